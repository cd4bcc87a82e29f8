//! The order of things in Chapter 7.

use super::campaigns::{Runs, Step};
use super::file::{Case, Setup, Variant};
use super::findings::{Findings, Found};
use super::flights::{BeforeAfter, Flown};
use super::optima::Optimum;
use super::pooled::Pooled;
use super::wrong::Choice;
use super::{claims, figures, kept, page, tables, wrong};
use crate::bat::{MODEL, STAND_IN};
use crate::blind::Blind;
use crate::gridded::{CellCosts, Designs, FlownGrid, OnDemand, Space, StandInRig};
use crate::handover::Handover;
use crate::memory::Memory;
use crate::reproduction::{self, Extent, Reproduction, Run, progress};
use anyhow::{Context as _, Result};
use indicatif::ProgressBar;
use std::path::Path;
use std::time::Instant;

/// The study, and the committed copy of its results.
pub(crate) const CHAPTER: Reproduction = Reproduction {
    command: "reproduce-chapter7",
    name: "chapter7",
    title: "Chapter 7",
    has_claims: true,
    run: Run::Remembering(reproduce),
};

pub(crate) fn reproduce(root: &Path, extent: Extent) -> Result<()> {
    let started = Instant::now();
    let setup = Setup::read(&root.join("fixtures/bat/chapter7.toml"))?;
    let out = CHAPTER.prepare(root, extent)?;
    let memory = Memory::of(root, extent);
    for case in &setup.cases {
        memory.remind(&case.bat, case.space.region(), &[MODEL, STAND_IN])?;
    }
    let designs = memory.designs()?;
    eprintln!("{}: the stand-in for the water channel is a richer model, not an experiment.", setup.file.title);

    let found = setup.cases.iter().map(|case| {
        let study = CaseStudy { setup: &setup, case, designs: &designs, memory: &memory };
        study.run().with_context(|| case.entry.label.clone())
    });
    let found = found.collect::<Result<_>>()?;
    let mut findings = Findings { setup, found, seconds: 0.0 };
    let pictures = figures::all(&findings)?;

    findings.seconds = started.elapsed().as_secs_f64();
    let claims = claims::all(&findings);
    let first = page::first_screen(&findings, &pictures)?;
    let page = page::page(&findings, &claims, &pictures, &first);
    let results = page::markdown(&findings, &claims, &first.markdown(&CHAPTER.kept_picture()));
    reproduction::save_page(&out, &pictures, &page, &results, first.picture)?;
    tables::every_step(&findings).write_csv(&out.join("iterations.csv"))?;
    tables::every_choice(&findings).write_csv(&out.join("choices.csv"))?;
    page::print(&findings, &claims, &CHAPTER.out());
    Handover::new(claims, &pictures).with_excerpts(page::excerpts(&findings)).save(&out)?;
    Ok(())
}

/// What one of the two studies is made from.
pub(crate) struct CaseStudy<'a> {
    pub(crate) setup: &'a Setup,
    pub(crate) case: &'a Case,
    pub(crate) designs: &'a Designs,
    pub(crate) memory: &'a Memory,
}

