#![doc = include_str!("../README.md")]

mod compare;
mod data;
mod distance;
mod error;
mod exponential;
mod inverse_distance;
mod lack_of_fit;
mod lanes;
mod leave_one_out;
mod monomial;
mod over_grid;
mod points;
mod polynomial;
pub mod process;
mod quotients;
mod regression;
mod relative_average;
mod scale_choice;
mod squared_exponential;
mod student;
mod surface;
mod weighted_average;

pub use compare::{Comparison, Kind, compare};
pub use data::Data;
/// What models, spaces and designs are made of, from the crates `design-space` and `doe`, for those who need no more of these.
#[doc(no_inline)]
pub use design_space::Error as DesignSpaceError;
#[doc(no_inline)]
pub use design_space::{Model, Term};
#[doc(no_inline)]
pub use doe::Error as DesignError;
#[doc(no_inline)]
pub use doe::{Axis, Confounding, Design, Space};
pub use error::Error;
pub use inverse_distance::InverseDistance;
pub use lack_of_fit::LackOfFit;
pub use lanes::{LANES, Lanes, MOST_FACTORS};
pub use leave_one_out::LeaveOneOut;
pub use over_grid::OverGrid;
pub use points::{GridPoints, PointSource, Rows};
pub use polynomial::Polynomial;
pub use regression::{Confounded, Regression};
pub use scale_choice::ScaleChoice;
pub use squared_exponential::SquaredExponential;
pub use student::CoefficientTest;
pub use surface::{Minimum, Surface};
