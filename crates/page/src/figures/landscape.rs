//! A quantity over two parameters, with the paths that a search took across it.

use super::axis::Axis;
use super::canvas::{Canvas, INK, PAPER, Pen, SHORT_DASHES, TEXT_SIZE, TITLE_PX, color, text_width_px};
use super::color_scale::{Bands, draw_color_bar};
use super::contours::{Grid, Segment};
use super::frame::{BELOW_PX, Frame, FrameText, LEFT_PX};
use super::labels::{Room, Taken};
use super::legend::{LegendEntry, Mark, draw_legend, legend_height_px};
use super::panels::{RIGHT_PX, Sheet};
use super::points::Points;
use super::scale::Scale;

/// Values on a rectangular grid and what is drawn over them.
#[derive(Clone, Debug)]
pub struct Landscape {
    /// Above the figure, or above its panel.
    pub title: String,
    /// Along the columns of the grid.
    pub x_axis: Axis,
    /// Along the rows of the grid.
    pub y_axis: Axis,
    /// Of the values. Its [`ColorScale`](crate::ColorScale) says how values become colors.
    pub z_axis: Axis,
    /// Increasing.
    pub x: Vec<f64>,
    /// Increasing.
    pub y: Vec<f64>,
    /// `z[row][column]` belongs to `y[row]` and `x[column]`; NaN where there is no value.
    pub z: Vec<Vec<f64>>,
    /// What a missing value means.
    pub missing_label: String,
    /// Places to show, such as grid points with a value to be wary of.
    pub points: Vec<Points>,
    /// Values of x to draw a line at.
    pub verticals: Vec<f64>,
    /// What these lines mean.
    pub verticals_label: String,
    /// At most three, the most important one first.
    pub paths: Vec<Path>,
    /// Where the landscape itself is lowest.
    pub minimum: Option<(f64, f64)>,
    /// What the mark there means.
    pub minimum_label: String,
}

/// Points in the order in which a search visited them; they are numbered from 1.
#[derive(Clone, Debug)]
pub struct Path {
    /// What took this way.
    pub label: String,
    /// In the units of the axes.
    pub points: Vec<(f64, f64)>,
}

const HEIGHT_PX: f64 = 420.0;
const PATH_FILLS: [&str; 3] = ["#56b4e9", "#e69f00", "#cc79a7"];
const PATH_RADII_PX: [f64; 3] = [3.2, 5.8, 8.4];
/// Points closer than this share a label.
const NEAR_PX: f64 = 9.0;

/// Draws a landscape.
pub fn landscape_figure(landscape: &Landscape) -> String {
    let legend = legend(landscape);
    let bottom = TITLE_PX + HEIGHT_PX;
    let mut canvas = Canvas::new(&landscape.title, bottom + BELOW_PX + legend_height_px(&legend, LEFT_PX));
    let frame = Frame {
        left: LEFT_PX,
        top: TITLE_PX,
        right: RIGHT_PX,
        bottom,
        x: grid_scale(&landscape.x_axis, &landscape.x),
        y: grid_scale(&landscape.y_axis, &landscape.y),
    };
    let text = FrameText {
        x_label: Some(landscape.x_axis.label()),
        y_label: Some(landscape.y_axis.label()),
        grid: super::frame::Grid::Hidden,
    };
    frame.draw(&mut canvas, &text);

    let bands = Bands::of(&landscape.z_axis, landscape.z.iter().flatten().copied());
    let mut room = room(landscape, &frame);
    let lines = draw_field(&mut canvas, landscape, &frame, &bands);
    // What is drawn later is smaller, so that of points on one spot all are seen.
    if let Some(minimum) = landscape.minimum {
        canvas.diamond(frame.px(minimum), color(4), PAPER);
    }
    for ((path, fill), radius) in landscape.paths.iter().zip(PATH_FILLS).zip(PATH_RADII_PX).rev() {
        draw_path(&mut canvas, &frame, path, fill, radius);
    }
    for (path, fill) in landscape.paths.iter().zip(PATH_FILLS) {
        label_path(&mut canvas, &frame, path, fill, &mut room);
    }
    keep_paths_free(&mut room, landscape, &frame);
    label_iso_lines(&mut canvas, &lines, &mut room);
    draw_color_bar(&mut canvas, &bands, bottom);
    draw_legend(&mut canvas, &legend, LEFT_PX, bottom + BELOW_PX);
    canvas.svg()
}

