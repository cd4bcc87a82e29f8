//! Exchange of runs for candidates, by the change of the criterion that each exchange would make.
//!
//! Replacing the run g by f changes M by f f' − g g'. With D = M⁻¹, d_fg = f'D g and
//! Δ = (1 + d_ff)(1 − d_gg) + d_fg²,
//!
//! ```text
//! |M'| = Δ |M|
//! x'D'x = x'D x − [(1 − d_gg)(x'D f)² + 2 d_fg (x'D f)(x'D g) − (1 + d_ff)(x'D g)²] / Δ
//! tr(B D') = tr(B D) − [(1 − d_gg) b_ff + 2 d_fg b_fg − (1 + d_ff) b_gg] / Δ,   b_fg = f'D B D g
//! ```

use std::collections::HashMap;
use std::rc::Rc;

use multiversion::multiversion;
use rand::RngExt;
use rand_pcg::Pcg64;

use super::attempt::Attempt;
use super::bounded::Objective as _;
use super::candidates::Candidates;
use super::continuous::Continuous;
use super::ending::IsOver;
use super::frame::{Frame, Matrices};
use super::incumbents::Incumbents;
use super::settings::Effort;
use super::smooth::Smooth;
use crate::matrix::{dot, multiply};
use crate::{Criterion, PredictionVariance};

/// A search over candidates.
#[derive(Debug)]
pub(crate) struct Discrete<'a> {
    pub(crate) frame: &'a Frame,
    pub(crate) candidates: &'a Candidates<'a>,
    /// The same problem with continuous coordinates, whose solutions are rounded to start from.
    pub(crate) relaxed: Option<Continuous<'a>>,
    /// How many of its solutions a start makes, to round the best of them.
    pub(crate) n_relaxed: usize,
    /// Whether no run may be made twice, not even a fixed one.
    pub(crate) is_distinct: bool,
    /// Runs whose coordinates differ by no more are made twice.
    pub(crate) apart: f64,
    pub(crate) fixed: Vec<Vec<f64>>,
}

/// Exponents of the smoothed worst prediction, as powers of 2; `None` is the worst prediction itself.
const STAGES: [Option<u32>; 4] = [Some(5), Some(7), Some(10), None];
/// Scans of all candidates per stage at most, and passes over all runs between them.
const PASSES: usize = 10;
const PASSES_PER_SCAN: usize = 2;
/// Candidates near a run, and candidates with a high prediction variance, tried in an exchange.
const NEAR: usize = 60;
const HIGH: usize = 40;
/// Points that the worst prediction of an exchange is taken over, between scans of all.
const WATCHED: usize = 500;
const WATCHED_SHARE: f64 = 0.75;
/// Watched points per block: an exchange that a block shows to be too bad is not looked at further.
const BLOCK: usize = 32;
/// Least relative improvement worth an exchange.
const LEAST: f64 = 1e-9;

/// Continuous starts of which a thorough start rounds the best: they take little time beside the exchanges after them. Few
/// factors do without.
pub(crate) fn n_relaxed(effort: Effort, n_factors: usize) -> usize {
    if effort == Effort::Thorough && n_factors >= 3 { 8 } else { 1 }
}

