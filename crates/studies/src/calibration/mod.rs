//! `cargo xtask calibrate`: plants that meet what the dissertation prints, fitted from starts about one plant.

mod attempt;
mod candidate;
mod default_plant;
mod evidence;
mod file;
mod fit;
mod free;
mod landscape;
mod medoid;
mod outcome;
mod page;
mod seen;
mod shortfall;
mod store;

use std::path::Path;

use anyhow::{Context as _, Result, ensure};
use rayon::prelude::*;

use crate::reproduction::progress;
use attempt::Attempt;
pub(crate) use candidate::Candidate;
use candidate::{Flown, fly};
use default_plant::DefaultPlant;
use evidence::{Aims, Found};
use file::Calibration;
#[cfg(feature = "identification")]
pub(crate) use free::{Free, FreeEntry};
pub(crate) use seen::Look;
use shortfall::shortfall;
#[cfg(feature = "ensemble")]
pub(crate) use store::CAMPAIGN_TABLES;
use store::{AT_ONCE, BEYOND, ENSEMBLE, Store};

/// The file, and what is kept of it: from its own ranges, and each plant within them.
fn read(root: &Path) -> Result<(Calibration, Store)> {
    let calibration = Calibration::read(root)?;
    let store = Store::read(&root.join(ENSEMBLE), calibration.shape(root)?)?;
    Ok((calibration, store))
}

/// What came of starts from farther away.
fn read_beyond(root: &Path, calibration: &Calibration) -> Result<Store> {
    Store::read(&root.join(BEYOND), calibration.shape_beyond(&calibration.shape(root)?))
}

/// Both, before anything is flown: a search takes long, and what is kept of either has to fit.
fn read_both(root: &Path) -> Result<(Calibration, [Store; 2])> {
    let (calibration, near) = read(root)?;
    let beyond = read_beyond(root, &calibration)?;
    Ok((calibration, [near, beyond]))
}

/// The same, with each plant flown to see that it meets its evidence.
fn flown(root: &Path) -> Result<(Calibration, [Store; 2])> {
    let (calibration, stores) = read_both(root)?;
    for store in &stores {
        let candidates = calibration.candidates(&store.members)?;
        meet(&calibration, &candidates, |index| format!("{}, ", store.place(index)), &store.remedy())?;
    }
    Ok((calibration, stores))
}

/// That candidates fly and meet the evidence; one that does not is named, with what is to be done.
fn meet(
    calibration: &Calibration,
    candidates: &[Candidate],
    name: impl Fn(usize) -> String,
    remedy: &str,
) -> Result<()> {
    let aims = Aims::new(&calibration.evidence, calibration.tolerance);
    let all = fly(candidates, &aims.spots(), &calibration.profile, &calibration.settings);
    for (index, (candidate, flown)) in candidates.iter().zip(all).enumerate() {
        let flown: Option<Vec<Flown>> = flown.into_iter().collect();
        let flown = flown.with_context(|| format!("{}a plant that no longer flies; {remedy}", name(index)))?;
        for row in aims.rows(candidate, &flown) {
            let Found { label, what, printed, found, allowed } = &row;
            ensure!(
                row.tolerances() <= 1.0,
                "{}{label}: {what}: {found:.4} where {printed} is published, {allowed:.4} apart at most; {remedy}",
                name(index)
            );
        }
    }
    Ok(())
}

/// That there are as many plants as the file asks for.
fn enough(calibration: &Calibration, store: &Store) -> Result<()> {
    let (n, wanted) = (store.members.len(), calibration.n_members);
    ensure!(n >= wanted, "{ENSEMBLE} has {n} plants of {wanted}: run `cargo xtask calibrate`");
    Ok(())
}

