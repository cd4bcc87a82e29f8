//! `infuse cancel`: stops the simulations that are in the queue.

use std::path::Path;
use std::time::Duration;

use anyhow::{Context as _, Result};
use page::Finding;
use serde_json::json;

use super::Output;
use crate::folder;
use crate::number::count;
use crate::problem::PROBLEM;
use crate::queue;
use crate::shell::infuse;

pub(crate) fn cancel(folder: &Path, wait: Duration) -> Result<Output> {
    let (mut campaign, _writer) = folder::open(folder, wait)?;
    let notices = campaign.take_notices();
    let (_, scheduler) =
        campaign.problem().simulator.queue().with_context(|| format!("{PROBLEM} has no [simulator.queue]"))?;
    let n = queue::cancel(folder, scheduler, campaign.submitted())?;
    let sentence = match n {
        0 => "Nothing of this campaign is in the queue.".to_owned(),
        n => format!(
            "Stopped: {}. What was finished counts; `{} ask` submits the others again.",
            count(n, "submission"),
            infuse(folder)
        ),
    };
    Ok(Output::new(&[Finding::new(sentence).with("submissions", n as f64, "1")], json!({ "stopped": n }), notices))
}