impl Discrete<'_> {
    /// One start; `is_over` is asked before every run.
    pub(crate) fn start(&self, generator: &mut Pcg64, incumbents: &Incumbents, is_over: IsOver<'_>) -> Attempt {
        let Some(x) = self.first_runs(generator, incumbents, is_over) else {
            return Attempt::Failed;
        };
        let is_worst_case = self.frame.criterion == Criterion::G;
        let mut runs = Runs::new(self, x);
        let mut value = runs.look_around();
        if value.is_none() {
            // What few candidates determine, such as a rare level, is easily missed by rounding and by samples.
            let Some(x) = self.supporting() else {
                return Attempt::Failed;
            };
            runs = Runs::new(self, x);
            value = runs.look_around();
        }
        let Some(value) = value else {
            return Attempt::Failed;
        };
        let mut best = (value, runs.x.clone());
        for stage in STAGES.into_iter().skip(if is_worst_case { 0 } else { 3 }) {
            for _ in 0..PASSES {
                let mut changed = false;
                for _ in 0..PASSES_PER_SCAN {
                    let pass = runs.pass(stage, generator, is_over);
                    if is_over() {
                        // The last scan of all candidates is what is known of it.
                        let (value, x) = best;
                        return Attempt::Cut { x, value };
                    }
                    changed |= pass;
                    if !pass {
                        break;
                    }
                }
                // Without a change the last scan still holds.
                if !changed {
                    break;
                }
                let Some(value) = runs.look_around() else {
                    break;
                };
                if value < best.0 {
                    best = (value, runs.x.clone());
                }
            }
        }
        let (value, x) = best;
        Attempt::Found { x, value, stages: Vec::new() }
    }

    fn is_taken(&self, point: &[f64], x: &[f64], except: usize) -> bool {
        let same = |other: &[f64]| other.iter().zip(point).all(|(a, b)| (a - b).abs() <= self.apart);
        let runs = x.chunks_exact(point.len()).enumerate().filter(|&(run, _)| run != except);
        self.is_distinct && (runs.map(|(_, run)| run).any(same) || self.fixed.iter().any(|run| same(run)))
    }

    /// A rounded continuous design, a changed good design, or random candidates chosen one by one where v is largest.
    fn first_runs(&self, generator: &mut Pcg64, incumbents: &Incumbents, is_over: IsOver<'_>) -> Option<Vec<f64>> {
        let (k, n) = (self.frame.n_factors(), self.frame.multiplicities.len());
        if let Some(elite) = incumbents.pick(generator) {
            let mut x = elite.to_vec();
            for _ in 0..generator.random_range(1..=(n / 4).max(1)) {
                let run = generator.random_range(0..n);
                let point = if generator.random::<bool>() {
                    self.candidates.sample(generator)
                } else {
                    let near = self.candidates.near(&x[run * k..run * k + k], NEAR);
                    near[generator.random_range(0..near.len())].clone()
                };
                if !self.is_taken(&point, &x, run) {
                    x[run * k..run * k + k].copy_from_slice(&point);
                }
            }
            return Some(x);
        }
        if let Some(relaxed) = &self.relaxed
            && generator.random_range(0..4) != 0
            && let Some(x) = best_relaxed(relaxed, self.n_relaxed, generator, is_over)
        {
            return self.rounded(&x);
        }
        self.greedy(generator)
    }

    /// Every run at its nearest free candidate.
    fn rounded(&self, x: &[f64]) -> Option<Vec<f64>> {
        let k = self.frame.n_factors();
        let mut rounded: Vec<f64> = Vec::with_capacity(x.len());
        for run in x.chunks_exact(k) {
            let mut near = self.candidates.near(run, 8);
            if near.iter().all(|point| self.is_taken(point, &rounded, usize::MAX)) {
                near = self.candidates.near(run, 8 + 2 * x.len() / k);
            }
            let is_free = |point: &[f64]| !self.is_taken(point, &rounded, usize::MAX);
            let free = near.into_iter().find(|point| is_free(point));
            // Where many runs crowd, everything near may be taken.
            rounded.extend(free.or_else(|| self.candidates.nearest_free(run, is_free))?);
        }
        Some(rounded)
    }

    /// Runs added one after the other where the regressor is least explained by those before, among random candidates.
    fn greedy(&self, generator: &mut Pcg64) -> Option<Vec<f64>> {
        const SAMPLE: usize = 400;
        let p = self.frame.n_terms();
        let sample: Vec<Vec<f64>> = (0..SAMPLE).map(|_| self.candidates.sample(generator)).collect();
        let regressors: Vec<Vec<f64>> = sample
            .iter()
            .map(|point| {
                let mut row = vec![0.0; p];
                self.frame.regressors.fill(point, &mut row);
                row
            })
            .collect();
        self.grown(|inverse, x| {
            let (mut u, mut best) = (vec![0.0; p], None);
            for (index, row) in regressors.iter().enumerate() {
                multiply(inverse, p, row, &mut u);
                let v = dot(row, &u) * (0.5 + generator.random::<f64>());
                if best.is_none_or(|best: (f64, usize)| v > best.0) && !self.is_taken(&sample[index], x, usize::MAX) {
                    best = Some((v, index));
                }
            }
            let is_free = |point: &[f64]| !self.is_taken(point, x, usize::MAX);
            // Many runs take all of a sample of few points.
            best.map(|(_, index)| sample[index].clone()).or_else(|| self.candidates.sample_free(generator, is_free))
        })
    }

    /// The same among all candidates: not singular unless they do not support the model.
    fn supporting(&self) -> Option<Vec<f64>> {
        let (k, p) = (self.frame.n_factors(), self.frame.n_terms());
        let n_taken = self.frame.multiplicities.len() + self.fixed.len();
        let mut variance = PredictionVariance::with_products(self.frame.products.clone(), &vec![0.0; p * p]);
        let (mut values, mut row, mut u) = (Vec::new(), vec![0.0; p], vec![0.0; p]);
        self.grown(|inverse, x| {
            variance.update(inverse);
            let high = self.candidates.scan(&variance, inverse, (0.0, n_taken + 1), &mut values);
            let free = high.points.chunks_exact(k).filter(|point| !self.is_taken(point, x, usize::MAX));
            let with_v = free.map(|point| {
                self.frame.regressors.fill(point, &mut row);
                multiply(inverse, p, &row, &mut u);
                (dot(&row, &u), point)
            });
            with_v.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, point)| point.to_vec())
        })
    }

    /// Runs added one after the other, each by a choice that knows (RᵀR + ε I)⁻¹ and the runs so far.
    fn grown(&self, mut choose: impl FnMut(&[f64], &[f64]) -> Option<Vec<f64>>) -> Option<Vec<f64>> {
        const RIDGE: f64 = 1e-4;
        let p = self.frame.n_terms();
        let mut information = self.frame.fixed.clone();
        information.iter_mut().step_by(p + 1).for_each(|d| *d += RIDGE);
        let (mut inverse, mut scratch) = (vec![0.0; p * p], vec![0.0; p * p]);
        crate::matrix::cholesky(&mut information, p, 0.0)?;
        crate::matrix::inverse_of_factor(&information, p, &mut inverse, &mut scratch);
        let (mut x, mut row, mut u) = (Vec::new(), vec![0.0; p], vec![0.0; p]);
        for _ in 0..self.frame.multiplicities.len() {
            let point = choose(&inverse, &x)?;
            self.frame.regressors.fill(&point, &mut row);
            multiply(&inverse, p, &row, &mut u);
            let scale = -1.0 / (1.0 + dot(&row, &u));
            crate::matrix::add_outer(&mut inverse, p, scale, &u);
            x.extend(point);
        }
        Some(x)
    }
}

