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

    /// A design taken to its local optimum, or as far as it comes until `is_over`, with its value; none if it is
    /// singular or not worth it.
    fn refine(&self, x: Vec<f64>, value: f64, incumbents: &Incumbents, is_over: IsOver<'_>) -> Option<(Vec<f64>, f64)>;
}
