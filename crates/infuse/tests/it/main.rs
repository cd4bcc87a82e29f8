//! Claims of the crate, each against a closed form or against the loop itself.

#![expect(clippy::unwrap_used, clippy::missing_assert_message, reason = "the helpers of tests fail like tests")]

mod correction;
mod errors;
mod failures;
mod invariants;
mod problems;
mod saved_state;
mod strategies;
