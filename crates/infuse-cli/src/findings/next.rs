//! What to do next, or why there is nothing to do.

use std::path::Path;

use page::Finding;

use super::stop::reason_to_stop;
use crate::campaign::{Campaign, Stage};
use crate::shell::{infuse, sheet_path, tell_with};

/// The next command to type, or why the campaign has ended.
pub(crate) fn next(campaign: &Campaign, stage: &Stage, folder: &Path) -> Finding {
    ended(campaign, stage).unwrap_or_else(|| {
        Finding::new(match stage {
            Stage::Pending => {
                let sheet = sheet_path(folder, campaign.batch(), None);
                if sheet.exists() {
                    let tell = tell_with(folder, &sheet);
                    format!("Next: run what is left in {}, then: {tell}", sheet.display())
                } else {
                    format!("Next: run what is left of the sheet, then: {} tell SHEET", infuse(folder))
                }
            }
            _ => format!("Next: {} ask", infuse(folder)),
        })
    })
}

/// Why there is nothing more to run, if so.
pub(crate) fn ended(campaign: &Campaign, stage: &Stage) -> Option<Finding> {
    reason_to_stop(campaign, stage).map(|reason| Finding::new(format!("Ended: {reason}.")))
}
