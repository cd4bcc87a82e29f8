//! The campaigns of Chapter 6, on costs that are known at every cell.

use anyhow::{Context as _, Result};
use infuse::global;
use rayon::prelude::*;

use super::file::{Case, Setup};
use crate::bat::MODEL;
use crate::gridded::{Accuracy, Designs, FlownGrid, StandInRig};

/// A space with its cost at every cell.
#[derive(Debug)]
pub(crate) struct Flown {
    pub(crate) model: FlownGrid,
    pub(crate) truths: Vec<FlownGrid>,
}

/// A campaign that has ended, beside the truth.
#[derive(Debug)]
pub(crate) struct Ended {
    pub(crate) case: Case,
    pub(crate) campaign: global::Loop,
    pub(crate) accuracy: Accuracy,
}

pub(crate) fn fly(setup: &Setup, done: impl Fn(usize) + Sync) -> Result<Vec<Flown>> {
    let each = setup.spaces.iter().map(|space| {
        let fly = |fidelity| FlownGrid::fly(&space.bat, &space.space, fidelity, &done);
        let truths = (0..setup.n_truths()).map(|truth| fly(setup.truth(truth).fidelity()));
        Ok(Flown { model: fly(MODEL)?, truths: truths.collect::<Result<_>>()? })
    });
    each.collect()
}

/// What the campaigns of the study are made from.
pub(crate) struct Campaigns<'a> {
    pub(crate) setup: &'a Setup,
    pub(crate) flown: &'a [Flown],
    pub(crate) designs: &'a Designs,
}

impl Campaigns<'_> {
    /// Runs them side by side, in their order.
    pub(crate) fn run(&self, cases: &[Case], iterated: impl Fn(usize) + Sync) -> Result<Vec<Ended>> {
        for case in cases {
            self.rig(*case).prepare(&self.setup.settings(*case)?, self.designs)?;
        }
        cases.par_iter().map(|case| self.run_one(*case, &iterated).with_context(|| self.setup.words(*case))).collect()
    }

    pub(crate) fn rig(&self, case: Case) -> StandInRig<'_> {
        let (space, flown) = (&self.setup.spaces[case.space].space, &self.flown[case.space]);
        let (model, truth) = (&flown.model, &flown.truths[case.truth]);
        StandInRig { space, model, truth, noise: case.noise, seed: self.setup.file.noise.seed }
    }

    pub(crate) fn run_one(&self, case: Case, iterated: impl Fn(usize)) -> Result<Ended> {
        let campaign = self.rig(case).run(&self.setup.settings(case)?, self.designs, iterated)?;
        let flown = &self.flown[case.space];
        let space = &self.setup.spaces[case.space].space;
        let accuracy = Accuracy::of(&campaign, space, &flown.model, &flown.truths[case.truth])?;
        Ok(Ended { case, campaign, accuracy })
    }
}
