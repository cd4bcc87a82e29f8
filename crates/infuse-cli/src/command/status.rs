//! `infuse status`: where a campaign stands, in a few lines.

use std::collections::BTreeSet;
use std::path::Path;

use anyhow::Result;
use page::Finding;
use serde_json::{Value, json};

use super::output::Output;
use super::settings;
use crate::campaign::{Campaign, Stage};
use crate::findings::{next, standing};
use crate::folder;
use crate::number::{count, grouped};
use crate::problem::Queue;
use crate::queue::{Stages, stages};
use crate::shell::infuse;
use crate::simulator::identity;

pub(crate) fn status(folder: &Path, why: Option<&str>) -> Result<Output> {
    let mut campaign = folder::read(folder)?;
    let notices = campaign.take_notices();
    let stage = campaign.stage()?;
    let (mut blocks, for_machines) = known(&*campaign)?;
    blocks.push(vec![next(&*campaign, &stage)]);
    let mut text = format!("{}\n", campaign.problem().title);
    for block in &blocks {
        text.push('\n');
        block.iter().for_each(|finding| text.push_str(&finding.to_string()));
    }
    let mut json = for_every_method(&*campaign, &stage);
    if let (Some(json), Value::Object(more)) = (json.as_object_mut(), for_machines) {
        json.extend(more);
    }
    json["findings"] = json!(blocks.concat());
    if let Some(why) = why {
        let why = campaign.why(&settings::all(why, &campaign.problem().region)?)?;
        text = why.to_string();
        json["why"] = json!(why);
    }
    json["notices"] = json!(notices);
    Ok(Output { text, json, notices })
}

/// All that is known, in blocks, but what to do next; and what a machine is told of it.
pub(crate) fn known(campaign: &dyn Campaign) -> Result<(Vec<Vec<Finding>>, Value)> {
    let (known, for_machines) = campaign.status()?;
    let blocks = std::iter::once(vec![standing(campaign)]).chain([in_the_queue(campaign)?]).chain(known);
    Ok((blocks.filter(|block| !block.is_empty()).collect(), for_machines))
}

/// What is waited for from a queue.
fn in_the_queue(campaign: &dyn Campaign) -> Result<Vec<Finding>> {
    let problem = campaign.problem();
    let of_simulations = campaign.submitted().iter().any(|one| !one.is_of_experiments());
    let simulations = if of_simulations { campaign.waits_for_simulations()? } else { BTreeSet::new() };
    let by = identity(&problem.simulator);
    let submitted = campaign.submitted().iter().filter(|one| !one.is_of_experiments() && one.by == by);
    let of_simulations = Waited {
        n: simulations.len(),
        what: "simulation",
        command: "ask",
        queue: problem.simulator.queue().map(|(_, queue)| queue),
        stages: stages(campaign.folder(), submitted, |key| simulations.contains(&key.cell())),
    };
    let experiments = queued_experiments(campaign);
    let submitted = campaign.submitted().iter().filter(|one| one.is_of_experiments());
    let of_experiments = Waited {
        n: experiments.len(),
        what: "experiment",
        command: "run",
        queue: problem.experiment.as_ref().and_then(|experiment| experiment.queue.as_ref()),
        stages: stages(campaign.folder(), submitted, |key| key.id().is_some_and(|id| experiments.contains(&id))),
    };
    let both = [of_simulations, of_experiments];
    Ok(both.iter().filter(|waited| waited.n > 0).map(|waited| waited.in_words(&infuse(campaign.folder()))).collect())
}

/// Runs that were given to a queue, without a result in the journal.
struct Waited<'a> {
    n: usize,
    what: &'a str,
    /// The command that waits for them.
    command: &'a str,
    queue: Option<&'a Queue>,
    stages: Stages,
}

impl Waited<'_> {
    fn in_words(&self, infuse: &str) -> Finding {
        let Self { n, what, command, queue, stages } = self;
        let stopped = format!("stopped by `{infuse} cancel`");
        let counted = [(stages.n_ended, "ended"), (stages.n_begun, "begun"), (stages.n_stopped, stopped.as_str())];
        let counted =
            counted.iter().filter(|(n, _)| *n > 0).map(|(n, stage)| format!("{} {stage}", grouped(*n as u64)));
        let counted = counted.collect::<Vec<_>>().join(", ");
        let counted = if counted.is_empty() { "none of them begun".to_owned() } else { counted };
        let is_cancellable =
            queue.is_some_and(|queue| !queue.cancel.is_empty()) && stages.n_stopped + stages.n_ended < *n;
        let stops =
            if is_cancellable { format!(", `{infuse} cancel` stops those in the queue") } else { String::new() };
        let sentence = format!(
            "{} in the queue or to be queued, {counted}: `{infuse} {command}` takes what has ended and waits for the \
             others{stops}.",
            count(*n, what)
        );
        Finding::new(sentence)
            .with(&format!("{what}s waited for"), *n as f64, "1")
            .with(&format!("{what}s ended"), stages.n_ended as f64, "1")
            .with(&format!("{what}s begun"), stages.n_begun as f64, "1")
            .with(&format!("{what}s stopped"), stages.n_stopped as f64, "1")
    }
}

/// Experiments without a result that were given to a queue.
fn queued_experiments(campaign: &dyn Campaign) -> BTreeSet<u64> {
    let experiments = campaign.experiments();
    let is_waited_for = |id: &u64| experiments.trials.get(id).is_some_and(|trial| !experiments.has_result(trial.id));
    let submitted = campaign.submitted().iter().flat_map(|one| one.experiments.iter().copied());
    submitted.filter(is_waited_for).collect()
}

fn for_every_method(campaign: &dyn Campaign, stage: &Stage) -> Value {
    let (problem, response, experiments) = (campaign.problem(), &campaign.problem().response, campaign.experiments());
    let (name, stopped) = match stage {
        Stage::Ready => ("ready", None),
        Stage::Pending => ("pending", None),
        Stage::Ended { reason, .. } => ("ended", Some(reason)),
    };
    json!({
        "title": problem.title,
        "response": { "name": response.name, "unit": response.unit, "better": response.better(), "scale": response.scale },
        "stage": name,
        "stopped": stopped,
        "best_measured": experiments.best_measured(response).map(|(id, value)| json!({ "id": id, "value": value })),
        "outstanding": experiments.n_outstanding(),
        "told": experiments.n_made(),
        "imported": campaign.imported().len(),
        "worth": problem.worth,
    })
}
