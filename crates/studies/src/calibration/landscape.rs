//! A candidate over the whole box: where its optima truly are, and whether its model is worth having.

use anyhow::{Context as _, Result, anyhow};
use bat_dynamics::Fidelity;
use doe::Model;
use interpn::MulticubicRegular;
use surface::{Data, Regression};
use water_channel::CostWeights;

use super::Calibration;
use super::candidate::{Candidate, Flown, Spot, fly};
use super::evidence::{Bounds, Evidence};
use crate::bat::{MODEL, STAND_IN};

/// Flights along center of mass and pitch set point, for both studies together.
const COARSE: [usize; 2] = [9, 12];
/// Points between them at which the interpolated cost is read.
const FINE: [usize; 2] = [113, 177];

/// Flights of both fidelities on a lattice over the widest box.
pub(super) struct Landscape {
    axes: [Vec<f64>; 2],
    /// Of model and stand-in; the second coordinate runs fastest.
    flown: [Vec<Option<Flown>>; 2],
}

/// Whether a numerical model of this plant is worth having.
#[derive(Debug, Clone, Copy)]
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

impl Landscape {
    pub(super) fn fly(calibration: &Calibration, candidate: &Candidate) -> Self {
        let widest: Bounds = core::array::from_fn(|k| {
            let all = calibration.boxes.map(|bounds| bounds[k]);
            [all[0][0].min(all[1][0]), all[0][1].max(all[1][1])]
        });
        let axes: [Vec<f64>; 2] = core::array::from_fn(|k| evenly(COARSE[k], widest[k]));
        let designs = || axes[0].iter().flat_map(|x| axes[1].iter().map(move |y| [*x, *y]));
        let of = |fidelity: Fidelity| designs().map(move |design| Spot::new(fidelity, design));
        let spots: Vec<Spot> = of(MODEL).chain(of(STAND_IN)).collect();
        let Calibration { profile, settings, .. } = calibration;
        let mut flown = fly(std::slice::from_ref(candidate), &spots, profile, settings).pop().unwrap_or_default();
        let stand_in = flown.split_off(flown.len() / 2);
        Self { axes, flown: [flown, stand_in] }
    }

    /// Share of the flights that failed.
    pub(super) fn failed(&self) -> f64 {
        let all = self.flown.iter().flatten();
        all.clone().filter(|flown| flown.is_none()).count() as f64 / all.count().max(1) as f64
    }

    /// Costs in a box, between the flights too, with their designs; not where a flight nearby failed.
    fn costs(&self, fidelity: Fidelity, weights: &CostWeights, bounds: Bounds) -> Result<Vec<([f64; 2], f64)>> {
        let flown = &self.flown[fidelity_index(fidelity)];
        let costs: Vec<f64> = flown.iter().map(|flown| flown.map_or(f64::NAN, |one| one.cost(weights))).collect();
        let dims = [self.axes[0].len(), self.axes[1].len()];
        let starts = [self.axes[0][0], self.axes[1][0]];
        let steps = [0, 1].map(|k| self.axes[k][1] - self.axes[k][0]);
        let cubic = MulticubicRegular::new(dims, starts, steps, &costs, false).map_err(|reason| anyhow!("{reason}"))?;
        let fine: [Vec<f64>; 2] = core::array::from_fn(|k| evenly(FINE[k], bounds[k]));
        let mut found = Vec::with_capacity(FINE[0] * FINE[1]);
        for x in &fine[0] {
            for y in &fine[1] {
                let cost = cubic.interp_one([*x, *y]).map_err(|reason| anyhow!("{reason}"))?;
                if cost.is_finite() {
                    found.push(([*x, *y], cost));
                }
            }
        }
        Ok(found)
    }

    /// The design with the lowest cost of a fidelity in a box, and that cost.
    pub(super) fn lowest(&self, evidence: &Evidence, candidate: &Candidate) -> Result<([f64; 2], f64)> {
        let costs = self.costs(evidence.fidelity, &candidate.weights[evidence.study], evidence.bounds)?;
        let lowest = costs.into_iter().min_by(|a, b| a.1.total_cmp(&b.1));
        lowest.with_context(|| format!("{}: no design of the box can fly", evidence.label))
    }

    /// What the model of a study is worth.
    pub(super) fn diagnostics(&self, study: usize, bounds: Bounds, candidate: &Candidate) -> Result<Diagnostics> {
        let weights = &candidate.weights[study];
        let [model, stand_in] = [MODEL, STAND_IN].map(|fidelity| self.costs(fidelity, weights, bounds));
        let (model, stand_in) = (model?, stand_in?);
        // Both where both can fly.
        let mut pairs = Vec::with_capacity(model.len());
        let mut others = stand_in.iter().peekable();
        for (design, cost) in &model {
            while others.next_if(|(other, _)| other < design).is_some() {}
            if let Some((_, true_cost)) = others.next_if(|(other, _)| other == design) {
                pairs.push((*design, *cost, *true_cost));
            }
        }
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
        rank_correlation: correlation(&ranks(&model), &ranks(&stand_in)),
        better_than_model: better,
        additive_fit: fit(&Model::additive_quadratic(2)?)?,
        quadratic_fit: fit(&Model::quadratic(2)?)?,
    })
}

/// Ranks from 0, equal values with their mean rank.
fn ranks(values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
    let mut ranks = vec![0.0; values.len()];
    let mut first = 0;
    for same in order.chunk_by(|a, b| values[*a] == values[*b]) {
        let mean = first as f64 + (same.len() - 1) as f64 / 2.0;
        same.iter().for_each(|index| ranks[*index] = mean);
        first += same.len();
    }
    ranks
}

/// Pearson's; 0 where one does not vary.
pub(super) fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let (ma, mb) = (mean(a), mean(b));
    let sum = |of: &dyn Fn(f64, f64) -> f64| a.iter().zip(b).map(|(x, y)| of(x - ma, y - mb)).sum::<f64>();
    let (aa, bb) = (sum(&|x, _| x * x), sum(&|_, y| y * y));
    if aa > 0.0 && bb > 0.0 { sum(&|x, y| x * y) / (aa * bb).sqrt() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// scipy.stats.spearmanr([1, 2, 2, 4, 7], [3, 1, 4, 4, 9]) is 0.763157894736842.
    #[test]
    fn rank_correlation_is_that_of_scipy() {
        let found = correlation(&ranks(&[1.0, 2.0, 2.0, 4.0, 7.0]), &ranks(&[3.0, 1.0, 4.0, 4.0, 9.0]));
        assert!((found - 0.763_157_894_736_842).abs() < 1e-12, "{found}");
        assert!(correlation(&[1.0, 1.0], &[2.0, 3.0]) == 0.0);
    }
}
