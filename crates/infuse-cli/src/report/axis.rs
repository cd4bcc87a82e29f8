//! The scale of an axis, and the round numbers along it.

use crate::number::plain;

/// Where values lie between the two ends of an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Scale {
    Linear {
        min: f64,
        max: f64,
    },
    /// Both ends positive.
    Log {
        min: f64,
        max: f64,
    },
}

impl Scale {
    /// From a round number below all values to one above, with some room, and from zero if that is near.
    pub(super) fn around(values: impl IntoIterator<Item = f64>) -> Self {
        let (mut min, mut max) = ends(values).unwrap_or((0.0, 1.0));
        if min >= 0.0 && min < 0.25 * max {
            min = 0.0;
        }
        if max - min <= 1e-9 * max.abs().max(min.abs()) {
            (min, max) = if max.abs() > 0.0 { (min - 0.1 * max.abs(), max + 0.1 * max.abs()) } else { (0.0, 1.0) };
        }
        let step = round_step((max - min) / 5.0);
        let room = 0.04 * (max - min);
        // Zero needs no room.
        let (min, max) = (if min >= 0.0 && min < room { 0.0 } else { min - room }, max + room);
        Self::Linear { min: (min / step + 1e-9).floor() * step, max: (max / step - 1e-9).ceil() * step }
    }

    /// From one end to the other, and as far as these values go.
    pub(super) fn covering(from: f64, to: f64, values: impl IntoIterator<Item = f64>) -> Self {
        let (min, max) = ends(values.into_iter().chain([from, to])).unwrap_or((from, to));
        let room = |moved: bool| if moved { 0.02 * (max - min) } else { 0.0 };
        Self::Linear { min: min - room(min < from), max: max + room(max > to) }
    }

    /// Whole numbers from the first to the last, with half a step of room on either side.
    pub(super) fn counting(first: usize, last: usize) -> Self {
        Self::Linear { min: first as f64 - 0.5, max: last as f64 + 0.5 }
    }

    /// From a power of ten to another; none if not all values are positive.
    pub(super) fn decades(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let (min, max) = ends(values).filter(|&(min, _)| min > 0.0)?;
        let (low, high) = ((min.log10() + 1e-9).floor(), (max.log10() - 1e-9).ceil());
        Some(Self::Log { min: 10_f64.powf(low), max: 10_f64.powf(high.max(low + 1.0)) })
    }

    /// 0 at the beginning, 1 at the end.
    pub(super) fn place(&self, value: f64) -> f64 {
        match *self {
            Self::Linear { min, max } => (value - min) / (max - min),
            Self::Log { min, max } => (value / min).log10() / (max / min).log10(),
        }
    }

    /// Where numbers stand, at most about this many.
    pub(super) fn ticks(&self, most: usize) -> Vec<f64> {
        match *self {
            Self::Linear { min, max } => multiples(min, max, round_step((max - min) / most.max(1) as f64)),
            Self::Log { min, max } => {
                let decades = (max / min).log10().round();
                let every = (decades / most.max(1) as f64).ceil().max(1.0);
                let exponents = multiples(min.log10().round(), max.log10().round(), every);
                exponents.into_iter().map(|exponent| 10_f64.powf(exponent)).collect()
            }
        }
    }

    /// The same for whole numbers.
    pub(super) fn whole_ticks(&self, most: usize) -> Vec<f64> {
        match *self {
            Self::Linear { min, max } => multiples(min, max, round_step((max - min) / most.max(1) as f64).max(1.0)),
            Self::Log { .. } => self.ticks(most),
        }
    }
}

/// What stands at a tick.
pub(super) fn label(tick: f64) -> String {
    plain(tick)
}

fn ends(values: impl IntoIterator<Item = f64>) -> Option<(f64, f64)> {
    let finite = values.into_iter().filter(|value| value.is_finite());
    finite.fold(None, |ends, value| match ends {
        None => Some((value, value)),
        Some((min, max)) => Some((value.min(min), value.max(max))),
    })
}

/// The multiples of a step in a range, without the rounding that adding up steps would bring.
fn multiples(min: f64, max: f64, step: f64) -> Vec<f64> {
    let (first, last) = ((min / step - 1e-6).ceil(), (max / step + 1e-6).floor());
    let mut multiples = Vec::new();
    let mut index = first;
    // Where a step is lost in rounding, the index never grows: the length ends it.
    while index <= last && multiples.len() < 100 {
        multiples.push(index * step + 0.0);
        index += 1.0;
    }
    multiples
}

/// 1, 2 or 5 times a power of ten, not less than this but for rounding.
fn round_step(rough: f64) -> f64 {
    let power = 10_f64.powf(rough.log10().floor());
    let factor = [1.0, 2.0, 5.0].into_iter().find(|factor| factor * power >= rough * (1.0 - 1e-9)).unwrap_or(10.0);
    factor * power
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_hold_the_values_between_round_numbers() {
        assert_eq!(Scale::around([4.35, 6.85]), Scale::Linear { min: 4.0, max: 7.0 });
        assert_eq!(Scale::around([0.001, 0.02]), Scale::Linear { min: 0.0, max: 0.025 });
        assert_eq!(Scale::decades([5.3, 100.0]), Some(Scale::Log { min: 1.0, max: 100.0 }));
        assert_eq!(Scale::decades([0.0, 1.0]), None);
    }

    #[test]
    fn ticks_are_round_and_few() {
        let linear = Scale::Linear { min: 10.0, max: 34.0 };
        assert_eq!(linear.ticks(6), [10.0, 15.0, 20.0, 25.0, 30.0]);
        assert_eq!(
            Scale::Linear { min: 0.1, max: 0.4 }.ticks(4).into_iter().map(label).collect::<Vec<_>>(),
            ["0.1", "0.2", "0.3", "0.4"]
        );
        assert_eq!(Scale::Log { min: 0.01, max: 100.0 }.ticks(9), [0.01, 0.1, 1.0, 10.0, 100.0]);
        assert_eq!(Scale::counting(1, 3).whole_ticks(8), [1.0, 2.0, 3.0]);
    }

    #[test]
    fn scales_survive_values_that_are_none_or_all_the_same() {
        for values in [vec![], vec![f64::NAN], vec![3.0], vec![0.0], vec![f64::INFINITY, 2.0], vec![-1e-300]] {
            let Scale::Linear { min, max } = Scale::around(values.clone()) else { continue };
            assert!(min < max, "{values:?}: {min} to {max}");
            assert!(Scale::around(values).ticks(5).len() < 20, "few");
        }
    }
}
