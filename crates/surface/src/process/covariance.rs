//! The covariance of a process: constant, trend, simulation and Matérn residual.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};
use multiversion::multiversion;
use serde::{Deserialize, Serialize};

use crate::exponential::exp_of_negative;
use crate::lanes::{LANES, Lanes};
use crate::process::places::Places;

/// What is made of the simulation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SimulationUse {
    /// Nothing: the response is learnt from the measurements alone.
    Ignored,
    /// It is subtracted: what is learnt is the discrepancy y − s.
    Subtracted,
    /// It enters with a factor ρ that is learnt, around 1.
    Scaled,
}

/// Which parts a response is made of, besides a constant, a quadratic trend and noise.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Structure {
    /// What is made of the simulation.
    pub simulation: SimulationUse,
    /// What there is beside trend and simulation.
    pub residual: Residual,
}

/// What a response has that neither its trend nor the simulation has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Residual {
    /// Nothing: the response is a polynomial, or a simulation corrected by one.
    None,
    /// A function with two derivatives: Matérn-5/2.
    Smooth,
    /// A function with one derivative, as kinks nearly are: Matérn-3/2.
    Rough,
}

impl Structure {
    /// All structures, those without a simulation first.
    pub const ALL: [Self; 9] = {
        let mut all = [Self { simulation: SimulationUse::Ignored, residual: Residual::None }; 9];
        let simulations = [SimulationUse::Ignored, SimulationUse::Subtracted, SimulationUse::Scaled];
        let residuals = [Residual::None, Residual::Smooth, Residual::Rough];
        let mut index = 0;
        while index < all.len() {
            all[index] = Self { simulation: simulations[index / 3], residual: residuals[index % 3] };
            index += 1;
        }
        all
    };

    /// ρ before anything was measured.
    pub(crate) fn prior_factor(self) -> f64 {
        if self.simulation == SimulationUse::Ignored { 0.0 } else { 1.0 }
    }
}

/// Variances and lengths of a process; variances in units of the squared scale of the data.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hyperparameters {
    /// τ², of each coefficient of the trend.
    pub trend: f64,
    /// κ², of ρ around 1.
    pub simulation: f64,
    /// v, of the Matérn residual.
    pub residual: f64,
    /// ℓ_j, along each axis, in coded units.
    pub lengths: Vec<f64>,
    /// σ², of a measurement of weight 1.
    pub noise: f64,
    /// Of the error that all measurements of one assembly share; 0 where assemblies are not told apart.
    #[serde(default)]
    pub assembly: f64,
}

/// The covariance of a process before anything was measured, for those who build on it.
#[derive(Debug, Clone)]
pub struct Covariance<'a> {
    structure: Structure,
    hyper: &'a Hyperparameters,
    constant: f64,
}

impl<'a> Covariance<'a> {
    /// Of a structure with these hyperparameters; simulated responses count as they are.
    #[must_use]
    pub fn of(structure: Structure, hyper: &'a Hyperparameters) -> Self {
        Self { structure, hyper, constant: CONSTANT }
    }

    /// The same without the variance of the constant, 4.
    #[must_use]
    pub fn without_constant(self) -> Self {
        Self { constant: 0.0, ..self }
    }

    /// Covariances of places (rows) with others (columns), without noise.
    #[must_use]
    pub fn between(&self, rows: &Places, columns: &Places) -> Mat<f64> {
        let mut matrix = Parts::between(rows, columns, &|s| s).covariance(self.structure, self.hyper);
        matrix.col_iter_mut().for_each(|column| column.iter_mut().for_each(|value| *value += self.constant - CONSTANT));
        matrix
    }

    /// Variance at each place, without noise.
    #[must_use]
    pub fn variances(&self, places: &Places) -> Vec<f64> {
        let variances = prior_variances(places, self.structure, self.hyper, &|s| s);
        variances.into_iter().map(|variance| variance + self.constant - CONSTANT).collect()
    }
}

/// Variance of the constant, in units of the squared scale of the data.
pub(crate) const CONSTANT: f64 = 4.0;

/// What the covariances between two sets of places have in common, whatever the hyperparameters.
#[derive(Debug, Clone)]
pub(crate) struct Parts<'a> {
    rows: &'a Places,
    columns: Vec<Vec<f64>>,
    /// QQ', a row per place of `rows`.
    trend: Mat<f64>,
    /// What the simulation says, centered and scaled.
    simulated: Option<[Vec<f64>; 2]>,
}

impl<'a> Parts<'a> {
    /// Between these places; `simulated` maps a simulated response to the centered and scaled one.
    pub(crate) fn between(rows: &'a Places, columns: &Places, simulated: &dyn Fn(f64) -> f64) -> Self {
        let (left, right) = (rows.trend(), columns.trend());
        let mut trend = Mat::zeros(rows.n_places(), columns.n_places());
        matmul(trend.as_mut(), Accum::Replace, &left, right.transpose(), 1.0, Par::Seq);
        let scaled = |places: &Places| Some(places.simulated()?.iter().map(|&s| simulated(s)).collect());
        let simulated = scaled(rows).zip(scaled(columns)).map(|(rows, columns)| [rows, columns]);
        let columns = (0..columns.n_places()).map(|place| columns.point(place)).collect();
        Self { rows, columns, trend, simulated }
    }

