//! What a campaign has found, in sentences with their numbers: `status` prints them, the page shows them.

mod amount;
mod best;
mod left;
mod lesson;
mod prospects;
mod standing;
mod stop;

pub(crate) use amount::{amount, value};
pub(crate) use best::{best, best_measured, best_of_batch};
pub(crate) use left::{dropped_because, dropped_by, left, ranges};
pub(crate) use lesson::lesson;
pub(crate) use prospects::prospects;
pub(crate) use standing::standing;
pub(crate) use stop::reason_to_stop;
