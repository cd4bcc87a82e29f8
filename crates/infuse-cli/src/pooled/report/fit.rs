//! How well the surface and the simulation agree with what was measured.

use page::palette::{BLUE, GRID, INK, LIGHT_BLUE};
use page::{Axis, Chart, Grid, Key, Mark, Page, Stroke};

use super::super::best::has_shifts;
use super::view::{AS_READ, Run, View};
use crate::number::percent;
use crate::pooled::bands::NINE_IN_TEN;
use crate::pooled::campaign::Origin;
use crate::report::axes;

const SIZE_PX: (f64, f64) = (292.0, 260.0);
/// Ranges that differ by more than this share no line of equals.
const FAR: f64 = 4.0;

type Points = Vec<((f64, f64), Mark)>;

/// Runs from which on a fit can be seen.
const FEWEST: usize = 3;

pub(super) fn write(page: &mut Page, view: &View) {
    if view.runs.len() < FEWEST {
        page.paragraph("Too few experiments gave a result to say how well the surface fits.");
        return;
    }
    let simulated = points(&view.runs, |run| view.simulated.get(&run.cell).copied());
    let expected = points(&view.runs, |run| view.expected(run.cell));
    let mut charts = vec![against(view, "expected", &expected), residuals_against_expected(view)];
    charts.extend(residuals_over_runs(view));
    if !simulated.is_empty() {
        charts.push(against(view, "simulated", &simulated));
    }
    page.charts(&charts, &legend(view, !simulated.is_empty()), &caption(view, !simulated.is_empty(), charts.len()));
}

/// Values of runs against something else about them.
fn points(runs: &[Run], of: impl Fn(&Run) -> Option<f64>) -> Points {
    runs.iter().filter_map(|run| Some(((of(run)?, run.value), mark(run)))).collect()
}

fn mark(run: &Run) -> Mark {
    match run.origin {
        Origin::Imported(_) => Mark::Square,
        Origin::Own(_) => Mark::Ring,
    }
}

/// What was measured less what is expected, against what is expected, with the band of the noise.
fn residuals_against_expected(view: &View) -> Chart {
    let response = view.response();
    let residual = |run: &Run| {
        let expected = view.expected(run.cell)?;
        Some(((expected, response.less(run.value, expected)), mark(run)))
    };
    let points: Points = view.runs.iter().filter_map(residual).collect();
    let xs = || points.iter().map(|((x, _), _)| *x);
    let (none, (least, most)) = of_noise(view);
    let x = axes::of_response(response, &format!("{} expected", response.name), xs());
    let y = residual_axis(view, points.iter().map(|((_, y), _)| *y).chain([least, most]));
    let mut chart = Chart::new(SIZE_PX, &x, &y, Grid::Hidden);
    let (low, high) = ends(xs());
    chart.ribbon(&[(low, least, most), (high, least, most)], LIGHT_BLUE);
    chart.line(&[(low, none), (high, none)], Stroke::Solid, BLUE);
    chart.outline();
    for &(point, mark) in &points {
        chart.mark(point, mark, INK);
    }
    chart
}

/// No residual at all, and the residuals that the noise alone makes nine times in ten.
fn of_noise(view: &View) -> (f64, (f64, f64)) {
    let none = view.response().no_difference();
    (none, view.response().band(none, NINE_IN_TEN * view.found.noise))
}

fn residual_axis(view: &View, values: impl IntoIterator<Item = f64>) -> Axis {
    axes::of_differences(view.response(), &view.response().less_in_words("expected"), values)
}

/// What was measured against what was expected or simulated; with the line on which both are equal, unless they are far apart.
fn against(view: &View, what: &str, points: &Points) -> Chart {
    let response = view.response();
    let xs = || points.iter().map(|((x, _), _)| *x);
    let ys = || points.iter().map(|((_, y), _)| *y);
    let names = [what, "measured"].map(|what| format!("{} {what}", response.name));
    let width = |values: &mut dyn Iterator<Item = f64>| width(values.map(|value| response.scaled(value)));
    let both = width(&mut xs().chain(ys()));
    let are_near = both <= FAR * width(&mut xs()).max(width(&mut ys())) || both <= 0.0;
    let (low, high) = ends(xs().chain(ys()));
    let [x, y] = match are_near {
        true => [0, 1].map(|side| axes::of_response(response, &names[side], xs().chain(ys()))),
        false => [axes::of_response(response, &names[0], xs()), axes::of_response(response, &names[1], ys())],
    };
    let mut chart = Chart::new(SIZE_PX, &x, &y, Grid::Shown);
    if are_near {
        chart.line(&[(low, low), (high, high)], Stroke::Solid, BLUE);
    }
    for &(point, mark) in points {
        chart.mark(point, mark, INK);
    }
    chart
}

