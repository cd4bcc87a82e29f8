//! Dropping what is worse than the optimum beyond doubt: Section 5.5.

use design_space::Cell;
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, Normal};
use surface::GridPoints;

use crate::global::retained::RetainedSet;
use crate::global::settings::{Settings, SpreadFallback};
use crate::global::spread::Spread;
use crate::traced::TracedSurface;

/// z of (39): how many standard deviations a cell is worse than the optimum.
///
/// ```text
/// z(p) = (Ĵ(p) − Ĵ(p*)) / (S √2)
/// ```
///
/// Source: (39).
pub(crate) fn z(value: f64, optimum_value: f64, spread: f64) -> f64 {
    (value - optimum_value) / (spread * std::f64::consts::SQRT_2)
}

/// z_0: the quantile of the standard normal distribution at this level, 1.2816 at 0.9. One-sided, because
/// (38) is: only what is worse is dropped.
pub(crate) fn threshold(confidence: f64) -> f64 {
    Normal::standard().inverse_cdf(confidence)
}

/// The optimum of a batch and the test of every other cell against it.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Screening {
    /// The cell of p̂*, where the combined surface is smallest among the retained cells.
    pub optimum_cell: Cell,
    /// p̂*, natural.
    pub optimum: Vec<f64>,
    /// Ĵ(p̂*).
    pub optimum_value: f64,
    /// The cell where Ĵsim is smallest among the retained cells: in batch 1 the pure numerical optimum,
    /// row 0 of Tables 5 and 6.
    pub simulation_optimum_cell: Cell,
    /// The same, natural.
    pub simulation_optimum: Vec<f64>,
    /// The S of the test.
    pub spread: Spread,
    /// Whether there was a test: not before [`Settings::first_screening`], and in a [careful](Settings::careful) campaign not
    /// without a degree of freedom that shows misfit.
    #[serde(default = "yes", skip_serializing_if = "is_yes")]
    pub tested: bool,
    /// z_0.
    pub threshold: f64,
    /// Cells at the onset of the batch, M_i.
    pub n_before: u64,
    /// Cells left after it, M_i+1.
    pub n_after: u64,
}

fn yes() -> bool {
    true
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde hands out references")]
fn is_yes(flag: &bool) -> bool {
    *flag
}

impl Screening {
    /// The S that cells were tested with.
    pub(crate) fn tested_spread(&self) -> Option<f64> {
        self.spread.s().filter(|_| self.tested)
    }

    /// Whether a cell with this combined value is retained: (37), that it is as good as the optimum, is not rejected in
    /// favor of (38), that it is worse.
    ///
    /// Source: (37), (38).
    pub(crate) fn keeps(&self, value: f64) -> bool {
        self.tested_spread().is_none_or(|s| {
            let z = z(value, self.optimum_value, s);
            z.is_nan() || z < self.threshold
        })
    }

    /// M_i+1: the cells of M_i that the test keeps.
    pub(crate) fn reduced(&self, before: &RetainedSet, points: &GridPoints, combined: &TracedSurface) -> RetainedSet {
        let mut after = before.clone();
        if self.tested_spread().is_some() {
            after.retain(points, combined.surface(), |value| self.keeps(value));
        }
        after
    }

    pub(crate) fn ends_campaign(&self, settings: &Settings) -> bool {
        settings.fallback == SpreadFallback::Stop && self.spread.s().is_none()
    }
}

/// Why and when a cell was dropped.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Dropped {
    /// The batch that dropped it, from 1.
    pub batch: usize,
    /// Ĵ of that batch at the cell.
    pub value: f64,
    /// Ĵ(p̂*) of that batch.
    pub optimum_value: f64,
    /// S of that batch.
    pub spread: f64,
    /// z of (39), at least z0.
    pub z: f64,
    /// z_0.
    pub z0: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// (38) is believed from z_0 on: a cell at z_0 is dropped, one just below is not.
    #[test]
    fn a_cell_at_the_threshold_is_dropped() {
        let screening = Screening {
            optimum_cell: Cell::new(0),
            optimum: vec![0.0],
            optimum_value: 1.0,
            simulation_optimum_cell: Cell::new(0),
            simulation_optimum: vec![0.0],
            spread: Spread::Estimated { s: 0.5, n_validation: 4 },
            tested: true,
            threshold: z(2.0, 1.0, 0.5),
            n_before: 2,
            n_after: 1,
        };
        assert!(!screening.keeps(2.0), "at the threshold");
        assert!(screening.keeps(2.0_f64.next_down()), "below it");
        assert!(screening.keeps(f64::NAN), "nothing is known of it");
        assert!(Screening { tested: false, ..screening }.keeps(3.0), "not tested");
    }
}
