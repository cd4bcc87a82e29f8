//! Pose after pose during a flight: noise, the last pose, and the delay.

use std::collections::VecDeque;

use bat_dynamics::LANES;
use tether_control::Measurement;

use super::bundle::Bundles;
use super::images::Shot;
use super::locate::{Hold, Search, locate};
use super::pose::Pose;
use super::view::{PixelNoise, View};
use super::viewer::Viewer;

/// What the controller is given at a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The pose, of an image as old as the delay: new or, with a `hold`, the last one.
    pub pose: Pose,
    /// How many dots were seen in that image by at least one camera.
    pub dots_seen: usize,
    /// How many cameras saw at least one dot.
    pub cameras_seeing: usize,
    /// Why the last pose is held, if it is.
    pub hold: Option<Hold>,
}

impl Estimate {
    /// What the controller takes of it.
    pub(crate) fn measurement(&self) -> Measurement {
        let Pose { roll_rad, pitch_rad, .. } = self.pose;
        Measurement { altitude_m: self.pose.altitude_m(), pitch_rad, roll_rad }
    }
}

/// The image processing of one flight.
///
/// Each image is fitted from the last pose found. The first pose is known: somebody put the body there.
#[derive(Clone, Debug)]
pub struct Tracker<'a> {
    viewer: &'a Viewer,
    noise: PixelNoise,
    view: View,
    shots: Vec<Shot>,
    bundles: Bundles,
    last: Option<Pose>,
    /// Images, and those of which no pose could be had.
    images: usize,
    held: usize,
    /// The cameras, by their place, that have seen no dot yet.
    blind: Vec<usize>,
    /// Estimates on their way to the controller, oldest first.
    on_the_way: VecDeque<Estimate>,
}

impl<'a> Tracker<'a> {
    /// A tracker at the start of a flight.
    #[must_use]
    pub fn new(viewer: &'a Viewer) -> Self {
        let on_the_way = VecDeque::with_capacity(viewer.delay_samples() + 1);
        let (noise, view) = (PixelNoise::new(viewer.seed()), View::default());
        let blind = (0..viewer.n_cameras()).collect();
        Self {
            viewer,
            noise,
            view,
            shots: Vec::new(),
            bundles: Bundles::default(),
            last: None,
            images: 0,
            held: 0,
            blind,
            on_the_way,
        }
    }

    /// Takes the images of a body at `truth` and returns the estimate that arrives at this sample.
    pub fn observe(&mut self, truth: &Pose) -> Estimate {
        self.look(truth);
        let idle = || Search::held(Hold::NotConverged);
        let mut searches = [self.search(), idle(), idle(), idle()];
        locate(&mut searches);
        let found = searches[0].found();
        self.conclude(found)
    }

    fn look(&mut self, truth: &Pose) {
        if self.last.is_none() {
            let start = Estimate { pose: *truth, dots_seen: 0, cameras_seeing: 0, hold: Some(Hold::NoImageYet) };
            self.on_the_way.extend(std::iter::repeat_n(start, self.viewer.delay_samples()));
            self.last = Some(*truth);
        }
        self.viewer.look_into(&mut self.shots, &mut self.view, truth, &mut self.noise);
    }

    /// The search for the pose of the last image.
    #[inline(always)]
    fn search(&mut self) -> Search<'_> {
        let guess = self.last.unwrap_or_default();
        self.viewer.search(&mut self.bundles, &self.view, &guess)
    }

    fn conclude(&mut self, found: Result<Pose, Hold>) -> Estimate {
        let (pose, hold) = match found {
            Ok(pose) => (pose, None),
            Err(hold) => (self.last.unwrap_or_default(), Some(hold)),
        };
        self.last = Some(pose);
        self.images += 1;
        self.held += usize::from(hold.is_some());
        if !self.blind.is_empty() {
            self.blind.retain(|camera| self.view.seen_by(*camera) == 0);
        }
        let cameras_seeing = self.view.cameras_seeing(self.viewer.n_cameras());
        let newest = Estimate { pose, dots_seen: self.view.dots_seen(), cameras_seeing, hold };
        self.on_the_way.push_back(newest);
        self.on_the_way.pop_front().unwrap_or(newest)
    }

    /// The share of the images so far of which no pose could be had, so that the last one was held; 0 before the first image.
    #[must_use]
    pub fn held_share(&self) -> f64 {
        self.held as f64 / self.images.max(1) as f64
    }

    /// The cameras that have seen no dot in any image so far, by their place in [`Sensing::cameras`](super::Sensing::cameras).
    #[must_use]
    pub fn blind_cameras(&self) -> &[usize] {
        &self.blind
    }
}

/// [`Tracker::observe`] of up to four flights, whose poses are sought side by side; without a tracker there is no estimate.
pub(crate) fn observe_abreast(trackers: &mut [Option<Tracker<'_>>], truths: &[Pose]) -> [Option<Estimate>; LANES] {
    let mut each = trackers.iter_mut();
    let mut four: [Option<&mut Tracker<'_>>; LANES] = core::array::from_fn(|_| each.next().and_then(Option::as_mut));
    for (tracker, truth) in four.iter_mut().zip(truths) {
        if let Some(tracker) = tracker {
            tracker.look(truth);
        }
    }
    let [a, b, c, d] = &mut four;
    let mut searches = [search(a), search(b), search(c), search(d)];
    locate(&mut searches);
    let [a, b, c, d] = &searches;
    let found = [a.found(), b.found(), c.found(), d.found()];
    let mut estimates = [None; LANES];
    for ((estimate, tracker), found) in estimates.iter_mut().zip(four).zip(found) {
        *estimate = tracker.map(|tracker| tracker.conclude(found));
    }
    estimates
}

#[inline(always)]
fn search<'b>(tracker: &'b mut Option<&mut Tracker<'_>>) -> Search<'b> {
    match tracker {
        Some(tracker) => tracker.search(),
        None => Search::held(Hold::NotConverged),
    }
}
