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

fn on_its_scale(response: &Response, axis: Axis, values: Vec<f64>) -> Axis {
    let (low, high) = values.iter().fold((f64::INFINITY, 0.0_f64), |(low, high), &v| (low.min(v), high.max(v)));
    match response.scale {
        Scale::Linear => axis.around(values),
        Scale::Log if high > MANY * low => axis.in_decades(values),
        Scale::Log => axis.in_ratios(values),
    }
}
