//! The squared-exponential average at any distance from the data.

use crate::exponential::exp_of_negative;
use crate::lanes::is_usable;
use crate::weighted_average::{Datum, mean};

/// (34) with all exponents relative to the largest: right at any distance. NaN without data or at a point that is not
/// finite.
pub(crate) fn average<'a>(point: &[f64], data: impl Iterator<Item = Datum<'a>> + Clone, scale: f64) -> f64 {
    if !is_usable(point, point.len()) {
        return f64::NAN;
    }
    let Some(nearest) = nearest(point, data.clone()) else {
        return f64::NAN;
    };
    let relative = |datum: Datum<'_>| (datum.value, datum.weight * relative_weight(point, datum.point, nearest, scale));
    mean(data.map(relative).filter(|&(_, weight)| weight > 0.0))
}

/// The nearest point, the first of equals.
pub(crate) fn nearest<'a>(point: &[f64], data: impl Iterator<Item = Datum<'a>>) -> Option<&'a [f64]> {
    let closer = |a: &'a [f64], b: &'a [f64]| if excess(point, b, a).0 < 0.0 { b } else { a };
    data.map(|datum| datum.point).reduce(closer)
}

/// |p − a|² − |p − b|² as a number and a factor of at least 1 that it has to be multiplied by.
///
/// It is (b − a)·((p − a) + (p − b)), which neither cancels nor overflows however far p is.
fn excess(point: &[f64], a: &[f64], b: &[f64]) -> (f64, f64) {
    let size = point.iter().fold(1.0, |largest: f64, x| largest.max(x.abs()));
    let parts = point.iter().zip(a.iter().zip(b)).map(|(x, (a, b))| (b - a) * ((x - a) / size + (x - b) / size));
    (parts.sum(), size)
}

/// exp(−c² (d² − d_nearest²)).
pub(crate) fn relative_weight(point: &[f64], datum: &[f64], nearest: &[f64], scale: f64) -> f64 {
    let (excess, size) = excess(point, datum, nearest);
    // An excess below zero is rounding; zero times an overflown factor would not be a number.
    if excess <= 0.0 { 1.0 } else { exp_of_negative(-(scale * excess) * (scale * size)) }
}
