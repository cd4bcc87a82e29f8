//! Under which names curves are kept, and what is kept of them over all plants.

use crate::chapter3;
use crate::chapter6::{self, Case};
use crate::ensemble::kept;
use crate::ensemble::row::{Method, Study, World};

/// Iterations of Chapter 6 that are kept.
pub(super) const ITERATIONS: [usize; 10] = [1, 2, 3, 5, 8, 12, 16, 22, 28, 33];
/// Errors of the heading are kept as the largest of so many seconds.
pub(in crate::ensemble) const BIN_S: f64 = 5.0;
/// The norm (42) of the error of the corrected model, as a share of that without correction.
pub(super) const ERROR: &str = "error";
/// The largest error of the corrected model, as a share of that without correction.
pub(super) const LARGEST: &str = "largest";
/// Share of the space after an iteration.
pub(super) const LEFT: &str = "left";

/// The places along the center of mass that Table 4 allows, with their numbers.
pub(super) fn places_in_table4(study: &chapter3::Setup) -> Vec<(usize, f64)> {
    let all = study.center_of_mass.places().into_iter().enumerate();
    all.filter(|(_, x)| chapter3::is_allowed(study, *x)).collect()
}

/// The lowest cost of Figure 14 in a panel at a place along the center of mass.
pub(super) fn of_place(panel: usize, place: usize) -> String {
    format!("panel {}/place {place}", panel + 1)
}

/// The cases of Chapter 6 that Figure 21 shows.
pub(super) fn cases_of_figure21(study: &chapter6::Setup) -> impl Iterator<Item = Case> {
    study
        .cases()
        .into_iter()
        .filter(|case| case.variant == 0 && study.spaces[case.space].space.region().n_parameters() == 2)
}

/// What an iteration of Figure 21 shows.
pub(super) fn of_iteration(study: &chapter6::Setup, case: Case, iteration: usize, what: &str) -> String {
    format!("{}/noise {}/iteration {iteration}/{what}", study.truth(case.truth).short, case.noise)
}

/// Designs that nobody chose that are flown before a camera.
pub(super) const N_RANDOM: usize = 16;

/// Share of the images of which no pose could be had, with so many pixels to spare, for the design of a seed.
pub(super) fn of_held(method: Method, seed: u64, margin_px: f64) -> String {
    format!("{}/{seed}/margin {margin_px} px/held", method.name())
}

/// A margin that leaves the whole image: what is lost there is not lost because of a region.
pub(super) const WHOLE_IMAGE: f64 = f64::INFINITY;

/// The largest error of the heading that was reported, in deg, in a bin of time.
pub(super) fn of_bin(method: Method, bin: usize) -> String {
    format!("{}/heading/{bin}", method.name())
}

/// A fact of all plants that have it, finite.
pub(super) fn over(cases: &[kept::Case<'_>], study: Study, world: World, name: &str) -> Vec<f64> {
    let mine = cases.iter().filter(|case| case.study == study && case.world == world);
    mine.filter_map(|case| case.fact(name)).filter(|value| value.is_finite()).collect()
}
