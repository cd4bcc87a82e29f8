//! Axes: a label, a range, and the round numbers along it.

/// One axis of a figure.
#[derive(Clone, Debug)]
pub struct Axis {
    label: String,
    range: Option<(f64, f64)>,
    step: Option<f64>,
    spacing: Spacing,
    colors: ColorScale,
}

/// How far apart the same ratio or the same difference is along an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Spacing {
    /// The same difference everywhere.
    Even,
    /// The same ratio everywhere.
    Decades,
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
}

impl Axis {
    /// An axis that shows all of the data; `unit` is "1" or empty for a pure number.
    pub fn new(quantity: &str, unit: &str) -> Self {
        let label = if ["", "1"].contains(&unit) { quantity.to_owned() } else { format!("{quantity} ({unit})") };
        Self { label, range: None, step: None, spacing: Spacing::Even, colors: ColorScale::Linear }
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

    /// The same axis with another scale of colors, if it is one of colors.
    pub fn with_colors(self, colors: ColorScale) -> Self {
        Self { colors, ..self }
    }

    pub(super) fn colors(&self) -> ColorScale {
        self.colors
    }

    pub(super) fn has_range(&self) -> bool {
        self.range.is_some()
    }

    pub(super) fn label(&self) -> &str {
        &self.label
    }

    /// The ticks for these values, about `ticks` of them.
    pub(super) fn scale(&self, values: impl Iterator<Item = f64>, ticks: usize) -> Scale {
        match (self.range, self.step) {
            (Some((min, max)), _) if self.spacing == Spacing::Decades => Scale::in_decades(min, max, ticks),
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
        Scale { min, max: steps(scale.max, touches_max) * scale.step, ..scale }
    }
}

/// An axis with its ticks: the multiples of `step` from `min` to `max`, or one power of ten in `step`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Scale {
    pub(super) min: f64,
    pub(super) max: f64,
    pub(super) step: f64,
    spacing: Spacing,
}

impl Scale {
    /// The multiples of a step between two values.
    pub(super) fn even(min: f64, max: f64, step: f64) -> Self {
        Self { min, max, step, spacing: Spacing::Even }
    }

    /// The same ticks between other ends.
    pub(super) fn between(self, min: f64, max: f64) -> Self {
        Self { min, max, ..self }
    }

    /// The powers of ten between two positive values, at most about this many.
    fn in_decades(min: f64, max: f64, ticks: usize) -> Self {
        let decades = (max / min).log10().round();
        Self { min, max, step: (decades / ticks.max(1) as f64).ceil().max(1.0), spacing: Spacing::Decades }
    }

    /// 0 at the beginning of the axis, 1 at its end.
    pub(super) fn place(&self, value: f64) -> f64 {
        match self.spacing {
            Spacing::Even => (value - self.min) / (self.max - self.min),
            Spacing::Decades => (value / self.min).log10() / (self.max / self.min).log10(),
        }
    }

    /// From a tick below all finite values to a tick above, from zero when that is near.
    pub(super) fn around(values: impl Iterator<Item = f64>, ticks: usize) -> Self {
        let (mut min, mut max) = ends(values).unwrap_or((0.0, 1.0));
        if min >= 0.0 && min < 0.25 * max {
            min = 0.0;
        }
        if max - min <= 1e-9 * max.abs().max(min.abs()) {
            let half = if max == 0.0 { 1.0 } else { 0.1 * max.abs() };
            (min, max) = (min - half, max + half);
        }
        let step = round_step(max - min, ticks);
        Self::even((min / step).floor() * step, (max / step).ceil() * step, step)
    }

    /// The ticks, without the rounding that adding up steps would bring.
    pub(super) fn ticks(&self) -> Vec<f64> {
        match self.spacing {
            Spacing::Even => multiples(self.min, self.max, self.step),
            Spacing::Decades => {
                let exponents = multiples(self.min.log10().round(), self.max.log10().round(), self.step);
                exponents.into_iter().map(|exponent| 10_f64.powf(exponent)).collect()
            }
        }
    }

    /// Decimals that tell neighboring ticks apart.
    pub(super) fn decimals(&self) -> usize {
        (-self.step.log10() - 1e-9).ceil().max(0.0) as usize
    }