/// Draws landscapes over the same axes side by side, with one scale of colors; each title stands above its panel.
pub fn landscape_panels_figure(title: &str, landscapes: &[Landscape]) -> String {
    let Some(first) = landscapes.first() else { return Canvas::new(title, TITLE_PX).svg() };
    let sheet = Sheet::of(landscapes.len());
    let bottom = sheet.bottom();
    let mut legend: Vec<LegendEntry> = Vec::new();
    for entry in landscapes.iter().flat_map(|landscape| marks(landscape, "")) {
        if legend.iter().all(|known| known.text != entry.text) {
            legend.push(entry);
        }
    }
    let mut canvas = Canvas::new(title, bottom + BELOW_PX + legend_height_px(&legend, LEFT_PX));
    let bands = Bands::of(&first.z_axis, landscapes.iter().flat_map(|one| one.z.iter().flatten().copied()));
    for (number, landscape) in landscapes.iter().enumerate() {
        let (x, y) = (&landscape.x_axis, &landscape.y_axis);
        let scales = [grid_scale(x, &landscape.x), grid_scale(y, &landscape.y)];
        let frame = sheet.panel(&mut canvas, number, &landscape.title, [x, y], scales);
        let mut room = room(landscape, &frame);
        let lines = draw_field(&mut canvas, landscape, &frame, &bands);
        if let Some(minimum) = landscape.minimum {
            canvas.diamond(frame.px(minimum), color(4), PAPER);
        }
        label_iso_lines(&mut canvas, &lines, &mut room);
    }
    draw_color_bar(&mut canvas, &bands, bottom);
    draw_legend(&mut canvas, &legend, LEFT_PX, bottom + BELOW_PX);
    canvas.svg()
}

/// Colors, lines and marks of the field itself, under its frame; the pieces of each iso-line with its text.
fn draw_field(canvas: &mut Canvas, landscape: &Landscape, frame: &Frame, bands: &Bands) -> Vec<(String, Vec<Segment>)> {
    draw_bands(canvas, landscape, frame, bands);
    let lines = draw_iso_lines(canvas, landscape, frame, bands);
    draw_missing(canvas, landscape, frame);
    draw_verticals(canvas, landscape, frame);
    for points in &landscape.points {
        points.draw(canvas, frame);
    }
    frame.outline(canvas);
    lines
}

/// A grid fills its frame.
fn grid_scale(axis: &Axis, places: &[f64]) -> Scale {
    let scale = axis.scale(places.iter().copied(), 6);
    match places {
        [first, .., last] if !axis.has_range() && first < last => scale.between(*first, *last),
        _ => scale,
    }
}

/// The grid in pixels, its values as the bands rank them.
fn with_pixel_grid<R>(landscape: &Landscape, frame: &Frame, bands: &Bands, draw: impl FnOnce(Grid) -> R) -> R {
    let x: Vec<f64> = landscape.x.iter().map(|x| frame.x_px(*x)).collect();
    let y: Vec<f64> = landscape.y.iter().map(|y| frame.y_px(*y)).collect();
    let z: Vec<Vec<f64>> = landscape.z.iter().map(|row| row.iter().map(|z| bands.rank(*z)).collect()).collect();
    draw(Grid { x: &x, y: &y, z: &z })
}

/// Each band is drawn over the one below it, so that no gap shows between them.
fn draw_bands(canvas: &mut Canvas, landscape: &Landscape, frame: &Frame, bands: &Bands) {
    with_pixel_grid(landscape, frame, bands, |grid| {
        for band in 0..bands.count() {
            let from = if band == 0 { f64::MIN } else { bands.borders()[band] };
            canvas.area(&grid.at_least(from), &bands.color(band));
        }
    });
}

/// Draws the lines and returns the pieces of each with its text.
fn draw_iso_lines(
    canvas: &mut Canvas,
    landscape: &Landscape,
    frame: &Frame,
    bands: &Bands,
) -> Vec<(String, Vec<Segment>)> {
    with_pixel_grid(landscape, frame, bands, |grid| {
        let mut lines = Vec::new();
        for (border, &level) in bands.borders().iter().enumerate().skip(1) {
            let segments = grid.iso_line(level);
            let d: String =
                segments.iter().map(|(a, b)| format!("M{:.1} {:.1}L{:.1} {:.1}", a.0, a.1, b.0, b.1)).collect();
            if !d.is_empty() {
                canvas.path(&d, "none", INK, 0.6);
            }
            lines.push((bands.text(border).to_owned(), segments));
        }
        lines
    })
}

/// Room around the number of an iso-line, so that numbers do not crowd.
const AROUND_NUMBER_PX: f64 = 14.0;

/// Writes each line's value where there is most room, if there is any.
fn label_iso_lines(canvas: &mut Canvas, lines: &[(String, Vec<Segment>)], room: &mut Room) {
    for (text, segments) in lines {
        let (width, height) = (text_width_px(text, TEXT_SIZE) + 4.0, 14.0);
        let middle = |segment: &Segment| (0.5 * (segment.0.0 + segment.1.0), 0.5 * (segment.0.1 + segment.1.1));
        // From the middle of the list outward: the ends of a line are often at the edge.
        let half = segments.len() / 2;
        let order = segments[half..].iter().chain(segments[..half].iter().rev());
        if let Some(at) = order
            .map(middle)
            .find(|at| room.take_if_free(Taken::around(*at, width + AROUND_NUMBER_PX, height + AROUND_NUMBER_PX)))
        {
            canvas.rect((at.0 - 0.5 * width, at.1 - 0.5 * height), (width, height), "#f4f4f4", "none");
            canvas.text(text, at);
        }
    }
}

