//! Small charts over the batches.

use infuse::global::{self, ObservedErrors};
use page::palette::{BLUE, INK, VERMILION};
use page::{Axis, Chart, Grid, Key, Mark, Page, Stroke};

use crate::dissertation::campaign::Campaign;
use crate::dissertation::findings::best_of_batch;

const SIZE_PX: (f64, f64) = (292.0, 220.0);
/// Below this share, in per cent, powers of ten tell more.
const SMALL_PERCENT: f64 = 5.0;
/// And from this ratio of the largest to the smallest.
const MANY: f64 = 50.0;

type Line = Vec<(f64, f64)>;

pub(super) fn write(page: &mut Page, campaign: &Campaign, observed: &[Option<ObservedErrors>]) {
    let reports = campaign.now.reports();
    let figures = [Some(best(campaign, reports)), Some(left(campaign, reports)), errors(campaign, reports, observed)];
    let figures: Vec<Chart> = figures.into_iter().flatten().collect();
    let mut caption =
        "Left: the best response that is predicted, and the best that was measured in the batch. Then the share of \
                       designs left."
            .to_owned();
    if figures.len() > 2 {
        caption.push_str(
            " Right: by how much the corrected simulation was off before the batch, as its experiments have shown, \
             and by how much at the most it is off after it (bound, see Bounds).",
        );
    }
    page.charts(&figures, &[], &caption);
}

fn best(campaign: &Campaign, reports: &[global::Report]) -> Chart {
    let response = &campaign.problem.response;
    let predicted: Line = reports.iter().map(|r| (batch(r), response.of_cost(r.screening.optimum_value))).collect();
    let whiskers: Vec<f64> = reports.iter().map(|report| report.screening.spread.s().unwrap_or(0.0)).collect();
    let measured = reports.iter().filter_map(|r| Some((batch(r), response.of_cost(best_of_batch(r)?))));
    let measured: Line = measured.collect();
    let ends = predicted.iter().zip(&whiskers).flat_map(|(point, s)| [point.1 - s, point.1 + s]);
    let y = Axis::new(&response.name, &response.unit).around(ends.chain(measured.iter().map(|point| point.1)));
    let mut chart = Chart::new(SIZE_PX, &batches("batch", 1, reports), &y, Grid::Shown);
    chart.line(&predicted, Stroke::Solid, BLUE);
    for (point, &s) in predicted.iter().zip(&whiskers) {
        if s > 0.0 {
            chart.whisker(point.0, point.1 - s, point.1 + s, BLUE);
        }
        chart.mark(*point, Mark::Dot, BLUE);
    }
    for &point in &measured {
        chart.mark(point, Mark::Ring, INK);
    }
    chart.key(Key::new("predicted").line(Stroke::Solid, BLUE).mark(Mark::Dot, BLUE));
    if whiskers.iter().any(|&s| s > 0.0) {
        chart.key(Key::new("± S").whisker(BLUE));
    }
    if !measured.is_empty() {
        chart.key(Key::new("best measured").mark(Mark::Ring, INK));
    }
    chart
}

fn left(campaign: &Campaign, reports: &[global::Report]) -> Chart {
    let of = campaign.now.retained().n_cells() as f64;
    let share = |report: &global::Report| (batch(report), 100.0 * report.screening.n_after as f64 / of);
    let points: Line = std::iter::once((0.0, 100.0)).chain(reports.iter().map(share)).collect();
    let smallest = points.iter().map(|point| point.1).fold(100.0, f64::min);
    let y = Axis::new("designs left", "%");
    let shares = points.iter().map(|point| point.1);
    let y = if smallest < SMALL_PERCENT { y.in_decades(shares) } else { y.with_range(0.0, 100.0) };
    let mut chart = Chart::new(SIZE_PX, &batches("batch, 0 is before the first", 0, reports), &y, Grid::Shown);
    chart.line(&points, Stroke::Solid, BLUE);
    for &point in &points {
        chart.mark(point, Mark::Dot, BLUE);
    }
    chart
}

/// None if no batch could be compared with its experiments.
fn errors(campaign: &Campaign, reports: &[global::Report], observed: &[Option<ObservedErrors>]) -> Option<Chart> {
    let shown: Line = reports.iter().filter_map(|r| Some((batch(r), r.changes.innovation?))).collect();
    let bound = reports.iter().zip(observed).filter_map(|(r, observed)| Some((batch(r), observed.as_ref()?.eps)));
    let bound: Line = bound.collect();
    if shown.is_empty() {
        return None;
    }
    let values = || shown.iter().chain(&bound).map(|point| point.1);
    let (least, most) = (values().fold(f64::INFINITY, f64::min), values().fold(0.0, f64::max));
    let y = Axis::new("off by up to", &campaign.problem.response.unit);
    let y = if most > MANY * least { y.in_decades(values()) } else { y.around(values().chain([0.0])) };
    let mut chart = Chart::new(SIZE_PX, &batches("batch", 1, reports), &y, Grid::Shown);
    for (line, stroke, color, mark) in
        [(&shown, Stroke::Solid, BLUE, Mark::Dot), (&bound, Stroke::Dashes, VERMILION, Mark::Ring)]
    {
        chart.line(line, stroke, color);
        for &point in line {
            chart.mark(point, mark, color);
        }
    }
    chart.key(Key::new("shown by experiments").line(Stroke::Solid, BLUE).mark(Mark::Dot, BLUE));
    if !bound.is_empty() {
        chart.key(Key::new("bound").line(Stroke::Dashes, VERMILION).mark(Mark::Ring, VERMILION));
    }
    Some(chart)
}

fn batch(report: &global::Report) -> f64 {
    report.number as f64
}

/// The axis along which batches are counted.
fn batches(label: &str, first: usize, reports: &[global::Report]) -> Axis {
    Axis::new(label, "1").counting(first, reports.len())
}
