//! Maps over pairs of parameters, through one design: what is drawn alike, whatever the surface.

use std::collections::BTreeSet;

use anyhow::Result;
use design_space::{Cell as Design, Grid, Levels, Parameter};
use page::palette::{INK, VERMILION};
use page::{Axis, Bands, Chart, ColorScale, MapCell, Mark};

use crate::number::{count, setting, short, with_unit};
use crate::problem::{Goal, Problem, Scale, step};

const SIZE_PX: (f64, f64) = (448.0, 380.0);
/// Maps on a page.
const MOST_MAPS: usize = 6;
/// Cells on a page: beyond it some levels are not drawn.
const MOST_CELLS: usize = 6_000;

/// What all maps of a page have in common.
#[derive(Debug)]
pub(crate) struct Maps<'a> {
    pub(crate) problem: &'a Problem,
    /// What can be set.
    pub(crate) grid: &'a Grid,
    /// Where the parameters are that a map does not vary.
    pub(crate) through: Design,
    /// Places to mark, in the order in which they are drawn.
    pub(crate) marks: Vec<(Vec<f64>, Mark)>,
}

/// The designs over which a map is drawn: those of two parameters.
#[derive(Debug, Clone)]
pub(crate) struct Plane {
    x: Side,
    y: Side,
    /// x fastest.
    pub(crate) designs: Vec<Design>,
}

/// The levels that are drawn.
#[derive(Debug, Clone)]
struct Side {
    parameter: usize,
    digits: Vec<u64>,
    levels: Vec<f64>,
    /// One in so many levels.
    stride: u32,
    /// Half the distance between levels that are drawn.
    half: f64,
    /// Where some levels are not drawn, the first cell begins and the last one ends at the bounds.
    ends: Option<(f64, f64)>,
}

/// A plane with its cells, x fastest.
#[derive(Debug)]
pub(crate) struct Map {
    plane: Plane,
    pub(crate) cells: Vec<Cell>,
}

#[derive(Debug)]
pub(crate) struct Cell {
    /// The response.
    pub(crate) value: f64,
    /// Of the element.
    pub(crate) class: String,
    pub(crate) apart: Option<Apart>,
}

/// A cell that is set off from the others: it has no color of its value.
#[derive(Debug)]
pub(crate) struct Apart {
    pub(crate) fill: String,
    /// What follows its value, for a pointer that rests on it.
    pub(crate) words: String,
}

