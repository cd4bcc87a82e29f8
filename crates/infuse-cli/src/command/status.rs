//! `infuse status`: where a campaign stands, in a few lines.

use std::fmt::Write as _;
use std::path::Path;

use anyhow::Result;
use infuse::global::{self, ObservedErrors, RetainedSet, Spread};
use serde_json::{Value, json};

use super::{Output, settings};
use crate::campaign::{Campaign, Stage};
use crate::number::{count, grouped, percent, plain, short, with_unit};

/// Lack of fit is said to be there from this probability down.
const SIGNIFICANT: f64 = 0.05;

pub(crate) fn status(folder: &Path, why: Option<&str>) -> Result<Output> {
    let campaign = Campaign::read(folder)?;
    let notices = campaign.notices.clone();
    let stage = campaign.stage()?;
    let mut text = format!("{}\n\n", campaign.problem.title);
    let _ = write!(text, "{}", standing(&campaign));
    if !campaign.now.reports().is_empty() {
        let _ = write!(text, "\n{}\n{}\n{}", best(&campaign)?, lesson(&campaign)?, left(&campaign)?);
        let _ = write!(text, "\n{}", prospects(&campaign)?);
    }
    let _ = write!(text, "\n{}", next(&campaign, &stage, folder));
    let mut json = as_json(&campaign, &stage)?;
    if let Some(why) = why {
        text = why_dropped(&campaign, why)?;
        json["why"] = json!(text);
    }
    json["notices"] = json!(notices);
    Ok(Output { text, json, notices })
}

pub(crate) fn standing(campaign: &Campaign) -> String {
    let (n_closed, n_told) =
        (campaign.now.reports().len(), campaign.readings.values().filter(|r| r.first.is_some()).count());
    let n_failed = campaign.readings.values().filter(|reading| reading.values().count() == 0).count();
    let failed = if n_failed > 0 { format!(", {n_failed} of them without a result") } else { String::new() };
    let mut text = format!("{} closed, {} told{failed}", count(n_closed, "batch"), count(n_told, "experiment"));
    let outstanding = campaign.now.outstanding().len();
    if outstanding > 0 {
        let batch = campaign.batch();
        let n = campaign.in_run_order(batch).len();
        let _ = write!(text, "; batch {batch} waits for {outstanding} of {n}");
    }
    let n_earlier = campaign.now.earlier().len();
    if n_earlier > 0 {
        let _ = write!(text, "; {} imported", count(n_earlier, "earlier experiment"));
    }
    text.push_str(".\n");
    text
}

/// The value of a computed cost, with its unit.
pub(crate) fn value(campaign: &Campaign, cost: f64) -> String {
    let response = &campaign.problem.response;
    with_unit(&short(response.cost(cost)), &response.unit)
}

/// A difference of costs, with its unit.
pub(crate) fn amount(campaign: &Campaign, difference: f64) -> String {
    with_unit(&short(difference), &campaign.problem.response.unit)
}

/// What can be gained, in words if it is nothing.
fn gain(campaign: &Campaign, mean: f64) -> String {
    if mean > 0.0 { amount(campaign, mean) } else { "practically nothing".to_owned() }
}

pub(crate) fn best(campaign: &Campaign) -> Result<String> {
    let (problem, reports) = (&campaign.problem, campaign.now.reports());
    let Some(last) = reports.last() else { return Ok(String::new()) };
    let screening = &last.screening;
    let mut text = format!("Best design: {}.\n", problem.describe(&screening.optimum));
    let sure = match screening.spread {
        Spread::Estimated { s, n_validation } => {
            format!("; {n_validation} experiments that it had not seen were missed by {} (S)", amount(campaign, s))
        }
        _ => "; how sure that is, too few experiments tell".to_owned(),
    };
    let _ = writeln!(
        text,
        "  {} there: {} predicted{sure}.",
        problem.response.name,
        value(campaign, screening.optimum_value)
    );
    if let Some((id, measured)) = best_measured(campaign) {
        let place = problem.describe(&campaign.settings_of(id));
        let _ = writeln!(
            text,
            "  Best measured: {}, experiment {id} at {place}.",
            with_unit(&short(measured), &problem.response.unit)
        );
    }
    let first = &reports[0].screening;
    let _ = writeln!(text, "  The simulation alone would have chosen {}.", problem.describe(&first.simulation_optimum));
    Ok(text)
}

/// The experiment with the best mean, and that.
pub(crate) fn best_measured(campaign: &Campaign) -> Option<(u64, f64)> {
    let response = &campaign.problem.response;
    let means = campaign.readings.iter().filter_map(|(&id, reading)| Some((id, reading.outcome(response)?.cost()?)));
    let (id, cost) = means.min_by(|a, b| a.1.total_cmp(&b.1))?;
    Some((id, response.cost(cost)))
}

