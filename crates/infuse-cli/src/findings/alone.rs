//! What a certificate would be, were the surface believed as it is.

use crate::problem::Response;

/// From this share of the bound on it is said that it is not the surface's.
pub(crate) const MUCH_IS_HELD: f64 = 0.2;

/// "more than 0.2 mm": the bound by the surface alone; none where that is hardly less.
pub(crate) fn by_the_surface_alone(response: &Response, bound: f64, alone: f64) -> Option<String> {
    (bound - alone > MUCH_IS_HELD * bound).then(|| match alone {
        alone if alone > 0.0 => format!("more than {}", response.amount(alone)),
        _ => "nothing".to_owned(),
    })
}
