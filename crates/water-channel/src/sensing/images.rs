//! From a pose to what the cameras report of it: four dots side by side, camera after camera.
//!
//! Loops are over indices: iterators are not inlined here, and take longer than the rest.

use bat_dynamics::{LANES, Lanes, Real};
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
    frames: Vec<Frame>,
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
            frames: cameras.iter().map(|camera| Frame::new(&camera.region)).collect(),
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

    /// Makes of exact pixels what the image processing reports: noise first, then the middle of a step.
    #[inline(always)]
    fn report(&self, sightings: &mut [Sighting], noise: &mut PixelNoise) {
        if self.noise_px > 0.0 {
            noise.add_to(sightings, self.noise_px);
        }
        if self.step_px > 0.0 {
            for sighting in sightings {
                let [u, v] = sighting.pixel;
                sighting.pixel = [
                    self.step_px * ((u / self.step_px).floor() + 0.5),
                    self.step_px * ((v / self.step_px).floor() + 0.5),
                ];
            }
        }
    }
}

/// Four dots as one camera has them, before noise.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shot {
    pixel: [Lanes; 2],
    /// 1, and 0 for a dot that is not seen.
    is_seen: Lanes,
}

/// A region of interest four times over: smallest and largest u, then v, each by the last number outside.
#[derive(Clone, Copy, Debug)]
struct Frame([[Lanes; 2]; 2]);

impl Frame {
    fn new(region: &Region) -> Self {
        let between = |from: f64, to: f64| [Lanes::constant(from.next_down()), Lanes::constant(to.next_up())];
        Self([between(region.left_px, region.right_px), between(region.top_px, region.bottom_px)])
    }
}

/// `so_far` where `low < high`, and 0 elsewhere.
#[inline(always)]
fn and_below(so_far: Lanes, low: Lanes, high: Lanes) -> Lanes {
    low.select_below(high, so_far, Lanes::constant(0.0))
}

#[inline(always)]
fn shot(eye: &Eye<Lanes>, frame: &Frame, place: Triple<Lanes>, normal: Triple<Lanes>) -> Shot {
    let zero = Lanes::constant(0.0);
    let faces = dot_product(normal, minus(eye.position, place));
    let seen = eye.project(place);
    let mut is_seen = and_below(and_below(Lanes::constant(1.0), zero, faces), zero, seen.depth);
    for axis in 0..2 {
        let [outside, beyond] = frame.0[axis];
        is_seen = and_below(and_below(is_seen, outside, seen.pixel[axis]), seen.pixel[axis], beyond);
    }
    Shot { pixel: seen.pixel, is_seen }
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
            shots.push(shot(&images.wide[camera], &images.frames[camera], place, normal));
        }
        let first = four * LANES;
        for lane in 0..LANES.min(images.marks.len() - first) {
            for (camera, shot) in shots.iter().enumerate() {
                if shot.is_seen.0[lane] > 0.0 {
                    let pixel = [shot.pixel[0].0[lane], shot.pixel[1].0[lane]];
                    view.push(Sighting { dot: first + lane, camera, pixel });
                }
            }
        }
    }
    images.report(view.sightings_mut(), noise);
}