/// What the last closed batch taught.
pub(crate) fn lesson(campaign: &Campaign) -> Result<String> {
    let (reports, surfaces) = (campaign.now.reports(), campaign.now.surfaces());
    let Some((report, surfaces)) = reports.last().zip(surfaces.last()) else { return Ok(String::new()) };
    let mut text = format!("Batch {} taught:\n", report.iteration);
    if let Some(innovation) = report.changes.innovation {
        let before = if reports.len() == 1 { "the simulation" } else { "the corrected simulation of the batch before" };
        let _ = writeln!(text, "  {before} was off by up to {}.", amount(campaign, innovation));
    }
    if let Some(reason) = &report.not_corrected {
        let _ = writeln!(text, "  its experiments could not be fitted, so the correction is as before: {reason}.");
    }
    let n_failed = report.failed_trials().count();
    if n_failed > 0 {
        let _ = writeln!(text, "  {} gave no result.", count(n_failed, "experiment"));
    }
    for term in &report.batch.dropped_terms {
        let _ = writeln!(text, "  the designs left do not tell the term {} from others; it was left out.", term.name);
    }
    let _ = writeln!(text, "  {}", noise(campaign));
    if let Some(regression) = surfaces.experiment.as_ref().and_then(|surface| surface.regression())
        && let Ok(test) = regression.lack_of_fit()
    {
        let verdict = if test.p_value < SIGNIFICANT {
            "the surface misses more than the noise explains: a richer model, or a smaller box, would tell more"
        } else {
            "the surface misses no more than the noise explains"
        };
        let _ = writeln!(text, "  lack of fit: {verdict} (F {}, p {}).", short(test.f), short(test.p_value));
    }
    Ok(text)
}

fn noise(campaign: &Campaign) -> String {
    match campaign.noise() {
        Some(error) => format!(
            "noise: repeats scatter by {} (standard deviation, {}).",
            amount(campaign, error.standard_deviation()),
            count(error.degrees_of_freedom, "degree of freedom").replace("degree of freedoms", "degrees of freedom"),
        ),
        None => "noise: not known, nothing was run twice (`replicates` in [loop] asks for repeats).".to_owned(),
    }
}

fn left(campaign: &Campaign) -> Result<String> {
    let retained = campaign.now.retained();
    let (n, of) = (retained.n_retained(), retained.n_cells());
    let mut text = format!("Left: {} of {} designs, {}.\n", grouped(n), grouped(of), percent(retained.share()));
    for (parameter, (least, most)) in campaign.problem.region.parameters().iter().zip(ranges(campaign, retained)?) {
        let whole = least <= parameter.lower() && most >= parameter.upper();
        let range = with_unit(&format!("{} to {}", plain(least), plain(most)), parameter.unit());
        let _ = writeln!(text, "  {}: {range}{}", parameter.name(), if whole { ", all of it" } else { "" });
    }
    for report in campaign.now.reports() {
        let _ = writeln!(text, "  {}", dropped_by(campaign, report));
    }
    Ok(text)
}

/// Why a batch dropped what it dropped.
pub(crate) fn dropped_by(campaign: &Campaign, report: &global::Report) -> String {
    let n = report.screening.n_before - report.screening.n_after;
    format!("batch {} dropped {}: {}", report.iteration, grouped(n), dropped_because(campaign, report))
}

pub(crate) fn dropped_because(campaign: &Campaign, report: &global::Report) -> String {
    let screening = &report.screening;
    match screening.spread.s() {
        _ if !screening.tested => "the first batches only correct, see `drop_from` in [loop]".to_owned(),
        Some(s) => {
            let worse = screening.threshold * s * std::f64::consts::SQRT_2;
            let limit = value(campaign, screening.optimum_value + worse);
            let word = if campaign.problem.response.better() == "lower" { "above" } else { "below" };
            format!("predicted {word} {limit}, that is worse than the best by {} S √2", short(screening.threshold))
        }
        None => "nothing could be dropped, as the validation experiments gave no spread S".to_owned(),
    }
}

/// The least and the largest setting of each parameter among the designs that are left.
pub(crate) fn ranges(campaign: &Campaign, retained: &RetainedSet) -> Result<Vec<(f64, f64)>> {
    let combinations = campaign.now.grid().combinations();
    let mut digits = vec![0; combinations.counts().len()];
    let mut ranges = vec![(u64::MAX, 0); digits.len()];
    for cell in retained.cells() {
        combinations.fill_digits(cell.index(), &mut digits);
        for (range, &digit) in ranges.iter_mut().zip(&digits) {
            *range = (range.0.min(digit), range.1.max(digit));
        }
    }
    let level = |(parameter, (least, most)): (&doe::Parameter, (u64, u64))| {
        let at = |digit: u64| parameter.level(u32::try_from(digit).unwrap_or(u32::MAX));
        Ok((at(least)?, at(most)?))
    };
    campaign.problem.region.parameters().iter().zip(ranges).map(level).collect()
}