impl Maps<'_> {
    fn parameters(&self) -> &[Parameter] {
        self.grid.region().parameters()
    }

    /// Every pair of parameters.
    pub(crate) fn planes(&self) -> Result<Vec<Plane>> {
        let k = self.parameters().len();
        let pairs: Vec<(usize, usize)> = (0..k).flat_map(|y| (0..y).map(move |x| (x, y))).collect();
        let shown = MOST_MAPS.min(pairs.len()).max(1);
        let most_levels = (MOST_CELLS / shown).isqrt();
        let side = |parameter: usize| self.side(parameter, most_levels);
        pairs.iter().map(|&(x, y)| self.plane(side(x)?, side(y)?)).collect()
    }

    /// At most this many levels, that of the design among them.
    fn side(&self, parameter: usize, most: usize) -> Result<Side> {
        let bounds = &self.parameters()[parameter];
        let Thinned { n_levels, stride, digits } = thinned(self.grid, self.through, parameter, most)?;
        let levels =
            digits.iter().map(|&digit| Ok(bounds.level(u32::try_from(digit)?)?)).collect::<Result<Vec<_>>>()?;
        let half = 0.5 * bounds.width() * f64::from(stride) / f64::from((n_levels - 1).max(1));
        let ends = (stride > 1).then(|| (bounds.lower(), bounds.upper()));
        Ok(Side { parameter, digits, levels, stride, half, ends })
    }

    fn plane(&self, x: Side, y: Side) -> Result<Plane> {
        let mut digits = self.grid.digits(self.through)?;
        let mut designs = Vec::with_capacity(x.digits.len() * y.digits.len());
        for &at_y in &y.digits {
            for &at_x in &x.digits {
                digits[x.parameter] = at_x;
                digits[y.parameter] = at_y;
                designs.push(self.grid.of_digits(&digits)?);
            }
        }
        Ok(Plane { x, y, designs })
    }

    /// The maps, with one scale of colors: that of the cells that are not set off.
    pub(crate) fn charts(&self, maps: &[Map]) -> Vec<Chart> {
        let response = &self.problem.response;
        let colors = match (response.goal, response.scale) {
            (Goal::Minimize, Scale::Linear) => ColorScale::NearLowest,
            (Goal::Maximize, Scale::Linear) => ColorScale::NearHighest,
            (Goal::Minimize, Scale::Log) => ColorScale::RatiosFromLowest,
            (Goal::Maximize, Scale::Log) => ColorScale::RatiosFromHighest,
        };
        let axis = Axis::new(&response.name, &response.unit).with_colors(colors);
        let shown = maps.iter().flat_map(|map| &map.cells).filter(|cell| cell.apart.is_none());
        let bands = Bands::of(&axis, shown.map(|cell| cell.value));
        maps.iter().map(|map| self.chart(map, &bands)).collect()
    }

    fn chart(&self, map: &Map, bands: &Bands) -> Chart {
        let axes = [&map.plane.x, &map.plane.y].map(|side| self.axis(side));
        let mut chart = Chart::with_color_bar(SIZE_PX, &axes[0], &axes[1], bands);
        self.draw_cells(map, &mut chart, bands);
        map.draw_border(&mut chart);
        chart.outline();
        self.draw_marks(&map.plane, &mut chart);
        chart
    }

    /// As far as its levels and all marks go.
    fn axis(&self, side: &Side) -> Axis {
        let parameter = &self.parameters()[side.parameter];
        let settings = self.marks.iter().map(|(settings, _)| settings[side.parameter]);
        let (first, last) = (side.sides(0).0, side.sides(side.levels.len() - 1).1);
        axis_of(parameter).covering(first, last, settings)
    }

    fn draw_cells(&self, map: &Map, chart: &mut Chart, bands: &Bands) {
        let (side_x, side_y) = (&map.plane.x, &map.plane.y);
        for y in 0..side_y.levels.len() {
            for x in 0..side_x.levels.len() {
                let cell = map.cell(x, y);
                let fill = cell.apart.as_ref().map_or_else(|| bands.color_of(cell.value), |apart| apart.fill.clone());
                let (class, title) = (cell.class.clone(), self.title(map, x, y));
                chart.cell(&MapCell { x: side_x.sides(x), y: side_y.sides(y), fill, class, title });
            }
        }
    }

    /// What a pointer on a cell shows.
    fn title(&self, map: &Map, x: usize, y: usize) -> String {
        let cell = map.cell(x, y);
        let value = with_unit(&short(cell.value), &self.problem.response.unit);
        let fate = cell.apart.as_ref().map(|apart| format!(", {}", apart.words)).unwrap_or_default();
        let place = [(&map.plane.x, x), (&map.plane.y, y)].map(|(side, index)| {
            let parameter = &self.parameters()[side.parameter];
            let at = with_unit(&setting(side.levels[index], step(parameter)), parameter.unit());
            format!("{} {at}", parameter.name())
        });
        format!("{}: {value}{fate}", place.join(", "))
    }

    /// Each place once, however many runs were made there.
    fn draw_marks(&self, plane: &Plane, chart: &mut Chart) {
        let mut drawn = BTreeSet::new();
        for (settings, mark) in &self.marks {
            let (x, y) = (settings[plane.x.parameter] + 0.0, settings[plane.y.parameter] + 0.0);
            if drawn.insert((x.to_bits(), y.to_bits(), *mark as u8)) {
                chart.mark((x, y), *mark, if *mark == Mark::Target { VERMILION } else { INK });
            }
        }
    }

    /// What a caption says about maps and levels that are not drawn, of so many maps.
    pub(crate) fn left_out(&self, maps: &[Map], of: usize) -> String {
        let mut text = String::new();
        if maps.len() < of {
            let pairs = count(of, "pair");
            text.push_str(&format!(" Of {pairs} the {} are shown over which the surface varies most.", maps.len()));
        }
        let sides = maps.iter().flat_map(|map| [&map.plane.x, &map.plane.y]).filter(|side| side.stride > 1);
        let strides: BTreeSet<(usize, u32)> = sides.map(|side| (side.parameter, side.stride)).collect();
        for (parameter, stride) in strides {
            if self.problem.region.parameters()[parameter].levels() == Levels::Continuous {
                continue;
            }
            let name = self.parameters()[parameter].name();
            text.push_str(&format!(" Of the levels of {name} one in {stride} is drawn."));
        }
        text
    }
}

