#![doc = include_str!("../README.md")]

mod error;
mod grid;
mod levels;
mod parameter;
mod region;

pub use error::Error;
pub use grid::Grid;
pub use levels::Levels;
pub use parameter::Parameter;
pub use region::Region;
