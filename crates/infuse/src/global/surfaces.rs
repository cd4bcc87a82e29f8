//! The surfaces of a batch.

use crate::traced::TracedSurface;

/// What a batch fitted, (30) to (36); all in coordinates coded to the original box.
#[non_exhaustive]
#[derive(Debug, Clone)]
pub struct BatchSurfaces {
    /// Ĵexp,i, of training and validation experiments; none if too many of them failed.
    pub experiment: Option<TracedSurface>,
    /// Ĵsim,i, of the simulations as they are.
    pub simulation: TracedSurface,
    /// Ĵ_i, of training experiments and the simulations with the correction of batch i − 1.
    pub combined: TracedSurface,
    /// Ĵcor,i; with no Ĵexp,i that of batch i − 1.
    pub correction: TracedSurface,
    /// Ĵnum,i = Ĵsim,i + Ĵcor,i of (35).
    pub numerical: TracedSurface,
}
