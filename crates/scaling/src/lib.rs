#![doc = include_str!("../README.md")]

mod dimension;
#[cfg(feature = "toml")]
mod document;
mod error;
mod exponents;
mod factor;
mod group;
mod groups;
mod law;
mod near;
mod number;
mod parse;
mod repeating;
mod set_up;
mod similarity;
mod span;
mod system;
mod units;

pub use dimension::Dimension;
#[cfg(feature = "toml")]
pub use document::{Conversion, Converted, DocumentOptions};
pub use error::Error;
pub use factor::Factor;
pub use group::Group;
pub use groups::{Groups, Orientation};
pub use law::{Rule, ScalingLaw};
/// Exact exponents.
pub use num_rational::BigRational;
pub use repeating::RepeatingSets;
pub use set_up::SetUp;
pub use similarity::{Remedies, Remedy, Row, Similarity, Unchecked, Verdict};
pub use system::{System, Variable};
pub use units::{Unit, Units};
