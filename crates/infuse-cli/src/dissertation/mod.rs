//! Campaigns of the dissertation's loop: a surface per batch, tests that drop designs, a corrected simulation.

mod apply;
mod campaign;
mod findings;
mod hand_out;
mod method;
mod report;

pub(crate) use campaign::Campaign;