/// The best of some continuous starts; those that fall behind the ones before are given up. None if all fail.
fn best_relaxed(
    relaxed: &Continuous<'_>,
    n_starts: usize,
    generator: &mut Pcg64,
    is_over: IsOver<'_>,
) -> Option<Vec<f64>> {
    let mut known = Incumbents::default();
    let mut best: Option<(f64, Vec<f64>)> = None;
    for _ in 0..n_starts {
        let (x, value, was_cut) = match relaxed.start(generator, &known, is_over) {
            Attempt::Found { x, value, stages } => {
                known.note(&stages, value);
                (x, value, false)
            }
            Attempt::Cut { x, value } => (x, value, true),
            Attempt::Abandoned | Attempt::Failed => continue,
        };
        if best.as_ref().is_none_or(|best| value < best.0) {
            best = Some((value, x));
        }
        if was_cut {
            break;
        }
    }
    best.map(|(_, x)| x)
}

/// Points with their regressors, point by point.
#[derive(Debug, Default)]
struct Offers {
    points: Vec<f64>,
    rows: Vec<f64>,
}

impl Offers {
    fn of<'a>(frame: &Frame, points: impl Iterator<Item = &'a [f64]>) -> Self {
        let p = frame.n_terms();
        let mut offers = Self::default();
        for point in points {
            offers.points.extend_from_slice(point);
            let at = offers.rows.len();
            offers.rows.resize(at + p, 0.0);
            frame.regressors.fill(point, &mut offers.rows[at..]);
        }
        offers
    }

    fn iter(&self, frame: &Frame) -> impl Iterator<Item = (&[f64], &[f64])> {
        self.points.chunks_exact(frame.n_factors()).zip(self.rows.chunks_exact(frame.n_terms()))
    }
}

/// A design in exchange.
struct Runs<'a> {
    search: &'a Discrete<'a>,
    x: Vec<f64>,
    rows: Vec<f64>,
    matrices: Matrices,
    variance: PredictionVariance,
    smooth: Smooth<'a>,
    /// Candidates with high v.
    high: Rc<Offers>,
    /// Regressors of the watched points, block by block, term by term, the highest peaks first; zeros fill the last.
    watched: Vec<f64>,
    /// v at the watched points, where it has been computed since runs or watched points last changed.
    values: Vec<f64>,
    /// v at all candidates.
    everywhere: Vec<f64>,
    /// Candidates near points asked for before: most runs stay where they are.
    near: HashMap<Vec<u64>, Rc<Offers>>,
    /// Counts the changes of runs, watched points and candidates with high v.
    version: u64,
    /// The version in which a run was last left where it is, and the stage of that.
    left: Vec<Option<(u64, Option<u32>)>>,
    scratch: Scratch,
}

