//! Why a campaign has ended.

use infuse::global::StopReason;

use crate::dissertation::campaign::{Campaign, Stage};
use crate::findings::all_batches_made;

/// Why there is nothing more to run, if so.
pub(in crate::dissertation) fn reason_to_stop(campaign: &Campaign, stage: &Stage) -> Option<String> {
    match stage {
        Stage::Ready | Stage::Pending => None,
        Stage::Ended(StopReason::BatchLimit) => {
            let n_made = campaign.experiments.last_batch().unwrap_or(0);
            Some(all_batches_made(campaign.now.settings().max_batches, n_made))
        }
        Stage::Ended(StopReason::NoInformation) => Some(
            "every experiment of the last batch failed; `infuse tell --correct` with a result reopens it".to_owned(),
        ),
        Stage::Ended(StopReason::FewerThanTwoCells) => Some("fewer than two designs are left".to_owned()),
        Stage::Ended(reason) => Some(reason.to_string()),
        Stage::NotWorth { gain: expected, worth } => Some(format!(
            "another batch may gain {} on average, less than the {} that would be worth it",
            campaign.problem.response.gain(*expected),
            campaign.problem.response.amount(*worth)
        )),
    }
}
