//! How much was done, and what is waited for.

use page::Finding;

use crate::campaign::Campaign;
use crate::number::count;

/// Batches and experiments so far.
pub(crate) fn standing(campaign: &dyn Campaign) -> Finding {
    let (n_closed, experiments) = (campaign.n_closed(), campaign.experiments());
    let (n_made, n_failed, outstanding) = (experiments.n_made(), experiments.n_failed(), experiments.n_outstanding());
    let failed = if n_failed > 0 { format!(", {n_failed} of them without a result") } else { String::new() };
    let n_further = experiments.n_further_runs();
    let further = if n_further > 0 { format!(", {} of these", count(n_further, "further run")) } else { String::new() };
    let mut text =
        format!("{} closed, {} made{failed}{further}", count(n_closed, "batch"), count(n_made, "experiment"));
    for batch in experiments.open_batches() {
        let n = experiments.trials.values().filter(|trial| trial.batch == batch).count();
        text.push_str(&format!("; batch {batch} waits for {} of {n}", experiments.n_outstanding_of(batch)));
    }
    let n_earlier = campaign.imported().len();
    if n_earlier > 0 {
        text.push_str(&format!("; {} imported", count(n_earlier, "earlier experiment")));
    }
    let numbers = [
        ("batches closed", n_closed),
        ("experiments made", n_made),
        ("experiments without a result", n_failed),
        ("further runs", n_further),
        ("experiments waited for", outstanding),
        ("experiments imported", n_earlier),
    ];
    let finding = Finding::new(format!("{text}."));
    numbers.into_iter().fold(finding, |finding, (name, number)| finding.with(name, number as f64, "1"))
}
