//! A batch that is handed out, and one that is closed.

use std::path::Path;

use page::Finding;

use crate::campaign::Campaign;
use crate::number::count;
use crate::problem::{Costs, heading};
use crate::shell::tell_with;

/// The experiments that are waited for, and what to do with them. The sheet may have been there before.
pub(crate) fn handed_out(
    campaign: &dyn Campaign,
    batch: usize,
    sheet: &Path,
    sheet_is_new: bool,
    n_simulated: usize,
) -> Vec<Finding> {
    let experiments = campaign.experiments();
    let trials = experiments.in_run_order(batch, campaign.problem().seed);
    let n_told = trials.iter().filter(|(trial, _)| experiments.has_result(trial.id)).count();
    let n_repeats = trials.iter().filter(|(_, repeats)| repeats.is_some()).count();
    let repeats = match n_repeats {
        0 => String::new(),
        1 => ", 1 of them a repeat that measures the noise".to_owned(),
        n => format!(", {n} of them repeats that measure the noise"),
    };
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
    found.push(campaign.purpose(batch));
    let points: Vec<&[f64]> = trials.iter().map(|(trial, _)| trial.point.as_slice()).collect();
    found.extend(campaign.problem().costs.as_ref().map(|costs| plants(costs, &points)));
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
    let problem = campaign.problem();
    let measured = std::iter::once(problem.response.heading())
        .chain(problem.constraints.iter().map(|held| heading(held.name(), &held.unit)));
    let measured: Vec<String> = measured.map(|heading| format!("`{heading}`")).collect();
    found.push(Finding::new(format!(
        "Run them, fill in {} (or, for a run without a result, the reason under `failed`), then: {}",
        measured.join(", "),
        tell_with(campaign.folder(), sheet),
    )));
    found
}

/// How many plants a batch is run on, and after which runs another is put together.
fn plants(costs: &Costs, runs: &[&[f64]]) -> Finding {
    let (n, changes) = (costs.n_plants_of(runs), costs.changes_of_plant(runs));
    let after = changes.iter().map(usize::to_string).collect::<Vec<_>>().join(", ");
    let sentence = match changes.len() {
        0 => "All runs are of one plant, put together once.".to_owned(),
        // Runs that compare designs may go back to a plant.
        n_changes if n_changes >= n => {
            format!("They are of {}: another is put together after run {after}.", count(n, "plant"))
        }
        _ => format!(
            "They are of {}, each put together once: another is put together after run {after}.",
            count(n, "plant")
        ),
    };
    let finding = Finding::new(sentence).with("plants", n as f64, "1");
    if costs.unit().is_empty() {
        return finding;
    }
    // The first may be the plant that stands there already.
    let (most, _) = costs.of_runs(None, runs);
    finding.detail(Finding::new(format!("They cost at most {}.", costs.shown(most))).with("cost", most, costs.unit()))
}
