//! A surface at the points of a grid by tables of its axes: what depends on one coordinate is computed once a level, not once
//! a point.

mod exponentials;
mod powers;
mod runs;
mod squares;

pub(crate) use exponentials::Exponentials;
pub(crate) use powers::Powers;
pub use runs::OverGrid;
pub(crate) use squares::Squares;
