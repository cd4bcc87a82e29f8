//! The surface along one parameter after the other, through the recommended design.

use anyhow::Result;
use design_space::Cell;
use page::palette::{BLUE, INK, LIGHT_BLUE, ORANGE, VERMILION};
use page::{Chart, Grid, Key, Mark, Page, Stroke};

use super::super::best::has_shifts;
use super::view::{AS_READ, Run, View};
use crate::pooled::campaign::{Access, Origin};

const SIZE_PX: (f64, f64) = (448.0, 270.0);
/// A simulation that would make the range of a chart so many times as wide is not drawn.
const FAR: f64 = 6.0;

/// What is drawn along a parameter.
#[derive(Debug)]
struct Drawn {
    /// Setting, lower end, expected, upper end.
    curve: Vec<(f64, f64, f64, f64)>,
    /// Pieces without a gap.
    simulation: Vec<Vec<(f64, f64)>>,
    runs: Vec<((f64, f64), Mark)>,
    /// Settings of runs without a value.
    failed: Vec<f64>,
    /// Settings that are not to be had.
    refused: Vec<f64>,
    /// Whether the simulation was left out.
    is_far: bool,
}

pub(super) fn write(page: &mut Page, view: &View) -> Result<()> {
    let drawn = (0..view.parameters().len()).map(|parameter| Drawn::of(view, parameter));
    let drawn = drawn.collect::<Result<Vec<_>>>()?;
    let charts: Vec<Chart> = drawn.iter().enumerate().map(|(at, drawn)| drawn.chart(view, at)).collect();
    page.subheading("Along each parameter, through the recommended design");
    page.charts(&charts, &legend(view, &drawn), &caption(view, &drawn));
    Ok(())
}

impl Drawn {
    fn of(view: &View, parameter: usize) -> Result<Self> {
        let setting = |cell: Cell| view.campaign.grid.point(cell).map_or(f64::NAN, |point| point[parameter]);
        let places: Vec<(f64, Cell)> = view.lines[parameter].iter().map(|&cell| (setting(cell), cell)).collect();
        let band = |&(x, cell): &(f64, Cell)| {
            let band = view.band(cell)?;
            Some((x, band.low, band.mean, band.high))
        };
        let mut drawn = Self {
            curve: places.iter().filter_map(band).collect(),
            simulation: simulation(view, parameter, &places),
            runs: view.runs.iter().filter_map(|run| place(view, parameter, run)).collect(),
            failed: Vec::new(),
            refused: Vec::new(),
            is_far: false,
        };
        // Those that were not moved are drawn over the others.
        drawn.runs.sort_by_key(|(_, mark)| *mark == Mark::Dot);
        let failed = view.failed.iter().filter(|settings| view.is_on_the_line(parameter, settings));
        drawn.failed = failed.map(|settings| settings[parameter]).collect();
        let cells: Vec<Cell> = places.iter().map(|place| place.1).collect();
        let refused = places.iter().zip(view.campaign.not_to_be_had(&cells)?);
        drawn.refused = refused.filter(|(_, is_refused)| *is_refused).map(|((x, _), _)| *x).collect();
        let scaled = |value: f64| view.response().scaled(value);
        let without = width(drawn.values().map(scaled));
        let with = width(drawn.values().chain(drawn.simulated()).map(scaled));
        if with > FAR * without {
            drawn.is_far = true;
            drawn.simulation.clear();
        }
        Ok(drawn)
    }

    /// All but the simulation.
    fn values(&self) -> impl Iterator<Item = f64> + '_ {
        let curve = self.curve.iter().flat_map(|&(_, low, _, high)| [low, high]);
        curve.chain(self.runs.iter().map(|((_, y), _)| *y))
    }

    fn simulated(&self) -> impl Iterator<Item = f64> + '_ {
        self.simulation.iter().flatten().map(|point| point.1)
    }

    fn chart(&self, view: &View, parameter: usize) -> Chart {
        let bounds = &view.parameters()[parameter];
        let room = view.room(parameter);
        let run_at = self.runs.iter().map(|((x, _), _)| *x).chain(self.failed.iter().copied());
        let x = view.axis(parameter).covering(bounds.lower() - room, bounds.upper() + room, run_at);
        let y = view.response_axis(self.values().chain(self.simulated()));
        let mut chart = Chart::new(SIZE_PX, &x, &y, Grid::Hidden);
        let is_choice = view.is_choice(parameter);
        let band: Vec<(f64, f64, f64)> = self.curve.iter().map(|&(x, low, _, high)| (x, low, high)).collect();
        let expected: Vec<(f64, f64)> = self.curve.iter().map(|&(x, _, mean, _)| (x, mean)).collect();
        draw_curve(&mut chart, &band, &expected, is_choice);
        for piece in &self.simulation {
            match (view.access, piece.as_slice()) {
                (Access::LookedUp | Access::All, [_, _, ..]) if !is_choice => {
                    chart.line(piece, Stroke::Dashes, ORANGE);
                }
                _ => piece.iter().for_each(|&point| chart.mark(point, Mark::Dot, ORANGE)),
            }
        }
        if !is_choice {
            // Over the simulation.
            chart.line(&expected, Stroke::Solid, BLUE);
        }
        for &(point, mark) in &self.runs {
            chart.mark(point, mark, INK);
        }
        for &x in &self.refused {
            chart.mark_below(x, Mark::Square, VERMILION);
        }
        for &x in &self.failed {
            chart.mark_below(x, Mark::Cross, INK);
        }
        let best = &view.found.recommended;
        chart.mark((best.point[parameter], view.response().of_cost(best.mean)), Mark::Target, VERMILION);
        chart
    }
}

