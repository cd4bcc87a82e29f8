//! Which runs to fit with, and which to check the fit with.

use serde::{Deserialize, Serialize};

use crate::criterion::moment_matrix;
use crate::matrix::{add_outer, cholesky, inverse_of_factor};
use crate::{Confounding, Design, Error, Model, Space, confounded_terms_of_design};

/// How runs are divided.
///
/// Distances are Euclidean in coded coordinates. Ties are decided by the coordinates, so the order of the runs in
/// the design does not matter, except that of replicates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SplitMethod {
    /// Section 5.1 of the source: sorted by distance from each other, every other run trains.
    ///
    /// The source does not say how distances between pairs give an order, nor where it begins. Here the order is a
    /// chain: it begins at the run farthest from the mean of all runs and goes on to the nearest run not yet in it. So
    /// neighbors come to different sides, and so do the two runs of a replicate; the first run trains, and with
    /// an odd number of runs the last one too.
    Alternating,
    /// The other reading of 5.1: sorted by distance from the mean of all runs, the farthest first, every other run
    /// trains. Runs of a symmetric design are equally far from the mean, and this says nothing about neighbors.
    AlternatingFromMean,
    /// Makes log m + |log(w / m)| small, with m the mean over the space, and w the mean over the validation runs,
    /// of the prediction variance that the training runs give. The first part is the precision of the fit; the second
    /// keeps the validation runs as hard to predict as the space is on average, so that their error stands for its error.
    /// Found by exchanging pairs of runs, from both alternating splits on, so it is good, but not always the best.
    #[default]
    Balanced,
}

/// Settings of a split.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SplitSettings {
    /// How.
    pub method: SplitMethod,
    /// Number of training runs; half of the runs, rounded up, where not said, as in 5.1.
    pub n_training: Option<usize>,
}

/// Runs to fit with and runs to check with, by index, each rising.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Split {
    /// Runs to fit with.
    pub training: Vec<usize>,
    /// Runs to check the fit with.
    pub validation: Vec<usize>,
    /// Number of pairs of runs that an alternating split had to exchange for its training runs to determine the model.
    pub repaired: usize,
    /// Terms that the training runs cannot tell apart: none if they determine the model.
    ///
    /// Never any, with at least as many training runs as terms, if the whole design determines the model.
    pub confounded: Vec<Confounding>,
}

impl Split {
    /// Whether the training runs determine the model.
    #[must_use]
    pub fn determines_model(&self) -> bool {
        self.confounded.is_empty()
    }

    /// The training runs as a design of their own.
    ///
    /// # Errors
    ///
    /// [`Error::Count`] if the indices are not those of the design.
    pub fn training_design(&self, design: &Design) -> Result<Design, Error> {
        select(design, &self.training)
    }

    /// The validation runs as a design of their own.
    ///
    /// # Errors
    ///
    /// As [`training_design`](Self::training_design).
    pub fn validation_design(&self, design: &Design) -> Result<Design, Error> {
        select(design, &self.validation)
    }
}

