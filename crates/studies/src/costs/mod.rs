//! What designs cost: one store of flown costs, in memory and on disk, named after what they follow from.

mod cost;
mod journal;
#[cfg(feature = "global")]
pub(crate) mod key;
pub(crate) mod line;
mod store;

pub(crate) use cost::{Cost, Failure, Flown};
#[cfg(feature = "global")]
pub(crate) use journal::read;
pub(crate) use store::Store;
