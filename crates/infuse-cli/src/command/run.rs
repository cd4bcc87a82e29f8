//! `infuse run`: the loop, closed by itself.

use std::path::Path;
use std::time::Duration;

use anyhow::{Result, bail};
use page::Finding;
use serde_json::json;

use super::made::make;
use super::output::Output;
use crate::campaign::{Stage, Wish};
use crate::findings::ended;
use crate::folder;
use crate::number::count;
use crate::problem::PROBLEM;
use crate::shell::infuse;

pub(crate) fn run(folder: &Path, wait: Duration, most: Option<usize>, anyway: bool) -> Result<Output> {
    let (mut campaign, mut writer) = folder::open(folder, wait)?;
    let mut notices = campaign.take_notices();
    if campaign.problem().experiment.is_none() {
        bail!(
            "{PROBLEM} has no [experiment] with a `command`: `infuse ask` and `infuse tell` are for experiments that people make"
        );
    }
    let (mut findings, mut n_experiments) = (Vec::new(), 0);
    let n_before = campaign.n_closed();
    let stage = loop {
        let n_closed = campaign.n_closed();
        if most.is_some_and(|most| n_closed - n_before >= most) {
            break campaign.stage()?;
        }
        // A whole batch has shown it.
        if !anyway
            && campaign.n_closed() > 0
            && let Some((n, reason)) = campaign.nothing_but_failures()
        {
            bail!(
                "not one of {} gave a value; the first one: {reason}\nRepair the command of [experiment], or go on all the same: \
                 {} run --anyway. All of it is written down; `infuse undo` takes results back",
                count(n, "run"),
                infuse(folder)
            );
        }
        notices.extend(campaign.hand_out(&mut writer, Wish { anyway, more: false })?.notices);
        match campaign.stage()? {
            Stage::Pending => n_experiments += make(&mut *campaign, &mut writer)?,
            stage => break stage,
        }
        if campaign.n_closed() > n_closed {
            findings.extend(campaign.closed()?);
        }
    };
    let stopped = match &stage {
        Stage::Ended { reason, .. } => Some(reason.clone()),
        _ => None,
    };
    findings.push(stopped.as_deref().map_or_else(|| so_far(folder, campaign.n_closed() - n_before), ended));
    let json = json!({
        "experiments_made": n_experiments, "batches_closed": campaign.n_closed(),
        "stopped": stopped,
    });
    Ok(Output::new(&findings, json, notices))
}

/// What was done of a campaign that has not ended.
fn so_far(folder: &Path, n_closed: usize) -> Finding {
    let sentence = format!("{} made; {} run goes on.", count(n_closed, "batch"), infuse(folder));
    Finding::new(sentence).with("batches made", n_closed as f64, "1")
}
