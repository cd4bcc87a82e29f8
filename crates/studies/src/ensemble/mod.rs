//! `cargo xtask reproduce-all --ensemble`: the claims of Chapters 4 and 7 on plants that meet the published numbers.
//!
//! The one plant of the other studies is one of these, their medoid, in still water, with equal sides and a state that is known: on it most
//! claims can neither hold nor fail. Here campaigns are run on all plants of `fixtures/bat/ensemble`, each in two worlds ([`row`]),
//! by the loops of the dissertation and by those who know less, with equal numbers of experiments ([`loops`]).
//!
//! A unit of work is a study on a plant in both worlds ([`mod@unit`]). What it finds are rows, one for each design that somebody chose, with
//! what that design truly shows in its flights ([`site`]), and facts about the plant ([`facts`]). They are appended to the tables of
//! `fixtures/bat/ensemble` when the unit is done ([`store`]); nothing else remembers anything, so that a run that is killed goes on.
//!
//! The same is done on the few plants that came of starts farther away, with tables of their own beside them ([`beyond`]); they count for no
//! word.
//!
//! All that is written on the page follows from these tables: claims are judged from them ([`judge`]), and `--check` says whether the
//! page is what they say.

mod beyond;
mod cameras;
mod claims;
mod curves;
mod decides;
mod evidence;
mod facts;
mod figures;
mod file;
mod findings;
mod judge;
mod kept;
mod loops;
mod page;
mod row;
mod sentences;
mod site;
mod store;
mod tables;
mod unit;

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::{Result, bail, ensure};

use crate::calibration::{CAMPAIGN_TABLES, Origin, Plant};
use crate::claims::{Place, Truth};
use crate::gridded::Designs;
use crate::memory::Memory;
use crate::reproduction::{Extent, progress};
use file::Setup;
use kept::{Ensembles, Kept};
use row::{DESIGNS, Study, Unit};
use store::{Found, Store};

/// Runs what is missing, and writes the page.
pub(crate) fn run(root: &Path) -> Result<()> {
    let mut both = open_both(root)?;
    let designs = Memory::of(root, Extent::Default).designs()?;
    run_missing(&mut both.near, &designs, "claims over the ensemble: studies of a plant")?;
    run_missing(&mut both.beyond, &designs, "the same on plants from farther away")?;
    page::write(root, &both)
}

fn run_missing(Kept { setup, store }: &mut Kept, designs: &Designs, words: &str) -> Result<()> {
    if store.drop_unfinished()? {
        eprintln!("{}: what an interrupted run had left of a unit was dropped", setup.origin.folder());
    }
    let works = works(setup);
    let bar = progress(words, works.len());
    for work in works {
        let unit = work.unit();
        if !store.has(&unit) {
            let (found, n_flights) = work.run(setup, store, designs)?;
            store.add(unit, found, n_flights)?;
        }
        bar.inc(1);
    }
    bar.finish();
    Ok(())
}

/// Runs the campaigns of the pooled loop anew, beside what is kept of the other methods, and what is missing; and writes the page.
pub(crate) fn run_pooled(root: &Path) -> Result<()> {
    let mut both = open_both(root)?;
    let designs = Memory::of(root, Extent::Default).designs()?;
    for Kept { setup, store } in [&mut both.near, &mut both.beyond] {
        store.drop_unfinished()?;
        let works = works(setup);
        let bar = progress(&format!("pooled loop anew: {}", setup.origin.folder()), works.len());
        for work in &works {
            let unit = work.unit();
            if let (Work::Study(study, plant), Some((kept, n_flights))) = (work, store.of(&unit)) {
                let found = unit::run_pooled(setup, *study, plant, &designs, &kept)?;
                if found.as_ref().is_none_or(|found| !found.agrees_with(&kept)) {
                    store.take_out(&unit)?;
                    found.map_or(Ok(()), |found| store.add(unit, found, n_flights))?;
                }
            }
            bar.inc(1);
        }
        bar.finish();
    }
    run(root)
}

