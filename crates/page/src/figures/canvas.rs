//! The sheet that all figures are drawn on: frames with axes, markers, legends, and the SVG text.

use std::fmt::Write as _;

use maud::{Markup, PreEscaped, Render, html};

use super::axis::Scale;
use super::palette::GRID;
pub(super) use super::palette::{INK, PAPER, color};

/// Width of every figure.
pub(super) const WIDTH_PX: f64 = 940.0;
/// Space above the first frame, with the title in it.
pub(super) const TITLE_PX: f64 = 40.0;
/// Space between the left edge and a frame, with the numbers and the label of its y axis in it.
pub(super) const LEFT_PX: f64 = 100.0;
/// Space below the last frame, with the numbers and the label of the x axis in it.
pub(super) const BELOW_PX: f64 = 54.0;
/// Height of one row of a legend.
pub(super) const LEGEND_ROW_PX: f64 = 22.0;

const FONT: &str = "DejaVu Sans, Verdana, Liberation Sans, Arial, sans-serif";
const TITLE_SIZE: u32 = 16;
const LABEL_SIZE: u32 = 13;
pub(super) const TICK_SIZE: u32 = 12;
pub(super) const TEXT_SIZE: u32 = 12;

const BLACK: &str = "#000000";
const FRAME_PEN: Pen<'static> = Pen { color: BLACK, width: 1.0, dashes: None };
/// How far a tick sticks out of its frame.
const TICK_PX: f64 = 5.0;
pub(super) const SHORT_DASHES: &str = "5 3";
pub(super) const LONG_DASHES: &str = "8 4";

/// About how wide a text is.
pub(super) fn text_width_px(text: &str, size: u32) -> f64 {
    0.58 * f64::from(size) * text.chars().count() as f64
}

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
}

/// What a frame says along its axes; without an x label it shows no numbers there either.
pub(super) struct FrameText<'a> {
    pub(super) x_label: Option<&'a str>,
    pub(super) y_label: &'a str,
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

/// Where a text stands beside its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

impl Anchor {
    fn name(self) -> &'static str {
        match self {
            Self::Start => "start",
            Self::Middle => "middle",
            Self::End => "end",
        }
    }
}

/// How a line is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pen<'a> {
    pub(super) color: &'a str,
    pub(super) width: f64,
    /// Lengths of dashes and gaps, as SVG has them.
    pub(super) dashes: Option<&'static str>,
}

impl<'a> Pen<'a> {
    pub(super) fn solid(color: &'a str, width: f64) -> Self {
        Self { color, width, dashes: None }
    }

    pub(super) fn dashed(color: &'a str, width: f64, dashes: &'static str) -> Self {
        Self { color, width, dashes: Some(dashes) }
    }
}

/// A length or a place in pixels, written to a hundredth.
pub(super) struct Px(pub(super) f64);

impl Render for Px {
    fn render_to(&self, buffer: &mut String) {
        let _ = write!(buffer, "{}", (100.0 * self.0).round() / 100.0 + 0.0);
    }
}

/// A figure under construction.
#[derive(Clone, Debug)]
pub(super) struct Canvas {
    size: (f64, f64),
    body: String,
    /// Clip paths so far.
    clips: usize,
}

impl Canvas {
    pub(super) fn new(title: &str, height_px: f64) -> Self {
        let mut canvas = Self::bare((WIDTH_PX, height_px));
        canvas.text_as(title, (WIDTH_PX / 2.0, 24.0), TITLE_SIZE, Anchor::Middle);
        canvas
    }

    /// A drawing of this size in pixels, without a title.
    pub(super) fn bare(size: (f64, f64)) -> Self {
        Self { size, body: String::new(), clips: 0 }
    }

    /// Axes around a frame, with their numbers and labels.
    pub(super) fn frame(&mut self, frame: &Frame, text: &FrameText) {
        if text.grid == Grid::Shown {
            self.grid(frame);
        }
        self.outline(frame);
        if text.x_label.is_some() {
            self.x_ticks(frame);
        }
        self.y_ticks(frame);
        self.axis_labels(frame, text);
    }

    pub(super) fn grid(&mut self, frame: &Frame) {
        let pen = Pen::solid(GRID, 1.0);
        for x in frame.x.ticks().into_iter().map(|tick| frame.x_px(tick)) {
            self.line(&[(x, frame.top), (x, frame.bottom)], pen);
        }
        for y in frame.y.ticks().into_iter().map(|tick| frame.y_px(tick)) {
            self.line(&[(frame.left, y), (frame.right, y)], pen);
        }
    }

