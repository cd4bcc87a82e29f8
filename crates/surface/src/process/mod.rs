//! Gaussian processes with a trend, a simulation and a Matérn residual, averaged over structures and hyperparameters.
//!
//! [`GaussianProcess`] is one of them with given hyperparameters; [`AveragedProcess`] is a sample of those that measurements leave
//! possible. What is measured are [`Sites`], where something is predicted are [`Places`]; both may carry what a simulation says
//! there. [`RegressorEvidence`] tells how well it does, [`Feasibility`] learns from failures where others will be.

mod averaged;
mod covariance;
mod feasibility;
mod gaussian_process;
mod gradient;
mod joint;
mod left_out;
mod places;
mod regressor;
mod sampler;
mod sites;

pub use averaged::AveragedProcess;
pub use covariance::{Additive, Covariance, Hyperparameters, Residual, SimulationUse, Structure};
pub use feasibility::Feasibility;
pub use gaussian_process::{Contrast, GaussianProcess, Marginals};
pub use gradient::Gradient;
pub use joint::Joint;
pub use places::Places;
pub use regressor::RegressorEvidence;
pub use sampler::SamplerSettings;
pub use sites::Sites;