/// Divides the runs of a design. The same runs are divided in the same way, whatever their order.
///
/// Section 5.1 of the source sorts them by distance from each other and takes every other one; it leaves open how pairs of distances become an order and where it begins.
/// `Alternating` reads it as a chain from the run farthest from the mean of all runs to the nearest run that is left, and so on; `AlternatingFromMean` as the distance from the mean.
///
/// `Balanced`, the default, makes the mean prediction variance that the training runs give small, and keeps the validation runs as hard to predict as the space on average.
/// `cargo run -p infuse-doe --example split_study` compares them on quadratics and on responses that no quadratic fits (8 repetitions; 2 without an argument):
///
/// ```text
/// G-optimal designs
///                             error of fit   log(estimate/error)
///                            / alternating                  mean       rms
/// random halves                       2.41                  0.47      0.60
/// alternating (5.1, chain)            1.00                  0.11      0.31
/// alternating (from mean)             1.46                  0.29      0.46
/// balanced                            0.68                  0.07      0.30
/// no split, leave one out             0.47                  0.15      0.33
///
/// Latin hypercubes
///                             error of fit   log(estimate/error)
///                            / alternating                  mean       rms
/// random halves                       1.58                  0.05      0.36
/// alternating (5.1, chain)            1.00                 -0.09      0.31
/// alternating (from mean)             1.34                 -0.03      0.32
/// balanced                            0.45                 -0.06      0.28
/// no split, leave one out             0.32                  0.09      0.36
/// ```
///
/// * Error of the fit: root mean square over the cube, geometric mean, as a ratio to the alternating split. The estimate is the root mean square of the validation residuals; the error that it is compared with has the noise in it.
/// * The balanced split fits much better, and its validation runs tell the error as well as those of the alternating one.
/// * The alternating split is much better than chance, and the chain better than sorting by the distance from the mean.
/// * Tried and not kept: halves of the best D, I or G efficiency fit no better than balanced ones within a few per cent, but leave validation runs that tell the error less well on Latin hypercubes; Snee's DUPLEX fits 10 to 20 % better than the chain on optimal designs, and not always on Latin hypercubes.
/// * A fit to all runs is more precise than any to a half. Its error by leaving one run out at a time comes out somewhat too large on average, and varies a little more. Where (39) of the source does not ask for validation runs, this is the better use of runs that cost a day each.
///
/// An alternating split whose training runs do not determine the model, although the whole design does and they are
/// enough, is repaired by as few exchanges of a training and a validation run as there are terms missing. With too few training
/// runs, or a design that confounds terms, [`Split::confounded`] says which terms; the combined response of
/// the source can still be fitted, since simulations join the training runs there.
///
/// ```
/// use doe::{Design, Model, Space, SplitMethod, SplitSettings, split};
/// let design = Design::new(1, vec![-1.0, -0.9, 0.0, 0.1, 1.0, 0.9])?;
/// let mut settings = SplitSettings::default();
/// settings.method = SplitMethod::Alternating;
/// let halves = split(&Model::quadratic(1)?, &Space::cube(1)?, &design, &settings)?;
/// // The chain is -1, -0.9, 0, 0.1, 0.9, 1.
/// assert_eq!((halves.training, halves.validation), (vec![0, 2, 5], vec![1, 3, 4]));
/// # Ok::<(), doe::Error>(())
/// ```
///
/// # Errors
///
/// [`Error::FactorMismatch`]; [`Error::Count`] for fewer than two runs, or a number of training runs that leaves one side
/// empty; for the balanced split also [`Error::TooFewRuns`] for fewer training runs than terms, [`Error::Confounded`] if the
/// whole design does not determine the model, and [`Error::Singular`] if no training half does in double precision.
pub fn split(model: &Model, space: &Space, design: &Design, settings: &SplitSettings) -> Result<Split, Error> {
    for (what, found) in [("the space", space.n_factors()), ("the design", design.n_factors())] {
        if found != model.n_factors() {
            return Err(Error::FactorMismatch { what, expected: model.n_factors(), found });
        }
    }
    let n_runs = design.n_runs();
    if n_runs < 2 {
        return Err(Error::Count { name: "runs to split", found: n_runs, least: 2, most: usize::MAX });
    }
    let n_training = settings.n_training.unwrap_or(n_runs.div_ceil(2));
    if !(1..n_runs).contains(&n_training) {
        return Err(Error::Count { name: "training runs", found: n_training, least: 1, most: n_runs - 1 });
    }
    let n_terms = model.n_terms();
    let whole = confounded_terms_of_design(model, design)?;
    if settings.method == SplitMethod::Balanced {
        if n_training < n_terms {
            return Err(Error::TooFewRuns { n_runs: n_training, n_terms });
        }
        if !whole.is_empty() {
            return Err(Error::Confounded { what: "design", confounded: whole });
        }
    }
    let can_determine = whole.is_empty() && n_training >= n_terms;
    let alternating = |order: Vec<usize>| -> Result<(Sides, usize), Error> {
        let mut sides = Sides::alternating(model, design, &order, n_training);
        let mut repaired = 0;
        while can_determine && !sides.confounded(model, design)?.is_empty() && sides.exchange_best(&Sides::spread) {
            repaired += 1;
        }
        Ok((sides, repaired))
    };
    let (sides, repaired) = match settings.method {
        SplitMethod::Alternating => alternating(chain(design))?,
        SplitMethod::AlternatingFromMean => alternating(from_mean(design))?,
        SplitMethod::Balanced => {
            let moments = moment_matrix(model, space)?;
            let objective = |sides: &Sides| sides.imbalance(&moments);
            let (mut first, mut second) = (alternating(chain(design))?.0, alternating(from_mean(design))?.0);
            let (a, b) = (first.descend(&objective), second.descend(&objective));
            if !f64::min(a, b).is_finite() {
                return Err(Error::Singular);
            }
            (if improves(b, a) { second } else { first }, 0)
        }
    };
    let confounded = sides.confounded(model, design)?;
    let Sides { mut training, mut validation, .. } = sides;
    training.sort_unstable();
    validation.sort_unstable();
    Ok(Split { training, validation, repaired, confounded })
}