/// What an exchange reuses.
#[derive(Debug, Default)]
struct Scratch {
    own: Vec<f64>,
    key: Vec<u64>,
    d_f: Vec<f64>,
    d_g: Vec<f64>,
    b_d_f: Vec<f64>,
    b_d_g: Vec<f64>,
    along_g: Vec<f64>,
}

impl<'a> Runs<'a> {
    fn new(search: &'a Discrete<'a>, x: Vec<f64>) -> Self {
        let (n, p) = (search.frame.multiplicities.len(), search.frame.n_terms());
        let matrices = Matrices::new(p);
        Self {
            rows: vec![0.0; n * p],
            variance: PredictionVariance::with_products(search.frame.products.clone(), &matrices.inverse),
            smooth: Smooth::new(search.frame, 12),
            matrices,
            search,
            x,
            high: Rc::default(),
            watched: Vec::new(),
            values: Vec::new(),
            everywhere: Vec::new(),
            near: HashMap::new(),
            version: 0,
            left: vec![None; n],
            scratch: Scratch::default(),
        }
    }

    /// Scans all candidates; the logarithm of the criterion, none if the design is singular.
    fn look_around(&mut self) -> Option<f64> {
        let frame = self.search.frame;
        frame.invert(&self.x, &mut self.rows, &mut self.matrices)?;
        self.variance.update(&self.matrices.inverse);
        let most = (WATCHED_SHARE, WATCHED);
        let near = self.search.candidates.scan(&self.variance, &self.matrices.inverse, most, &mut self.everywhere);
        let (k, p) = (frame.n_factors(), frame.n_terms());
        // The local maxima if they are known, else spread over the near-active points, not only the very highest.
        let n_near = near.points.len() / k;
        let stride = if near.n_peaks > 0 { 1 } else { (n_near / HIGH).max(1) };
        self.high = Rc::new(Offers::of(frame, near.points.chunks_exact(k).step_by(stride).take(HIGH)));
        self.touch();
        self.watched.clear();
        self.watched.resize(n_near.div_ceil(BLOCK) * p * BLOCK, 0.0);
        let mut row = vec![0.0; p];
        for (at, point) in near.points.chunks_exact(k).enumerate() {
            frame.regressors.fill(point, &mut row);
            let block = &mut self.watched[at / BLOCK * p * BLOCK..][..p * BLOCK];
            for (values, value) in block.chunks_exact_mut(BLOCK).zip(&row) {
                values[at % BLOCK] = *value;
            }
        }
        if frame.criterion == Criterion::G {
            return Some(near.highest.ln());
        }
        let mut gradient = vec![0.0; self.x.len()];
        Some(self.smooth.evaluate(&self.x, &mut gradient)).filter(|value| value.is_finite())
    }

    /// Offers every run, in random order, its best exchange, until `is_over`; whether any was made.
    fn pass(&mut self, stage: Option<u32>, generator: &mut Pcg64, is_over: IsOver<'_>) -> bool {
        let n = self.search.frame.multiplicities.len();
        let mut order: Vec<usize> = (0..n).collect();
        for i in (1..n).rev() {
            order.swap(i, generator.random_range(0..=i));
        }
        let mut changed = false;
        for run in order {
            if is_over() {
                break;
            }
            changed |= self.exchange(run, stage);
        }
        changed
    }

    /// Notes that what an exchange follows from has changed.
    fn touch(&mut self) {
        self.version += 1;
        self.values.clear();
    }

    /// Offers a run its best exchange; whether it was made.
    fn exchange(&mut self, run: usize, stage: Option<u32>) -> bool {
        // Nothing has changed since: it would be left where it is again.
        if self.left[run] == Some((self.version, stage)) {
            return false;
        }
        let made = self.make_exchange(run, stage);
        self.left[run] = (!made).then_some((self.version, stage));
        made
    }

