//! The search over a grid as it is, and over a box with a continuous axis and one with levels, or whose free runs must
//! differ: on a fine grid, and off it along the continuous axes as far as runs that must differ stay apart.

use rand_pcg::Pcg64;

use super::attempt::{Attempt, Designer, Refinement, WORTH_REFINING};
use super::candidates::Candidates;
use super::continuous::Continuous;
use super::ending::IsOver;
use super::exchange::{Discrete, n_relaxed};
use super::frame::{Frame, lattice};
use super::gridded::{gridded, thinned};
use super::incumbents::Incumbents;
use super::problem::{APART, Problem, Replicates};
use super::settings::Effort;
use super::starts::{Outcome, Runner};
use crate::Error;
use crate::same::SAME_RUN;
use crate::shape::BoxShape;

pub(crate) fn over_grid(problem: &Problem, shape: &BoxShape, runner: Runner<'_>) -> Result<Outcome, Error> {
    let is_discrete = shape.is_discrete();
    let grid = if is_discrete { thinned(shape) } else { gridded(shape)? };
    let relaxed = shape.relaxed();
    let frame = Frame::of(problem, Some(&relaxed), runner.least_log_determinant, &<[f64]>::to_vec)?;
    let lattice = lattice(&relaxed, &frame.products);
    let continuous =
        |effort: Effort| Continuous { frame: &frame, shape: &relaxed, judged: &relaxed, lattice: &lattice, effort };
    let candidates = Candidates::grid(&grid, &frame.products);
    let effort = runner.settings.effort;
    let search = Discrete {
        frame: &frame,
        candidates: &candidates,
        relaxed: Some(continuous(Effort::Quick)),
        n_relaxed: if is_discrete { n_relaxed(effort, shape.axes.len()) } else { 1 },
        is_distinct: problem.replicates() != Replicates::Allowed,
        apart: if is_discrete { SAME_RUN } else { APART },
        fixed: problem.fixed_runs().map(<[f64]>::to_vec).collect(),
    };
    let polish = continuous(effort);
    let off_grid = (!is_discrete).then_some(OffGrid { problem, shape, polish });
    let is_mixed = !is_discrete && !shape.is_continuous();
    let n_tries = if is_mixed && effort == Effort::Thorough { MIXED_TRIES } else { 1 };
    Ok(runner.run(&Gridded { search, off_grid, n_tries }))
}

/// Starts on a grid, and where they are taken from there.
struct Gridded<'a> {
    search: Discrete<'a>,
    off_grid: Option<OffGrid<'a>>,
    /// Designs that a start makes, of which it keeps the best.
    n_tries: usize,
}

/// Tries of a thorough start where some axes are continuous and others have levels: which runs get which levels decides, and
/// what is best on the fine grid need not be off it.
const MIXED_TRIES: usize = 5;
/// Such a design is refined unless it is further behind the best on the grid than this, and so many per round at most.
const MIXED_WORTH_REFINING: (f64, usize) = (0.05, 4);

/// The box that the grid stands for.
struct OffGrid<'a> {
    problem: &'a Problem,
    shape: &'a BoxShape,
    polish: Continuous<'a>,
}

impl Designer for Gridded<'_> {
    fn start(&self, generator: &mut Pcg64, incumbents: &Incumbents, is_over: IsOver<'_>) -> Attempt {
        let mut best: Option<(f64, Vec<f64>)> = None;
        let mut failed = Attempt::Failed;
        for _ in 0..self.n_tries {
            let attempt = self.search.start(generator, incumbents, is_over);
            let was_cut = matches!(attempt, Attempt::Cut { .. });
            match attempt {
                Attempt::Found { x, value, .. } | Attempt::Cut { x, value } => {
                    if best.as_ref().is_none_or(|best| value < best.0) {
                        best = Some((value, x));
                    }
                }
                other => failed = other,
            }
            if was_cut {
                return best.map_or(failed, |(value, x)| Attempt::Cut { x, value });
            }
        }
        best.map_or(failed, |(value, x)| Attempt::Found { x, value, stages: Vec::new() })
    }

    fn worth_refining(&self) -> (f64, usize) {
        if self.n_tries > 1 { MIXED_WORTH_REFINING } else { WORTH_REFINING }
    }

    fn refine(&self, x: Vec<f64>, value: f64, incumbents: &Incumbents, is_over: IsOver<'_>) -> Refinement {
        match &self.off_grid {
            None => Refinement::Reached { x, value },
            Some(off_grid) => off_grid.refine(x, incumbents, is_over),
        }
    }
}

