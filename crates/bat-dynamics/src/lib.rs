#![doc = include_str!("../README.md")]

mod error;
mod flow;
mod fluid;
mod inertia;
mod kinematics;
mod lanes;
mod linear;
mod modes;
mod motion;
mod parameters;
mod plant;
mod presets;
mod real;
mod trig;
mod trim;
mod vector;

pub use error::Error;
pub use flow::{Flow, FlowHistory, FlowKnot, Transition};
pub use fluid::{aerodynamic_wrench, lift_coefficients};
pub use inertia::{
    christoffel_matrix, generalized_forces, gravity_vector, kinetic_energy, mass_matrix, potential_energy,
};
pub use kinematics::{
    Coordinates, FlightState, STATE_NAMES, STATE_UNITS, Sight, body_to_ground, driven_of_lines, lines_of_driven,
    rotation, translation,
};
pub use lanes::{LANES, Lanes};
pub use linear::{Linearization, Variable, linearize};
pub use modes::{Mode, Modes, modes};
pub use motion::{
    Accelerations, Evaluation, SINGULAR_SIN_ZENITH, Slack, Tensions, accelerations, check_state, evaluate, sight,
};
pub use parameters::{
    AddedMass, Allowed, Body, FIELDS, Field, Fluid, HorizontalStabilizer, Hull, Parameters, Stall, Tether,
    TetherLayout, VerticalStabilizer, Winch,
};
pub use plant::{Fidelity, FluidInertia, Lift, Plant};
pub use real::Real;
pub use trim::{NoTrim, Trim, TrimHeight, TrimRequest, trim, trim_with_lines};
