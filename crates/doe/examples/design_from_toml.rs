//! From a problem in TOML to a design in CSV: `design_from_toml [problem.toml [design.csv]]`.
//!
//! Without a file to write to, the design is printed; the evaluation always is. Settings are rounded to within 1e-8 of their range, and
//! the figures are those of the design as it is written. More than 2000 runs need a limit in `seconds`. With `judged_levels`
//! the criterion is over that grid, while the evaluation below it is over the whole space. A search that takes long says on standard error how far it is.

mod problem;

use std::error::Error;
use std::io::{self, Write as _, stdout};
use std::process::ExitCode;
use std::sync::Mutex;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use doe::{Design, Found, Problem, Progress, RunOrder, Settings, StopReason, Watch, evaluate, search_watched};
use problem::ProblemFile;

const BUNDLED: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/rig.toml");

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    problem::finish(design(&arguments))
}

/// Time after which a search says how far it is, again and again.
const SILENCE: Duration = Duration::from_secs(5);

/// The search, with a word now and then.
fn search(problem: &Problem, settings: &Settings) -> Result<Found, doe::Error> {
    let (began, last) = (Instant::now(), Mutex::new(None::<Progress>));
    let (over, is_over) = channel::<()>();
    std::thread::scope(|scope| {
        scope.spawn(|| {
            let is_over = is_over;
            while is_over.recv_timeout(SILENCE) == Err(RecvTimeoutError::Timeout) {
                let reached = match last.lock().ok().and_then(|last| *last) {
                    Some(Progress { starts, best_percent, .. }) => {
                        format!("{starts} of {} starts, the best {best_percent:.3} %", settings.starts)
                    }
                    None => format!("the first of {} starts are on their way", settings.starts),
                };
                let hint = if settings.time_limit.is_none() { "; `seconds` in the file would limit it" } else { "" };
                // Where nobody listens the search goes on.
                let _ = writeln!(io::stderr(), "searching for {:.0} s: {reached}{hint}", began.elapsed().as_secs_f64());
            }
        });
        let mut note = |progress: Progress| {
            if let Ok(mut last) = last.lock() {
                *last = Some(progress);
            }
        };
        let found = search_watched(problem, settings, Watch { is_interrupted: None, progress: Some(&mut note) });
        drop(over);
        found
    })
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
    // Names that a file cannot hold are better refused before the search than after it.
    Design::new(region.n_parameters(), vec![0.0; region.n_parameters()])?.write_csv_with_kinds(
        &region,
        RunOrder::Standard,
        0,
        io::sink(),
    )?;
    let settings = file.settings()?;
    let found = search(&problem, &settings)?;
    let n_fixed = problem.fixed().map_or(0, Design::n_runs);
    let design = found.design.rounded(&region, problem.space(), n_fixed)?;
    design.check_within(problem.space())?;

    let order = file.order_seed.map_or(RunOrder::Standard, |seed| RunOrder::Random { seed: seed.0 });
    let mut text = Vec::new();
    design.write_csv_with_kinds(&region, order, n_fixed, &mut text)?;
    match csv {
        Some(path) => std::fs::write(path, text).map_err(|error| format!("{path}: {error}"))?,
        None => writeln!(stdout(), "{}", String::from_utf8(text)?)?,
    }
    let report = &found.report;
    let efficiency = problem.criterion().efficiency(problem.model(), problem.judged(), &design)?;
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
        writeln!(stdout())?;
        writeln!(
            io::stderr(),
            "warning: no start is whole: this is the best that the search had on its way, with more `seconds` it finds a better one"
        )?;
    } else {
        let starts = if report.starts == 1 { "start" } else { "starts" };
        let made = format!("found {times} in {} whole {starts}", report.starts);
        writeln!(stdout(), "{efficiency}, {made}{unfinished}; the search ended because {stop}\n")?;
    }
    writeln!(stdout(), "{}", evaluate(problem.model(), problem.space(), &design, &file.evaluation_settings())?)?;
    Ok(())
}
