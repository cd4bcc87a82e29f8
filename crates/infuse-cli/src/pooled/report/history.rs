//! Batch by batch: what was recommended, how sure that was, and what was measured.

use std::collections::BTreeMap;

use anyhow::Result;
use infuse::pooled::Assessment;
use page::palette::{BLUE, INK, VERMILION};
use page::{Axis, Chart, Column, Grid, Key, Mark, Page, Stroke, Table};

use super::super::best::has_shifts;
use super::nothing::NOTHING;
use crate::journal::Assessed;
use crate::number::{percent, short};
use crate::pooled::bands::NINE_IN_TEN;
use crate::pooled::campaign::Campaign;
use crate::problem::{Response, Scale};
use crate::report::axes;

const SIZE_PX: (f64, f64) = (292.0, 220.0);
/// Below this share, in per cent, powers of ten tell more.
const SMALL_PERCENT: f64 = 5.0;
/// How far beside what is expected the best measured is drawn: this share of the axis.
const BESIDE: f64 = 0.03;

type Line = Vec<(f64, f64)>;

pub(super) fn write(page: &mut Page, campaign: &Campaign) -> Result<()> {
    page.section("history", "History");
    if campaign.history.is_empty() {
        if let Some(before) = &campaign.on_another_scale {
            page.paragraph(&format!(
                "What was known after batch {} was said on another `scale` of the response: `infuse log` has it, and the next batch \
                 begins the history of this one.",
                before.batch
            ));
            let chart = best_so_far(campaign, with_shifts(campaign)?.as_ref());
            page.charts(&[chart], &[], "Every experiment of the campaign, and the best so far.");
            return Ok(());
        }
        page.paragraph("No batch gave a result yet.");
        return Ok(());
    }
    write_charts(page, campaign)?;
    write_table(page, campaign, &best_of_batches(campaign), as_read(with_shifts(campaign)?.is_some()));
    Ok(())
}

pub(super) fn write_charts(page: &mut Page, campaign: &Campaign) -> Result<()> {
    let (of_batches, found) = (best_of_batches(campaign), with_shifts(campaign)?);
    let so_far = best_so_far(campaign, found.as_ref());
    let mut charts = vec![expected(campaign, &of_batches), bound(campaign), left(campaign), so_far];
    charts.extend(spent(campaign));
    let worth = match campaign.settings.worth {
        Some(_) => " Below `worth` another batch is not worth its cost.",
        None => "",
    };
    let kept = if campaign.problem.constraints.is_empty() { "" } else { " of those that keep to their bounds" };
    let shifted =
        if found.is_some() { ", all without what their batches are off by, as far as that is known now" } else { "" };
    let as_read = as_read(found.is_some());
    let below = match campaign.problem.costs {
        Some(_) => " Beside it: the bound against what the experiments so far have cost, plants included.",
        None => "",
    };
    let caption = format!(
        "Left: what is expected of the recommended design after each batch, with its band of 90 %, and the best that was \
         measured in the batch{as_read}. Middle: no design is better than the recommended one by more than the bound, with the \
         probability of the certificate; beside it the same by the surface alone; what is next to nothing stands on the lower border.{worth} Right: the share of all designs that may still be the best. Below: \
         every experiment of the campaign, and the best so far{kept}{shifted}.{below}"
    );
    page.charts(&charts, &[], &caption);
    Ok(())
}

/// What is said of the best of a batch where batches are off.
fn as_read(has_shifts: bool) -> &'static str {
    if has_shifts { ", as it was read, with what the batch is off by" } else { "" }
}

/// The best mean of an experiment of each batch that kept to its bounds.
fn best_of_batches(campaign: &Campaign) -> BTreeMap<usize, f64> {
    let (experiments, response) = (&campaign.experiments, &campaign.problem.response);
    let mut best: BTreeMap<usize, f64> = BTreeMap::new();
    for (id, reading) in
        experiments.readings.iter().filter(|(id, reading)| campaign.may_be_best_measured(**id, reading))
    {
        let cost = reading.outcome(response).and_then(|outcome| outcome.cost());
        if let (Some(trial), Some(cost)) = (experiments.trials.get(id), cost) {
            let known = best.entry(trial.batch).or_insert(cost);
            *known = known.min(cost);
        }
    }
    best.into_iter().map(|(batch, cost)| (batch, response.of_cost(cost))).collect()
}

/// What is known now of batches that are off, if anything is.
fn with_shifts(campaign: &Campaign) -> Result<Option<Assessment>> {
    Ok(campaign.assessment()?.filter(has_shifts))
}

/// Half the band of what was expected: where nothing is promised, how far off it may be is not known.
fn half(known: &Assessed) -> Option<f64> {
    known.bound.map(|_| NINE_IN_TEN * known.deviation)
}

