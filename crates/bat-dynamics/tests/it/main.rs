//! Claims about the physics and the mathematics of the plant.

#![expect(clippy::float_cmp, reason = "bit-for-bit claims compare numbers with ==")]

mod aerodynamics;
mod eigenmodes;
mod energy;
mod equations;
mod golden;
mod limits;
mod linearization;
mod lines;
mod oracle;
mod plants;
mod symmetry;
mod trims;