    fn make_exchange(&mut self, run: usize, stage: Option<u32>) -> bool {
        let frame = self.search.frame;
        let k = frame.n_factors();
        let at = run * k..run * k + k;
        self.scratch.own.clear();
        self.scratch.own.extend_from_slice(&self.x[at.clone()]);
        let offers = [self.near(run), self.high.clone()];
        let offers = offers.iter().flat_map(|offers| offers.iter(frame));
        let best = match frame.criterion {
            Criterion::E | Criterion::T => self.best_exactly(run, offers),
            _ if frame.multiplicities[run] > 1.0 => self.best_exactly(run, offers),
            _ => self.best_by_formula(run, offers, stage),
        };
        let Some(point) = best else {
            return false;
        };
        self.x[at.clone()].copy_from_slice(point);
        if frame.invert(&self.x, &mut self.rows, &mut self.matrices).is_some() {
            self.touch();
            return true;
        }
        self.x[at].copy_from_slice(&self.scratch.own);
        frame.invert(&self.x, &mut self.rows, &mut self.matrices);
        false
    }

    /// The candidates near a run.
    fn near(&mut self, run: usize) -> Rc<Offers> {
        let (search, k) = (self.search, self.search.frame.n_factors());
        let own = &self.x[run * k..run * k + k];
        self.scratch.key.clear();
        self.scratch.key.extend(own.iter().map(|x| x.to_bits()));
        if let Some(near) = self.near.get(&self.scratch.key) {
            return near.clone();
        }
        let near = search.candidates.near(own, NEAR);
        let near = Rc::new(Offers::of(search.frame, near.iter().map(Vec::as_slice)));
        self.near.insert(self.scratch.key.clone(), near.clone());
        near
    }

    /// Whether a run may move to a point: it is not there, nor another that must differ from it.
    fn may_move(&self, run: usize, point: &[f64]) -> bool {
        let k = point.len();
        *point != self.x[run * k..run * k + k] && !self.search.is_taken(point, &self.x, run)
    }

    /// The offer with the best criterion, computed from scratch.
    fn best_exactly<'o>(
        &mut self,
        run: usize,
        offers: impl Iterator<Item = (&'o [f64], &'o [f64])>,
    ) -> Option<&'o [f64]> {
        let k = self.search.frame.n_factors();
        let mut x = self.x.clone();
        let mut gradient = vec![0.0; x.len()];
        let mut best = (self.value_of(&x, &mut gradient), None);
        for (offer, _) in offers {
            if !self.may_move(run, offer) {
                continue;
            }
            x[run * k..run * k + k].copy_from_slice(offer);
            let value = self.value_of(&x, &mut gradient);
            if value < best.0 - LEAST {
                best = (value, Some(offer));
            }
        }
        best.1
    }

    fn value_of(&mut self, x: &[f64], gradient: &mut [f64]) -> f64 {
        if self.search.frame.criterion != Criterion::G {
            return self.smooth.evaluate(x, gradient);
        }
        let frame = self.search.frame;
        let p = frame.n_terms();
        let mut rows = vec![0.0; self.rows.len()];
        let mut matrices = Matrices::new(p);
        if frame.invert(x, &mut rows, &mut matrices).is_none() {
            return f64::INFINITY;
        }
        let mut values = Vec::new();
        watched_variances(&self.watched, &matrices.inverse, p, &mut values);
        let highest = values.iter().copied().fold(0.0, f64::max);
        highest.ln()
    }

    /// The offer with the best criterion by the formulas above.
    ///
    /// Whether a run may move to an offer is asked only of those that would be better: they are few.
    fn best_by_formula<'o>(
        &mut self,
        run: usize,
        offers: impl Iterator<Item = (&'o [f64], &'o [f64])>,
        stage: Option<u32>,
    ) -> Option<&'o [f64]> {
        let (frame, criterion) = (self.search.frame, self.search.frame.criterion);
        let p = frame.n_terms();
        let inverse = &self.matrices.inverse;
        let g = &self.rows[run * p..run * p + p];
        let mut scratch = std::mem::take(&mut self.scratch);
        let Scratch { d_f, d_g, b_d_f, b_d_g, along_g, .. } = &mut scratch;
        for vector in [&mut *d_f, &mut *d_g, &mut *b_d_f, &mut *b_d_g] {
            vector.resize(p, 0.0);
        }
        let d_gg = project(inverse, g, d_g);
        let mut best: (f64, Option<&[f64]>) = (0.0, None);
        match criterion {
            Criterion::G => {
                // x'D g and v at the watched points.
                combine(&self.watched, d_g, along_g);
                if self.values.is_empty() {
                    watched_variances(&self.watched, inverse, p, &mut self.values);
                }
                best.0 = size(&self.values, stage);
            }
            Criterion::I => multiply(&frame.moments, p, d_g, b_d_g),
            _ => b_d_g.copy_from_slice(d_g),
        }
        let b_gg = dot(d_g, b_d_g);
        for (offer, f) in offers {
            let d_ff = project(inverse, f, d_f);
            let d_fg = dot(g, d_f);
            let delta = (1.0 + d_ff) * (1.0 - d_gg) + d_fg * d_fg;
            // An exchange that leaves almost nothing of the determinant leads nowhere.
            if delta.is_nan() || delta < 1e-6 {
                continue;
            }
            let value = match criterion {
                Criterion::D => -delta.ln(),
                Criterion::A | Criterion::I => {
                    match criterion {
                        Criterion::I => multiply(&frame.moments, p, d_f, b_d_f),
                        _ => b_d_f.copy_from_slice(d_f),
                    }
                    let (b_ff, b_fg) = (dot(d_f, b_d_f), dot(d_g, b_d_f));
                    -((1.0 - d_gg) * b_ff + 2.0 * d_fg * b_fg - (1.0 + d_ff) * b_gg) / delta
                }
                _ => {
                    let weights = [(1.0 - d_gg) / delta, 2.0 * d_fg / delta, (1.0 + d_ff) / delta];
                    let exchange = Exchange { d_f, weights, values: &self.values, along_g };
                    match size_exchanged(&self.watched, exchange, stage, best.0) {
                        Some(size) => size,
                        None => continue,
                    }
                }
            };
            if value < best.0 - LEAST * best.0.abs().max(1.0) && self.may_move(run, offer) {
                best = (value, Some(offer));
            }
        }
        self.scratch = scratch;
        best.1
    }
}

