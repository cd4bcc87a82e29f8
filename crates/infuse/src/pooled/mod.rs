//! The pooled loop: every experiment so far and the simulation in one surface, and a certificate of what may still be gained.
//!
//! One turn:
//!
//! 1. All readings, earlier experiments included, condition a [`surface::process::AveragedProcess`]: polynomial trend, the
//!    simulation ignored, subtracted or scaled by a factor that is learnt, and a residual that is absent, smooth or rough; nine
//!    structures and their hyperparameters, averaged. Experiments that failed tell where others may fail. A simulation that is cheap
//!    is taken from as far off as makes the readings most probable, if that is by far more probable than its own place.
//! 2. The design with the lowest mean, of all that are likely to give a response, is recommended.
//! 3. Draws from that average, and some from one that does not believe the simulation, tell how much better another design may
//!    be: the [`Certificate`].
//! 4. The next batch is what lowers the expected minimum most: a knowledge gradient, pick by pick, repeats allowed. One pick in
//!    six is for the one who does not believe the simulation, so that a simulation that misleads is found out sooner; without a
//!    simulation one in four goes to where most of the box is far from any run, so that a well is found that no surface expects, and
//!    beside a simulation as many of these as it is likely to be of no use. What would gain next to nothing goes there, too.
//!    A reading that is far from all others is run again first, and set aside if that run says otherwise; if it is far better, up
//!    to a quarter of the batch is made around it, and the certificate holds something for what these runs may find. So it is with a
//!    few runs near to each other that are all far better than runs elsewhere say.
//!
//! While there are fewer readings than it takes to tell a plane from its noise, a batch is spread, two thirds over the
//! box and a third over what the simulation likes. Nothing is dropped for good, and all of it follows from readings, simulations,
//! settings and seed: in any order, on any number of threads. On one machine with one build it does so bit for bit. Elsewhere exp, ln
//! and sin of the platform may round differently, and then answers may differ, a draw of the sampler or a choice between equals that
//! fell otherwise included.
//!
//! The recipe is not from the dissertation. Its sources: Kennedy and O'Hagan (2000) for the factor of the simulation, Murray,
//! Adams and MacKay (2010) for the sampler of the hyperparameters, Frazier, Powell and Dayanik (2009) for the knowledge gradient.
//!
//! A campaign can be saved at any time: [`Loop`] serializes, with all that it was told and has asked for. What it thinks of that follows anew
//! when it is read; a file that no campaign can have written is refused.
//!
//! ```
//! use design_space::{Cell, Parameter, Region};
//! use infuse::pooled::{Loop, Settings};
//!
//! let region = Region::new(vec![
//!     Parameter::continuous("spring", "N/mm", 10.0, 50.0)?.with_levels(21)?,
//!     Parameter::continuous("damper", "N s/m", 0.0, 400.0)?.with_levels(21)?,
//! ])?;
//! let mut settings = Settings::new(8);
//! settings.max_batches = 3;
//! let mut campaign = Loop::new(&region, settings)?;
//! let mut simulation = |_: Cell, p: &[f64]| Ok(((p[0] - 25.0) / 20.0).powi(2) + ((p[1] - 150.0) / 200.0).powi(2));
//! // On the rig the best is elsewhere.
//! let rig = |p: &[f64]| ((p[0] - 34.0) / 20.0).powi(2) + ((p[1] - 220.0) / 200.0).powi(2);
//! campaign.run(&mut simulation, &mut |trial| Ok(rig(&trial.point)))?;
//! let found = campaign.assess(Some(&mut simulation))?.expect("there are responses");
//! assert_eq!(found.recommended.point, [34.0, 220.0]);
//! # Ok::<(), infuse::Error>(())
//! ```

mod admission;
mod answers;
mod ask_tell;
mod assessment;
mod bands;
mod block;
mod campaign;
mod certificate;
mod constraint;
mod coverage;
mod designs;
mod displacement;
mod drift;
mod economy;
mod evenly;
mod finds;
mod first_batch;
mod held;
mod knowledge;
mod knowledge_gradient;
mod look;
mod measurements;
mod moments;
mod narrow;
mod outcomes;
mod outliers;
mod plants;
mod pockets;
mod pool;
mod readings;
mod reason;
mod recommendation;
mod registration;
mod run_means;
#[cfg(test)]
mod scene;
mod settings;
mod shared;
mod simulated;
mod spread;
mod state;
mod streams;
mod turn;

pub use ask_tell::{Ask, StopReason};
pub use assessment::{Assessment, Expectation, Needed, Standing};
pub use campaign::{Earlier, Loop, Record, Trial};
pub use certificate::{Certificate, Forecast};
pub use constraint::{Constraint, LinearConstraint};
pub use plants::Plants;
pub use reason::Reason;
pub use settings::{Settings, StopBy};
pub use simulated::{Responses, Simulate};

/// What an [`Assessment`] consists of.
pub mod reported {
    pub use super::assessment::{Constrained, Contradiction, SimulationWorth};
    pub use super::bands::NINE_IN_TEN;
    pub use super::block::Block;
    pub use super::drift::{Drift, Shift};
    pub use super::held::FEASIBLE;
    pub use super::outliers::{Doubted, Outlier};
    pub use super::registration::{Refused, Registration};
    pub use super::run_means::OfMeans;
}
