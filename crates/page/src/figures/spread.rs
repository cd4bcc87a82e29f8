//! How a quantity spreads over repetitions, iteration by iteration.

use super::axis::Axis;
use super::canvas::{Canvas, INK, PAPER, Pen, SHORT_DASHES, TITLE_PX, WIDTH_PX, color};
use super::frame::{BELOW_PX, Frame, FrameText, Grid, LEFT_PX};
use super::legend::{LegendEntry, Mark, draw_legend, legend_height_px};

/// One quantity over the iterations, in groups of repetitions.
#[derive(Clone, Debug)]
pub struct SpreadFigure {
    /// Above the figure.
    pub title: String,
    /// Of the quantity.
    pub y_axis: Axis,
    /// Side by side at each iteration.
    pub groups: Vec<Group>,
    /// Values to compare with.
    pub reference: Option<Reference>,
}

/// Repetitions under the same conditions.
#[derive(Clone, Debug)]
pub struct Group {
    /// What they have in common.
    pub label: String,
    /// `values[iteration]` are those of the repetitions that got so far; a failed one is NaN and is left out.
    pub values: Vec<Vec<f64>>,
}

/// Values to compare with, the first belongs to iteration 1.
#[derive(Clone, Debug)]
pub struct Reference {
    /// Where they come from.
    pub label: String,
    /// By iteration.
    pub values: Vec<f64>,
}

/// Five numbers that tell how values spread.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Summary {
    /// How many finite values there are.
    pub count: usize,
    /// The least.
    pub minimum: f64,
    /// Above a quarter of the values.
    pub lower_quartile: f64,
    /// Above half of the values.
    pub median: f64,
    /// Above three quarters of the values.
    pub upper_quartile: f64,
    /// The largest.
    pub maximum: f64,
}

impl Summary {
    /// The summary of the finite values, quartiles by linear interpolation; none when there is no such value.
    pub fn of(values: &[f64]) -> Option<Self> {
        let mut sorted: Vec<f64> = values.iter().copied().filter(|value| value.is_finite()).collect();
        sorted.sort_by(f64::total_cmp);
        Some(Self {
            count: sorted.len(),
            minimum: quantile_of_sorted(&sorted, 0.0)?,
            lower_quartile: quantile_of_sorted(&sorted, 0.25)?,
            median: quantile_of_sorted(&sorted, 0.5)?,
            upper_quartile: quantile_of_sorted(&sorted, 0.75)?,
            maximum: quantile_of_sorted(&sorted, 1.0)?,
        })
    }
}

/// The value that this share of the values, from 0 to 1, stays below, by linear interpolation between neighbors; none without
/// values.
pub fn quantile(values: &[f64], share: f64) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    quantile_of_sorted(&sorted, share)
}

fn quantile_of_sorted(sorted: &[f64], share: f64) -> Option<f64> {
    let place = share.clamp(0.0, 1.0) * sorted.len().checked_sub(1)? as f64;
    let (below, above) = (sorted[place.floor() as usize], sorted[place.ceil() as usize]);
    Some(below + (place - place.floor()) * (above - below))
}

const RIGHT_PX: f64 = WIDTH_PX - 24.0;
const HEIGHT_PX: f64 = 300.0;
/// The share of an iteration's width that its boxes take together.
const BOXES_SHARE: f64 = 0.5;
/// The share of its slot that a box takes: between two there is room for a mark of the reference.
const BOX_SHARE: f64 = 0.6;
const WIDEST_BOX_PX: f64 = 34.0;

/// Draws the spread: a box from quartile to quartile with the median, whiskers to the extremes.
pub fn spread_figure(figure: &SpreadFigure) -> String {
    let legend = legend(figure);
    let bottom = TITLE_PX + HEIGHT_PX;
    let mut canvas = Canvas::new(&figure.title, bottom + BELOW_PX + legend_height_px(&legend, LEFT_PX));
    let values = figure.groups.iter().flat_map(|group| group.values.iter().flatten());
    let values = values.chain(figure.reference.iter().flat_map(|reference| &reference.values));
    let axis = Axis::new("iteration", "1").counting_to(iterations(figure));
    let frame = Frame {
        left: LEFT_PX,
        top: TITLE_PX,
        right: RIGHT_PX,
        bottom,
        x: axis.scale(std::iter::empty(), 8),
        y: figure.y_axis.roomy_scale(values.copied(), 6),
    };
    let text = FrameText { x_label: Some(axis.label()), y_label: Some(figure.y_axis.label()), grid: Grid::Shown };
    frame.draw(&mut canvas, &text);

    let iteration_px = frame.x_px(2.0) - frame.x_px(1.0);
    let slot_px = BOXES_SHARE * iteration_px / figure.groups.len().max(1) as f64;
    for (number, group) in figure.groups.iter().enumerate() {
        let shift_px = (number as f64 - 0.5 * (figure.groups.len() as f64 - 1.0)) * slot_px;
        let width_px = BOX_SHARE * slot_px;
        draw_group(&mut canvas, &frame, group, Boxes { shift_px, width_px, color: color(number) });
    }
    if let Some(reference) = &figure.reference {
        let points = reference.values.iter().enumerate().filter(|(_, value)| value.is_finite());
        for (index, value) in points {
            canvas.diamond(frame.px(((index + 1) as f64, *value)), color(4), PAPER);
        }
    }
    draw_legend(&mut canvas, &legend, LEFT_PX, bottom + BELOW_PX);
    canvas.svg()
}

