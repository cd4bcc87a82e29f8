//! Sightings four side by side, as the normal equations take them.

use bat_dynamics::{LANES, Lanes};

use super::camera::Eye;
use super::dot::Mark;
use super::triple::Triple;
use super::view::Sighting;

/// Four sightings with all that is known of their dots and cameras.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bundle {
    /// The dots from the point of the pose, along B.
    pub(crate) place: Triple<Lanes>,
    pub(crate) eye: Eye<Lanes>,
    /// u and v as they were told.
    pub(crate) pixel: [Lanes; 2],
    /// 1, and 0 where the last bundle is filled up with a sighting that counts already.
    pub(crate) weight: Lanes,
}

/// Writes `sightings` into `bundles`, which keeps its memory.
#[inline(always)]
pub(crate) fn bundle(bundles: &mut Vec<Bundle>, eyes: &[Eye], marks: &[Mark], sightings: &[Sighting]) {
    bundles.clear();
    let n = sightings.len();
    let mut from = 0;
    while from < n {
        let at = |k: usize| sightings[if from + k < n { from + k } else { n - 1 }];
        let counts = |k: usize| if from + k < n { 1.0 } else { 0.0 };
        let seen = [at(0), at(1), at(2), at(3)];
        bundles.push(of_four(eyes, marks, &seen, Lanes([counts(0), counts(1), counts(2), counts(3)])));
        from += LANES;
    }
}

/// Written out: `array::map` is not inlined here, and would take longer than all the rest.
#[inline(always)]
fn of_four(eyes: &[Eye], marks: &[Mark], seen: &[Sighting; LANES], weight: Lanes) -> Bundle {
    let [a, b, c, d] = seen;
    let [e, f, g, h] = [&eyes[a.camera], &eyes[b.camera], &eyes[c.camera], &eyes[d.camera]];
    Bundle {
        place: abreast(&marks[a.dot].place, &marks[b.dot].place, &marks[c.dot].place, &marks[d.dot].place),
        eye: Eye {
            position: abreast(&e.position, &f.position, &g.position, &h.position),
            ahead: abreast(&e.ahead, &f.ahead, &g.ahead, &h.ahead),
            right: abreast(&e.right, &f.right, &g.right, &h.right),
            below: abreast(&e.below, &f.below, &g.below, &h.below),
            focal_px: Lanes([e.focal_px, f.focal_px, g.focal_px, h.focal_px]),
            center_px: [
                Lanes([e.center_px[0], f.center_px[0], g.center_px[0], h.center_px[0]]),
                Lanes([e.center_px[1], f.center_px[1], g.center_px[1], h.center_px[1]]),
            ],
        },
        pixel: [
            Lanes([a.pixel[0], b.pixel[0], c.pixel[0], d.pixel[0]]),
            Lanes([a.pixel[1], b.pixel[1], c.pixel[1], d.pixel[1]]),
        ],
        weight,
    }
}

/// Four vectors side by side.
#[inline(always)]
fn abreast(a: &Triple, b: &Triple, c: &Triple, d: &Triple) -> Triple<Lanes> {
    [Lanes([a[0], b[0], c[0], d[0]]), Lanes([a[1], b[1], c[1], d[1]]), Lanes([a[2], b[2], c[2], d[2]])]
}
