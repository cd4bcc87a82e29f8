//! Problems with known answers.

use design_space::{Parameter, Region};
use infuse::codesign::{OptimizerSettings, Strategy};
use infuse::{CodesignProblem, Outcome, Role, gradient};

/// Parameters named p0, p1, ... with these bounds.
pub(crate) fn region(bounds: &[(f64, f64)]) -> Region {
    let parameter = |(index, &(lower, upper)): (usize, &(f64, f64))| {
        Parameter::continuous(format!("p{index}"), "m", lower, upper).unwrap()
    };
    Region::new(bounds.iter().enumerate().map(parameter).collect()).unwrap()
}

/// One plant parameter and one controller parameter with the same bounds.
pub(crate) fn pair(lower: f64, upper: f64) -> CodesignProblem {
    let region = region(&[(lower, upper); 2]);
    CodesignProblem::new(region, vec![Role::Plant, Role::Controller]).unwrap()
}

/// One plant parameter.
pub(crate) fn single(lower: f64, upper: f64) -> CodesignProblem {
    CodesignProblem::new(region(&[(lower, upper)]), vec![Role::Plant]).unwrap()
}

pub(crate) fn optimizer(strategy: Strategy) -> OptimizerSettings {
    let mut settings = OptimizerSettings::default();
    settings.strategy = strategy;
    settings
}

/// A loop over one parameter that never stops by itself before `max_iterations`.
pub(crate) fn single_settings(trust: f64, step: f64, max_iterations: usize) -> gradient::Settings {
    let mut settings = gradient::Settings::new(vec![trust], vec![step]);
    settings.optimizer = optimizer(Strategy::Simultaneous);
    settings.optimizer.final_radius = 1e-8;
    settings.tolerances = Some(vec![2e-7]);
    settings.max_iterations = max_iterations;
    settings
}

/// curvature/2 (p − optimum)² + lowest.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Parabola {
    pub(crate) curvature: f64,
    pub(crate) optimum: f64,
}

impl Parabola {
    pub(crate) fn cost(self, point: &[f64]) -> f64 {
        0.5 * self.curvature * (point[0] - self.optimum).powi(2) + 3.0
    }

    pub(crate) fn slope(self, point: f64) -> f64 {
        self.curvature * (point - self.optimum)
    }
}

/// A biased pair in two parameters, coupled: the simulation has its optimum elsewhere.
pub(crate) fn simulated(p: &[f64]) -> Result<f64, String> {
    Ok((p[0] - 0.3).powi(2) + 2.0 * (p[1] - 0.5 * p[0]).powi(2) + 1.0)
}

/// The experiment of that pair, optimum at (0.7, −0.2).
pub(crate) fn measured(p: &[f64]) -> Result<f64, String> {
    Ok(1.4 * (p[0] - 0.7).powi(2) + (p[1] + 0.2).powi(2) + 0.3 * (p[0] - 0.7) * (p[1] + 0.2) + 2.0)
}

pub(crate) fn pair_loop() -> gradient::Loop {
    let problem = pair(-1.0, 1.0);
    let settings = gradient::Settings::new(problem.per_role(0.5, 0.8), vec![0.1, 0.05]);
    gradient::Loop::new(problem, settings).unwrap()
}

#[track_caller]
pub(crate) fn trials(ask: gradient::Ask) -> Vec<gradient::Trial> {
    match ask {
        gradient::Ask::Trials(trials) => trials,
        gradient::Ask::Stopped(reason) => panic!("the campaign has stopped: {reason:?}"),
    }
}

pub(crate) fn failed(reason: &str) -> Outcome {
    Outcome::Failed { reason: reason.to_owned() }
}

pub(crate) fn json(campaign: &gradient::Loop) -> String {
    serde_json::to_string(campaign).unwrap()
}
