//! From a problem in TOML to a design in CSV: `design_from_toml [problem.toml [design.csv]]`.
//!
//! Without a file to write to, the design is printed; the evaluation always is.

mod problem;

use std::error::Error;
use std::process::ExitCode;

use doe::{RunOrder, evaluate, search};
use problem::ProblemFile;

const BUNDLED: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/rig.toml");

#[expect(clippy::print_stderr, reason = "this is where a program complains")]
fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match design(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

#[expect(clippy::print_stdout, reason = "an example shows what it computes")]
fn design(arguments: &[String]) -> Result<(), Box<dyn Error>> {
    let (file, csv) = match arguments {
        [] => (BUNDLED, None),
        [file] => (file.as_str(), None),
        [file, csv] => (file.as_str(), Some(csv)),
        _ => return Err("expected at most two arguments: problem.toml design.csv".into()),
    };
    let file = ProblemFile::read(file)?;
    let (region, problem) = (file.region()?, file.problem()?);
    let found = search(&problem, &file.settings()?)?;
    found.design.check_within(problem.space())?;

    let order = file.order_seed.map_or(RunOrder::Standard, |seed| RunOrder::Random { seed });
    let mut text = Vec::new();
    found.design.write_csv(&region, order, &mut text)?;
    match csv {
        Some(path) => std::fs::write(path, text).map_err(|error| format!("{path}: {error}"))?,
        None => println!("{}", String::from_utf8(text)?),
    }
    let report = &found.report;
    println!("{}, best of {} starts, found {} times\n", found.efficiency, report.starts, report.times_found);
    println!("{}", evaluate(problem.model(), problem.space(), &found.design, &file.evaluation_settings())?);
    Ok(())
}
