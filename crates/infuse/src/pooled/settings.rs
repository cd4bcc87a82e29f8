//! The numbers and choices of the pooled loop.

use design_space::Region;
use serde::{Deserialize, Serialize};
use surface::process::{SamplerSettings, Structure};

use crate::Error;
use crate::pooled::constraint::{Constraint, LinearConstraint};
use crate::pooled::plants::Plants;

/// The settings of a pooled loop.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Experiments per batch, at least 1.
    pub n_experiments: usize,
    /// Simulations per batch, where they are dear: the loop then says which to run, and a surface through them stands for the
    /// others. The experiments' own settings are simulated first, and may alone be more; where the simulation is displaced, the
    /// settings that tell of them. Default: the simulation is cheap, and run wherever it is needed, which is at thousands of designs in a
    /// batch, and at tens of thousands where it may be [displaced](Self::displaced): one that takes longer than a millisecond or so is
    /// better called dear.
    #[serde(default)]
    pub simulations: Option<usize>,
    /// Whether the simulation may be displaced: right not of the design that it is asked for but of one that is so much farther along each
    /// axis. By how much is learnt, and believed where the readings are sure of it. Default true.
    #[serde(default = "default_displaced", skip_serializing_if = "is_true")]
    pub displaced: bool,
    /// Limit on the batches. Default 10.
    #[serde(default = "default_max_batches")]
    pub max_batches: usize,
    /// Standard deviation of one reading, in the unit of the response, where it is known; otherwise it is learnt.
    #[serde(default)]
    pub noise: Option<f64>,
    /// The campaign stops once no design is better than the recommended one by more than this, as far as the certificate
    /// goes; in the unit of the response. Default: it does not stop by itself.
    #[serde(default)]
    pub worth: Option<f64>,
    /// What has to be no more than `worth` for that. Default the bound of the certificate.
    #[serde(default, skip_serializing_if = "StopBy::is_bound")]
    pub stop_by: StopBy,
    /// The response is known to have no narrow well: the certificate holds nothing in reserve for one. Default: that is not known.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub smooth: bool,
    /// No response can be less than this: no design is better than the recommended one by more than that may be above it. Default: that is
    /// not known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub least: Option<f64>,
    /// Probability of the certificate, 0.5 to 0.99. Default 0.9.
    #[serde(default = "default_confidence")]
    pub confidence: f64,
    /// Responses that have to stay within bounds, besides the one that is minimized. Default: none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub constraints: Vec<Constraint>,
    /// Settings that go together. Default: all.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub linear_constraints: Vec<LinearConstraint>,
    /// Which parameters are built and not typed, and what another plant costs. Default: all are set anew for every run.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub plants: Option<Plants>,
    /// Number of structures and hyperparameters that are averaged. Default 18.
    #[serde(default = "default_particles")]
    pub particles: usize,
    /// Whether runs of a batch share an error that those of others do not have, as where a rig drifts from day to day; so do those of a
    /// source outside of the campaign, then. Where there are [plants](Self::plants), runs of one in a batch do anyway, and this changes
    /// nothing. Default: as soon as the readings are [sure](crate::pooled::reported::Drift::is_sure) of it, of each response by its own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub blocks: Option<bool>,
    /// The structures that are averaged. Default: all.
    #[serde(default = "default_structures")]
    pub structures: Vec<Structure>,
    /// Everything random follows from this. Default 1.
    #[serde(default = "default_seed")]
    pub seed: u64,
}

/// By which of two numbers a campaign stops.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StopBy {
    /// By the bound of the certificate, which allows for what so few experiments cannot have shown: seldom too early, and seldom before
    /// twenty designs a parameter were run.
    #[default]
    Bound,
    /// By what the surface alone says, and what a find may hide: a batch or two earlier, and too early where the response has a well that
    /// neither a run nor the simulation has met. How often is in `docs/results-benchmark.md`.
    Surface,
}

impl StopBy {
    fn is_bound(&self) -> bool {
        *self == Self::Bound
    }
}

fn default_max_batches() -> usize {
    10
}

fn default_displaced() -> bool {
    true
}

fn is_true(flag: &bool) -> bool {
    *flag
}

fn default_confidence() -> f64 {
    0.9
}

fn default_particles() -> usize {
    18
}

fn default_structures() -> Vec<Structure> {
    Structure::ALL.to_vec()
}

fn default_seed() -> u64 {
    1
}

impl Settings {
    /// Settings with this number of experiments per batch, the rest as documented per field.
    #[must_use]
    pub fn new(n_experiments: usize) -> Self {
        Self {
            n_experiments,
            simulations: None,
            displaced: default_displaced(),
            max_batches: default_max_batches(),
            noise: None,
            worth: None,
            stop_by: StopBy::Bound,
            smooth: false,
            least: None,
            confidence: default_confidence(),
            constraints: Vec::new(),
            linear_constraints: Vec::new(),
            plants: None,
            blocks: None,
            particles: default_particles(),
            structures: default_structures(),
            seed: default_seed(),
        }
    }

