//! How points and lines of a chart are drawn, and the legend that says what they mean.

use maud::{Markup, html};

use super::canvas::{Canvas, Pen};
use super::palette::{INK, PAPER};

const LINE_PX: f64 = 2.0;
pub(super) const THIN_PX: f64 = 1.5;

/// How a point is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Mark {
    /// A filled circle.
    Dot,
    /// A circle with paper inside.
    Ring,
    /// A square with paper inside.
    Square,
    /// A very small filled circle.
    Speck,
    /// Two strokes, for what has no value.
    Cross,
    /// A large diamond that shows what is below it.
    Target,
}

/// How a line is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stroke {
    /// Without gaps.
    Solid,
    /// Long pieces.
    Dashes,
    /// Short pieces.
    Dots,
}

/// An entry of a legend: a sample of what is drawn, and what it means.
#[derive(Clone, Debug)]
pub struct Key {
    sample: Canvas,
    text: String,
}

impl Key {
    /// An entry without a sample, to be given one or several.
    pub fn new(text: &str) -> Self {
        Self { sample: Canvas::bare((26.0, 24.0)), text: text.to_owned() }
    }

    /// With a piece of a line.
    pub fn line(mut self, stroke: Stroke, color: &str) -> Self {
        self.sample.line(&[(-12.0, 0.0), (12.0, 0.0)], pen(stroke, color));
        self
    }

    /// With a mark.
    pub fn mark(mut self, mark: Mark, color: &str) -> Self {
        draw_mark(&mut self.sample, (0.0, 0.0), mark, color);
        self
    }

    /// With a field of a color.
    pub fn field(mut self, color: &str) -> Self {
        self.sample.rect((-11.0, -6.0), (22.0, 12.0), color, INK);
        self
    }

    /// With a whisker.
    pub fn whisker(mut self, color: &str) -> Self {
        draw_whisker(&mut self.sample, 0.0, (-6.0, 6.0), color);
        self
    }

    /// With the border between two cells.
    pub fn border(mut self) -> Self {
        self.sample.line(&[(-12.0, 0.0), (12.0, 0.0)], Pen::solid(INK, THIN_PX));
        self
    }
}

/// The entries of a legend, unless there are none.
pub(crate) fn legend_markup(legend: &[Key]) -> Markup {
    html! {
        @if !legend.is_empty() {
            ul class="legend" {
                @for key in legend {
                    li { (key.sample.element((-13.0, -12.0))) " " (crate::text::escaped(&key.text)) }
                }
            }
        }
    }
}

pub(super) fn pen(stroke: Stroke, color: &str) -> Pen<'_> {
    match stroke {
        Stroke::Solid => Pen::solid(color, LINE_PX),
        Stroke::Dashes => Pen::dashed(color, LINE_PX, "7 4"),
        Stroke::Dots => Pen::dashed(color, LINE_PX, "2 3"),
    }
}

pub(super) fn draw_whisker(canvas: &mut Canvas, x: f64, (top, bottom): (f64, f64), color: &str) {
    for ends in [[(x, top), (x, bottom)], [(x - 5.0, top), (x + 5.0, top)], [(x - 5.0, bottom), (x + 5.0, bottom)]] {
        canvas.line(&ends, Pen::solid(color, THIN_PX));
    }
}

pub(super) fn draw_mark(canvas: &mut Canvas, (x, y): (f64, f64), mark: Mark, color: &str) {
    let circle = |canvas: &mut Canvas, r: f64, fill: &str, pen: Pen| canvas.circle((x, y), r, fill, pen);
    let strokes = |canvas: &mut Canvas, r: f64, pen: Pen| {
        canvas.line(&[(x - r, y - r), (x + r, y + r)], pen);
        canvas.line(&[(x - r, y + r), (x + r, y - r)], pen);
    };
    match mark {
        Mark::Dot => circle(canvas, 4.0, color, Pen::solid(PAPER, 1.0)),
        Mark::Ring => circle(canvas, 4.5, PAPER, Pen::solid(color, 1.8)),
        Mark::Speck => circle(canvas, 2.2, color, Pen::solid(PAPER, 0.9)),
        Mark::Square => canvas.rect((x - 4.0, y - 4.0), (8.0, 8.0), PAPER, color),
        // On any color: light below, dark above.
        Mark::Target => {
            let r = 9.0;
            let diamond = [(x, y - r), (x + r, y), (x, y + r), (x - r, y), (x, y - r), (x + r, y)];
            canvas.line(&diamond, Pen::solid(PAPER, 5.0));
            canvas.line(&diamond, Pen::solid(color, 2.6));
        }
        Mark::Cross => {
            strokes(canvas, 4.0, Pen::solid(PAPER, 4.5));
            strokes(canvas, 4.0, Pen::solid(color, 2.0));
        }
    }
}
