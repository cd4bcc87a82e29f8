//! What to do next, or why there is nothing to do.

use page::Finding;

use crate::campaign::{Campaign, Stage};
use crate::sheet::check_same;
use crate::shell::{infuse, sheet_path, tell_with, typed_name};

/// The next command to type, or why the campaign has ended.
pub(crate) fn next(campaign: &dyn Campaign, stage: &Stage) -> Finding {
    let folder = campaign.folder();
    Finding::new(match stage {
        Stage::Ended { reason, .. } => {
            return after_the_end(campaign).into_iter().fold(ended(reason), Finding::detail);
        }
        Stage::Ready => format!("Next: {} ask", infuse(folder)),
        Stage::Pending => {
            let (problem, experiments) = (campaign.problem(), campaign.experiments());
            let batch = experiments.open_batches().first().copied().unwrap_or(1);
            let named = experiments.sheets_of(batch).last().map(|kept| typed_name(folder, kept));
            let usual = || sheet_path(folder, problem.sheets, batch, None);
            let sheet = named.filter(|sheet| sheet.exists()).unwrap_or_else(usual);
            // A file of that name may be of a batch that was taken back.
            if !sheet.exists() {
                format!("Next: run what is left of the sheet, then: {} tell SHEET", infuse(folder))
            } else if let Err(fault) = check_same(&sheet, problem, &experiments.in_run_order(batch, problem.seed)) {
                format!("Next: {} ask writes the sheet of batch {batch}, but {fault:#}", infuse(folder))
            } else {
                format!("Next: run what is left in {}, then: {}", sheet.display(), tell_with(folder, &sheet))
            }
        }
    })
}

/// What to type after the end.
pub(crate) fn after_the_end(campaign: &dyn Campaign) -> Option<Finding> {
    let infuse = infuse(campaign.folder());
    if campaign.is_confirmed() {
        return Some(Finding::new(format!("Next: {infuse} report, which draws all that was found")));
    }
    let sentence = format!("Next: {infuse} confirm, a few runs that measure what was gained; then: {infuse} report");
    campaign.may_confirm().then(|| Finding::new(sentence))
}

/// Why there is nothing more to run.
pub(crate) fn ended(reason: &str) -> Finding {
    Finding::new(format!("Ended: {reason}."))
}

/// That the limit on the batches is reached; it may have been lowered since.
pub(crate) fn all_batches_made(limit: usize, n_made: usize) -> String {
    let made = match limit {
        _ if n_made > limit => format!("{n_made} batches were made, and [loop] has {limit}"),
        1 => "the one batch of [loop] was made".to_owned(),
        _ => format!("all {limit} batches of [loop] were made"),
    };
    format!("{made} (`batches` may be raised)")
}
