//! Observations and surfaces that know every trial they rest on, so that validation cannot leak into what it validates.

mod fit;
mod observations;
mod sum;
mod traced_surface;

pub use observations::Observations;
pub use traced_surface::TracedSurface;
