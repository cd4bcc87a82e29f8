//! Round numbers along an axis.

/// How far apart the same ratio or the same difference is along an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Spacing {
    /// The same difference everywhere.
    Even,
    /// The same ratio everywhere, ticks at powers of ten.
    Decades,
    /// The same ratio everywhere, ticks within powers of ten as well.
    Ratios,
    /// Of factors above 1: the same ratio of their logarithms everywhere.
    Factors,
}

/// Ticks of an axis of ratios or factors that spans too little for round ones, about.
const EVEN_TICKS: usize = 4;

/// Ticks of an axis of factors are at least this share of it apart.
const FACTORS_APART: f64 = 0.1;
/// Digits behind the point of the least factor that has a tick.
const FACTOR_DECIMALS: usize = 6;

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

    /// The same ends with ticks this far apart.
    pub(super) fn with_step(self, step: f64) -> Self {
        Self { step, ..self }
    }

    /// The powers of ten between two positive values, at most about this many.
    pub(super) fn in_decades(min: f64, max: f64, ticks: usize) -> Self {
        let decades = (max / min).log10().round();
        Self { min, max, step: (decades / ticks.max(1) as f64).ceil().max(1.0), spacing: Spacing::Decades }
    }

    /// 1, 2, 3 and 5 times powers of ten between two positive values.
    pub(super) fn in_ratios(min: f64, max: f64) -> Self {
        Self { min, max, step: 1.0, spacing: Spacing::Ratios }
    }

    /// Such as 1.01, 1.1, 2, 10 and 1000 between two factors above 1.
    pub(super) fn in_factors(min: f64, max: f64) -> Self {
        Self { min, max, step: 1.0, spacing: Spacing::Factors }
    }

    /// 0 at the beginning of the axis, 1 at its end.
    pub(super) fn place(&self, value: f64) -> f64 {
        match self.spacing {
            Spacing::Even => (value - self.min) / (self.max - self.min),
            Spacing::Decades | Spacing::Ratios => (value / self.min).log10() / (self.max / self.min).log10(),
            Spacing::Factors => {
                let [value, min, max] = [value, self.min, self.max].map(|one| one.ln().max(f64::MIN_POSITIVE).ln());
                (value - min) / (max - min)
            }
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
            Spacing::Ratios => {
                let exponents = self.min.log10().floor() as i32..=self.max.log10().floor() as i32;
                let powers = exponents.map(|exponent| 10_f64.powi(exponent));
                let ticks = powers.flat_map(|power| [1.0, 2.0, 3.0, 5.0].map(|times| times * power));
                let ticks: Vec<f64> = ticks.filter(|tick| (self.min..=self.max).contains(tick)).collect();
                // Between neighbors of those even steps are as good.
                let step = round_step(self.max - self.min, EVEN_TICKS);
                if ticks.len() > 1 { ticks } else { multiples(self.min, self.max, step) }
            }
            Spacing::Factors => self.factors(),
        }
    }

    /// Factors that are far enough apart, the roundest first.
    fn factors(&self) -> Vec<f64> {
        let small = |times: f64| (1..=FACTOR_DECIMALS as i32).rev().map(move |k| 1.0 + times * 10_f64.powi(-k));
        let powers = (1..=f64::MAX_10_EXP).map(|k| 10_f64.powi(k));
        let round: Vec<f64> = small(1.0).chain([2.0]).chain(powers).collect();
        let between: Vec<f64> = small(2.0).chain(small(5.0)).chain([5.0]).collect();
        let mut ticks: Vec<f64> = Vec::new();
        let mut add = |factors: &[f64]| {
            for &factor in factors.iter().filter(|factor| (self.min..=self.max).contains(*factor)) {
                let is_apart = |tick: &f64| (self.place(*tick) - self.place(factor)).abs() >= FACTORS_APART;
                if ticks.iter().all(is_apart) {
                    ticks.push(factor);
                }
            }
            ticks.len()
        };
        if add(&round) < EVEN_TICKS {
            add(&between);
        }
        ticks.sort_by(f64::total_cmp);
        ticks
    }

    /// Decimals that tell neighboring ticks apart.
    pub(super) fn decimals(&self) -> usize {
        (-self.step.log10() - 1e-9).ceil().max(0.0) as usize
    }

    /// What stands at a tick: as many decimals as all ticks need, and a power of ten where that would be long; the distance to
    /// [`Self::above`] where even that would be.
    pub(super) fn text(&self, tick: f64) -> String {
        match self.offset() {
            Some(offset) => Self::even(self.min - offset, self.max - offset, self.step).whole_text(tick - offset),
            None => self.whole_text(tick),
        }
    }

    /// What follows the label of the axis where its ticks are counted from another number than zero: " above 1000000".
    pub(super) fn above(&self) -> String {
        let Some(offset) = self.offset() else { return String::new() };
        let (plain, power) = (offset.to_string(), format!("{offset:e}"));
        let shown = if plain.len() > LONGEST_OFFSET && power.len() < plain.len() { power } else { plain };
        format!(" above {}", shown.replace('-', MINUS))
    }

    /// A round number below all ticks, where these are so close together that their texts would be long without it.
    fn offset(&self) -> Option<f64> {
        let is_long = |tick: &f64| self.whole_text(*tick).chars().count() > LONGEST_TEXT;
        if self.spacing != Spacing::Even || !self.ticks().iter().any(is_long) {
            return None;
        }
        let unit = 10_f64.powf(((self.max - self.min).log10() - 1e-9).ceil());
        let offset = rounded_to((self.min / unit).floor() * unit, unit);
        (offset != 0.0 && offset.is_finite()).then_some(offset)
    }

    fn whole_text(&self, tick: f64) -> String {
        if self.spacing == Spacing::Factors {
            return factor_text(tick);
        }
        if self.spacing != Spacing::Even {
            return ratio_text(tick, &self.ticks());
        }
        let largest = self.max.abs().max(self.min.abs());
        match self.decimals() {
            decimals @ 0..=5 if largest < 1e6 => number_text(tick, decimals),
            _ => match rounded_to(tick, self.step) {
                0.0 => "0".to_owned(),
                rounded => format!("{rounded:e}").replace('-', MINUS),
            },
        }
    }
}