fn expected(campaign: &Campaign, of_batches: &BTreeMap<usize, f64>) -> Chart {
    let response = &campaign.problem.response;
    let expected: Line = campaign.history.values().map(|known| (batch(known), known.expected)).collect();
    let halves: Vec<f64> = campaign.history.values().map(|known| half(known).unwrap_or(0.0)).collect();
    let beside = (BESIDE * campaign.batches.len() as f64).min(0.3);
    let measured: Line = of_batches.iter().map(|(&batch, &value)| (batch as f64 + beside, value)).collect();
    let bands: Line = expected.iter().zip(&halves).map(|(point, &half)| response.band(point.1, half)).collect();
    let ends = bands.iter().flat_map(|&(low, high)| [low, high]);
    let y = axes::of_response(response, &response.name, ends.chain(measured.iter().map(|point| point.1)));
    let mut chart = Chart::new(SIZE_PX, &batches("batch", 1, campaign), &y, Grid::Shown);
    chart.line(&expected, Stroke::Solid, BLUE);
    for (point, &(low, high)) in expected.iter().zip(&bands) {
        if low < high {
            chart.whisker(point.0, low, high, BLUE);
        }
        chart.mark(*point, Mark::Dot, BLUE);
    }
    for &point in &measured {
        chart.mark(point, Mark::Ring, INK);
    }
    chart.key(Key::new("expected").line(Stroke::Solid, BLUE).mark(Mark::Dot, BLUE));
    chart.key(Key::new("90 %").whisker(BLUE));
    chart.key(Key::new("best measured").mark(Mark::Ring, INK));
    chart
}

fn bound(campaign: &Campaign) -> Chart {
    let response = &campaign.problem.response;
    let bounds: Line = campaign.history.values().filter_map(|known| Some((batch(known), known.bound?))).collect();
    let alone: Line = campaign.history.values().filter_map(|known| Some((batch(known), known.alone?))).collect();
    let worth = campaign.settings.worth;
    let all: Vec<f64> = bounds.iter().chain(&alone).map(|point| point.1).chain(worth).collect();
    let (y, least) = axes::of_bounds(response, bound_in_words(response), &all);
    let shown = |bound: f64| response.of_difference(bound.max(least));
    let along = |line: &Line| -> Line { line.iter().map(|&(batch, bound)| (batch, shown(bound))).collect() };
    let (bounds, alone, worth) = (along(&bounds), along(&alone), worth.map(shown));
    let x = batches("batch", 1, campaign);
    let mut chart = Chart::new(SIZE_PX, &x, &y, Grid::Shown);
    if let Some(worth) = worth {
        let ends = [(0.5, worth), (campaign.batches.len().max(1) as f64 + 0.5, worth)];
        chart.line(&ends, Stroke::Dashes, VERMILION);
    }
    chart.line(&alone, Stroke::Solid, INK);
    for &point in &alone {
        chart.mark(point, Mark::Ring, INK);
    }
    draw(&mut chart, &bounds);
    chart.key(Key::new("bound").line(Stroke::Solid, BLUE).mark(Mark::Dot, BLUE));
    if !alone.is_empty() {
        chart.key(Key::new("by the surface alone").line(Stroke::Solid, INK).mark(Mark::Ring, INK));
    }
    if worth.is_some() {
        chart.key(Key::new("worth").line(Stroke::Dashes, VERMILION));
    }
    chart
}

/// The best that was measured so far, over the experiments in the order of their sheets; where batches are off, without that.
fn best_so_far(campaign: &Campaign, found: Option<&Assessment>) -> Chart {
    let (experiments, response) = (&campaign.experiments, &campaign.problem.response);
    let batches = 1..=experiments.last_batch().unwrap_or(0);
    let order = batches.flat_map(|batch| experiments.in_run_order(batch, campaign.problem.seed));
    let made = order.filter(|(trial, _)| experiments.has_result(trial.id));
    let (mut measured, mut stairs, mut best, mut n): (Line, Line, Option<f64>, usize) =
        (Line::new(), Line::new(), None, 0);
    for (place, (trial, _)) in made.enumerate() {
        n = place + 1;
        let id = trial.id.number();
        let Some(reading) = experiments.readings.get(&id) else { continue };
        let Some(cost) = reading.outcome(response).and_then(|outcome| outcome.cost()) else { continue };
        let cost = cost - found.map_or(0.0, |found| campaign.off_of(found, id, reading).by);
        measured.push((n as f64, response.of_cost(cost)));
        if campaign.may_be_best_measured(id, reading) && best.is_none_or(|best| cost < best) {
            stairs.extend(best.map(|best| (n as f64, response.of_cost(best))));
            stairs.push((n as f64, response.of_cost(cost)));
            best = Some(cost);
        }
    }
    stairs.extend(best.map(|best| (n as f64 + 0.5, response.of_cost(best))));
    let y = axes::of_response(response, &response.name, measured.iter().map(|point| point.1));
    let x = Axis::new("experiment, in the order of the runs", "1").counting(1, n.max(1));
    let mut chart = Chart::new(SIZE_PX, &x, &y, Grid::Shown);
    for &point in &measured {
        chart.mark(point, Mark::Ring, INK);
    }
    chart.line(&stairs, Stroke::Solid, BLUE);
    let measured = if found.is_some() { "measured, less shifts" } else { "measured" };
    chart.key(Key::new(measured).mark(Mark::Ring, INK));
    chart.key(Key::new("best so far").line(Stroke::Solid, BLUE));
    chart
}

