//! The combined surface over pairs of parameters, through the best design.

use std::collections::BTreeSet;

use anyhow::Result;
use doe::{Levels, Parameter};

use super::axis::Scale;
use super::chart::{Chart, Grid, Mark, Ticks, border_sample, color_bar_room, field_sample, mark_sample};
use super::html::{Figure, Key, Page};
use super::last::{Last, Origin};
use super::palette::{INK, VERMILION, dropped, viridis};
use crate::number::{count, setting, short, with_unit};
use crate::problem::{Goal, step};

const SIZE_PX: (f64, f64) = (448.0, 380.0);
/// Maps on a page.
const MOST_MAPS: usize = 6;
/// Cells on a page: beyond it some levels are not drawn.
const MOST_CELLS: usize = 6_000;

/// The cells over two parameters, x fastest.
#[derive(Debug)]
struct Map {
    x: Axis,
    y: Axis,
    cells: Vec<Cell>,
}

/// The levels that are drawn.
#[derive(Debug)]
struct Axis {
    parameter: usize,
    levels: Vec<f64>,
    /// One in so many levels.
    stride: u32,
    /// Half the distance between levels that are drawn.
    half: f64,
}

#[derive(Debug)]
struct Cell {
    value: f64,
    /// By which batch.
    dropped: Option<usize>,
}

pub(super) fn write(page: &mut Page, last: &Last) -> Result<()> {
    let k = last.parameters().len();
    let pairs: Vec<(usize, usize)> = (0..k).flat_map(|y| (0..y).map(move |x| (x, y))).collect();
    if pairs.is_empty() {
        return Ok(());
    }
    let shown = MOST_MAPS.min(pairs.len());
    let most_levels = (MOST_CELLS / shown).isqrt();
    let maps = pairs.iter().map(|&(x, y)| Map::of(last, x, y, most_levels)).collect::<Result<Vec<_>>>()?;
    let maps = most_varied(maps);
    let scale = Scale::around(maps.iter().flat_map(Map::left).map(|cell| cell.value));
    let figures: Vec<Figure> = maps.iter().map(|map| map.figure(last, scale)).collect();
    page.heading("Over pairs of parameters, through the best design");
    page.figures(&figures, &legend(last, &maps), &caption(last, &maps, pairs.len()));
    Ok(())
}

/// Those over which the surface varies most, in the order of the parameters.
fn most_varied(maps: Vec<Map>) -> Vec<Map> {
    let mut ranked: Vec<(usize, Map)> = maps.into_iter().enumerate().collect();
    ranked.sort_by(|a, b| b.1.variation().total_cmp(&a.1.variation()));
    ranked.truncate(MOST_MAPS);
    ranked.sort_by_key(|&(index, _)| index);
    ranked.into_iter().map(|(_, map)| map).collect()
}

impl Axis {
    /// At most this many levels, that of the best design among them.
    fn of(last: &Last, parameter: usize, most: usize) -> Result<Self> {
        let bounds: &Parameter = &last.parameters()[parameter];
        let Levels::Count(n) = bounds.levels() else {
            anyhow::bail!("parameter `{}` has no levels", bounds.name());
        };
        let stride = n.div_ceil(u32::try_from(most).unwrap_or(u32::MAX)).max(1);
        let best = bounds.nearest_level(last.report.screening.optimum[parameter])?;
        let levels = (0..n).filter(|level| level % stride == best % stride);
        let levels = levels.map(|level| Ok(bounds.level(level)?)).collect::<Result<Vec<_>>>()?;
        let half = 0.5 * bounds.width() * f64::from(stride) / f64::from((n - 1).max(1));
        Ok(Self { parameter, levels, stride, half })
    }

    /// Around this level.
    fn sides(&self, index: usize) -> (f64, f64) {
        (self.levels[index] - self.half, self.levels[index] + self.half)
    }

