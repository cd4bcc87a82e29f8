//! Claims about parameters and regions.

#![expect(clippy::unwrap_used, clippy::missing_assert_message, reason = "the helpers of tests fail like tests")]

mod errors;
mod files;
mod grid;
mod properties;
