//! How far the models of a campaign are from the truth, beside what Section 6.1 says about it.

use anyhow::{Context as _, Result};
use design_space::Cell;
use infuse::{
    convergence::{AssumptionReport, Bound, Norm, NormOrder, NormScaling, RegretCertificate, coded_cell_measure},
    correction::ModelStage,
    global::{self, RetainedSet, TracedSurface},
};
use surface::GridPoints;

use super::grid::FlownGrid;
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
        let points = GridPoints::of_space(&doe::Space::of_region(space.region())?)?;
        let (simulated, true_cost) = (model.values(), truth.values());
        let (best_cell, best_cost) = truth.lowest()?;
        let measure = coded_cell_measure(space.region().n_parameters(), space.n_cells())?;
        let norms = norms()?;
        let rule = campaign.settings().correction;
        let bound = Bound::new(rule, ModelStage::Corrected);

        let less = |surface: &TracedSurface, minus: &[f64]| -> Result<Vec<f64>> {
            let mut values = vec![0.0; minus.len()];
            surface.surface().predict_range(&points, 0, &mut values)?;
            values.iter_mut().zip(minus).for_each(|(value, minus)| *value -= minus);
            Ok(values)
        };
        let gap: Vec<f64> = true_cost.iter().zip(&simulated).map(|(a, b)| a - b).collect();
        let (mut e1, mut e2): (Vec<Vec<f64>>, Vec<Vec<f64>>) = (Vec::new(), Vec::new());
        let mut correction = vec![0.0; space.n_cells()];
        let zero = correction.clone();
        let mut iterations = Vec::new();
        for (report, surfaces) in campaign.reports().iter().zip(campaign.surfaces()) {
            let experiment = surfaces.experiment.as_ref();
            let experiment =
                experiment.with_context(|| format!("iteration {}: no surface of experiments", report.iteration))?;
            e1.push(less(&surfaces.simulation, &simulated)?);
            e2.push(less(experiment, &true_cost)?);
            let error = less(&surfaces.numerical, &true_cost)?;
            let mut onset = less(&surfaces.simulation, &true_cost)?;
            onset.iter_mut().zip(&correction).for_each(|(value, correction)| *value += correction);
            correction = less(&surfaces.correction, &zero)?;

            let before = campaign.retained_at(report.iteration).context("a closed iteration")?;
            let after = campaign.retained_at(report.iteration + 1).context("the iteration after a closed one")?;
            let cells = flying_cells(&before, &simulated, &true_cost);
            let over = |values: &[f64]| -> Vec<f64> { cells.iter().map(|cell| values[*cell]).collect() };
            let measures = vec![measure; cells.len()];
            let each = norms.map(|norm| -> Result<NormAccuracy> {
                let of = |values: &[f64]| -> Result<f64> { Ok(norm.over(&over(values), &measures)?) };
                let each = |fields: &[Vec<f64>]| fields.iter().map(|field| of(field)).collect::<Result<Vec<f64>>>();
                let (e1, e2, gap) = (each(&e1)?, each(&e2)?, of(&gap)?);
                let (simulation, experiment) = (e1[e1.len() - 1], e2[e2.len() - 1]);
                Ok(NormAccuracy {
                    error: of(&error)?,
                    onset_error: of(&onset)?,
                    gap,
                    simulation,
                    experiment,
                    finite_bound: bound.finite(gap, &e1, &e2)?,
                    proposition: 2.0 * simulation + experiment,
                })
            });
            let [a, b, c] = each;
            let norms = [a?, b?, c?];

            let optimum_cell = usize::try_from(report.screening.optimum_cell.index())?;
            let optimum_cost = true_cost[optimum_cell];
            let corrected: Vec<f64> = over(&error).iter().zip(over(&true_cost)).map(|(e, truth)| e + truth).collect();
            let place = cells.iter().position(|cell| *cell == optimum_cell);
            let certified_regret = match place {
                Some(place) => RegretCertificate::of_cell(place, &corrected, norms[SUP].finite_bound)?.regret,
                None => f64::NAN,
            };
            let least = over(&true_cost).into_iter().fold(f64::INFINITY, f64::min);
            iterations.push(IterationAccuracy {
                iteration: report.iteration,
                share_before: before.share(),
                share_after: after.share(),
                norms,
                optimum: report.screening.optimum.clone(),
                optimum_cost,
                regret: optimum_cost - best_cost,
                retained_regret: optimum_cost - least,
                certified_regret,
                keeps_best: after.contains(Cell::new(best_cell as u64)),
                spread: report.screening.spread.s(),
            });
        }
        let assumption = (0..NORMS.len())
            .map(|q| {
                let of =
                    |f: fn(&NormAccuracy) -> f64| -> Vec<f64> { iterations.iter().map(|i| f(&i.norms[q])).collect() };
                AssumptionReport::new(&of(|n| n.simulation), &of(|n| n.experiment), GROWTH_TOLERANCE)
            })
            .collect::<std::result::Result<_, _>>()?;
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

fn flying_cells(retained: &RetainedSet, simulated: &[f64], true_cost: &[f64]) -> Vec<usize> {
    let cells = retained.cells().filter_map(|cell| usize::try_from(cell.index()).ok());
    cells.filter(|cell| simulated[*cell].is_finite() && true_cost[*cell].is_finite()).collect()
}