    /// The covariance without noise, a row per place of `rows`.
    pub(crate) fn covariance(&self, structure: Structure, hyper: &Hyperparameters) -> Mat<f64> {
        let mut matrix = Mat::zeros(self.rows.n_places(), self.columns.len());
        for column in 0..self.columns.len() {
            if let Some(into) = matrix.col_mut(column).try_as_col_major_mut() {
                self.column(structure, hyper, column, 0, into.as_slice_mut());
            }
        }
        matrix
    }

    /// The lower half of a covariance of places with themselves; the rest is zero.
    pub(crate) fn lower_half(&self, structure: Structure, hyper: &Hyperparameters) -> Mat<f64> {
        let mut matrix = Mat::zeros(self.rows.n_places(), self.columns.len());
        for column in 0..self.columns.len() {
            if let Some(into) = matrix.col_mut(column).try_as_col_major_mut() {
                self.column(structure, hyper, column, column, &mut into.as_slice_mut()[column..]);
            }
        }
        matrix
    }

    /// Covariances of the places from `first` on with one of the columns.
    fn column(&self, structure: Structure, hyper: &Hyperparameters, column: usize, first: usize, into: &mut [f64]) {
        if let Some(trend) = self.trend.col(column).try_as_col_major() {
            for (value, trend) in into.iter_mut().zip(&trend.as_slice()[first..]) {
                *value = CONSTANT + hyper.trend * trend;
            }
        }
        if let (SimulationUse::Scaled, Some([rows, columns])) = (structure.simulation, &self.simulated) {
            let factor = hyper.simulation * columns[column];
            for (value, t) in into.iter_mut().zip(&rows[first..]) {
                *value += factor * t;
            }
        }
        if structure.residual != Residual::None {
            let rates: Vec<f64> = hyper.lengths.iter().map(|length| 1.0 / (length * length)).collect();
            let axes: Vec<&[f64]> = (0..rates.len()).map(|axis| &self.rows.axis(axis)[first..]).collect();
            let point = &self.columns[column];
            match structure.residual {
                Residual::Rough => add_rough(&axes, point, &rates, hyper.residual, into),
                _ => add_smooth(&axes, point, &rates, hyper.residual, into),
            }
        }
    }
}

/// The prior variance without noise at places whose simulated response is centered and scaled.
pub(crate) fn prior_variances(
    places: &Places,
    structure: Structure,
    hyper: &Hyperparameters,
    simulated: &dyn Fn(f64) -> f64,
) -> Vec<f64> {
    let trend = places.trend();
    let residual = if structure.residual == Residual::None { 0.0 } else { hyper.residual };
    let simulation = |place: usize| match (structure.simulation, places.simulated()) {
        (SimulationUse::Scaled, Some(all)) => hyper.simulation * simulated(all[place]).powi(2),
        _ => 0.0,
    };
    let of_trend = |place: usize| (0..trend.ncols()).map(|column| trend[(place, column)].powi(2)).sum::<f64>();
    (0..places.n_places())
        .map(|place| CONSTANT + hyper.trend * of_trend(place) + simulation(place) + residual)
        .collect()
}

/// The Matérn-5/2 correlation at a squared distance in lengths: (1 + r + r²/3) exp(−r) with r = √5 d.
#[inline(always)]
pub(crate) fn smooth(squared_distance: f64) -> f64 {
    let square = 5.0 * squared_distance;
    let r = square.sqrt();
    (1.0 + r + square / 3.0) * exp_of_negative(-r)
}

/// The Matérn-3/2 correlation at a squared distance in lengths: (1 + r) exp(−r) with r = √3 d.
#[inline(always)]
pub(crate) fn rough(squared_distance: f64) -> f64 {
    let r = (3.0 * squared_distance).sqrt();
    (1.0 + r) * exp_of_negative(-r)
}

/// Adds `variance` times the Matérn-5/2 correlation of each place with `point`; `rates` are the inverse squared lengths.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx+avx2"))]
fn add_smooth(axes: &[&[f64]], point: &[f64], rates: &[f64], variance: f64, into: &mut [f64]) {
    add_correlations(axes, point, rates, into, |square| variance * smooth(square));
}

/// As [`add_smooth`], Matérn-3/2.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx+avx2"))]
fn add_rough(axes: &[&[f64]], point: &[f64], rates: &[f64], variance: f64, into: &mut [f64]) {
    add_correlations(axes, point, rates, into, |square| variance * rough(square));
}

#[inline(always)]
fn add_correlations(axes: &[&[f64]], point: &[f64], rates: &[f64], into: &mut [f64], covariance: impl Fn(f64) -> f64) {
    for (block, into) in into.chunks_mut(LANES).enumerate() {
        let mut squares: Lanes = [0.0; LANES];
        for ((axis, &center), &rate) in axes.iter().zip(point).zip(rates) {
            let axis = &axis[block * LANES..][..into.len()];
            for (square, x) in squares.iter_mut().zip(axis) {
                *square += rate * ((x - center) * (x - center));
            }
        }
        for square in &mut squares {
            *square = covariance(*square);
        }
        for (value, covariance) in into.iter_mut().zip(&squares) {
            *value += covariance;
        }
    }
}
