//! The parts of the global loop of Chapter 5.

pub(crate) mod agreement;
pub(crate) mod batch;
pub(crate) mod candidates;
pub(crate) mod cells;
pub(crate) mod changes;
pub(crate) mod earlier;
pub(crate) mod greedy;
pub(crate) mod iteration;
pub(crate) mod observations;
pub(crate) mod outlook;
pub(crate) mod plan;
pub(crate) mod pure_error;
pub(crate) mod report;
pub(crate) mod retained;
pub(crate) mod screening;
pub(crate) mod settings;
pub(crate) mod state;
pub(crate) mod sum;
pub(crate) mod surfaces;
pub(crate) mod traced;
pub(crate) mod trial;
