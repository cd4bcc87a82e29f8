//! Distances that neither overflow nor vanish.

/// A Euclidean distance as largest coordinate difference times a number from 1 to √K.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Distance {
    largest: f64,
    /// Sum of squares of the differences, each divided by the largest.
    shape: f64,
}

impl Distance {
    pub(crate) fn between(a: &[f64], b: &[f64]) -> Self {
        let largest = a.iter().zip(b).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
        let shape = if largest > 0.0 {
            a.iter().zip(b).map(|(x, y)| (x - y) / largest).map(|ratio| ratio * ratio).sum()
        } else {
            1.0
        };
        Self { largest, shape }
    }

    /// Only the same point has no distance: the difference of two unequal numbers is never zero.
    pub(crate) fn is_zero(self) -> bool {
        self.largest <= 0.0
    }

    pub(crate) fn value(self) -> f64 {
        self.largest * self.shape.sqrt()
    }

    /// This distance over another that is not zero.
    pub(crate) fn ratio(self, other: Self) -> f64 {
        (self.largest / other.largest) * (self.shape / other.shape).sqrt()
    }

    pub(crate) fn is_below(self, other: Self) -> bool {
        if other.is_zero() { false } else { self.ratio(other) < 1.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_keep_their_ratio_at_any_size() {
        for size in [1e-300, 1e-160, 1.0, 1e160, 1e300] {
            let three = Distance::between(&[3.0 * size, 0.0], &[0.0, 0.0]);
            let five = Distance::between(&[3.0 * size, 0.0], &[0.0, 4.0 * size]);
            assert!((three.ratio(five) - 0.6).abs() < 1e-15, "{size:e}");
            assert!((five.value() / size - 5.0).abs() < 1e-14, "{size:e}");
            assert!(three.is_below(five) && !five.is_below(three), "{size:e}");
        }
        let zero = Distance::between(&[1.0], &[1.0]);
        assert!(zero.is_zero() && !zero.is_below(zero));
        assert!(zero.is_below(Distance::between(&[f64::MIN_POSITIVE], &[0.0])));
    }
}