/// One unit of work.
enum Work<'a> {
    Study(Study, &'a Plant),
    /// The designs of a plant seen by cameras.
    Cameras(&'a Plant),
    /// Figures 14, 21 and 26 on a plant.
    Curves(&'a Plant),
    /// Designs of experiments, which know no plant.
    Designs,
}

/// All of them, in the order in which they are done: studies of four parameters last, which take longest.
fn works(setup: &Setup) -> Vec<Work<'_>> {
    let of_four = setup.campaigns.plants_of_four.min(setup.plants.len());
    let plants = |study: Study| if study == Study::Four { &setup.plants[..of_four] } else { &setup.plants[..] };
    let studies = Study::OF_CAMPAIGNS
        .into_iter()
        .flat_map(|study| plants(study).iter().map(move |plant| Work::Study(study, plant)));
    let mut works: Vec<Work<'_>> = studies.collect();
    // They know no plant: once is enough.
    if setup.origin == Origin::Near {
        works.push(Work::Designs);
    }
    works.extend(plants(Study::Four).iter().map(Work::Cameras));
    works.extend(plants(Study::Four).iter().map(Work::Curves));
    works
}

impl Work<'_> {
    fn unit(&self) -> Unit {
        match self {
            Self::Study(study, plant) => (study.name().to_owned(), plant.number),
            Self::Cameras(plant) => ("cameras".to_owned(), plant.number),
            Self::Curves(plant) => ("curves".to_owned(), plant.number),
            Self::Designs => (DESIGNS.to_owned(), 0),
        }
    }

    fn run(&self, setup: &Setup, store: &Store, designs: &Designs) -> Result<(Found, usize)> {
        match self {
            Self::Study(study, plant) => unit::run(setup, *study, plant, designs),
            Self::Cameras(plant) => cameras::run(setup, &store.done, plant),
            Self::Curves(plant) => curves::run(setup, &store.done, plant, designs),
            Self::Designs => Ok((Found { facts: facts::designs(setup)?, ..Found::default() }, 0)),
        }
    }
}

fn open(root: &Path, setup: Setup) -> Result<Kept> {
    let store = Store::read(&root.join(setup.origin.folder()), &setup.key)?;
    Ok(Kept { setup, store })
}

/// What is kept of both, before anything is flown: campaigns take long, and what is kept of either has to fit.
fn open_both(root: &Path) -> Result<Ensembles> {
    let [near, beyond] = [Origin::Near, Origin::Beyond].map(|origin| Setup::read_of(root, origin));
    let (near, beyond) = (near?, beyond?);
    let tables = [&near, &beyond].map(|setup| (root.join(setup.origin.folder()), setup.key.as_str()));
    store::check_first_lines(&tables)?;
    Ok(Ensembles { near: open(root, near)?, beyond: open(root, beyond)? })
}

/// A unit for people.
fn words_of((work, plant): &Unit) -> String {
    if work == DESIGNS { "designs of experiments".to_owned() } else { format!("{work} of plant {plant}") }
}

/// That nothing is missing.
fn whole(Kept { setup, store }: Kept) -> Result<Kept> {
    let works = works(&setup);
    let missing: Vec<Unit> = works.iter().map(Work::unit).filter(|unit| !store.has(unit)).collect();
    if let Some(first) = missing.first().map(words_of) {
        let (n, all) = (missing.len(), works.len());
        bail!(
            "{}: {n} of {all} studies of a plant are missing, {first} first: run `cargo xtask reproduce-all --ensemble`",
            setup.origin.folder()
        );
    }
    Ok(Kept { setup, store })
}

fn open_both_whole(root: &Path) -> Result<Ensembles> {
    let Ensembles { near, beyond } = open_both(root)?;
    Ok(Ensembles { near: whole(near)?, beyond: whole(beyond)? })
}

/// What became of a claim over the ensemble, for the page over all chapters.
pub(crate) struct OverEnsemble {
    pub(crate) place: Place,
    /// The study that was flown for it, which need not be that of the chapter that has the same claim.
    pub(crate) flown: &'static str,
    pub(crate) says: String,
    pub(crate) truth: Truth,
    pub(crate) words: String,
}

/// All claims that were judged, and how many became what in each world, from what is kept.
pub(crate) fn over(root: &Path) -> Result<(Vec<OverEnsemble>, Vec<String>)> {
    let Kept { setup, store } = whole(open(root, Setup::read_of(root, Origin::Near)?)?)?;
    let all = page::judged(&setup, &kept::cases(&store.done), &kept::searches(&store.done));
    let counts = findings::counts(&all);
    let claims = all.into_iter().map(|both| OverEnsemble {
        words: both.words(),
        flown: both.claim.study.chapter(),
        place: both.claim.place,
        says: both.claim.says,
        truth: both.claim.truth,
    });
    Ok((claims.collect(), counts))
}

/// Writes the page from what is kept, and runs nothing.
pub(crate) fn write_page(root: &Path) -> Result<()> {
    page::write(root, &open_both_whole(root)?)
}

/// That the page follows from what is kept, and that a plant flies, and the pooled loop chooses on it, as when that was kept.
pub(crate) fn check(root: &Path) -> Result<()> {
    check_with(root, &open_both_whole(root)?)
}

