//! The best design, as predicted and as measured.

use infuse::Outcome;
use infuse::global::{Report, Spread};
use page::Finding;

use super::amount::{amount, value};
use crate::campaign::Campaign;
use crate::number::{short, with_unit};

/// The recommendation of the last closed batch; none before there is one.
pub(crate) fn best(campaign: &Campaign) -> Option<Finding> {
    let (problem, reports) = (&campaign.problem, campaign.now.reports());
    let (first, last) = reports.first().zip(reports.last())?;
    let mut best = best_design(campaign)?.detail(predicted(campaign, last));
    if let Some((id, measured)) = best_measured(campaign) {
        let place = problem.describe(&campaign.settings_of(id));
        let shown = with_unit(&short(measured), &problem.response.unit);
        let sentence = format!("Best measured: {shown}, experiment {id} at {place}.");
        best = best.detail(Finding::new(sentence).with("best measured", measured, &problem.response.unit));
    }
    let alone = problem.describe(&first.screening.simulation_optimum);
    Some(best.detail(Finding::new(format!("The simulation alone would have chosen {alone}."))))
}

/// The same in one sentence, with its settings.
pub(crate) fn best_design(campaign: &Campaign) -> Option<Finding> {
    let (problem, last) = (&campaign.problem, campaign.now.reports().last()?);
    let best = Finding::new(format!("Best design: {}.", problem.describe(&last.screening.optimum)));
    let settings = problem.region.parameters().iter().zip(&last.screening.optimum);
    Some(settings.fold(best, |best, (parameter, &setting)| best.with(parameter.name(), setting, parameter.unit())))
}

fn predicted(campaign: &Campaign, last: &Report) -> Finding {
    let (response, screening) = (&campaign.problem.response, &last.screening);
    let sure = match screening.spread {
        Spread::Estimated { s, n_validation } => {
            format!("; {n_validation} experiments that it had not seen were missed by {} (S)", amount(campaign, s))
        }
        _ => "; how sure that is, too few experiments tell".to_owned(),
    };
    let shown = value(campaign, screening.optimum_value);
    let predicted = Finding::new(format!("{} there: {shown} predicted{sure}.", response.name)).with(
        "predicted",
        response.of_cost(screening.optimum_value),
        &response.unit,
    );
    match screening.spread.s() {
        Some(s) => predicted.with("S", s, &response.unit),
        None => predicted,
    }
}

/// The experiment with the best mean, and that.
pub(crate) fn best_measured(campaign: &Campaign) -> Option<(u64, f64)> {
    let response = &campaign.problem.response;
    let means = campaign.readings.iter().filter_map(|(&id, reading)| Some((id, reading.outcome(response)?.cost()?)));
    let (id, cost) = means.min_by(|a, b| a.1.total_cmp(&b.1))?;
    Some((id, response.of_cost(cost)))
}

/// The least cost among the experiments of a batch.
pub(crate) fn best_of_batch(report: &Report) -> Option<f64> {
    let costs = report.trials.iter().filter_map(|record| record.outcome.as_ref().and_then(Outcome::cost));
    costs.min_by(f64::total_cmp)
}
