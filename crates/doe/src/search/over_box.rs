//! The search over a continuous box, replicates allowed.

use rand_pcg::Pcg64;

use super::attempt::{Attempt, Designer};
use super::continuous::Continuous;
use super::ending::IsOver;
use super::frame::{Frame, lattice};
use super::incumbents::Incumbents;
use super::problem::Problem;
use super::starts::{Outcome, Runner};
use crate::Error;
use crate::shape::BoxShape;

pub(crate) fn over_box(problem: &Problem, shape: &BoxShape, runner: Runner<'_>) -> Result<Outcome, Error> {
    let relaxed = shape.relaxed();
    let frame = Frame::of(problem, Some(&relaxed), runner.least_log_determinant, &<[f64]>::to_vec)?;
    let lattice = lattice(&relaxed, &frame.products);
    let effort = runner.settings.effort;
    Ok(runner.run(&Continuous { frame: &frame, shape: &relaxed, lattice: &lattice, effort }))
}

impl Designer for Continuous<'_> {
    fn start(&self, generator: &mut Pcg64, incumbents: &Incumbents, is_over: IsOver<'_>) -> Attempt {
        self.start(generator, incumbents, is_over)
    }

    fn refine(
        &self,
        x: Vec<f64>,
        _value: f64,
        incumbents: &Incumbents,
        is_over: IsOver<'_>,
    ) -> Option<(Vec<f64>, f64)> {
        self.refine(x, incumbents, is_over)
    }
}
