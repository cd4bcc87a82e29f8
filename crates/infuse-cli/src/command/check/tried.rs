//! The commands of a campaign, tried once.

use std::path::Path;
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result, bail, ensure};
use design_space::{Cell, Grid};
use page::Finding;
use serde_json::{Value, json};

use super::budget::is_allowed;
use crate::campaign::{Campaign, checked};
use crate::journal::Measured;
use crate::number::{count, grouped, plain, seconds, with_unit};
use crate::problem::{PROBLEM, Problem, Program, Simulator};
use crate::program::{Ran, is_interrupted};
use crate::simulator::looked_up;
use crate::spread::spread;

/// Designs that are tried until one gives a value: shares of the width of each parameter.
const SHARES: [f64; 3] = [0.5, 0.25, 0.75];
/// Where the settings are confined, so many designs all over the grid are looked at for others.
const LOOKED_AT: u64 = 20_000;

/// What trying the commands gave.
#[derive(Debug)]
pub(super) struct Tried {
    pub(super) findings: Vec<Finding>,
    pub(super) json: Value,
    /// Of one simulation, where it is a command.
    pub(super) took: Option<Duration>,
    /// Whether the design that was tried can be built, where a command says so.
    pub(super) can_be_built: Option<bool>,
}

/// Looks the simulation up or runs it, and asks whether the same design can be built.
pub(super) fn try_commands(campaign: &dyn Campaign, grid: &Grid) -> Result<Tried> {
    let (folder, problem) = (campaign.folder(), campaign.problem());
    let designs = designs(problem, grid)?;
    let mut tried = match is_known(problem, &campaign.simulations_made()) {
        Some(known) => known,
        None => try_simulator(folder, problem, grid, &designs)?,
    };
    if let (Some(program), Some(point)) = (&problem.can_be_built, designs.first()) {
        let (start, at) = (Instant::now(), problem.describe(point));
        let can_be_built = program
            .says_yes(folder, &problem.region, point)
            .with_context(|| format!("{PROBLEM}: [can_be_built] at {at}"))?;
        let word = if can_be_built { "can" } else { "cannot" };
        let sentence = format!("Asked [can_be_built] once: {at} {word} be built, in {}.", seconds(start.elapsed()));
        tried.findings.push(Finding::new(sentence));
        tried.can_be_built = Some(can_be_built);
    }
    Ok(tried)
}

/// Designs that are as good to try as any: those that the linear constraints allow.
fn designs(problem: &Problem, grid: &Grid) -> Result<Vec<Vec<f64>>> {
    let n = grid.n_cells();
    let mut points = Vec::new();
    for share in SHARES {
        let parameters = problem.region.parameters().iter();
        let middle: Vec<f64> = parameters.map(|one| one.lower() + share * one.width()).collect();
        points.push(grid.point(grid.nearest_clamped(&middle)?)?);
    }
    points.retain(|point| is_allowed(problem, point));
    let others = (1..LOOKED_AT.min(n)).filter_map(|k| grid.point(Cell::new(spread(k, n))).ok());
    let missing = SHARES.len() - points.len();
    points.extend(others.filter(|point| is_allowed(problem, point)).take(missing));
    ensure!(
        !points.is_empty(),
        "{PROBLEM}: of {} designs the linear constraints leave none",
        grouped(LOOKED_AT.min(n))
    );
    Ok(points)
}

/// What the journal has of the command need not be run again; one that never gave a value is tried.
fn is_known(problem: &Problem, made: &[Measured]) -> Option<Tried> {
    let values: Vec<f64> = made.iter().filter_map(Measured::value).collect();
    if problem.simulator.queue().is_some() || values.is_empty() {
        return None;
    }
    let n = count(made.len(), "simulation");
    let sentence = format!(
        "The journal has {n} by this command, so it was not tried; `infuse ask --resimulate` makes all anew, if the program behind it is another."
    );
    let mut finding = Finding::new(sentence).with("simulations made", made.len() as f64, "1");
    if values.len() > 1 && values.windows(2).all(|two| two[0].to_bits() == two[1].to_bits()) {
        finding = finding.detail(Finding::new(ALL_THE_SAME));
    }
    Some(Tried { findings: vec![finding], json: json!({ "made": made.len() }), took: None, can_be_built: None })
}

/// What is said of a simulation that tells no designs apart.
const ALL_THE_SAME: &str = "Careful: all of them have the same value: such a simulation tells nothing.";

