//! How the numerical optimization is done.

use serde::{Deserialize, Serialize};

use crate::Error;
use crate::codesign::strategy::Strategy;

/// Why a numerical optimization ended.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CodesignStop {
    /// Every search came down to the final radius, and an alternation to a standstill.
    Converged,
    /// [`OptimizerSettings::max_simulations`] was reached; the best point so far is returned.
    SimulationLimit,
    /// A single search used up [`OptimizerSettings::max_search_steps`].
    SearchLimit,
    /// [`OptimizerSettings::max_sweeps`] of the iterative strategy were made and it still moved.
    SweepLimit,
    /// A search lost its quadratic model to rounding; the best point so far is returned.
    ModelDegenerate,
}

impl CodesignStop {
    /// Whether the point is as good as the settings allow.
    #[must_use]
    pub fn is_converged(self) -> bool {
        self == Self::Converged
    }

    /// The graver of two ends: anything rather than `Converged`.
    pub(crate) fn and(self, other: Self) -> Self {
        if self.is_converged() { other } else { self }
    }
}

/// How the numerical optimization is done: strategy, starts, radii and limits.
///
/// Radii are coded: half the width of a parameter is 1. A search starts from the warm start and from
/// those points of a small lattice that have no better start nearby, so that on a single bowl it
/// costs one descent, and on two basins two.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct OptimizerSettings {
    /// Order of plant and controller.
    pub strategy: Strategy,
    /// Lattice points of the plant search, and of the simultaneous search. With 0 only the warm
    /// start is used. Default 5.
    pub n_starts: usize,
    /// Lattice points of each controller search. With 0 only the warm start is used. Default 5.
    pub n_controller_starts: usize,
    /// First trust-region radius, coded, at most 1. Default 0.2.
    pub initial_radius: f64,
    /// Last trust-region radius, coded: the accuracy of the optimum, and the smallest move of it that
    /// can be seen. Default 1e-3.
    pub final_radius: f64,
    /// Last radius of the controller search within the nested strategy, coded; finer than
    /// `final_radius`, because its error is the noise of the plant search. Default 1e-4.
    pub inner_final_radius: f64,
    /// Limit on the steps of one descent. Default 200, or more if the descent needs more to start.
    pub max_search_steps: usize,
    /// Limit on the simulations of one optimization. Default 10 000.
    pub max_simulations: usize,
    /// Limit on the turns of the iterative strategy. Default 50.
    pub max_sweeps: usize,
}

impl Default for OptimizerSettings {
    fn default() -> Self {
        Self {
            strategy: Strategy::Nested,
            n_starts: 5,
            n_controller_starts: 5,
            initial_radius: 0.2,
            final_radius: 1e-3,
            inner_final_radius: 1e-4,
            max_search_steps: 200,
            max_simulations: 10_000,
            max_sweeps: 50,
        }
    }
}

impl OptimizerSettings {
    /// Whether every number is usable.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`], [`Error::SettingCount`].
    pub fn validate(&self) -> Result<(), Error> {
        for (name, value, largest, expected) in [
            ("initial_radius", self.initial_radius, 1.0, "0 < radius <= 1"),
            ("final_radius", self.final_radius, self.initial_radius, "0 < radius <= initial_radius"),
            ("inner_final_radius", self.inner_final_radius, self.initial_radius, "0 < radius <= initial_radius"),
        ] {
            if !(value > 0.0 && value <= largest) {
                return Err(Error::Setting { name, value, expected });
            }
        }
        for (name, value) in [
            ("max_search_steps", self.max_search_steps),
            ("max_simulations", self.max_simulations),
            ("max_sweeps", self.max_sweeps),
        ] {
            if value == 0 {
                return Err(Error::SettingCount { name, value, expected: "at least 1" });
            }
        }
        Ok(())
    }
}
