//! Cameras and dots, checked: what they show of a pose, and the pose that fits what they show.

use nalgebra::{Matrix3, Matrix6};

use super::arrangement::Sensing;
use super::bundle::Bundles;
use super::dot::marks;
use super::images::{self, Images, Shot};
use super::locate::{FEWEST_DOTS, Hold, Search, locate};
use super::normal_equations::Shares;
use super::pose::Pose;
use super::view::{PixelNoise, View};
use crate::error::Error;

/// Largest delay in samples.
const LONGEST_DELAY: usize = 10_000;

/// Cameras and dots ready for use.
///
/// # Which dots are seen
/// A camera sees a dot if the dot lies ahead of it, falls in its region of interest before noise, and faces it: with n the
/// dot's outward normal, `n · (camera − dot) > 0`. That is the whole rule of occlusion: the hull is taken as convex, and
/// fins, lines and rotor hide nothing.
#[derive(Clone, Debug)]
pub struct Viewer {
    images: Images,
    /// Of the cameras, in their order.
    names: Vec<String>,
    delay_samples: usize,
    seed: u64,
}

impl Viewer {
    /// Cameras and dots for poses of the point `reference_m` of the body, from the bridle joint along B in m.
    ///
    /// # Errors
    /// [`Error::Sensing`] for no camera, fewer than four dots, two dots in one place, a normal of zero, a focal length or
    /// image without size, a region of interest that leaves the image, negative noise or quantization, a delay of more
    /// than 10,000 samples, and any number that is not finite.
    pub fn new(sensing: &Sensing, reference_m: [f64; 3]) -> Result<Self, Error> {
        let refuse =
            |field: &str, value: String, expected| Err(Error::Sensing { field: field.to_owned(), value, expected });
        let Sensing { cameras, dots, pixel_noise_px, quantization_px, delay_samples, seed } = sensing;
        if cameras.is_empty() {
            return refuse("camera", "none".to_owned(), "at least one camera");
        }
        if dots.len() < FEWEST_DOTS {
            return refuse("dot", format!("{} dots", dots.len()), "at least 4 dots, since fewer leave the pose open");
        }
        for (name, value) in [("pixel_noise", *pixel_noise_px), ("quantization", *quantization_px)] {
            if !(value.is_finite() && value >= 0.0) {
                return refuse(name, format!("{value} px"), "finite and zero or more");
            }
        }
        if *delay_samples > LONGEST_DELAY {
            return refuse("delay", format!("{delay_samples} samples"), "a whole number from 0 to 10000");
        }
        Ok(Self {
            images: Images::new(cameras, marks(dots, reference_m)?, *pixel_noise_px, *quantization_px)?,
            names: cameras.iter().map(|camera| camera.name.clone()).collect(),
            delay_samples: *delay_samples,
            seed: *seed,
        })
    }

    /// What the cameras report of a body at `pose`, noise and quantization included.
    ///
    /// A camera that sees no dot adds nothing, and no camera need see any. Two numbers are drawn from `noise` per sighting.
    #[must_use]
    pub fn look(&self, pose: &Pose, noise: &mut PixelNoise) -> View {
        let mut view = View::default();
        self.look_into(&mut Vec::new(), &mut view, pose, noise);
        view
    }

    /// [`Viewer::look`] into the memory of a view, with that of shots.
    pub(crate) fn look_into(&self, shots: &mut Vec<Shot>, view: &mut View, pose: &Pose, noise: &mut PixelNoise) {
        images::take(&self.images, shots, view, pose, noise);
    }

    /// The pose whose pixels are closest to those of `view` in the sense of least squares, sought from `guess`.
    ///
    /// All sightings weigh the same. Seen from `guess` no dot of the view may be behind its camera.
    ///
    /// # Errors
    /// [`Hold`] where there is none, and with sightings of a dot or camera that does not exist.
    pub fn locate(&self, view: &View, guess: &Pose) -> Result<Pose, Hold> {
        if !self.knows(view) {
            return Err(Hold::NotConverged);
        }
        let mut bundles = Bundles::default();
        let alone = self.search(&mut bundles, view, guess);
        let idle = || Search::held(Hold::NotConverged);
        let mut searches = [alone, idle(), idle(), idle()];
        locate(&mut searches);
        searches[0].found()
    }

    /// The search of [`Viewer::locate`] for a view of this viewer, with the memory of earlier ones.
    #[inline(always)]
    pub(crate) fn search<'b>(&self, bundles: &'b mut Bundles, view: &View, guess: &Pose) -> Search<'b> {
        if view.dots_seen() < FEWEST_DOTS {
            return Search::held(Hold::TooFewDots);
        }
        Search::new(bundles.take(&self.images.eyes, &self.images.marks, view.sightings()), guess)
    }

    /// Covariance of x, y, z in m and roll, pitch, heading in rad at `pose`, from `view` with pixels of the standard
    /// deviation `deviation_px`: `deviation² (Jᵀ J)⁻¹`.
    ///
    /// `None` where the dots seen leave the pose open.
    #[must_use]
    pub fn covariance(&self, view: &View, pose: &Pose, deviation_px: f64) -> Option<Matrix6<f64>> {
        if !self.knows(view) {
            return None;
        }
        let (mut bundles, attitude) = (Bundles::default(), pose.attitude());
        let bundles = bundles.take(&self.images.eyes, &self.images.marks, view.sightings());
        let of_turns = Shares::new(bundles, pose.position_m, &attitude.rows_gb())?.inverse()?;
        if attitude.has_angles() <= 0.0 {
            return None;
        }
        let mut to_angles = Matrix6::identity();
        let rows = attitude.angles_of_turn();
        to_angles.fixed_view_mut::<3, 3>(3, 3).copy_from(&Matrix3::from_fn(|i, j| rows[i][j]));
        Some(to_angles * of_turns * to_angles.transpose() * (deviation_px * deviation_px))
    }

    fn knows(&self, view: &View) -> bool {
        view.sightings().iter().all(|seen| seen.dot < self.images.marks.len() && seen.camera < self.n_cameras())
    }

    /// How many cameras there are.
    #[must_use]
    pub fn n_cameras(&self) -> usize {
        self.images.eyes.len()
    }

    /// That cameras and dots, without noise and quantization, give a pose of a body at `start`.
    pub(crate) fn check_start(&self, start: &Pose) -> Result<(), Error> {
        let mut view = View::default();
        images::take(&self.images.exact(), &mut Vec::new(), &mut view, start, &mut PixelNoise::new(self.seed));
        let Err(hold) = self.locate(&view, start) else { return Ok(()) };
        let seen_by = self.names.iter().enumerate().map(|(camera, name)| (name.clone(), view.seen_by(camera)));
        Err(Error::NoFirstPose {
            reason: hold.to_string(),
            dots_seen: view.dots_seen(),
            dots: self.images.marks.len(),
            seen_by: seen_by.collect(),
        })
    }

    pub(crate) fn delay_samples(&self) -> usize {
        self.delay_samples
    }

    pub(crate) fn seed(&self) -> u64 {
        self.seed
    }
}
