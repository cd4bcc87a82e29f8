#![doc = include_str!("../README.md")]

mod closed_loop;
mod cost;
mod course;
mod energy;
mod error;
mod experiment;
mod file;
mod fleet;
mod flight;
mod footprint;
mod integrate;
mod log;
mod masses;
mod open_loop;
mod plant_table;
mod profile;
mod quantity;
mod rig;
mod sensing;
mod settings;
mod shedding;
mod turbulence;
mod units;
mod watch;
mod water;

pub use closed_loop::{ClosedLoop, SampledMode, closed_loop_modes};
pub use cost::{CostBreakdown, CostFile, CostWeights, Integrals, N_TERMS, TERM_NAMES, open_loop_cost};
pub use energy::{Energy, Turbine};
pub use error::{Error, FileError, FlightError};
pub use experiment::BoundedNoise;
pub use fleet::{fly_all, fly_all_logged, fly_seeded};
pub use flight::{Flight, FlightRequest, fly, fly_logged};
pub use footprint::footprint_m2;
pub use log::{FlightLog, LogRow};
pub use masses::Masses;
pub use open_loop::{OpenLoop, open_loop_modes};
pub use profile::{Control, Departure, ProfileFile, TestProfile, Window};
pub use quantity::{Provenance, Record};
pub use rig::{Rig, RigFile};
pub use sensing::{
    Camera, Dot, Estimate, Hold, PixelNoise, Pose, Region, Sensing, SensingFile, Sighting, Tracker, View, Viewer,
};
pub use settings::{FlightSettings, SlackPolicy};
pub use shedding::Shedding;
pub use turbulence::Turbulence;
pub use watch::{Extremes, SlackEvent};
pub use water::{MovingWater, WaterRow, WaterTable};
