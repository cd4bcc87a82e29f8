//! What is searched for.

use crate::shape::{BoxShape, Shape};
use crate::support::{check_support, confounded_terms_of_design};
use crate::{Cell, Criterion, Design, Error, Model, Space};

/// A model, a space, a number of runs and a criterion; and what is settled beforehand.
#[derive(Debug, Clone)]
pub struct Problem {
    model: Model,
    space: Space,
    n_runs: usize,
    criterion: Criterion,
    fixed: Option<Design>,
    replicates: Replicates,
    judged: Option<Space>,
}

/// Whether a run may be made twice.
///
/// Runs are the same where no coordinate differs by more than 1e-6; in the design that a search returns such runs are equal
/// to the last bit, a free run at the coordinates of the fixed one that it repeats. Fixed runs may be replicates of each
/// other as they please, and stay as they are.
///
/// Along a continuous axis a rule against replicates would be met by runs a millionth apart, which no rig can tell. With
/// [`Planned`](Self::Planned) a search therefore chooses free runs on a fine grid (41 levels per axis, fewer with many
/// factors), and moves them off it only as far as they stay 0.049 apart in some coded coordinate, fixed runs included.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Replicates {
    /// As often as the criterion likes: the default on continuous spaces.
    Allowed,
    /// Exactly this many free runs are a second run of another free one, and nothing else is repeated, neither a free
    /// run nor a fixed one: the default with 0 on grids and lists.
    Planned(usize),
}

/// Runs that must be distinct along a continuous axis are at least this far apart, coded.
pub(crate) const APART: f64 = 0.049;

impl Problem {
    /// A design of `n_runs` runs from the space, good by the criterion for the model. Fixed runs and the rule for
    /// replicates may follow in any order: what they mean for each other [`validate`](Self::validate) checks.
    ///
    /// # Errors
    ///
    /// [`Error::FactorMismatch`]; [`Error::TooFewRuns`] for fewer runs than terms; [`Error::Count`] for more than
    /// [`MOST_RUNS`](Self::MOST_RUNS); [`Error::Confounded`] if no design from this space can tell the terms apart, with the
    /// terms.
    pub fn new(model: Model, space: Space, n_runs: usize, criterion: Criterion) -> Result<Self, Error> {
        let (expected, found) = (model.n_factors(), space.n_factors());
        if expected != found {
            return Err(Error::FactorMismatch { what: "the space", expected, found });
        }
        if n_runs < model.n_terms() {
            return Err(Error::TooFewRuns { n_runs, n_terms: model.n_terms() });
        }
        if n_runs > Self::MOST_RUNS {
            return Err(Error::Count { name: "runs", found: n_runs, least: model.n_terms(), most: Self::MOST_RUNS });
        }
        check_support(&model, &space)?;
        let replicates = if space.n_points().is_none() { Replicates::Allowed } else { Replicates::Planned(0) };
        Ok(Self { model, space, n_runs, criterion, fixed: None, replicates, judged: None })
    }

    /// The first runs of the design are these, already made or wished for; the search adds the others.
    ///
    /// # Errors
    ///
    /// [`Error::FactorMismatch`], [`Error::RunOutside`]; [`Error::Count`] if no run is left to choose.
    pub fn with_fixed_runs(mut self, fixed: Design) -> Result<Self, Error> {
        fixed.check_within(&self.space)?;
        if fixed.n_runs() >= self.n_runs {
            return Err(Error::Count { name: "fixed runs", found: fixed.n_runs(), least: 0, most: self.n_runs - 1 });
        }
        self.fixed = Some(fixed);
        Ok(self)
    }

    /// Another rule for replicates than the default of the space.
    ///
    /// # Errors
    ///
    /// [`Error::Count`] for more planned replicates than half of the runs, [`Error::TooFewRuns`] if the distinct runs
    /// are fewer than the terms.
    pub fn with_replicates(mut self, replicates: Replicates) -> Result<Self, Error> {
        self.replicates = replicates;
        if let Replicates::Planned(found) = replicates {
            check_planned(found, self.n_runs)?;
            let distinct = self.n_runs - found;
            if distinct < self.model.n_terms() {
                return Err(Error::TooFewRuns { n_runs: distinct, n_terms: self.model.n_terms() });
            }
        }
        Ok(self)
    }