impl CaseStudy<'_> {
    pub(crate) fn run(&self) -> Result<Found> {
        let bar = self.bar("1/6 flights of model and stand-in", 2 * self.case.flown.n_cells());
        let fly = |fidelity| FlownGrid::fly(&self.case.bat, &self.case.flown, fidelity, |n| bar.inc(n as u64));
        let (model, truth) = (fly(MODEL)?, fly(STAND_IN)?);
        bar.finish();

        let bar = self.bar("2/6 optima of model and stand-in", 1);
        let (numerical, best) =
            rayon::join(|| Optimum::of(self.case, &model, MODEL), || Optimum::of(self.case, &truth, STAND_IN));
        let (numerical, best) = (numerical?, best?);
        bar.finish();

        let runs = self.runs(&model, &truth)?;
        let choices = self.choices(&model, &truth)?;

        let bar = self.bar("5/6 designs of the figures", 1);
        let flights = fly_before_after(self.case, &numerical, &runs[0])?;
        let numerical_true_cost = self.case.bat.cost(&numerical.point, STAND_IN).unwrap_or(f64::NAN);
        let best = best_known(best, &runs);
        bar.finish();

        let pooled = self.pooled(&model, &truth)?;
        Ok(Found { model, truth, numerical, numerical_true_cost, best, runs, choices, flights, pooled })
    }

    pub(crate) fn bar(&self, what: &str, length: usize) -> ProgressBar {
        progress(&format!("{}: {what}", self.case.entry.label), length)
    }

    pub(crate) fn rig<'a>(&self, space: &'a Space, [model, truth]: [&'a dyn CellCosts; 2]) -> StandInRig<'a> {
        let noise = &self.setup.file.noise;
        StandInRig { space, model, truth, noise: noise.share, seed: noise.first_seed }
    }

    /// The campaigns of every variant: on the grid that is flown, or with flights on demand where it has too many cells.
    pub(crate) fn runs(&self, model: &FlownGrid, truth: &FlownGrid) -> Result<Vec<Runs>> {
        let Self { setup, case, designs, .. } = self;
        let variants = &setup.file.variant;
        let n_campaigns: usize = variants.iter().map(|variant| 1 + variant.seeds as usize).sum();
        let bar = self.bar("3/6 campaigns: iterations", case.entry.iterations * n_campaigns);
        let run = |rig: &StandInRig<'_>, variant: &Variant| {
            let seeds = setup.file.noise.numbers(variant.seeds);
            let settings = setup.settings(case, variant)?;
            Runs::of(&variant.label, rig, &settings, &seeds, designs, |n| bar.inc(n as u64))
                .with_context(|| variant.label.clone())
        };
        let runs = self.on_all_cells([model, truth], |rig| variants.iter().map(|variant| run(rig, variant)).collect());
        bar.finish();
        runs
    }

    /// The campaigns of the pooled loop, with the budget of the first variant.
    fn pooled(&self, model: &FlownGrid, truth: &FlownGrid) -> Result<Pooled> {
        let Self { setup, case, .. } = self;
        let seeds = setup.file.noise.numbers(setup.file.pooled.seeds);
        let bar = self.bar("6/6 pooled loop: batches", case.entry.iterations * seeds.len());
        let budget = setup.settings(case, &setup.file.variant[0])?;
        let pooled = self
            .on_all_cells([model, truth], |rig| kept::pooled(self.memory, case, rig, &budget, &seeds, || bar.inc(1)));
        bar.finish();
        pooled
    }

    /// Something on the rig over all cells of the loops: the grid that is flown, or flights on demand where there are too many
    /// cells.
    fn on_all_cells<T>(&self, [model, truth]: [&FlownGrid; 2], run: impl FnOnce(&StandInRig<'_>) -> T) -> T {
        let case = self.case;
        let demand =
            |fidelity, grid: &FlownGrid| OnDemand { bat: &case.bat, space: &case.space, fidelity, range: grid.range() };
        let (model_on_demand, truth_on_demand) = (demand(MODEL, model), demand(STAND_IN, truth));
        let costs: [&dyn CellCosts; 2] =
            if case.is_flown_whole() { [model, truth] } else { [&model_on_demand, &truth_on_demand] };
        run(&self.rig(&case.space, costs))
    }

    pub(crate) fn choices(&self, model: &FlownGrid, truth: &FlownGrid) -> Result<Vec<Choice>> {
        let seeds = self.setup.file.noise.numbers(self.setup.file.noise.seeds);
        let bar = self.bar("4/6 wrong choices: campaigns", wrong::N_CHOICES * seeds.len());
        let rig = self.rig(&self.case.flown, [model, truth]);
        let base = self.setup.settings(self.case, &self.setup.file.variant[0])?;
        let choices = wrong::choices(&rig, [model, truth], &base, &seeds, self.designs, || bar.inc(1));
        bar.finish();
        choices
    }
}

/// The best design of the stand-in: that of the search, unless a campaign came upon a better one.
pub(crate) fn best_known(searched: Optimum, runs: &[Runs]) -> Optimum {
    let steps = runs.iter().flat_map(|runs| std::iter::once(&runs.quiet).chain(&runs.noisy)).flat_map(|steps| &steps.0);
    let met = steps.min_by(|a, b| a.cost.total_cmp(&b.cost));
    match met {
        Some(Step { point, cost, .. }) if *cost < searched.cost => Optimum { point: point.clone(), cost: *cost },
        _ => searched,
    }
}

pub(crate) fn fly_before_after(case: &Case, numerical: &Optimum, runs: &Runs) -> Result<BeforeAfter> {
    let last = runs.noisy.iter().map(|steps| Ok(steps.last()?.point.clone())).collect::<Result<Vec<_>>>()?;
    let after_seeds = case.bat.read_logged(&last, STAND_IN, |point, logged| Flown::of(point, logged).means());
    let blind = |points: &[Vec<f64>]| {
        case.bat.read_logged(points, STAND_IN, |point, logged| (point.to_vec(), Flown::of(point, logged).means()))
    };
    Ok(BeforeAfter {
        before: Flown::fly(case, &numerical.point).context("the numerical optimum")?,
        after: Flown::fly(case, &runs.quiet.last()?.point).context("the infused optimum")?,
        after_seeds: after_seeds.into_iter().collect::<Result<_>>()?,
        blind: Blind::read(case.space.region(), blind),
    })
}
