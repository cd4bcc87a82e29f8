//! Claims about designs, their evaluation and their search.

#![expect(clippy::unwrap_used, reason = "the helpers of tests fail like tests")]

mod cutting;
mod design;
mod evaluate;
mod file;
mod problem_file;
mod replicates;
mod search;
mod space;
mod split;
mod variance;
