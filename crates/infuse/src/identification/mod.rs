//! Identification of parameters: numbers of the model that nobody is sure of, found from what was measured.
//!
//! The other way to digest experiments, beside the correction (27) of a response: "direct parameter identification of a
//! subset of system parameters".
//! Numbers that are sought are called *unknowns* here, because parameters are what the loops of this crate optimize.
//!
//! ```text
//! minimize over θ   Σ_i Σ_k ((f_k(θ, p_i) − y_ik) / σ_ik)²        lower ≤ θ ≤ upper
//! ```
//!
//! with the response k of experiment i at the design p_i, measured as y_ik with the standard deviation σ_ik.
//! The minimum is sought in shares of the ranges, by steps of least length within a trust region that bends at the bounds
//! (`basin`, after Branch, Coleman and Li 1999); a step whose model fails is shortened.
//!
//! ```
//! use design_space::{Parameter, Region};
//! use infuse::identification::{Measurements, Settings, Unknowns, identify};
//!
//! let region = Region::new(vec![
//!     Parameter::continuous("stiffness", "N/m", 1.0, 9.0)?,
//!     Parameter::continuous("preload", "N", -5.0, 5.0)?,
//!     Parameter::continuous("damping", "N s/m", 0.0, 1.0)?,
//! ])?;
//! let unknowns = Unknowns::new(region, vec![2.0, 0.0, 0.5])?;
//! // The force at four deflections, to 0.1 N: 4 N/m and 1 N would make 5, 9, 13 and 17 N.
//! let mut measurements = Measurements::new(vec!["force".into()])?;
//! for (deflection, force) in [(1.0, 5.1), (2.0, 8.9), (3.0, 13.0), (4.0, 17.1)] {
//!     measurements.push(&[deflection], &[force], &[0.1])?;
//! }
//! // For every vector of unknowns and every design, the responses.
//! let mut model = |unknowns: &[Vec<f64>], designs: &[Vec<f64>]| {
//!     let force = |theta: &Vec<f64>, p: &Vec<f64>| Ok(vec![theta[0] * p[0] + theta[1]]);
//!     unknowns.iter().map(|theta| designs.iter().map(|p| force(theta, p)).collect()).collect()
//! };
//! let found = identify(&unknowns, &measurements, &Settings::default(), &mut model)?;
//! let stiffness = &found.estimates[0];
//! assert!((stiffness.value - 4.01).abs() < 1e-6);
//! // 0.1 N over the root of Σ (p − 2.5)² = 5.
//! assert!((stiffness.standard_error.unwrap() - 0.1 / 5.0_f64.sqrt()).abs() < 1e-6);
//! // Nothing that moves slowly tells of damping: it stays where it was believed to be.
//! assert!(found.estimates[2].standard_error.is_none() && (found.estimates[2].value - 0.5).abs() < 1e-6);
//! assert_eq!(found.undetermined[0].words, "`damping` has no effect on what was measured");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # What can be known
//!
//! The Jacobian of the weighted residuals at the estimate, in shares of the ranges, is taken apart into directions by its
//! singular values S. Along one of them the standard error is σ/S, with σ = 1 where the noise is known, and estimated from
//! the residuals where it is not ([`Noise`]). A direction is *undetermined* where that is more than
//! [`Settings::largest_error`] of the range, or S less than 1e-6 of the largest. Along such a direction the unknowns are held at
//! their start and the rest is fitted anew, so that noise does not choose what data cannot tell; the direction is told in words.
//!
//! Standard errors are those of the linearized model, of unknowns that lie within their bounds; an unknown at a bound has
//! none, and those of the others are as if it were known. They say how noise moves the estimates, and nothing of a model that is wrong:
//! its error is a bias that no residual shows. [`Identification::misfit`] tells when the residuals are larger than the
//! noise allows.
//!
//! Together with the correction (27): [`gradient::IdentifyingLoop`](crate::gradient::IdentifyingLoop).
//!
//! Source: Section 3.5, the first of its two mechanisms, which the dissertation names and does not use.

mod found;
mod identify;
mod jacobian;
mod measurements;
mod precision;
mod residuals;
mod search;
mod settings;
mod undetermined;
mod unknowns;

pub use found::{Estimate, FitStop, Identification, RangeEnd};
pub use identify::identify;
pub use measurements::Measurements;
pub use residuals::Answer;
pub use settings::{Noise, Settings};
pub use undetermined::Direction;
pub use unknowns::Unknowns;
