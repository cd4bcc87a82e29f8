//! What a run of Chapter 6 found.

use anyhow::{Context as _, Result};

use super::campaigns::{Ended, Flown};
use super::file::{Case, Setup};
use super::flights::BeforeAfter;
use crate::reproduction::Extent;

/// The noise that pictures show, as a part of the range: the nearest of the file.
pub(crate) const SHOWN_NOISE: f64 = 0.03;

/// Everything that a run found.
#[derive(Debug)]
pub(crate) struct Findings {
    pub(crate) setup: Setup,
    pub(crate) extent: Extent,
    pub(crate) flown: Vec<Flown>,
    pub(crate) ended: Vec<Ended>,
    pub(crate) footprints: Vec<BeforeAfter>,
    pub(crate) seconds: f64,
}

impl Findings {
    /// The campaigns of the first variant in a space, noise by noise.
    pub(crate) fn main(&self, space: usize, truth: usize) -> Vec<&Ended> {
        let wanted = |case: Case| case.space == space && case.truth == truth && case.variant == 0;
        self.ended.iter().filter(|ended| wanted(ended.case)).collect()
    }

    /// The one of them that pictures show.
    pub(crate) fn shown(&self, space: usize, truth: usize) -> Result<&Ended> {
        let distance = |ended: &&Ended| (ended.case.noise - SHOWN_NOISE).abs();
        let main = self.main(space, truth).into_iter();
        main.min_by(|a, b| distance(a).total_cmp(&distance(b))).context("no campaign of the first variant")
    }

    /// The one that pictures show in each space with each truth.
    pub(crate) fn all_shown(&self) -> Result<Vec<&Ended>> {
        self.fields().map(|(space, truth)| self.shown(space, truth)).collect()
    }

    /// Every space with every truth.
    pub(crate) fn fields(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        (0..self.setup.spaces.len()).flat_map(|space| (0..self.setup.n_truths()).map(move |truth| (space, truth)))
    }

    /// A point with its units.
    pub(crate) fn point_words(&self, space: usize, point: &[f64]) -> String {
        self.setup.spaces[space].space.words(point)
    }
}
