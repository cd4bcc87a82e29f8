//! Small charts over the batches.

use infuse::global::{self, ObservedErrors};

use super::axis::Scale;
use super::chart::{Chart, Grid, Mark, Stroke, Ticks, line_sample, mark_sample, whisker_sample};
use super::history::best_measured;
use super::html::{Figure, Key, Page};
use super::palette::{BLUE, INK, VERMILION};
use crate::campaign::Campaign;
use crate::problem::heading;

const SIZE_PX: (f64, f64) = (292.0, 220.0);
/// Below this share, in per cent, powers of ten tell more.
const SMALL_PERCENT: f64 = 5.0;
/// And from this ratio of the largest to the smallest.
const MANY: f64 = 50.0;

type Line = Vec<(f64, f64)>;

pub(super) fn write(page: &mut Page, campaign: &Campaign, observed: &[Option<ObservedErrors>]) {
    let reports = campaign.now.reports();
    let figures = [Some(best(campaign, reports)), Some(left(campaign, reports)), errors(campaign, reports, observed)];
    let figures: Vec<Figure> = figures.into_iter().flatten().collect();
    let mut caption =
        "Left: the best response that is predicted, and the best that was measured in the batch. Then the share of \
                       designs left."
            .to_owned();
    if figures.len() > 2 {
        caption.push_str(
            " Right: by how much the corrected simulation was off before the batch, as its experiments have shown \
             (innovation), and by how much at the most it is off after it (bound, see Bounds).",
        );
    }
    page.figures(&figures, &[], &caption);
}

fn best(campaign: &Campaign, reports: &[global::Report]) -> Figure {
    let response = &campaign.problem.response;
    let predicted: Line = reports.iter().map(|r| (batch(r), response.cost(r.screening.optimum_value))).collect();
    let whiskers: Vec<f64> = reports.iter().map(|report| report.screening.spread.s().unwrap_or(0.0)).collect();
    let measured = reports.iter().filter_map(|r| Some((batch(r), response.cost(best_measured(r)?))));
    let measured: Line = measured.collect();
    let ends = predicted.iter().zip(&whiskers).flat_map(|(point, s)| [point.1 - s, point.1 + s]);
    let y = Scale::around(ends.chain(measured.iter().map(|point| point.1)));
    let mut chart = Chart::new(SIZE_PX, 0.0, over(1, reports), y, Grid::Shown);
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
    let mut legend = vec![key(line_sample(Stroke::Solid, BLUE) + &mark_sample(Mark::Dot, BLUE), "predicted")];
    if whiskers.iter().any(|&s| s > 0.0) {
        legend.push(key(whisker_sample(BLUE), "± S"));
    }
    if !measured.is_empty() {
        legend.push(key(mark_sample(Mark::Ring, INK), "best measured"));
    }
    Figure { y_label: response.heading(), svg: chart.svg(), width_px: SIZE_PX.0, x_label: "batch".to_owned(), legend }
}

fn left(campaign: &Campaign, reports: &[global::Report]) -> Figure {
    let of = campaign.now.retained().n_cells() as f64;
    let share = |report: &global::Report| (batch(report), 100.0 * report.screening.n_after as f64 / of);
    let points: Line = std::iter::once((0.0, 100.0)).chain(reports.iter().map(share)).collect();
    let smallest = points.iter().map(|point| point.1).fold(100.0, f64::min);
    let linear = Scale::Linear { min: 0.0, max: 100.0 };
    let y = if smallest < SMALL_PERCENT {
        Scale::decades(points.iter().map(|point| point.1)).unwrap_or(linear)
    } else {
        linear
    };
    let mut chart = Chart::new(SIZE_PX, 0.0, over(0, reports), y, Grid::Shown);
    chart.line(&points, Stroke::Solid, BLUE);
    for &point in &points {
        chart.mark(point, Mark::Dot, BLUE);
    }
    let y_label = "designs left [%]".to_owned();
    Figure {
        y_label,
        svg: chart.svg(),
        width_px: SIZE_PX.0,
        x_label: "batch, 0 is before the first".to_owned(),
        legend: Vec::new(),
    }
}

/// None if no batch could be compared with its experiments.
fn errors(campaign: &Campaign, reports: &[global::Report], observed: &[Option<ObservedErrors>]) -> Option<Figure> {
    let innovation: Line = reports.iter().filter_map(|r| Some((batch(r), r.changes.innovation?))).collect();
    let bound = reports.iter().zip(observed).filter_map(|(r, observed)| Some((batch(r), observed.as_ref()?.eps)));
    let bound: Line = bound.collect();
    if innovation.is_empty() {
        return None;
    }
    let values = || innovation.iter().chain(&bound).map(|point| point.1);
    let (least, most) = (values().fold(f64::INFINITY, f64::min), values().fold(0.0, f64::max));
    let linear = Scale::around(values().chain([0.0]));
    let y = if most > MANY * least { Scale::decades(values()).unwrap_or(linear) } else { linear };
    let mut chart = Chart::new(SIZE_PX, 0.0, over(1, reports), y, Grid::Shown);
    for (line, stroke, color, mark) in
        [(&innovation, Stroke::Solid, BLUE, Mark::Dot), (&bound, Stroke::Dashes, VERMILION, Mark::Ring)]
    {
        chart.line(line, stroke, color);
        for &point in line {
            chart.mark(point, mark, color);
        }
    }
    let mut legend = vec![key(line_sample(Stroke::Solid, BLUE) + &mark_sample(Mark::Dot, BLUE), "innovation")];
    if !bound.is_empty() {
        legend.push(key(line_sample(Stroke::Dashes, VERMILION) + &mark_sample(Mark::Ring, VERMILION), "bound"));
    }
    let y_label = heading("off by up to", &campaign.problem.response.unit);
    Some(Figure { y_label, svg: chart.svg(), width_px: SIZE_PX.0, x_label: "batch".to_owned(), legend })
}

fn batch(report: &global::Report) -> f64 {
    report.iteration as f64
}

fn over(first: usize, reports: &[global::Report]) -> (Scale, Ticks) {
    (Scale::counting(first, reports.len()), Ticks::Whole)
}

fn key(sample: String, text: &str) -> Key {
    Key { sample, text: text.to_owned() }
}
