//! The search over a list of candidates.

use rand_pcg::Pcg64;

use super::attempt::{Attempt, Designer, Refinement};
use super::candidates::Candidates;
use super::continuous::Continuous;
use super::ending::IsOver;
use super::exchange::{Discrete, n_relaxed};
use super::frame::{Frame, lattice};
use super::incumbents::Incumbents;
use super::problem::{Problem, Replicates};
use super::settings::Effort;
use super::starts::{Outcome, Runner};
use crate::nested::MOST_STORED;
use crate::products::Products;
use crate::same::SAME_RUN;
use crate::shape::{Axis, BoxShape, List};
use crate::{Criterion, Error};

/// What was found, and the index of the candidate that each distinct free run is.
///
/// The list is stretched to fill the cube where that does not change the problem, so that a list shrunken to a small
/// part of it is as well conditioned as any.
pub(crate) fn over_list(problem: &Problem, list: &List, runner: Runner<'_>) -> Result<(Outcome, Vec<usize>), Error> {
    let k = list.n_factors;
    let stretch = Stretch::of(problem, list);
    let map = |point: &[f64]| stretch.map(point);
    let stretched = List { n_factors: k, coordinates: list.points().flat_map(map).collect() };
    let cube = BoxShape { axes: vec![Axis::Continuous; k], forbidden: Vec::new() };
    // Where the cube's lattice is that large, the list is searched for itself.
    let products = Products::of(problem.model());
    let n_values = lattice(&cube, &products).n_points().saturating_mul(products.n_monomials());
    let is_boxed = (stretch.fills || stretch.stretches) && n_values <= MOST_STORED;
    let frame = Frame::of(problem, is_boxed.then_some(&cube), runner.least_log_determinant, &map)?;
    let lattice = lattice(&cube, &frame.products);
    let relaxed = Continuous { frame: &frame, shape: &cube, judged: &cube, lattice: &lattice, effort: Effort::Quick };
    let candidates = Candidates::list(&stretched, &frame.regressors, &frame.products);
    let search = Discrete {
        frame: &frame,
        candidates: &candidates,
        relaxed: is_boxed.then_some(relaxed),
        n_relaxed: n_relaxed(runner.settings.effort, k),
        is_distinct: problem.replicates() != Replicates::Allowed,
        apart: SAME_RUN,
        fixed: problem.fixed_runs().map(map).collect(),
    };
    let mut outcome = runner.run(&Listed { search });
    let Some(best) = &mut outcome.best else {
        return Ok((outcome, Vec::new()));
    };
    let chosen: Vec<usize> = best.x.chunks_exact(k).map(|run| stretched.nearest(run).0).collect();
    best.x = chosen.iter().flat_map(|&index| list.point(index)).copied().collect();
    Ok((outcome, chosen))
}

/// Coordinates in which a list fills the cube.
struct Stretch {
    /// Least and largest coordinate of the list along each axis.
    ends: Vec<[f64; 2]>,
    /// Whether the list fills the cube as it is.
    fills: bool,
    /// Whether stretching changes nothing about the problem.
    stretches: bool,
}

impl Stretch {
    fn of(problem: &Problem, list: &List) -> Self {
        let mut ends = vec![[f64::INFINITY, f64::NEG_INFINITY]; list.n_factors];
        for point in list.points() {
            for ([lower, upper], &x) in ends.iter_mut().zip(point) {
                *lower = lower.min(x);
                *upper = upper.max(x);
            }
        }
        let is_invariant = matches!(problem.criterion(), Criterion::D | Criterion::G | Criterion::I);
        let fills = ends.iter().all(|[lower, upper]| *lower <= -1.0 && *upper >= 1.0);
        let stretches = is_invariant && problem.model().is_affine_closed() && ends.iter().all(|[a, b]| b - a > 1e-9);
        Self { ends, fills, stretches }
    }

    fn map(&self, point: &[f64]) -> Vec<f64> {
        if self.fills || !self.stretches {
            return point.to_vec();
        }
        let stretched = |(x, [a, b]): (&f64, &[f64; 2])| ((x - a) - (b - x)) / (b - a);
        point.iter().zip(&self.ends).map(stretched).collect()
    }
}

/// Starts on a list. What they find needs no refinement.
struct Listed<'a> {
    search: Discrete<'a>,
}

impl Designer for Listed<'_> {
    fn start(&self, generator: &mut Pcg64, incumbents: &Incumbents, is_over: IsOver<'_>) -> Attempt {
        self.search.start(generator, incumbents, is_over)
    }

    fn refine(&self, x: Vec<f64>, value: f64, _: &Incumbents, _: IsOver<'_>) -> Refinement {
        Refinement::Reached { x, value }
    }
}
