//! From a pose to what the cameras tell of it: four cameras side by side, dot after dot.
//!
//! Loops are over indices: iterators are not inlined here, and take longer than the rest.

use bat_dynamics::{LANES, Lanes};
use multiversion::multiversion;

use super::bundle::{eyes_abreast, filled_up};
use super::camera::{Camera, Eye, Region};
use super::dot::Mark;
use super::pose::Pose;
use super::triple::{add, constant, dot as dot_product, minus, times};
use super::view::{PixelNoise, Sighting, View};
use crate::error::Error;

/// Cameras, dots, and the faults of pixels.
#[derive(Clone, Debug)]
pub(crate) struct Images {
    pub(crate) eyes: Vec<Eye>,
    /// The eyes four by four; the last four are filled up with the last eye.
    fours: Vec<Eye<Lanes>>,
    regions: Vec<Region>,
    pub(crate) marks: Vec<Mark>,
    noise_px: f64,
    step_px: f64,
}

impl Images {
    /// Of these cameras, each checked.
    pub(crate) fn new(cameras: &[Camera], marks: Vec<Mark>, noise_px: f64, step_px: f64) -> Result<Self, Error> {
        let eyes: Vec<Eye> =
            cameras.iter().enumerate().map(|(index, camera)| camera.eye(index)).collect::<Result<_, _>>()?;
        let fours = eyes.chunks(LANES).map(|four| eyes_abreast(&filled_up(four))).collect();
        Ok(Self {
            eyes,
            fours,
            regions: cameras.iter().map(|camera| camera.region).collect(),
            marks,
            noise_px,
            step_px,
        })
    }

    /// The same without noise and quantization.
    pub(crate) fn exact(&self) -> Self {
        Self { noise_px: 0.0, step_px: 0.0, ..self.clone() }
    }

    /// A pixel as the image processing tells it: noise first, then the middle of a step.
    #[inline(always)]
    fn told(&self, exact_px: [f64; 2], noise: &mut PixelNoise) -> [f64; 2] {
        let mut told = exact_px;
        if self.noise_px > 0.0 {
            told[0] += self.noise_px * noise.draw();
            told[1] += self.noise_px * noise.draw();
        }
        if self.step_px > 0.0 {
            told[0] = self.step_px * ((told[0] / self.step_px).floor() + 0.5);
            told[1] = self.step_px * ((told[1] / self.step_px).floor() + 0.5);
        }
        told
    }
}

/// Fills `view` with what is seen of a body at `pose`.
///
/// Compiled for several instruction sets, none of which contracts a product and a sum: all give the same bits. Rounding down is one
/// instruction in two of them, and a call in the oldest.
#[multiversion(targets("x86_64+avx+avx2"))]
pub(crate) fn take(images: &Images, view: &mut View, pose: &Pose, noise: &mut PixelNoise) {
    view.clear();
    let r_gb = pose.rows_gb();
    for dot in 0..images.marks.len() {
        let mark = &images.marks[dot];
        let place = constant(add(pose.position_m, times(&r_gb, mark.place)));
        let normal = constant(times(&r_gb, mark.normal));
        for four in 0..images.fours.len() {
            let (eyes, first) = (&images.fours[four], four * LANES);
            let faces: Lanes = dot_product(normal, minus(eyes.position, place));
            let seen = eyes.project(place);
            for lane in 0..LANES {
                let camera = first + lane;
                if camera >= images.regions.len() {
                    break;
                }
                let pixel = [seen.pixel[0].0[lane], seen.pixel[1].0[lane]];
                if faces.0[lane] > 0.0 && seen.depth.0[lane] > 0.0 && images.regions[camera].contains(pixel) {
                    view.push(Sighting { dot, camera, pixel: images.told(pixel, noise) });
                }
            }
        }
    }
}
