//! Values and differences of the response, with their unit.

use crate::number::{short, with_unit};
use crate::problem::Response;

/// The value of a computed cost.
pub(crate) fn value(response: &Response, cost: f64) -> String {
    with_unit(&short(response.of_cost(cost)), &response.unit)
}

/// The same, known to about `resolution`.
pub(crate) fn value_to(response: &Response, cost: f64, resolution: f64) -> String {
    with_unit(&response.number_to(cost, resolution), &response.unit)
}

/// A difference of costs.
pub(crate) fn amount(response: &Response, difference: f64) -> String {
    response.amount(difference)
}

/// What can be gained, in words if it is nothing.
pub(crate) fn gain(response: &Response, mean: f64) -> String {
    if mean > 0.0 { amount(response, mean) } else { "practically nothing".to_owned() }
}
