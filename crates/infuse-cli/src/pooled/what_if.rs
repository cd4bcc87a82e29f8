//! What is expected of designs that a person asks about.

use std::path::Path;

use anyhow::{Context as _, Result};
use design_space::{Cell, Combinations};
use infuse::pooled::{Expectation, Standing};
use page::Finding;
use serde_json::{Value, json};

use super::bands::NINE_IN_TEN;
use super::bounds::as_json;
use super::campaign::Campaign;
use super::findings::standing_in_words;
use crate::disk::replace;
use crate::journal::Measured;
use crate::number::{are_written_alike, count, resolved, short};
use crate::problem::{Goal, Response, heading, written};

/// Rows of a table over the grid, at most.
const MOST_ROWS: u64 = 20_000;

impl Campaign {
    /// The design next to what was asked for, in words that say so if it is another.
    pub(super) fn nearest(&self, asked: &[f64]) -> Result<(String, Cell)> {
        self.problem.region.coded(asked)?;
        let cell = self.grid.nearest(asked)?;
        let point = self.grid.point(cell)?;
        let is_off = point.iter().zip(asked).any(|(level, asked)| !are_written_alike(*level, *asked));
        let nearest = if is_off { "The nearest design that can be set, " } else { "" };
        Ok((format!("{nearest}{}", self.problem.describe(&point)), cell))
    }

    /// What is known of a design, beside the recommended one.
    pub(super) fn standing(&self, cell: Cell) -> Result<Option<Standing>> {
        let found = self.with_loop(|now, simulate| now.standings(&[cell], simulate))?;
        Ok(found.and_then(|found| found.into_iter().next()))
    }

    /// What is expected of designs.
    pub(super) fn expectations(&self, cells: &[Cell]) -> Result<Option<Vec<Expectation>>> {
        self.with_loop(|now, simulate| now.expectations(cells, simulate))
    }

    /// Runs of a design that are planned and have no result.
    pub(super) fn n_waited_for_at(&self, cell: Cell) -> usize {
        let there = self.experiments.trials.values().filter(|trial| trial.cell == cell);
        there.filter(|trial| !self.experiments.has_result(trial.id)).count()
    }

    /// Why a run of a design failed, if one did and none gave a value.
    pub(super) fn failure_at(&self, cell: Cell) -> Option<String> {
        let readings = self.experiments.trials.values().filter(|trial| trial.cell == cell);
        let readings: Vec<_> = readings.filter_map(|trial| self.experiments.readings.get(&trial.id.number())).collect();
        if readings.iter().any(|reading| reading.values().next().is_some()) {
            return None;
        }
        readings.iter().find_map(|reading| match &reading.first {
            Some(Measured::Failed(reason)) => Some(reason.clone()),
            _ => None,
        })
    }
}

/// What is expected of one design.
pub(super) fn of_design(campaign: &Campaign, asked: &[f64]) -> Result<(Vec<Finding>, Value)> {
    let (_, cell) = campaign.nearest(asked)?;
    let standing = campaign.standing(cell)?.context("no experiment gave a result yet, so nothing is expected")?;
    let (problem, response) = (&campaign.problem, &campaign.problem.response);
    let assessment = campaign.assessment()?;
    let noise = assessment.as_ref().map_or(0.0, |found| found.noise.hypot(found.assembly.unwrap_or(0.0)));
    let has_band = assessment.is_some_and(|found| found.needed.is_none());
    let half = NINE_IN_TEN * standing.deviation.hypot(noise);
    let costs = low_and_high(response, standing.mean, half);
    let values = costs.map(|cost| response.of_cost(cost));
    let sentence = format!(
        "One run there would read {} to {}, nine times in ten.",
        response.value_to(costs[0], half),
        response.value_to(costs[1], half)
    );
    let (half, unit) = (response.of_difference(half), response.unit_of_differences());
    let one_run = Finding::new(sentence).with("give or take", half, unit);
    let json = json!({
        "settings": problem.named(&standing.point), "expected": response.of_cost(standing.mean),
        "deviation": has_band.then(|| response.of_difference(standing.deviation)), "one_run": has_band.then_some(values), "probability_better": standing.probability_better,
        "probability_of_a_value": standing.feasible, "constraints": as_json(campaign, &standing.constrained), "runs": standing.n_readings,
        "measured": standing.measured.map(|cost| response.of_cost(cost)),
    });
    let cannot = campaign.cannot_be_built(cell)?.then(|| {
        Finding::new("It cannot be built, says the command of [can_be_built]: it is neither asked for nor recommended.")
    });
    let one_run = (has_band && campaign.failure_at(cell).is_none()).then_some(one_run);
    Ok((vec![standing_in_words(campaign, asked)?].into_iter().chain(one_run).chain(cannot).collect(), json))
}