fn missing(landscape: &Landscape) -> Vec<(f64, f64)> {
    let rows = landscape.y.iter().zip(&landscape.z);
    rows.flat_map(|(y, row)| landscape.x.iter().zip(row).filter(|(_, z)| !z.is_finite()).map(|(x, _)| (*x, *y)))
        .collect()
}

fn draw_missing(canvas: &mut Canvas, landscape: &Landscape, frame: &Frame) {
    for point in missing(landscape) {
        canvas.cross(frame.px(point), "#888888");
    }
}

fn draw_verticals(canvas: &mut Canvas, landscape: &Landscape, frame: &Frame) {
    for x in landscape.verticals.iter().filter(|x| (frame.x.min..=frame.x.max).contains(x)) {
        let ends = [(frame.x_px(*x), frame.top), (frame.x_px(*x), frame.bottom)];
        canvas.line(&ends, Pen::dashed(PAPER, 1.6, SHORT_DASHES));
    }
}

/// What labels must not cover: the points of all paths and the minimum.
fn room(landscape: &Landscape, frame: &Frame) -> Room {
    let points = landscape.paths.iter().flat_map(|path| &path.points).chain(&landscape.minimum);
    Room {
        outer: Taken { left: frame.left, top: frame.top, right: frame.right, bottom: frame.bottom },
        taken: points.map(|point| Taken::around(frame.px(*point), 10.0, 10.0)).collect(),
    }
}

/// Numbers of iso-lines stay off the paths.
fn keep_paths_free(room: &mut Room, landscape: &Landscape, frame: &Frame) {
    for leg in landscape.paths.iter().flat_map(|path| path.points.windows(2)) {
        let (from, to) = (frame.px(leg[0]), frame.px(leg[1]));
        let pieces = ((to.0 - from.0).hypot(to.1 - from.1) / 6.0).ceil().max(1.0);
        for piece in 0..=pieces as usize {
            let share = piece as f64 / pieces;
            let at = (from.0 + share * (to.0 - from.0), from.1 + share * (to.1 - from.1));
            room.taken.push(Taken::around(at, 6.0, 6.0));
        }
    }
}

fn draw_path(canvas: &mut Canvas, frame: &Frame, path: &Path, fill: &str, radius: f64) {
    let points: Vec<(f64, f64)> = path.points.iter().map(|point| frame.px(*point)).collect();
    canvas.line(&points, Pen::solid("#000000", 3.4));
    canvas.line(&points, Pen::solid(fill, 1.8));
    for point in points {
        canvas.dot(point, radius, fill, "#000000");
    }
}

/// Numbers the points; neighbors that lie on one spot share a label.
fn label_path(canvas: &mut Canvas, frame: &Frame, path: &Path, fill: &str, room: &mut Room) {
    let points: Vec<(f64, f64)> = path.points.iter().map(|point| frame.px(*point)).collect();
    let mut first = 0;
    while first < points.len() {
        let near = |point: &(f64, f64)| (point.0 - points[first].0).hypot(point.1 - points[first].1) < NEAR_PX;
        let count = points[first..].iter().take_while(|point| near(point)).count();
        let text = if count == 1 { format!("{}", first + 1) } else { format!("{}–{}", first + 1, first + count) };
        let (width, height) = (text_width_px(&text, TEXT_SIZE) + 8.0, 16.0);
        let at = room.place_near(points[first], width, height);
        canvas.rect((at.0 - 0.5 * width, at.1 - 0.5 * height), (width, height), fill, "#000000");
        canvas.text(&text, at);
        first += count;
    }
}

fn legend(landscape: &Landscape) -> Vec<LegendEntry> {
    let paths = landscape.paths.iter().zip(PATH_FILLS).map(|(path, fill)| LegendEntry {
        mark: Mark::Dot,
        fill: fill.into(),
        outline: "#000000".into(),
        text: path.label.clone(),
    });
    let (missing, all) = (missing(landscape).len(), landscape.x.len() * landscape.y.len());
    paths.chain(marks(landscape, &format!(" ({missing} of {all})"))).collect()
}

/// What the marks of a field mean; `missing` is added to what a missing value means.
fn marks(landscape: &Landscape, missing: &str) -> Vec<LegendEntry> {
    let entry = |is_there: bool, mark: Mark, [fill, outline]: [&str; 2], text: String| {
        is_there.then(|| LegendEntry { mark, fill: fill.into(), outline: outline.into(), text })
    };
    let is_blank = !self::missing(landscape).is_empty();
    let blank = format!("blank: {}{missing}", landscape.missing_label);
    let [minimum, verticals] = [&landscape.minimum_label, &landscape.verticals_label].map(Clone::clone);
    let points = landscape.points.iter().filter(|points| !points.points.is_empty()).map(Points::entry);
    let before = [
        entry(landscape.minimum.is_some(), Mark::Diamond, [color(4), PAPER], minimum),
        entry(!landscape.verticals.is_empty(), Mark::Dashes, ["#888888", "none"], verticals),
    ];
    let after = entry(is_blank, Mark::Cross, ["#888888", "none"], blank);
    before.into_iter().flatten().chain(points).chain(after).collect()
}