/// D f into `d_f`; f'D f.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx+avx2"))]
fn project(inverse: &[f64], f: &[f64], d_f: &mut [f64]) -> f64 {
    multiply(inverse, f.len(), f, d_f);
    dot(f, d_f)
}

/// (Σ v^q)^(1/q), or the largest v.
fn size(values: &[f64], stage: Option<u32>) -> f64 {
    let highest = values.iter().copied().fold(0.0, f64::max);
    match stage {
        Some(log_q) if highest > 0.0 => {
            let sum: f64 = values.iter().map(|v| power(v / highest, log_q)).sum();
            highest * (sum.ln() / f64::from(1 << log_q)).exp()
        }
        _ => highest,
    }
}

/// x to the power 2^`log`.
#[inline(always)]
fn power(x: f64, log: u32) -> f64 {
    (0..log).fold(x, |power, _| power * power)
}

/// What an exchange of g for f changes at the watched points.
#[derive(Clone, Copy)]
struct Exchange<'a> {
    d_f: &'a [f64],
    /// Of (x'D f)², (x'D f)(x'D g) and −(x'D g)².
    weights: [f64; 3],
    /// v and x'D g at the watched points, before.
    values: &'a [f64],
    along_g: &'a [f64],
}

/// The size of v after an exchange; none as soon as it is known to be no smaller than the best.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx+avx2"))]
fn size_exchanged(watched: &[f64], exchange: Exchange<'_>, stage: Option<u32>, best: f64) -> Option<f64> {
    let [ff, fg, gg] = exchange.weights;
    let scale = 1.0 / best;
    let log_q = stage.unwrap_or(0);
    let (mut highest, mut sum) = (0.0, 0.0);
    let blocks = watched.chunks_exact(exchange.d_f.len() * BLOCK);
    let known = exchange.values.chunks_exact(BLOCK).zip(exchange.along_g.chunks_exact(BLOCK));
    for (block, (values, along_g)) in blocks.zip(known) {
        let mut along_f = [0.0; BLOCK];
        for (row, c) in block.chunks_exact(BLOCK).zip(exchange.d_f) {
            for lane in 0..BLOCK {
                along_f[lane] += c * row[lane];
            }
        }
        let mut changed = [0.0; BLOCK];
        for lane in 0..BLOCK {
            let (f, g) = (along_f[lane], along_g[lane]);
            changed[lane] = scale * (values[lane] - (ff * f * f + fg * f * g - gg * g * g));
        }
        let mut lanes = [0.0; 8];
        for eight in changed.chunks_exact(8) {
            for lane in 0..8 {
                lanes[lane] = if eight[lane] > lanes[lane] { eight[lane] } else { lanes[lane] };
            }
        }
        highest = lanes.iter().copied().fold(highest, f64::max);
        if highest >= 1.0 {
            return None;
        }
        if stage.is_some() {
            for _ in 0..log_q {
                for value in &mut changed {
                    *value *= *value;
                }
            }
            let mut lanes = [0.0; 8];
            for eight in changed.chunks_exact(8) {
                for lane in 0..8 {
                    lanes[lane] += eight[lane];
                }
            }
            sum += lanes.iter().sum::<f64>();
            if sum >= 1.0 {
                return None;
            }
        }
    }
    Some(if stage.is_some() { best * (sum.ln() / f64::from(1 << log_q)).exp() } else { best * highest })
}

