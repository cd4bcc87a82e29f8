//! `infuse run`: the loop, closed by itself.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::Duration;

use anyhow::{Context as _, Result, bail};
use page::Finding;
use serde_json::json;

use super::Output;
use crate::campaign::{Campaign, Stage, Wish};
use crate::findings::ended;
use crate::folder;
use crate::journal::{Event, Measured, Told, Writer, now};
use crate::number::count;
use crate::problem::PROBLEM;
use crate::program::Ran;
use crate::shell::{infuse, sheet_path};

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
        notices.extend(campaign.hand_out(&mut writer, Wish { anyway, more: false })?.notices);
        match campaign.stage()? {
            Stage::Pending => n_experiments += experiment(&mut *campaign, &mut writer)?,
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

/// Makes the experiments that are waited for, one after the other, and writes each down at once.
fn experiment(campaign: &mut dyn Campaign, writer: &mut Writer) -> Result<usize> {
    let (folder, problem) = (campaign.folder().to_path_buf(), campaign.problem().clone());
    let program = problem.experiment.as_ref().context("an experiment")?;
    let last = campaign.experiments().last_batch().unwrap_or(0);
    let mut trials = Vec::new();
    for batch in 1..=last {
        let of_batch = campaign.experiments().in_run_order(batch, problem.seed);
        let waits = of_batch.iter().any(|(trial, _)| !campaign.experiments().is_told(trial.id));
        let path = sheet_path(&folder, problem.sheets, batch, None);
        if waits && !path.exists() {
            crate::sheet::write(&path, &problem, &of_batch)?;
        }
        trials.extend(of_batch);
    }
    let mut n_made = 0;
    for (trial, _) in trials {
        if campaign.experiments().is_told(trial.id) {
            continue;
        }
        let id = trial.id.number();
        let (result, constrained) = match program.run(&folder, &problem.region, &trial.point, Some(id))? {
            Ran::Value(value, others) => match problem.response.fault(value) {
                Some(expected) => {
                    (Measured::Failed(format!("it returned {value}, expected {expected}")), BTreeMap::new())
                }
                None => (Measured::Value(value), problem.of_constraints(others)),
            },
            Ran::Failed(reason) => (Measured::Failed(reason), BTreeMap::new()),
            Ran::Interrupted => bail!("interrupted: the results so far are written down, run again to go on"),
        };
        let (actual, note) = (BTreeMap::new(), String::new());
        let (from, at) = ("infuse run".to_owned(), now());
        let told =
            Told { row: 1, rows: 1, id, result, constrained, actual, repeat: 0, corrects: false, note, from, at };
        campaign.record(writer, vec![Event::Told(told)])?;
        n_made += 1;
    }
    Ok(n_made)
}