/// A descent that has not ended by then is ended.
const MOST_PASSES: usize = 50;
/// Distances that differ by no more are a tie.
const TIE: f64 = 1e-9;

/// The two sides on the way, with the regressor of each run.
struct Sides {
    n_terms: usize,
    regressors: Vec<f64>,
    training: Vec<usize>,
    validation: Vec<usize>,
}

impl Sides {
    fn alternating(model: &Model, design: &Design, order: &[usize], n_training: usize) -> Self {
        let n_terms = model.n_terms();
        let mut regressors = vec![0.0; design.n_runs() * n_terms];
        for (run, regressor) in design.runs().zip(regressors.chunks_exact_mut(n_terms)) {
            model.fill_regressor(run, regressor);
        }
        let n = order.len();
        // Half of the runs are every other one; any other number is spread over the order as evenly as it can be.
        let trains = |position: usize| {
            if n_training == n.div_ceil(2) {
                position.is_multiple_of(2)
            } else {
                ((position + 1) * n_training).div_ceil(n) > (position * n_training).div_ceil(n)
            }
        };
        let (training, validation): (Vec<usize>, Vec<usize>) = (0..n).partition(|&position| trains(position));
        let runs = |positions: Vec<usize>| positions.into_iter().map(|position| order[position]).collect();
        Self { n_terms, regressors, training: runs(training), validation: runs(validation) }
    }

    fn confounded(&self, model: &Model, design: &Design) -> Result<Vec<Confounding>, Error> {
        confounded_terms_of_design(model, &select(design, &self.training)?)
    }

    fn regressor(&self, run: usize) -> &[f64] {
        &self.regressors[run * self.n_terms..][..self.n_terms]
    }

    fn information(&self, runs: &[usize]) -> Vec<f64> {
        let mut matrix = vec![0.0; self.n_terms * self.n_terms];
        for &run in runs {
            add_outer(&mut matrix, self.n_terms, 1.0, self.regressor(run));
        }
        matrix
    }

    /// −log det of the training information with a ridge so small that a missing rank outweighs everything else.
    fn spread(&self) -> f64 {
        let p = self.n_terms;
        let mut matrix = self.information(&self.training);
        let trace: f64 = matrix.iter().step_by(p + 1).sum();
        for diagonal in matrix.iter_mut().step_by(p + 1) {
            *diagonal += 1e-9 * trace.max(f64::MIN_POSITIVE) / p as f64;
        }
        cholesky(&mut matrix, p, 0.0).map_or(f64::INFINITY, |log_determinant| -log_determinant)
    }

    /// log m + |log(w / m)|, see [`SplitMethod::Balanced`]; infinite if the training runs do not determine the model.
    fn imbalance(&self, moments: &[f64]) -> f64 {
        let p = self.n_terms;
        let mut factor = self.information(&self.training);
        if cholesky(&mut factor, p, crate::information::PIVOT_FLOOR).is_none() {
            return f64::INFINITY;
        }
        let (mut inverse, mut scratch) = (vec![0.0; p * p], vec![0.0; p * p]);
        inverse_of_factor(&factor, p, &mut inverse, &mut scratch);
        // Only the lower triangle of the inverse is complete, the other factor is symmetric.
        let trace = |matrix: &[f64]| -> f64 {
            let row = |i: usize| {
                let off: f64 = (0..i).map(|j| inverse[i * p + j] * matrix[i * p + j]).sum();
                2.0 * off + inverse[i * p + i] * matrix[i * p + i]
            };
            (0..p).map(row).sum()
        };
        let over_space = trace(moments);
        let over_validation = trace(&self.information(&self.validation)) / self.validation.len() as f64;
        // Where nothing is known of the validation runs' difficulty, precision alone decides.
        let mismatch = (over_validation / over_space).ln().abs();
        over_space.ln() + if mismatch.is_finite() { mismatch } else { f64::MAX.ln() }
    }

    fn swap(&mut self, a: usize, b: usize) {
        std::mem::swap(&mut self.training[a], &mut self.validation[b]);
    }

    /// The exchange of one pair that makes the objective smallest; false if none makes it smaller.
    fn exchange_best(&mut self, objective: &impl Fn(&Self) -> f64) -> bool {
        let mut best = (None, objective(self));
        for a in 0..self.training.len() {
            for b in 0..self.validation.len() {
                self.swap(a, b);
                let value = objective(self);
                self.swap(a, b);
                if improves(value, best.1) {
                    best = (Some((a, b)), value);
                }
            }
        }
        if let Some((a, b)) = best.0 {
            self.swap(a, b);
        }
        best.0.is_some()
    }