/// What was measured less what is expected, in the order in which the experiments were to be run.
fn residuals_over_runs(view: &View) -> Option<Chart> {
    let (experiments, seed) = (&view.campaign.experiments, view.campaign.problem.seed);
    let batches = 1..=experiments.last_batch()?;
    let order: Vec<(u64, usize)> = batches
        .flat_map(|batch| experiments.in_run_order(batch, seed))
        .map(|(trial, _)| (trial.id.number(), trial.batch))
        .collect();
    let mut points: Vec<(f64, f64)> = Vec::new();
    for (place, (id, _)) in order.iter().enumerate() {
        for run in view.runs.iter().filter(|run| run.origin == Origin::Own(*id)) {
            let residual = |expected: f64| view.response().less(run.value, expected);
            points.extend(view.expected(run.cell).map(|expected| ((place + 1) as f64, residual(expected))));
        }
    }
    let (none, (least, most)) = of_noise(view);
    let y = residual_axis(view, points.iter().map(|point| point.1).chain([least, most]));
    let x = Axis::new("experiment, in the order of the runs", "1").counting(1, order.len());
    let mut chart = Chart::new(SIZE_PX, &x, &y, Grid::Hidden);
    let (first, last) = (0.5, order.len() as f64 + 0.5);
    chart.ribbon(&[(first, least, most), (last, least, most)], LIGHT_BLUE);
    let begins = order.windows(2).enumerate().filter(|(_, pair)| pair[0].1 != pair[1].1);
    for (index, _) in begins {
        chart.divider(index as f64 + 1.5, GRID);
    }
    chart.line(&[(first, none), (last, none)], Stroke::Solid, BLUE);
    chart.outline();
    for &point in &points {
        chart.mark(point, Mark::Ring, INK);
    }
    Some(chart)
}

fn legend(view: &View, has_simulation: bool) -> Vec<Key> {
    let equal = if has_simulation { "as expected, or as simulated" } else { "as expected" };
    let mut keys = vec![Key::new(equal).line(Stroke::Solid, BLUE)];
    for (kind, text) in [(Mark::Ring, "experiment"), (Mark::Square, "imported experiment")] {
        if view.runs.iter().any(|run| mark(run) == kind) {
            keys.push(Key::new(text).mark(kind, INK));
        }
    }
    if view.campaign.experiments.last_batch().is_some() {
        keys.push(Key::new("nine in ten, by the noise alone").field(LIGHT_BLUE));
    }
    if view.campaign.batches.len() > 1 {
        keys.push(Key::new("between batches").line(Stroke::Solid, GRID));
    }
    keys
}

fn caption(view: &View, has_simulation: bool, n_charts: usize) -> String {
    let mut text =
        "First: what was measured in all batches against what is expected at the same settings, with the line on which both are \
         equal; the surface has seen these runs. Second: how far they are from that line."
            .to_owned();
    if view.campaign.experiments.last_batch().is_some() {
        text.push_str(&format!(
            " Third: the same over the runs, where a trend would tell that something has drifted; the \
             noise of one run is {}.",
            view.response().amount(view.found.noise)
        ));
    }
    if has_shifts(&view.found) {
        text.push_str(AS_READ);
    }
    if has_simulation {
        let place = if n_charts > 3 { "Fourth" } else { "Third" };
        text.push_str(&format!(" {place}: what was measured against the simulation."));
        text.push_str(&match view.found.simulation {
            Some(worth) if view.found.displacement.is_some() => format!(
                " It is drawn as it stands; displaced as it is taken to be it explains {} of the variance of what was measured (squared \
                 correlation).",
                percent(worth.explained)
            ),
            Some(worth) => format!(
                " It explains {} of the variance of what was measured (squared correlation).",
                percent(worth.explained)
            ),
            None => " What it is worth, too few experiments tell.".to_owned(),
        });
    }
    text
}

fn ends(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)))
}

fn width(values: impl Iterator<Item = f64>) -> f64 {
    let (low, high) = ends(values);
    (high - low).max(0.0)
}