    fn scale(&self, settings: impl Iterator<Item = f64>) -> Scale {
        Scale::covering(self.sides(0).0, self.sides(self.levels.len() - 1).1, settings)
    }
}

impl Map {
    fn of(last: &Last, x: usize, y: usize, most_levels: usize) -> Result<Self> {
        let (x, y) = (Axis::of(last, x, most_levels)?, Axis::of(last, y, most_levels)?);
        let (now, mut cells) = (&last.campaign.now, Vec::new());
        for &at_y in &y.levels {
            for &at_x in &x.levels {
                let point = last.moved(&[(x.parameter, at_x), (y.parameter, at_y)]);
                let value = last.value(&last.surfaces.combined, &point)?;
                let dropped = now.why_dropped(now.cell(&point)?).map(|dropped| dropped.iteration);
                cells.push(Cell { value, dropped });
            }
        }
        Ok(Self { x, y, cells })
    }

    fn left(&self) -> impl Iterator<Item = &Cell> {
        self.cells.iter().filter(|cell| cell.dropped.is_none())
    }

    fn variation(&self) -> f64 {
        let values = || self.cells.iter().map(|cell| cell.value);
        values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min)
    }

    fn cell(&self, x: usize, y: usize) -> &Cell {
        &self.cells[y * self.x.levels.len() + x]
    }

    fn figure(&self, last: &Last, scale: Scale) -> Figure {
        let settings = |axis: &Axis| {
            let parameter = axis.parameter;
            axis.scale(last.runs.iter().map(move |run| run.settings[parameter]))
        };
        let room = color_bar_room(scale);
        let mut chart = Chart::new(SIZE_PX, room, (settings(&self.x), Ticks::Any), settings(&self.y), Grid::Hidden);
        self.draw_cells(last, &mut chart, scale);
        self.draw_border(&mut chart);
        chart.outline();
        self.draw_runs(last, &mut chart);
        chart.color_bar(scale, |share| viridis(lightness(last, share)));
        let (y_label, x_label) = (last.label(self.y.parameter), last.label(self.x.parameter));
        Figure { y_label, svg: chart.svg(), width_px: SIZE_PX.0, x_label, legend: Vec::new() }
    }

    fn draw_cells(&self, last: &Last, chart: &mut Chart, scale: Scale) {
        let response = last.response();
        for y in 0..self.y.levels.len() {
            for x in 0..self.x.levels.len() {
                let cell = self.cell(x, y);
                let value = with_unit(&short(cell.value), &response.unit);
                let (fill, class, fate) = match cell.dropped {
                    Some(batch) => (
                        dropped(batch, last.report.iteration),
                        format!("dropped by-{batch}"),
                        format!(", dropped by batch {batch}"),
                    ),
                    None => (viridis(lightness(last, scale.place(cell.value))), "left".to_owned(), String::new()),
                };
                let place = [(&self.x, x), (&self.y, y)].map(|(axis, index)| {
                    let parameter = &last.parameters()[axis.parameter];
                    format!(
                        "{} {}",
                        parameter.name(),
                        with_unit(&setting(axis.levels[index], step(parameter)), parameter.unit())
                    )
                });
                let title = format!("{}: {value}{fate}", place.join(", "));
                chart.cell(self.x.sides(x), self.y.sides(y), &fill, &class, &title);
            }
        }
    }

    /// Between what was dropped and what is left.
    fn draw_border(&self, chart: &mut Chart) {
        let (n_x, n_y) = (self.x.levels.len(), self.y.levels.len());
        let differ = |a: &Cell, b: &Cell| a.dropped.is_some() != b.dropped.is_some();
        for y in 0..n_y {
            for x in 0..n_x {
                let ((left, right), (low, high)) = (self.x.sides(x), self.y.sides(y));
                if x + 1 < n_x && differ(self.cell(x, y), self.cell(x + 1, y)) {
                    chart.border((right, low), (right, high));
                }
                if y + 1 < n_y && differ(self.cell(x, y), self.cell(x, y + 1)) {
                    chart.border((left, high), (right, high));
                }
            }
        }
    }

    /// Each place once, however many runs were made there.
    fn draw_runs(&self, last: &Last, chart: &mut Chart) {
        let place = |settings: &[f64]| (settings[self.x.parameter] + 0.0, settings[self.y.parameter] + 0.0);
        let mut drawn = BTreeSet::new();
        let mut draw = |settings: &[f64], mark: Mark, color: &str| {
            let (x, y) = place(settings);
            if drawn.insert((x.to_bits(), y.to_bits(), mark as u8)) {
                chart.mark((x, y), mark, color);
            }
        };
        for run in &last.runs {
            draw(&run.settings, mark(run.origin, run.cost.is_none()), INK);
        }
        for simulation in &last.report.simulations {
            draw(&simulation.point, Mark::Speck, INK);
        }
        draw(&last.report.screening.optimum, Mark::Target, VERMILION);
    }
}

