//! What commands say whatever the method of a campaign, in sentences with their numbers: they are printed, and the page shows
//! them.

mod alone;
mod batch;
mod bounds;
mod displacement;
mod next;
mod standing;
mod taken;

pub(crate) use alone::{MUCH_IS_HELD, by_the_surface_alone};
pub(crate) use batch::handed_out;
pub(crate) use bounds::on_bounds;
pub(crate) use displacement::{displaced_by, give_or_take};
pub(crate) use next::{after_the_end, all_batches_made, ended, next};
pub(crate) use standing::standing;
pub(crate) use taken::{
    Twice, as_from_elsewhere, imported, outstanding, taken, there_twice, withdrawn, without_columns,
};

/// The name of that number, before the campaign and in it.
pub(crate) const WITHOUT_RESERVE: &str = "designs run from which on nothing is held for a narrow well";
