//! What became of things: bars of equal boxes, one for each thing, from left to right by what became of it.

use super::axis::Axis;
use super::canvas::{Anchor, Canvas, INK, PAPER, TEXT_SIZE, TITLE_PX, WIDTH_PX, text_width_px};
use super::frame::{BELOW_PX, Frame, FrameText, Grid};
use super::legend::{LegendEntry, Mark, draw_legend, legend_height_px};

/// Counts of the same kinds in several bars.
#[derive(Clone, Debug)]
pub struct CountFigure {
    /// Above the figure.
    pub title: String,
    /// Of the counts.
    pub x_axis: Axis,
    /// From left to right: what is counted, and the color of its boxes.
    pub kinds: Vec<(String, &'static str)>,
    /// From top to bottom: the name of a bar, and a count for each kind.
    pub bars: Vec<(String, Vec<usize>)>,
}

const BAR_PX: f64 = 22.0;
const SLOT_PX: f64 = 34.0;
const RIGHT_PX: f64 = WIDTH_PX - 24.0;
const LEGEND_LEFT_PX: f64 = 40.0;

/// Draws the bars.
pub fn count_figure(figure: &CountFigure) -> String {
    let legend: Vec<LegendEntry> = figure
        .kinds
        .iter()
        .map(|(text, fill)| LegendEntry {
            mark: Mark::Box,
            fill: (*fill).into(),
            outline: INK.into(),
            text: text.clone(),
        })
        .collect();
    let widest = figure.bars.iter().map(|(name, _)| text_width_px(name, TEXT_SIZE)).fold(0.0, f64::max);
    let bottom = TITLE_PX + SLOT_PX * figure.bars.len() as f64;
    let mut canvas = Canvas::new(&figure.title, bottom + BELOW_PX + legend_height_px(&legend, LEGEND_LEFT_PX));
    let most = figure.bars.iter().map(|(_, counts)| counts.iter().sum::<usize>()).max().unwrap_or(0).max(1);
    let frame = Frame {
        left: (widest + 24.0).max(LEGEND_LEFT_PX),
        top: TITLE_PX,
        right: RIGHT_PX,
        bottom,
        x: figure.x_axis.clone().with_range(0.0, most as f64).scale(std::iter::empty(), 8),
        y: Axis::new("", "1").with_range(0.0, 1.0).scale(std::iter::empty(), 1),
    };
    frame.draw_x_ticks(&mut canvas);
    let label = FrameText { x_label: Some(figure.x_axis.label()), y_label: None, grid: Grid::Hidden };
    frame.draw_axis_labels(&mut canvas, &label);
    for (number, (name, counts)) in figure.bars.iter().enumerate() {
        let middle = TITLE_PX + SLOT_PX * (number as f64 + 0.5);
        canvas.text_as(name, (frame.left - 8.0, middle + 4.4), TEXT_SIZE, Anchor::End);
        let mut before = 0;
        for (count, (_, fill)) in counts.iter().zip(&figure.kinds) {
            for _ in 0..*count {
                let (from, to) = (frame.x_px(before as f64), frame.x_px((before + 1) as f64));
                canvas.rect((from, middle - 0.5 * BAR_PX), (to - from, BAR_PX), fill, PAPER);
                before += 1;
            }
        }
    }
    frame.outline(&mut canvas);
    draw_legend(&mut canvas, &legend, LEGEND_LEFT_PX, bottom + BELOW_PX);
    canvas.svg()
}