/// Tries starts until there are enough plants, and writes the page.
///
/// Where there are not enough in the end the error says what was missed and by how much.
pub(crate) fn run(root: &Path) -> Result<()> {
    let (calibration, [mut store, mut beyond]) = flown(root)?;
    eprintln!("{}: {} of {} kept so far", calibration.title, store.members.len(), calibration.n_members);
    let bar = progress("plants kept", calibration.n_members);
    bar.inc(store.members.len() as u64);
    while store.members.len() < calibration.n_members && store.next() < calibration.most_starts {
        let before = store.members.len();
        try_some(&calibration, &mut store, calibration.reach, calibration.most_starts)?;
        bar.inc((store.members.len() - before) as u64);
    }
    bar.finish();
    if store.members.len() < calibration.n_members {
        return Err(shortfall(&calibration, &store)?);
    }
    let (reach, n_starts) = calibration.beyond;
    let bar = progress("starts from farther away", usize::try_from(n_starts)?);
    bar.inc(beyond.next());
    while beyond.next() < n_starts {
        let before = beyond.next();
        try_some(&calibration, &mut beyond, reach, n_starts)?;
        bar.inc(beyond.next() - before);
    }
    bar.finish();
    page::write(root, &calibration, &store, &beyond)
}

/// Tries the next starts, a few at once and no more than `most` in all, and keeps what came of them.
fn try_some(calibration: &Calibration, store: &mut Store, reach: [f64; 2], most: u64) -> Result<()> {
    let next = store.next();
    let some: Vec<u64> = (next..most.min(next + AT_ONCE)).collect();
    let found = some.par_iter().map(|number| calibration.try_start(*number, reach)).collect::<Result<Vec<_>>>()?;
    store.add(found.into_iter().map(|Attempt { start, member, .. }| (start, member)).collect())
}

/// That all starts from farther away were tried.
fn all_tried(calibration: &Calibration, beyond: &Store) -> Result<()> {
    let (n, wanted) = (beyond.next(), calibration.beyond.1);
    ensure!(n >= wanted, "{BEYOND} has {n} starts of {wanted}: run `cargo xtask calibrate`");
    Ok(())
}

/// Both with each plant flown, and nothing missing.
fn flown_and_whole(root: &Path) -> Result<(Calibration, [Store; 2])> {
    let (calibration, stores) = flown(root)?;
    enough(&calibration, &stores[0])?;
    all_tried(&calibration, &stores[1])?;
    Ok((calibration, stores))
}

/// Writes the page of the plants that are kept.
pub(crate) fn write_page(root: &Path) -> Result<()> {
    let (calibration, [store, beyond]) = flown_and_whole(root)?;
    page::write(root, &calibration, &store, &beyond)
}

/// Writes the plant that is nearest to all others into the files of the default plant.
pub(crate) fn write_default(root: &Path) -> Result<()> {
    let (calibration, [store, _]) = flown(root)?;
    enough(&calibration, &store)?;
    DefaultPlant::of(&calibration, &store.members)?.write(&calibration)
}

/// A plant of the ensemble.
#[cfg(feature = "ensemble")]
#[derive(Debug, Clone)]
pub(crate) struct Plant {
    /// Of the start that it came of.
    pub(crate) number: u64,
    pub(crate) rig: water_channel::Rig,
    /// Of Chapter 4 and of Chapter 7.
    pub(crate) weights: [water_channel::CostWeights; 2],
    /// Its numbers that were free, in their order.
    pub(crate) values: Vec<f64>,
}

/// All keys of numbers that differ between plants, with those that take the same value.
#[cfg(feature = "ensemble")]
pub(crate) fn free_keys(root: &Path) -> Result<Vec<String>> {
    let calibration = Calibration::read(root)?;
    Ok(calibration.free.iter().flat_map(|free| free.keys().map(str::to_owned)).collect())
}

/// From where plants were found.
#[cfg(feature = "ensemble")]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Origin {
    /// From starts about one plant: the ensemble.
    Near,
    /// From starts farther away, tried beside them.
    Beyond,
}

