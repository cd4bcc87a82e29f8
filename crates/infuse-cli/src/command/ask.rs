//! `infuse ask`: the next experiments.

use std::path::Path;
use std::time::Duration;

use anyhow::{Result, bail};
use indicatif::{ProgressBar, ProgressStyle};
use infuse::{Error, global};
use page::Finding;
use serde_json::{Map, Value, json};

use super::Output;
use crate::campaign::{Campaign, Stage};
use crate::findings::{best_design, ended, handed_out, reason_to_stop};
use crate::journal::{Event, Measured, Writer, now};
use crate::number::{count, rounded};
use crate::shell::{infuse, sheet_path};
use crate::simulator::{identity, simulate};
use crate::{program, sheet};

/// Plans that fail because their simulations do, one after the other, before a person is asked.
const ATTEMPTS: usize = 5;

pub(crate) fn ask(
    folder: &Path,
    wait: Duration,
    sheet: Option<&Path>,
    anyway: bool,
    resimulate: bool,
) -> Result<Output> {
    let (mut campaign, mut writer) = Campaign::open(folder, wait)?;
    let mut notices = std::mem::take(&mut campaign.notices);
    if resimulate {
        if campaign.stage()? == Stage::Pending {
            let stand = "the simulations of the batch that is open stand; the next batch simulates everything again";
            notices.push(stand.to_owned());
        }
        campaign.record(&mut writer, vec![Event::Discarded { at: now() }])?;
    }
    let ran = hand_out(folder, &mut campaign, &mut writer, anyway)?;
    notices.extend(ran.notices);
    match campaign.stage()? {
        Stage::Pending => pending(folder, &campaign, sheet, ran.n_simulated, notices),
        stage => Ok(nothing_to_run(&campaign, &stage, folder, notices)),
    }
}

/// What had to be done before experiments could be handed out.
#[derive(Debug, Default)]
pub(crate) struct HandedOut {
    n_simulated: usize,
    pub(crate) notices: Vec<String>,
}

/// Brings the campaign to the point where experiments are waited for, or to its end.
pub(crate) fn hand_out(folder: &Path, campaign: &mut Campaign, writer: &mut Writer, anyway: bool) -> Result<HandedOut> {
    let mut done = HandedOut::default();
    let by = identity(&campaign.problem.simulator);
    for _ in 0..ATTEMPTS {
        match campaign.stage()? {
            Stage::Ready => {}
            Stage::NotWorth { .. } if anyway => {}
            _ => return Ok(done),
        }
        let searching = ProgressBar::new_spinner().with_message(format!("designing batch {}", campaign.batch()));
        searching.enable_steady_tick(std::time::Duration::from_millis(200));
        let planning = campaign.planning()?;
        searching.finish_and_clear();
        campaign.record(writer, planning.into_iter().collect())?;
        let n_failed = simulate_missing(folder, campaign, writer, &by, &mut done)?;
        if n_failed > 0 {
            done.notices.push(format!("{} failed; the journal says why", count(n_failed, "simulation")));
        }
        let batch = campaign.batch();
        campaign.failed_opening = None;
        campaign.record(writer, vec![Event::Opened { batch, at: now() }])?;
        match campaign.failed_opening.take() {
            None => return Ok(done),
            Some(error @ Error::EverySimulationFailed { .. }) => {
                bail!("{error}\nRepair the simulator and ask again: nothing is lost");
            }
            Some(error) => done.notices.push(format!("{error}; other points are simulated instead")),
        }
    }
    bail!(
        "{ATTEMPTS} designs in a row could not be simulated; repair the simulator or narrow the bounds, and ask again"
    )
}

fn simulate_missing(
    folder: &Path,
    campaign: &mut Campaign,
    writer: &mut Writer,
    by: &str,
    done: &mut HandedOut,
) -> Result<usize> {
    let missing = campaign.missing_simulations(by)?;
    if missing.is_empty() {
        return Ok(0);
    }
    let bar = ProgressBar::new(missing.len() as u64);
    let style = ProgressStyle::with_template("simulations {bar:30} {pos}/{len}, {eta} left");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar.tick();
    let (problem, grid) = (campaign.problem.clone(), campaign.now.clone());
    let (mut n_done, mut n_failed) = (0, 0);
    let outcome = simulate(folder, &problem, &grid, &missing, |(cell, point), result| {
        n_failed += usize::from(matches!(result, Measured::Failed(_)));
        let event = Event::Simulated {
            cell: *cell,
            point: point.iter().copied().map(rounded).collect(),
            result,
            by: by.to_owned(),
        };
        campaign.record_simulation(writer, event)?;
        n_done += 1;
        bar.inc(1);
        Ok(())
    });
    bar.finish_and_clear();
    done.n_simulated += n_done;
    outcome?;
    if program::INTERRUPTED.load(std::sync::atomic::Ordering::Relaxed) {
        bail!("interrupted: {n_done} of {} are remembered, ask again to go on", count(missing.len(), "simulation"));
    }
    Ok(n_failed)
}

/// The experiments that are waited for.
fn pending(
    folder: &Path,
    campaign: &Campaign,
    sheet: Option<&Path>,
    n_simulated: usize,
    notices: Vec<String>,
) -> Result<Output> {
    let batch = campaign.batch();
    let trials = campaign.in_run_order(batch);
    let path = sheet_path(folder, batch, sheet);
    let is_new = !path.exists();
    if is_new {
        sheet::write(&path, &campaign.problem, &trials)?;
    }
    let findings = handed_out(campaign, folder, &path, is_new, n_simulated);
    let rows = trials.iter().enumerate().map(|(index, (trial, repeats))| {
        json!({
            "run": index + 1, "id": trial.id, "repeats": repeats, "told": campaign.is_told(trial.id),
            "settings": settings(campaign, trial),
        })
    });
    let json = json!({
        "batch": batch, "sheet": path, "sheet_is_new": is_new, "simulations_made": n_simulated,
        "experiments": rows.collect::<Vec<_>>(),
    });
    Ok(Output::new(&findings, json, notices))
}

/// By name, as numbers people would write.
pub(crate) fn settings(campaign: &Campaign, trial: &global::Trial) -> Value {
    let pairs = campaign.problem.names().zip(&trial.point);
    Value::Object(pairs.map(|(name, &value)| (name.to_owned(), json!(rounded(value)))).collect::<Map<_, _>>())
}

/// Why there is nothing to run.
fn nothing_to_run(campaign: &Campaign, stage: &Stage, folder: &Path, notices: Vec<String>) -> Output {
    let infuse = infuse(folder);
    let has_learned = *stage != Stage::Ended(infuse::global::StopReason::NoInformation);
    let mut findings: Vec<Finding> = ended(campaign, stage).into_iter().collect();
    findings.extend(best_design(campaign).filter(|_| has_learned));
    if let Stage::NotWorth { .. } = stage {
        findings.push(Finding::new(format!("To go on all the same: {infuse} ask --anyway")));
    }
    findings.push(Finding::new(format!("All about it: {infuse} status, {infuse} report")));
    let best = campaign.now.reports().last().map(|report| campaign.problem.named(&report.screening.optimum));
    Output::new(&findings, json!({ "stopped": reason_to_stop(campaign, stage), "best": best }), notices)
}