    /// Predictions are asked for on this grid only, while the runs may be anywhere in the continuous space: designs in the
    /// literature are often judged on five levels of each factor.
    ///
    /// ```
    /// use doe::{Criterion, Model, Problem, Settings, Space, search};
    /// let problem = Problem::new(Model::quadratic(2)?, Space::cube(2)?, 7, Criterion::G)?;
    /// let found = search(&problem.judged_over(Space::grid(&[5, 5])?)?, &Settings::default())?;
    /// assert!(found.efficiency.percent > 80.238, "the best published one has 80.239 %: {}", found.efficiency);
    /// assert!(found.efficiency.to_string().ends_with("over the grid of 5 x 5 levels"));
    /// # Ok::<(), doe::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::FactorMismatch`]; [`Error::NotAGrid`] for a list or a box with a continuous axis; [`Error::Count`] for more
    /// than [`MOST_JUDGED`](Self::MOST_JUDGED) points.
    pub fn judged_over(mut self, judged: Space) -> Result<Self, Error> {
        let (expected, found) = (self.model.n_factors(), judged.n_factors());
        if expected != found {
            return Err(Error::FactorMismatch { what: "the grid to judge over", expected, found });
        }
        let Some(n_points) = judged.axes().and(judged.n_points()) else {
            return Err(Error::NotAGrid { what: "the space to judge over" });
        };
        let (found, most) = (usize::try_from(n_points).unwrap_or(usize::MAX), Self::MOST_JUDGED);
        if found > most {
            return Err(Error::Count { name: "points to judge over", found, least: 1, most });
        }
        self.judged = Some(judged);
        Ok(self)
    }

    /// The largest number of runs.
    pub const MOST_RUNS: usize = 1_000_000;

    /// The largest grid to judge over, in points.
    pub const MOST_JUDGED: usize = 100_000;

    /// Where predictions are asked for: the space, unless another was [set](Self::judged_over).
    #[must_use]
    pub fn judged(&self) -> &Space {
        self.judged.as_ref().unwrap_or(&self.space)
    }

    /// The grid that predictions are asked for on, where it is not the space.
    pub(crate) fn judged_grid(&self) -> Option<&BoxShape> {
        match self.judged.as_ref()?.shape() {
            Shape::Box(shape) => Some(shape),
            Shape::List(_) => None,
        }
    }

    /// Whether runs are anywhere in a box, as often as the criterion likes.
    pub(crate) fn is_continuous(&self) -> bool {
        let is_box = matches!(self.space.shape(), Shape::Box(shape) if shape.is_continuous());
        is_box && self.replicates == Replicates::Allowed
    }

    /// Nothing if there can be a design: what no part of the problem can tell alone. A search calls it.
    ///
    /// # Errors
    ///
    /// [`Error::TooFewFreeRuns`] for fixed runs that leave more terms open than there are distinct free runs;
    /// [`Error::Count`] for more planned replicates than free runs to repeat; [`Error::TooFewPoints`] if the space has
    /// fewer points than distinct runs are needed; [`Error::NotContinuous`] for a grid to judge over where runs are not
    /// continuous in every factor, or not to be repeated.
    pub fn validate(&self) -> Result<(), Error> {
        if self.judged.is_some() && !self.is_continuous() {
            return Err(Error::NotContinuous { what: "a grid to judge over" });
        }
        self.check_replicates()?;
        let Some(fixed) = &self.fixed else {
            return Ok(());
        };
        let (n_fixed, n_terms) = (fixed.n_runs(), self.model.n_terms());
        let determined = n_terms - confounded_terms_of_design(&self.model, fixed)?.len();
        let n_free = self.multiplicities().len();
        if determined + n_free < n_terms {
            return Err(Error::TooFewFreeRuns { n_fixed, determined, n_free, n_terms });
        }
        Ok(())
    }

    fn check_replicates(&self) -> Result<(), Error> {
        let Replicates::Planned(planned) = self.replicates else {
            return Ok(());
        };
        check_planned(planned, self.n_free())?;
        let n_fixed = self.fixed.as_ref().map_or(0, Design::n_distinct);
        let n_distinct = n_fixed + self.n_free() - planned;
        match self.space.n_points() {
            Some(n_points) if (n_distinct as u64) > n_points => Err(Error::TooFewPoints { n_distinct, n_points }),
            _ => Ok(()),
        }
    }

    /// The same problem with another criterion.
    #[must_use]
    pub fn with_criterion(mut self, criterion: Criterion) -> Self {
        self.criterion = criterion;
        self
    }

    /// The model.
    #[must_use]
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// The space that runs are chosen from and predictions are made in.
    #[must_use]
    pub fn space(&self) -> &Space {
        &self.space
    }

    /// Number of runs, N, fixed ones included.
    #[must_use]
    pub fn n_runs(&self) -> usize {
        self.n_runs
    }

    /// The criterion.
    #[must_use]
    pub fn criterion(&self) -> Criterion {
        self.criterion
    }

    /// The runs that are settled.
    #[must_use]
    pub fn fixed(&self) -> Option<&Design> {
        self.fixed.as_ref()
    }

    /// The rule for replicates.
    #[must_use]
    pub fn replicates(&self) -> Replicates {
        self.replicates
    }

    pub(crate) fn n_free(&self) -> usize {
        self.n_runs - self.fixed.as_ref().map_or(0, Design::n_runs)
    }

    /// How often each distinct free run is made, the planned replicates first.
    pub(crate) fn multiplicities(&self) -> Vec<f64> {
        let planned = match self.replicates {
            Replicates::Allowed => 0,
            Replicates::Planned(planned) => planned,
        };
        (0..self.n_free() - planned).map(|run| if run < planned { 2.0 } else { 1.0 }).collect()
    }

