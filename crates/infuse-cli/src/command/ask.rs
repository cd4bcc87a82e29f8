//! `infuse ask`: the next experiments.

use std::fmt::Write as _;
use std::path::Path;
use std::time::Duration;

use anyhow::{Result, bail};
use indicatif::{ProgressBar, ProgressStyle};
use infuse::{Error, global};
use serde_json::{Map, Value, json};

use super::Output;
use super::shell::{sheet_path, tell_with};
use crate::campaign::{Campaign, Stage};
use crate::findings::reason_to_stop;
use crate::journal::{Event, Measured, Writer, now};
use crate::number::{count, rounded};
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
        stage => Ok(ended(&campaign, &stage, notices)),
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
    let n_told = trials.iter().filter(|(trial, _)| campaign.is_told(trial.id)).count();
    let n_repeats = trials.iter().filter(|(_, repeats)| repeats.is_some()).count();
    let response = &campaign.problem.response;
    let mut text = String::new();
    let repeats =
        if n_repeats > 0 { format!(", {n_repeats} of them repeats that measure the noise") } else { String::new() };
    let _ = writeln!(text, "Batch {batch}: {}{repeats}.", count(trials.len(), "experiment"));
    if n_simulated > 0 {
        let _ = writeln!(text, "{} made for it.", plural_was(n_simulated, "simulation"));
    }
    let purpose = if batch == 1 {
        "It is the first: spread over all that can be set, it shows where the simulation is wrong."
    } else {
        "It is spread over the designs that are left, so that the surface is known best where the optimum may be."
    };
    let _ = writeln!(text, "{purpose}");
    if n_told > 0 {
        let _ = writeln!(text, "Results so far: {n_told}; {} to go.", trials.len() - n_told);
    }
    let place = path.display();
    let _ = if is_new {
        writeln!(text, "Written to {place}, in the order in which to run them.")
    } else {
        writeln!(text, "They are in {place}, which was there already and is left as it is.")
    };
    let _ = writeln!(
        text,
        "Run them, fill in `{}` (or, for a run without a result, the reason under `failed`), then: {}",
        response.heading(),
        tell_with(folder, &path),
    );
    let rows = trials.iter().enumerate().map(|(index, (trial, repeats))| {
        json!({
            "run": index + 1, "id": trial.id, "repeats": repeats, "told": campaign.is_told(trial.id),
            "settings": settings(campaign, trial),
        })
    });
    let json = json!({
        "batch": batch, "sheet": path, "sheet_is_new": is_new, "simulations_made": n_simulated,
        "experiments": rows.collect::<Vec<_>>(), "notices": notices,
    });
    Ok(Output { text, json, notices })
}

fn plural_was(n: usize, noun: &str) -> String {
    format!("{} {}", count(n, noun), if n == 1 { "was" } else { "were" })
}

/// By name, as numbers people would write.
pub(crate) fn settings(campaign: &Campaign, trial: &global::Trial) -> Value {
    let pairs = campaign.problem.names().zip(&trial.point);
    Value::Object(pairs.map(|(name, &value)| (name.to_owned(), json!(rounded(value)))).collect::<Map<_, _>>())
}

/// Why there is nothing to run.
fn ended(campaign: &Campaign, stage: &Stage, notices: Vec<String>) -> Output {
    let reason = reason_to_stop(campaign, stage).unwrap_or_default();
    let best = campaign.now.reports().last().map(|report| report.screening.optimum.clone());
    let mut text = format!("No more experiments: {reason}.\n");
    let has_learned = *stage != Stage::Ended(infuse::global::StopReason::NoInformation);
    if let Some(best) = best.as_ref().filter(|_| has_learned) {
        let _ = writeln!(text, "The best design is {}.", campaign.problem.describe(best));
    }
    if let Stage::NotWorth { .. } = stage {
        let _ = writeln!(text, "To go on all the same: infuse ask --anyway");
    }
    let _ = writeln!(text, "All about it: infuse status, infuse report");
    Output {
        text,
        json: json!({ "stopped": reason, "best": best.map(|best| campaign.problem.named(&best)), "notices": notices }),
        notices,
    }
}
