//! Claims about parameters and regions.

#![expect(clippy::unwrap_used, clippy::missing_assert_message, reason = "the helpers of tests fail like tests")]

mod errors;
mod evaluate;
mod file;
mod files;
mod grid;
mod model;
mod properties;
mod search;
mod space;
mod split;
mod variance;
