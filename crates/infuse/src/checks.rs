//! The checks that the public functions on correction and convergence share.

use crate::Error;

/// A list with one entry per parameter.
pub(crate) fn check_length(name: &'static str, expected: usize, found: usize) -> Result<(), Error> {
    if found == expected {
        return Ok(());
    }
    Err(Error::WrongLength { name, expected, found })
}

pub(crate) fn check_count(name: &'static str, expected: usize, found: usize, per: &'static str) -> Result<(), Error> {
    if found == expected { Ok(()) } else { Err(Error::WrongCount { name, found, expected, per }) }
}

/// The format of a saved campaign.
pub(crate) fn check_format(found: u32, supported: u32) -> Result<(), Error> {
    if found == supported { Ok(()) } else { Err(Error::StateFormat { found, supported }) }
}

pub(crate) fn check_cells(n_cells: usize) -> Result<(), Error> {
    if n_cells == 0 { Err(Error::EmptyRegion) } else { Ok(()) }
}

pub(crate) fn check_finite(name: &'static str, values: &[f64]) -> Result<(), Error> {
    check_each(name, values, "a finite number", f64::is_finite)
}

/// Bounds on errors: a sequence of them, one per batch.
pub(crate) fn check_error_bounds(name: &'static str, values: &[f64]) -> Result<(), Error> {
    check_each(name, values, NOT_NEGATIVE, is_not_negative)
}

pub(crate) fn check_not_negative(name: &'static str, value: f64) -> Result<(), Error> {
    if is_not_negative(value) { Ok(()) } else { Err(Error::Setting { name, value, expected: NOT_NEGATIVE }) }
}

pub(crate) fn check_each(
    name: &'static str,
    values: &[f64],
    expected: &'static str,
    is_usable: impl Fn(f64) -> bool,
) -> Result<(), Error> {
    match values.iter().position(|value| !is_usable(*value)) {
        Some(index) => Err(Error::Entry { name, index, value: values[index], expected }),
        None => Ok(()),
    }
}

const NOT_NEGATIVE: &str = "a finite number, zero or positive";

fn is_not_negative(value: f64) -> bool {
    value.is_finite() && value >= 0.0
}
