//! Frames: the rectangle between two axes, with numbers, labels and a grid.

use super::axis::Label;
use super::canvas::{Anchor, Canvas, LABEL_SIZE, Pen, text_width_px};
use super::palette::GRID;
use super::scale::Scale;

/// Space below the last frame, with the numbers and the label of the x axis in it.
pub(super) const BELOW_PX: f64 = 54.0;
/// Space between the left edge and a frame, with the numbers and the label of its y axis in it.
pub(super) const LEFT_PX: f64 = 100.0;
pub(super) const TICK_SIZE: u32 = 12;
/// How far a tick sticks out of its frame.
const TICK_PX: f64 = 5.0;
const FRAME_PEN: Pen<'static> = Pen { color: BLACK, width: 1.0, dashes: None };
const BLACK: &str = "#000000";

/// The rectangle between two axes, in pixels of the sheet.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    pub(super) left: f64,
    pub(super) top: f64,
    pub(super) right: f64,
    pub(super) bottom: f64,
    pub(super) x: Scale,
    pub(super) y: Scale,
}

impl Frame {
    pub(super) fn x_px(&self, x: f64) -> f64 {
        self.left + self.x.place(x) * (self.right - self.left)
    }

    pub(super) fn y_px(&self, y: f64) -> f64 {
        self.bottom - self.y.place(y) * (self.bottom - self.top)
    }

    pub(super) fn px(&self, point: (f64, f64)) -> (f64, f64) {
        (self.x_px(point.0), self.y_px(point.1))
    }

    /// Whether a point lies in the frame or on its border.
    pub(super) fn holds(&self, point: (f64, f64)) -> bool {
        [(self.x, point.0), (self.y, point.1)].iter().all(|(scale, value)| {
            let place = scale.place(*value);
            (-1e-9..=1.0 + 1e-9).contains(&place)
        })
    }

    /// Axes around a frame, with their numbers and labels.
    pub(super) fn draw(&self, canvas: &mut Canvas, text: &FrameText) {
        if text.grid == Grid::Shown {
            self.draw_grid(canvas);
        }
        self.outline(canvas);
        if text.x_label.is_some() {
            self.draw_x_ticks(canvas);
        }
        self.draw_y_ticks(canvas);
        self.draw_axis_labels(canvas, text);
    }

    pub(super) fn draw_grid(&self, canvas: &mut Canvas) {
        let pen = Pen::solid(GRID, 1.0);
        for x in self.x.ticks().into_iter().map(|tick| self.x_px(tick)) {
            canvas.line(&[(x, self.top), (x, self.bottom)], pen);
        }
        for y in self.y.ticks().into_iter().map(|tick| self.y_px(tick)) {
            canvas.line(&[(self.left, y), (self.right, y)], pen);
        }
    }

    pub(super) fn draw_x_ticks(&self, canvas: &mut Canvas) {
        self.draw_x_ticks_as(canvas, |tick| self.x.text(tick));
    }

    /// With other words at the ticks.
    pub(super) fn draw_x_ticks_as(&self, canvas: &mut Canvas, text: impl Fn(f64) -> String) {
        for tick in self.x.ticks() {
            let x = self.x_px(tick);
            canvas.line(&[(x, self.bottom), (x, self.bottom + TICK_PX)], FRAME_PEN);
            canvas.text_as(&text(tick), (x, self.bottom + 16.0), TICK_SIZE, Anchor::Middle);
        }
    }

    pub(super) fn draw_y_ticks(&self, canvas: &mut Canvas) {
        self.draw_y_ticks_as(canvas, |tick| self.y.text(tick));
    }

    /// With other words at the ticks.
    pub(super) fn draw_y_ticks_as(&self, canvas: &mut Canvas, text: impl Fn(f64) -> String) {
        for tick in self.y.ticks() {
            let y = self.y_px(tick);
            canvas.line(&[(self.left - TICK_PX, y), (self.left, y)], FRAME_PEN);
            canvas.text_as(&text(tick), (self.left - 8.0, y + 4.4), TICK_SIZE, Anchor::End);
        }
    }

    /// The labels of the axes, with what their ticks are counted from; a long one along y breaks before its unit.
    pub(super) fn draw_axis_labels(&self, canvas: &mut Canvas, text: &FrameText) {
        if let Some(label) = text.x_label {
            let at = (0.5 * (self.left + self.right), self.bottom + 40.0);
            canvas.text_as(&format!("{label}{}", self.x.above()), at, LABEL_SIZE, Anchor::Middle);
        }
        let Some(label) = text.y_label else { return };
        let middle = 0.5 * (self.top + self.bottom);
        let above = self.y.above();
        let whole = format!("{label}{above}");
        match &label.unit {
            Some(unit) if text_width_px(&whole, LABEL_SIZE) > self.bottom - self.top => {
                canvas.vertical_text(&label.quantity, (16.0, middle));
                canvas.vertical_text(&format!("({unit}){above}"), (32.0, middle));
            }
            _ => canvas.vertical_text(&whole, (24.0, middle)),
        }
    }

    /// The outline of a frame; once more over what was drawn into it.
    pub(super) fn outline(&self, canvas: &mut Canvas) {
        let size = (self.right - self.left, self.bottom - self.top);
        canvas.rect((self.left, self.top), size, "none", BLACK);
    }

    /// Draws what is cut off at the border of the frame.
    pub(super) fn draw_inside(&self, canvas: &mut Canvas, draw: impl FnOnce(&mut Canvas)) {
        canvas.inside((self.left, self.top), (self.right - self.left, self.bottom - self.top), draw);
    }
}

/// What a frame says along its axes; without an x label it shows no numbers there either.
pub(super) struct FrameText<'a> {
    pub(super) x_label: Option<&'a Label>,
    pub(super) y_label: Option<&'a Label>,
    pub(super) grid: Grid,
}

/// Whether lines across a frame help to read values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Grid {
    /// A line at every tick.
    Shown,
    /// Ticks alone.
    Hidden,
}
