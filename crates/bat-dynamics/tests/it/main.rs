//! Claims about the physics and the mathematics of the plant.

mod energy;
mod equations;
mod golden;
mod oracle;
mod plants;
