//! Runs the studies and the checks of the workspace.

fn main() {}