fn check_with(root: &Path, both: &Ensembles) -> Result<()> {
    for Kept { setup, store } in [&both.near, &both.beyond] {
        cameras::fly_again(setup, &store.done)?;
        let first = store.done.iter().find(|done| done.unit.0 == Study::Chapter4.name());
        let plant = first.and_then(|done| setup.plants.iter().find(|plant| plant.number == done.unit.1));
        if let (Some(done), Some(plant)) = (first, plant) {
            unit::choose_again(setup, plant, &done.found.rows)?;
        }
    }
    let Kept { setup, store } = &both.near;
    setup.plants.first().map_or(Ok(()), |plant| curves::fly_again(setup, &store.done, plant))?;
    page::check(root, both)
}

/// The same, and that one unit of each kind, on the last plant of either that has it, comes out as it is kept.
pub(crate) fn check_all(root: &Path) -> Result<()> {
    let both = open_both_whole(root)?;
    check_with(root, &both)?;
    let designs = Memory::of(root, Extent::Default).designs()?;
    [&both.near, &both.beyond].into_iter().try_for_each(|kept| run_one_of_each_kind(kept, &designs))
}

fn run_one_of_each_kind(Kept { setup, store }: &Kept, designs: &Designs) -> Result<()> {
    let folder = setup.origin.folder();
    let of_each_kind: BTreeMap<String, Work<'_>> = works(setup).into_iter().map(|work| (work.unit().0, work)).collect();
    for work in of_each_kind.values() {
        let (found, _) = work.run(setup, store, designs)?;
        let words = words_of(&work.unit());
        let kept = store.done.iter().find(|done| done.unit == work.unit());
        ensure!(
            kept.is_some_and(|kept| kept.found.agrees_with(&found)),
            "{folder}: {words} is no longer what is kept: to run all campaigns anew remove all of {} from {} and {}",
            CAMPAIGN_TABLES.join(", "),
            Origin::Near.folder(),
            Origin::Beyond.folder()
        );
        let (rows, facts) = (found.rows.len(), found.facts.len());
        eprintln!("{folder}, {words}: {rows} designs and {facts} facts as kept");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seal::Copies;

    const FILES: [&str; 17] = [
        "calibration.toml",
        "rig.toml",
        "cost-chapter4.toml",
        "cost-chapter7.toml",
        "ensemble.toml",
        "test-profile.toml",
        "test-profile-open-loop.toml",
        "chapter3.toml",
        "chapter4.toml",
        "chapter6.toml",
        "chapter7.toml",
        "moving-water.toml",
        "sensing.toml",
        "ensemble/members.csv",
        "ensemble/starts.csv",
        "ensemble/beyond/members.csv",
        "ensemble/beyond/starts.csv",
    ];

    /// Campaigns of an hour would end with an error that could be known at their beginning.
    #[test]
    fn what_is_kept_of_another_study_is_refused_before_a_campaign_is_run() {
        let copies = Copies::of(&FILES);
        let [near, beyond] = [Origin::Near, Origin::Beyond].map(|origin| copies.root().join(origin.folder()));
        let others = [near.join("facts.csv"), beyond.join("designs.csv")];
        for path in &others {
            std::fs::write(path, "# other\n").expect("written");
        }
        let error = format!("{:#}", run(copies.root()).expect_err("tables of another study"));
        assert!(others.iter().all(|path| error.contains(&path.display().to_string())), "{error}");
        assert!(!near.join("times.csv").exists(), "nothing was run");
    }

    /// Designs of experiments know no plant, and are not searched for again.
    #[test]
    fn plants_from_farther_away_have_all_studies_but_that_without_plants() -> Result<()> {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let kinds = |origin: Origin| -> Result<Vec<String>> {
            let setup = Setup::read_of(&root, origin)?;
            let of_last = |work: &Work<'_>| setup.plants.last().is_some_and(|plant| work.unit().1 == plant.number);
            let kinds =
                works(&setup).into_iter().filter(|work| of_last(work) || work.unit().1 == 0).map(|work| work.unit().0);
            let mut kinds: Vec<String> = kinds.collect();
            kinds.sort_unstable();
            kinds.dedup();
            Ok(kinds)
        };
        let (mut near, beyond) = (kinds(Origin::Near)?, kinds(Origin::Beyond)?);
        near.retain(|kind| kind != DESIGNS);
        assert_eq!((near.len(), &near), (5, &beyond));
        assert!(open_both_whole(&root).is_ok(), "both are kept whole");
        Ok(())
    }
}
