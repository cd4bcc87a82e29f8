//! Cameras, dots and the pose that follows from them: what a controller knows of the body where it does not see the state.
//!
//! The rig of the dissertation has three cameras, dots on the hull, and a computer that turns images into position and
//! attitude at every sample (Sections 2.2 and 7.2.4). It prints no number of them; the model here is the plainest one that
//! has their faults: noise, whole pixels, dots out of sight, delay.
//!
//! - A camera is a pinhole, [`Camera`]; a dot is a place on the hull with the direction in which it faces, [`Dot`].
//! - [`Viewer`] says which dots are seen and where ([`Viewer::look`]), and which pose fits them best ([`Viewer::locate`]).
//! - [`Tracker`] does both once a sample, with what a flight has to remember: noise, last pose, delay.

mod arrangement;
mod bundle;
mod camera;
mod dot;
mod images;
mod locate;
mod normal_equations;
mod pose;
mod table;
mod tracker;
mod triple;
mod view;
mod viewer;

pub use arrangement::Sensing;
pub use camera::{Camera, Region};
pub use dot::Dot;
pub use locate::Hold;
pub use pose::Pose;
pub use table::SensingFile;
pub(crate) use table::SensingTable;
pub(crate) use tracker::observe_abreast;
pub use tracker::{Estimate, Tracker};
pub use view::{PixelNoise, Sighting, View};
pub use viewer::Viewer;
