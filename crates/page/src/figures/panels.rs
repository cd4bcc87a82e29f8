//! Where panels over the same axes stand, two in a row.

use super::axis::Axis;
use super::canvas::{Anchor, Canvas, TEXT_SIZE, TITLE_PX, WIDTH_PX};
use super::frame::{Frame, FrameText, Grid, LEFT_PX};
use super::scale::Scale;

/// Where the frames of a figure with a color bar end; the bar stands on their right.
pub(super) const RIGHT_PX: f64 = WIDTH_PX - 130.0;
const COLUMNS: usize = 2;
const SMALL_HEIGHT_PX: f64 = 300.0;
const COLUMN_GAP_PX: f64 = 60.0;
const ROW_GAP_PX: f64 = 40.0;
/// Space above a panel, with its title in it.
const PANEL_TITLE_PX: f64 = 24.0;

/// Where panels over the same axes stand, two in a row.
pub(super) struct Sheet {
    rows: usize,
}

impl Sheet {
    pub(super) fn of(panels: usize) -> Self {
        Self { rows: panels.div_ceil(COLUMNS).max(1) }
    }

    fn top_of(row: usize) -> f64 {
        TITLE_PX + PANEL_TITLE_PX + row as f64 * (SMALL_HEIGHT_PX + ROW_GAP_PX)
    }

    pub(super) fn bottom(&self) -> f64 {
        Self::top_of(self.rows - 1) + SMALL_HEIGHT_PX
    }

    /// Draws the frame of a panel with its title above it; only the outer panels label their axes.
    pub(super) fn panel(
        &self,
        canvas: &mut Canvas,
        number: usize,
        title: &str,
        [x_axis, y_axis]: [&Axis; 2],
        [x, y]: [Scale; 2],
    ) -> Frame {
        let width = (RIGHT_PX - LEFT_PX - COLUMN_GAP_PX) / COLUMNS as f64;
        let (row, column) = (number / COLUMNS, number % COLUMNS);
        let left = LEFT_PX + column as f64 * (width + COLUMN_GAP_PX);
        let top = Self::top_of(row);
        let frame = Frame { left, top, right: left + width, bottom: top + SMALL_HEIGHT_PX, x, y };
        let text = FrameText {
            x_label: (row + 1 == self.rows).then_some(x_axis.label()),
            y_label: (column == 0).then_some(y_axis.label()),
            grid: Grid::Hidden,
        };
        frame.draw(canvas, &text);
        canvas.text_as(title, (left, frame.top - 8.0), TEXT_SIZE, Anchor::Start);
        frame
    }
}
