//! What a design in a file is worth: `evaluate_design [problem.toml design.csv [evaluation.json]]`.
//!
//! Of the problem the parameters, the model and the forbidden combinations count.

mod problem;

use std::error::Error;
use std::fs::File;
use std::io::{Write as _, stdout};
use std::process::ExitCode;

use doe::{Design, evaluate};
use problem::ProblemFile;

const BUNDLED: [&str; 2] = [
    concat!(env!("CARGO_MANIFEST_DIR"), "/examples/rig.toml"),
    concat!(env!("CARGO_MANIFEST_DIR"), "/examples/handmade.csv"),
];

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    problem::finish(score(&arguments))
}

fn score(arguments: &[String]) -> Result<(), Box<dyn Error>> {
    let (problem, csv, json) = match arguments {
        [] => (BUNDLED[0], BUNDLED[1], None),
        [problem, csv] => (problem.as_str(), csv.as_str(), None),
        [problem, csv, json] => (problem.as_str(), csv.as_str(), Some(json)),
        _ => return Err("expected none, two or three arguments: problem.toml design.csv evaluation.json".into()),
    };
    let file = ProblemFile::read(problem)?;
    let reader = File::open(csv).map_err(|error| format!("{csv}: {error}"))?;
    let read = Design::read_csv(&file.region()?, reader).map_err(|error| format!("{csv}: {error}"))?;
    let evaluation = evaluate(&file.model()?, &file.space()?, &read.design, &file.evaluation_settings())?;
    writeln!(stdout(), "{evaluation}")?;
    if !read.ignored.is_empty() {
        writeln!(stdout(), "not read: {}", read.ignored.join(", "))?;
    }
    if let Some(path) = json {
        serde_json::to_writer_pretty(File::create(path).map_err(|error| format!("{path}: {error}"))?, &evaluation)?;
    }
    Ok(())
}
