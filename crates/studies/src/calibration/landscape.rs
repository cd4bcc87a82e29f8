//! A candidate over the whole box: where its optima truly are, and whether its model is worth having.

use anyhow::{Context as _, Result, anyhow};
use bat_dynamics::Fidelity;
use doe::Model;
use interpn::MulticubicRegular;
use serde::{Deserialize, Serialize};
use surface::{Data, Regression};
use water_channel::CostWeights;

use super::candidate::{Candidate, Flown, Spot};
use super::evidence::{Bounds, Evidence};
use super::file::Calibration;
use crate::bat::{MODEL, STAND_IN};
use crate::correlation::rank_correlation;

/// Flights along center of mass and pitch set point, for both studies together.
const COARSE: [usize; 2] = [9, 12];
/// Points between them at which the interpolated cost is read.
const FINE: [usize; 2] = [113, 177];
const FINE_NEAR: [usize; 2] = [49, 81];

/// Flights about an optimum of the evidence, and how far they reach from it in tolerances.
const NEAR: [usize; 2] = [9, 9];
const REACH: f64 = 2.0;

/// Flights of one fidelity on a lattice; the second coordinate runs fastest.
struct Lattice {
    axes: [Vec<f64>; 2],
    flown: Vec<Option<Flown>>,
}

/// Flights of both fidelities over the widest box, and closer ones about the optima of the evidence.
pub(super) struct Landscape {
    /// Of model and stand-in.
    wide: [Lattice; 2],
    /// For each of the evidence that is an optimum.
    near: Vec<Option<Lattice>>,
}

/// Whether a numerical model of this plant is worth having.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(super) struct Diagnostics {
    /// Of model and stand-in over the box, by rank.
    pub(super) rank_correlation: f64,
    /// Share of the box that is better in the stand-in than the model's optimum.
    pub(super) better_than_model: f64,
    /// Of the additive quadratic (61) in the stand-in's cost.
    pub(super) additive_fit: f64,
    /// Of the full quadratic.
    pub(super) quadratic_fit: f64,
}

fn fidelity_index(fidelity: Fidelity) -> usize {
    usize::from(fidelity != MODEL)
}

fn evenly(count: usize, [lower, upper]: [f64; 2]) -> Vec<f64> {
    (0..count).map(|k| lower + (upper - lower) * k as f64 / (count - 1) as f64).collect()
}

impl Lattice {
    fn axes(counts: [usize; 2], bounds: Bounds) -> [Vec<f64>; 2] {
        core::array::from_fn(|k| evenly(counts[k], bounds[k]))
    }

    fn fly(calibration: &Calibration, candidate: &Candidate, fidelity: Fidelity, axes: [Vec<f64>; 2]) -> Self {
        let along = |x: f64| axes[1].iter().map(move |y| Spot::new(fidelity, [x, *y]));
        let spots: Vec<Spot> = axes[0].iter().flat_map(|x| along(*x)).collect();
        let flown = calibration.fly(candidate, &spots);
        Self { axes, flown }
    }

    /// Costs at as many designs within bounds, between the flights too; not finite where a flight nearby failed.
    fn costs(&self, weights: &CostWeights, counts: [usize; 2], bounds: Bounds) -> Result<Vec<([f64; 2], f64)>> {
        let costs: Vec<f64> = self.flown.iter().map(|flown| flown.map_or(f64::NAN, |one| one.cost(weights))).collect();
        let dims = [self.axes[0].len(), self.axes[1].len()];
        let starts = [self.axes[0][0], self.axes[1][0]];
        let steps = [0, 1].map(|k| self.axes[k][1] - self.axes[k][0]);
        let cubic = MulticubicRegular::new(dims, starts, steps, &costs, false).map_err(|reason| anyhow!("{reason}"))?;
        let [xs, ys] = Self::axes(counts, bounds);
        let mut found = Vec::with_capacity(xs.len() * ys.len());
        for x in &xs {
            for y in &ys {
                let cost = cubic.interp_one([*x, *y]).map_err(|reason| anyhow!("{reason}"))?;
                found.push(([*x, *y], cost));
            }
        }
        Ok(found)
    }
}

/// What lies within the reach of an optimum, inside of its box.
fn window(evidence: &Evidence, tolerance: [f64; 2]) -> Bounds {
    core::array::from_fn(|k| {
        let [lower, upper] = evidence.bounds[k];
        let reach = REACH * tolerance[k];
        [lower.max(evidence.design[k] - reach), upper.min(evidence.design[k] + reach)]
    })
}

