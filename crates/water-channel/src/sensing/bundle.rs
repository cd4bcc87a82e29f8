//! Sightings four side by side, as the normal equations take them.

use bat_dynamics::{LANES, Lanes};

use super::camera::Eye;
use super::dot::Mark;
use super::triple::{Triple, abreast};
use super::view::Sighting;

/// Four sightings with all that is known of their dots and cameras.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bundle {
    /// The dots from the point of the pose, along B.
    pub(crate) place: Triple<Lanes>,
    pub(crate) eye: Eye<Lanes>,
    /// u and v as they were reported.
    pub(crate) pixel: [Lanes; 2],
    /// 1, and 0 where the last bundle is filled up with a sighting that counts already.
    pub(crate) weight: Lanes,
    /// Whether all four count.
    pub(crate) is_full: bool,
}

/// The sightings of an image four side by side, with the memory of the image before.
#[derive(Clone, Debug, Default)]
pub(crate) struct Bundles {
    list: Vec<Bundle>,
    /// Dot and camera of each sighting.
    of: Vec<(usize, usize)>,
}

impl Bundles {
    /// The bundles of these sightings, by the eyes and marks that all earlier ones were by. Where the same cameras see the same
    /// dots as before, which is what most images show, only the pixels are new.
    #[inline(always)]
    pub(crate) fn take(&mut self, eyes: &[Eye], marks: &[Mark], sightings: &[Sighting]) -> &[Bundle] {
        let mut as_before = self.of.len() == sightings.len();
        for (before, seen) in self.of.iter().zip(sightings) {
            as_before &= *before == (seen.dot, seen.camera);
        }
        if !as_before {
            self.of.clear();
            self.of.extend(sightings.iter().map(|sighting| (sighting.dot, sighting.camera)));
            self.list.clear();
            self.list.extend(sightings.chunks(LANES).map(|four| of_four(eyes, marks, four)));
        }
        let (fours, rest) = sightings.as_chunks::<LANES>();
        for (bundle, [a, b, c, d]) in self.list.iter_mut().zip(fours) {
            bundle.pixel = pixels([a, b, c, d]);
        }
        if let (Some(bundle), true) = (self.list.last_mut(), !rest.is_empty()) {
            bundle.pixel = pixels(filled_up(rest));
        }
        &self.list
    }
}

/// Written out here and below: `array::map` is not inlined, and would take longer than all the rest.
#[inline(always)]
fn pixels([a, b, c, d]: [&Sighting; LANES]) -> [Lanes; 2] {
    [Lanes([a.pixel[0], b.pixel[0], c.pixel[0], d.pixel[0]]), Lanes([a.pixel[1], b.pixel[1], c.pixel[1], d.pixel[1]])]
}

/// Up to four of something, and the last of them in the place of each that is missing.
#[inline(always)]
pub(crate) fn filled_up<T>(four: &[T]) -> [&T; LANES] {
    let at = |k: usize| &four[if k < four.len() { k } else { four.len() - 1 }];
    [at(0), at(1), at(2), at(3)]
}

#[inline(always)]
fn of_four(eyes: &[Eye], marks: &[Mark], four: &[Sighting]) -> Bundle {
    let [a, b, c, d] = filled_up(four);
    let counts = |k: usize| if k < four.len() { 1.0 } else { 0.0 };
    Bundle {
        place: abreast(&marks[a.dot].place, &marks[b.dot].place, &marks[c.dot].place, &marks[d.dot].place),
        eye: eyes_abreast(&[&eyes[a.camera], &eyes[b.camera], &eyes[c.camera], &eyes[d.camera]]),
        pixel: pixels([a, b, c, d]),
        weight: Lanes([counts(0), counts(1), counts(2), counts(3)]),
        is_full: four.len() == LANES,
    }
}

/// Four cameras side by side.
#[inline(always)]
pub(crate) fn eyes_abreast(&[e, f, g, h]: &[&Eye; LANES]) -> Eye<Lanes> {
    Eye {
        position: abreast(&e.position, &f.position, &g.position, &h.position),
        ahead: abreast(&e.ahead, &f.ahead, &g.ahead, &h.ahead),
        right: abreast(&e.right, &f.right, &g.right, &h.right),
        below: abreast(&e.below, &f.below, &g.below, &h.below),
        focal_px: Lanes([e.focal_px, f.focal_px, g.focal_px, h.focal_px]),
        center_px: [
            Lanes([e.center_px[0], f.center_px[0], g.center_px[0], h.center_px[0]]),
            Lanes([e.center_px[1], f.center_px[1], g.center_px[1], h.center_px[1]]),
        ],
    }
}

/// Four dots side by side.
pub(crate) fn marks_abreast(&[a, b, c, d]: &[&Mark; LANES]) -> Mark<Lanes> {
    Mark {
        place: abreast(&a.place, &b.place, &c.place, &d.place),
        normal: abreast(&a.normal, &b.normal, &c.normal, &d.normal),
    }
}
