//! `cargo xtask reproduce-chapter6`: the surrogate study of Section 6.2, Figures 20 to 22.

mod claims;
mod file;
mod pictures;
mod report;
mod tables;

use std::path::Path;
use std::time::Instant;

use anyhow::{Context as _, Result};
use infuse::global;
use rayon::prelude::*;

use file::{Case, Setup};

use crate::bat::MODEL;
use crate::gridded::{Accuracy, Designs, FlownGrid, SurrogateRig};
use crate::handover::Handover;
use crate::reproduction::{self, DESIGNS, Extent, FLIGHTS, Reproduction, Run, progress};

/// The study, and the committed copy of its results.
pub(crate) const CHAPTER: Reproduction =
    Reproduction { command: "reproduce-chapter6", name: "chapter6", run: Run::OrFull(reproduce) };

/// The noise that pictures show, as a part of the range: the nearest of the file.
const SHOWN_NOISE: f64 = 0.03;

/// A space with its cost at every cell.
#[derive(Debug)]
pub(crate) struct Flown {
    model: FlownGrid,
    truths: Vec<FlownGrid>,
}

/// A campaign that has ended, beside the truth.
#[derive(Debug)]
pub(crate) struct Ended {
    case: Case,
    campaign: global::Loop,
    accuracy: Accuracy,
}

/// Everything that a run found.
#[derive(Debug)]
pub(crate) struct Findings {
    setup: Setup,
    extent: Extent,
    flown: Vec<Flown>,
    ended: Vec<Ended>,
    footprints: Vec<tables::BeforeAfter>,
    seconds: f64,
}

fn reproduce(root: &Path, extent: Extent) -> Result<()> {
    let started = Instant::now();
    let setup = Setup::read(&root.join("fixtures/bat/chapter6.toml"), extent)?;
    let out = CHAPTER.prepare(root, extent)?;
    for space in &setup.spaces {
        space.bat.keep_in(&root.join(FLIGHTS), space.space.region(), &setup.fidelities())?;
    }
    let designs = Designs::keep_in(&root.join(DESIGNS))?;
    eprintln!("{}: the experiments are flights of a surrogate model with noise.", setup.file.title);

    let n_flights: usize = setup.spaces.iter().map(|space| space.space.n_cells() * (1 + setup.n_truths())).sum();
    if extent == Extent::Full {
        eprintln!("--full: {}", estimate(&setup)?);
    }
    let bar = progress("1/3 true costs: flights of model and surrogates", n_flights);
    let flown = fly(&setup, |n| bar.inc(n as u64))?;
    bar.finish();

    let cases = setup.cases();
    let bar = progress("2/3 campaigns: iterations", cases.len() * setup.file.iterations.iterations);
    let study = Campaigns { setup: &setup, flown: &flown, designs: &designs };
    let ended = study.run(&cases, |n| bar.inc(n as u64))?;
    bar.finish();

    let bar = progress("3/3 designs of the figures, pictures", 2);
    let mut findings = Findings { setup, extent, flown, ended, footprints: Vec::new(), seconds: 0.0 };
    findings.footprints = tables::before_after(&findings)?;
    bar.inc(1);
    let pictures = pictures::all(&findings)?;
    bar.inc(1);
    bar.finish();

    findings.seconds = started.elapsed().as_secs_f64();
    let claims = claims::claims(&findings);
    let page = report::page(&findings, &claims, &pictures)?;
    reproduction::save_page(&out, &pictures, &page, &report::markdown(&findings, &claims)?)?;
    tables::iterations(&findings).write_csv(&out.join("iterations.csv"))?;
    tables::campaigns(&findings).write_csv(&out.join("campaigns.csv"))?;
    let handover = Handover::new(claims, &pictures);
    handover.save(&out)?;
    report::print(&findings, &handover.claims, &CHAPTER.out_of(extent))
}

