//! The combined surface over pairs of parameters, through the best design.

use std::collections::BTreeSet;

use anyhow::Result;
use design_space::{Levels, Parameter};
use page::palette::{INK, VERMILION, gray};
use page::{Axis, Bands, Chart, ColorScale, Key, MapCell, Mark, Page};

use super::last::{Last, Origin};
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
    x: Side,
    y: Side,
    cells: Vec<Cell>,
}

/// The levels that are drawn.
#[derive(Debug)]
struct Side {
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
    let colors = match last.response().goal {
        Goal::Minimize => ColorScale::NearLowest,
        Goal::Maximize => ColorScale::NearHighest,
    };
    let axis = last.response_axis().with_colors(colors);
    let bands = Bands::of(&axis, maps.iter().flat_map(Map::left).map(|cell| cell.value));
    let charts: Vec<Chart> = maps.iter().map(|map| map.chart(last, &bands)).collect();
    page.subheading("Over pairs of parameters, through the best design");
    page.charts(&charts, &legend(last, &maps), &caption(last, &maps, pairs.len()));
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

impl Side {
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

    /// As far as its levels and the settings of all runs go.
    fn axis(&self, last: &Last) -> Axis {
        let settings = last.runs.iter().map(|run| run.settings[self.parameter]);
        last.axis(self.parameter).covering(self.sides(0).0, self.sides(self.levels.len() - 1).1, settings)
    }
}

impl Map {
    fn of(last: &Last, x: usize, y: usize, most_levels: usize) -> Result<Self> {
        let (x, y) = (Side::of(last, x, most_levels)?, Side::of(last, y, most_levels)?);
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

    fn chart(&self, last: &Last, bands: &Bands) -> Chart {
        let mut chart = Chart::with_color_bar(SIZE_PX, &self.x.axis(last), &self.y.axis(last), bands);
        self.draw_cells(last, &mut chart, bands);
        self.draw_border(&mut chart);
        chart.outline();
        self.draw_runs(last, &mut chart);
        chart
    }

    fn draw_cells(&self, last: &Last, chart: &mut Chart, bands: &Bands) {
        for y in 0..self.y.levels.len() {
            for x in 0..self.x.levels.len() {
                let cell = self.cell(x, y);
                let (fill, class) = match cell.dropped {
                    Some(batch) => (gray(batch, last.report.iteration), format!("dropped by-{batch}")),
                    None => (bands.color_of(cell.value), "left".to_owned()),
                };
                let title = self.title(last, x, y);
                chart.cell(&MapCell { x: self.x.sides(x), y: self.y.sides(y), fill, class, title });
            }
        }
    }

    /// What a pointer on a cell shows.
    fn title(&self, last: &Last, x: usize, y: usize) -> String {
        let cell = self.cell(x, y);
        let value = with_unit(&short(cell.value), &last.response().unit);
        let fate = cell.dropped.map(|batch| format!(", dropped by batch {batch}")).unwrap_or_default();
        let place = [(&self.x, x), (&self.y, y)].map(|(side, index)| {
            let parameter = &last.parameters()[side.parameter];
            let at = with_unit(&setting(side.levels[index], step(parameter)), parameter.unit());
            format!("{} {at}", parameter.name())
        });
        format!("{}: {value}{fate}", place.join(", "))
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

fn legend(last: &Last, maps: &[Map]) -> Vec<Key> {
    let mut keys = vec![Key::new("best design").mark(Mark::Target, VERMILION)];
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
            keys.push(Key::new(text).mark(mark(origin, is_failed), INK));
        }
    }
    keys.push(Key::new("simulation").mark(Mark::Speck, INK));
    let batches: BTreeSet<usize> = maps.iter().flat_map(|map| &map.cells).filter_map(|cell| cell.dropped).collect();
    if !batches.is_empty() {
        keys.push(Key::new("edge of what is left").border());
    }
    for batch in batches {
        let color = gray(batch, last.report.iteration);
        keys.push(Key::new(&format!("dropped by batch {batch}")).field(&color));
    }
    keys
}

fn caption(last: &Last, maps: &[Map], n_pairs: usize) -> String {
    let (response, best) = (last.response(), &last.report.screening.optimum);
    let mut text = format!(
        "Color: {} by the combined surface of batch {}; darker is better, and colors change faster near the best.",
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
