//! A batch chosen on results that were made up, to see how long that takes.

use std::time::{Duration, Instant};

use anyhow::Result;
use design_space::Cell;
use infuse::Outcome;
use infuse::pooled::{Ask, Loop, Responses, Settings};

use crate::campaign::busy;
use crate::problem::Problem;

/// From the results of one batch, which fall and rise with every parameter; what stands for the simulation, if there is one, costs nothing.
pub(super) fn dry_pick(problem: &Problem, settings: &Settings) -> Result<Duration> {
    let mut settings = settings.clone();
    (settings.simulations, settings.worth) = (None, None);
    settings.max_batches = 100;
    let mut made_up = Loop::new(&problem.region, settings)?;
    let region = problem.region.clone();
    let n_constraints = problem.constraints.len();
    let value = move |point: &[f64], center: f64| -> Result<f64> {
        let coded = region.coded(point)?;
        Ok(coded.iter().enumerate().map(|(place, x)| (x - center).powi(2) + 0.1 * x * place as f64).sum())
    };
    let mut simulate = |_: Cell, point: &[f64]| match value(point, 0.0) {
        Ok(value) => Ok(Responses { cost: value, constrained: vec![Some(value); n_constraints] }),
        Err(error) => Err(error.to_string()),
    };
    let is_simulated = problem.simulator.is_there();
    let mut ask = |made_up: &mut Loop| made_up.ask_more(if is_simulated { Some(&mut simulate) } else { None });
    let Ask::Run { trials, .. } = ask(&mut made_up)? else { return Ok(Duration::ZERO) };
    for trial in trials {
        let value = value(&trial.point, 0.2)?;
        made_up.tell(trial.id, Outcome::Value(value))?;
        made_up.tell_constrained(trial.id, &vec![Some(value); n_constraints])?;
    }
    let choosing = busy("trying how long it takes to choose a batch".to_owned());
    let start = Instant::now();
    ask(&mut made_up)?;
    choosing.finish_and_clear();
    Ok(start.elapsed())
}