/// The same over the grid, as a table. How many rows it has.
pub(super) fn over_the_grid(campaign: &Campaign, path: &Path) -> Result<(Vec<Finding>, Value)> {
    let (problem, response) = (&campaign.problem, &campaign.problem.response);
    let cells = some_cells(campaign);
    let found = campaign.expectations(&cells)?.context("no experiment gave a result yet, so nothing is expected")?;
    let has_band = campaign.assessment()?.is_some_and(|found| found.needed.is_none());
    let mut table = csv::Writer::from_writer(Vec::new());
    let mut headings: Vec<String> = problem.region.parameters().iter().map(|p| heading(p.name(), p.unit())).collect();
    let of_response =
        ["expected", "lowest", "highest"].map(|word| heading(&format!("{word} {}", response.name), &response.unit));
    headings.extend(of_response);
    headings.push("probability of a value".to_owned());
    for held in &problem.constraints {
        headings.push(heading(&format!("expected {}", held.name()), &held.unit));
        headings.push(format!("probability of {} {}", held.name(), held.bounds()));
    }
    table.write_record(&headings)?;
    for (&cell, expectation) in cells.iter().zip(&found) {
        let point = campaign.grid.point(cell)?;
        let settings = problem.region.parameters().iter().zip(&point);
        let mut row: Vec<String> = settings.map(|(parameter, &value)| written(parameter, value)).collect();
        let half = NINE_IN_TEN * expectation.deviation;
        // A tenth of the band and less says nothing.
        let known_to = half / 10.0;
        row.push(response.number_to(expectation.mean, known_to));
        for end in low_and_high(response, expectation.mean, half) {
            row.push(if has_band { response.number_to(end, known_to) } else { String::new() });
        }
        row.push(short(expectation.feasible));
        for there in &expectation.constrained {
            row.push(there.expected.map_or_else(String::new, |(mean, deviation)| resolved(mean, deviation / 10.0)));
            row.push(short(there.within));
        }
        table.write_record(&row)?;
    }
    let bytes = table.into_inner().map_err(|error| anyhow::anyhow!("{}: {error}", path.display()))?;
    replace(path, &bytes)?;
    let n_cells = campaign.grid.n_cells();
    let which = if (cells.len() as u64) < n_cells { "designs all over the grid" } else { "all designs" };
    let rows = count(cells.len(), "row");
    let typical = found.iter().map(|expectation| NINE_IN_TEN * expectation.deviation).fold(0.0, f64::max);
    let (lowest, widest) = match has_band {
        true => (
            "lowest and highest leave out one in ten",
            format!("The widest band is give or take {}.", response.amount(typical)),
        ),
        false => (
            "lowest and highest are empty",
            "How far off what is expected may be, so few results cannot tell.".to_owned(),
        ),
    };
    let sentence = format!("Written to {}: {which}, {rows}; {lowest}.", path.display());
    Ok((vec![Finding::new(sentence), Finding::new(widest)], json!({ "table": path, "rows": cells.len() })))
}

/// Both ends of a band, as costs, that of the lower response first.
fn low_and_high(response: &Response, mean: f64, half: f64) -> [f64; 2] {
    match response.goal {
        Goal::Minimize => [mean - half, mean + half],
        Goal::Maximize => [mean + half, mean - half],
    }
}

/// Every design, or every so many levels of each parameter.
fn some_cells(campaign: &Campaign) -> Vec<Cell> {
    let designs = campaign.grid.combinations();
    let thinned = |stride: u64| {
        let counts = designs.counts().iter().map(|count| (count - 1) / stride + 1);
        Combinations::saturating(counts.collect::<Vec<_>>())
    };
    let strides = (1..).map(|stride| (stride, thinned(stride)));
    let fitting = strides.into_iter().find(|(_, thinned)| thinned.len() <= MOST_ROWS);
    let (stride, thinned) = fitting.unwrap_or_else(|| (1, thinned(1)));
    let cell = |places: Vec<u64>| {
        let digits: Vec<u64> = places.into_iter().map(|place| place * stride).collect();
        Cell::new(designs.index(&digits))
    };
    thinned.all().map(cell).collect()
}