fn mark(origin: Origin, is_failed: bool) -> Mark {
    match origin {
        _ if is_failed => Mark::Cross,
        Origin::Imported => Mark::Square,
        Origin::Training | Origin::Validation => Mark::Ring,
    }
}

/// The better, the darker.
fn lightness(last: &Last, share: f64) -> f64 {
    match last.response().goal {
        Goal::Minimize => share,
        Goal::Maximize => 1.0 - share,
    }
}

fn legend(last: &Last, maps: &[Map]) -> Vec<Key> {
    let key = |sample: String, text: String| Key { sample, text };
    let mut keys = vec![key(mark_sample(Mark::Target, VERMILION), "best design".to_owned())];
    let is_there = |origin: Origin, is_failed: bool| {
        last.runs.iter().any(|run| {
            (run.origin == Origin::Imported) == (origin == Origin::Imported) && run.cost.is_none() == is_failed
        })
    };
    for (origin, is_failed, text) in [
        (Origin::Training, false, "experiment"),
        (Origin::Training, true, "experiment without a result"),
        (Origin::Imported, false, "imported experiment"),
    ] {
        if is_there(origin, is_failed) {
            keys.push(key(mark_sample(mark(origin, is_failed), INK), text.to_owned()));
        }
    }
    keys.push(key(mark_sample(Mark::Speck, INK), "simulation".to_owned()));
    let batches: BTreeSet<usize> = maps.iter().flat_map(|map| &map.cells).filter_map(|cell| cell.dropped).collect();
    if !batches.is_empty() {
        keys.push(key(border_sample(), "edge of what is left".to_owned()));
    }
    for batch in batches {
        keys.push(key(field_sample(&dropped(batch, last.report.iteration)), format!("dropped by batch {batch}")));
    }
    keys
}

fn caption(last: &Last, maps: &[Map], n_pairs: usize) -> String {
    let (response, best) = (last.response(), &last.report.screening.optimum);
    let mut text = format!(
        "Color: {} by the combined surface of batch {}; darker is better.",
        response.heading(),
        last.report.iteration
    );
    let others = last.parameters().len() > 2;
    if others {
        text.push_str(&format!(
            " The other parameters are at their best settings, {}; runs are drawn whatever their settings of them.",
            last.campaign.problem.describe(best)
        ));
    }
    text.push_str(" Experiments and simulations are those of this batch.");
    if maps.len() < n_pairs {
        text.push_str(&format!(
            " Of {} the {} are shown over which the surface varies most.",
            count(n_pairs, "pair"),
            maps.len()
        ));
    }
    let strides: BTreeSet<(usize, u32)> = maps
        .iter()
        .flat_map(|map| [&map.x, &map.y])
        .filter(|axis| axis.stride > 1)
        .map(|axis| (axis.parameter, axis.stride))
        .collect();
    for (parameter, stride) in strides {
        let name = last.parameters()[parameter].name();
        text.push_str(&format!(" Of the levels of {name} one in {stride} is drawn."));
    }
    text
}