impl Landscape {
    pub(super) fn fly(calibration: &Calibration, candidate: &Candidate) -> Self {
        let widest: Bounds = core::array::from_fn(|k| {
            let all = calibration.boxes.map(|bounds| bounds[k]);
            [all[0][0].min(all[1][0]), all[0][1].max(all[1][1])]
        });
        let fly =
            |fidelity, counts, bounds| Lattice::fly(calibration, candidate, fidelity, Lattice::axes(counts, bounds));
        let about = |evidence: &Evidence| {
            let bounds = window(evidence, calibration.tolerance.of_design());
            evidence.is_optimum.then(|| fly(evidence.fidelity, NEAR, bounds))
        };
        Self {
            wide: [MODEL, STAND_IN].map(|fidelity| fly(fidelity, COARSE, widest)),
            near: calibration.evidence.iter().map(about).collect(),
        }
    }

    /// Share of the flights over the box that failed.
    pub(super) fn failed(&self) -> f64 {
        let all = self.wide.iter().flat_map(|lattice| &lattice.flown);
        all.clone().filter(|flown| flown.is_none()).count() as f64 / all.count().max(1) as f64
    }

    /// The design with the lowest cost in the box of evidence that is an optimum, by its number, and that cost.
    pub(super) fn lowest(
        &self,
        calibration: &Calibration,
        index: usize,
        candidate: &Candidate,
    ) -> Result<([f64; 2], f64)> {
        let evidence = &calibration.evidence[index];
        let weights = &candidate.weights[evidence.study];
        let close = window(evidence, calibration.tolerance.of_design());
        let is_close =
            |design: &[f64; 2]| design.iter().zip(close).all(|(x, [lower, upper])| (lower..=upper).contains(x));
        let wide = self.wide[fidelity_index(evidence.fidelity)].costs(weights, FINE, evidence.bounds)?;
        let near = match &self.near[index] {
            Some(lattice) => lattice.costs(weights, FINE_NEAR, close)?,
            None => Vec::new(),
        };
        let least = |costs: Vec<([f64; 2], f64)>| {
            costs.into_iter().filter(|(_, cost)| cost.is_finite()).min_by(|a, b| a.1.total_cmp(&b.1))
        };
        let near = least(near).with_context(|| format!("{}: no design nearby can fly", evidence.label))?;
        let far = least(wide.into_iter().filter(|(design, _)| !is_close(design)).collect());
        // The wide lattice is too coarse to be believed: what it promises is flown.
        let Some((design, _)) = far.filter(|(_, cost)| *cost < near.1) else { return Ok(near) };
        let flown = calibration.fly(candidate, &[Spot::new(evidence.fidelity, design)]).pop().flatten();
        let flown = flown.map(|flown| (design, flown.cost(weights)));
        Ok(flown.filter(|(_, cost)| *cost < near.1).unwrap_or(near))
    }

    /// What the model of a study is worth.
    pub(super) fn diagnostics(&self, study: usize, bounds: Bounds, candidate: &Candidate) -> Result<Diagnostics> {
        let weights = &candidate.weights[study];
        let [model, stand_in] =
            [MODEL, STAND_IN].map(|fidelity| self.wide[fidelity_index(fidelity)].costs(weights, FINE, bounds));
        let (model, stand_in) = (model?, stand_in?);
        // Both where both can fly, in the same order.
        let pairs = model.iter().zip(&stand_in).map(|((design, model), (_, stand_in))| (*design, *model, *stand_in));
        let pairs: Vec<([f64; 2], f64, f64)> =
            pairs.filter(|(_, model, stand_in)| model.is_finite() && stand_in.is_finite()).collect();
        diagnostics(&pairs, bounds)
    }
}

fn diagnostics(pairs: &[([f64; 2], f64, f64)], bounds: Bounds) -> Result<Diagnostics> {
    let (model, stand_in): (Vec<f64>, Vec<f64>) = pairs.iter().map(|(_, model, stand_in)| (*model, *stand_in)).unzip();
    let best = pairs.iter().min_by(|a, b| a.1.total_cmp(&b.1)).context("no design flies in both fidelities")?;
    let better = stand_in.iter().filter(|cost| **cost < best.2).count() as f64 / stand_in.len() as f64;
    let coded = |design: &[f64; 2]| -> [f64; 2] {
        core::array::from_fn(|k| 2.0 * (design[k] - bounds[k][0]) / (bounds[k][1] - bounds[k][0]) - 1.0)
    };
    let coordinates: Vec<f64> = pairs.iter().flat_map(|(design, ..)| coded(design)).collect();
    let data = Data::new(2, coordinates, stand_in.clone())?;
    let fit = |model: &Model| -> Result<f64> { Ok(Regression::fit(model, &data)?.r_squared().unwrap_or(f64::NAN)) };
    Ok(Diagnostics {
        rank_correlation: rank_correlation(&model, &stand_in),
        better_than_model: better,
        additive_fit: fit(&Model::additive_quadratic(2)?)?,
        quadratic_fit: fit(&Model::quadratic(2)?)?,
    })
}
