//! Claims of the crate, each against a closed form or against the loop itself.

#![expect(clippy::unwrap_used, clippy::missing_assert_message, reason = "the helpers of tests fail like tests")]

mod convergence;
mod correction;
mod errors;
mod failures;
mod global_accuracy;
mod global_campaigns;
mod global_careful;
mod global_convergence;
mod global_failures;
mod global_problems;
mod global_saved_state;
mod global_screening;
mod global_settings;
mod global_small;
mod identification;
mod invariants;
mod mechanisms;
mod pooled;
mod pooled_constraints;
mod pooled_plants;
mod pooled_saved_state;
mod problems;
mod reports;
mod saved_state;
mod simulators;
mod strategies;
