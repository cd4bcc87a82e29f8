//! Series over a shared axis, in one panel or in several below each other.

use kuva::plot::{LinePlot, ScatterPlot};
use kuva::render::plots::Plot;

use super::axis::{Axis, Scale};
use super::canvas::{
    BELOW_PX, Canvas, Frame, FrameText, Grid, LEFT_PX, LegendEntry, Mark, TITLE_PX, WIDTH_PX, color, legend_height_px,
};
use super::thinning::{MAX_POINTS, changes, finite_stretches, thin};

/// Series over one x axis.
#[derive(Clone, Debug)]
pub(crate) struct LineFigure {
    pub(crate) title: String,
    pub(crate) x_axis: Axis,
    /// From top to bottom.
    pub(crate) panels: Vec<Panel>,
    /// Spans of x to set off, in every panel.
    pub(crate) shaded: Option<Shaded>,
}

/// One y axis and its series.
#[derive(Clone, Debug)]
pub(crate) struct Panel {
    pub(crate) y_axis: Axis,
    /// Series of the same label have the same color in all panels.
    pub(crate) series: Vec<Series>,
}

/// Spans of x and what they are.
#[derive(Clone, Debug)]
pub(crate) struct Shaded {
    pub(crate) label: String,
    pub(crate) spans: Vec<(f64, f64)>,
}

/// Values over x, in the order of x; a value that is not finite leaves a gap.
#[derive(Clone, Debug)]
pub(crate) struct Series {
    label: String,
    points: Vec<(f64, f64)>,
    shape: Shape,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Shape {
    Line,
    Step,
}

impl Series {
    /// Values joined by straight lines.
    pub(crate) fn line(label: &str, x: &[f64], y: &[f64]) -> Self {
        Self::new(label, x, y, Shape::Line)
    }

    /// Values that hold until the next one.
    pub(crate) fn step(label: &str, x: &[f64], y: &[f64]) -> Self {
        Self::new(label, x, y, Shape::Step)
    }

    fn new(label: &str, x: &[f64], y: &[f64], shape: Shape) -> Self {
        debug_assert_eq!(x.len(), y.len(), "series `{label}`");
        let points = x.iter().copied().zip(y.iter().copied()).collect();
        Self { label: label.to_owned(), points, shape }
    }

    fn plots(&self, color: &str) -> Vec<Plot> {
        let mut plots = Vec::new();
        for stretch in finite_stretches(&self.points) {
            plots.push(match self.shape {
                Shape::Step => lines(thin(&changes(stretch), MAX_POINTS), color).with_step().into(),
                Shape::Line => lines(thin(stretch, MAX_POINTS), color).into(),
            });
        }
        if self.shape == Shape::Line && self.points.len() <= FEW_POINTS {
            let finite = finite_stretches(&self.points).concat();
            plots.push(ScatterPlot::new().with_data(finite).with_color(color).with_size(3.5).into());
        }
        plots
    }
}

/// So few points are shown as such, beside the line through them.
const FEW_POINTS: usize = 30;

fn lines(points: Vec<(f64, f64)>, color: &str) -> LinePlot {
    LinePlot::new().with_data(points).with_color(color).with_stroke_width(1.4)
}

const RIGHT_PX: f64 = WIDTH_PX - 24.0;
const SINGLE_PANEL_PX: f64 = 300.0;
const STACKED_PANEL_PX: f64 = 150.0;
const GAP_PX: f64 = 20.0;
const SHADE: &str = "#ececec";

/// Draws a figure of series.
pub(crate) fn line_figure(figure: &LineFigure) -> String {
    let labels = labels(figure);
    let legend = legend(figure, &labels);
    let count = figure.panels.len();
    let panel_px = if count == 1 { SINGLE_PANEL_PX } else { STACKED_PANEL_PX };
    let bottom = TITLE_PX + count as f64 * (panel_px + GAP_PX) - GAP_PX;
    let mut canvas = Canvas::new(&figure.title, bottom + BELOW_PX + legend_height_px(&legend, LEFT_PX));
    let x = x_scale(figure);
    for (number, panel) in figure.panels.iter().enumerate() {
        let top = TITLE_PX + number as f64 * (panel_px + GAP_PX);
        let values = panel.series.iter().flat_map(|series| &series.points).map(|point| point.1);
        let y = panel.y_axis.roomy_scale(values, if count == 1 { 6 } else { 4 });
        let frame = Frame { left: LEFT_PX, top, right: RIGHT_PX, bottom: top + panel_px, x, y };
        shade(&mut canvas, &frame, figure.shaded.as_ref());
        let text = FrameText {
            x_label: (number + 1 == count).then_some(figure.x_axis.label()),
            y_label: panel.y_axis.label(),
            grid: Grid::Shown,
        };
        let plots = panel.series.iter().flat_map(|series| series.plots(color_of(&series.label, &labels)));
        canvas.frame(&frame, &text, plots.collect());
    }
    canvas.legend(&legend, LEFT_PX, bottom + BELOW_PX);
    canvas.svg()
}

/// The x axis ends with the data: a flight of 300 s needs no room after it.
fn x_scale(figure: &LineFigure) -> Scale {
    let values = || {
        let series = figure.panels.iter().flat_map(|panel| &panel.series);
        series.flat_map(|series| &series.points).map(|point| point.0).filter(|x| x.is_finite())
    };
    let scale = figure.x_axis.scale(values(), 8);
    let (first, last) = (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max));
    if figure.x_axis.has_range() || first >= last {
        return scale;
    }
    Scale { min: scale.min.max(first), max: scale.max.min(last), ..scale }
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

/// The different labels, in the order in which they appear.
fn labels(figure: &LineFigure) -> Vec<&str> {
    let mut labels: Vec<&str> = Vec::new();
    for series in figure.panels.iter().flat_map(|panel| &panel.series) {
        if !labels.contains(&series.label.as_str()) {
            labels.push(&series.label);
        }
    }
    labels
}

fn color_of(label: &str, labels: &[&str]) -> &'static str {
    color(labels.iter().position(|known| *known == label).unwrap_or(0))
}

fn legend(figure: &LineFigure, labels: &[&str]) -> Vec<LegendEntry> {
    let mut entries: Vec<LegendEntry> = labels
        .iter()
        .map(|label| LegendEntry {
            mark: Mark::Line,
            fill: color_of(label, labels).into(),
            outline: color_of(label, labels).into(),
            text: (*label).to_owned(),
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
