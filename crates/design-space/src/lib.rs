#![doc = include_str!("../README.md")]

mod cell;
mod combinations;
mod error;
mod grid;
mod levels;
mod model;
mod parameter;
mod region;
mod term;

pub use cell::Cell;
pub use combinations::Combinations;
pub use error::Error;
pub use grid::{Grid, coded_level};
pub use levels::Levels;
pub use model::{Model, factor_names};
pub use parameter::Parameter;
pub use region::Region;
pub use term::Term;
