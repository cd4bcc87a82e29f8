//! A small drawing between two axes, of which a page shows several side by side.

use maud::{Markup, html};

use super::axis::Axis;
use super::canvas::{Canvas, INK, Pen, Px, text_width_px};
use super::color_scale::{BAR_WIDTH_PX, Bands, Bar, LINE_PX};
use super::frame::{Frame, Grid, TICK_SIZE};
use super::marks::{Key, Mark, Stroke, THIN_PX, draw_mark, draw_whisker, legend_markup, pen};
use super::scale::Scale;

const TOP_PX: f64 = 8.0;
const BELOW_PX: f64 = 24.0;
const RIGHT_PX: f64 = 12.0;
/// More than seven digits.
const LONG_NUMBER_PX: f64 = 50.0;
/// How far above the lower edge a mark is drawn that has no height.
const ABOVE_EDGE_PX: f64 = 8.0;
/// Along x and along y, where there is room.
const MOST_TICKS: usize = 8;
const Y_TICKS: usize = 5;
/// Names along y are as wide at most.
const MOST_NAME_PX: f64 = 120.0;
/// Where the step of an axis is given and its ticks do not fit, some multiple of it.
const COARSER: [f64; 6] = [2.0, 5.0, 10.0, 20.0, 50.0, 100.0];

/// A rectangle of a map.
#[derive(Clone, Debug)]
pub struct MapCell {
    /// From and to, in units of the axis.
    pub x: (f64, f64),
    /// From and to, in units of the axis.
    pub y: (f64, f64),
    /// A color of SVG.
    pub fill: String,
    /// The class of the element.
    pub class: String,
    /// What a pointer that rests on it shows.
    pub title: String,
}

/// What stands at ticks: names in their place, or numbers.
struct TickText<'a> {
    names: &'a [String],
}

impl<'a> TickText<'a> {
    /// The names of an axis, if it has some and they fit.
    fn of(axis: &'a Axis, fits: impl Fn(&Self) -> bool) -> Self {
        let names = Self { names: axis.names() };
        if fits(&names) { names } else { Self { names: &[] } }
    }

    fn text(&self, scale: &Scale, tick: f64) -> String {
        let place = tick.round();
        let name = (place >= 0.0).then(|| self.names.get(place as usize)).flatten();
        name.cloned().unwrap_or_else(|| scale.text(tick))
    }

    fn widest(&self, scale: &Scale) -> f64 {
        scale.ticks().into_iter().map(|tick| text_width_px(&self.text(scale, tick), TICK_SIZE)).fold(0.0, f64::max)
    }
}

/// A drawing between two axes; its labels stand around it, in the text of the page.
#[derive(Clone, Debug)]
pub struct Chart {
    canvas: Canvas,
    frame: Frame,
    x_label: String,
    y_label: String,
    legend: Vec<Key>,
}

impl Chart {
    /// Axes with their numbers in a drawing of this size in pixels. The axes need a range.
    pub fn new(size: (f64, f64), x: &Axis, y: &Axis, grid: Grid) -> Self {
        Self::with_room(size, RIGHT_PX, x, y, grid)
    }

    /// The same with a bar of colors on the right.
    pub fn with_color_bar(size: (f64, f64), x: &Axis, y: &Axis, bands: &Bands) -> Self {
        let text_px = bands.text_width_px();
        // Digits are wider than other letters, which tells where there are many.
        let digits_px = if text_px > LONG_NUMBER_PX { 0.1 * text_px } else { 0.0 };
        let label = bands.label_lines(size.1 - BELOW_PX);
        let label_px = 22.0 + LINE_PX * label.len().saturating_sub(1) as f64;
        let room = 14.0 + BAR_WIDTH_PX + 6.0 + text_px + digits_px + label_px;
        let mut chart = Self::with_room(size, room, x, y, Grid::Hidden);
        let Frame { top, bottom, right, .. } = chart.frame;
        // Room for the tip.
        let bar = Bar { left: right + 14.0, top: top + 16.0, bottom, label_x: size.0 - 4.0 };
        bar.draw(&mut chart.canvas, bands, &label);
        chart
    }