/// What is expected and its band: lines, or of choices, between which there is nothing, a whisker each.
pub(super) fn draw_curve(chart: &mut Chart, band: &[(f64, f64, f64)], expected: &[(f64, f64)], is_choice: bool) {
    if !is_choice {
        chart.ribbon(band, LIGHT_BLUE);
        chart.outline();
        return;
    }
    for (&(x, low, high), &(_, mean)) in band.iter().zip(expected) {
        chart.ribbon(&[(x - 0.2, low, high), (x + 0.2, low, high)], LIGHT_BLUE);
        chart.line(&[(x - 0.2, mean), (x + 0.2, mean)], Stroke::Solid, BLUE);
    }
    chart.outline();
}

/// What the simulation says along the line, in pieces: of few simulations each is one.
fn simulation(view: &View, parameter: usize, places: &[(f64, Cell)]) -> Vec<Vec<(f64, f64)>> {
    if view.access == Access::Budget {
        let point = |(&cell, &value): (&Cell, &f64)| {
            let settings = view.campaign.grid.point(cell).ok()?;
            view.is_on_the_line(parameter, &settings).then(|| vec![(settings[parameter], value)])
        };
        return view.simulated.iter().filter_map(point).collect();
    }
    let values: Vec<Option<(f64, f64)>> =
        places.iter().map(|(x, cell)| view.simulated.get(cell).map(|&value| (*x, value))).collect();
    let pieces = values.split(Option::is_none).map(|piece| piece.iter().flatten().copied().collect::<Vec<_>>());
    pieces.filter(|piece| !piece.is_empty()).collect()
}

/// A run where it was made, or moved along the surface to the line.
fn place(view: &View, parameter: usize, run: &Run) -> Option<((f64, f64), Mark)> {
    let x = run.settings[parameter];
    if view.is_on_the_line(parameter, &run.settings) {
        return Some(((x, run.value), Mark::Dot));
    }
    let on_the_line = view.on_the_line(parameter, run.cell).ok()?;
    let moved = view.response().moved(view.expected(on_the_line)?, run.value, view.expected(run.cell)?);
    Some(((x, moved), Mark::Ring))
}

fn width(values: impl Iterator<Item = f64>) -> f64 {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), y| (low.min(y), high.max(y)));
    (high - low).max(0.0)
}

fn legend(view: &View, drawn: &[Drawn]) -> Vec<Key> {
    let mut keys = vec![
        Key::new("expected").line(Stroke::Solid, BLUE),
        Key::new("its band of 90 %").field(LIGHT_BLUE),
        Key::new("recommended design").mark(Mark::Target, VERMILION),
    ];
    if drawn.iter().any(|drawn| !drawn.simulation.is_empty()) {
        keys.push(match view.access {
            Access::Budget => Key::new("simulation on the line").mark(Mark::Dot, ORANGE),
            Access::Nothing | Access::LookedUp | Access::All => Key::new("simulation").line(Stroke::Dashes, ORANGE),
        });
    }
    let marks = || drawn.iter().flat_map(|drawn| &drawn.runs).map(|(_, mark)| *mark);
    for (mark, text) in [(Mark::Dot, "run on the line"), (Mark::Ring, "run moved to the line")] {
        if marks().any(|other| other == mark) {
            keys.push(Key::new(text).mark(mark, INK));
        }
    }
    if drawn.iter().any(|drawn| !drawn.failed.is_empty()) {
        keys.push(Key::new("run without a result").mark(Mark::Cross, INK));
    }
    if drawn.iter().any(|drawn| !drawn.refused.is_empty()) {
        keys.push(Key::new("not to be had").mark(Mark::Square, VERMILION));
    }
    keys
}

fn caption(view: &View, drawn: &[Drawn]) -> String {
    let mut text = "The band holds the response with 90 % probability, without the noise of a run.".to_owned();
    if drawn.iter().flat_map(|drawn| &drawn.runs).any(|(_, mark)| *mark == Mark::Ring) {
        text.push_str(
            " A run that was made at other settings of the other parameters is moved to the line along the surface: it is \
             drawn as far from the curve as it was from what is expected where it was made.",
        );
    }
    if has_shifts(&view.found) {
        text.push_str(AS_READ);
    }
    if view.runs.iter().any(|run| matches!(run.origin, Origin::Imported(_))) {
        text.push_str(" Imported experiments are among them.");
    }
    if drawn.iter().any(|drawn| !drawn.failed.is_empty()) {
        text.push_str(" A run without a result has no height; it is drawn at the lower edge.");
    }
    if drawn.iter().any(|drawn| !drawn.refused.is_empty()) {
        text.push_str(
            " What is not to be had, [can_be_built] or [[linear_constraint]] refuses with the other parameters as recommended; \
             what the command was not asked about may be refused as well.",
        );
    }
    if view.found.displacement.is_some() && drawn.iter().any(|drawn| !drawn.simulation.is_empty()) {
        text.push_str(" The simulation is drawn as it stands, not displaced as it is taken to be.");
    }
    if drawn.iter().any(|drawn| drawn.is_far) {
        text.push_str(" The simulation is left out where it is so far from all else that nothing else could be seen.");
    }
    text
}
