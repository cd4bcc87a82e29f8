//! The entries that study files of several chapters have.

use std::path::Path;

use anyhow::{Context as _, Result};
#[cfg(feature = "global")]
use design_space::Model;
#[cfg(feature = "global")]
use infuse::global;
use serde::Deserialize;

use super::checks::{check_seeds, check_share};

/// The files of the case study, beside the study file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct FilesEntry {
    pub(crate) rig: String,
    pub(crate) profile: String,
    pub(crate) cost: String,
}

/// A file as written.
#[derive(Clone, Debug)]
pub(crate) struct NamedText {
    pub(crate) name: String,
    pub(crate) text: String,
}

impl FilesEntry {
    /// The texts of rig, profile and cost.
    pub(crate) fn read(&self, directory: &Path) -> Result<[NamedText; 3]> {
        let read = |name: &String| -> Result<NamedText> {
            let path = directory.join(name);
            let text = std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
            Ok(NamedText { name: name.clone(), text })
        };
        Ok([read(&self.rig)?, read(&self.profile)?, read(&self.cost)?])
    }
}

#[cfg(test)]
impl FilesEntry {
    /// Those of Chapter 7.
    pub(crate) fn of_chapter7() -> Self {
        let [rig, profile, cost] = ["rig.toml", "test-profile.toml", "cost-chapter7.toml"].map(str::to_owned);
        Self { rig, profile, cost }
    }
}

/// The step sizes.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct NumericsEntry {
    steps_per_sample: usize,
    report_steps_per_sample: usize,
}

impl NumericsEntry {
    /// RK4 steps per sample: in searches and landscapes, and for reported designs.
    pub(crate) fn steps(&self) -> [usize; 2] {
        [self.steps_per_sample, self.report_steps_per_sample]
    }
}

#[cfg(test)]
impl NumericsEntry {
    pub(crate) const COARSE: Self = Self { steps_per_sample: 1, report_steps_per_sample: 1 };
}

/// A design variable with its bounds.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ParameterEntry {
    pub(crate) name: String,
    pub(crate) unit: String,
    pub(crate) lower: f64,
    pub(crate) upper: f64,
}

#[cfg(test)]
impl ParameterEntry {
    /// Center of mass and pitch set point within these bounds.
    pub(crate) fn two(center_of_mass: [f64; 2], pitch_set_point: [f64; 2]) -> [Self; 2] {
        let entry = |name: &str, unit: &str, [lower, upper]: [f64; 2]| Self {
            name: name.to_owned(),
            unit: unit.to_owned(),
            lower,
            upper,
        };
        [entry("center_of_mass", "% chord", center_of_mass), entry("pitch_set_point", "deg", pitch_set_point)]
    }
}

/// How many runs a batch makes, and what they weigh in the combined surface.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct BatchEntry {
    pub(crate) experiments: usize,
    pub(crate) simulations: usize,
    pub(crate) experiment_weight: f64,
    pub(crate) simulation_weight: f64,
}

#[cfg(feature = "global")]
impl BatchEntry {
    /// The settings of a loop with such batches.
    pub(crate) fn settings(&self, model: Model) -> global::Settings {
        let mut settings = global::Settings::new(model, self.experiments, self.simulations);
        settings.experiment_weight = self.experiment_weight;
        settings.simulation_weight = self.simulation_weight;
        settings
    }
}

/// The noise of experiments: its largest share, and the seeds with which it is drawn.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct NoiseEntry {
    /// Of the cost in Chapter 4, of the range of the cost in Chapter 7.
    pub(crate) share: f64,
    pub(crate) first_seed: u64,
    pub(crate) seeds: u64,
}

impl NoiseEntry {
    /// The share and the number of seeds checked.
    pub(crate) fn check(&self) -> Result<()> {
        check_share("noise.share", self.share)?;
        check_seeds("noise.seeds", self.seeds)
    }

    /// So many seeds.
    pub(crate) fn numbers(&self, count: u64) -> Vec<u64> {
        (self.first_seed..self.first_seed.saturating_add(count)).collect()
    }
}