#[cfg(feature = "ensemble")]
impl Origin {
    /// Where they are kept.
    pub(crate) const fn folder(self) -> &'static str {
        match self {
            Self::Near => ENSEMBLE,
            Self::Beyond => BEYOND,
        }
    }
}

/// The plants that are kept, in their order, after the names of the numbers that were free.
#[cfg(feature = "ensemble")]
pub(crate) fn plants(root: &Path, origin: Origin) -> Result<(Vec<String>, Vec<Plant>)> {
    let (calibration, near) = read(root)?;
    let store = match origin {
        Origin::Near => near,
        Origin::Beyond => {
            let beyond = read_beyond(root, &calibration)?;
            all_tried(&calibration, &beyond)?;
            beyond
        }
    };
    let plants = store.members.iter().map(|member| {
        let candidate = calibration.with(&member.values)?;
        let values = member.values.clone();
        Ok(Plant { number: member.start, rig: candidate.rig, weights: candidate.weights, values })
    });
    Ok((calibration.keys(), plants.collect::<Result<_>>()?))
}

/// That each plant that is kept, those from farther away among them, still flies and meets its evidence, that there are enough, and that the default plant is one of them:
/// the one nearest to all others.
pub(crate) fn check(root: &Path, look: Look) -> Result<()> {
    let (calibration, [store, beyond]) = flown_and_whole(root)?;
    DefaultPlant::of(&calibration, &store.members)?.check(&calibration)?;
    // Its numbers are rounded.
    let default_plant = std::slice::from_ref(&calibration.base);
    meet(&calibration, default_plant, |_| "the default plant: ".to_owned(), "run `cargo xtask calibrate --default`")?;
    let [n, n_beyond] = [&store, &beyond].map(|store| store.members.len());
    eprintln!("{n} plants, {n_beyond} from farther away and the default plant fly and meet their evidence");
    page::check(root, &calibration, [&store, &beyond], look)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seal::{self, Copies, Form};

    const FILES: [&str; 5] =
        ["calibration.toml", "rig.toml", "test-profile.toml", "cost-chapter4.toml", "cost-chapter7.toml"];

    /// A search of minutes would end with an error that could be known at its beginning.
    #[test]
    fn what_is_kept_of_other_files_is_refused_before_a_start_is_tried() {
        let copies = Copies::of(&FILES);
        let beyond = copies.root().join(BEYOND);
        std::fs::create_dir_all(&beyond).expect("a folder");
        let others = seal::sealed(Form::Comment, "other", "start,outcome,worst_residual\n");
        std::fs::write(beyond.join("starts.csv"), others).expect("written");
        let error = format!("{:#}", run(copies.root()).expect_err("starts of another file"));
        let remedy =
            format!("remove all of starts.csv, members.csv, designs.csv, facts.csv, times.csv from {BEYOND}, ");
        assert!(error.contains("`other`") && error.contains(&remedy), "{error}");
        assert!(!copies.root().join(ENSEMBLE).join("starts.csv").exists(), "no start was tried");
    }

    /// Plants from farther away are held to their evidence as the others are.
    #[test]
    fn a_plant_from_farther_away_that_misses_its_evidence_is_named() {
        let beyond = ["starts.csv", "members.csv"].map(|name| format!("ensemble/beyond/{name}"));
        let copies = Copies::of(&[&FILES[..], &beyond.each_ref().map(String::as_str)].concat());
        let (calibration, [near, store]) = flown(copies.root()).expect("plants that meet their evidence");
        assert_eq!((near.members.len(), store.members.len()), (0, 4));
        let mut member = store.members[0].clone();
        member.values[0] = calibration.free[0].lower;
        let candidates = calibration.candidates(&[member]).expect("a plant");
        let error =
            meet(&calibration, &candidates, |index| store.place(index), &store.remedy()).expect_err("it misses");
        let error = format!("{error:#}");
        assert!(error.contains("beyond/members.csv: line 3 (start ") && error.contains("to calibrate anew"), "{error}");
    }
}