/// What stands along an axis of bounds.
fn bound_in_words(response: &Response) -> &'static str {
    match response.scale {
        Scale::Linear => "bound",
        Scale::Log => "bound, as a factor",
    }
}

/// The bound against what was spent for it.
fn spent(campaign: &Campaign) -> Option<Chart> {
    let costs = campaign.problem.costs.as_ref()?;
    let response = &campaign.problem.response;
    let spent = |known: &Assessed| Some((campaign.spent_until(known.batch)?.0, known.bound?));
    let bounds: Line = campaign.history.values().filter_map(spent).collect();
    let all: Vec<f64> = bounds.iter().map(|point| point.1).collect();
    let (y, least) = axes::of_bounds(response, bound_in_words(response), &all);
    let points: Line = bounds.iter().map(|&(cost, bound)| (cost, response.of_difference(bound.max(least)))).collect();
    let x = Axis::new("cost", costs.unit()).around(points.iter().map(|point| point.0).chain([0.0]));
    let mut chart = Chart::new(SIZE_PX, &x, &y, Grid::Shown);
    draw(&mut chart, &points);
    Some(chart)
}

fn left(campaign: &Campaign) -> Chart {
    let shares = campaign.history.values().map(|known| (batch(known), 100.0 * known.left));
    let points: Line = std::iter::once((0.0, 100.0)).chain(shares).collect();
    let smallest = points.iter().map(|point| point.1).fold(100.0, f64::min);
    let y = Axis::new("designs that may be the best", "%");
    let shares = points.iter().map(|point| point.1);
    let y = if smallest < SMALL_PERCENT { y.in_decades(shares) } else { y.with_range(0.0, 100.0) };
    let mut chart = Chart::new(SIZE_PX, &batches("batch, 0 is before the first", 0, campaign), &y, Grid::Shown);
    draw(&mut chart, &points);
    chart
}

fn draw(chart: &mut Chart, points: &Line) {
    chart.line(points, Stroke::Solid, BLUE);
    for &point in points {
        chart.mark(point, Mark::Dot, BLUE);
    }
}

fn write_table(page: &mut Page, campaign: &Campaign, of_batches: &BTreeMap<usize, f64>, as_read: &str) {
    let mut probabilities: Vec<f64> = campaign.history.values().map(|known| known.probability).collect();
    probabilities.dedup();
    let (table, with) = match probabilities.as_slice() {
        [one] => (table(campaign, of_batches).without("probability"), format!(" with {} probability", percent(*one))),
        _ => (table(campaign, of_batches), String::new()),
    };
    let caption = format!(
        "What was known after each batch. Bound: no design is better by more{with}; by the surface alone: the same, were the surface believed as it is. Left: the share of designs that may still \
         be the best. Noise: standard deviation of one run, as the surface has it. Best measured: in the batch{as_read}.{}",
        match campaign.problem.response.scale {
            Scale::Linear => "",
            Scale::Log => " Bands, bounds and noise are factors.",
        }
    );
    page.table(&table, &caption);
}

fn table(campaign: &Campaign, of_batches: &BTreeMap<usize, f64>) -> Table {
    let response = &campaign.problem.response;
    let (unit, of_differences) = (&response.unit, response.unit_of_differences());
    let difference = |difference: f64| short(response.of_difference(difference));
    let row = |known: &Assessed| {
        vec![
            known.batch.to_string(),
            campaign.problem.describe(&known.recommended),
            short(known.expected),
            half(known).map_or_else(|| NOTHING.to_owned(), difference),
            known.bound.map_or_else(|| NOTHING.to_owned(), difference),
            known.alone.map_or_else(|| NOTHING.to_owned(), difference),
            percent(known.probability),
            percent(known.left),
            difference(known.noise),
            of_batches.get(&known.batch).map_or_else(|| NOTHING.to_owned(), |&value| short(value)),
        ]
    };
    Table {
        columns: vec![
            Column::number("batch", ""),
            Column::words("recommended design"),
            Column::number("expected", unit),
            Column::number(response.band_heading(), of_differences),
            Column::number("bound", of_differences),
            Column::number("by the surface alone", of_differences),
            Column::number("probability", ""),
            Column::number("left", ""),
            Column::number("noise", of_differences),
            Column::number("best measured", unit),
        ],
        rows: campaign.history.values().map(row).collect(),
    }
}

fn batch(known: &Assessed) -> f64 {
    known.batch as f64
}

/// The axis along which batches are counted.
fn batches(label: &str, first: usize, campaign: &Campaign) -> Axis {
    Axis::new(label, "1").counting(first, campaign.batches.len())
}
