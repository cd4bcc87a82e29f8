//! The sheet that all figures are drawn on: frames with axes (by kuva), markers, legends, and the SVG text.

use std::sync::Arc;

use kuva::backend::svg::SvgBackend;
use kuva::plot::LinePlot;
use kuva::render::layout::{AxisLine, Layout, TickFormat};
use kuva::render::plots::Plot;
use kuva::render::render::{PathData, Primitive, Scene, TextAnchor, render_multiple};

use super::axis::Scale;

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
const TICK_SIZE: u32 = 12;
pub(super) const TEXT_SIZE: u32 = 12;

pub(super) const INK: &str = "#222222";
pub(super) const PAPER: &str = "#ffffff";
const GRID: &str = "#dddddd";

/// The palette of Okabe and Ito, which color-blind readers can tell apart, dark and light by turns; its yellow is darkened
/// to be seen on white.
const COLORS: [&str; 8] = ["#0072b2", "#e69f00", "#cc79a7", "#009e73", "#d55e00", "#56b4e9", "#000000", "#a89f10"];

/// The color of the series with this index.
pub(super) fn color(index: usize) -> &'static str {
    COLORS[index % COLORS.len()]
}

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
        self.left + (x - self.x.min) / (self.x.max - self.x.min) * (self.right - self.left)
    }

    pub(super) fn y_px(&self, y: f64) -> f64 {
        self.bottom - (y - self.y.min) / (self.y.max - self.y.min) * (self.bottom - self.top)
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

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Grid {
    Shown,
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

/// A figure under construction.
pub(super) struct Canvas {
    scene: Scene,
}

impl Canvas {
    pub(super) fn new(title: &str, height_px: f64) -> Self {
        let mut scene = Scene::new(WIDTH_PX, height_px);
        scene.background_color = Some(PAPER.into());
        scene.text_color = Some(INK.into());
        scene.font_family = Some(FONT.into());
        let mut canvas = Self { scene };
        canvas.text_as(title, (WIDTH_PX / 2.0, 24.0), TITLE_SIZE, TextAnchor::Middle);
        canvas
    }

    /// Axes around a frame, and plots inside it.
    pub(super) fn frame(&mut self, frame: &Frame, text: &FrameText, plots: Vec<Plot>) {
        // kuva draws a whole figure with margins; the frame sits in one of its own, shifted to its place.
        let below = 30.0;
        let height = frame.bottom - frame.top + below;
        let mut layout = Layout::new((frame.x.min, frame.x.max), (frame.y.min, frame.y.max))
            .with_width(WIDTH_PX)
            .with_height(height)
            .with_force_margins(frame.left, WIDTH_PX - frame.right)
            .with_force_margins_y(0.0, below)
            .with_x_axis_min(frame.x.min)
            .with_x_axis_max(frame.x.max)
            .with_y_axis_min(frame.y.min)
            .with_y_axis_max(frame.y.max)
            .with_x_tick_step(frame.x.step)
            .with_y_tick_step(frame.y.step)
            .with_x_tick_format(tick_format(&frame.x))
            .with_y_tick_format(tick_format(&frame.y))
            .with_tick_size(TICK_SIZE)
            .with_show_grid(text.grid == Grid::Shown)
            .with_axis_line(AxisLine::Box);
        layout.theme.grid_color = GRID.into();
        layout.suppress_x_ticks = text.x_label.is_none();
        layout.show_legend = false;
        let plots = if plots.is_empty() { vec![LinePlot::new().into()] } else { plots };
        let inner = render_multiple(plots, layout);
        self.scene.defs.extend(inner.defs);
        let transform = Some(format!("translate(0,{})", frame.top));
        self.add(Primitive::GroupStart { transform, title: None, extra_attrs: None });
        for element in inner.elements {
            self.add(element);
        }
        self.add(Primitive::GroupEnd);
        self.axis_labels(frame, text);
    }

    /// The labels of the axes; a long one along y breaks before its unit.
    fn axis_labels(&mut self, frame: &Frame, text: &FrameText) {
        if let Some(label) = text.x_label {
            let at = (0.5 * (frame.left + frame.right), frame.bottom + 40.0);
            self.text_as(label, at, LABEL_SIZE, TextAnchor::Middle);
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

    /// The outline of a frame once more, over what was drawn into it.
    pub(super) fn outline(&mut self, frame: &Frame) {
        self.add(Primitive::Rect {
            x: frame.left,
            y: frame.top,
            width: frame.right - frame.left,
            height: frame.bottom - frame.top,
            fill: "none".into(),
            stroke: Some("black".into()),
            stroke_width: Some(1.0),
            opacity: None,
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
            self.text_as(&entry.text, (x + 26.0, y + 4.0), TEXT_SIZE, TextAnchor::Start);
            x += entry_width_px(entry);
        }
    }

    fn legend_mark(&mut self, entry: &LegendEntry, at: (f64, f64)) {
        match entry.mark {
            Mark::Line => self.line(&[(at.0 - 10.0, at.1), (at.0 + 10.0, at.1)], &entry.fill, 2.5),
            Mark::Dashes => self.dashed_line(&[(at.0 - 10.0, at.1), (at.0 + 10.0, at.1)], &entry.fill, 2.5),
            Mark::Box => self.rect((at.0 - 10.0, at.1 - 6.0), (20.0, 12.0), &entry.fill, &entry.outline),
            Mark::Dot => self.dot(at, 4.0, &entry.fill, &entry.outline),
            Mark::Diamond => self.diamond(at, &entry.fill, &entry.outline),
            Mark::Cross => self.cross(at, &entry.fill),
        }
    }

    pub(super) fn text(&mut self, text: &str, at: (f64, f64)) {
        self.text_as(text, (at.0, at.1 + 4.0), TEXT_SIZE, TextAnchor::Middle);
    }

    pub(super) fn text_as(&mut self, text: &str, at: (f64, f64), size: u32, anchor: TextAnchor) {
        self.add(Primitive::Text {
            x: at.0,
            y: at.1,
            content: text.into(),
            size,
            anchor,
            rotate: None,
            bold: false,
            color: Some(INK.into()),
        });
    }

    /// A text along a vertical axis, read from below.
    pub(super) fn vertical_text(&mut self, text: &str, at: (f64, f64)) {
        self.add(Primitive::Text {
            x: at.0,
            y: at.1,
            content: text.into(),
            size: LABEL_SIZE,
            anchor: TextAnchor::Middle,
            rotate: Some(-90.0),
            bold: false,
            color: Some(INK.into()),
        });
    }

    pub(super) fn line(&mut self, points: &[(f64, f64)], color: &str, width: f64) {
        self.add(Primitive::PolyLine {
            points: points.to_vec(),
            stroke: color.into(),
            stroke_width: width,
            stroke_dasharray: None,
        });
    }

    pub(super) fn dashed_line(&mut self, points: &[(f64, f64)], color: &str, width: f64) {
        self.add(Primitive::PolyLine {
            points: points.to_vec(),
            stroke: color.into(),
            stroke_width: width,
            stroke_dasharray: Some("5 3".into()),
        });
    }

    pub(super) fn area(&mut self, d: String, fill: &str) {
        self.path(d, fill, "none", 0.0);
    }

    pub(super) fn path(&mut self, d: String, fill: &str, stroke: &str, width: f64) {
        self.add(Primitive::Path(Box::new(PathData {
            d,
            fill: Some(fill.into()),
            stroke: stroke.into(),
            stroke_width: width,
            opacity: None,
            stroke_dasharray: None,
        })));
    }

    pub(super) fn rect(&mut self, corner: (f64, f64), size: (f64, f64), fill: &str, outline: &str) {
        self.add(Primitive::Rect {
            x: corner.0,
            y: corner.1,
            width: size.0,
            height: size.1,
            fill: fill.into(),
            stroke: Some(outline.into()),
            stroke_width: Some(1.0),
            opacity: None,
        });
    }

    pub(super) fn dot(&mut self, at: (f64, f64), radius: f64, fill: &str, outline: &str) {
        self.add(Primitive::Circle {
            cx: at.0,
            cy: at.1,
            r: radius,
            fill: fill.into(),
            fill_opacity: None,
            stroke: Some(outline.into()),
            stroke_width: Some(1.2),
        });
    }

    pub(super) fn diamond(&mut self, (x, y): (f64, f64), fill: &str, outline: &str) {
        let r = 6.5;
        let d = format!("M{} {}L{} {}L{} {}L{} {}Z", x - r, y, x, y - r, x + r, y, x, y + r);
        self.path(d, fill, outline, 1.4);
    }

    pub(super) fn cross(&mut self, (x, y): (f64, f64), color: &str) {
        let r = 3.0;
        self.line(&[(x - r, y - r), (x + r, y + r)], color, 1.2);
        self.line(&[(x - r, y + r), (x + r, y - r)], color, 1.2);
    }

    fn add(&mut self, primitive: Primitive) {
        self.scene.add(primitive);
    }

    /// The SVG text, with a view box so that a page may scale it.
    pub(super) fn svg(self) -> String {
        let (width, height) = (self.scene.width, self.scene.height);
        let svg = with_own_clips(SvgBackend::new().render_scene(&self.scene));
        let view = format!("<svg viewBox=\"0 0 {width} {height}\" ");
        svg.replacen("<svg ", &view, 1)
    }
}

/// kuva numbers its clip paths over the whole life of the program; a figure numbers its own, to be the same each time.
fn with_own_clips(mut svg: String) -> String {
    const THEIRS: &str = "id=\"kuva-clip-";
    for number in 1.. {
        let Some(start) = svg.find(THEIRS) else {
            break;
        };
        let their: String = svg[start + THEIRS.len()..].chars().take_while(char::is_ascii_digit).collect();
        if their.is_empty() {
            break;
        }
        svg = svg.replace(&format!("id=\"kuva-clip-{their}\""), &format!("id=\"clip-{number}\""));
        svg = svg.replace(&format!("url(#kuva-clip-{their})"), &format!("url(#clip-{number})"));
    }
    svg
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

fn tick_format(scale: &Scale) -> TickFormat {
    let largest = scale.max.abs().max(scale.min.abs());
    match scale.decimals() {
        decimals @ 0..=5 if largest < 1e6 => TickFormat::Custom(Arc::new(move |value| number_text(value, decimals))),
        _ => TickFormat::Sci,
    }
}

/// A number with its decimals and a proper minus sign.
pub(super) fn number_text(value: f64, decimals: usize) -> String {
    format!("{:.decimals$}", value + 0.0).replace('-', "\u{2212}")
}
