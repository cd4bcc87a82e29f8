//! A drawing between two axes, as SVG.

use std::fmt::Write as _;

use super::axis::{Scale, label};
use super::html::escape;
use super::palette::{GRID, INK, PAPER};

const FONT_PX: f64 = 12.0;
/// About the width of a digit.
const DIGIT_PX: f64 = 7.2;
/// Along x, where there is room.
const MOST_TICKS: usize = 8;
const TOP_PX: f64 = 8.0;
const BELOW_PX: f64 = 24.0;

/// How a run is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Mark {
    Dot,
    Ring,
    Square,
    Speck,
    Cross,
    Target,
}

/// How a line is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stroke {
    Solid,
    Dashes,
    Dots,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Ticks {
    Any,
    Whole,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Grid {
    Shown,
    Hidden,
}

/// A rectangle in pixels, and what its sides stand for.
#[derive(Debug, Clone, Copy)]
struct Frame {
    left: f64,
    top: f64,
    width: f64,
    height: f64,
    x: Scale,
    y: Scale,
}

#[derive(Debug)]
pub(super) struct Chart {
    svg: String,
    frame: Frame,
}

impl Chart {
    /// Axes with their numbers, in a drawing of this size in pixels, with room on its right.
    pub(super) fn new(size: (f64, f64), room: f64, x: (Scale, Ticks), y: Scale, grid: Grid) -> Self {
        let (width, height) = size;
        let y_ticks = y.ticks(6);
        let widest = y_ticks.iter().map(|&tick| width_of(&label(tick))).fold(0.0, f64::max);
        // The first and the last number along x stick out by half.
        let half = 0.5 * x.0.ticks(MOST_TICKS).iter().map(|&tick| width_of(&label(tick))).fold(0.0, f64::max);
        let (left, right) = ((widest + 14.0).max(half), room.max(half + 4.0).max(12.0));
        let frame =
            Frame { left, top: TOP_PX, width: width - left - right, height: height - TOP_PX - BELOW_PX, x: x.0, y };
        let svg = format!(
            "<svg width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" font-size=\"{FONT_PX}\" fill=\"{INK}\">\n"
        );
        let mut chart = Self { svg, frame };
        chart.draw_axes(&frame.x_ticks(x.1), &y_ticks, grid);
        chart
    }

    fn draw_axes(&mut self, x_ticks: &[f64], y_ticks: &[f64], grid: Grid) {
        let Frame { left, top, width, height, .. } = self.frame;
        let (right, bottom) = (left + width, top + height);
        let long = grid == Grid::Shown;
        for &tick in y_ticks {
            let y = self.frame.y_px(tick);
            self.straight((left - 4.0, y), (if long { right } else { left }, y), GRID);
            self.text(&label(tick), (left - 7.0, y + 4.0), "end");
        }
        for &tick in x_ticks {
            let x = self.frame.x_px(tick);
            self.straight((x, bottom + 4.0), (x, if long { top } else { bottom }), GRID);
            self.text(&label(tick), (x, bottom + 17.0), "middle");
        }
        self.outline();
    }

    /// The frame itself, over what was drawn into it.
    pub(super) fn outline(&mut self) {
        let Frame { left, top, width, height, .. } = self.frame;
        let _ = writeln!(
            self.svg,
            "<rect x=\"{left:.1}\" y=\"{top:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" fill=\"none\" stroke=\"{INK}\"/>"
        );
    }

    fn straight(&mut self, from: (f64, f64), to: (f64, f64), color: &str) {
        let _ = writeln!(
            self.svg,
            "<line x1=\"{:.1}\" y1=\"{:.1}\" x2=\"{:.1}\" y2=\"{:.1}\" stroke=\"{color}\"/>",
            from.0, from.1, to.0, to.1
        );
    }

    fn text(&mut self, text: &str, at: (f64, f64), anchor: &str) {
        let text = escape(text);
        let _ = writeln!(self.svg, "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"{anchor}\">{text}</text>", at.0, at.1);
    }

    /// A color behind this range of x.
    pub(super) fn band(&mut self, from: f64, to: f64, color: &str) {
        let Frame { top, height, .. } = self.frame;
        let (left, right) = (self.frame.x_px(from), self.frame.x_px(to));
        let _ = writeln!(
            self.svg,
            "<rect x=\"{:.1}\" y=\"{top:.1}\" width=\"{:.1}\" height=\"{height:.1}\" fill=\"{color}\"/>",
            left - 1.0,
            right - left + 2.0
        );
    }

    /// A rectangle in the units of the axes; a pointer that rests on it shows the title.
    pub(super) fn cell(&mut self, x: (f64, f64), y: (f64, f64), fill: &str, class: &str, title: &str) {
        // Whole pixels, so that no seam shows between neighbors.
        let whole = |(x, y): (f64, f64)| (x.round(), y.round());
        let ((left, top), (right, bottom)) = (whole(self.frame.px((x.0, y.1))), whole(self.frame.px((x.1, y.0))));
        let _ = writeln!(
            self.svg,
            "<rect class=\"{class}\" x=\"{left}\" y=\"{top}\" width=\"{}\" height=\"{}\" fill=\"{fill}\"><title>{}</title></rect>",
            right - left,
            bottom - top,
            escape(title)
        );
    }

    /// Between two points in the units of the axes, dark enough for any ground.
    pub(super) fn border(&mut self, from: (f64, f64), to: (f64, f64)) {
        let whole = |(x, y): (f64, f64)| (x.round(), y.round());
        let (from, to) = (whole(self.frame.px(from)), whole(self.frame.px(to)));
        let _ = writeln!(
            self.svg,
            "<line x1=\"{:.1}\" y1=\"{:.1}\" x2=\"{:.1}\" y2=\"{:.1}\" stroke=\"{INK}\" stroke-width=\"1.5\" stroke-linecap=\"square\"/>",
            from.0, from.1, to.0, to.1
        );
    }

    pub(super) fn line(&mut self, points: &[(f64, f64)], stroke: Stroke, color: &str) {
        let mut place = String::new();
        for &point in points.iter().filter(|(x, y)| x.is_finite() && y.is_finite()) {
            let (x, y) = self.frame.px(point);
            let _ = write!(place, "{x:.1},{y:.1} ");
        }
        let _ = writeln!(self.svg, "<polyline points=\"{}\" {}/>", place.trim_end(), stroke_of(stroke, color));
    }

    /// From one value to another at an x.
    pub(super) fn whisker(&mut self, x: f64, low: f64, high: f64, color: &str) {
        let ((x, top), (_, bottom)) = (self.frame.px((x, high)), self.frame.px((x, low)));
        let _ = writeln!(
            self.svg,
            "<path d=\"M{x:.1} {top:.1}V{bottom:.1}M{:.1} {top:.1}h10M{:.1} {bottom:.1}h10\" fill=\"none\" stroke=\"{color}\" stroke-width=\"1.5\"/>",
            x - 5.0,
            x - 5.0
        );
    }

    pub(super) fn mark(&mut self, point: (f64, f64), mark: Mark, color: &str) {
        if !(point.0.is_finite() && point.1.is_finite()) {
            return;
        }
        let (x, y) = self.frame.px(point);
        let _ = writeln!(self.svg, "{}", mark_at((x, y), mark, color));
    }

    /// A bar of colors on the right, from the lower end of a scale up.
    pub(super) fn color_bar(&mut self, scale: Scale, color: impl Fn(f64) -> String) {
        const STEPS: usize = 48;
        let Frame { left, top, width, height, .. } = self.frame;
        let (x, bar) = (left + width + 14.0, 14.0);
        let strip = height / STEPS as f64;
        for step in 0..STEPS {
            let share = (step as f64 + 0.5) / STEPS as f64;
            let y = top + height - (step + 1) as f64 * strip;
            let _ = writeln!(
                self.svg,
                "<rect x=\"{x:.1}\" y=\"{y:.2}\" width=\"{bar}\" height=\"{:.2}\" fill=\"{}\" shape-rendering=\"crispEdges\"/>",
                strip + 0.3,
                color(share)
            );
        }
        for tick in scale.ticks(6) {
            let y = top + height * (1.0 - scale.place(tick));
            self.straight((x + bar, y), (x + bar + 4.0, y), INK);
            self.text(&label(tick), (x + bar + 7.0, y + 4.0), "start");
        }
    }

    pub(super) fn svg(mut self) -> String {
        self.svg.push_str("</svg>");
        self.svg
    }
}

impl Frame {
    fn x_px(&self, x: f64) -> f64 {
        self.left + self.x.place(x) * self.width
    }

    fn y_px(&self, y: f64) -> f64 {
        self.top + (1.0 - self.y.place(y)) * self.height
    }

    fn px(&self, (x, y): (f64, f64)) -> (f64, f64) {
        (self.x_px(x), self.y_px(y))
    }

    /// As many numbers along x as fit.
    fn x_ticks(&self, ticks: Ticks) -> Vec<f64> {
        let at_most = |most: usize| match ticks {
            Ticks::Any => self.x.ticks(most),
            Ticks::Whole => self.x.whole_ticks(most),
        };
        let fits = |ticks: &Vec<f64>| ticks.iter().map(|&tick| width_of(&label(tick)) + 12.0).sum::<f64>() < self.width;
        (1..=MOST_TICKS).rev().map(at_most).find(fits).unwrap_or_default()
    }
}

/// Room for a bar of colors with these numbers.
pub(super) fn color_bar_room(scale: Scale) -> f64 {
    scale.ticks(6).iter().map(|&tick| width_of(&label(tick))).fold(0.0, f64::max) + 40.0
}

fn width_of(text: &str) -> f64 {
    DIGIT_PX * text.chars().count() as f64
}

fn stroke_of(stroke: Stroke, color: &str) -> String {
    let dashes = match stroke {
        Stroke::Solid => "",
        Stroke::Dashes => " stroke-dasharray=\"7 4\"",
        Stroke::Dots => " stroke-dasharray=\"2 3\"",
    };
    format!("fill=\"none\" stroke=\"{color}\" stroke-width=\"2\"{dashes}")
}

/// A piece of a line, for a legend.
pub(super) fn line_sample(stroke: Stroke, color: &str) -> String {
    format!("<line x1=\"-12\" y1=\"0\" x2=\"12\" y2=\"0\" {}/>", stroke_of(stroke, color))
}

/// A field of a color, for a legend.
pub(super) fn field_sample(color: &str) -> String {
    format!(
        "<rect x=\"-11\" y=\"-6\" width=\"22\" height=\"12\" fill=\"{color}\" stroke=\"{INK}\" stroke-width=\"0.5\"/>"
    )
}

pub(super) fn whisker_sample(color: &str) -> String {
    format!("<path d=\"M0 -6V6M-5 -6h10M-5 6h10\" fill=\"none\" stroke=\"{color}\" stroke-width=\"1.5\"/>")
}

pub(super) fn border_sample() -> String {
    format!("<line x1=\"-12\" y1=\"0\" x2=\"12\" y2=\"0\" stroke=\"{INK}\" stroke-width=\"1.5\"/>")
}

/// A mark, for a legend.
pub(super) fn mark_sample(mark: Mark, color: &str) -> String {
    mark_at((0.0, 0.0), mark, color)
}

fn mark_at((x, y): (f64, f64), mark: Mark, color: &str) -> String {
    let circle = |r: f64, fill: &str, stroke: &str, width: f64| {
        format!(
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{r}\" fill=\"{fill}\" stroke=\"{stroke}\" stroke-width=\"{width}\"/>"
        )
    };
    let path = |d: &str, fill: &str, stroke: &str, width: f64| {
        format!(
            "<path transform=\"translate({x:.1} {y:.1})\" d=\"{d}\" fill=\"{fill}\" stroke=\"{stroke}\" stroke-width=\"{width}\"/>"
        )
    };
    match mark {
        Mark::Dot => circle(4.0, color, PAPER, 1.0),
        Mark::Ring => circle(4.5, PAPER, color, 1.8),
        Mark::Speck => circle(2.2, color, PAPER, 0.9),
        Mark::Square => path("M-4 -4h8v8h-8z", PAPER, color, 1.8),
        // On any ground: light below, dark above.
        Mark::Target => {
            let d = "M0 -9L9 0L0 9L-9 0Z";
            path(d, "none", PAPER, 5.0) + &path(d, "none", color, 2.6)
        }
        Mark::Cross => {
            let d = "M-4 -4L4 4M-4 4L4 -4";
            path(d, "none", PAPER, 4.5) + &path(d, "none", color, 2.0)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_stand_where_the_axes_say() {
        let (x, y) = (Scale::Linear { min: 0.0, max: 10.0 }, Scale::Linear { min: -1.0, max: 1.0 });
        let mut chart = Chart::new((200.0, 100.0), 20.0, (x, Ticks::Any), y, Grid::Shown);
        let Frame { left, top, width, height, .. } = chart.frame;
        assert_eq!((left + width, top + height), (180.0, 76.0));
        chart.mark((10.0, 1.0), Mark::Dot, INK);
        chart.mark((0.0, 0.0), Mark::Ring, INK);
        chart.mark((f64::NAN, 0.0), Mark::Dot, INK);
        let svg = chart.svg();
        assert!(svg.contains("<circle cx=\"180.0\" cy=\"8.0\""), "{svg}");
        assert!(svg.contains(&format!("<circle cx=\"{left:.1}\" cy=\"42.0\"")), "{svg}");
        assert!(!svg.contains("NaN"), "a place that is none");
    }

    #[test]
    fn numbers_along_x_do_not_touch() {
        let x = Scale::Linear { min: 1.0e6, max: 1.000_001e6 };
        for width in [60.0, 120.0, 300.0] {
            let frame = Frame { left: 0.0, top: 0.0, width, height: 9.0, x, y: x };
            let ticks = frame.x_ticks(Ticks::Any);
            let widest = ticks.iter().map(|&tick| width_of(&label(tick))).fold(0.0, f64::max);
            let apart = ticks.windows(2).map(|pair| frame.x_px(pair[1]) - frame.x_px(pair[0]));
            assert!(apart.fold(f64::INFINITY, f64::min) > widest, "{width}: {ticks:?}");
        }
    }
}
