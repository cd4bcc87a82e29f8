//! How well models predict designs that no loop has visited.

use super::file::Study;
use super::plant::Doubted;
use super::store::Kept;
use crate::correlation::rank_correlation;

/// What is known of the designs that are held out.
pub(super) struct HeldOut {
    designs: Vec<Vec<f64>>,
    /// In the stand-in; NaN where it cannot be flown.
    truth: Vec<f64>,
}

/// How a model does there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Score {
    /// Root of the mean squared error, relative to the true cost, in per cent.
    pub(super) error_pct: f64,
    /// Mean of the error, model less truth, in s.
    pub(super) bias: f64,
    /// Rank correlation of model and truth.
    pub(super) rank_correlation: f64,
}

impl HeldOut {
    pub(super) fn fly(study: &Study) -> Self {
        let at = |k: usize, i: usize| {
            let (lower, upper) = study.setup.bounds(k);
            lower + (upper - lower) * (i as f64 + 0.5) / study.positions[k] as f64
        };
        let [n, m] = study.positions;
        let designs: Vec<Vec<f64>> = (0..n).flat_map(|i| (0..m).map(move |j| vec![at(0, i), at(1, j)])).collect();
        let truth = Doubted(study).stand_in(&designs);
        Self { designs, truth: truth.into_iter().map(|flown| flown.map_or(f64::NAN, |cost| cost.total)).collect() }
    }

    pub(super) fn len(&self) -> usize {
        self.designs.len()
    }

    /// The model of all these campaigns: flown together they fill the lanes.
    pub(super) fn fly_last(&self, study: &Study, all: &[Kept]) {
        let last: Vec<&[f64]> = all.iter().filter_map(|kept| Some(&kept.turns.last()?.unknowns[..])).collect();
        let pairs: Vec<(&[f64], &[f64])> =
            last.iter().flat_map(|unknowns| self.designs.iter().map(move |design| (*unknowns, &design[..]))).collect();
        Doubted(study).fly(&pairs);
    }

    /// The model with these unknowns, and a plane on it.
    pub(super) fn score(&self, study: &Study, unknowns: &[f64], slope: &[f64], offset: f64) -> Score {
        let pairs: Vec<(&[f64], &[f64])> = self.designs.iter().map(|design| (unknowns, &design[..])).collect();
        let flown = Doubted(study).fly(&pairs);
        let plane = |design: &[f64]| offset + slope.iter().zip(design).map(|(slope, p)| slope * p).sum::<f64>();
        let both: Vec<(f64, f64)> = flown
            .into_iter()
            .zip(&self.designs)
            .zip(&self.truth)
            .filter_map(|((flown, design), truth)| Some((flown.ok()?.total + plane(design), *truth)))
            .filter(|(_, truth)| truth.is_finite())
            .collect();
        let (models, truths): (Vec<f64>, Vec<f64>) = both.iter().copied().unzip();
        let n = both.len().max(1) as f64;
        let squares: f64 = both.iter().map(|(model, truth)| (model / truth - 1.0).powi(2)).sum();
        Score {
            error_pct: 100.0 * (squares / n).sqrt(),
            bias: both.iter().map(|(model, truth)| model - truth).sum::<f64>() / n,
            rank_correlation: rank_correlation(&models, &truths),
        }
    }

    /// The model that a campaign optimized last.
    pub(super) fn score_of(&self, study: &Study, kept: &Kept) -> Option<Score> {
        let last = kept.turns.last()?;
        Some(self.score(study, &last.unknowns, &last.carried_slope, last.carried_offset))
    }
}
