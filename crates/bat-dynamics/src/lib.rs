#![doc = include_str!("../README.md")]

mod aerodynamics;
mod allowed;
mod balance;
mod ballast;
mod bridle;
mod coordinates;
mod disturbance;
mod double;
mod dual;
mod error;
mod evaluation;
mod flow;
mod inertia;
mod kinematics;
mod lanes;
mod layout;
mod linear;
mod modes;
mod motion;
mod parameters;
mod plant;
mod presets;
mod real;
mod rows;
mod stall;
mod tensions;
mod tether_drag;
mod trig;
mod trim;
mod vector;
mod winch;

pub use aerodynamics::aerodynamic_wrench;
pub use allowed::Allowed;
pub use balance::TrimHeight;
pub use ballast::{Ballast, Fin, MassModel, PlantDesign};
pub use bridle::{driven_of_lines, lines_of_driven};
pub use coordinates::{Coordinates, FlightState, SINGULAR_SIN_ZENITH, STATE_NAMES, STATE_UNITS, check_state};
pub use disturbance::Disturbance;
pub use error::{Error, NoTrim};
pub use evaluation::{Evaluation, evaluate, evaluate_disturbed, evaluate_with, sight};
pub use flow::{Flow, FlowHistory, FlowKnot, Transition};
pub use inertia::{
    christoffel_matrix, generalized_forces, gravity_vector, kinetic_energy, mass_matrix, potential_energy,
};
pub use kinematics::{Sight, body_to_ground, rotation, translation};
pub use lanes::{LANES, Lanes};
pub use layout::TetherLayout;
pub use linear::{Linearization, Variable, linearize};
pub use modes::{Mode, Modes, modes};
pub use motion::{Accelerations, accelerations};
pub use parameters::{
    AddedMass, Asymmetry, Body, FIELDS, Field, Fluid, HorizontalStabilizer, Hull, OPTIONAL_FIELDS, Parameters, Stall,
    Tether, VerticalStabilizer, Winch,
};
pub use plant::{Fidelity, FluidInertia, Lift, Plant};
pub use real::Real;
pub use stall::lift_coefficients;
pub use tensions::{Slack, Tensions};
pub use trim::{Trim, TrimRequest, trim, trim_with_lines};
