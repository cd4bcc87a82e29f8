//! `infuse ask`: the next experiments.

use std::path::Path;
use std::time::Duration;

use anyhow::{Context as _, Result, bail, ensure};
use page::Finding;
use serde_json::json;

use super::output::Output;
use super::taken_back::still_in_the_sheet;
use crate::campaign::{Campaign, Stage, Wish};
use crate::findings::{after_the_end, ended, handed_out};
use crate::folder;
use crate::journal::{Event, Journal, Writer, now};
use crate::number::count;
use crate::problem::PROBLEM;
use crate::sheet;
use crate::sheet::check_ending;
use crate::shell::{infuse, kept_name, sheet_path};

pub(crate) fn ask(folder: &Path, wait: Duration, sheet: Option<&Path>, wish: Wish, resimulate: bool) -> Result<Output> {
    sheet.map_or(Ok(()), check_ending)?;
    let (mut campaign, mut writer) = folder::open(folder, wait)?;
    let mut notices = campaign.take_notices();
    if resimulate {
        ensure!(campaign.problem().simulator.is_there(), "--resimulate: {PROBLEM} has no [simulator]");
        if campaign.stage()? == Stage::Pending {
            let stand = "the simulations of the batch that is open stand; the next batch simulates everything again";
            notices.push(stand.to_owned());
        }
        campaign.record(&mut writer, vec![Event::Discarded { at: now() }])?;
    }
    let before = campaign.experiments().last_batch();
    let ran = campaign.hand_out(&mut writer, wish)?;
    notices.extend(ran.notices);
    match campaign.stage()? {
        Stage::Ended { may_go_on: false, .. } if wish.anyway && campaign.n_closed() >= campaign.budget()?.batches => {
            bail!(
                "--anyway: all {} that `batches` in [loop] allows are made; raise it in {PROBLEM} to go on",
                count(campaign.budget()?.batches, "batch")
            )
        }
        Stage::Ended { reason, may_go_on } => nothing_to_run(&*campaign, &reason, may_go_on, notices),
        _ => {
            let is_new = campaign.experiments().last_batch() != before;
            waiting((&mut *campaign, &mut writer), (sheet, is_new), ran.n_simulated, notices)
        }
    }
}

/// The experiments of the last batch, which are waited for; it may be new.
pub(super) fn waiting(
    (campaign, writer): (&mut dyn Campaign, &mut Writer),
    (sheet, batch_is_new): (Option<&Path>, bool),
    n_simulated: usize,
    mut notices: Vec<String>,
) -> Result<Output> {
    let batch = campaign.experiments().last_batch().context("no experiment was handed out")?;
    let (problem, experiments) = (campaign.problem(), campaign.experiments());
    let trials = experiments.in_run_order(batch, problem.seed);
    let path = sheet_path(campaign.folder(), problem.sheets, batch, sheet);
    let is_new = !path.exists();
    if is_new {
        sheet::write(&path, problem, &trials)?;
    } else {
        sheet::check_same(&path, problem, &trials)
            .with_context(|| format!("batch {batch} is chosen and written down, but has no sheet yet"))?;
        notices.extend(still_in_the_sheet(campaign, &Journal::read(campaign.folder())?, &path));
    }
    note_where_it_is(campaign, writer, batch, &path, batch_is_new)?;
    let (problem, experiments) = (campaign.problem(), campaign.experiments());
    let findings = handed_out(campaign, batch, &path, is_new, n_simulated);
    let rows = trials.iter().enumerate().map(|(index, (trial, repeats))| {
        json!({
            "run": index + 1, "id": trial.id, "repeats": repeats, "told": experiments.has_result(trial.id),
            "settings": problem.named(&trial.point),
        })
    });
    let json = json!({
        "batch": batch, "sheet": path, "sheet_is_new": is_new, "simulations_made": n_simulated,
        "experiments": rows.collect::<Vec<_>>(),
    });
    Ok(Output::new(&findings, json, notices))
}

/// Writes down where the sheet is, where that does not follow from the batch; with it the one of the usual name, if that was handed out
/// before.
fn note_where_it_is(
    campaign: &mut dyn Campaign,
    writer: &mut Writer,
    batch: usize,
    path: &Path,
    batch_is_new: bool,
) -> Result<()> {
    let folder = campaign.folder();
    let usual = sheet_path(folder, campaign.problem().sheets, batch, None);
    let (Some(name), Some(usual_name)) = (kept_name(folder, path), kept_name(folder, &usual)) else { return Ok(()) };
    let noted = campaign.experiments().sheets_of(batch);
    if noted.contains(&name) || (noted.is_empty() && name == usual_name) {
        return Ok(());
    }
    let usual_name = (noted.is_empty() && !batch_is_new && usual.exists()).then_some(usual_name);
    let note = |path: String| Event::Sheet { batch, path, at: now() };
    campaign.record(writer, usual_name.into_iter().chain([name]).map(note).collect())
}

/// Why there is nothing to run.
fn nothing_to_run(campaign: &dyn Campaign, reason: &str, may_go_on: bool, notices: Vec<String>) -> Result<Output> {
    let infuse = infuse(campaign.folder());
    let mut findings = vec![ended(reason)];
    let (best, point) = campaign.recommendation()?.unzip();
    findings.extend(best);
    if may_go_on {
        findings.push(Finding::new(format!("To go on all the same: {infuse} ask --anyway")));
    }
    findings.push(
        after_the_end(campaign)
            .unwrap_or_else(|| Finding::new(format!("All about it: {infuse} status, {infuse} report"))),
    );
    let best = point.map(|point| campaign.problem().named(&point));
    Ok(Output::new(&findings, json!({ "stopped": reason, "best": best }), notices))
}
