//! How far the models of a campaign are from the truth, beside what Section 6.1 says about it.

use anyhow::{Context as _, Result};
use design_space::Cell;
use infuse::{
    convergence::{AssumptionReport, Bound, Norm, NormOrder, NormScaling, RegretCertificate, coded_cell_measure},
    correction::ModelStage,
    global::{self, BatchSurfaces, RetainedSet, TracedSurface},
};
use surface::{GridPoints, PointSource as _};

use super::grid::FlownGrid;
use super::per_cell::PerCell;
use super::space::Space;

/// A norm by name: those of (42) for q = 1 and 2 as printed, and the largest magnitude.
pub(crate) const NORMS: [&str; 3] = ["q = 1", "q = 2", "q = ∞"];
/// The norm (42) that tables and figures show.
pub(crate) const Q2: usize = 1;
/// The one that bounds the error of each single design.
pub(crate) const SUP: usize = 2;
/// An error counts as grown when it exceeds the least so far by this part of it.
const GROWTH_TOLERANCE: f64 = 0.05;

fn norms() -> Result<[Norm; 3]> {
    let of = |q| -> Result<Norm> { Ok(Norm { order: NormOrder::finite(q)?, scaling: NormScaling::Integral }) };
    Ok([of(1.0)?, of(2.0)?, Norm::SUP])
}

/// What one norm says about the model after an iteration, over the cells that were left at its onset; in seconds times a
/// power of the coded volume.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NormAccuracy {
    /// ‖Ĵnum,n − J_true‖.
    pub(crate) error: f64,
    /// ‖Ĵsim,n + Ĵcor,n−1 − J_true‖: the model that the combined surface of the iteration was fitted to.
    pub(crate) onset_error: f64,
    /// ‖J_true − J_sim‖: the error of the model that is never corrected.
    pub(crate) gap: f64,
    /// ‖e1,n‖ and ‖e2,n‖ of (41).
    pub(crate) simulation: f64,
    pub(crate) experiment: f64,
    /// What the error cannot exceed, from the errors of all iterations so far over the same cells.
    pub(crate) finite_bound: f64,
    /// 2 ‖e1,n‖ + ‖e2,n‖: the right-hand side of (55) with the errors of this iteration. It bounds a limit, not this error.
    pub(crate) proposition: f64,
}

/// One iteration of a campaign beside the truth.
#[derive(Clone, Debug)]
pub(crate) struct IterationAccuracy {
    pub(crate) iteration: usize,
    /// Parts of the original cells, at the onset and after the z-test.
    pub(crate) share_before: f64,
    pub(crate) share_after: f64,
    /// In the order of [`NORMS`].
    pub(crate) norms: [NormAccuracy; 3],
    pub(crate) optimum: Vec<f64>,
    /// What the optimum of the combined surface truly costs.
    pub(crate) optimum_cost: f64,
    /// That, less the lowest true cost of the whole space.
    pub(crate) regret: f64,
    /// The same, less the lowest true cost of the cells at the onset.
    pub(crate) retained_regret: f64,
    /// What the certificate says the latter is at most, with the finite bound.
    pub(crate) certified_regret: f64,
    /// Whether the truly best cell is left after the z-test.
    pub(crate) keeps_best: bool,
    /// S of (40), if there was one.
    pub(crate) spread: Option<f64>,
}

/// A campaign beside the truth.
#[derive(Clone, Debug)]
pub(crate) struct Accuracy {
    pub(crate) iterations: Vec<IterationAccuracy>,
    /// Where the errors of the surfaces grew, in the order of [`NORMS`].
    pub(crate) assumption: Vec<AssumptionReport>,
}

impl Accuracy {
    /// Compares every iteration. The truth and the true simulation are known at every cell;
    /// cells that do not fly in both are left out of all norms.
    ///
    /// # Errors
    /// When an iteration could not fit its experiments: then there is no e2 to speak of.
    pub(crate) fn of(campaign: &global::Loop, space: &Space, model: &FlownGrid, truth: &FlownGrid) -> Result<Self> {
        let mut beside = Beside::new(campaign, space, model, truth)?;
        let batches = campaign.reports().iter().zip(campaign.surfaces());
        let iterations = batches.map(|(report, surfaces)| beside.iteration(report, surfaces));
        let iterations = iterations.collect::<Result<Vec<_>>>()?;
        let assumption = (0..NORMS.len()).map(|norm| assumption(&iterations, norm)).collect::<Result<_>>()?;
        Ok(Self { iterations, assumption })
    }

