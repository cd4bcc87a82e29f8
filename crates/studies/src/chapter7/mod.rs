//! `cargo xtask reproduce-chapter7`: Tables 5 and 6 and Figures 23, 24, 26 to 28, the loop of Chapter 5 over two and over
//! four parameters; and what the wrong choices cost.

mod campaigns;
mod claims;
mod file;
mod flights;
mod leak;
mod optima;
mod pictures;
mod report;
mod tables;
mod wrong;

use std::path::Path;
use std::time::Instant;

use anyhow::{Context as _, Result};
use infuse::global;
use rayon::prelude::*;

use campaigns::{Runs, Step};
use file::{Case, Setup};
use flights::{BeforeAfter, Flown};
use optima::Optimum;
use wrong::Choice;

use crate::gridded::{Campaigns, CellCosts, FlightStore, FlownGrid, OnDemand, Space, SurrogateRig};
use crate::handover::Handover;
use crate::reproduction::{self, Extent, Reproduction, Run, progress};
use crate::study::{MODEL, STAND_IN};

/// The study, and the committed copy of its results.
pub(crate) const CHAPTER: Reproduction =
    Reproduction { command: "reproduce-chapter7", name: "chapter7", run: Run::Always(reproduce) };

/// The grid that is flown in whole.
#[derive(Debug)]
struct Ground {
    model: FlownGrid,
    truth: FlownGrid,
}

/// Everything that was found in one of the two studies.
#[derive(Debug)]
struct Found {
    ground: Ground,
    /// The optimum of the numerical model: row 0.
    numerical: Optimum,
    /// What the numerical optimum truly costs.
    numerical_true_cost: f64,
    /// The best design of the stand-in, which no engineer could compute.
    best: Optimum,
    /// In the order of the file's variants.
    runs: Vec<Runs>,
    choices: Vec<Choice>,
    flights: BeforeAfter,
}

impl Found {
    /// The runs of the first variant.
    fn main(&self) -> &Runs {
        &self.runs[0]
    }
}

/// Everything that a run found.
#[derive(Debug)]
struct Findings {
    setup: Setup,
    /// In the order of the cases.
    found: Vec<Found>,
    seconds: f64,
}

impl Findings {
    /// The largest error of an experiment in a study, in s.
    fn noise_s(&self, found: &Found) -> f64 {
        self.setup.file.noise.share * found.ground.truth.range()
    }

    fn cases(&self) -> impl Iterator<Item = (&Case, &Found)> {
        self.setup.cases.iter().zip(&self.found)
    }
}

fn reproduce(root: &Path) -> Result<()> {
    let started = Instant::now();
    let setup = Setup::read(&root.join("fixtures/bat/chapter7.toml"))?;
    let out = CHAPTER.prepare(root, Extent::Default)?;
    let store = FlightStore::new(root.join("target/reproduction/flights"));
    let campaigns = Campaigns::new(root.join("target/reproduction/campaigns"));
    eprintln!("{}: the stand-in for the water channel is a surrogate model, not an experiment.", setup.file.title);

    let bar = progress("1/5 flights of model and stand-in over whole grids", setup.cases.iter().map(n_flights).sum());
    let grounds = setup.cases.iter().map(|case| {
        let fly = |fidelity| store.fly(&case.study, &case.flown, fidelity, |n| bar.inc(n as u64));
        Ok(Ground { model: fly(MODEL)?, truth: fly(STAND_IN)? })
    });
    let grounds = grounds.collect::<Result<Vec<_>>>()?;
    bar.finish();

    let bar = progress("2/5 optima of model and stand-in themselves", setup.cases.len());
    let optima = setup.cases.iter().zip(&grounds).map(|(case, ground)| {
        let (model, truth) =
            rayon::join(|| Optimum::of(case, &ground.model, MODEL), || Optimum::of(case, &ground.truth, STAND_IN));
        bar.inc(1);
        Ok((model?, truth?))
    });
    let optima = optima.collect::<Result<Vec<_>>>()?;
    bar.finish();

    let bar = progress("3/5 campaigns: iterations", setup.cases.iter().map(|case| n_iterations(&setup, case)).sum());
    let runs = setup
        .cases
        .iter()
        .zip(&grounds)
        .map(|(case, ground)| run(&setup, case, ground, &store, &campaigns, |n| bar.inc(n as u64)));
    let runs = runs.collect::<Result<Vec<_>>>()?;
    bar.finish();

    let seeds = setup.file.noise.numbers(setup.file.noise.seeds);
    let bar = progress("4/5 wrong choices: campaigns", setup.cases.len() * wrong::N_CHOICES * seeds.len());
    let choices = setup.cases.iter().zip(&grounds).map(|(case, ground)| {
        let rig = rig(&setup, &case.flown, &ground.model, &ground.truth);
        let base = setup.settings(case, &setup.file.variant[0])?;
        wrong::choices(&rig, [&ground.model, &ground.truth], &base, &seeds, &campaigns, || bar.inc(1))
            .with_context(|| case.entry.label.clone())
    });
    let choices = choices.collect::<Result<Vec<_>>>()?;
    bar.finish();

    let bar = progress("5/5 designs of the figures, pictures", setup.cases.len() + 1);
    let mut found = Vec::new();
    for ((((case, ground), (numerical, best)), runs), choices) in
        setup.cases.iter().zip(grounds).zip(optima).zip(runs).zip(choices)
    {
        let flights = fly_before_after(case, &numerical, &runs[0])?;
        let numerical_true_cost = case.study.cost(&numerical.point, STAND_IN).unwrap_or(f64::NAN);
        let best = best_known(best, &runs);
        found.push(Found { ground, numerical, numerical_true_cost, best, runs, choices, flights });
        bar.inc(1);
    }
    let mut findings = Findings { setup, found, seconds: 0.0 };
    let pictures = pictures::all(&findings)?;
    bar.inc(1);
    bar.finish();

    findings.seconds = started.elapsed().as_secs_f64();
    let claims = claims::all(&findings);
    let page = report::page(&findings, &claims, &pictures);
    reproduction::save_page(&out, &pictures, &page, &report::markdown(&findings, &claims))?;
    tables::every_step(&findings).write_csv(&out.join("iterations.csv"))?;
    tables::every_choice(&findings).write_csv(&out.join("choices.csv"))?;
    report::print(&findings, &claims, &CHAPTER.out());
    Handover::new(claims, &pictures).with_excerpts(report::excerpts(&findings)).save(&out)?;
    Ok(())
}