    pub(super) fn x_ticks(&mut self, frame: &Frame) {
        for tick in frame.x.ticks() {
            let x = frame.x_px(tick);
            self.line(&[(x, frame.bottom), (x, frame.bottom + TICK_PX)], FRAME_PEN);
            self.text_as(&frame.x.text(tick), (x, frame.bottom + 16.0), TICK_SIZE, Anchor::Middle);
        }
    }

    pub(super) fn y_ticks(&mut self, frame: &Frame) {
        for tick in frame.y.ticks() {
            let y = frame.y_px(tick);
            self.line(&[(frame.left - TICK_PX, y), (frame.left, y)], FRAME_PEN);
            self.text_as(&frame.y.text(tick), (frame.left - 8.0, y + 4.4), TICK_SIZE, Anchor::End);
        }
    }

    /// The labels of the axes; a long one along y breaks before its unit.
    fn axis_labels(&mut self, frame: &Frame, text: &FrameText) {
        if let Some(label) = text.x_label {
            let at = (0.5 * (frame.left + frame.right), frame.bottom + 40.0);
            self.text_as(label, at, LABEL_SIZE, Anchor::Middle);
        }
        let middle = 0.5 * (frame.top + frame.bottom);
        let long = text_width_px(text.y_label, LABEL_SIZE) > frame.bottom - frame.top;
        match text.y_label.rsplit_once(" (") {
            Some((quantity, unit)) if long => {
                self.vertical_text(quantity, (16.0, middle));
                self.vertical_text(&format!("({unit}"), (32.0, middle));
            }
            _ => self.vertical_text(text.y_label, (24.0, middle)),
        }
    }

    /// The outline of a frame; once more over what was drawn into it.
    pub(super) fn outline(&mut self, frame: &Frame) {
        let size = (frame.right - frame.left, frame.bottom - frame.top);
        self.rect((frame.left, frame.top), size, "none", BLACK);
    }

    /// Draws what is cut off at the border of a frame.
    pub(super) fn inside(&mut self, frame: &Frame, draw: impl FnOnce(&mut Self)) {
        self.clips += 1;
        let id = format!("clip-{}", self.clips);
        let outside = std::mem::take(&mut self.body);
        draw(self);
        let inside = PreEscaped(std::mem::replace(&mut self.body, outside));
        let (width, height) = (frame.right - frame.left, frame.bottom - frame.top);
        self.add(&html! {
            clipPath id=(id) { rect x=(Px(frame.left)) y=(Px(frame.top)) width=(Px(width)) height=(Px(height)) {} }
            g clip-path={ "url(#" (id) ")" } { (inside) }
        });
    }

    /// A row of entries, broken where it gets too long, from a height downward.
    pub(super) fn legend(&mut self, entries: &[LegendEntry], left_px: f64, top_px: f64) {
        let (mut x, mut y) = (left_px, top_px + 0.5 * LEGEND_ROW_PX);
        for (entry, row) in entries.iter().zip(legend_rows(entries, left_px)) {
            if top_px + (row as f64 + 0.5) * LEGEND_ROW_PX > y {
                (x, y) = (left_px, top_px + (row as f64 + 0.5) * LEGEND_ROW_PX);
            }
            self.legend_mark(entry, (x + 10.0, y));
            self.text_as(&entry.text, (x + 26.0, y + 4.0), TEXT_SIZE, Anchor::Start);
            x += entry_width_px(entry);
        }
    }

    fn legend_mark(&mut self, entry: &LegendEntry, at: (f64, f64)) {
        let ends = [(at.0 - 10.0, at.1), (at.0 + 10.0, at.1)];
        match entry.mark {
            Mark::Line => self.line(&ends, Pen::solid(&entry.fill, 2.5)),
            Mark::Dashes => self.line(&ends, Pen::dashed(&entry.fill, 2.5, SHORT_DASHES)),
            Mark::Box => self.rect((at.0 - 10.0, at.1 - 6.0), (20.0, 12.0), &entry.fill, &entry.outline),
            Mark::Dot => self.dot(at, 4.0, &entry.fill, &entry.outline),
            Mark::Diamond => self.diamond(at, &entry.fill, &entry.outline),
            Mark::Cross => self.cross(at, &entry.fill),
        }
    }

    pub(super) fn text(&mut self, text: &str, at: (f64, f64)) {
        self.text_as(text, (at.0, at.1 + 4.0), TEXT_SIZE, Anchor::Middle);
    }

