//! `cargo xtask machines`: whether kept pages, flights and designs come out the same when everything is compiled for another
//! processor.

use std::process::Command;
use std::time::Instant;

use anyhow::Result;

use crate::workspace::{cargo, root, run_quietly, target_directory};

/// What the compiler may use: what nearly all processors of the last 15 years have, what those of the last 10, and all of this one.
/// Without a word it is what every processor of 64 bits has.
const PROCESSORS: [&str; 3] = ["x86-64-v2", "x86-64-v3", "native"];

/// What is kept with the sources is taken over, but for a sample that is made anew and has to have the same bits.
const CHECK: [&str; 2] = ["reproduce-all", "--check"];

/// Builds the studies for each processor and lets them check what is kept.
pub(crate) fn run() -> Result<()> {
    for processor in PROCESSORS {
        let start = Instant::now();
        let target = target_directory()?.join("machines").join(processor);
        let mut build = cargo(&["build", "--release", "--package", "studies"])?;
        build.env("RUSTFLAGS", format!("-C target-cpu={processor}")).env("CARGO_TARGET_DIR", &target);
        run_quietly(&mut build)?;
        let program = target.join("release/studies").with_extension(std::env::consts::EXE_EXTENSION);
        run_quietly(Command::new(program).args(CHECK).current_dir(root()?))?;
        println!("{processor:10} the same, after {:.0} s", start.elapsed().as_secs_f64());
    }
    Ok(())
}
