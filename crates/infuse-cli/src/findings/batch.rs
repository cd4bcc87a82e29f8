//! A batch that is handed out, and one that is closed.

use std::path::Path;

use infuse::global::Report;
use page::Finding;

use super::amount::value;
use crate::campaign::Campaign;
use crate::number::{count, percent};
use crate::shell::tell_with;

/// The experiments that are waited for, and what to do with them. The sheet may have been there before.
pub(crate) fn handed_out(
    campaign: &Campaign,
    folder: &Path,
    sheet: &Path,
    sheet_is_new: bool,
    n_simulated: usize,
) -> Vec<Finding> {
    let batch = campaign.batch();
    let trials = campaign.in_run_order(batch);
    let n_told = trials.iter().filter(|(trial, _)| campaign.is_told(trial.id)).count();
    let n_repeats = trials.iter().filter(|(_, repeats)| repeats.is_some()).count();
    let repeats =
        if n_repeats > 0 { format!(", {n_repeats} of them repeats that measure the noise") } else { String::new() };
    let mut found = vec![
        Finding::new(format!("Batch {batch}: {}{repeats}.", count(trials.len(), "experiment")))
            .with("batch", batch as f64, "1")
            .with("experiments", trials.len() as f64, "1")
            .with("repeats", n_repeats as f64, "1"),
    ];
    if n_simulated > 0 {
        let were = if n_simulated == 1 { "was" } else { "were" };
        let sentence = format!("{} {were} made for it.", count(n_simulated, "simulation"));
        found.push(Finding::new(sentence).with("simulations made", n_simulated as f64, "1"));
    }
    found.push(Finding::new(if batch == 1 {
        "It is the first: spread over all that can be set, it shows where the simulation is wrong."
    } else {
        "It is spread over the designs that are left, so that the surface is known best where the optimum may be."
    }));
    if n_told > 0 {
        let n_left = trials.len() - n_told;
        let sentence = format!("Results so far: {n_told}; {n_left} to go.");
        found.push(Finding::new(sentence).with("results", n_told as f64, "1").with("to go", n_left as f64, "1"));
    }
    let place = sheet.display();
    found.push(Finding::new(if sheet_is_new {
        format!("Written to {place}, in the order in which to run them.")
    } else {
        format!("They are in {place}, which was there already and is left as it is.")
    }));
    found.push(Finding::new(format!(
        "Run them, fill in `{}` (or, for a run without a result, the reason under `failed`), then: {}",
        campaign.problem.response.heading(),
        tell_with(folder, sheet),
    )));
    found
}

/// A closed batch in one line.
pub(crate) fn closed(campaign: &Campaign, report: &Report) -> Finding {
    let (problem, screening) = (&campaign.problem, &report.screening);
    let (predicted, share) = (value(campaign, screening.optimum_value), campaign.now.retained().share());
    let best = problem.describe(&screening.optimum);
    Finding::new(format!("batch {}: {best}; {predicted} predicted, {} left", report.iteration, percent(share)))
        .with("predicted", problem.response.of_cost(screening.optimum_value), &problem.response.unit)
        .with("share left", share, "1")
}