    /// Whether the free runs at these coordinates keep apart as the rule for replicates wants it on a continuous axis.
    pub(crate) fn keeps_replicates(&self, x: &[f64]) -> bool {
        if self.replicates == Replicates::Allowed {
            return true;
        }
        let k = self.model.n_factors();
        let runs: Vec<&[f64]> = x.chunks_exact(k).collect();
        let same = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(x, y)| (x - y).abs() < APART);
        let fixed: Vec<&[f64]> = self.fixed_runs().collect();
        runs.iter().enumerate().all(|(i, a)| !runs[..i].iter().any(|b| same(a, b)) && !fixed.iter().any(|b| same(a, b)))
    }

    /// The coordinates of the runs that are settled.
    pub(crate) fn fixed_runs(&self) -> impl Iterator<Item = &[f64]> {
        self.fixed.iter().flat_map(Design::runs)
    }

    /// The whole design of the distinct free runs at these coordinates, replicates equal to the last bit.
    pub(crate) fn design(&self, x: &[f64]) -> Result<Design, Error> {
        let free: Vec<&[f64]> = x.chunks_exact(self.model.n_factors()).collect();
        let design = Design::from_runs(&self.arranged(self.fixed_runs(), &free))?;
        Ok(design.with_equal_replicates(self.n_runs - self.n_free()))
    }

    /// The candidate of each run of the whole design, by index, from those of the distinct free runs; nothing where the
    /// space is no list.
    pub(crate) fn candidates(&self, free: &[usize]) -> Vec<usize> {
        match self.space.shape() {
            Shape::Box(_) => Vec::new(),
            Shape::List(list) => self.arranged(self.fixed_runs().map(|run| list.nearest(run).0), free),
        }
    }

    /// The cell of each run of the whole design; nothing where the space is no grid.
    pub(crate) fn cells(&self, design: &Design) -> Vec<Cell> {
        match self.space.shape() {
            Shape::Box(shape) => shape.cells(design.runs()).unwrap_or_default(),
            Shape::List(_) => Vec::new(),
        }
    }

    /// In the order of the whole design: what belongs to fixed runs, to distinct free runs, and to planned replicates.
    fn arranged<T: Copy>(&self, fixed: impl Iterator<Item = T>, free: &[T]) -> Vec<T> {
        let n_repeated = self.multiplicities().iter().filter(|&&multiplicity| multiplicity > 1.0).count();
        fixed.chain(free.iter().copied()).chain(free.iter().copied().take(n_repeated)).collect()
    }

    /// Efficiency of a logarithmic value of the criterion, per cent: for progress and targets.
    pub(crate) fn percent(&self, log_value: f64) -> f64 {
        let (n, p) = (self.n_runs as f64, self.model.n_terms() as f64);
        100.0
            * match self.criterion {
                Criterion::D => (-log_value).exp() / n,
                Criterion::A | Criterion::G | Criterion::I => p / (n * log_value.exp()),
                Criterion::E => (-log_value).exp() / n,
                Criterion::T => (-log_value).exp() / (n * p),
            }
    }

    /// The inverse of [`percent`](Self::percent).
    pub(crate) fn log_value(&self, percent: f64) -> f64 {
        let (n, p) = (self.n_runs as f64, self.model.n_terms() as f64);
        let fraction = percent / 100.0;
        match self.criterion {
            Criterion::D | Criterion::E => -(fraction * n).ln(),
            Criterion::A | Criterion::G | Criterion::I => (p / (n * fraction)).ln(),
            Criterion::T => -(fraction * n * p).ln(),
        }
    }
}

/// Each planned replicate repeats another of these runs.
fn check_planned(found: usize, n_runs: usize) -> Result<(), Error> {
    let most = n_runs / 2;
    if found > most { Err(Error::Count { name: "planned replicates", found, least: 0, most }) } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Four corners of a square: M = 4 I, so D⁻¹ is 4, tr D is 3/4, and the largest v is 3/4; all by 100 %.
    #[test]
    fn percent_of_an_orthogonal_design_is_one_hundred() {
        for (criterion, log_value) in [
            (Criterion::D, -4.0_f64.ln()),
            (Criterion::A, 0.75_f64.ln()),
            (Criterion::G, 0.75_f64.ln()),
            (Criterion::E, 0.25_f64.ln()),
            (Criterion::T, -12.0_f64.ln()),
        ] {
            let problem = Problem::new(Model::linear(2).unwrap(), Space::cube(2).unwrap(), 4, criterion).unwrap();
            assert!((problem.percent(log_value) - 100.0).abs() < 1e-12, "{criterion}: {}", problem.percent(log_value));
            assert!((problem.log_value(100.0) - log_value).abs() < 1e-15, "{criterion}");
            assert!((problem.percent(problem.log_value(61.0)) - 61.0).abs() < 1e-12, "{criterion}");
        }
    }
}
