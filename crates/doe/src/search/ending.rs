//! What ends a search before all its starts are made.

use std::time::{Duration, Instant};

use super::report::StopReason;

/// Whether a search is over, asked wherever it may have to end: cheap, and true from some time on.
pub(crate) type IsOver<'a> = &'a (dyn Fn() -> bool + Sync);

/// What ends a search from outside.
#[derive(Clone, Copy)]
pub(crate) struct Ending<'a> {
    pub(crate) began: Instant,
    pub(crate) time_limit: Option<Duration>,
    pub(crate) is_interrupted: IsOver<'a>,
}

impl Ending<'_> {
    /// Why the search is over; none while it is not.
    pub(crate) fn reason(&self) -> Option<StopReason> {
        if (self.is_interrupted)() {
            Some(StopReason::Interrupted)
        } else if self.time_limit.is_some_and(|limit| self.began.elapsed() >= limit) {
            Some(StopReason::TimeLimit)
        } else {
            None
        }
    }

    pub(crate) fn is_over(&self) -> bool {
        self.reason().is_some()
    }
}
