//! What a campaign will cost at most.

use std::time::Duration;

use anyhow::Result;
use design_space::{Cell, Grid, Levels, Parameter};
use infuse::pooled::StopBy;
use page::Finding;
use serde_json::{Value, json};

use crate::campaign::{Budget, Campaign, Reserve, Stage};
use crate::findings::WITHOUT_RESERVE;
use crate::number::{count, grouped, percent, plain, seconds};
use crate::problem::{Problem, Scale, Simulator};
use crate::spread::spread;

/// Up to so many designs are counted one by one; of more a share is told from so many all over the grid.
const MOST_COUNTED: u64 = 500_000;
const SAMPLED: u64 = 50_000;

/// Whether the linear constraints allow a design.
pub(super) fn is_allowed(problem: &Problem, point: &[f64]) -> bool {
    problem.linear_constraints.iter().all(|linear| linear.allows(point))
}

/// In sentences, and for machines.
pub(super) fn in_words(
    campaign: &dyn Campaign,
    budget: &Budget,
    took: Option<Duration>,
) -> Result<(Vec<Finding>, Value)> {
    let problem = campaign.problem();
    let Budget { terms, experiments, batches, simulations, grid, without_reserve, .. } = budget;
    let allowed = allowed(problem, grid);
    let simulations_of_all = simulations_of_all(campaign, budget, allowed)?;
    let mut findings = vec![whole(budget, problem, allowed)];
    findings.extend(simulated(campaign, budget, took, simulations_of_all)?);
    let costs = problem.costs.as_ref().map(|costs| {
        let (of_batch, n_plants) = costs.at_most(*experiments);
        let in_all = of_batch * *batches as f64;
        let sentence = format!(
            "A batch costs up to {}: {} on up to {}; all of them up to {}.",
            costs.shown(of_batch),
            count(*experiments, "run"),
            count(n_plants, "plant"),
            costs.shown(in_all)
        );
        let finding = Finding::new(sentence).with("cost of a batch", of_batch, costs.unit());
        findings.push(finding.with("cost in all", in_all, costs.unit()));
        json!({ "batch": of_batch, "all": in_all, "unit": costs.unit(), "plants_per_batch": n_plants })
    });
    findings.extend(campaign.reserve()?.and_then(|reserve| reserved(reserve, budget, problem)));
    let choosing = campaign.dry_pick()?;
    findings.push(Finding::new(match choosing {
        Some(took) => format!(
            "To choose a batch takes some {} here, tried once on results made up; with every batch it takes longer.",
            seconds(took)
        ),
        None => "How long it takes to choose a batch is not known beforehand.".to_owned(),
    }));
    let json = json!({
        "parameters": problem.region.n_parameters(), "designs": designs(problem, grid),
        "designs_allowed": allowed.filter(|_| designs(problem, grid).is_some()).and_then(Allowed::exactly),
        "share_allowed": allowed.map(|allowed| allowed.share(grid)), "terms": terms,
        "experiments_per_batch": experiments, "batches": batches, "runs_at_most": experiments * batches,
        "simulations_per_batch": simulations, "simulations_made": simulations_of_all.n_made,
        "simulations_to_come": simulations_of_all.n_to_come, "simulations_at_most": simulations_of_all.at_most(), "costs": costs,
        "designs_without_reserve": without_reserve, "seconds_to_choose": choosing.map(|took| took.as_secs_f64()),
    });
    Ok((findings, json))
}

/// How many designs there are; nothing where a parameter can have any setting.
fn designs(problem: &Problem, grid: &Grid) -> Option<u64> {
    let is_counted = |parameter: &Parameter| parameter.levels() != Levels::Continuous;
    problem.region.parameters().iter().all(is_counted).then(|| grid.n_cells())
}

/// What the linear constraints leave of the grid.
#[derive(Debug, Clone, Copy)]
struct Allowed {
    n: u64,
    /// As many were looked at.
    of: u64,
    is_exact: bool,
}

impl Allowed {
    fn exactly(self) -> Option<u64> {
        self.is_exact.then_some(self.n)
    }

    fn share(self, grid: &Grid) -> f64 {
        let of = if self.is_exact { grid.n_cells() } else { self.of };
        self.n as f64 / of as f64
    }
}

