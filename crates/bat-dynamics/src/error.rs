//! What can be wrong with what a caller gives.

use thiserror::Error;

use crate::trim::NoTrim;

/// An error of this crate: what is wrong, where, and what was allowed.
#[non_exhaustive]
#[derive(Clone, Debug, Error, PartialEq)]
pub enum Error {
    /// A parameter outside what is physically possible.
    #[error("{section}.{name} = {value} {unit}: it must be {allowed}")]
    Parameter {
        /// Section of the parameter, as in a parameter file.
        section: &'static str,
        /// Name of the parameter, as in a parameter file.
        name: &'static str,
        /// The value that was given.
        value: f64,
        /// Its unit.
        unit: &'static str,
        /// What was allowed.
        allowed: &'static str,
    },
    /// A state in which the equations of motion are not defined.
    #[error("{name} = {value} {unit} at t = {time_s} s: it must be {allowed}")]
    State {
        /// Name of the coordinate or quantity.
        name: &'static str,
        /// The value that was given or reached.
        value: f64,
        /// Its unit.
        unit: &'static str,
        /// The time at which it was found.
        time_s: f64,
        /// What was allowed.
        allowed: &'static str,
    },
    /// An argument that is not a state or a parameter.
    #[error("{name} = {value}: it must be {allowed}")]
    Argument {
        /// Name of the argument.
        name: &'static str,
        /// The value that was given.
        value: f64,
        /// What was allowed.
        allowed: &'static str,
    },
    /// There is no equilibrium; the reason says why.
    #[error("no trim: {0}")]
    NoTrim(#[from] NoTrim),
    /// An eigenvalue computation that did not finish.
    #[error("the eigenvalues of the {size} x {size} matrix did not converge, or the matrix is not finite")]
    Eigenvalues {
        /// Rows of the matrix.
        size: usize,
    },
}
