//! Where things lie along named ranges: a row for each range, a dot for each thing.

use super::axis::Axis;
use super::canvas::{Anchor, Canvas, PAPER, Pen, TEXT_SIZE, TITLE_PX, WIDTH_PX, color, text_width_px};
use super::frame::{BELOW_PX, Frame, FrameText, Grid};
use super::palette::gray;

/// Dots along rows of one axis.
#[derive(Clone, Debug)]
pub struct StripFigure {
    /// Above the figure.
    pub title: String,
    /// Of all rows; it needs a range.
    pub x_axis: Axis,
    /// From top to bottom: the name of a row, and where its dots are.
    pub rows: Vec<(String, Vec<f64>)>,
}

const ROW_PX: f64 = 17.0;
const DOT_PX: f64 = 3.0;
const RIGHT_PX: f64 = WIDTH_PX - 24.0;
/// Every other row is set off by this gray.
const SHADE: (usize, usize) = (0, 12);

/// Draws the rows.
pub fn strip_figure(figure: &StripFigure) -> String {
    let widest = figure.rows.iter().map(|(name, _)| text_width_px(name, TEXT_SIZE)).fold(0.0, f64::max);
    let bottom = TITLE_PX + ROW_PX * figure.rows.len() as f64;
    let mut canvas = Canvas::new(&figure.title, bottom + BELOW_PX);
    let frame = Frame {
        left: widest + 24.0,
        top: TITLE_PX,
        right: RIGHT_PX,
        bottom,
        x: figure.x_axis.scale(std::iter::empty(), 8),
        y: Axis::new("", "1").with_range(0.0, 1.0).scale(std::iter::empty(), 1),
    };
    let shade = gray(SHADE.0, SHADE.1);
    for (number, (name, values)) in figure.rows.iter().enumerate() {
        let top = TITLE_PX + ROW_PX * number as f64;
        let middle = top + 0.5 * ROW_PX;
        if number % 2 == 1 {
            canvas.rect((frame.left, top), (frame.right - frame.left, ROW_PX), &shade, "none");
        }
        canvas.text_as(name, (frame.left - 8.0, middle + 4.4), TEXT_SIZE, Anchor::End);
        for value in values.iter().filter(|value| value.is_finite()) {
            canvas.circle((frame.x_px(*value), middle), DOT_PX, color(0), Pen::solid(PAPER, 0.5));
        }
    }
    frame.draw_x_ticks(&mut canvas);
    let label = FrameText { x_label: Some(figure.x_axis.label()), y_label: None, grid: Grid::Hidden };
    frame.draw_axis_labels(&mut canvas, &label);
    frame.outline(&mut canvas);
    canvas.svg()
}
