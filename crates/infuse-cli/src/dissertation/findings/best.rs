//! The best design, as predicted and as measured.

use infuse::Outcome;
use infuse::global::Report;
use infuse::global::reported::Spread;
use page::Finding;

use crate::dissertation::campaign::Campaign;
use crate::findings::on_bounds;
use crate::number::{percent, short, with_unit};

/// The recommendation of the last closed batch; none before there is one.
pub(in crate::dissertation) fn best(campaign: &Campaign) -> Option<Finding> {
    let (problem, reports) = (&campaign.problem, campaign.now.reports());
    let (first, last) = reports.first().zip(reports.last())?;
    let mut best = best_design(campaign)?.detail(predicted(campaign, last));
    let made = campaign.experiments.readings.keys().any(|&id| {
        let settings = campaign.experiments.settings_of(id);
        settings.iter().zip(&last.screening.optimum).all(|(a, b)| (a - b).abs() <= 1e-9 * b.abs().max(1.0))
    });
    if !made {
        best = best.detail(Finding::new("It was never run: what is predicted there rests on others."));
    }
    for bound in on_bounds(problem, &last.screening.optimum) {
        best = best.detail(bound);
    }
    best = contradiction(campaign, last, best);
    if let Some((id, measured)) = campaign.experiments.best_measured(&problem.response) {
        let place = problem.describe(&campaign.experiments.settings_of(id));
        let shown = with_unit(&short(measured), &problem.response.unit);
        let sentence = format!("Best measured: {shown}, experiment {id} at {place}.");
        best = best.detail(Finding::new(sentence).with("best measured", measured, &problem.response.unit));
    }
    let alone = problem.describe(&first.screening.simulation_optimum);
    Some(best.detail(Finding::new(format!("A surface through the simulations alone would have chosen {alone}."))))
}

/// Standard deviations by which a measurement must be better than what is predicted to be said.
const CONTRADICTING: f64 = 3.0;

/// Says it if a measurement is better than what is predicted of the best design by more than noise and S explain.
fn contradiction(campaign: &Campaign, last: &Report, best: Finding) -> Finding {
    let response = &campaign.problem.response;
    let Some((id, measured)) = campaign.experiments.best_measured(response) else { return best };
    let s = last.screening.spread.s().unwrap_or(0.0);
    let noise = campaign.noise().map_or(0.0, |error| error.standard_deviation());
    let error = s.hypot(noise);
    let better = last.screening.optimum_value - response.cost(measured);
    if error <= 0.0 || better <= CONTRADICTING * error {
        return best;
    }
    let times = better / error;
    let sentence = format!(
        "Careful: experiment {id} measured {} times S and noise better than that: run both again before you believe it.",
        short(times)
    );
    best.detail(Finding::new(sentence).with("better by, in S and noise", times, "1"))
}

/// The same in one sentence, with its settings.
pub(in crate::dissertation) fn best_design(campaign: &Campaign) -> Option<Finding> {
    let (problem, last) = (&campaign.problem, campaign.now.reports().last()?);
    let best = Finding::new(format!("Best design: {}.", problem.describe(&last.screening.optimum)));
    let settings = problem.region.parameters().iter().zip(&last.screening.optimum);
    Some(settings.fold(best, |best, (parameter, &setting)| best.with(parameter.name(), setting, parameter.unit())))
}

fn predicted(campaign: &Campaign, last: &Report) -> Finding {
    let (response, screening) = (&campaign.problem.response, &last.screening);
    let sure = match screening.spread {
        Spread::Estimated { s, n_validation } => {
            format!(
                "; {n_validation} experiments that it had not seen were missed by {} (S)",
                campaign.problem.response.amount(s)
            )
        }
        _ => "; how sure that is, too few experiments tell".to_owned(),
    };
    let shown = campaign.problem.response.value(screening.optimum_value);
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

/// The least cost among the experiments of a batch.
pub(in crate::dissertation) fn best_of_batch(report: &Report) -> Option<f64> {
    let costs = report.trials.iter().filter_map(|record| record.outcome.as_ref().and_then(Outcome::cost));
    costs.min_by(f64::total_cmp)
}

/// A closed batch in one line.
pub(in crate::dissertation) fn closed(campaign: &Campaign, report: &Report) -> Finding {
    let (problem, screening) = (&campaign.problem, &report.screening);
    let (predicted, share) = (problem.response.value(screening.optimum_value), campaign.now.retained().share());
    let best = problem.describe(&screening.optimum);
    Finding::new(format!("batch {}: {best}; {predicted} predicted, {} left", report.number, percent(share)))
        .with("predicted", problem.response.of_cost(screening.optimum_value), &problem.response.unit)
        .with("share left", share, "1")
}
