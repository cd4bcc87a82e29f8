//! `infuse cancel`: stops the simulations and experiments that are in a queue.

use std::path::Path;
use std::time::Duration;

use anyhow::{Result, ensure};
use page::Finding;
use serde_json::json;

use super::output::Output;
use crate::folder;
use crate::number::count;
use crate::problem::PROBLEM;
use crate::queue;
use crate::shell::infuse;

pub(crate) fn cancel(folder: &Path, wait: Duration) -> Result<Output> {
    let (mut campaign, _writer) = folder::open(folder, wait)?;
    let notices = campaign.take_notices();
    let problem = campaign.problem();
    let of_simulations = problem.simulator.queue().map(|(_, queue)| (queue, false, "ask"));
    let of_experiments = problem.experiment.as_ref().and_then(|one| Some((one.queue.as_ref()?, true, "run")));
    ensure!(
        of_simulations.is_some() || of_experiments.is_some(),
        "{PROBLEM} has no [simulator.queue] and no [experiment.queue]"
    );
    let (mut n, mut again) = (0, Vec::new());
    for (scheduler, is_of_experiments, command) in [of_simulations, of_experiments].into_iter().flatten() {
        let submitted = campaign.submitted().iter().filter(|one| one.is_of_experiments() == is_of_experiments);
        let n_stopped = queue::cancel(folder, scheduler, submitted)?;
        if n_stopped > 0 {
            n += n_stopped;
            again.push(format!("`{} {command}`", infuse(folder)));
        }
    }
    let sentence = match n {
        0 => "Nothing of this campaign is in the queue.".to_owned(),
        n => format!(
            "Stopped: {}. What was finished counts; {} submits the others again.",
            count(n, "submission"),
            again.join(" or ")
        ),
    };
    Ok(Output::new(&[Finding::new(sentence).with("submissions", n as f64, "1")], json!({ "stopped": n }), notices))
}
