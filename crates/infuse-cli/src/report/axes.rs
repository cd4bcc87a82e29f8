//! Axes of the response and of its differences, on the scale of the response.

use page::Axis;

use crate::problem::{Response, Scale};

/// From this ratio of the largest to the smallest on, powers of ten tell more than the numbers between them.
const MANY: f64 = 30.0;

/// Of the response, or of something else in its unit, around these values.
pub(crate) fn of_response(response: &Response, name: &str, values: impl IntoIterator<Item = f64>) -> Axis {
    on_its_scale(response, Axis::new(name, &response.unit), values.into_iter().collect())
}

/// Of differences: about zero, or as factors about one.
pub(crate) fn of_differences(response: &Response, name: &str, values: impl IntoIterator<Item = f64>) -> Axis {
    let values = values.into_iter().chain([response.no_difference()]).collect();
    on_its_scale(response, Axis::new(name, response.unit_of_differences()), values)
}

/// From this ratio of the largest bound to the least on, powers of ten tell more.
const MANY_BOUNDS: f64 = 20.0;
/// A bound of less than this share of the largest is next to nothing.
const NEXT_TO_NOTHING: f64 = 1e-4;

/// Of bounds that are so many differences, and the least of them that it has: one that is less is drawn there.
pub(crate) fn of_bounds(response: &Response, name: &str, bounds: &[f64]) -> (Axis, f64) {
    let most = bounds.iter().copied().fold(0.0, f64::max);
    let least = bounds.iter().copied().filter(|bound| *bound > NEXT_TO_NOTHING * most).fold(f64::INFINITY, f64::min);
    if most <= MANY_BOUNDS * least {
        let values = bounds.iter().map(|bound| response.of_difference(*bound));
        return (of_differences(response, name, values), 0.0);
    }
    let axis = Axis::new(name, response.unit_of_differences());
    let round = |value: f64| 10_f64.powf((value.log10() + 1e-6).floor());
    match response.scale {
        Scale::Linear => (axis.in_decades([round(least), most]), round(least)),
        Scale::Log => {
            let least = 1.0 + round(response.of_difference(least) - 1.0);
            (axis.in_factors([least, response.of_difference(most)]), least.ln())
        }
    }
}

fn on_its_scale(response: &Response, axis: Axis, values: Vec<f64>) -> Axis {
    let (low, high) = values.iter().fold((f64::INFINITY, 0.0_f64), |(low, high), &v| (low.min(v), high.max(v)));
    match response.scale {
        Scale::Linear => axis.around(values),
        Scale::Log if high > MANY * low => axis.in_decades(values),
        Scale::Log => axis.in_ratios(values),
    }
}
