//! A quantity on the cells of a grid, some of which are no longer there, with the points chosen among them.

use super::axis::{Axis, Scale};
use super::canvas::{BELOW_PX, Canvas, Frame, INK, LEFT_PX, LegendEntry, Mark, PAPER, color, legend_height_px};
use super::color_scale::{Bands, draw_color_bar};
use super::panels::Sheet;
use super::points::Points;

/// One panel: values on cells.
#[derive(Clone, Debug)]
pub struct CellPanel {
    pub title: String,
    /// Centers of the cells, increasing, at least two.
    pub x: Vec<f64>,
    pub y: Vec<f64>,
    /// `z[row][column]` belongs to `y[row]` and `x[column]`; NaN where there is no cell any more.
    pub z: Vec<Vec<f64>>,
    pub points: Vec<Points>,
    pub minimum: Option<(f64, f64)>,
}

/// Panels over the same axes, two in a row, with one scale of colors.
#[derive(Clone, Debug)]
pub struct CellFigure {
    pub title: String,
    pub x_axis: Axis,
    pub y_axis: Axis,
    pub z_axis: Axis,
    pub panels: Vec<CellPanel>,
    pub missing_label: String,
    pub minimum_label: String,
}

const MISSING: &str = "#e9e9e9";

/// Draws the panels.
pub fn cell_figure(figure: &CellFigure) -> String {
    let sheet = Sheet::of(figure.panels.len());
    let bottom = sheet.bottom();
    let legend = legend(figure);
    let mut canvas = Canvas::new(&figure.title, bottom + BELOW_PX + legend_height_px(&legend, LEFT_PX));
    let bands = Bands::of(&figure.z_axis, figure.panels.iter().flat_map(|panel| panel.z.iter().flatten().copied()));
    for (number, panel) in figure.panels.iter().enumerate() {
        let axes = [&figure.x_axis, &figure.y_axis];
        let scales = [around_cells(axes[0], &panel.x), around_cells(axes[1], &panel.y)];
        let frame = sheet.panel(&mut canvas, number, &panel.title, axes, scales);
        draw_cells(&mut canvas, &frame, panel, &bands);
        for points in &panel.points {
            points.draw(&mut canvas, &frame);
        }
        if let Some(minimum) = panel.minimum {
            canvas.diamond(frame.px(minimum), color(4), PAPER);
        }
        canvas.outline(&frame);
    }
    draw_color_bar(&mut canvas, &bands, bottom);
    canvas.legend(&legend, LEFT_PX, bottom + BELOW_PX);
    canvas.svg()
}

/// Half a cell beyond the centers of the first and the last.
fn around_cells(axis: &Axis, centers: &[f64]) -> Scale {
    let scale = axis.scale(centers.iter().copied(), 6);
    let half = 0.5 * step(centers);
    match centers {
        [first, .., last] => scale.between(first - half, last + half),
        _ => scale,
    }
}

fn step(centers: &[f64]) -> f64 {
    match centers {
        [first, .., last] => (last - first) / (centers.len() - 1) as f64,
        _ => 1.0,
    }
}

fn draw_cells(canvas: &mut Canvas, frame: &Frame, panel: &CellPanel, bands: &Bands) {
    let (dx, dy) = (step(&panel.x), step(&panel.y));
    for (y, row) in panel.y.iter().zip(&panel.z) {
        for (x, z) in panel.x.iter().zip(row) {
            let (left, right) = (frame.x_px(x - 0.5 * dx), frame.x_px(x + 0.5 * dx));
            let (top, bottom) = (frame.y_px(y + 0.5 * dy), frame.y_px(y - 0.5 * dy));
            let fill = if z.is_finite() { bands.color_of(*z) } else { MISSING.to_owned() };
            // A little larger, so that no gap shows between neighbors.
            canvas.rect((left, top), (right - left + 0.4, bottom - top + 0.4), &fill, "none");
        }
    }
}

fn legend(figure: &CellFigure) -> Vec<LegendEntry> {
    let mut entries: Vec<LegendEntry> = Vec::new();
    for points in figure.panels.iter().flat_map(|panel| &panel.points) {
        if entries.iter().all(|known| known.text != points.label) {
            entries.push(points.entry());
        }
    }
    let entry = |mark, [fill, outline]: [&str; 2], text: &str| LegendEntry {
        mark,
        fill: fill.into(),
        outline: outline.into(),
        text: text.to_owned(),
    };
    if figure.panels.iter().any(|panel| panel.minimum.is_some()) {
        entries.push(entry(Mark::Diamond, [color(4), PAPER], &figure.minimum_label));
    }
    if figure.panels.iter().any(|panel| panel.z.iter().flatten().any(|z| !z.is_finite())) {
        entries.push(entry(Mark::Box, [MISSING, INK], &figure.missing_label));
    }
    entries
}