/// What more experiments could bring, and what is certain.
pub(crate) fn prospects(campaign: &Campaign) -> Result<String> {
    let mut text = String::new();
    if let Some(outlook) = campaign.outlook()? {
        let total = outlook.total_gain();
        let headline = total.map_or_else(|| "nobody knows how much".to_owned(), |total| gain(campaign, total));
        let _ = writeln!(text, "More experiments may still gain {headline} on average:");
        let mean = gain(campaign, outlook.mean_gain);
        let upper = match outlook.upper_gain {
            upper if upper > 0.0 => format!("at most {}", amount(campaign, upper)),
            _ => "nothing".to_owned(),
        };
        let _ = writeln!(text, "  {mean} by averaging out the noise ({upper} nine times in ten);");
        let shape = match outlook.misfit_gain {
            _ if campaign.now.retained().n_retained() < 2 => "nothing by a better shape: one design is left".to_owned(),
            Some(misfit) if misfit > 0.0 => {
                let why = match campaign.noise() {
                    Some(_) => "S is larger than noise and fit make it on average",
                    None => "S may be noise, but no run was repeated",
                };
                format!("{} because the surface may have the wrong shape: {why}", amount(campaign, misfit))
            }
            Some(_) => "nothing by a better shape: S is no larger than noise and fit make it".to_owned(),
            None => "what a better shape would bring is not known, without an S".to_owned(),
        };
        let _ = writeln!(text, "  {shape}.");
        let verdict = match (campaign.problem.worth, total) {
            _ if campaign.now.stop().is_some() => None,
            (Some(worth), Some(total)) if total < worth => {
                Some(format!("That is less than the {} of `worth`: stop", amount(campaign, worth)))
            }
            (Some(worth), _) => {
                Some(format!("That is not less than the {} of `worth`: go on", amount(campaign, worth)))
            }
            (None, _) => Some("`worth` in [stop] says from what gain on another batch is worth its cost".to_owned()),
        };
        if let Some(verdict) = verdict {
            let _ = writeln!(text, "{verdict}.");
        }
    }
    if let Some(observed) = campaign.now.observed_certificate()? {
        let ObservedErrors { eps, certificate, .. } = observed;
        let _ = writeln!(
            text,
            "Guarantee: of the designs left none is better than this one by more than {}, if the corrected simulation is off by at most {}, as its errors at left-out runs say.",
            amount(campaign, certificate.regret),
            amount(campaign, eps),
        );
    }
    Ok(text)
}

pub(crate) fn next(campaign: &Campaign, stage: &Stage, folder: &Path) -> String {
    match stage {
        Stage::Ready => format!("Next: {} ask\n", super::ask::infuse(folder)),
        Stage::Pending => {
            let sheet = super::ask::sheet_path(folder, campaign.batch(), None);
            if sheet.exists() {
                let tell = super::ask::tell_with(folder, &sheet);
                format!("Next: run what is left in {}, then: {tell}\n", sheet.display())
            } else {
                format!("Next: run what is left of the sheet, then: {} tell SHEET\n", super::ask::infuse(folder))
            }
        }
        stage => format!("Ended: {}.\n", reason_to_stop(campaign, stage).unwrap_or_default()),
    }
}

/// Why there is nothing more to run, if so.
pub(crate) fn reason_to_stop(campaign: &Campaign, stage: &Stage) -> Option<String> {
    match stage {
        Stage::Ready | Stage::Pending => None,
        Stage::Ended(infuse::global::StopReason::IterationLimit) => {
            let batches = count(campaign.problem.settings.max_iterations, "batch");
            Some(format!("all {batches} of [loop] were made (`batches` may be raised)"))
        }
        Stage::Ended(infuse::global::StopReason::NoInformation) => Some(
            "every experiment of the last batch failed; `infuse tell --correct` with a result reopens it".to_owned(),
        ),
        Stage::Ended(infuse::global::StopReason::FewerThanTwoCells) => {
            Some("fewer than two designs are left".to_owned())
        }
        Stage::Ended(reason) => Some(reason.to_string()),
        Stage::NotWorth { gain, worth } => Some(format!(
            "another batch may gain {} on average, and is worth it from {}",
            self::gain(campaign, *gain),
            amount(campaign, *worth)
        )),
    }
}

fn why_dropped(campaign: &Campaign, why: &str) -> Result<String> {
    let region = &campaign.problem.region;
    let asked = settings::all(why, region)?;
    let cell = campaign.now.cell(&asked)?;
    let point = campaign.now.point(cell)?;
    let is_off = point.iter().zip(&asked).any(|(level, asked)| plain(*level) != plain(*asked));
    let nearest = if is_off { "The nearest design that can be set, " } else { "" };
    let place = format!("{nearest}{}", campaign.problem.describe(&point));
    Ok(match campaign.now.why_dropped(cell) {
        Some(dropped) => format!(
            "{place} was dropped by batch {}: {} was predicted there against {} at the best, which is {} S √2 more, and {} are enough.",
            dropped.iteration,
            value(campaign, dropped.value),
            value(campaign, dropped.optimum_value),
            short(dropped.z),
            short(dropped.z0),
        ),
        None => format!("{place} is still in the running."),
    })
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
