//! Axes: a label and a range.

use std::fmt;

use super::scale::{Scale, Spacing, ends, round_step};

/// What stands along an axis.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Label {
    pub(super) quantity: String,
    /// None for a pure number.
    pub(super) unit: Option<String>,
}

/// "time (s)".
impl fmt::Display for Label {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.unit {
            Some(unit) => write!(formatter, "{} ({unit})", self.quantity),
            None => formatter.write_str(&self.quantity),
        }
    }
}

/// One axis of a figure.
#[derive(Clone, Debug)]
pub struct Axis {
    label: Label,
    range: Option<(f64, f64)>,
    step: Option<f64>,
    spacing: Spacing,
    colors: ColorScale,
    /// What stands at 0, 1, 2, ... instead of these numbers, where there is room.
    names: Vec<String>,
}

/// How the values along an axis become the colors of a [`Landscape`](crate::Landscape) or a
/// [`CellFigure`](crate::CellFigure); the bar of colors says which.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ColorScale {
    /// Bands of equal width. Above the range of the axis, or above what four fifths of the values stay below if the rest
    /// is far higher, all values have the color of the highest.
    #[default]
    Linear,
    /// Bands by the distance from the lowest value, with borders at 1, 2 and 5 times powers of ten: narrow near the
    /// lowest value, wide far from it.
    NearLowest,
    /// The same from the highest value down; the highest has the darkest color.
    NearHighest,
    /// Bands that hold equally many values.
    EqualShares,
    /// Bands of about the same ratio, with borders at powers of ten, and within them where they are few or near the lowest value, which has
    /// the darkest color. As `Linear` if a value is not positive or all are nearly the same.
    RatiosFromLowest,
    /// The same, with the darkest color for the highest value.
    RatiosFromHighest,
}

impl Axis {
    /// An axis that shows all of the data; `unit` is "1" or empty for a pure number.
    pub fn new(quantity: &str, unit: &str) -> Self {
        let unit = (!["", "1"].contains(&unit)).then(|| unit.to_owned());
        let label = Label { quantity: quantity.to_owned(), unit };
        Self { label, range: None, step: None, spacing: Spacing::Even, colors: ColorScale::Linear, names: Vec::new() }
    }

    /// The same axis from one value to another, whatever the data; what lies outside is cut off.
    pub fn with_range(mut self, from: f64, to: f64) -> Self {
        debug_assert!(from < to, "an axis from {from} to {to}");
        self.range = Some((from, to));
        self
    }

    /// The same axis with a range of round numbers around these values and some room, from zero when that is near.
    pub fn around(self, values: impl IntoIterator<Item = f64>) -> Self {
        let values: Vec<f64> = values.into_iter().collect();
        let scale = self.roomy_scale(values.into_iter(), 5);
        self.with_range(scale.min, scale.max)
    }

    /// The same axis from one value to another, and as far beyond as these values go.
    pub fn covering(self, from: f64, to: f64, values: impl IntoIterator<Item = f64>) -> Self {
        let (min, max) = ends(values.into_iter().chain([from, to])).unwrap_or((from, to));
        let room = |moved: bool| if moved { 0.02 * (max - min) } else { 0.0 };
        self.with_range(min - room(min < from), max + room(max > to))
    }

    /// The same axis from one power of ten to another around these values, if all of them are positive; else as
    /// [`Axis::around`].
    pub fn in_decades(self, values: impl IntoIterator<Item = f64>) -> Self {
        let values: Vec<f64> = values.into_iter().collect();
        let Some((min, max)) = ends(values.iter().copied()).filter(|(min, _)| *min > 0.0) else {
            return self.around(values);
        };
        let (low, high) = ((min.log10() + 1e-9).floor(), (max.log10() - 1e-9).ceil());
        let axis = self.with_range(10_f64.powf(low), 10_f64.powf(high.max(low + 1.0)));
        Self { spacing: Spacing::Decades, ..axis }
    }

    /// The same axis just around these values, the same ratio everywhere as far, if all of them are positive; else as
    /// [`Axis::around`]. For values that span too little for [`Axis::in_decades`].
    pub fn in_ratios(self, values: impl IntoIterator<Item = f64>) -> Self {
        let values: Vec<f64> = values.into_iter().collect();
        let Some((min, max)) = ends(values.iter().copied()).filter(|(min, _)| *min > 0.0) else {
            return self.around(values);
        };
        Self { spacing: Spacing::Ratios, ..self.with_range(0.95 * min, 1.05 * max) }
    }

