//! What all figures are drawn on: lines, areas and texts in pixels, and the SVG that they become.

use std::fmt::Write as _;

use maud::{Markup, PreEscaped, Render, html};

pub(super) use super::palette::{INK, PAPER, color};

/// Width of every figure.
pub(super) const WIDTH_PX: f64 = 940.0;
/// Space above the first frame, with the title in it.
pub(super) const TITLE_PX: f64 = 40.0;

const FONT: &str = "DejaVu Sans, Verdana, Liberation Sans, Arial, sans-serif";
const TITLE_SIZE: u32 = 16;
pub(super) const LABEL_SIZE: u32 = 13;
pub(super) const TEXT_SIZE: u32 = 12;

pub(super) const SHORT_DASHES: &str = "5 3";
pub(super) const LONG_DASHES: &str = "8 4";

/// About how wide a text is.
pub(super) fn text_width_px(text: &str, size: u32) -> f64 {
    0.58 * f64::from(size) * text.chars().count() as f64
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

    /// Draws what is cut off at the border of a rectangle.
    pub(super) fn inside(&mut self, corner: (f64, f64), size: (f64, f64), draw: impl FnOnce(&mut Self)) {
        self.clips += 1;
        let id = format!("clip-{}", self.clips);
        let outside = std::mem::take(&mut self.body);
        draw(self);
        let inside = PreEscaped(std::mem::replace(&mut self.body, outside));
        self.add(&html! {
            clipPath id=(id) { rect x=(Px(corner.0)) y=(Px(corner.1)) width=(Px(size.0)) height=(Px(size.1)) {} }
            g clip-path={ "url(#" (id) ")" } { (inside) }
        });
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

    /// A filled outline, unless it encloses nothing.
    pub(super) fn polygon(&mut self, points: &[(f64, f64)], fill: &str) {
        if points.len() > 2 {
            self.add(&html! { polygon points=(Places(points)) fill=(fill) {} });
        }
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

/// Points of a line, in pixels, written to a tenth: a line has many.
struct Places<'a>(&'a [(f64, f64)]);

impl Render for Places<'_> {
    fn render_to(&self, buffer: &mut String) {
        for (number, (x, y)) in self.0.iter().enumerate() {
            if number > 0 {
                buffer.push(' ');
            }
            let tenths = |px: f64| (10.0 * px).round() / 10.0 + 0.0;
            let _ = write!(buffer, "{},{}", tenths(*x), tenths(*y));
        }
    }
}
