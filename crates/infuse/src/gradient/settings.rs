//! What a person decides before a campaign.

use design_space::Parameter;
use serde::{Deserialize, Serialize};

use crate::checks::check_length;
use crate::codesign::OptimizerSettings;
use crate::correction::Form;
use crate::{CodesignProblem, Error};

/// What happens to a difference step that would leave the region.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BoundPolicy {
    /// It is left out, and the difference is one-sided, from the center.
    #[default]
    StayInside,
    /// It is taken: experiments and simulations may be asked outside the region, by one step at
    /// most.
    StepOutside,
}

/// The settings of a gradient loop: one entry per parameter in each list, in the region's order.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Trust factors R of (27), dimensionless, 0 < R < 2; 0 < R ≤ 1 recommended.
    ///
    /// On quadratics with curvatures H_mod and H_exp the distance to the optimum is multiplied by
    /// 1 − R H_exp/H_mod per iteration, so the loop contracts for R < 2 H_mod/H_exp. At an active
    /// bound the factor is 1 − R whatever the curvatures, hence the limit of 2.
    pub trust: Vec<f64>,
    /// Experiment steps δ, in each parameter's unit: positive, under half the parameter's width.
    pub experiment_steps: Vec<f64>,
    /// Steps of the model's own gradient, in each parameter's unit; when missing, a tenth of the
    /// experiment steps.
    pub model_steps: Option<Vec<f64>>,
    /// Largest move of the optimum that counts as none, in each parameter's unit; when missing, a
    /// tenth of the experiment steps. A small trust factor makes small moves: choose it with R in mind.
    /// It must not be finer than the optimizer can see, which is
    /// [`final_radius`](OptimizerSettings::final_radius) times half the parameter's width.
    pub tolerances: Option<Vec<f64>>,
    /// Largest move of the optimum from one iteration to the next, in each parameter's unit; when
    /// missing, the whole region.
    pub move_limits: Option<Vec<f64>>,
    /// Where the first numerical optimization starts, natural coordinates; when missing, the center
    /// of the region.
    pub start: Option<Vec<f64>>,
    /// What happens to steps that would leave the region.
    #[serde(default)]
    pub bound_policy: BoundPolicy,
    /// How the correction is updated.
    #[serde(default)]
    pub correction_form: Form,
    /// Limit on the iterations. Default 20.
    #[serde(default = "default_max_iterations")]
    pub max_iterations: usize,
    /// How the numerical optimization is done.
    #[serde(default)]
    pub optimizer: OptimizerSettings,
}

fn default_max_iterations() -> usize {
    20
}

/// The fraction of the experiment step that the missing lists stand for.
const TENTH: f64 = 0.1;

impl Settings {
    /// Settings with these trust factors and experiment steps; the rest as documented per field.
    #[must_use]
    pub fn new(trust: Vec<f64>, experiment_steps: Vec<f64>) -> Self {
        Self {
            trust,
            experiment_steps,
            model_steps: None,
            tolerances: None,
            move_limits: None,
            start: None,
            bound_policy: BoundPolicy::default(),
            correction_form: Form::default(),
            max_iterations: default_max_iterations(),
            optimizer: OptimizerSettings::default(),
        }
    }

    /// The model steps in force, in each parameter's unit.
    #[must_use]
    pub fn model_steps(&self) -> Vec<f64> {
        self.or_a_tenth(self.model_steps.as_ref())
    }

    /// The tolerances in force, in each parameter's unit.
    #[must_use]
    pub fn tolerances(&self) -> Vec<f64> {
        self.or_a_tenth(self.tolerances.as_ref())
    }

    fn or_a_tenth(&self, list: Option<&Vec<f64>>) -> Vec<f64> {
        list.cloned().unwrap_or_else(|| {
            let steps = self.experiment_steps.iter();
            steps.map(|step| TENTH * step).collect()
        })
    }

    /// Whether every number is usable for this problem.
    ///
    /// # Errors
    ///
    /// [`Error::WrongLength`], [`Error::ParameterSetting`], [`Error::SettingCount`],
    /// [`Error::Setting`], [`Error::DesignSpace`] for a start outside the region, and
    /// [`Error::NeedsPlantAndController`].
    pub fn validate(&self, problem: &CodesignProblem) -> Result<(), Error> {
        self.optimizer.validate()?;
        let parameters = problem.region().parameters();
        each(parameters, "trust", &self.trust, "0 < R < 2", |_, r| r > 0.0 && r < 2.0)?;
        for (name, steps) in [("experiment_steps", &self.experiment_steps), ("model_steps", &self.model_steps())] {
            let expected = "a step above rounding and under half the parameter's width";
            each(parameters, name, steps, expected, is_usable_step)?;
        }
        let (name, positive) = ("tolerances", "a positive number");
        each(parameters, name, &self.tolerances(), positive, is_positive)?;
        let expected = "at least the optimizer's final_radius times half the parameter's width";
        let final_radius = self.optimizer.final_radius;
        let is_visible = |parameter: &Parameter, length| length >= final_radius * 0.5 * parameter.width();
        each(parameters, name, &self.tolerances(), expected, is_visible)?;
        if let Some(limits) = &self.move_limits {
            let expected = "a length above rounding";
            each(parameters, "move_limits", limits, expected, |parameter, limit| {
                is_above_rounding(parameter, limit) && limit.is_finite()
            })?;
        }
        if self.max_iterations == 0 {
            return Err(Error::SettingCount { name: "max_iterations", value: 0, expected: "at least 1" });
        }
        if let Some(start) = &self.start {
            problem.region().check(start)?;
        }
        problem.check_strategy(self.optimizer.strategy)
    }
}

fn is_positive(_: &Parameter, value: f64) -> bool {
    value > 0.0 && value.is_finite()
}

fn is_usable_step(parameter: &Parameter, step: f64) -> bool {
    is_above_rounding(parameter, step) && step < 0.5 * parameter.width()
}

fn is_above_rounding(parameter: &Parameter, length: f64) -> bool {
    length > 1e-12 * parameter.lower().abs().max(parameter.upper().abs())
}

fn each(
    parameters: &[Parameter],
    name: &'static str,
    values: &[f64],
    expected: &'static str,
    is_usable: impl Fn(&Parameter, f64) -> bool,
) -> Result<(), Error> {
    check_length(name, parameters.len(), values.len())?;
    for (parameter, &value) in parameters.iter().zip(values) {
        if !is_usable(parameter, value) {
            return Err(Error::ParameterSetting { name, parameter: parameter.name().to_owned(), value, expected });
        }
    }
    Ok(())
}