    /// The same axis around factors above 1, as far apart as their logarithms on an axis in decades; as [`Axis::in_decades`] if one
    /// of them is not above 1. For factors of which some are many powers of ten and others next to 1.
    pub fn in_factors(self, values: impl IntoIterator<Item = f64>) -> Self {
        let values: Vec<f64> = values.into_iter().collect();
        let Some((min, max)) = ends(values.iter().copied()).filter(|(min, _)| *min > 1.0) else {
            return self.in_decades(values);
        };
        let least = 1.0 + 10_f64.powf(((min - 1.0).log10() + 1e-6).floor());
        let most = max.powf(1.5).min(f64::MAX).max(1.1 * least);
        Self { spacing: Spacing::Factors, ..self.with_range(least, most) }
    }

    /// The same axis for counting between two numbers: whole numbers, half a step of room on either side.
    pub fn counting(self, first: usize, last: usize) -> Self {
        let step = (last.saturating_sub(first) / 10 + 1) as f64;
        Self { step: Some(step), ..self.with_range(first as f64 - 0.5, last.max(first) as f64 + 0.5) }
    }

    /// The same axis with ticks this far apart, if it has a range.
    pub fn with_step(self, step: f64) -> Self {
        Self { step: Some(step), ..self }
    }

    /// The same axis for counting from 1: whole numbers, half a step of room on either side.
    pub fn counting_to(self, count: usize) -> Self {
        let step = if count <= 20 { 1.0 } else { 5.0 };
        Self { step: Some(step), ..self.with_range(0.5, count.max(1) as f64 + 0.5) }
    }

    /// The same axis of things that are no numbers: their names stand at 0, 1, 2, ..., or, where a [`Chart`](crate::Chart) has no
    /// room for them, beside these numbers in the label.
    pub fn with_names(self, names: &[String]) -> Self {
        Self { step: Some(1.0), names: names.to_vec(), ..self }
    }

    /// The same axis with another scale of colors, if it is one of colors.
    pub fn with_colors(self, colors: ColorScale) -> Self {
        Self { colors, ..self }
    }

    pub(super) fn colors(&self) -> ColorScale {
        self.colors
    }

    pub(super) fn names(&self) -> &[String] {
        &self.names
    }

    /// The label, with the numbers of what has names.
    pub(super) fn numbered_label(&self) -> String {
        let numbered: Vec<String> = (0..).zip(&self.names).map(|(number, name)| format!("{number} {name}")).collect();
        match numbered.is_empty() {
            true => self.label.to_string(),
            false => format!("{}: {}", self.label, numbered.join(", ")),
        }
    }

    pub(super) fn has_range(&self) -> bool {
        self.range.is_some()
    }

    pub(super) fn label(&self) -> &Label {
        &self.label
    }

    /// The ticks for these values, about `ticks` of them.
    pub(super) fn scale(&self, values: impl Iterator<Item = f64>, ticks: usize) -> Scale {
        match (self.range, self.step) {
            (Some((min, max)), _) if self.spacing == Spacing::Decades => Scale::in_decades(min, max, ticks),
            (Some((min, max)), _) if self.spacing == Spacing::Ratios => Scale::in_ratios(min, max),
            (Some((min, max)), _) if self.spacing == Spacing::Factors => Scale::in_factors(min, max),
            (Some((min, max)), Some(step)) => Scale::even(min, max, step),
            (Some((min, max)), None) => Scale::even(min, max, round_step(max - min, ticks)),
            (None, _) => Scale::around(values, ticks),
        }
    }

