//! From a pose to what the cameras tell of it: four dots side by side, camera after camera.
//!
//! Loops are over indices: iterators are not inlined here, and take longer than the rest.

use bat_dynamics::{LANES, Lanes};
use multiversion::multiversion;

use super::bundle::{eyes_abreast, filled_up, marks_abreast};
use super::camera::{Camera, Eye, Region};
use super::dot::Mark;
use super::pose::Pose;
use super::triple::{Triple, add, constant, dot as dot_product, minus, times};
use super::view::{PixelNoise, Sighting, View};
use crate::error::Error;

/// Cameras, dots, and the faults of pixels.
#[derive(Clone, Debug)]
pub(crate) struct Images {
    pub(crate) eyes: Vec<Eye>,
    /// Each eye four times over.
    wide: Vec<Eye<Lanes>>,
    regions: Vec<Region>,
    pub(crate) marks: Vec<Mark>,
    /// The marks four by four; the last four are filled up with the last mark.
    fours: Vec<Mark<Lanes>>,
    noise_px: f64,
    step_px: f64,
}

impl Images {
    /// Of these cameras, each checked.
    pub(crate) fn new(cameras: &[Camera], marks: Vec<Mark>, noise_px: f64, step_px: f64) -> Result<Self, Error> {
        let eyes: Vec<Eye> =
            cameras.iter().enumerate().map(|(index, camera)| camera.eye(index)).collect::<Result<_, _>>()?;
        Ok(Self {
            wide: eyes.iter().map(|eye| eyes_abreast(&[eye; LANES])).collect(),
            eyes,
            regions: cameras.iter().map(|camera| camera.region).collect(),
            fours: marks.chunks(LANES).map(|four| marks_abreast(&filled_up(four))).collect(),
            marks,
            noise_px,
            step_px,
        })
    }

    /// The same without noise and quantization.
    pub(crate) fn exact(&self) -> Self {
        Self { noise_px: 0.0, step_px: 0.0, ..self.clone() }
    }

    /// Makes of exact pixels what the image processing tells: noise first, then the middle of a step.
    #[inline(always)]
    fn tell(&self, sightings: &mut [Sighting], noise: &mut PixelNoise) {
        if self.noise_px > 0.0 {
            noise.add_to(sightings, self.noise_px);
        }
        if self.step_px > 0.0 {
            for sighting in sightings {
                let [u, v] = sighting.pixel;
                sighting.pixel =
                    [self.step_px * ((u / self.step_px).floor() + 0.5), self.step_px * ((v / self.step_px).floor() + 0.5)];
            }
        }
    }
}

/// Four dots as one camera has them, before noise.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shot {
    pixel: [Lanes; 2],
    is_seen: [bool; LANES],
}

#[inline(always)]
fn shot(eye: &Eye<Lanes>, region: &Region, place: Triple<Lanes>, normal: Triple<Lanes>) -> Shot {
    let faces = dot_product(normal, minus(eye.position, place)).0;
    let seen = eye.project(place);
    let (depth, [u, v]) = (seen.depth.0, seen.pixel);
    let mut is_seen = [false; LANES];
    for lane in 0..LANES {
        is_seen[lane] = (faces[lane] > 0.0) & (depth[lane] > 0.0) & region.contains([u.0[lane], v.0[lane]]);
    }
    Shot { pixel: [u, v], is_seen }
}

/// Fills `view` with what is seen of a body at `pose`; `shots` is memory.
///
/// Compiled for several instruction sets, none of which contracts a product and a sum: all give the same bits. Rounding down is one
/// instruction in two of them, and a call in the oldest.
#[multiversion(targets("x86_64+avx+avx2"))]
pub(crate) fn take(images: &Images, shots: &mut Vec<Shot>, view: &mut View, pose: &Pose, noise: &mut PixelNoise) {
    view.clear();
    let rows = pose.rows_gb();
    let r_gb: [Triple<Lanes>; 3] = [constant(rows[0]), constant(rows[1]), constant(rows[2])];
    let position = constant(pose.position_m);
    for four in 0..images.fours.len() {
        let mark = &images.fours[four];
        let place = add(position, times(&r_gb, mark.place));
        let normal = times(&r_gb, mark.normal);
        shots.clear();
        for camera in 0..images.wide.len() {
            shots.push(shot(&images.wide[camera], &images.regions[camera], place, normal));
        }
        let first = four * LANES;
        for lane in 0..LANES.min(images.marks.len() - first) {
            for camera in 0..shots.len() {
                let shot = &shots[camera];
                if shot.is_seen[lane] {
                    let pixel = [shot.pixel[0].0[lane], shot.pixel[1].0[lane]];
                    view.push(Sighting { dot: first + lane, camera, pixel });
                }
            }
        }
    }
    images.tell(view.sightings_mut(), noise);
}
