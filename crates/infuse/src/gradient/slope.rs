//! Slopes from the costs at a center and beside it.

/// A cost beside the center.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Side {
    /// Distance from the center, positive, in the parameter's unit.
    pub(crate) distance: f64,
    pub(crate) cost: f64,
}

/// Relative difference of two distances that counts as a difference: far above rounding.
const SAME_DISTANCE: f64 = 1e-9;

/// Slope at the center along one parameter, from what is known; nothing if too little is.
///
/// Both sides at the same distance h give the central difference (J₊ − J₋) / 2h, which does not need
/// the center. At distances a and b the parabola through all three points gives
/// ((J₊ − J₀) b/a + (J₀ − J₋) a/b) / (a + b), or the secant if the center is unknown. One side and
/// the center give the one-sided difference, whose error is of first order in the distance.
pub(crate) fn slope(center: Option<f64>, plus: Option<Side>, minus: Option<Side>) -> Option<f64> {
    let slope = match (plus, minus) {
        (Some(plus), Some(minus)) => {
            let (a, b) = (plus.distance, minus.distance);
            match center {
                Some(center) if (a - b).abs() > SAME_DISTANCE * (a + b) => {
                    ((plus.cost - center) * (b / a) + (center - minus.cost) * (a / b)) / (a + b)
                }
                _ => (plus.cost - minus.cost) / (a + b),
            }
        }
        (Some(plus), None) => (plus.cost - center?) / plus.distance,
        (None, Some(minus)) => (center? - minus.cost) / minus.distance,
        (None, None) => return None,
    };
    slope.is_finite().then_some(slope)
}

/// Slope at the center from two points on one side, at h and 2 h: (4 J₁ − 3 J₀ − J₂) / 2h away from
/// the center, exact on a parabola; the one-sided difference if the second is unknown.
pub(crate) fn slope_away(center: f64, near: Option<Side>, far: Option<Side>) -> Option<f64> {
    let near = near?;
    let slope = far.map_or_else(
        || (near.cost - center) / near.distance,
        |far| (4.0 * near.cost - 3.0 * center - far.cost) / far.distance,
    );
    slope.is_finite().then_some(slope)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// J = 3 + 2 x + 5 x², slope 2 at the center.
    fn side(x: f64) -> Option<Side> {
        Some(Side { distance: x.abs(), cost: 3.0 + 2.0 * x + 5.0 * x * x })
    }

    #[track_caller]
    fn check(slope: Option<f64>, expected: f64) {
        let slope = slope.expect("the slope is known");
        assert!((slope - expected).abs() < 1e-12, "{slope} is not {expected}");
    }

    #[test]
    fn two_sides_are_exact_on_a_parabola() {
        check(slope(Some(3.0), side(0.5), side(-0.5)), 2.0);
        check(slope(None, side(0.5), side(-0.5)), 2.0);
        check(slope(Some(3.0), side(0.5), side(-0.2)), 2.0);
    }

    #[test]
    fn one_side_errs_by_half_the_curvature_times_the_distance() {
        check(slope(Some(3.0), side(0.5), None), 2.0 + 5.0 * 0.5);
        check(slope(Some(3.0), None, side(-0.5)), 2.0 - 5.0 * 0.5);
        check(slope(None, side(0.5), side(-0.2)), 2.0 + 5.0 * 0.3);
    }

    #[test]
    fn two_points_on_one_side_are_exact_on_a_parabola() {
        check(slope_away(3.0, side(0.5), side(1.0)), 2.0);
        check(slope_away(3.0, side(-0.5), side(-1.0)), -2.0);
        check(slope_away(3.0, side(0.5), None), 2.0 + 5.0 * 0.5);
        assert_eq!(slope_away(3.0, None, side(1.0)), None, "no near side");
    }

    #[test]
    fn too_little_is_unknown() {
        assert_eq!(slope(None, side(0.5), None), None, "no center");
        assert_eq!(slope(None, None, side(-0.5)), None, "no center");
        assert_eq!(slope(Some(3.0), None, None), None, "no side");
        let huge = |cost| Some(Side { distance: 1e-3, cost });
        assert_eq!(slope(None, huge(1e308), huge(-1e308)), None, "overflow");
    }
}
