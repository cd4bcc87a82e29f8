//! Where runs and simulations gave no value, in a sentence each.

use std::collections::BTreeMap;

use anyhow::Result;
use design_space::Parameter;
use page::Finding;
use serde_json::{Value, json};

use super::campaign::{Access, Campaign};
use crate::campaign::{FailedSimulation, failed_in_words};
use crate::echo::echo;
use crate::journal::Measured;
use crate::number::{count, grouped, plain, with_unit};
use crate::problem::{Simulator, shown};
use crate::simulator::identity;

/// Where runs fail is called a region of one parameter if no larger share of the runs in it gave a value.
const FEW: f64 = 0.25;
/// So many are named where no parameter tells.
const MOST_NAMED: usize = 3;

/// Where runs gave no value: one by its settings, several by the parameter that tells them from the others, if one does.
pub(super) fn where_runs_fail(campaign: &Campaign) -> Option<Finding> {
    let (failed, worked) = settings_by_outcome(campaign);
    let (n, n_all) = (failed.len(), failed.len() + worked.len());
    if failed.is_empty() || worked.is_empty() {
        return None;
    }
    let place = match failed.as_slice() {
        [only] => campaign.problem.describe(only),
        _ => {
            let parameters = campaign.grid.region().parameters().iter().enumerate();
            let regions = parameters.flat_map(|(at, parameter)| regions(parameter, at, &failed, &worked));
            let clearest = regions.min_by(|a, b| a.share(n).total_cmp(&b.share(n)));
            // What holds for nearly all runs tells none from the others.
            let tells = |region: &Region| region.share(n) <= FEW && 2 * region.n_worked <= worked.len();
            match clearest.filter(tells) {
                Some(Region { words, n_worked: 0 }) => format!("all with {words}, where no run gave one"),
                Some(Region { words, n_worked }) => {
                    format!("all with {words}, where {n_worked} of {} gave one", count(n + n_worked, "run"))
                }
                None if n <= MOST_NAMED => {
                    let each = failed.iter().map(|settings| campaign.problem.describe(settings));
                    each.collect::<Vec<_>>().join("; ")
                }
                None => "no parameter alone tells where; the maps of `infuse report` show it".to_owned(),
            }
        }
    };
    let why = reasons(campaign).map_or_else(String::new, |why| format!(" {why}"));
    let sentence = format!("No value from {n} of {}: {place}.{why}", count(n_all, "run"));
    Some(Finding::new(sentence).with("runs without a value", n as f64, "1"))
}

/// What was told as the reason why runs gave no value, the most frequent ones first.
fn reasons(campaign: &Campaign) -> Option<String> {
    let imported = campaign.imported.iter().map(|one| &one.result);
    let own = campaign.experiments.readings.values().filter(|reading| reading.values().next().is_none());
    let own = own.flat_map(|reading| reading.first.iter().chain(reading.again.values()));
    let mut of_each: BTreeMap<&str, usize> = BTreeMap::new();
    for result in imported.chain(own) {
        if let Measured::Failed(reason) = result {
            *of_each.entry(reason.trim()).or_default() += 1;
        }
    }
    let mut told: Vec<(&str, usize)> = of_each.into_iter().filter(|(reason, _)| !reason.is_empty()).collect();
    told.sort_by_key(|&(_, n)| std::cmp::Reverse(n));
    let (head, n) = (if told.len() == 1 { "Reason told" } else { "Reasons told" }, told.len());
    let named = told.iter().take(MOST_NAMED).map(|&(reason, n_runs)| match n {
        1 => echo(reason),
        _ => format!("{} ({})", echo(reason), count(n_runs, "run")),
    });
    let named = named.collect::<Vec<_>>().join("; ");
    let more = if n > MOST_NAMED { format!("; and {} more", n - MOST_NAMED) } else { String::new() };
    (n > 0).then(|| format!("{head}: {named}{more}."))
}

/// Settings of one parameter, which all runs have that failed, and how many of those that did not.
struct Region {
    words: String,
    n_worked: usize,
}

impl Region {
    fn share(&self, n_failed: usize) -> f64 {
        self.n_worked as f64 / (self.n_worked + n_failed) as f64
    }
}

/// From the lowest setting that failed on, up to the highest, between both, and outside of what worked; of a choice the one that all
/// have.
fn regions(parameter: &Parameter, at: usize, failed: &[Vec<f64>], worked: &[Vec<f64>]) -> Vec<Region> {
    let setting = |settings: &Vec<f64>| settings[at];
    let lowest = failed.iter().map(setting).fold(f64::INFINITY, f64::min);
    let highest = failed.iter().map(setting).fold(f64::NEG_INFINITY, f64::max);
    let region = |words: String, is_in: &dyn Fn(f64) -> bool| {
        let n_worked = worked.iter().map(setting).filter(|&setting| is_in(setting)).count();
        Region { words, n_worked }
    };
    let said = |value: f64| with_unit(&shown(parameter, value), parameter.unit());
    if parameter.choices().is_some() {
        let is_one = lowest.to_bits() == highest.to_bits();
        let words = format!("{} {}", parameter.name(), said(lowest));
        return is_one.then(|| region(words, &|value| value.to_bits() == lowest.to_bits())).into_iter().collect();
    }
    // The widest gap without failures between the lowest and the highest.
    let mut ordered: Vec<f64> = failed.iter().map(setting).collect();
    ordered.sort_by(f64::total_cmp);
    let gap = ordered.windows(2).map(|pair| (pair[0], pair[1])).max_by(|a, b| (a.1 - a.0).total_cmp(&(b.1 - b.0)));
    let (low, high) = gap.unwrap_or((lowest, highest));
    let name = parameter.name();
    vec![
        region(format!("{name} {} or more", said(lowest)), &|value| value >= lowest),
        region(format!("{name} {} or less", said(highest)), &|value| value <= highest),
        region(format!("{name} {} to {}", plain(lowest), said(highest)), &|value| (lowest..=highest).contains(&value)),
        region(format!("{name} up to {} or from {} on", plain(low), said(high)), &|value| {
            value <= low || value >= high
        }),
    ]
}