/// None without linear constraints.
fn allowed(problem: &Problem, grid: &Grid) -> Option<Allowed> {
    if problem.linear_constraints.is_empty() {
        return None;
    }
    let n_cells = grid.n_cells();
    let is_kept = |cell: Cell| grid.point(cell).is_ok_and(|point| is_allowed(problem, &point));
    Some(match n_cells {
        few if few <= MOST_COUNTED => {
            let n = grid.cells().filter(|&cell| is_kept(cell)).count() as u64;
            Allowed { n, of: n_cells, is_exact: true }
        }
        many => {
            let n = (0..SAMPLED).filter(|&k| is_kept(Cell::new(spread(k, many)))).count() as u64;
            Allowed { n, of: SAMPLED, is_exact: false }
        }
    })
}

/// The campaign in one sentence.
fn whole(budget: &Budget, problem: &Problem, allowed: Option<Allowed>) -> Finding {
    let Budget { terms, experiments, batches, grid, .. } = budget;
    let terms = terms.map_or_else(String::new, |terms| format!("{}, ", count(terms, "term")));
    let of_them = allowed.map_or_else(String::new, |allowed| match allowed.exactly() {
        Some(n) => format!(", of which the linear constraints leave {}", grouped(n)),
        None => format!(", of which the linear constraints leave some {}", percent(allowed.share(grid))),
    });
    let designs = match designs(problem, grid) {
        Some(n) => format!("{} designs{of_them}", grouped(n)),
        None => format!("any design between the bounds ({} are compared{of_them})", grouped(grid.n_cells())),
    };
    let sentence = format!(
        "The campaign: {designs}; {terms}{} a batch, at most {}, so at most {}.",
        count(*experiments, "experiment"),
        count(*batches, "batch"),
        count(experiments * batches, "run")
    );
    Finding::new(sentence).with("runs at most", (experiments * batches) as f64, "1")
}

/// From when on the certificate is as narrow as what was measured says, unless it is.
fn reserved(reserve: Reserve, budget: &Budget, problem: &Problem) -> Option<Finding> {
    let Reserve { until: n, so_far, n_left } = reserve;
    let needed = ((n as f64 - so_far) / budget.experiments as f64).ceil() as usize;
    if needed == 0 {
        return None;
    }
    let (is_begun, is_enough) = (so_far > 0.0, needed <= n_left);
    let counted = match is_begun {
        true => format!(" ({} so far, a repeat counting half)", plain(so_far)),
        false => ", a repeat counting half".to_owned(),
    };
    let enough = match (is_enough, is_begun) {
        (true, false) => format!("in {} or more", count(needed, "batch")),
        (true, true) => format!("in {} or more", count(needed, "more batch")),
        (false, false) => "more than the campaign has".to_owned(),
        (false, true) => "more than is left of the campaign".to_owned(),
    };
    let out_of_reach = match problem.worth {
        None if problem.stop_by == Some(StopBy::Surface) => " `by` in [stop] ends nothing without `worth`.",
        Some(_) if problem.stop_by == Some(StopBy::Surface) => {
            " The campaign does not wait for that: it stops by the surface alone, as `by` in [stop] says."
        }
        Some(_) if !is_enough => {
            " So `worth` may never be met: raise `batches` in [loop], set `smooth` if it is so, or stop by the surface alone (`by` = \"surface\")."
        }
        _ => "",
    };
    let well = problem.response.well();
    let as_a_power = match (problem.response.scale, problem.response.least()) {
        (Scale::Log, None) => {
            " On a logarithmic scale that room is a power of what results differ by, which the best value that there can be bounds, as \
             `lower` or `upper` of [response]."
        }
        _ => "",
    };
    let sentence = format!(
        "Until {} run{counted}, {enough}, what the certificate promises leaves room for a \
         narrow {well}; `smooth` in [stop] says that there surely is none.{out_of_reach}{as_a_power}",
        if n == 1 { "one design was".to_owned() } else { format!("{n} designs were") }
    );
    Some(Finding::new(sentence).with(WITHOUT_RESERVE, n as f64, "1"))
}

/// Simulations of the whole campaign; none where they are looked up.
#[derive(Debug, Clone, Copy, Default)]
struct OfAll {
    /// Those that are in the journal.
    n_made: u64,
    /// At most.
    n_to_come: u64,
}

impl OfAll {
    fn at_most(self) -> u64 {
        self.n_made + self.n_to_come
    }
}

