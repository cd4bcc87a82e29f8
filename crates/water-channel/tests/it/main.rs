//! Claims about the rig, its test, its cost and its files.
#![expect(clippy::unwrap_used, reason = "helpers of tests fail the test")]

mod accuracy;
mod closed_loop;
mod convergence;
mod cost;
mod energy;
mod failures;
mod files;
mod fleet;
mod golden;
mod kick;
mod landscape;
mod log;
mod masses;
mod noise;
mod open_loop;
mod profile;
mod reference;
mod rigs;
mod sensing;
mod slack;
mod water;
