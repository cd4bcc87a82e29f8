//! What the last closed batch taught.

use infuse::global::BatchSurfaces;
use page::Finding;

use crate::dissertation::campaign::Campaign;
use crate::number::{count, short};

/// Lack of fit is said to be there from this probability down.
const SIGNIFICANT: f64 = 0.05;

/// What the last closed batch taught; none before there is one.
pub(in crate::dissertation) fn lesson(campaign: &Campaign) -> Option<Finding> {
    let (reports, surfaces) = (campaign.now.reports(), campaign.now.surfaces());
    let (report, surfaces) = reports.last().zip(surfaces.last())?;
    let mut details = Vec::new();
    if let Some(innovation) = report.changes.innovation {
        let before = if reports.len() == 1 { "the simulation" } else { "the corrected simulation of the batch before" };
        let sentence = format!("{before} was off by up to {}.", campaign.problem.response.amount(innovation));
        details.push(Finding::new(sentence).with("off by up to", innovation, &campaign.problem.response.unit));
    }
    if let Some(reason) = &report.not_corrected {
        let sentence = format!("its experiments could not be fitted, so the correction is as before: {reason}.");
        details.push(Finding::new(sentence));
    }
    let n_failed = report.failed_trials().count();
    if n_failed > 0 {
        let sentence = format!("{} gave no result.", count(n_failed, "experiment"));
        details.push(Finding::new(sentence).with("experiments without a result", n_failed as f64, "1"));
    }
    for term in &report.batch.dropped_terms {
        let name = &term.name;
        let sentence = format!("the designs left do not tell the term {name} from others; it was left out.");
        details.push(Finding::new(sentence));
    }
    details.push(noise(campaign));
    details.extend(lack_of_fit(surfaces));
    let lesson = Finding::new(format!("Batch {} taught:", report.number));
    Some(details.into_iter().fold(lesson, Finding::detail))
}

fn noise(campaign: &Campaign) -> Finding {
    let Some(error) = campaign.noise() else {
        return Finding::new("noise: not known, nothing was run twice (`replicates` in [loop] asks for repeats).");
    };
    let deviation = error.standard_deviation();
    if deviation <= 0.0 {
        return Finding::new("noise: not known, repeats do not differ at all.");
    }
    let degrees = match error.degrees_of_freedom {
        1 => "1 degree of freedom".to_owned(),
        n => format!("{n} degrees of freedom"),
    };
    let sentence = format!(
        "noise: repeats scatter by {} (standard deviation, {degrees}).",
        campaign.problem.response.amount(deviation)
    );
    Finding::new(sentence).with("standard deviation of the noise", deviation, &campaign.problem.response.unit).with(
        "degrees of freedom",
        error.degrees_of_freedom as f64,
        "1",
    )
}

fn lack_of_fit(surfaces: &BatchSurfaces) -> Option<Finding> {
    let test = surfaces.experiment.as_ref()?.regression()?.lack_of_fit().ok()?;
    let verdict = if test.p_value < SIGNIFICANT {
        "the surface misses more than the noise explains: a richer model, or a smaller box, would tell more"
    } else {
        "the surface misses no more than the noise explains"
    };
    let sentence = format!("lack of fit: {verdict} (F {}, p {}).", short(test.f), short(test.p_value));
    Some(Finding::new(sentence).with("F", test.f, "1").with("p", test.p_value, "1"))
}
