//! The noise of the experiments of a campaign, from those that were repeated.

use crate::global::campaign::Loop;
use crate::pure_error::PureError;

impl Loop {
    /// The noise of the experiments reported so far, open batch included; none while no setting was made twice.
    #[must_use]
    pub fn pure_error(&self) -> Option<PureError> {
        let closed = self.history.iter().flat_map(|report| &report.trials);
        let records = closed.chain(self.open.iter().flat_map(|open| open.trials.records()));
        PureError::of_readings(records.filter_map(|record| Some((record.settings().to_vec(), record.cost()?))))
    }
}
