//! What the cameras saw in one sample: sightings, and the noise in them.

use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;

/// A dot as one camera reported it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sighting {
    /// The place of the dot in [`Sensing::dots`](super::Sensing::dots).
    pub dot: usize,
    /// The place of the camera in [`Sensing::cameras`](super::Sensing::cameras).
    pub camera: usize,
    /// u and v, in px from the upper left corner of the image.
    pub pixel: [f64; 2],
}

/// All sightings of one sample, sorted by dot and then by camera.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct View {
    sightings: Vec<Sighting>,
    dots_seen: usize,
}

impl View {
    /// A view of these sightings, from wherever they come.
    #[must_use]
    pub fn new(mut sightings: Vec<Sighting>) -> Self {
        sightings.sort_by_key(|sighting| (sighting.dot, sighting.camera));
        let mut view = Self::default();
        sightings.into_iter().for_each(|sighting| view.push(sighting));
        view
    }

    /// The sightings.
    #[must_use]
    pub fn sightings(&self) -> &[Sighting] {
        &self.sightings
    }

    /// How many dots at least one camera sees.
    #[must_use]
    pub fn dots_seen(&self) -> usize {
        self.dots_seen
    }

    /// How many dots the camera of this index sees; a camera may well see none.
    #[must_use]
    pub fn seen_by(&self, camera: usize) -> usize {
        self.sightings.iter().filter(|sighting| sighting.camera == camera).count()
    }

    /// How many of the first `n_cameras` cameras see at least one dot.
    pub(crate) fn cameras_seeing(&self, n_cameras: usize) -> usize {
        let sees = |camera: &usize| self.sightings.iter().any(|sighting| sighting.camera == *camera);
        (0..n_cameras).filter(sees).count()
    }

    pub(crate) fn sightings_mut(&mut self) -> &mut [Sighting] {
        &mut self.sightings
    }

    /// Forgets all sightings and keeps their memory.
    pub(crate) fn clear(&mut self) {
        self.sightings.clear();
        self.dots_seen = 0;
    }

    /// Adds a sighting that comes after all others in the order of a view.
    #[inline(always)]
    pub(crate) fn push(&mut self, sighting: Sighting) {
        let is_new = self.sightings.last().is_none_or(|last| last.dot != sighting.dot);
        self.dots_seen += usize::from(is_new);
        self.sightings.push(sighting);
    }
}

/// The errors of pixels, one after the other from a seed.
#[derive(Clone, Debug)]
pub struct PixelNoise {
    generator: Pcg64,
}

impl PixelNoise {
    /// The errors that belong to `seed`.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self { generator: Pcg64::seed_from_u64(seed) }
    }

    /// Adds normal numbers of mean 0 and the standard deviation `deviation_px` to u and v of one sighting after the other.
    #[inline(always)]
    pub(crate) fn add_to(&mut self, sightings: &mut [Sighting], deviation_px: f64) {
        // Not by reference: within this loop the generator stays in registers.
        let mut generator = self.generator.clone();
        for sighting in sightings {
            for pixel in &mut sighting.pixel {
                let number: f64 = StandardNormal.sample(&mut generator);
                *pixel += deviation_px * number;
            }
        }
        self.generator = generator;
    }
}