impl Side {
    /// Around this level.
    fn sides(&self, index: usize) -> (f64, f64) {
        let (low, high) = (self.levels[index] - self.half, self.levels[index] + self.half);
        let (first, last) = self.ends.unwrap_or((low, high));
        (if index == 0 { first } else { low }, if index + 1 == self.levels.len() { last } else { high })
    }
}

impl Map {
    /// With a cell for each design of the plane, in their order.
    pub(crate) fn new(plane: Plane, cells: Vec<Cell>) -> Self {
        Self { plane, cells }
    }

    fn variation(&self) -> f64 {
        let values = || self.cells.iter().map(|cell| cell.value);
        values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min)
    }

    fn cell(&self, x: usize, y: usize) -> &Cell {
        &self.cells[y * self.plane.x.levels.len() + x]
    }

    /// Between cells that are set off and the others.
    fn draw_border(&self, chart: &mut Chart) {
        let (n_x, n_y) = (self.plane.x.levels.len(), self.plane.y.levels.len());
        let differ = |a: &Cell, b: &Cell| a.apart.is_some() != b.apart.is_some();
        for y in 0..n_y {
            for x in 0..n_x {
                let ((left, right), (low, high)) = (self.plane.x.sides(x), self.plane.y.sides(y));
                if x + 1 < n_x && differ(self.cell(x, y), self.cell(x + 1, y)) {
                    chart.border((right, low), (right, high));
                }
                if y + 1 < n_y && differ(self.cell(x, y), self.cell(x, y + 1)) {
                    chart.border((left, high), (right, high));
                }
            }
        }
    }
}

/// Levels of a parameter that are drawn.
#[derive(Debug)]
pub(crate) struct Thinned {
    pub(crate) n_levels: u32,
    /// One in so many is drawn.
    pub(crate) stride: u32,
    /// Their indices.
    pub(crate) digits: Vec<u64>,
}

/// At most so many levels of a parameter, one in a stride, that of this design among them.
pub(crate) fn thinned(grid: &Grid, with: Design, parameter: usize, most: usize) -> Result<Thinned> {
    let bounds = &grid.region().parameters()[parameter];
    let Levels::Count(n_levels) = bounds.levels() else {
        anyhow::bail!("parameter `{}` has no levels", bounds.name());
    };
    let stride = n_levels.div_ceil(u32::try_from(most).unwrap_or(u32::MAX)).max(1);
    let first = grid.digits(with)?[parameter] % u64::from(stride);
    let digits = (first..u64::from(n_levels)).step_by(stride as usize).collect();
    Ok(Thinned { n_levels, stride, digits })
}

/// Those over which the surface varies most, in the order of the parameters.
pub(crate) fn most_varied(maps: Vec<Map>) -> Vec<Map> {
    let mut ranked: Vec<(usize, Map)> = maps.into_iter().enumerate().collect();
    ranked.sort_by(|a, b| b.1.variation().total_cmp(&a.1.variation()));
    ranked.truncate(MOST_MAPS);
    ranked.sort_by_key(|&(index, _)| index);
    ranked.into_iter().map(|(_, map)| map).collect()
}

/// An axis of a parameter, without a range; of choices it has the names.
pub(crate) fn axis_of(parameter: &Parameter) -> Axis {
    let axis = Axis::new(parameter.name(), parameter.unit());
    match parameter.choices() {
        Some(choices) => Axis::new(parameter.name(), "").with_names(choices),
        None => axis,
    }
}
