//! `infuse run`: the loop, closed by itself.

use std::path::Path;
use std::time::Duration;

use anyhow::{Context as _, Result, bail};
use page::Finding;
use serde_json::json;

use super::Output;
use super::ask::hand_out;
use crate::campaign::{Campaign, Stage};
use crate::findings::{closed, ended, reason_to_stop};
use crate::journal::{Event, Measured, Writer, now};
use crate::number::count;
use crate::problem::PROBLEM;
use crate::program::Ran;
use crate::shell::{infuse, sheet_path};

pub(crate) fn run(folder: &Path, wait: Duration, most: Option<usize>, anyway: bool) -> Result<Output> {
    let (mut campaign, mut writer) = Campaign::open(folder, wait)?;
    let mut notices = std::mem::take(&mut campaign.notices);
    if campaign.problem.experiment.is_none() {
        bail!(
            "{PROBLEM} has no [experiment] with a `command`: `infuse ask` and `infuse tell` are for experiments that people make"
        );
    }
    let (mut findings, mut n_experiments) = (Vec::new(), 0);
    let n_before = campaign.now.reports().len();
    let stage = loop {
        let n_closed = campaign.now.reports().len();
        if most.is_some_and(|most| n_closed - n_before >= most) {
            break campaign.stage()?;
        }
        notices.extend(hand_out(folder, &mut campaign, &mut writer, anyway)?.notices);
        match campaign.stage()? {
            Stage::Pending => n_experiments += experiment(folder, &mut campaign, &mut writer)?,
            stage => break stage,
        }
        findings.extend(campaign.now.reports().get(n_closed).map(|report| closed(&campaign, report)));
    };
    findings.push(ended(&campaign, &stage).unwrap_or_else(|| {
        let n_closed = campaign.now.reports().len() - n_before;
        Finding::new(format!("{} made; {} run goes on.", count(n_closed, "batch"), infuse(folder))).with(
            "batches made",
            n_closed as f64,
            "1",
        )
    }));
    let json = json!({
        "experiments_made": n_experiments, "batches_closed": campaign.now.reports().len(),
        "stopped": reason_to_stop(&campaign, &stage),
    });
    Ok(Output::new(&findings, json, notices))
}

/// Makes the experiments that are waited for, one after the other, and writes each down at once.
fn experiment(folder: &Path, campaign: &mut Campaign, writer: &mut Writer) -> Result<usize> {
    let program = campaign.problem.experiment.clone().context("an experiment")?;
    let batch = campaign.batch();
    let path = sheet_path(folder, batch, None);
    let trials = campaign.in_run_order(batch);
    if !path.exists() {
        crate::sheet::write(&path, &campaign.problem, &trials)?;
    }
    let mut n_made = 0;
    for (trial, _) in trials {
        if campaign.is_told(trial.id) {
            continue;
        }
        let id = trial.id.number();
        let result = match program.run(folder, &campaign.problem.region, &trial.point, Some(id))? {
            Ran::Value(value) => match campaign.problem.response.fault(value) {
                Some(expected) => Measured::Failed(format!("it returned {value}, expected {expected}")),
                None => Measured::Value(value),
            },
            Ran::Failed(reason) => Measured::Failed(reason),
            Ran::Interrupted => bail!("interrupted: the results so far are written down, run again to go on"),
        };
        let (actual, note) = (std::collections::BTreeMap::new(), String::new());
        let (from, at) = ("infuse run".to_owned(), now());
        let told = Event::Told { row: 1, rows: 1, id, result, actual, repeat: 0, corrects: false, note, from, at };
        campaign.record(writer, vec![told])?;
        n_made += 1;
    }
    Ok(n_made)
}