fn try_simulator(folder: &Path, problem: &Problem, grid: &Grid, designs: &[Vec<f64>]) -> Result<Tried> {
    let nothing =
        |finding: Finding, json: Value| Tried { findings: vec![finding], json, took: None, can_be_built: None };
    match &problem.simulator {
        Simulator::Nothing => Ok(nothing(
            Finding::new("There is no [simulator]: experiments alone tell which designs are good."),
            Value::Null,
        )),
        Simulator::Table(path) => {
            let rows = looked_up(folder, path, problem, grid)?;
            let n = rows.len();
            let (n_rows, n_cells) = (grouped(n as u64), grouped(grid.n_cells()));
            let sentence = format!("{}: {n_rows} of {n_cells} designs are simulated.", path.display());
            let mut finding = Finding::new(sentence).with("rows", n as f64, "1");
            if n > 1 && rows.values().windows(2).all(|two| two[0].to_bits() == two[1].to_bits()) {
                finding = finding.detail(Finding::new(ALL_THE_SAME));
            }
            Ok(nothing(finding, json!({ "rows": n })))
        }
        Simulator::Program { queue: Some(_), .. } => {
            Ok(nothing(Finding::new("The simulations run in a queue: none was tried."), Value::Null))
        }
        Simulator::Program { program, .. } => run_one(folder, problem, program, designs),
    }
}

/// A second simulation is tried if the first one took no longer.
const QUICK: Duration = Duration::from_secs(5);

/// What another design gives: the very same value, another or none.
fn elsewhere(
    folder: &Path,
    problem: &Problem,
    program: &Program,
    others: &[Vec<f64>],
    value: f64,
    took: Duration,
) -> Result<Option<Finding>> {
    let Some(other) = others.first().filter(|_| took <= QUICK) else { return Ok(None) };
    Ok(match program.run(folder, &problem.region, other, None)? {
        Ran::Value { value: there, .. } if there.to_bits() == value.to_bits() => {
            let at = problem.describe(other);
            Some(Finding::new(format!("Careful: {at} gives exactly the same: does the simulation take its settings?")))
        }
        Ran::Interrupted => bail!("interrupted: nothing was written down"),
        Ran::Value { .. } => {
            Some(Finding::new("A second one, elsewhere, gives another value: it takes its settings. Neither is kept."))
        }
        Ran::Failed(reason) => {
            let at = problem.describe(other);
            Some(Finding::new(format!("A second one, at {at}, gives no value: {reason}. Neither is kept.")))
        }
    })
}

/// Runs the simulation of one design after the other until one gives a value.
fn run_one(folder: &Path, problem: &Problem, program: &Program, designs: &[Vec<f64>]) -> Result<Tried> {
    let (mut findings, mut reasons) = (Vec::new(), Vec::new());
    for (tried, point) in designs.iter().enumerate() {
        let (start, at) = (Instant::now(), problem.describe(point));
        match program.run(folder, &problem.region, point, None)? {
            Ran::Value { value, others, .. } => {
                let took = start.elapsed();
                if let (Measured::Failed(reason), _) = checked(problem, Measured::Value(value), others.clone()) {
                    findings.push(Finding::new(format!("Careful: the simulation of {at} counts as failed: {reason}.")));
                    reasons.push(json!({ "settings": problem.named(point), "reason": Measured::Failed(reason) }));
                    continue;
                }
                let others = problem.of_constraints(others);
                let mut said = vec![with_unit(&plain(value), &problem.response.unit)];
                let (known, unknown): (Vec<_>, Vec<_>) =
                    problem.constraints.iter().partition(|held| others.contains_key(held.name()));
                said.extend(
                    known
                        .iter()
                        .map(|held| format!("{} {}", held.name(), with_unit(&plain(others[held.name()]), &held.unit))),
                );
                let sentence = format!("Tried one simulation: {at} gives {}, in {}.", said.join(", "), seconds(took));
                let mut finding = Finding::new(sentence).with("simulated", value, &problem.response.unit);
                for held in unknown {
                    let sentence = format!("It says nothing of {}: experiments alone will.", held.name());
                    finding = finding.detail(Finding::new(sentence));
                }
                finding = elsewhere(folder, problem, program, &designs[tried + 1..], value, took)?
                    .into_iter()
                    .fold(finding, Finding::detail);
                findings.push(finding);
                let json = json!({
                    "settings": problem.named(point), "value": value, "constrained": others, "failed": reasons,
                });
                return Ok(Tried { findings, json, took: Some(took), can_be_built: None });
            }
            Ran::Failed(reason) => {
                findings.push(Finding::new(format!("Careful: the simulation of {at} gives no value: {reason}.")));
                reasons.push(json!({ "settings": problem.named(point), "reason": Measured::Failed(reason) }));
            }
            Ran::Interrupted => bail!("interrupted: nothing was written down"),
        }
        if is_interrupted() {
            break;
        }
    }
    let said = findings.iter().map(Finding::sentence).collect::<Vec<_>>().join("\n  ");
    let n = count(designs.len(), "design");
    bail!("{PROBLEM} is right, but the simulator gave no value at {n}:\n  {said}")
}