    /// The same, with room between the values and the ends, so that no line runs along a border; zero needs no room.
    pub(super) fn roomy_scale(&self, values: impl Iterator<Item = f64> + Clone, ticks: usize) -> Scale {
        let scale = self.scale(values.clone(), ticks);
        if self.has_range() {
            return scale;
        }
        let near = |value: f64, end: f64| (value - end).abs() < 0.04 * (scale.max - scale.min);
        let mut values = values.filter(|value| value.is_finite());
        let (touches_min, touches_max) = values
            .clone()
            .fold((false, false), |(min, max), value| (min || near(value, scale.min), max || near(value, scale.max)));
        let all_above_zero = values.all(|value| value >= 0.0);
        let below = touches_min && !(all_above_zero && scale.min <= 0.0);
        // Counted in steps, so that the ends are still ticks to the last bit.
        let steps = |end: f64, more: bool| (end / scale.step).round() + f64::from(u8::from(more));
        let min = -steps(-scale.min, below) * scale.step;
        scale.between(min, steps(scale.max, touches_max) * scale.step)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_do_not_run_along_a_border() {
        let roomy = |values: [f64; 2]| Axis::new("speed", "m/s").roomy_scale(values.into_iter(), 5);
        assert_eq!(roomy([-10.0, 0.0]), Scale::even(-12.0, 2.0, 2.0));
        assert_eq!(roomy([0.0, 9.0]), Scale::even(0.0, 10.0, 2.0));
        assert_eq!(roomy([0.0, 0.245]), Scale::even(0.0, 6.0 * 0.05, 0.05));
        assert_eq!(roomy([4.25, 6.75]), Scale::even(4.0, 7.0, 0.5));
    }

    #[test]
    fn counting_has_whole_numbers() {
        let scale = Axis::new("iteration", "1").counting_to(3).scale(std::iter::empty(), 8);
        assert_eq!(scale.ticks(), [1.0, 2.0, 3.0]);
        assert_eq!(scale.decimals(), 0);
    }

    #[test]
    fn decades_have_powers_of_ten() {
        let scale = Axis::new("share", "%").in_decades([5.3, 100.0]).scale(std::iter::empty(), 6);
        assert_eq!((scale.ticks(), scale.text(10.0)), (vec![1.0, 10.0, 100.0], "10".to_owned()));
        assert!((scale.place(10.0) - 0.5).abs() < 1e-12, "the same ratio is as far");
        let linear = Axis::new("share", "%").in_decades([0.0, 1.0]).scale(std::iter::empty(), 6);
        assert!((linear.place(0.5 * linear.max) - 0.5).abs() < 1e-12, "zero has no power of ten");
        let many = Axis::new("share", "%").in_decades([1e-30, 1e30]).scale(std::iter::empty(), 6);
        assert!(many.ticks().len() <= 8, "{:?}", many.ticks());
    }

    #[test]
    fn ratios_have_ticks_within_a_power_of_ten() {
        let scale = Axis::new("cost", "s").in_ratios([1.74, 11.0]).scale(std::iter::empty(), 4);
        assert_eq!(scale.ticks(), [2.0, 3.0, 5.0, 10.0]);
        assert!((scale.place(4.0) - scale.place(2.0) - scale.place(10.0) + scale.place(5.0)).abs() < 1e-12);
        let small = Axis::new("cost", "s").in_ratios([0.29, 0.8]).scale(std::iter::empty(), 4);
        let texts: Vec<String> = small.ticks().into_iter().map(|tick| small.text(tick)).collect();
        assert_eq!(texts, ["0.3", "0.5"]);
        let narrow = Axis::new("cost", "s").in_ratios([0.9, 1.2]).scale(std::iter::empty(), 4);
        let texts: Vec<String> = narrow.ticks().into_iter().map(|tick| narrow.text(tick)).collect();
        assert_eq!(texts, ["0.9", "1", "1.1", "1.2"]);
    }

    #[test]
    fn factors_begin_a_round_one_below_the_least() {
        let scale = |values: [f64; 2]| Axis::new("bound", "1").in_factors(values).scale(std::iter::empty(), 5);
        let (small, large) = (scale([1.05, 1000.0]), scale([1.001, 1e300]));
        assert!((small.min - 1.01).abs() < 1e-12 && small.max > 1000.0, "{small:?}");
        assert!((large.min - 1.001).abs() < 1e-12 && large.max.is_finite(), "{large:?}");
        assert_eq!(scale([1.0, 1000.0]), Scale::in_decades(1.0, 1000.0, 5), "1 has no place among them");
    }

    #[test]
    fn unit_one_is_not_shown() {
        assert_eq!(Axis::new("iteration", "1").label().to_string(), "iteration");
        assert_eq!(Axis::new("time", "s").label().to_string(), "time (s)");
    }
}
