//! A batch chosen on results that were made up, to see how long that takes.

use std::time::{Duration, Instant};

use anyhow::Result;
use infuse::Outcome;
use infuse::pooled::{Ask, Loop, Settings};

use super::campaign::busy;
use crate::problem::Problem;

/// From the results of one batch, which fall and rise with every parameter; nothing is simulated for it.
pub(super) fn dry_pick(problem: &Problem, settings: &Settings) -> Result<Duration> {
    let mut settings = settings.clone();
    (settings.simulations, settings.worth) = (None, None);
    settings.max_batches = 100;
    let mut made_up = Loop::new(&problem.region, settings)?;
    let Ask::Run { trials, .. } = made_up.ask_more(None)? else { return Ok(Duration::ZERO) };
    for trial in trials {
        let coded = problem.region.coded(&trial.point)?;
        let value: f64 = coded.iter().enumerate().map(|(place, x)| (x - 0.2).powi(2) + 0.1 * x * place as f64).sum();
        made_up.tell(trial.id, Outcome::Value(value))?;
        made_up.tell_constrained(trial.id, &vec![Some(value); problem.constraints.len()])?;
    }
    let choosing = busy("trying how long it takes to choose a batch".to_owned());
    let start = Instant::now();
    made_up.ask_more(None)?;
    choosing.finish_and_clear();
    Ok(start.elapsed())
}