fn iterations(figure: &SpreadFigure) -> usize {
    let lengths = figure.groups.iter().map(|group| group.values.len());
    lengths.chain(figure.reference.iter().map(|reference| reference.values.len())).max().unwrap_or(1)
}

/// How the boxes of one group look.
#[derive(Clone, Copy)]
struct Boxes {
    shift_px: f64,
    width_px: f64,
    color: &'static str,
}

fn draw_group(canvas: &mut Canvas, frame: &Frame, group: &Group, boxes: Boxes) {
    let width = boxes.width_px.min(WIDEST_BOX_PX);
    let summaries: Vec<(f64, Summary)> = group
        .values
        .iter()
        .enumerate()
        .filter_map(|(index, values)| Some((frame.x_px((index + 1) as f64) + boxes.shift_px, Summary::of(values)?)))
        .collect();
    let medians: Vec<(f64, f64)> = summaries.iter().map(|(x, summary)| (*x, frame.y_px(summary.median))).collect();
    canvas.line(&medians, Pen::dashed(boxes.color, 1.0, SHORT_DASHES));
    for (x, summary) in summaries {
        let y = |value: f64| frame.y_px(value);
        let (left, right) = (x - 0.5 * width, x + 0.5 * width);
        canvas.line(&[(x, y(summary.minimum)), (x, y(summary.maximum))], Pen::solid(INK, 1.0));
        for end in [summary.minimum, summary.maximum] {
            canvas.line(&[(x - 0.25 * width, y(end)), (x + 0.25 * width, y(end))], Pen::solid(INK, 1.0));
        }
        let (top, bottom) = (y(summary.upper_quartile), y(summary.lower_quartile));
        canvas.rect((left, top), (width, bottom - top), boxes.color, INK);
        canvas.line(&[(left, y(summary.median)), (right, y(summary.median))], Pen::solid(PAPER, 4.0));
        canvas.line(&[(left, y(summary.median)), (right, y(summary.median))], Pen::solid(INK, 2.0));
    }
}

fn legend(figure: &SpreadFigure) -> Vec<LegendEntry> {
    let repetitions = figure.groups.iter().flat_map(|group| &group.values).map(Vec::len).max().unwrap_or(0);
    let mut entries: Vec<LegendEntry> = figure
        .groups
        .iter()
        .enumerate()
        .map(|(number, group)| LegendEntry {
            mark: Mark::Box,
            fill: color(number).into(),
            outline: INK.into(),
            text: group.label.clone(),
        })
        .collect();
    entries.push(LegendEntry {
        mark: Mark::Box,
        fill: PAPER.into(),
        outline: INK.into(),
        text: format!("box: quartiles and median of {repetitions}, whiskers: extremes"),
    });
    if let Some(reference) = &figure.reference {
        entries.push(LegendEntry {
            mark: Mark::Diamond,
            fill: color(4).into(),
            outline: PAPER.into(),
            text: reference.label.clone(),
        });
    }
    entries
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn summary_of_five_values_is_these_values() {
        let summary = Summary::of(&[5.0, 1.0, f64::NAN, 3.0, 2.0, 4.0]).expect("five values");
        let expected =
            Summary { count: 5, minimum: 1.0, lower_quartile: 2.0, median: 3.0, upper_quartile: 4.0, maximum: 5.0 };
        assert_eq!(summary, expected);
        assert!((Summary::of(&[1.0, 2.0]).expect("two values").median - 1.5).abs() < 1e-15, "between");
        assert_eq!(Summary::of(&[f64::NAN]), None);
        assert_eq!(Summary::of(&[]), None);
    }

    #[test]
    fn quantiles_are_those_of_numpy() {
        // numpy.quantile([3, 1, 2, 10], [0.5, 0.9])
        assert_eq!(quantile(&[3.0, 1.0, 2.0, 10.0], 0.5), Some(2.5));
        assert!((quantile(&[3.0, 1.0, 2.0, 10.0], 0.9).unwrap_or(f64::NAN) - 7.9).abs() < 1e-12);
        assert_eq!(quantile(&[], 0.5), None);
    }
}
