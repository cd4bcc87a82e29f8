//! Values and differences of the response, with their unit.

use crate::campaign::Campaign;
use crate::number::{short, with_unit};

/// The value of a computed cost.
pub(crate) fn value(campaign: &Campaign, cost: f64) -> String {
    let response = &campaign.problem.response;
    with_unit(&short(response.of_cost(cost)), &response.unit)
}

/// A difference of costs.
pub(crate) fn amount(campaign: &Campaign, difference: f64) -> String {
    with_unit(&short(difference), &campaign.problem.response.unit)
}

/// What can be gained, in words if it is nothing.
pub(super) fn gain(campaign: &Campaign, mean: f64) -> String {
    if mean > 0.0 { amount(campaign, mean) } else { "practically nothing".to_owned() }
}
