//! The responses that have to stay within bounds, along one parameter after the other.

use page::palette::{BLUE, INK, LIGHT_BLUE, VERMILION};
use page::{Axis, Chart, Grid, Key, Mark, Page, Stroke};

use super::curves::draw_curve;
use super::view::{AS_READ, View};
use crate::pooled::bands::NINE_IN_TEN;
use crate::problem::Held;

const SIZE_PX: (f64, f64) = (448.0, 270.0);

/// A picture per constraint and parameter, through the recommended design.
pub(super) fn write(page: &mut Page, view: &View) {
    for (index, held) in view.campaign.problem.constraints.iter().enumerate() {
        page.subheading(&format!("{}: {}", held.name(), held.bounds()));
        let charts: Vec<Chart> =
            (0..view.parameters().len()).filter_map(|parameter| chart(view, held, index, parameter)).collect();
        if charts.is_empty() {
            page.paragraph("It was not measured yet.");
            continue;
        }
        let keys = [
            Key::new("expected").line(Stroke::Solid, BLUE),
            Key::new("its band of 90 %").field(LIGHT_BLUE),
            Key::new("bound").line(Stroke::Dashes, VERMILION),
            Key::new("recommended design").mark(Mark::Target, VERMILION),
            Key::new("run on the line").mark(Mark::Dot, INK),
        ];
        let caption = "A design is recommended if it keeps to every bound with the probability that is asked for. The band is \
                       without the noise of a run.";
        let is_shared = view.found.constrained_shared.get(index).is_some_and(Option::is_some);
        let as_read = if is_shared { AS_READ } else { "" };
        page.charts(&charts, &keys, &format!("{caption}{as_read}"));
    }
}

fn chart(view: &View, held: &Held, index: usize, parameter: usize) -> Option<Chart> {
    let at = |cell: &design_space::Cell| view.campaign.grid.point(*cell).map_or(f64::NAN, |point| point[parameter]);
    let curve: Vec<(f64, f64, f64)> = view.lines[parameter]
        .iter()
        .filter_map(|cell| {
            let (mean, deviation) = view.constrained(*cell, index)?;
            Some((at(cell), mean, NINE_IN_TEN * deviation))
        })
        .collect();
    if curve.is_empty() {
        return None;
    }
    let runs: Vec<(f64, f64)> = view
        .measured(held.name())
        .filter(|(settings, _)| view.is_on_the_line(parameter, settings))
        .map(|(settings, value)| (settings[parameter], value))
        .collect();
    let of = &view.parameters()[parameter];
    let room = view.room(parameter);
    let x = view.axis(parameter).covering(of.lower() - room, of.upper() + room, runs.iter().map(|run| run.0));
    let bounds = || [held.constraint.lower, held.constraint.upper].into_iter().flatten();
    let heights = curve.iter().flat_map(|&(_, mean, half)| [mean - half, mean + half]);
    let y = Axis::new(held.name(), &held.unit).around(heights.chain(runs.iter().map(|run| run.1)).chain(bounds()));
    let mut chart = Chart::new(SIZE_PX, &x, &y, Grid::Hidden);
    let band: Vec<(f64, f64, f64)> = curve.iter().map(|&(x, mean, half)| (x, mean - half, mean + half)).collect();
    let expected: Vec<(f64, f64)> = curve.iter().map(|&(x, mean, _)| (x, mean)).collect();
    let is_choice = view.is_choice(parameter);
    draw_curve(&mut chart, &band, &expected, is_choice);
    for bound in bounds() {
        chart.line(&[(of.lower() - room, bound), (of.upper() + room, bound)], Stroke::Dashes, VERMILION);
    }
    if !is_choice {
        chart.line(&expected, Stroke::Solid, BLUE);
    }
    runs.iter().for_each(|&run| chart.mark(run, Mark::Dot, INK));
    let best = &view.found.recommended;
    if let Some((mean, _)) = best.constrained.get(index).and_then(|there| there.expected) {
        chart.mark((best.point[parameter], mean), Mark::Target, VERMILION);
    }
    Some(chart)
}
