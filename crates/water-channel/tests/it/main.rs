//! Claims about the rig, its test, its cost and its files.

mod closed_loop;
mod convergence;
mod cost;
mod failures;
mod files;
mod fleet;
mod golden;
mod kick;
mod landscape;
mod log;
mod profile;
mod reference;
mod rigs;
mod slack;