    /// What stands at a tick: as many decimals as all ticks need, and a power of ten where that would be long.
    pub(super) fn text(&self, tick: f64) -> String {
        if self.spacing == Spacing::Decades {
            return if (1e-4..1e6).contains(&tick) {
                tick.to_string()
            } else {
                format!("{tick:e}").replace('-', MINUS)
            };
        }
        let largest = self.max.abs().max(self.min.abs());
        match self.decimals() {
            decimals @ 0..=5 if largest < 1e6 => number_text(tick, decimals),
            _ => format!("{:e}", rounded_to(tick, self.step)).replace('-', MINUS),
        }
    }
}

/// The least and the largest finite value.
fn ends(values: impl IntoIterator<Item = f64>) -> Option<(f64, f64)> {
    let finite = values.into_iter().filter(|value| value.is_finite());
    finite.fold(None, |ends, value| match ends {
        None => Some((value, value)),
        Some((min, max)) => Some((value.min(min), value.max(max))),
    })
}

/// The multiples of a step in a range.
fn multiples(min: f64, max: f64, step: f64) -> Vec<f64> {
    let slack = 1e-6;
    let first = (min / step - slack).ceil() as i64;
    let last = (max / step + slack).floor() as i64;
    (first..=last).map(|tick| tick as f64 * step).collect()
}

const MINUS: &str = "\u{2212}";

/// A number with its decimals and a proper minus sign.
pub(super) fn number_text(value: f64, decimals: usize) -> String {
    format!("{:.decimals$}", value + 0.0).replace('-', MINUS)
}

/// A multiple of a step without the last bits of the multiplication, which its shortest text would show.
fn rounded_to(tick: f64, step: f64) -> f64 {
    let digits = if tick.abs() > 0.0 { (tick.abs() / step).log10().floor().max(0.0) as usize + 1 } else { 0 };
    format!("{tick:.digits$e}").parse().unwrap_or(tick)
}

/// 1, 2 or 5 times a power of ten, so that a span has about the number of ticks asked for.
fn round_step(span: f64, ticks: usize) -> f64 {
    let rough = span / ticks.max(1) as f64;
    let power = 10_f64.powf(rough.log10().floor());
    let factor = match rough / power {
        share if share < 1.5 => 1.0,
        share if share < 3.5 => 2.0,
        share if share < 7.5 => 5.0,
        _ => 10.0,
    };
    factor * power
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scale_is_round_and_holds_the_values() {
        let scale = Scale::around([4.35, 6.85].into_iter(), 5);
        assert_eq!(scale, Scale::even(4.0, 7.0, 0.5));
        assert_eq!(scale.decimals(), 1);
        assert_eq!(scale.ticks().len(), 7);
    }

    #[test]
    fn scale_starts_at_zero_when_that_is_near() {
        assert!(Scale::around([0.001, 0.02].into_iter(), 5).min.abs() <= 0.0, "from zero");
        assert!(Scale::around([4.0, 5.0].into_iter(), 5).min > 3.0, "zero is far");
    }

    #[test]
    fn scale_survives_bad_values() {
        for values in [vec![], vec![f64::NAN], vec![3.0], vec![0.0], vec![f64::INFINITY, 2.0]] {
            let scale = Scale::around(values.iter().copied(), 5);
            assert!(scale.min < scale.max && scale.step > 0.0, "{values:?}: {scale:?}");
            assert!(scale.ticks().len() >= 2, "{values:?}: {scale:?}");
        }
    }

    #[test]
    fn lines_do_not_run_along_a_border() {
        let roomy = |values: [f64; 2]| Axis::new("speed", "m/s").roomy_scale(values.into_iter(), 5);
        assert_eq!(roomy([-10.0, 0.0]), Scale::even(-12.0, 2.0, 2.0));
        assert_eq!(roomy([0.0, 9.0]), Scale::even(0.0, 10.0, 2.0));
        assert_eq!(roomy([0.0, 0.245]), Scale::even(0.0, 6.0 * 0.05, 0.05));
        assert_eq!(roomy([4.25, 6.75]), Scale::even(4.0, 7.0, 0.5));
    }

    #[test]
    fn ticks_that_would_be_long_have_a_power_of_ten() {
        let texts = |scale: Scale| scale.ticks().into_iter().map(|tick| scale.text(tick)).collect::<Vec<_>>();
        assert_eq!(texts(Scale::even(0.0, 3e-7, 1e-7)), ["0e0", "1e\u{2212}7", "2e\u{2212}7", "3e\u{2212}7"]);
        assert_eq!(texts(Scale::even(1e6, 2e6, 5e5)), ["1e6", "1.5e6", "2e6"]);
        assert_eq!(texts(Scale::even(-0.5, 0.5, 0.5)), ["\u{2212}0.5", "0.0", "0.5"]);
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
    fn unit_one_is_not_shown() {
        assert_eq!(Axis::new("iteration", "1").label(), "iteration");
        assert_eq!(Axis::new("time", "s").label(), "time (s)");
    }
}
