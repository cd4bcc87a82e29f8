//! How much was done, and what is waited for.

use page::Finding;

use crate::campaign::Campaign;
use crate::number::count;

/// Batches and experiments so far.
pub(crate) fn standing(campaign: &Campaign) -> Finding {
    let n_closed = campaign.now.reports().len();
    let n_made = campaign.readings.values().filter(|reading| reading.first.is_some()).count();
    let n_failed = campaign.readings.values().filter(|reading| reading.values().count() == 0).count();
    let failed = if n_failed > 0 { format!(", {n_failed} of them without a result") } else { String::new() };
    let mut text = format!("{} closed, {} made{failed}", count(n_closed, "batch"), count(n_made, "experiment"));
    let outstanding = campaign.now.outstanding().len();
    if outstanding > 0 {
        let batch = campaign.batch();
        let n = campaign.in_run_order(batch).len();
        text.push_str(&format!("; batch {batch} waits for {outstanding} of {n}"));
    }
    let n_earlier = campaign.now.earlier().len();
    if n_earlier > 0 {
        text.push_str(&format!("; {} imported", count(n_earlier, "earlier experiment")));
    }
    let numbers = [
        ("batches closed", n_closed),
        ("experiments made", n_made),
        ("experiments without a result", n_failed),
        ("experiments waited for", outstanding),
        ("experiments imported", n_earlier),
    ];
    let finding = Finding::new(format!("{text}."));
    numbers.into_iter().fold(finding, |finding, (name, number)| finding.with(name, number as f64, "1"))
}