    pub(crate) fn last(&self) -> Option<&IterationAccuracy> {
        self.iterations.last()
    }

    /// The largest part of its finite bound that the error ever reaches, over all iterations and norms.
    pub(crate) fn largest_share_of_bound(&self) -> f64 {
        let norms = self.iterations.iter().flat_map(|iteration| &iteration.norms);
        norms.map(|norm| norm.error / norm.finite_bound).fold(0.0, f64::max)
    }

    /// The first iteration from which on the error stays within the right-hand side of (55).
    pub(crate) fn within_proposition_from(&self, norm: usize) -> Option<usize> {
        let outside = self.iterations.iter().rposition(|i| i.norms[norm].error > i.norms[norm].proposition);
        let first = outside.map_or(0, |last| last + 1);
        self.iterations.get(first).map(|iteration| iteration.iteration)
    }

    /// The iteration whose z-test dropped the truly best cell.
    pub(crate) fn best_dropped_at(&self) -> Option<usize> {
        self.iterations.iter().find(|iteration| !iteration.keeps_best).map(|iteration| iteration.iteration)
    }

    /// How many iterations dropped at least one cell.
    pub(crate) fn n_shrinking(&self) -> usize {
        self.iterations.iter().filter(|iteration| iteration.share_after < iteration.share_before).count()
    }
}

/// Whether the errors of the surfaces grew, in one norm.
fn assumption(iterations: &[IterationAccuracy], norm: usize) -> Result<AssumptionReport> {
    let of = |f: fn(&NormAccuracy) -> f64| -> Vec<f64> { iterations.iter().map(|i| f(&i.norms[norm])).collect() };
    Ok(AssumptionReport::new(&of(|n| n.simulation), &of(|n| n.experiment), GROWTH_TOLERANCE)?)
}

/// A campaign beside the truth, iteration by iteration.
struct Beside<'a> {
    campaign: &'a global::Loop,
    points: GridPoints,
    simulated: PerCell<f64>,
    true_cost: PerCell<f64>,
    /// The truly best cell and its cost.
    best: (Cell, f64),
    /// Of a cell.
    measure: f64,
    norms: [Norm; 3],
    bound: Bound,
    /// J_true − J_sim.
    gap: PerCell<f64>,
    /// e1 and e2 of (41) of the iterations so far.
    e1: Vec<PerCell<f64>>,
    e2: Vec<PerCell<f64>>,
    /// Ĵcor of the iteration before.
    correction: PerCell<f64>,
}

/// Values of some cells, in their order.
struct Over {
    measures: Vec<f64>,
    error: Vec<f64>,
    onset_error: Vec<f64>,
    gap: Vec<f64>,
    e1: Vec<Vec<f64>>,
    e2: Vec<Vec<f64>>,
}

impl<'a> Beside<'a> {
    fn new(campaign: &'a global::Loop, space: &Space, model: &FlownGrid, truth: &FlownGrid) -> Result<Self> {
        let (simulated, true_cost) = (model.values(), truth.values());
        Ok(Self {
            campaign,
            points: GridPoints::of_space(&doe::Space::of_region(space.region())?)?,
            best: truth.lowest()?,
            measure: coded_cell_measure(space.region().n_parameters(), space.n_cells())?,
            norms: norms()?,
            bound: Bound::new(campaign.settings().correction, ModelStage::Corrected),
            gap: true_cost.with(&simulated, |truth, simulated| truth - simulated),
            e1: Vec::new(),
            e2: Vec::new(),
            correction: simulated.map(|_| 0.0),
            simulated,
            true_cost,
        })
    }

