//! Gaussian processes with a trend, a simulation and a Matérn residual, averaged over their hyperparameters.

mod averaged;
mod covariance;
mod feasibility;
mod gaussian_process;
mod joint;
mod places;
mod sampler;
mod sites;

pub use averaged::AveragedProcess;
pub use covariance::{Covariance, Hyperparameters, Residual, SimulationUse, Structure};
pub use feasibility::Feasibility;
pub use gaussian_process::{Contrast, GaussianProcess, Marginals};
pub use joint::Joint;
pub use places::Places;
pub use sampler::SamplerSettings;
pub use sites::Sites;