    fn with_room(size: (f64, f64), room: f64, x: &Axis, y: &Axis, grid: Grid) -> Self {
        let y_scale = y.scale(std::iter::empty(), Y_TICKS);
        let y_text = TickText::of(y, |names| names.widest(&y_scale) <= MOST_NAME_PX);
        let most = x.scale(std::iter::empty(), MOST_TICKS);
        let sides = |text: &TickText<'_>| {
            // The first and the last number along x stick out by half.
            let half = 0.5 * text.widest(&most);
            ((y_text.widest(&y_scale) + 14.0).max(half), size.0 - room.max(half + 4.0))
        };
        let fits = |text: &TickText<'_>, scale: &Scale| {
            let (left, right) = sides(text);
            scale.ticks().len() as f64 * (text.widest(scale) + 12.0) < right - left
        };
        let x_text = TickText::of(x, |names| fits(names, &most));
        let (left, right) = sides(&x_text);
        let x_scales = (1..=MOST_TICKS).rev().map(|ticks| x.scale(std::iter::empty(), ticks));
        let mut x_scales = x_scales.chain(COARSER.map(|times| most.with_step(times * most.step)));
        // Where no number fits, at most one stands.
        let x_scale = x_scales
            .find(|scale| fits(&x_text, scale))
            .unwrap_or_else(|| Scale::even(most.min, most.max, 10.0 * (most.max - most.min)));
        let frame = Frame { left, top: TOP_PX, right, bottom: size.1 - BELOW_PX, x: x_scale, y: y_scale };
        let mut canvas = Canvas::bare(size);
        if grid == Grid::Shown {
            frame.draw_grid(&mut canvas);
        }
        frame.draw_x_ticks_as(&mut canvas, |tick| x_text.text(&frame.x, tick));
        frame.draw_y_ticks_as(&mut canvas, |tick| y_text.text(&frame.y, tick));
        frame.outline(&mut canvas);
        let [x_label, y_label] = [(x, &x_text, frame.x), (y, &y_text, frame.y)].map(|(axis, text, scale)| {
            let label = if text.names.is_empty() { axis.numbered_label() } else { axis.label().to_string() };
            format!("{label}{}", scale.above())
        });
        Self { canvas, frame, x_label, y_label, legend: Vec::new() }
    }

    /// The frame once more, over what was drawn into it.
    pub fn outline(&mut self) {
        self.frame.outline(&mut self.canvas);
    }

    /// A color behind a range of x.
    pub fn band(&mut self, from: f64, to: f64, color: &str) {
        let (left, right) = (self.frame.x_px(from), self.frame.x_px(to));
        let size = (right - left + 2.0, self.frame.bottom - self.frame.top);
        self.canvas.rect((left - 1.0, self.frame.top), size, color, "none");
    }

    /// A line from the lower to the upper edge.
    pub fn divider(&mut self, x: f64, color: &str) {
        let x = self.frame.x_px(x);
        self.canvas.line(&[(x, self.frame.top), (x, self.frame.bottom)], Pen::solid(color, THIN_PX));
    }

    /// A color between two lines: x, and from where to where there. Points that are not finite are left out.
    pub fn ribbon(&mut self, points: &[(f64, f64, f64)], color: &str) {
        let is_finite = |(x, low, high): &&(f64, f64, f64)| [x, low, high].iter().all(|value| value.is_finite());
        let finite: Vec<&(f64, f64, f64)> = points.iter().filter(is_finite).collect();
        let there = finite.iter().map(|point| self.frame.px((point.0, point.2)));
        let back = finite.iter().rev().map(|point| self.frame.px((point.0, point.1)));
        let outline: Vec<(f64, f64)> = there.chain(back).collect();
        self.canvas.polygon(&outline, color);
    }

    /// A rectangle in the units of the axes.
    pub fn cell(&mut self, cell: &MapCell) {
        // Whole pixels, so that no seam shows between neighbors.
        let whole = |(x, y): (f64, f64)| (x.round(), y.round());
        let ((left, top), (right, bottom)) =
            (whole(self.frame.px((cell.x.0, cell.y.1))), whole(self.frame.px((cell.x.1, cell.y.0))));
        self.canvas.add(&html! {
            rect class=(cell.class) x=(Px(left)) y=(Px(top)) width=(Px(right - left)) height=(Px(bottom - top))
                fill=(cell.fill) { title { (crate::text::escaped(&cell.title)) } }
        });
    }

    /// A straight line between two cells.
    pub fn border(&mut self, from: (f64, f64), to: (f64, f64)) {
        let whole = |(x, y): (f64, f64)| (x.round(), y.round());
        self.canvas.line(&[whole(self.frame.px(from)), whole(self.frame.px(to))], Pen::solid(INK, THIN_PX));
    }

    /// A line through the points that are finite.
    pub fn line(&mut self, points: &[(f64, f64)], stroke: Stroke, color: &str) {
        let finite = points.iter().filter(|(x, y)| x.is_finite() && y.is_finite());
        let places: Vec<(f64, f64)> = finite.map(|point| self.frame.px(*point)).collect();
        self.canvas.line(&places, pen(stroke, color));
    }

    /// A line from one value to another at an x, with its ends marked.
    pub fn whisker(&mut self, x: f64, low: f64, high: f64, color: &str) {
        let ((x, top), (_, bottom)) = (self.frame.px((x, high)), self.frame.px((x, low)));
        draw_whisker(&mut self.canvas, x, (top, bottom), color);
    }

    /// A mark at a point, unless that is not finite.
    pub fn mark(&mut self, point: (f64, f64), mark: Mark, color: &str) {
        if point.0.is_finite() && point.1.is_finite() {
            draw_mark(&mut self.canvas, self.frame.px(point), mark, color);
        }
    }

    /// A mark just above the lower edge, for what has an x and no y.
    pub fn mark_below(&mut self, x: f64, mark: Mark, color: &str) {
        if x.is_finite() {
            draw_mark(&mut self.canvas, (self.frame.x_px(x), self.frame.bottom - ABOVE_EDGE_PX), mark, color);
        }
    }

    /// Adds an entry to the legend below the drawing.
    pub fn key(&mut self, key: Key) {
        self.legend.push(key);
    }

    /// The figure as it stands in a page.
    pub(crate) fn markup(&self) -> Markup {
        html! {
            figure style={ "width: " (Px(self.canvas.size().0)) "px" } {
                div class="y" { (crate::text::escaped(&self.y_label)) }
                (self.canvas.element((0.0, 0.0)))
                div class="x" { (crate::text::escaped(&self.x_label)) }
                (legend_markup(&self.legend))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis(from: f64, to: f64) -> Axis {
        Axis::new("gap", "mm").with_range(from, to)
    }

    #[test]
    fn marks_stand_where_the_axes_say() {
        let mut chart = Chart::new((200.0, 100.0), &axis(0.0, 10.0), &axis(-1.0, 1.0), Grid::Shown);
        let Frame { left, right, bottom, .. } = chart.frame;
        assert!((bottom - 76.0).abs() < 1e-9, "{bottom}");
        chart.mark((10.0, 1.0), Mark::Dot, INK);
        chart.mark((0.0, 0.0), Mark::Ring, INK);
        chart.mark((f64::NAN, 0.0), Mark::Dot, INK);
        let html = chart.markup().into_string();
        let px = |value: f64| format!("{}", (100.0 * value).round() / 100.0);
        assert!(html.contains(&format!("<circle cx=\"{}\" cy=\"8\"", px(right))), "{html}");
        assert!(html.contains(&format!("<circle cx=\"{}\" cy=\"42\"", px(left))), "{html}");
        assert!(!html.contains("NaN"), "a place that is none");
    }

    #[test]
    fn divider_goes_from_edge_to_edge() {
        let mut chart = Chart::new((200.0, 100.0), &axis(0.0, 10.0), &axis(-1.0, 1.0), Grid::Hidden);
        chart.divider(0.0, INK);
        let left = (10.0 * chart.frame.left).round() / 10.0;
        let html = chart.markup().into_string();
        assert!(html.contains(&format!("points=\"{left},8 {left},76\"")), "{html}");
    }

    #[test]
    fn marks_without_a_height_stand_above_the_lower_edge() {
        let mut chart = Chart::new((200.0, 100.0), &axis(0.0, 10.0), &axis(-1.0, 1.0), Grid::Hidden);
        chart.mark_below(10.0, Mark::Dot, INK);
        chart.mark_below(f64::NAN, Mark::Dot, INK);
        let right = (100.0 * chart.frame.right).round() / 100.0;
        let html = chart.markup().into_string();
        assert!(html.contains(&format!("<circle cx=\"{right}\" cy=\"68\"")), "{html}");
        assert_eq!(html.matches("<circle").count(), 1, "{html}");
    }

    #[test]
    fn ribbon_goes_along_one_line_and_back_along_the_other() {
        let mut chart = Chart::new((200.0, 100.0), &axis(0.0, 10.0), &axis(-1.0, 1.0), Grid::Hidden);
        let Frame { left, right, top, bottom, .. } = chart.frame;
        chart.ribbon(&[(0.0, -1.0, 1.0), (5.0, f64::NAN, 1.0), (10.0, -1.0, 0.0)], INK);
        chart.ribbon(&[(f64::NAN, 0.0, 1.0)], INK);
        let html = chart.markup().into_string();
        let px = |value: f64| (10.0 * value).round() / 10.0;
        let (left, right, top, middle, bottom) = (px(left), px(right), px(top), px(0.5 * (top + bottom)), px(bottom));
        let outline = format!("points=\"{left},{top} {right},{middle} {right},{bottom} {left},{bottom}\"");
        assert!(html.contains(&outline), "{outline} in {html}");
        assert_eq!(html.matches("<polygon").count(), 1, "nothing is drawn of nothing: {html}");
    }

    #[test]
    fn numbers_along_x_do_not_touch() {
        for width in [120.0, 200.0, 400.0] {
            let chart = Chart::new((width, 90.0), &axis(1.0e6, 1.000_001e6), &axis(0.0, 1.0), Grid::Hidden);
            let scale = chart.frame.x;
            let ticks = scale.ticks();
            let widest = ticks.iter().map(|tick| text_width_px(&scale.text(*tick), TICK_SIZE)).fold(0.0, f64::max);
            let apart = ticks.windows(2).map(|pair| chart.frame.x_px(pair[1]) - chart.frame.x_px(pair[0]));
            assert!(apart.fold(f64::INFINITY, f64::min) > widest, "{width}: {ticks:?}");
        }
    }

    #[test]
    fn an_axis_far_from_zero_says_what_its_numbers_are_counted_from() {
        let force = Axis::new("force", "N").around([1_000_000.1, 1_000_000.6]);
        let html = Chart::new((200.0, 90.0), &axis(0.0, 1.0), &force, Grid::Hidden).markup().into_string();
        assert!(html.contains("force (N) above 1000000<") && html.contains(">0.2<"), "{html}");
        assert!(!html.contains("e6"), "{html}");
    }

    #[test]
    fn numbers_that_are_counted_are_fewer_where_all_do_not_fit() {
        let ticks = |last: usize, width: f64| {
            let counted = Axis::new("batch", "1").counting(1, last);
            Chart::new((width, 90.0), &counted, &axis(0.0, 1.0), Grid::Hidden).frame.x.ticks()
        };
        assert_eq!(ticks(10, 292.0), [2.0, 4.0, 6.0, 8.0, 10.0]);
        assert_eq!(ticks(6, 292.0), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        assert_eq!(ticks(20, 250.0), [4.0, 8.0, 12.0, 16.0, 20.0]);
    }

    #[test]
    fn color_bar_fits_beside_the_frame() {
        let z = Axis::new("force", "N").with_colors(crate::ColorScale::NearLowest);
        let bands = Bands::of(&z, (0..50).map(|i| f64::from(i * i)));
        let chart = Chart::with_color_bar((448.0, 380.0), &axis(0.0, 1.0), &axis(0.0, 1.0), &bands);
        assert!(chart.frame.right < 448.0 - 14.0 - BAR_WIDTH_PX - bands.text_width_px(), "{:?}", chart.frame);
        assert!(chart.markup().into_string().contains(">force (N) above the lowest, 0<"), "the bar says what it is");
    }
}
