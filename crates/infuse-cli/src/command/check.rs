//! `infuse check`: whether a campaign is right, and what it will cost.

use std::path::Path;
use std::time::{Duration, Instant};

use anyhow::{Result, bail};
use design_space::{Grid, Levels};
use page::Finding;
use serde_json::{Value, json};

use super::Output;
use crate::campaign::{Budget, Campaign};
use crate::folder;
use crate::journal::{JOURNAL, Measured};
use crate::number::{count, grouped, plain, short, with_unit};
use crate::problem::{PROBLEM, Problem, Simulator};
use crate::program::{Ran, is_interrupted};
use crate::shell::{infuse, sheet_path};
use crate::simulator::table;

/// Designs that are tried until one gives a value: shares of the width of each parameter.
const TRIED: [f64; 3] = [0.5, 0.25, 0.75];

/// What trying the simulator gave.
#[derive(Debug)]
struct Tried {
    findings: Vec<Finding>,
    json: Value,
    /// Of one run, where it is a command.
    took: Option<Duration>,
}

pub(crate) fn check(folder: &Path) -> Result<Output> {
    let mut campaign = folder::read(folder)?;
    let notices = campaign.take_notices();
    let problem = campaign.problem();
    let budget = campaign.budget()?;
    let tried = try_simulator(folder, problem, &budget.grid)?;
    let mut findings = vec![right(problem)];
    findings.extend(tried.findings);
    findings.extend(costs(&budget, problem, tried.took));
    findings.push(files(&*campaign));
    let json = json!({
        "parameters": problem.region.n_parameters(), "designs": designs(problem, &budget.grid), "terms": budget.terms,
        "experiments_per_batch": budget.experiments, "batches": budget.batches,
        "runs_at_most": budget.experiments * budget.batches, "simulations_per_batch": budget.simulations,
        "simulation": tried.json, "seconds_per_simulation": tried.took.map(|took| took.as_secs_f64()),
        "experiments_made": campaign.experiments().n_made(),
    });
    Ok(Output::new(&findings, json, notices))
}

fn right(problem: &Problem) -> Finding {
    let parts = problem.region.parameters().iter().map(|parameter| {
        let levels = match parameter.levels() {
            Levels::Count(n) => count(n as usize, "setting"),
            Levels::Continuous => "any setting".to_owned(),
        };
        let bounds = match parameter.choices() {
            Some(choices) => return Finding::new(format!("{}: {}.", parameter.name(), choices.join(", "))),
            None => {
                format!("{} to {}", plain(parameter.lower()), with_unit(&plain(parameter.upper()), parameter.unit()))
            }
        };
        Finding::new(format!("{}: {bounds}, {levels}.", parameter.name()))
    });
    let response = &problem.response;
    let sentence = format!("{PROBLEM} is right. {} is better of {}.", response.better(), response.heading());
    let sentence = sentence.replace("right. lower", "right. Lower").replace("right. higher", "right. Higher");
    parts.fold(Finding::new(sentence), Finding::detail)
}

/// How many designs there are; nothing where a parameter can have any setting.
fn designs(problem: &Problem, grid: &Grid) -> Option<u64> {
    let is_counted = |parameter: &design_space::Parameter| parameter.levels() != Levels::Continuous;
    problem.region.parameters().iter().all(is_counted).then(|| grid.n_cells())
}