    /// Exchanges pairs until nothing makes the objective smaller; its value then.
    fn descend(&mut self, objective: &impl Fn(&Self) -> f64) -> f64 {
        for _ in 0..MOST_PASSES {
            if !self.exchange_pass(objective) {
                break;
            }
        }
        objective(self)
    }

    /// The best exchange of each training run in turn; false if none makes the objective smaller.
    fn exchange_pass(&mut self, objective: &impl Fn(&Self) -> f64) -> bool {
        let mut value = objective(self);
        let mut moved = false;
        for a in 0..self.training.len() {
            let mut best = (None, value);
            for b in 0..self.validation.len() {
                self.swap(a, b);
                let value = objective(self);
                self.swap(a, b);
                if improves(value, best.1) {
                    best = (Some(b), value);
                }
            }
            if let (Some(b), better) = best {
                self.swap(a, b);
                value = better;
                moved = true;
            }
        }
        moved
    }
}

/// Smaller by more than rounding.
fn improves(value: f64, than: f64) -> bool {
    value < than - 1e-10 || value.is_finite() && than == f64::INFINITY
}

fn select(design: &Design, runs: &[usize]) -> Result<Design, Error> {
    let n_runs = design.n_runs();
    if let Some(&found) = runs.iter().find(|&&run| run >= n_runs) {
        return Err(Error::Count { name: "index of a run", found, least: 0, most: n_runs - 1 });
    }
    let k = design.n_factors();
    Design::new(k, runs.iter().flat_map(|run| &design.coordinates()[run * k..][..k]).copied().collect())
}

/// Runs by their coordinates: the order that decides ties.
fn by_coordinates(design: &Design) -> Vec<usize> {
    let runs: Vec<&[f64]> = design.runs().collect();
    let mut order: Vec<usize> = (0..runs.len()).collect();
    let compare = |&a: &usize, &b: &usize| {
        let pairs = runs[a].iter().zip(runs[b]).map(|(x, y)| x.total_cmp(y));
        pairs.fold(std::cmp::Ordering::Equal, std::cmp::Ordering::then)
    };
    order.sort_by(compare);
    order
}

fn distances_from_mean(design: &Design, order: &[usize]) -> Vec<f64> {
    let runs: Vec<&[f64]> = design.runs().collect();
    let mut mean = vec![0.0; design.n_factors()];
    for &run in order {
        mean.iter_mut().zip(runs[run]).for_each(|(mean, x)| *mean += x / runs.len() as f64);
    }
    runs.iter().map(|run| distance(run, &mean)).collect()
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| (x - y) * (x - y)).sum::<f64>().sqrt()
}

/// From the run farthest from the mean, always to the nearest run that is left.
fn chain(design: &Design) -> Vec<usize> {
    let runs: Vec<&[f64]> = design.runs().collect();
    let mut left = by_coordinates(design);
    let from_mean = distances_from_mean(design, &left);
    let mut chain: Vec<usize> = Vec::with_capacity(left.len());
    while !left.is_empty() {
        let length = |run: usize| match chain.last() {
            Some(&last) => distance(runs[last], runs[run]),
            None => -from_mean[run],
        };
        let mut nearest = (0, length(left[0]));
        for (at, &run) in left.iter().enumerate().skip(1) {
            let length = length(run);
            if length < nearest.1 - TIE {
                nearest = (at, length);
            }
        }
        chain.push(left.remove(nearest.0));
    }
    chain
}

/// By distance from the mean, the farthest first.
fn from_mean(design: &Design) -> Vec<usize> {
    let mut order = by_coordinates(design);
    let distances = distances_from_mean(design, &order);
    let step = |run: usize| (distances[run] / TIE).round();
    order.sort_by(|&a, &b| step(b).total_cmp(&step(a)));
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    /// On a line: from the end that lies farther from the mean, 0.16, step by step to the other.
    #[test]
    fn a_chain_goes_from_the_farthest_run_to_the_nearest_left() {
        let design = Design::from_runs(&[[0.5], [-1.0], [0.7], [-0.2], [0.8]]).unwrap();
        assert_eq!(chain(&design), [1, 3, 0, 2, 4]);
        assert_eq!(from_mean(&design)[0], 1);
        // The same from the other end, against the order of the coordinates.
        let mirrored = Design::from_runs(&[[-0.5], [1.0], [-0.7], [0.2], [-0.8]]).unwrap();
        assert_eq!(chain(&mirrored), [1, 3, 0, 2, 4]);
    }
}
