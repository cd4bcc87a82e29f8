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
mod surface;
mod weighted_average;

pub use compare::{Comparison, Kind, compare};
pub use data::Data;
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
pub use surface::{Minimum, Surface};
