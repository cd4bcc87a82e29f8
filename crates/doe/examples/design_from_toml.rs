//! From a problem in TOML to a design in CSV: `design_from_toml [problem.toml [design.csv]]`.
//!
//! Without a file to write to, the design is printed; the evaluation always is. Settings have nine significant digits, and
//! the figures are those of the design as it is written.

mod problem;

use std::error::Error;
use std::io::{Write as _, stdout};
use std::process::ExitCode;

use doe::{Design, RunOrder, StopReason, evaluate, search};
use problem::ProblemFile;

const BUNDLED: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/rig.toml");

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    problem::finish(design(&arguments))
}

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
    let n_fixed = problem.fixed().map_or(0, Design::n_runs);
    let design = found.design.rounded(&region, problem.space(), n_fixed)?;
    design.check_within(problem.space())?;

    let order = file.order_seed.map_or(RunOrder::Standard, |seed| RunOrder::Random { seed });
    let mut text = Vec::new();
    design.write_csv_with_kinds(&region, order, n_fixed, &mut text)?;
    match csv {
        Some(path) => std::fs::write(path, text).map_err(|error| format!("{path}: {error}"))?,
        None => writeln!(stdout(), "{}", String::from_utf8(text)?)?,
    }
    let report = &found.report;
    let efficiency = problem.criterion().efficiency(problem.model(), problem.space(), &design)?;
    let times = match report.times_found {
        1 => "once".to_owned(),
        times => format!("{times} times"),
    };
    let stop = match report.stop {
        StopReason::StartsDone => "all starts were made",
        StopReason::TimeLimit => "the time was over",
        StopReason::TargetReached => "the target was reached",
        StopReason::Interrupted => "it was interrupted",
    };
    let unfinished = match report.unfinished {
        0 => String::new(),
        unfinished => format!(", {unfinished} {} left unfinished", if unfinished == 1 { "was" } else { "were" }),
    };
    if report.starts == 0 {
        writeln!(stdout(), "{efficiency}; the search ended because {stop}{unfinished}")?;
        writeln!(stdout(), "no start is whole: the search needs more time, this is the best that it had on its way\n")?;
    } else {
        let starts = if report.starts == 1 { "start" } else { "starts" };
        let made = format!("found {times} in {} whole {starts}", report.starts);
        writeln!(stdout(), "{efficiency}, {made}{unfinished}; the search ended because {stop}\n")?;
    }
    writeln!(stdout(), "{}", evaluate(problem.model(), problem.space(), &design, &file.evaluation_settings())?)?;
    Ok(())
}
