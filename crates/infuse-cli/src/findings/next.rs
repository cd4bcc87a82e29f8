//! What to do next, or why there is nothing to do.

use page::Finding;

use crate::campaign::{Campaign, Stage};
use crate::shell::{infuse, sheet_path, tell_with};

/// The next command to type, or why the campaign has ended.
pub(crate) fn next(campaign: &dyn Campaign, stage: &Stage) -> Finding {
    let folder = campaign.folder();
    Finding::new(match stage {
        Stage::Ended { reason, .. } => return ended(reason),
        Stage::Ready => format!("Next: {} ask", infuse(folder)),
        Stage::Pending => {
            let sheet = sheet_path(
                folder,
                campaign.problem().sheets,
                campaign.experiments().open_batches().first().copied().unwrap_or(1),
                None,
            );
            if sheet.exists() {
                format!("Next: run what is left in {}, then: {}", sheet.display(), tell_with(folder, &sheet))
            } else {
                format!("Next: run what is left of the sheet, then: {} tell SHEET", infuse(folder))
            }
        }
    })
}

/// Why there is nothing more to run.
pub(crate) fn ended(reason: &str) -> Finding {
    Finding::new(format!("Ended: {reason}."))
}
