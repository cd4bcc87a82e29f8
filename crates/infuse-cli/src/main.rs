//! `infuse`: campaigns of experiments and simulations from a shell.

fn main() {}
