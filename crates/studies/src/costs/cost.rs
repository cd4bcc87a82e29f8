//! What a flight costs.

/// A flight's cost, or the reason why there is none.
pub(crate) type Cost = Result<f64, String>;