    /// The next iteration: they must come in their order.
    fn iteration(&mut self, report: &global::Report, surfaces: &BatchSurfaces) -> Result<IterationAccuracy> {
        let number = report.number;
        let [error, onset_error] = self.errors(number, surfaces)?;
        let before = self.campaign.retained_at(number).context("a closed iteration")?;
        let after = self.campaign.retained_at(number + 1).context("the iteration after a closed one")?;
        let cells = self.flying(&before);
        let over = self.over(&cells, &error, &onset_error);
        let [a, b, c] = self.norms.map(|norm| self.norm(norm, &over));
        let norms = [a?, b?, c?];

        let optimum_cell = report.screening.optimum_cell;
        let optimum_cost = self.true_cost[optimum_cell];
        let true_cost = self.true_cost.over(&cells);
        let corrected: Vec<f64> = error.over(&cells).iter().zip(&true_cost).map(|(e, truth)| e + truth).collect();
        let certified_regret = match cells.iter().position(|cell| *cell == optimum_cell) {
            Some(place) => RegretCertificate::of_cell(place, &corrected, norms[SUP].finite_bound)?.regret,
            None => f64::NAN,
        };
        let (best_cell, best_cost) = self.best;
        Ok(IterationAccuracy {
            iteration: number,
            share_before: before.share(),
            share_after: after.share(),
            norms,
            optimum: report.screening.optimum.clone(),
            optimum_cost,
            regret: optimum_cost - best_cost,
            retained_regret: optimum_cost - true_cost.into_iter().fold(f64::INFINITY, f64::min),
            certified_regret,
            keeps_best: after.contains(best_cell),
            spread: report.screening.spread.s(),
        })
    }

    /// The errors of the model at the end of an iteration and at its onset; those of its surfaces are kept.
    fn errors(&mut self, number: usize, surfaces: &BatchSurfaces) -> Result<[PerCell<f64>; 2]> {
        let experiment = surfaces.experiment.as_ref();
        let experiment = experiment.with_context(|| format!("iteration {number}: no surface of experiments"))?;
        let less = |values: &PerCell<f64>, minus: &PerCell<f64>| values.with(minus, |value, minus| value - minus);
        let simulation = self.predicted(&surfaces.simulation)?;
        self.e1.push(less(&simulation, &self.simulated));
        self.e2.push(less(&self.predicted(experiment)?, &self.true_cost));
        let error = less(&self.predicted(&surfaces.numerical)?, &self.true_cost);
        let onset = less(&simulation, &self.true_cost).with(&self.correction, |error, correction| error + correction);
        self.correction = self.predicted(&surfaces.correction)?;
        Ok([error, onset])
    }

    /// A surface at every cell.
    fn predicted(&self, surface: &TracedSurface) -> Result<PerCell<f64>> {
        let mut values = vec![0.0; self.points.n_points() as usize];
        surface.surface().predict_range(&self.points, 0, &mut values)?;
        Ok(values.into_iter().collect())
    }

    /// The cells of a set that fly in the model and in truth.
    fn flying(&self, retained: &RetainedSet) -> Vec<Cell> {
        let flies = |cell: &Cell| self.simulated[*cell].is_finite() && self.true_cost[*cell].is_finite();
        retained.cells().filter(flies).collect()
    }

    /// Everything that norms are taken of, over these cells.
    fn over(&self, cells: &[Cell], error: &PerCell<f64>, onset_error: &PerCell<f64>) -> Over {
        let each = |fields: &[PerCell<f64>]| fields.iter().map(|field| field.over(cells)).collect();
        Over {
            measures: vec![self.measure; cells.len()],
            error: error.over(cells),
            onset_error: onset_error.over(cells),
            gap: self.gap.over(cells),
            e1: each(&self.e1),
            e2: each(&self.e2),
        }
    }

    /// What a norm says of the latest iteration.
    fn norm(&self, norm: Norm, over: &Over) -> Result<NormAccuracy> {
        let of = |values: &Vec<f64>| -> Result<f64> { Ok(norm.over(values, &over.measures)?) };
        let each = |fields: &[Vec<f64>]| fields.iter().map(of).collect::<Result<Vec<f64>>>();
        let (e1, e2, gap) = (each(&over.e1)?, each(&over.e2)?, of(&over.gap)?);
        let (simulation, experiment) = (e1[e1.len() - 1], e2[e2.len() - 1]);
        Ok(NormAccuracy {
            error: of(&over.error)?,
            onset_error: of(&over.onset_error)?,
            gap,
            simulation,
            experiment,
            finite_bound: self.bound.finite(gap, &e1, &e2)?,
            proposition: 2.0 * simulation + experiment,
        })
    }
}
