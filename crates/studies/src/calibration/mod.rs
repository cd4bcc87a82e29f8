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
mod store;

use std::path::Path;

use anyhow::{Context as _, Result, ensure};
use rayon::prelude::*;

use crate::reproduction::progress;
#[cfg(feature = "identification")]
pub(crate) use candidate::Candidate;
#[cfg(any(feature = "identification", feature = "ensemble"))]
pub(crate) use landscape::{correlation, ranks};

use candidate::{Flown, fly};
use default_plant::DefaultPlant;
use evidence::Aims;
use file::Calibration;
use fit::worst;
#[cfg(feature = "identification")]
pub(crate) use free::{Free, FreeEntry};
use store::Store;

const ENSEMBLE: &str = "fixtures/bat/ensemble";
/// Starts at once, so that a killed run loses no more than these.
const AT_ONCE: u64 = 2;

/// Tries starts until there are enough plants, and writes the page.
pub(crate) fn run(root: &Path) -> Result<()> {
    let calibration = Calibration::read(root)?;
    let mut store = Store::read(&root.join(ENSEMBLE), calibration.keys())?;
    eprintln!("{}: {} of {} kept so far", calibration.title, store.members.len(), calibration.n_members);
    let bar = progress("plants kept", calibration.n_members);
    bar.inc(store.members.len() as u64);
    let mut next = store.starts.last().map_or(0, |start| start.number + 1);
    while store.members.len() < calibration.n_members && next < calibration.most_starts {
        let some: Vec<u64> = (next..calibration.most_starts.min(next + AT_ONCE)).collect();
        next += some.len() as u64;
        let found = some.par_iter().map(|number| calibration.try_start(*number)).collect::<Result<Vec<_>>>()?;
        let before = store.members.len();
        store.add(found)?;
        bar.inc((store.members.len() - before) as u64);
    }
    bar.finish();
    page::write(root, &calibration, &store)
}

/// Writes the page of the plants that are kept.
pub(crate) fn write_page(root: &Path) -> Result<()> {
    let calibration = Calibration::read(root)?;
    let store = Store::read(&root.join(ENSEMBLE), calibration.keys())?;
    page::write(root, &calibration, &store)
}

/// Writes the plant that is nearest to all others into the files of the default plant.
pub(crate) fn write_default(root: &Path) -> Result<()> {
    let calibration = Calibration::read(root)?;
    let store = Store::read(&root.join(ENSEMBLE), calibration.keys())?;
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

/// The plants that are kept, in their order, after the names of the numbers that were free.
#[cfg(feature = "ensemble")]
pub(crate) fn plants(root: &Path) -> Result<(Vec<String>, Vec<Plant>)> {
    let calibration = Calibration::read(root)?;
    let store = Store::read(&root.join(ENSEMBLE), calibration.keys())?;
    let plants = store.members.iter().map(|member| {
        let candidate = calibration.with(&member.values)?;
        let values = member.values.clone();
        Ok(Plant { number: member.start, rig: candidate.rig, weights: candidate.weights, values })
    });
    Ok((calibration.keys(), plants.collect::<Result<_>>()?))
}

/// That each plant that is kept still flies and meets its evidence, that there are enough, and that the default plant is one of them:
/// the one nearest to all others.
pub(crate) fn check(root: &Path) -> Result<()> {
    let calibration = Calibration::read(root)?;
    let store = Store::read(&root.join(ENSEMBLE), calibration.keys())?;
    ensure!(
        store.members.len() >= calibration.n_members,
        "{ENSEMBLE} has {} plants of {}: run `cargo xtask calibrate`",
        store.members.len(),
        calibration.n_members
    );
    DefaultPlant::of(&calibration, &store.members)?.check(&calibration)?;
    let aims = Aims::new(&calibration.evidence, calibration.tolerance);
    let mut candidates = calibration.candidates(&store.members)?;
    // Its numbers are rounded.
    candidates.push(calibration.base.clone());
    let names = store.members.iter().map(|member| format!("plant {} of {ENSEMBLE}", member.start));
    let names = names.chain(std::iter::once("the default plant".to_owned()));
    let all = fly(&candidates, &aims.spots(), &calibration.profile, &calibration.settings);
    for ((name, candidate), flown) in names.zip(&candidates).zip(all) {
        let flown: Option<Vec<Flown>> = flown.into_iter().collect();
        let flown = flown.with_context(|| format!("{name} no longer flies"))?;
        let worst = worst(&aims.residuals(candidate, &flown));
        ensure!(worst <= 1.0, "{name} misses its evidence by {worst:.2} tolerances");
    }
    eprintln!("{} plants and the default plant fly and meet their evidence", store.members.len());
    page::check(root, &calibration, &store)
}
