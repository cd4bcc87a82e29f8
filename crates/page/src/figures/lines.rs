//! Series over a shared axis, in one panel or in several below each other.

use super::axis::Axis;
use super::canvas::{Canvas, LONG_DASHES, Pen, TITLE_PX, WIDTH_PX, color};
use super::frame::{BELOW_PX, Frame, FrameText, Grid, LEFT_PX};
use super::legend::{LegendEntry, Mark, draw_legend, legend_height_px};
use super::scale::Scale;
use super::thinning::{MAX_POINTS, changes, finite_stretches, thin};

/// Series over one x axis.
#[derive(Clone, Debug)]
pub struct LineFigure {
    /// Above the first panel.
    pub title: String,
    /// Below the last panel, for all that have none of their own.
    pub x_axis: Axis,
    /// From top to bottom.
    pub panels: Vec<Panel>,
    /// Spans of x to set off, in every panel.
    pub shaded: Option<Shaded>,
}

/// One y axis and its series.
#[derive(Clone, Debug)]
pub struct Panel {
    /// An x axis of the panel's own, below it.
    pub x_axis: Option<Axis>,
    /// On the left.
    pub y_axis: Axis,
    /// Series of the same label have the same color in all panels.
    pub series: Vec<Series>,
}

/// Spans of x and what they are.
#[derive(Clone, Debug)]
pub struct Shaded {
    /// What is set off.
    pub label: String,
    /// From and to.
    pub spans: Vec<(f64, f64)>,
}

/// Values over x, in the order of x; a value that is not finite leaves a gap.
#[derive(Clone, Debug)]
pub struct Series {
    label: String,
    /// By which its color is known.
    family: String,
    points: Vec<(f64, f64)>,
    shape: Shape,
    dashed: bool,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Shape {
    Line,
    Step,
}

impl Series {
    /// Values joined by straight lines.
    pub fn line(label: &str, x: &[f64], y: &[f64]) -> Self {
        Self::new(label, x, y, Shape::Line)
    }

    /// Values that hold until the next one.
    pub fn step(label: &str, x: &[f64], y: &[f64]) -> Self {
        Self::new(label, x, y, Shape::Step)
    }

    fn new(label: &str, x: &[f64], y: &[f64], shape: Shape) -> Self {
        debug_assert_eq!(x.len(), y.len(), "series `{label}`");
        let points = x.iter().copied().zip(y.iter().copied()).collect();
        Self { label: label.to_owned(), family: label.to_owned(), points, shape, dashed: false }
    }

    /// The same in the color of the series of another label.
    pub fn colored_as(self, label: &str) -> Self {
        Self { family: label.to_owned(), ..self }
    }

    /// The same with gaps, through which a line that it covers can be seen.
    pub fn dashed(self) -> Self {
        Self { dashed: true, ..self }
    }

    fn draw(&self, canvas: &mut Canvas, frame: &Frame, color: &str) {
        let pen = Pen { color, width: 1.4, dashes: self.dashed.then_some(LONG_DASHES) };
        for stretch in finite_stretches(&self.points) {
            let points = match self.shape {
                Shape::Step => stairs(&thin(&changes(stretch), MAX_POINTS)),
                Shape::Line => thin(stretch, MAX_POINTS),
            };
            let points: Vec<(f64, f64)> = points.into_iter().map(|point| frame.px(point)).collect();
            canvas.line(&points, pen);
        }
    }