    pub(super) fn text_as(&mut self, text: &str, at: (f64, f64), size: u32, anchor: Anchor) {
        self.add(&html! {
            text x=(Px(at.0)) y=(Px(at.1)) font-size=(size) text-anchor=(anchor.name()) { (text) }
        });
    }

    /// A text along a vertical axis, read from below.
    pub(super) fn vertical_text(&mut self, text: &str, at: (f64, f64)) {
        let (x, y) = (Px(at.0), Px(at.1));
        self.add(&html! {
            text x=(x) y=(y) font-size=(LABEL_SIZE) text-anchor="middle" transform={ "rotate(-90 " (x) " " (y) ")" } {
                (text)
            }
        });
    }

    pub(super) fn line(&mut self, points: &[(f64, f64)], pen: Pen) {
        self.add(&html! {
            polyline points=(Places(points)) fill="none" stroke=(pen.color) stroke-width=(Px(pen.width))
                stroke-dasharray=[pen.dashes] {}
        });
    }

    pub(super) fn area(&mut self, d: &str, fill: &str) {
        self.path(d, fill, "none", 0.0);
    }

    pub(super) fn path(&mut self, d: &str, fill: &str, stroke: &str, width: f64) {
        self.add(&html! { path d=(d) fill=(fill) stroke=(stroke) stroke-width=(Px(width)) {} });
    }

    pub(super) fn rect(&mut self, corner: (f64, f64), size: (f64, f64), fill: &str, outline: &str) {
        self.add(&html! {
            rect x=(Px(corner.0)) y=(Px(corner.1)) width=(Px(size.0)) height=(Px(size.1)) fill=(fill)
                stroke=[(outline != "none").then_some(outline)] {}
        });
    }

    pub(super) fn dot(&mut self, at: (f64, f64), radius: f64, fill: &str, outline: &str) {
        self.circle(at, radius, fill, Pen::solid(outline, 1.2));
    }

    pub(super) fn circle(&mut self, at: (f64, f64), radius: f64, fill: &str, outline: Pen) {
        self.add(&html! {
            circle cx=(Px(at.0)) cy=(Px(at.1)) r=(Px(radius)) fill=(fill) stroke=(outline.color)
                stroke-width=(Px(outline.width)) {}
        });
    }

    /// Width and height in pixels.
    pub(super) fn size(&self) -> (f64, f64) {
        self.size
    }

    pub(super) fn diamond(&mut self, (x, y): (f64, f64), fill: &str, outline: &str) {
        let r = 6.5;
        let d = format!("M{:.2} {y:.2}L{x:.2} {:.2}L{:.2} {y:.2}L{x:.2} {:.2}Z", x - r, y - r, x + r, y + r);
        self.path(&d, fill, outline, 1.4);
    }

    pub(super) fn cross(&mut self, (x, y): (f64, f64), color: &str) {
        let r = 3.0;
        self.line(&[(x - r, y - r), (x + r, y + r)], Pen::solid(color, 1.2));
        self.line(&[(x - r, y + r), (x + r, y - r)], Pen::solid(color, 1.2));
    }

    pub(super) fn add(&mut self, element: &Markup) {
        self.body.push_str(&element.0);
    }

    /// The SVG text of a file of its own, with a view box so that a page may scale it.
    pub(super) fn svg(self) -> String {
        let (width, height) = (Px(self.size.0), Px(self.size.1));
        let svg = html! {
            svg viewBox={ "0 0 " (width) " " (height) } xmlns="http://www.w3.org/2000/svg" width=(width) height=(height)
                font-family=(FONT) fill=(INK) {
                rect width="100%" height="100%" fill=(PAPER) {}
                (PreEscaped(self.body))
            }
        };
        svg.into_string()
    }

    /// The SVG element of a page, around the middle of its view box or from its corner.
    pub(super) fn element(&self, corner: (f64, f64)) -> Markup {
        let ((left, top), (width, height)) = ((Px(corner.0), Px(corner.1)), (Px(self.size.0), Px(self.size.1)));
        html! {
            svg viewBox={ (left) " " (top) " " (width) " " (height) } width=(width) height=(height) fill=(INK) {
                (PreEscaped(&self.body))
            }
        }
    }
}

/// Points of a line, in pixels.
struct Places<'a>(&'a [(f64, f64)]);

impl Render for Places<'_> {
    fn render_to(&self, buffer: &mut String) {
        for (number, (x, y)) in self.0.iter().enumerate() {
            if number > 0 {
                buffer.push(' ');
            }
            Px(*x).render_to(buffer);
            buffer.push(',');
            Px(*y).render_to(buffer);
        }
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