/// How long the flights will take, by the pace of a few.
fn estimate(setup: &Setup) -> Result<String> {
    const TIMED: usize = 64;
    let (mut missing, mut seconds) = (0, 0.0);
    for space in &setup.spaces {
        let points = space.space.points()?;
        for fidelity in setup.fidelities() {
            missing += space.bat.n_missing(&points, fidelity);
        }
        let cells = (0..TIMED).map(|k| space.space.point(k * (space.space.n_cells() - 1) / TIMED));
        let started = Instant::now();
        space.bat.flown_costs(&cells.collect::<Result<Vec<_>>>()?, MODEL, |_| {});
        seconds = started.elapsed().as_secs_f64() / TIMED as f64;
    }
    Ok(format!(
        "{missing} flights of 300 s are missing, about {:.0} minutes at the present pace of this machine; then the campaigns. What was \
         flown is remembered, and an interrupted run goes on where it was.",
        (missing as f64 * seconds / 60.0).ceil()
    ))
}

fn fly(setup: &Setup, done: impl Fn(usize) + Sync) -> Result<Vec<Flown>> {
    let each = setup.spaces.iter().map(|space| {
        let fly = |fidelity| FlownGrid::fly(&space.bat, &space.space, fidelity, &done);
        let truths = (0..setup.n_truths()).map(|truth| fly(setup.truth(truth).fidelity()));
        Ok(Flown { model: fly(MODEL)?, truths: truths.collect::<Result<_>>()? })
    });
    each.collect()
}

/// What the campaigns of the study are made from.
struct Campaigns<'a> {
    setup: &'a Setup,
    flown: &'a [Flown],
    designs: &'a Designs,
}

impl Campaigns<'_> {
    /// Runs them side by side, in their order.
    fn run(&self, cases: &[Case], iterated: impl Fn(usize) + Sync) -> Result<Vec<Ended>> {
        for case in cases {
            self.rig(*case).prepare(&self.setup.settings(*case)?, self.designs)?;
        }
        cases.par_iter().map(|case| self.run_one(*case, &iterated).with_context(|| self.setup.words(*case))).collect()
    }

    fn rig(&self, case: Case) -> SurrogateRig<'_> {
        let (space, flown) = (&self.setup.spaces[case.space].space, &self.flown[case.space]);
        let (model, truth) = (&flown.model, &flown.truths[case.truth]);
        SurrogateRig { space, model, truth, noise: case.noise, seed: self.setup.file.noise.seed }
    }

    fn run_one(&self, case: Case, iterated: impl Fn(usize)) -> Result<Ended> {
        let campaign = self.rig(case).run(&self.setup.settings(case)?, self.designs, iterated)?;
        let flown = &self.flown[case.space];
        let space = &self.setup.spaces[case.space].space;
        let accuracy = Accuracy::of(&campaign, space, &flown.model, &flown.truths[case.truth])?;
        Ok(Ended { case, campaign, accuracy })
    }
}

impl Findings {
    /// The campaigns of the first variant in a space, noise by noise.
    fn main(&self, space: usize, truth: usize) -> Vec<&Ended> {
        let wanted = |case: Case| case.space == space && case.truth == truth && case.variant == 0;
        self.ended.iter().filter(|ended| wanted(ended.case)).collect()
    }

    /// The one of them that pictures show.
    fn shown(&self, space: usize, truth: usize) -> Result<&Ended> {
        let distance = |ended: &&Ended| (ended.case.noise - SHOWN_NOISE).abs();
        let main = self.main(space, truth).into_iter();
        main.min_by(|a, b| distance(a).total_cmp(&distance(b))).context("no campaign of the first variant")
    }

    /// Every space with every truth.
    fn fields(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        (0..self.setup.spaces.len()).flat_map(|space| (0..self.setup.n_truths()).map(move |truth| (space, truth)))
    }

    /// A space and a truth in words.
    fn field_words(&self, space: usize, truth: usize) -> String {
        format!("{}, {}", self.setup.spaces[space].entry.label, self.setup.truth(truth).short())
    }

    /// A point with its units.
    fn point_words(&self, space: usize, point: &[f64]) -> String {
        let parameters = self.setup.spaces[space].space.region().parameters();
        let words = parameters.iter().zip(point).map(|(parameter, x)| match parameter.name() {
            "center_of_mass" => format!("{x:.2} % chord"),
            "pitch_set_point" => format!("{x:.2} deg"),
            "horizontal_area" => format!("A^H {x:.2}"),
            _ => format!("A^V {x:.2}"),
        });
        words.collect::<Vec<_>>().join(", ")
    }
}