    /// The points themselves where there are few, whole also where they lie on the border.
    fn draw_points(&self, canvas: &mut Canvas, frame: &Frame, color: &str) {
        if self.shape == Shape::Line && self.points.len() <= FEW_POINTS {
            let points = finite_stretches(&self.points).concat();
            for point in points.into_iter().filter(|point| frame.holds(*point)) {
                canvas.dot(frame.px(point), 3.5, color, "none");
            }
        }
    }
}

/// So few points are shown as such, beside the line through them.
const FEW_POINTS: usize = 30;

/// Each value held until the next one.
fn stairs(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut stairs: Vec<(f64, f64)> = Vec::with_capacity(2 * points.len());
    for &(x, y) in points {
        if let Some(&(_, before)) = stairs.last() {
            stairs.push((x, before));
        }
        stairs.push((x, y));
    }
    stairs
}

const RIGHT_PX: f64 = WIDTH_PX - 24.0;
const SINGLE_PANEL_PX: f64 = 300.0;
const STACKED_PANEL_PX: f64 = 150.0;
const OWN_AXIS_PANEL_PX: f64 = 230.0;
const GAP_PX: f64 = 20.0;
const SHADE: &str = "#ececec";

/// Draws a figure of series.
pub fn line_figure(figure: &LineFigure) -> String {
    let families = different(figure, |series| &series.family);
    let legend = legend(figure, &families);
    let count = figure.panels.len();
    let panel_px = |panel: &Panel| match count {
        1 => SINGLE_PANEL_PX,
        _ if panel.x_axis.is_some() => OWN_AXIS_PANEL_PX,
        _ => STACKED_PANEL_PX,
    };
    let frames_px: f64 = figure.panels.iter().map(|panel| panel_px(panel) + gap_px(panel)).sum();
    let bottom = TITLE_PX + frames_px - figure.panels.last().map_or(0.0, gap_px);
    let mut canvas = Canvas::new(&figure.title, bottom + BELOW_PX + legend_height_px(&legend, LEFT_PX));
    let shared = x_scale(&figure.x_axis, figure.panels.iter().filter(|panel| panel.x_axis.is_none()));
    let mut top = TITLE_PX;
    for (number, panel) in figure.panels.iter().enumerate() {
        let values = panel.series.iter().flat_map(|series| &series.points).map(|point| point.1);
        let y = panel.y_axis.roomy_scale(values, if count == 1 { 6 } else { 4 });
        let x = panel.x_axis.as_ref().map_or(shared, |axis| x_scale(axis, std::iter::once(panel)));
        let frame = Frame { left: LEFT_PX, top, right: RIGHT_PX, bottom: top + panel_px(panel), x, y };
        shade(&mut canvas, &frame, figure.shaded.as_ref());
        let below = (number + 1 == count).then_some(&figure.x_axis);
        let text = FrameText {
            x_label: panel.x_axis.as_ref().or(below).map(Axis::label),
            y_label: Some(panel.y_axis.label()),
            grid: Grid::Shown,
        };
        frame.draw(&mut canvas, &text);
        frame.draw_inside(&mut canvas, |canvas| {
            for series in &panel.series {
                series.draw(canvas, &frame, color_of(series, &families));
            }
        });
        for series in &panel.series {
            series.draw_points(&mut canvas, &frame, color_of(series, &families));
        }
        top += panel_px(panel) + gap_px(panel);
    }
    draw_legend(&mut canvas, &legend, LEFT_PX, bottom + BELOW_PX);
    canvas.svg()
}

/// Room below a panel: more where it has an axis of its own.
fn gap_px(panel: &Panel) -> f64 {
    if panel.x_axis.is_some() { BELOW_PX + GAP_PX } else { GAP_PX }
}

/// The x axis ends with the data: a flight of 300 s needs no room after it.
fn x_scale<'a>(axis: &Axis, panels: impl Iterator<Item = &'a Panel> + Clone) -> Scale {
    let values = || {
        let series = panels.clone().flat_map(|panel| &panel.series);
        series.flat_map(|series| &series.points).map(|point| point.0).filter(|x| x.is_finite())
    };
    let scale = axis.scale(values(), 8);
    let (first, last) = (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max));
    if axis.has_range() || first >= last {
        return scale;
    }
    scale.between(scale.min.max(first), scale.max.min(last))
}

fn shade(canvas: &mut Canvas, frame: &Frame, shaded: Option<&Shaded>) {
    for &(from, to) in shaded.iter().flat_map(|shaded| &shaded.spans) {
        let (from, to) = (from.max(frame.x.min), to.min(frame.x.max));
        if from < to {
            let (left, right) = (frame.x_px(from), frame.x_px(to));
            canvas.rect((left, frame.top), (right - left, frame.bottom - frame.top), SHADE, "none");
        }
    }
}

/// The different words of the series, in the order in which they appear.
fn different<'a>(figure: &'a LineFigure, word: impl Fn(&'a Series) -> &'a String) -> Vec<&'a str> {
    let mut words: Vec<&str> = Vec::new();
    for series in figure.panels.iter().flat_map(|panel| &panel.series) {
        if !words.contains(&word(series).as_str()) {
            words.push(word(series));
        }
    }
    words
}

fn color_of(series: &Series, families: &[&str]) -> &'static str {
    color(families.iter().position(|known| *known == series.family).unwrap_or(0))
}

fn legend(figure: &LineFigure, families: &[&str]) -> Vec<LegendEntry> {
    let series = || figure.panels.iter().flat_map(|panel| &panel.series);
    let is_dashed = |label: &str| series().any(|series| series.label == label && series.dashed);
    let color =
        |label: &str| series().find(|series| series.label == label).map_or("none", |one| color_of(one, families));
    let mut entries: Vec<LegendEntry> = different(figure, |series| &series.label)
        .into_iter()
        .map(|label| LegendEntry {
            mark: if is_dashed(label) { Mark::Dashes } else { Mark::Line },
            fill: color(label).into(),
            outline: color(label).into(),
            text: label.to_owned(),
        })
        .collect();
    if let Some(shaded) = &figure.shaded {
        entries.push(LegendEntry {
            mark: Mark::Box,
            fill: SHADE.into(),
            outline: "none".into(),
            text: shaded.label.clone(),
        });
    }
    // One series needs no legend: the axis says what it is.
    if entries.len() == 1 { Vec::new() } else { entries }
}
