//! Cameras, dots and what is imperfect about them: the `[sensing]` of a rig.

use super::camera::Camera;
use super::dot::Dot;

/// How a rig sees its body.
///
/// Values are public: they are checked by [`Viewer::new`](super::Viewer::new), where a flight begins.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensing {
    /// The cameras, at least one.
    pub cameras: Vec<Camera>,
    /// The dots, at least four.
    pub dots: Vec<Dot>,
    /// Standard deviation of the normal error of u and of v of every sighting, independent of each other.
    pub pixel_noise_px: f64,
    /// Pixels are reported in the middle of steps of this size: 1 for whole pixels, less where dots are found within a pixel, 0 for exact.
    pub quantization_px: f64,
    /// How many samples pass between an image and the pose that the controller gets of it.
    pub delay_samples: usize,
    /// The same seed gives the same noise; a flight uses nothing else for it.
    pub seed: u64,
}

impl Sensing {
    /// Standard deviation of u and v, in px, from noise and quantization together: `sqrt(noise² + q²/12)`.
    ///
    /// An error that is uniform over a step q has the variance q²/12; that holds where pixels are spread over several
    /// steps or the noise is no less than about half a step.
    #[must_use]
    pub fn pixel_deviation_px(&self) -> f64 {
        (self.pixel_noise_px.powi(2) + self.quantization_px.powi(2) / 12.0).sqrt()
    }
}
