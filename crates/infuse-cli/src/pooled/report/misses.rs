//! What the simulation misses, along one parameter after the other.

use page::palette::{BLUE, INK};
use page::{Chart, Grid, Key, Mark, Page, Stroke};

use super::super::best::has_shifts;
use super::view::View;
use crate::pooled::campaign::Origin;
use crate::problem::Scale;
use crate::report::axes;

const SIZE_PX: (f64, f64) = (292.0, 220.0);
/// With fewer runs nothing is seen.
const FEWEST: usize = 3;

/// A picture per parameter: every run whose design was simulated, less what the simulation says there.
pub(super) fn write(page: &mut Page, view: &View) {
    let runs: Vec<(&[f64], f64, Mark)> = view
        .runs
        .iter()
        .filter_map(|run| {
            let simulated = view.simulated.get(&run.cell)?;
            let mark = if matches!(run.origin, Origin::Imported(_)) { Mark::Square } else { Mark::Ring };
            Some((&*run.settings, view.response().less(run.value, *simulated), mark))
        })
        .collect();
    if runs.len() < FEWEST {
        return;
    }
    let chart = |at: usize| {
        let (parameter, room) = (&view.parameters()[at], view.room(at));
        let (low, high) = (parameter.lower() - room, parameter.upper() + room);
        let x = view.axis(at).covering(low, high, runs.iter().map(|run| run.0[at]));
        let (response, misses) = (view.response(), runs.iter().map(|run| run.1));
        let y = axes::of_differences(response, &response.less_in_words("simulated"), misses);
        let none = response.no_difference();
        let mut chart = Chart::new(SIZE_PX, &x, &y, Grid::Shown);
        chart.line(&[(low, none), (high, none)], Stroke::Solid, BLUE);
        for &(settings, miss, mark) in &runs {
            chart.mark((settings[at], miss), mark, INK);
        }
        chart
    };
    let charts: Vec<Chart> = (0..view.parameters().len()).map(chart).collect();
    let mut keys = vec![Key::new("as simulated").line(Stroke::Solid, BLUE)];
    for (mark, text) in [(Mark::Ring, "experiment"), (Mark::Square, "imported experiment")] {
        if runs.iter().any(|run| run.2 == mark) {
            keys.push(Key::new(text).mark(mark, INK));
        }
    }
    page.subheading("What the simulation misses");
    let (less, zero) = match view.response().scale {
        Scale::Linear => ("less", "zero"),
        Scale::Log => ("divided by", "1"),
    };
    let mut caption = format!(
        "What was measured {less} what the simulation says of the same design, whatever the other parameters. A level away from {zero} \
         does no harm, as the surface learns it; a slope or a bend along a parameter is what the simulation has wrong."
    );
    if view.found.displacement.is_some() {
        caption.push_str(
            " The simulation is taken as it stands here; a part of what it misses is its displacement, which the surface makes up for.",
        );
    }
    if has_shifts(&view.found) {
        caption.push_str(" Results are as they were read, with what their batches or sources are off by.");
    }
    page.charts(&charts, &keys, &caption);
}
