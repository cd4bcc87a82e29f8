//! Why a campaign has ended.

use infuse::global::StopReason;

use super::amount::{amount, gain};
use crate::campaign::{Campaign, Stage};
use crate::number::count;

/// Why there is nothing more to run, if so.
pub(crate) fn reason_to_stop(campaign: &Campaign, stage: &Stage) -> Option<String> {
    match stage {
        Stage::Ready | Stage::Pending => None,
        Stage::Ended(StopReason::IterationLimit) => {
            let batches = count(campaign.problem.settings.max_iterations, "batch");
            Some(format!("all {batches} of [loop] were made (`batches` may be raised)"))
        }
        Stage::Ended(StopReason::NoInformation) => Some(
            "every experiment of the last batch failed; `infuse tell --correct` with a result reopens it".to_owned(),
        ),
        Stage::Ended(StopReason::FewerThanTwoCells) => Some("fewer than two designs are left".to_owned()),
        Stage::Ended(reason) => Some(reason.to_string()),
        Stage::NotWorth { gain: expected, worth } => Some(format!(
            "another batch may gain {} on average, and is worth it from {}",
            gain(campaign, *expected),
            amount(campaign, *worth)
        )),
    }
}
