//! Claims about the physics and the mathematics of the plant.

#![expect(clippy::float_cmp, reason = "bit-for-bit claims compare numbers with ==")]

mod aerodynamics;
mod eigenmodes;
mod energy;
mod equations;
mod flows;
mod fuzz;
mod golden;
mod inputs;
mod limits;
mod linearization;
mod lines;
mod oracle;
mod plants;
mod scalars;
mod symmetry;
mod trims;