/// Looks designs up, or runs one.
fn try_simulator(folder: &Path, problem: &Problem, grid: &Grid) -> Result<Tried> {
    match &problem.simulator {
        Simulator::Table(path) => {
            let rows = table(&folder.join(path), problem, grid)?.len();
            let sentence = format!(
                "{}: {} of {} designs are simulated.",
                path.display(),
                grouped(rows as u64),
                grouped(grid.n_cells())
            );
            let finding = Finding::new(sentence).with("rows", rows as f64, "1");
            Ok(Tried { findings: vec![finding], json: json!({ "rows": rows }), took: None })
        }
        Simulator::Program { queue: Some(_), .. } => {
            let finding = Finding::new("The simulations run in a queue: none was tried.");
            Ok(Tried { findings: vec![finding], json: Value::Null, took: None })
        }
        Simulator::Program { program, .. } => {
            let (mut findings, mut reasons) = (Vec::new(), Vec::new());
            for share in TRIED {
                let middle: Vec<f64> =
                    problem.region.parameters().iter().map(|one| one.lower() + share * one.width()).collect();
                let point = grid.point(grid.nearest(&middle)?)?;
                let (start, at) = (Instant::now(), problem.describe(&point));
                match program.run(folder, &problem.region, &point, None)? {
                    Ran::Value(value, _) => {
                        let took = start.elapsed();
                        let value_said = with_unit(&plain(value), &problem.response.unit);
                        let sentence = format!("Tried one simulation: {at} gives {value_said}, in {}.", seconds(took));
                        findings.push(Finding::new(sentence).with("simulated", value, &problem.response.unit));
                        let json = json!({ "settings": problem.named(&point), "value": value, "failed": reasons });
                        return Ok(Tried { findings, json, took: Some(took) });
                    }
                    Ran::Failed(reason) => {
                        findings
                            .push(Finding::new(format!("Careful: the simulation of {at} gives no value: {reason}.")));
                        reasons.push(json!({ "settings": problem.named(&point), "reason": Measured::Failed(reason) }));
                    }
                    Ran::Interrupted => bail!("interrupted: nothing was written down"),
                }
                if is_interrupted() {
                    break;
                }
            }
            let said = findings.iter().map(Finding::sentence).collect::<Vec<_>>().join("\n  ");
            bail!("{PROBLEM} is right, but the simulator gave no value at {} designs:\n  {said}", TRIED.len())
        }
    }
}

fn seconds(took: Duration) -> String {
    let seconds = took.as_secs_f64();
    match seconds {
        _ if seconds < 90.0 => format!("{} s", short((100.0 * seconds).ceil() / 100.0)),
        _ if seconds < 5400.0 => format!("{} min", short((seconds / 6.0).round() / 10.0)),
        _ => format!("{} h", short((seconds / 360.0).round() / 10.0)),
    }
}

/// What the campaign will cost at most.
fn costs(budget: &Budget, problem: &Problem, took: Option<Duration>) -> Vec<Finding> {
    let Budget { terms, experiments, batches, simulations, grid } = budget;
    let terms = terms.map_or_else(String::new, |terms| format!("{}, ", count(terms, "term")));
    let designs = match designs(problem, grid) {
        Some(n) => format!("{} designs", grouped(n)),
        None => format!("any design between the bounds ({} are compared)", grouped(grid.n_cells())),
    };
    let sentence = format!(
        "The campaign: {designs}; {terms}{} a batch, at most {}, so at most {}.",
        count(*experiments, "experiment"),
        count(*batches, "batch"),
        count(experiments * batches, "run")
    );
    let mut findings = vec![Finding::new(sentence).with("runs at most", (experiments * batches) as f64, "1")];
    let jobs = match &problem.simulator {
        Simulator::Table(_) => None,
        Simulator::Program { jobs, queue, .. } => Some(if queue.is_some() { 1 } else { *jobs }),
    };
    findings.push(match (jobs, simulations) {
        (None, _) => Finding::new("A batch costs no simulation: they are looked up."),
        (Some(jobs), Some(n)) => {
            let time = took.map(|took| took.mul_f64(n.div_ceil(jobs.max(1)) as f64));
            let time = time.map_or_else(String::new, |time| format!(", some {} at {jobs} at once", seconds(time)));
            let sentence = format!("A batch costs up to {}{time}.", count(*n, "simulation"));
            Finding::new(sentence).with("simulations a batch", *n as f64, "1")
        }
        (Some(jobs), None) => {
            let n = grid.n_cells();
            let time = took.map(|took| took.mul_f64(n.div_ceil(jobs.max(1) as u64) as f64));
            let time = time.map_or_else(String::new, |time| format!(", some {} at {jobs} at once", seconds(time)));
            let sentence = format!("Before the first batch all {} designs are simulated{time}; then none.", grouped(n));
            Finding::new(sentence).with("simulations", n as f64, "1")
        }
    });
    findings
}

fn files(campaign: &dyn Campaign) -> Finding {
    let (folder, problem) = (campaign.folder(), campaign.problem());
    let first = sheet_path(folder, problem.sheets, campaign.experiments().last_batch().unwrap_or(0) + 1, None);
    let n = campaign.experiments().n_made();
    let so_far = if n > 0 { format!(" Told so far: {}.", count(n, "experiment")) } else { String::new() };
    Finding::new(format!(
        "The next sheet will be {}, the journal {}.{so_far} Next: {} ask",
        first.display(),
        if folder == Path::new(".") { JOURNAL.to_owned() } else { folder.join(JOURNAL).display().to_string() },
        infuse(folder)
    ))
}
