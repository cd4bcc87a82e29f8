#![doc = include_str!("../README.md")]

mod controller;
mod error;
mod filtered_pd;
mod mixing;

pub use controller::{
    Command, Controller, ControllerParameters, ControllerState, Measurement, SetPoints, TrackingErrors,
};
pub use error::Error;
pub use filtered_pd::{FilteredPd, PdState, SampledPd};
pub use mixing::{Mixing, TetherLayout};