/// Settings of the runs, as they were made: those that gave no value, and the others.
fn settings_by_outcome(campaign: &Campaign) -> (Vec<Vec<f64>>, Vec<Vec<f64>>) {
    let imported = campaign.imported.iter().map(|one| (one.point.clone(), one.result.value().is_some()));
    let told = campaign.experiments.readings.iter();
    let told = told.filter(|(_, reading)| reading.first.is_some() || reading.values().next().is_some());
    let own = told.map(|(&id, reading)| (campaign.experiments.settings_of(id), reading.values().next().is_some()));
    let (worked, failed): (Vec<_>, Vec<_>) = imported.chain(own).partition(|(_, has_value)| *has_value);
    let settings = |runs: Vec<(Vec<f64>, bool)>| runs.into_iter().map(|(settings, _)| settings).collect();
    (settings(failed), settings(worked))
}

/// Settings of the runs that gave no value, as they were made.
pub(super) fn settings_that_failed(campaign: &Campaign) -> Vec<Vec<f64>> {
    settings_by_outcome(campaign).0
}

/// Simulations that failed, of those that were made by the simulator as it is; or designs that its table does not have, where it has
/// most.
pub(super) struct FailedSimulations {
    failed: Vec<FailedSimulation>,
    n_all: usize,
    table: Option<String>,
}

/// So many are told to machines; the page has more.
const MOST_TOLD: usize = 100;

impl FailedSimulations {
    pub(super) fn of(campaign: &Campaign) -> Result<Self> {
        let (mut failed, mut n_all, mut table) = (Vec::new(), 0, None);
        match &campaign.problem.simulator {
            Simulator::Nothing => {}
            Simulator::Table(path) if campaign.access()? == Access::LookedUp => {
                let rows = campaign.rows()?;
                // Most tables have every design.
                let is_whole = rows.len() as u64 == campaign.grid.n_cells();
                n_all = if is_whole { rows.len() } else { 0 };
                let reason = format!("no row in {}", path.display());
                table = Some(path.display().to_string());
                let cells = (!is_whole).then(|| campaign.grid.cells()).into_iter().flatten();
                for cell in cells.filter(|&cell| campaign.empty.allows(cell)) {
                    n_all += 1;
                    if rows.get(cell).is_none() {
                        let point = campaign.grid.point(cell)?;
                        failed.push(FailedSimulation { cell, point, reason: reason.clone() });
                    }
                }
            }
            // What is between the rows of a table with few of them is not missing.
            Simulator::Table(_) => {}
            Simulator::Program { .. } => {
                let by = identity(&campaign.problem.simulator);
                for (&cell, known) in campaign.memory.iter().filter(|(_, known)| known.by == by) {
                    n_all += 1;
                    if let Measured::Failed(reason) = &known.result {
                        let (point, reason) = (campaign.grid.point(cell)?, reason.clone());
                        failed.push(FailedSimulation { cell, point, reason });
                    }
                }
                failed.sort_by_key(|one| one.cell);
            }
        }
        Ok(Self { failed, n_all, table })
    }

    pub(super) fn in_words(&self, campaign: &Campaign) -> Option<Finding> {
        let n = self.failed.len();
        let sentence = match &self.table {
            Some(table) if n > 0 => {
                let named = self.failed.iter().take(MOST_NAMED).map(|one| campaign.problem.describe(&one.point));
                let named = named.collect::<Vec<_>>().join("; ");
                let more = match n.saturating_sub(MOST_NAMED) {
                    0 => String::new(),
                    more => format!("; and {} more", grouped(more as u64)),
                };
                let have = if n == 1 { "has" } else { "have" };
                format!(
                    "{} of {} {have} no row in {table}: {named}{more}",
                    grouped(n as u64),
                    count(self.n_all, "design")
                )
            }
            _ => failed_in_words(&campaign.problem, self.n_all, &self.failed)?,
        };
        Some(Finding::new(format!("{sentence}.")).with("simulations that failed", n as f64, "1"))
    }

    pub(super) fn as_json(&self, campaign: &Campaign) -> Value {
        let first = self.failed.iter().take(MOST_TOLD);
        let first = first.map(|one| json!({ "settings": campaign.problem.named(&one.point), "reason": one.reason }));
        json!({ "failed": self.failed.len(), "of": self.n_all, "first": first.collect::<Vec<_>>() })
    }
}
