//! Legends: what lines, areas and marks mean.

use super::canvas::{Anchor, Canvas, Pen, SHORT_DASHES, TEXT_SIZE, WIDTH_PX, text_width_px};

/// Height of one row of a legend.
pub(super) const LEGEND_ROW_PX: f64 = 22.0;

/// How a series or a marker looks, in the figure and in the legend.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Mark {
    Line,
    Dashes,
    Box,
    Dot,
    Diamond,
    Cross,
}

pub(super) struct LegendEntry {
    pub(super) mark: Mark,
    pub(super) fill: String,
    pub(super) outline: String,
    pub(super) text: String,
}

/// A row of entries, broken where it gets too long, from a height downward.
pub(super) fn draw_legend(canvas: &mut Canvas, entries: &[LegendEntry], left_px: f64, top_px: f64) {
    let (mut x, mut y) = (left_px, top_px + 0.5 * LEGEND_ROW_PX);
    for (entry, row) in entries.iter().zip(legend_rows(entries, left_px)) {
        if top_px + (row as f64 + 0.5) * LEGEND_ROW_PX > y {
            (x, y) = (left_px, top_px + (row as f64 + 0.5) * LEGEND_ROW_PX);
        }
        draw_sample(canvas, entry, (x + 10.0, y));
        canvas.text_as(&entry.text, (x + 26.0, y + 4.0), TEXT_SIZE, Anchor::Start);
        x += entry_width_px(entry);
    }
}

fn draw_sample(canvas: &mut Canvas, entry: &LegendEntry, at: (f64, f64)) {
    let ends = [(at.0 - 10.0, at.1), (at.0 + 10.0, at.1)];
    match entry.mark {
        Mark::Line => canvas.line(&ends, Pen::solid(&entry.fill, 2.5)),
        Mark::Dashes => canvas.line(&ends, Pen::dashed(&entry.fill, 2.5, SHORT_DASHES)),
        Mark::Box => canvas.rect((at.0 - 10.0, at.1 - 6.0), (20.0, 12.0), &entry.fill, &entry.outline),
        Mark::Dot => canvas.dot(at, 4.0, &entry.fill, &entry.outline),
        Mark::Diamond => canvas.diamond(at, &entry.fill, &entry.outline),
        Mark::Cross => canvas.cross(at, &entry.fill),
    }
}

/// How many rows a legend takes.
pub(super) fn legend_height_px(entries: &[LegendEntry], left_px: f64) -> f64 {
    LEGEND_ROW_PX * legend_rows(entries, left_px).last().map_or(0.0, |row| (row + 1) as f64)
}

/// The row of each entry.
fn legend_rows(entries: &[LegendEntry], left_px: f64) -> Vec<usize> {
    let (mut x, mut row) = (left_px, 0);
    entries
        .iter()
        .map(|entry| {
            let width = entry_width_px(entry);
            if x > left_px && x + width > WIDTH_PX {
                (x, row) = (left_px, row + 1);
            }
            x += width;
            row
        })
        .collect()
}

fn entry_width_px(entry: &LegendEntry) -> f64 {
    26.0 + text_width_px(&entry.text, TEXT_SIZE) + 20.0
}
