//! `infuse status`: where a campaign stands, in a few lines.

use std::path::Path;

use anyhow::Result;
use page::Finding;
use serde_json::{Value, json};

use super::{Output, settings};
use crate::campaign::{Campaign, Stage};
use crate::findings::{best, best_measured, left, lesson, next, prospects, reason_to_stop, standing, why_dropped};

pub(crate) fn status(folder: &Path, why: Option<&str>) -> Result<Output> {
    let campaign = Campaign::read(folder)?;
    let notices = campaign.notices.clone();
    let stage = campaign.stage()?;
    let blocks = blocks(&campaign, &stage, folder)?;
    let mut text = format!("{}\n", campaign.problem.title);
    for block in &blocks {
        text.push('\n');
        block.iter().for_each(|finding| text.push_str(&finding.to_string()));
    }
    let mut json = as_json(&campaign, &stage)?;
    json["findings"] = json!(blocks.concat());
    if let Some(why) = why {
        let why = why_dropped(&campaign, &settings::all(why, &campaign.problem.region)?)?;
        text = why.to_string();
        json["why"] = json!(why);
    }
    json["notices"] = json!(notices);
    Ok(Output { text, json, notices })
}

/// What is said, in blocks with an empty line between them.
fn blocks(campaign: &Campaign, stage: &Stage, folder: &Path) -> Result<Vec<Vec<Finding>>> {
    let mut blocks = vec![vec![standing(campaign)]];
    if !campaign.now.reports().is_empty() {
        blocks.push(best(campaign).into_iter().collect());
        blocks.push(lesson(campaign).into_iter().collect());
        blocks.push(vec![left(campaign)?]);
        blocks.push(prospects(campaign)?);
    }
    blocks.push(vec![next(campaign, stage, folder)]);
    Ok(blocks)
}

fn as_json(campaign: &Campaign, stage: &Stage) -> Result<Value> {
    let (problem, response) = (&campaign.problem, &campaign.problem.response);
    let named = |point: &[f64]| problem.named(point);
    let batches = campaign.now.reports().iter().map(|report| {
        let screening = &report.screening;
        json!({
            "batch": report.iteration, "best": named(&screening.optimum),
            "predicted": response.cost(screening.optimum_value), "spread": screening.spread.s(),
            "left": screening.n_after, "left_before": screening.n_before, "threshold": screening.threshold,
            "innovation": report.changes.innovation, "failed_experiments": report.failed_trials().count(),
            "failed_simulations": report.failed_simulations().count(),
            "g_efficiency_percent": report.batch.experiment_efficiency,
            "simulation_alone": named(&screening.simulation_optimum),
        })
    });
    let outlook = campaign.outlook()?;
    let observed = campaign.now.observed_certificate()?;
    let last = campaign.now.reports().last();
    Ok(json!({
        "title": problem.title,
        "response": { "name": response.name, "unit": response.unit, "better": response.better() },
        "stage": match stage { Stage::Ready => "ready", Stage::Pending => "pending", _ => "ended" },
        "stopped": reason_to_stop(campaign, stage),
        "batches": batches.collect::<Vec<_>>(),
        "best": last.map(|report| named(&report.screening.optimum)),
        "simulation_alone": campaign.now.reports().first().map(|first| named(&first.screening.simulation_optimum)),
        "predicted": last.map(|report| response.cost(report.screening.optimum_value)),
        "best_measured": best_measured(campaign).map(|(id, value)| json!({ "id": id, "value": value })),
        "outstanding": campaign.now.outstanding().len(),
        "told": campaign.readings.values().filter(|reading| reading.first.is_some()).count(),
        "imported": campaign.now.earlier().len(),
        "left": campaign.now.retained().n_retained(), "of": campaign.now.retained().n_cells(),
        "noise": campaign.noise().map(|error| json!({
            "standard_deviation": error.standard_deviation(), "degrees_of_freedom": error.degrees_of_freedom,
        })),
        "gain": outlook.map(|outlook| json!({ "total": outlook.total_gain(), "noise": outlook.mean_gain, "misfit": outlook.misfit_gain, "nine_in_ten_below": outlook.upper_gain })),
        "worth": problem.worth,
        "guarantee": observed.map(|observed| json!({ "eps": observed.eps, "regret": observed.certificate.regret })),
    }))
}