    /// How hyperparameters are drawn.
    pub(crate) fn sampler(&self) -> SamplerSettings {
        SamplerSettings {
            structures: self.structures.clone(),
            noise: self.noise,
            particles: self.particles,
            seed: self.seed,
            ..SamplerSettings::default()
        }
    }

    /// How the surface of a constrained response is learnt.
    pub(crate) fn sampler_of(&self, constraint: &Constraint) -> SamplerSettings {
        SamplerSettings { noise: constraint.noise, ..self.sampler() }
    }

    /// Whether every setting is usable in this region.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`], [`Error::SettingCount`], [`Error::Constraint`], [`Error::SecondConstraint`] for two of one name,
    /// [`Error::DesignSpace`] for a linear constraint of a choice.
    pub fn validate(&self, region: &Region) -> Result<(), Error> {
        count("n_experiments", self.n_experiments, 1..=1000, "1 to 1000")?;
        if let Some(simulations) = self.simulations {
            count("simulations", simulations, 2..=10_000, "2 to 10000")?;
        }
        count("max_batches", self.max_batches, 1..=100_000, "1 to 100000")?;
        count("particles", self.particles, 2..=1024, "2 to 1024")?;
        count("structures", self.structures.len(), 1..=1000, "at least one structure")?;
        for constraint in &self.constraints {
            constraint.validate()?;
            let n_times = self.constraints.iter().filter(|other| other.name == constraint.name).count();
            if n_times > 1 {
                return Err(Error::SecondConstraint { constraint: constraint.name.clone(), n_times });
            }
        }
        if let Some(plants) = &self.plants {
            plants.validate(region)?;
        }
        for (index, constraint) in self.linear_constraints.iter().enumerate() {
            constraint.validate(index + 1, region)?;
        }
        for (name, value) in [("noise", self.noise), ("worth", self.worth)] {
            if let Some(value) = value.filter(|value| !(0.0..=1e100).contains(value)) {
                return Err(Error::Setting { name, value, expected: "a number from 0 to 1e100" });
            }
        }
        if let Some(value) = self.least.filter(|value| !(-1e100..=1e100).contains(value)) {
            return Err(Error::Setting { name: "least", value, expected: "a number from -1e100 to 1e100" });
        }
        if (0.5..=0.99).contains(&self.confidence) {
            return Ok(());
        }
        Err(Error::Setting { name: "confidence", value: self.confidence, expected: "0.5 to 0.99" })
    }
}

fn count(
    name: &'static str,
    value: usize,
    allowed: std::ops::RangeInclusive<usize>,
    expected: &'static str,
) -> Result<(), Error> {
    if allowed.contains(&value) { Ok(()) } else { Err(Error::SettingCount { name, value, expected }) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use design_space::Parameter;

    #[test]
    fn defaults_are_those_that_the_fields_name() {
        let settings = Settings::new(7);
        assert_eq!((settings.n_experiments, settings.max_batches, settings.particles, settings.seed), (7, 10, 18, 1));
        assert!((settings.confidence - 0.9).abs() < 1e-15);
        assert_eq!(settings.structures, Structure::ALL);
        let region = Region::new(vec![Parameter::continuous("x", "mm", 0.0, 1.0).unwrap()]).unwrap();
        assert_eq!(settings.validate(&region), Ok(()));
        let with = |change: fn(&mut Settings)| {
            let mut settings = Settings::new(7);
            change(&mut settings);
            settings.validate(&region).is_ok()
        };
        assert!(with(|settings| settings.noise = Some(0.0)) && with(|settings| settings.worth = Some(3.0)));
        assert!(with(|settings| settings.least = Some(-3.0)) && !with(|settings| settings.least = Some(f64::NAN)));
        let two = [Constraint::at_most("travel", 1.0), Constraint::at_least("travel", 0.0)];
        let alike = Settings { constraints: two.to_vec(), ..Settings::new(7) }.validate(&region);
        assert_eq!(alike, Err(Error::SecondConstraint { constraint: "travel".into(), n_times: 2 }));
        assert!(with(|settings| settings.linear_constraints = vec![LinearConstraint::at_most(vec![1.0], 0.5)]));
        assert!(!with(|settings| settings.linear_constraints = vec![LinearConstraint::at_most(vec![1.0], f64::NAN)]));
        assert!(!with(|settings| settings.linear_constraints = vec![LinearConstraint::at_most(Vec::new(), 0.5)]));
        assert!(with(|settings| settings.plants = Some(Plants::at_most(2, vec![0]))));
        assert!(!with(|settings| settings.plants = Some(Plants::at_most(2, vec![1]))));
        assert!(!with(|settings| settings.noise = Some(-1.0)) && !with(|settings| settings.worth = Some(f64::NAN)));
    }
}