fn simulations_of_all(campaign: &dyn Campaign, budget: &Budget, allowed: Option<Allowed>) -> Result<OfAll> {
    if matches!(campaign.problem().simulator, Simulator::Nothing | Simulator::Table(_)) {
        return Ok(OfAll::default());
    }
    let n_made = campaign.simulations_made().len() as u64;
    let n_cells = allowed.and_then(Allowed::exactly).unwrap_or(budget.grid.n_cells());
    let n_waited = campaign.waits_for_simulations()?.len() as u64;
    let n_left = if has_ended(campaign)? { 0 } else { budget.n_left };
    let n_to_come = match (budget.simulations, campaign.experiments().last_batch()) {
        (None, _) => n_waited,
        // What of the first batch was made stays made.
        (Some(n), None) => ((n * n_left + budget.experiments) as u64).saturating_sub(n_made),
        (Some(n), Some(_)) => (n * n_left) as u64 + n_waited,
    };
    Ok(OfAll { n_made, n_to_come: n_to_come.min(n_cells.saturating_sub(n_made)) })
}

fn has_ended(campaign: &dyn Campaign) -> Result<bool> {
    Ok(matches!(campaign.stage()?, Stage::Ended { .. }))
}

/// What is simulated, and how long it takes.
fn simulated(campaign: &dyn Campaign, budget: &Budget, took: Option<Duration>, of_all: OfAll) -> Result<Vec<Finding>> {
    let jobs = match &campaign.problem().simulator {
        Simulator::Nothing => return Ok(Vec::new()),
        Simulator::Table(_) => return Ok(vec![Finding::new("A batch costs no simulation: they are looked up.")]),
        Simulator::Program { queue: Some(_), .. } => 1,
        Simulator::Program { jobs, .. } => (*jobs).max(1),
    };
    let time = |n: u64| {
        let time = took.map(|took| took.mul_f64(n.div_ceil(jobs as u64) as f64));
        time.map_or_else(String::new, |time| format!(", some {} at {jobs} at once", seconds(time)))
    };
    let OfAll { n_made, n_to_come } = of_all;
    let in_all = if n_made > 0 {
        let were = if n_made == 1 { "was" } else { "were" };
        format!("{} {were} made, and up to {} are to come{}.", count_of(n_made), grouped(n_to_come), time(n_to_come))
    } else {
        format!("That is up to {} in all{}.", count_of(n_to_come), time(n_to_come))
    };
    let in_all = Finding::new(in_all).with("simulations made", n_made as f64, "1");
    let in_all = in_all.with("simulations to come at most", n_to_come as f64, "1");
    if n_to_come == 0 && budget.simulations.is_some() {
        let sentence = format!("No simulation is to come any more: {}", made_so_far(n_made));
        return Ok(vec![Finding::new(sentence).with("simulations made", n_made as f64, "1")]);
    }
    let is_begun = campaign.experiments().last_batch().is_some();
    Ok(match (budget.simulations, is_begun) {
        (Some(n), _) => {
            let of_first = ((n + budget.experiments) as u64).min(of_all.at_most());
            let first = match is_begun {
                true => String::new(),
                false => format!("; the first up to {of_first}, as its experiments are simulated, too"),
            };
            let n = (n as u64).min(n_to_come);
            let sentence = format!("A batch costs up to {}{}{first}.", count_of(n), time(n));
            vec![Finding::new(sentence).with("simulations a batch", n as f64, "1").detail(in_all)]
        }
        (None, _) => vec![all_designs(is_begun || n_made > 0, n_to_come, &time(n_to_come))],
    })
}

/// Where all designs are simulated before the first batch.
fn all_designs(is_begun: bool, n_to_come: u64, time: &str) -> Finding {
    Finding::new(match (is_begun, n_to_come) {
        (false, n) => format!("Before the first batch all {} designs are simulated{time}; then none.", grouped(n)),
        (true, 0) => "A batch costs no simulation any more: all designs were simulated.".to_owned(),
        (true, n) => format!("Before the next batch {} are made{time}; then none.", count_of(n)),
    })
    .with("simulations", n_to_come as f64, "1")
}

fn made_so_far(n: u64) -> String {
    match n {
        0 => "none was made.".to_owned(),
        1 => "1 was made.".to_owned(),
        n => format!("{} were made.", grouped(n)),
    }
}

fn count_of(n: u64) -> String {
    if n == 1 { "1 simulation".to_owned() } else { format!("{} simulations", grouped(n)) }
}
