//! One start of a search: who makes it, and how it ends.

use rand_pcg::Pcg64;

use super::ending::IsOver;
use super::incumbents::Incumbents;

/// How one start ended.
#[derive(Debug, Clone)]
pub(crate) enum Attempt {
    /// With free runs at x, the logarithm of the criterion there, smoothed for G, and its values on the way.
    Found {
        x: Vec<f64>,
        value: f64,
        stages: Vec<f64>,
    },
    Abandoned,
    Failed,
    /// The search was over before the start was: what it had, not singular.
    Cut {
        x: Vec<f64>,
        value: f64,
    },
}

/// What became of a design that was to be taken to its local optimum.
#[derive(Debug, Clone)]
pub(crate) enum Refinement {
    /// With free runs at x, or as far as they came before the search was over, and the logarithm of the criterion there.
    Reached { x: Vec<f64>, value: f64 },
    /// The search was over before the value of the design was known: it is what the start made of it.
    Unjudged,
    /// It is singular, or not worth it.
    Failed,
}

impl Refinement {
    /// What was reached, or failure.
    pub(crate) fn of(reached: Option<(Vec<f64>, f64)>) -> Self {
        reached.map_or(Self::Failed, |(x, value)| Self::Reached { x, value })
    }
}

/// A start further behind the best before refinement is not refined, nor are more than so many of a round.
pub(crate) const WORTH_REFINING: (f64, usize) = (0.004, 2);

/// How the starts over one kind of space are made, and the best of them refined.
pub(crate) trait Designer: Sync {
    /// One start, or as much of it as there is until `is_over`.
    fn start(&self, generator: &mut Pcg64, incumbents: &Incumbents, is_over: IsOver<'_>) -> Attempt;

    /// How far behind the best before refinement a start may be to be refined, and how many of a round are at most.
    fn worth_refining(&self) -> (f64, usize) {
        WORTH_REFINING
    }

    /// A design taken to its local optimum, or as far as it comes until `is_over`.
    fn refine(&self, x: Vec<f64>, value: f64, incumbents: &Incumbents, is_over: IsOver<'_>) -> Refinement;
}