fn n_flights(case: &Case) -> usize {
    2 * case.flown.n_cells()
}

fn n_iterations(setup: &Setup, case: &Case) -> usize {
    setup.file.variant.iter().map(|variant| case.entry.iterations * (1 + variant.seeds as usize)).sum()
}

fn rig<'a>(setup: &Setup, space: &'a Space, model: &'a dyn CellCosts, truth: &'a dyn CellCosts) -> SurrogateRig<'a> {
    SurrogateRig { space, model, truth, noise: setup.file.noise.share, seed: setup.file.noise.first_seed }
}

/// The campaigns of every variant: on the grid that is flown, or with flights on demand where it has too many cells.
fn run(
    setup: &Setup,
    case: &Case,
    ground: &Ground,
    store: &FlightStore,
    campaigns: &Campaigns,
    iterated: impl Fn(usize) + Sync,
) -> Result<Vec<Runs>> {
    let runs = |rig: &SurrogateRig<'_>| {
        let each = setup.file.variant.iter().map(|variant| {
            let seeds = setup.file.noise.numbers(variant.seeds);
            Runs::of(&variant.label, rig, &setup.settings(case, variant)?, &seeds, campaigns, &iterated)
                .with_context(|| format!("{}, {}", case.entry.label, variant.label))
        });
        each.collect()
    };
    if case.is_flown_whole() {
        return runs(&rig(setup, &case.space, &ground.model, &ground.truth));
    }
    let demand = |fidelity, grid: &FlownGrid| -> Result<OnDemand<'_>> {
        store.on_demand(&case.study, &case.space, fidelity, grid.range())
    };
    let (model, truth) = (demand(MODEL, &ground.model)?, demand(STAND_IN, &ground.truth)?);
    runs(&rig(setup, &case.space, &model, &truth))
}

/// The best design of the stand-in: that of the search, unless a campaign came upon a better one.
fn best_known(searched: Optimum, runs: &[Runs]) -> Optimum {
    let steps = runs.iter().flat_map(|runs| std::iter::once(&runs.quiet).chain(&runs.noisy)).flat_map(|steps| &steps.0);
    let met = steps.min_by(|a, b| a.cost.total_cmp(&b.cost));
    match met {
        Some(Step { point, cost, .. }) if *cost < searched.cost => Optimum { point: point.clone(), cost: *cost },
        _ => searched,
    }
}

fn fly_before_after(case: &Case, numerical: &Optimum, runs: &Runs) -> Result<BeforeAfter> {
    let after_seeds = runs.noisy.par_iter().map(|steps| Ok(Flown::fly(case, &steps.last()?.point)?.means()));
    Ok(BeforeAfter {
        before: Flown::fly(case, &numerical.point).context("the numerical optimum")?,
        after: Flown::fly(case, &runs.quiet.last()?.point).context("the infused optimum")?,
        after_seeds: after_seeds.collect::<Result<_>>()?,
    })
}

/// What is left of the space after an iteration from 1, and before it.
fn shares(campaign: &global::Loop, iteration: usize) -> Option<f64> {
    Some(100.0 * campaign.retained_at(iteration)?.share())
}