impl OffGrid<'_> {
    /// The design moved off the grid if that is better and keeps to the rule for replicates, else as it is.
    fn refine(&self, x: Vec<f64>, incumbents: &Incumbents, is_over: IsOver<'_>) -> Refinement {
        // A score takes what a scan of the space takes, with many factors a second.
        if is_over() {
            return Refinement::Unjudged;
        }
        let Some(value) = self.score(&x) else {
            return Refinement::Failed;
        };
        let refinement = if self.shape.is_continuous() {
            self.polish.refine(x.clone(), incumbents, is_over)
        } else {
            Refinement::of(self.polish.on_levels(self.shape, x.clone(), is_over))
        };
        let moved = match refinement {
            Refinement::Reached { x, .. } => Some(x).filter(|moved| self.problem.keeps_replicates(moved)),
            Refinement::Unjudged | Refinement::Failed => None,
        };
        match moved.and_then(|moved| Some((self.score(&moved)?, moved))) {
            Some((better, moved)) if better < value => Refinement::Reached { x: moved, value: better },
            _ => Refinement::Reached { x, value },
        }
    }

    /// The value over the space, which is not that on the grid: both designs are scored where they count.
    fn score(&self, x: &[f64]) -> Option<f64> {
        let problem = self.problem;
        let design = problem.design(x).ok()?;
        let efficiency = problem.criterion().efficiency(problem.model(), problem.space(), &design).ok()?;
        Some(problem.log_value(efficiency.percent))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use rand::SeedableRng as _;

    use crate::shape::Shape;
    use crate::{Axis, Criterion, Model, Space};

    /// What a search over five levels of one factor and any value of another consists of.
    fn mixed(then: impl Fn(&Problem, Discrete<'_>, OffGrid<'_>)) {
        let space = Space::of_axes(vec![Axis::equally_spaced(5).unwrap(), Axis::Continuous]).unwrap();
        let problem = Problem::new(Model::quadratic(2).unwrap(), space.clone(), 8, Criterion::G).unwrap();
        let Shape::Box(shape) = space.shape() else { unreachable!("axes make a box") };
        let (grid, relaxed) = (gridded(shape).unwrap(), shape.relaxed());
        let frame = Frame::of(&problem, Some(&relaxed), f64::NEG_INFINITY, &<[f64]>::to_vec).unwrap();
        let (lattice, candidates) = (lattice(&relaxed, &frame.products), Candidates::grid(&grid, &frame.products));
        let search = Discrete {
            frame: &frame,
            candidates: &candidates,
            relaxed: None,
            n_relaxed: 1,
            is_distinct: false,
            apart: APART,
            fixed: Vec::new(),
        };
        let (shape, judged, effort) = (&relaxed, &relaxed, Effort::Thorough);
        let polish = Continuous { frame: &frame, shape, judged, lattice: &lattice, effort };
        let Shape::Box(shape) = space.shape() else { unreachable!("axes make a box") };
        then(&problem, search, OffGrid { problem: &problem, shape, polish });
    }

    fn value_of(attempt: Attempt) -> f64 {
        match attempt {
            Attempt::Found { value, .. } => value,
            other => panic!("a start without a design: {other:?}"),
        }
    }

    #[test]
    fn a_start_keeps_the_best_of_its_tries() {
        mixed(|_, search, _| {
            let none = Incumbents::default();
            let (mut one, mut other) = (Pcg64::seed_from_u64(3), Pcg64::seed_from_u64(3));
            let alone = (0..4).map(|_| value_of(search.start(&mut one, &none, &|| false)));
            let (best, worst) =
                alone.fold((f64::INFINITY, 0.0), |(best, worst), value| (value.min(best), value.max(worst)));
            let gridded = Gridded { search, off_grid: None, n_tries: 4 };
            let found = value_of(gridded.start(&mut other, &none, &|| false));
            assert_eq!(found.to_bits(), best.to_bits(), "{found} of {best} to {worst}");
            assert!(best < worst, "they differ");
            // What is best on the grid need not be off it: more are refined, and from further behind.
            let once = Gridded { n_tries: 1, ..gridded };
            assert_eq!(once.worth_refining(), WORTH_REFINING);
            let tried = Gridded { n_tries: 4, ..once };
            assert!(tried.worth_refining().0 > WORTH_REFINING.0 && tried.worth_refining().1 > WORTH_REFINING.1);
        });
    }

    /// Scored where it counts: by the efficiency over the space.
    #[test]
    fn a_design_is_moved_off_the_grid_where_that_is_better() {
        mixed(|problem, search, off_grid| {
            let mut generator = Pcg64::seed_from_u64(3);
            let Attempt::Found { x, .. } = search.start(&mut generator, &Incumbents::default(), &|| false) else {
                panic!("a start without a design");
            };
            let percent = |x: &[f64]| {
                let design = problem.design(x).unwrap();
                problem.criterion().efficiency(problem.model(), problem.space(), &design).unwrap().percent
            };
            let refinement = off_grid.refine(x.clone(), &Incumbents::default(), &|| false);
            let Refinement::Reached { x: moved, value } = refinement else { panic!("{refinement:?}") };
            assert!((problem.percent(value) - percent(&moved)).abs() < 1e-9, "{value}");
            let over = off_grid.refine(x.clone(), &Incumbents::default(), &|| true);
            assert!(matches!(over, Refinement::Unjudged), "nothing is scored once the search is over: {over:?}");
            assert!(percent(&moved) > percent(&x) + 0.01, "{} of {}", percent(&moved), percent(&x));
        });
    }
}
