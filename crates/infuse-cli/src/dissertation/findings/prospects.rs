//! What more experiments could bring, and what is certain.

use anyhow::Result;
use infuse::global::{ObservedErrors, Outlook, SurfaceKinds};
use page::Finding;

use crate::dissertation::campaign::Campaign;

/// The gain that may be expected, what follows from it, and the guarantee; as far as each is known.
pub(in crate::dissertation) fn prospects(campaign: &Campaign) -> Result<Vec<Finding>> {
    let mut found = Vec::new();
    let (outlook, observed) = (campaign.outlook()?, campaign.now.observed_certificate()?);
    if let Some(outlook) = &outlook {
        found.push(expected_gain(campaign, outlook));
        found.extend(verdict(campaign, outlook.total_gain()));
    }
    if let Some(observed) = &observed {
        found.push(guarantee(campaign, observed));
    }
    found.extend(not_known(campaign, outlook.is_some(), observed.is_some()));
    Ok(found)
}

/// What is not said because the surfaces are of other kinds.
fn not_known(campaign: &Campaign, has_outlook: bool, has_guarantee: bool) -> Option<Finding> {
    if campaign.now.settings().surfaces == SurfaceKinds::default() {
        return None;
    }
    let what = match (has_outlook, has_guarantee) {
        (true, true) => return None,
        (false, true) => "What more experiments may gain is",
        (true, false) => "A guarantee is",
        (false, false) => "What more experiments may gain, and a guarantee, are",
    };
    Some(Finding::new(format!("{what} not known with these `surfaces` of [loop]: regressions would tell.")))
}

fn expected_gain(campaign: &Campaign, outlook: &Outlook) -> Finding {
    let unit = &campaign.problem.response.unit;
    let total = outlook.total_gain();
    let headline =
        total.map_or_else(|| "nobody knows how much".to_owned(), |total| campaign.problem.response.gain(total));
    let (mean, most) = (outlook.noise_gain(), outlook.upper_noise_gain());
    let upper = match most {
        upper if upper > 0.0 => format!("at most {}", campaign.problem.response.amount(upper)),
        _ => "nothing".to_owned(),
    };
    let shown = campaign.problem.response.gain(mean);
    let by_noise = Finding::new(format!("{shown} by averaging out the noise ({upper} nine times in ten);"))
        .with("mean gain", mean, unit)
        .with("gain nine times in ten at most", most, unit);
    let by_shape = Finding::new(format!("{}.", by_shape(campaign, outlook)));
    let by_shape = match outlook.misfit_gain {
        Some(misfit) => by_shape.with("gain by a better shape", misfit, unit),
        None => by_shape,
    };
    let finding = Finding::new(format!("More experiments may still gain {headline} on average:"));
    let finding = match total {
        Some(total) => finding.with("total gain", total, unit),
        None => finding,
    };
    let finding = finding.detail(by_noise);
    // The best design is that of a surface which the experiments of the last batch have not corrected yet.
    let finding = if outlook.moved_gain > 0.0 {
        let moved = campaign.problem.response.amount(outlook.moved_gain);
        let sentence = format!("{moved} because the simulation as it is corrected now has its best at another design;");
        finding.detail(Finding::new(sentence).with("gain at another design", outlook.moved_gain, unit))
    } else {
        finding
    };
    finding.detail(by_shape)
}

fn by_shape(campaign: &Campaign, outlook: &Outlook) -> String {
    match outlook.misfit_gain {
        _ if campaign.now.retained().n_retained() < 2 => "nothing by a better shape: one design is left".to_owned(),
        Some(misfit) if misfit > 0.0 => {
            let why = match campaign.noise() {
                Some(_) => "S is larger than noise and fit make it on average",
                None => "S may be noise, but no run was repeated",
            };
            format!("{} because the surface may have the wrong shape: {why}", campaign.problem.response.amount(misfit))
        }
        Some(_) => "nothing by a better shape: S is no larger than noise and fit make it".to_owned(),
        None => "what a better shape would bring is not known, without an S".to_owned(),
    }
}

/// Whether another batch is worth its cost; none once the campaign has ended.
fn verdict(campaign: &Campaign, total: Option<f64>) -> Option<Finding> {
    let unit = &campaign.problem.response.unit;
    let of_worth = |worth: f64| format!("{} of `worth`", campaign.problem.response.amount(worth));
    match (campaign.problem.worth, total) {
        _ if campaign.now.stop().is_some() => None,
        (Some(worth), Some(total)) if total < worth => {
            let sentence = format!("That is less than the {}: stop.", of_worth(worth));
            Some(Finding::new(sentence).with("worth", worth, unit))
        }
        (Some(worth), _) => {
            let sentence = format!("That is not less than the {}: go on.", of_worth(worth));
            Some(Finding::new(sentence).with("worth", worth, unit))
        }
        (None, _) => Some(Finding::new("`worth` in [stop] says from what gain on another batch is worth its cost.")),
    }
}

fn guarantee(campaign: &Campaign, observed: &ObservedErrors) -> Finding {
    let (unit, ObservedErrors { eps, certificate, .. }) = (&campaign.problem.response.unit, observed);
    let sentence = format!(
        "Guarantee: of the designs left none is better than this one by more than {}, if the corrected simulation is off by \
         at most {}, as its errors at left-out runs say.",
        campaign.problem.response.amount(certificate.regret),
        campaign.problem.response.amount(*eps),
    );
    Finding::new(sentence).with("regret", certificate.regret, unit).with("eps", *eps, unit)
}
