//! What can be wrong with the parameters of a controller.

/// A parameter that the controller refuses.
///
/// Only constructors fail: once a [`Controller`](crate::Controller) exists, every call of it succeeds.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The parameter is infinite or not a number.
    #[error("`{name}` is {value}, but must be finite")]
    NonFinite {
        /// The parameter's name as it stands in its struct.
        name: &'static str,
        /// The refused value.
        value: f64,
    },
    /// The parameter must be greater than zero.
    #[error("`{name}` is {value}, but must be greater than 0")]
    NotPositive {
        /// The parameter's name as it stands in its struct.
        name: &'static str,
        /// The refused value.
        value: f64,
    },
}

/// Refuses what is infinite or not a number.
pub(crate) fn check_finite(name: &'static str, value: f64) -> Result<(), Error> {
    if value.is_finite() { Ok(()) } else { Err(Error::NonFinite { name, value }) }
}

/// Refuses what is not finite, and what is zero or negative.
pub(crate) fn check_positive(name: &'static str, value: f64) -> Result<(), Error> {
    check_finite(name, value)?;
    if value > 0.0 { Ok(()) } else { Err(Error::NotPositive { name, value }) }
}
