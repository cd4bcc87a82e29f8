//! How far from what is expected the response may be: wider than the surface has it while readings are few.

use crate::pooled::measurements::Reading;

/// With no more readings than a quadratic has terms, the surface's deviations are widened by so many times themselves. Half of what the
/// certificate adds: that is about the best of all designs, this about one of them.
const WIDENED: f64 = 3.0;
/// Standard deviations on either side of an expectation, within which the response lies with 90 % probability.
pub const NINE_IN_TEN: f64 = 1.645;

/// How the surface's deviations are widened. Of few readings it cannot tell how much of what they differ by is noise, and takes their
/// lowest for lower than it is. Chosen on campaigns of which the truth is known, as `docs/results-benchmark.md` says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bands {
    by: f64,
    /// No deviation is widened beyond this.
    most: f64,
}

impl Bands {
    pub(crate) fn of(readings: &[Reading], n_terms: usize) -> Self {
        Self::after(readings.len(), n_terms, Reading::range(readings))
    }

    /// A band of nine in ten is not widened beyond what the readings differ by to either side.
    fn after(n_readings: usize, n_terms: usize, range: f64) -> Self {
        let scarcity = (n_terms as f64 / n_readings.max(1) as f64).min(1.0);
        Self { by: 1.0 + WIDENED * scarcity * scarcity, most: range / NINE_IN_TEN }
    }

    pub(crate) fn widen(self, deviation: f64) -> f64 {
        (self.by * deviation).min(self.most).max(deviation)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Four times with as many readings as terms or fewer, by three quarters of itself with twice as many, and by next to nothing with many;
    /// to no more than what they differ by, and never narrowed.
    #[test]
    fn bands_are_widened_while_readings_are_few() {
        for (n_readings, expected) in [(0, 4.0), (3, 4.0), (6, 4.0), (12, 1.75), (60, 1.03)] {
            let found = Bands::after(n_readings, 6, 1e9).widen(2.0);
            assert!((found - 2.0 * expected).abs() < 1e-12, "{n_readings}: {found}");
        }
        let capped = Bands::after(3, 6, 1.645);
        assert!(
            [0.2, 0.3, 5.0].map(|d| capped.widen(d)).iter().zip([0.8, 1.0, 5.0]).all(|(a, b)| (a - b).abs() < 1e-12)
        );
    }
}
