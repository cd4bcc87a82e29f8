//! How far from what is expected the response may be: wider than the surface has it while readings are few.

/// With no more readings than a quadratic has terms, the surface's deviations are widened by so many times themselves. Half of what the
/// certificate adds: that is about the best of all designs, this about one of them.
const WIDENED: f64 = 3.0;

/// By this the surface's deviations are multiplied. Of few readings it cannot tell how much of what they differ by is noise, and takes
/// their lowest for lower than it is. Chosen on campaigns of which the truth is known, as `docs/results-benchmark.md` says.
pub(crate) fn widened(n_readings: usize, n_terms: usize) -> f64 {
    let scarcity = (n_terms as f64 / n_readings.max(1) as f64).min(1.0);
    1.0 + WIDENED * scarcity * scarcity
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Four times with as many readings as terms or fewer, by three quarters of itself with twice as many, and by next to nothing with many.
    #[test]
    fn bands_are_widened_while_readings_are_few() {
        for (n_readings, expected) in [(0, 4.0), (3, 4.0), (6, 4.0), (12, 1.75), (60, 1.03)] {
            let found = widened(n_readings, 6);
            assert!((found - expected).abs() < 1e-12, "{n_readings}: {found}");
        }
    }
}