/// The least and the largest finite value.
pub(super) fn ends(values: impl IntoIterator<Item = f64>) -> Option<(f64, f64)> {
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

/// A text of more characters at a tick is hard to read, and has no room beside the label of its axis.
const LONGEST_TEXT: usize = 8;
/// Ticks of ratios beyond these are powers of ten.
const PLAIN_RATIOS: std::ops::Range<f64> = 1e-4..1e6;
/// Of the number that ticks are counted from.
const LONGEST_OFFSET: usize = 13;

/// One of some numbers that are shown together where ratios are: all of them plain, or all with a power of ten.
pub(super) fn ratio_text(value: f64, all: &[f64]) -> String {
    let rounded = |value: f64| format!("{value:.3e}").parse().unwrap_or(value);
    let are_plain = all.iter().all(|value| PLAIN_RATIOS.contains(&rounded(*value)));
    let value = rounded(value);
    if are_plain { value.to_string() } else { format!("{value:e}").replace('-', MINUS) }
}

/// A factor, with a power of ten only where it would be long by itself.
fn factor_text(factor: f64) -> String {
    if !PLAIN_RATIOS.contains(&factor) {
        return format!("{factor:e}");
    }
    let text = format!("{factor:.FACTOR_DECIMALS$}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// A step of a scale, with a power of ten where it would be long.
pub(super) fn step_text(step: f64, decimals: usize) -> String {
    let text = number_text(step, decimals);
    if text.chars().count() < LONGEST_TEXT { text } else { format!("{step:e}").replace('-', MINUS) }
}

/// A multiple of a step without the last bits of the multiplication, which its shortest text would show.
fn rounded_to(tick: f64, step: f64) -> f64 {
    let digits = if tick.abs() > 0.0 { (tick.abs() / step).log10().floor().max(0.0) as usize + 1 } else { 0 };
    format!("{tick:.digits$e}").parse().unwrap_or(tick)
}

/// 1, 2 or 5 times a power of ten, so that a span has about the number of ticks asked for.
pub(super) fn round_step(span: f64, ticks: usize) -> f64 {
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
    fn ticks_that_would_be_long_have_a_power_of_ten() {
        let texts = |scale: Scale| scale.ticks().into_iter().map(|tick| scale.text(tick)).collect::<Vec<_>>();
        assert_eq!(texts(Scale::even(0.0, 3e-7, 1e-7)), ["0", "1e\u{2212}7", "2e\u{2212}7", "3e\u{2212}7"]);
        assert_eq!(texts(Scale::even(1e6, 2e6, 5e5)), ["1e6", "1.5e6", "2e6"]);
        assert_eq!(texts(Scale::even(-0.5, 0.5, 0.5)), ["\u{2212}0.5", "0.0", "0.5"]);
    }

    #[test]
    fn ticks_of_ratios_are_all_plain_or_all_powers_of_ten() {
        let texts = |scale: Scale| scale.ticks().into_iter().map(|tick| scale.text(tick)).collect::<Vec<_>>();
        assert_eq!(texts(Scale::in_decades(1e-3, 1e5, 4)), ["0.01", "1", "100", "10000"]);
        assert_eq!(texts(Scale::in_decades(1.0, 1e9, 3)), ["1e0", "1e3", "1e6", "1e9"]);
        assert_eq!(texts(Scale::in_ratios(2e5, 2e6)), ["2e5", "3e5", "5e5", "1e6", "2e6"]);
    }

    #[test]
    fn factors_are_as_far_apart_as_their_logarithms() {
        let texts = |scale: Scale| scale.ticks().into_iter().map(|tick| scale.text(tick)).collect::<Vec<_>>();
        assert_eq!(texts(Scale::in_factors(1.01, 3000.0)), ["1.01", "1.1", "2", "10", "100"]);
        assert_eq!(texts(Scale::in_factors(1.01, 1e16)), ["1.01", "1.1", "2", "10", "1000", "1e7", "1e16"]);
        assert_eq!(texts(Scale::in_factors(1.1, 9.0)), ["1.1", "1.2", "1.5", "2", "5"]);
        let scale = Scale::in_factors(1.01, 1e16);
        assert!((scale.place(10.0) - scale.place(100.0) - scale.place(100.0) + scale.place(1e4)).abs() < 1e-12);
        assert!(scale.place(1.0) < 0.0 && scale.place(0.5) < 0.0, "cut off, like all that is less");
    }

    #[test]
    fn ticks_far_from_zero_are_short_and_counted_from_a_round_number() {
        let texts = |scale: Scale| scale.ticks().into_iter().map(|tick| scale.text(tick)).collect::<Vec<_>>();
        let scale = Scale::around([1_000_000.1, 1_000_000.5].into_iter(), 4);
        assert_eq!(texts(scale), ["0.1", "0.2", "0.3", "0.4", "0.5"]);
        assert_eq!(scale.above(), " above 1000000");
        let below_zero = Scale::even(-2_000_000.4, -2_000_000.0, 0.2);
        assert_eq!(
            (texts(below_zero), below_zero.above()),
            (vec!["0.6".into(), "0.8".into(), "1.0".into()], " above \u{2212}2000001".into())
        );
        let small = Scale::even(0.123_456_1, 0.123_456_3, 1e-7);
        assert_eq!(
            (texts(small), small.above()),
            (vec!["1e\u{2212}7".into(), "2e\u{2212}7".into(), "3e\u{2212}7".into()], " above 0.123456".into())
        );
        assert_eq!(Scale::even(4e15, 4.000_000_02e15, 1e7).above(), " above 4e15");
        assert_eq!(Scale::even(1e6, 2e6, 5e5).above(), "", "1.5e6 is short");
    }

    #[test]
    fn texts_at_ticks_are_short_and_no_two_are_equal() {
        for magnitude in [0.0, 1.0, 1e3, 999_999.0, 1e6, 1.234_567e6, 1e7, 1e9, 1e12] {
            for span in [1e-3, 0.4, 1.0, 30.0, 2e3, 1e6, 7e8] {
                for start in [magnitude, -magnitude, -magnitude - 0.5 * span] {
                    if span < 1e-8 * magnitude {
                        continue;
                    }
                    let scale = Scale::around([start, start + span].into_iter(), 5);
                    let mut texts: Vec<String> = scale.ticks().into_iter().map(|tick| scale.text(tick)).collect();
                    assert!(texts.iter().all(|text| text.chars().count() <= LONGEST_TEXT), "{texts:?}");
                    let n = texts.len();
                    texts.sort();
                    texts.dedup();
                    assert_eq!(texts.len(), n, "from {start}, {span} wide: {texts:?}");
                }
            }
        }
    }
}
