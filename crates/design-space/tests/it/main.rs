//! Claims about parameters, regions, grids and models.

#![expect(clippy::unwrap_used, clippy::missing_assert_message, reason = "the helpers of tests fail like tests")]

mod errors;
mod files;
mod grid;
mod model;
mod properties;
