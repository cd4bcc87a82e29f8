//! What a campaign of the dissertation's loop has found, in sentences with their numbers.

mod best;
mod left;
mod lesson;
mod prospects;
mod stop;

pub(super) use best::{best, best_design, best_of_batch, closed};
pub(super) use left::{dropped_because, dropped_by, how_many, left, ranges, why_dropped};
pub(super) use lesson::lesson;
pub(super) use prospects::prospects;
pub(super) use stop::reason_to_stop;
