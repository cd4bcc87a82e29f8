//! What a campaign has found, in sentences with their numbers: commands print them, the page shows them.

mod amount;
mod batch;
mod best;
mod left;
mod lesson;
mod next;
mod prospects;
mod standing;
mod stop;
mod taken;

pub(crate) use amount::amount;
pub(crate) use batch::{closed, handed_out};
pub(crate) use best::{best, best_design, best_measured, best_of_batch};
pub(crate) use left::{dropped_because, dropped_by, how_many, left, ranges, why_dropped};
pub(crate) use lesson::lesson;
pub(crate) use next::{ended, next};
pub(crate) use prospects::prospects;
pub(crate) use standing::standing;
pub(crate) use stop::reason_to_stop;
pub(crate) use taken::{imported, outstanding, taken, withdrawn};
