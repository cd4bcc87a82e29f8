//! Claims about the physics and the mathematics of the plant.

mod equations;
mod golden;
mod plants;