/// Σ_t c_t x_t at every watched point.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx+avx2"))]
fn combine(watched: &[f64], coefficients: &[f64], sums: &mut Vec<f64>) {
    sums.clear();
    for block in watched.chunks_exact(coefficients.len() * BLOCK) {
        let mut lanes = [0.0; BLOCK];
        for (row, c) in block.chunks_exact(BLOCK).zip(coefficients) {
            for lane in 0..BLOCK {
                lanes[lane] += c * row[lane];
            }
        }
        sums.extend_from_slice(&lanes);
    }
}

/// v at every watched point.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx+avx2"))]
fn watched_variances(watched: &[f64], inverse: &[f64], p: usize, values: &mut Vec<f64>) {
    values.clear();
    for block in watched.chunks_exact(p * BLOCK) {
        let mut lanes = [0.0; BLOCK];
        for (i, row) in block.chunks_exact(BLOCK).enumerate() {
            let mut sums = [0.0; BLOCK];
            for (other, c) in block.chunks_exact(BLOCK).zip(&inverse[i * p..i * p + p]) {
                for lane in 0..BLOCK {
                    sums[lane] += c * other[lane];
                }
            }
            for lane in 0..BLOCK {
                lanes[lane] += sums[lane] * row[lane];
            }
        }
        values.extend_from_slice(&lanes);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::products::Products;
    use crate::same::SAME_RUN;
    use crate::shape::Shape;
    use crate::{Model, Problem, Space};
    use rand::SeedableRng;

    /// A search without a continuous solution and without fixed runs.
    fn plain<'a>(frame: &'a Frame, candidates: &'a Candidates<'a>, is_distinct: bool) -> Discrete<'a> {
        Discrete { frame, candidates, relaxed: None, n_relaxed: 1, apart: SAME_RUN, is_distinct, fixed: Vec::new() }
    }

    #[test]
    fn formulas_choose_what_computing_from_scratch_chooses() {
        let space = Space::grid(&[5, 5]).expect("a grid");
        let Shape::Box(shape) = space.shape() else { unreachable!("a grid is a box") };
        let candidates = Candidates::grid(shape, &Products::of(&Model::quadratic(2).expect("a model")));
        let mut generator = Pcg64::seed_from_u64(5);
        let mut compared = 0;
        let criteria = [Criterion::D, Criterion::A, Criterion::I, Criterion::G];
        // Six runs are as many as terms: every exchange for another of them leaves a singular design.
        for (criterion, n) in criteria.into_iter().flat_map(|criterion| [(criterion, 9), (criterion, 6)]) {
            let problem =
                Problem::new(Model::quadratic(2).expect("a model"), space.clone(), n, criterion).expect("sound");
            let frame = Frame::of(&problem, Some(&shape.relaxed()), f64::NEG_INFINITY, &<[f64]>::to_vec);
            let frame = frame.expect("a frame");
            let search = plain(&frame, &candidates, false);
            for _ in 0..20 {
                let x = search.greedy(&mut generator).expect("nine runs");
                let mut runs = Runs::new(&search, x);
                if runs.look_around().is_none() {
                    continue;
                }
                let mut offers: Vec<Vec<f64>> = (0..12).map(|_| candidates.sample(&mut generator)).collect();
                offers.extend(runs.x.chunks_exact(2).map(<[f64]>::to_vec));
                let offers = Offers::of(&frame, offers.iter().map(Vec::as_slice));
                for run in 0..n {
                    let by_formula = runs.best_by_formula(run, offers.iter(&frame), None);
                    let exactly = runs.best_exactly(run, offers.iter(&frame));
                    // Mirror images and the same candidate twice may tie: then the values count.
                    let mut value = |choice: Option<&[f64]>| {
                        let mut x = runs.x.clone();
                        if let Some(point) = choice {
                            x[run * 2..run * 2 + 2].copy_from_slice(point);
                        }
                        let mut gradient = vec![0.0; x.len()];
                        runs.value_of(&x, &mut gradient)
                    };
                    let (one, other) = (value(by_formula), value(exactly));
                    assert!((one - other).abs() < 1e-7, "{criterion}: {one} is not {other}");
                    compared += 1;
                }
            }
        }
        assert!(compared > 400, "{compared}");
    }

    #[test]
    fn size_is_a_power_mean_that_tends_to_the_largest() {
        let values = [1.0, 3.0, 2.0, 0.5];
        assert!((size(&values, Some(2)) - (1.0 + 81.0 + 16.0 + 0.0625_f64).powf(0.25)).abs() < 1e-14);
        assert!((size(&values, Some(10)) - 3.0).abs() < 1e-14);
        assert_eq!(size(&values, None).to_bits(), 3.0_f64.to_bits());
        assert_eq!(size(&[0.0; 3], Some(5)).to_bits(), 0.0_f64.to_bits());
    }

    /// They take little time beside the exchanges after them; few factors do without.
    #[test]
    fn a_thorough_start_in_many_factors_rounds_the_best_of_several_designs() {
        for (effort, k, several) in
            [(Effort::Quick, 5, false), (Effort::Thorough, 2, false), (Effort::Thorough, 3, true)]
        {
            assert_eq!(n_relaxed(effort, k) > 1, several, "{effort:?} in {k} factors");
        }
    }

    /// Near every run of a grid of 25 points lie all of them.
    #[test]
    fn a_start_ends_where_no_exchange_of_one_run_is_better() {
        let space = Space::grid(&[5, 5]).expect("a grid");
        let Shape::Box(shape) = space.shape() else { unreachable!("a grid is a box") };
        let model = Model::quadratic(2).expect("a model");
        let candidates = Candidates::grid(shape, &Products::of(&model));
        let all: Vec<[f64; 2]> = (0..25).map(|i| [i / 5, i % 5].map(|level| f64::from(level) / 2.0 - 1.0)).collect();
        for criterion in [Criterion::D, Criterion::A, Criterion::I] {
            let problem = Problem::new(model.clone(), space.clone(), 9, criterion).expect("sound");
            let frame = Frame::of(&problem, Some(&shape.relaxed()), f64::NEG_INFINITY, &<[f64]>::to_vec);
            let frame = frame.expect("a frame");
            let search = plain(&frame, &candidates, true);
            for seed in 0..4 {
                let attempt = search.start(&mut Pcg64::seed_from_u64(seed), &Incumbents::default(), &|| false);
                let Attempt::Found { x, .. } = attempt else { panic!("a start without a design") };
                let mut runs = Runs::new(&search, x);
                runs.look_around().expect("not singular");
                let offers = Offers::of(&frame, all.iter().map(|point| &point[..]));
                for run in 0..9 {
                    let better = runs.best_exactly(run, offers.iter(&frame));
                    assert!(better.is_none(), "{criterion}, seed {seed}: run {run} to {better:?}");
                }
            }
        }
    }

    /// One term, equal to 1 at 64 points: an exchange takes off all of them the same.
    #[test]
    fn size_after_an_exchange_is_that_of_the_changed_variances() {
        let watched = vec![1.0; 2 * BLOCK];
        let values: Vec<f64> = (0..2 * BLOCK).map(|point| 1.0 + 0.01 * point as f64).collect();
        let along_g = vec![0.5; 2 * BLOCK];
        // v − (0.4 f² + 0.2 f g − 0.6 g²) with f = 1 and g = 1/2.
        let exchange = Exchange { d_f: &[1.0], weights: [0.4, 0.2, 0.6], values: &values, along_g: &along_g };
        let changed: Vec<f64> = values.iter().map(|v| v - (0.4 + 0.1 - 0.15)).collect();
        for stage in [None, Some(3), Some(7)] {
            let (before, after) = (size(&values, stage), size(&changed, stage));
            let found = size_exchanged(&watched, exchange, stage, before).expect("it is smaller");
            assert!((found - after).abs() < 1e-12, "{stage:?}: {found} is not {after}");
            assert_eq!(
                size_exchanged(&watched, exchange, stage, 0.999 * after),
                None,
                "{stage:?}: no better than that"
            );
        }
    }
}
