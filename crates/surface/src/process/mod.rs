//! Gaussian processes with a trend, a simulation and a Matérn residual, averaged over their hyperparameters.

mod averaged;
mod covariance;
mod gaussian_process;
mod places;
mod sampler;
mod sites;

pub use averaged::{AveragedProcess, pooled_moments};
pub use covariance::{Covariance, Hyperparameters, Residual, SimulationUse, Structure};
pub use gaussian_process::{Contrast, GaussianProcess, Marginals};
pub use places::Places;
pub use sampler::SamplerSettings;
pub use sites::Sites;
