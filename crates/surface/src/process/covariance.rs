//! The covariance of a process: constant, trend, simulation and Matérn residual.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};
use multiversion::multiversion;
use serde::{Deserialize, Serialize};

use crate::Error;
use crate::exponential::exp_of_minus;
use crate::lanes::{LANES, Lanes, check_factors};
use crate::process::places::Places;
use crate::process::sites::{Units, check_axes};

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
    /// Of the part of the response that depends on some axes alone, where there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub additive: Option<Additive>,
}

/// A part of the response that depends on some axes alone, whatever the others are: with the residual, an additive Gaussian
/// process (Duvenaud et al. 2011). It is as smooth as the residual.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Additive {
    /// The axes, counted from 0.
    pub axes: Vec<usize>,
    /// Its variance.
    pub variance: f64,
    /// A length along each of these axes, in coded units.
    pub lengths: Vec<f64>,
}

/// A term of Matérn covariance.
pub(crate) struct Matern {
    pub(crate) variance: f64,
    /// The inverse squared length along each axis; 0 where it does not depend on one.
    pub(crate) rates: Vec<f64>,
    pub(crate) is_rough: bool,
}

impl Hyperparameters {
    /// Whether a process of so many factors can have them.
    pub(crate) fn check(&self, n_factors: usize) -> Result<(), Error> {
        self.check_axes(n_factors)?;
        self.check_values()
    }

    /// Whether there is a length along every axis, and along every one of the additive part.
    fn check_axes(&self, n_factors: usize) -> Result<(), Error> {
        if self.lengths.len() != n_factors {
            return Err(Error::Length { name: "lengths", expected: n_factors, found: self.lengths.len() });
        }
        let Some(additive) = &self.additive else { return Ok(()) };
        check_axes(&additive.axes, n_factors)?;
        let (expected, found) = (additive.axes.len(), additive.lengths.len());
        if expected != found {
            return Err(Error::Length { name: "lengths of the additive part", expected, found });
        }
        Ok(())
    }

    /// Whether every variance and length can be one.
    fn check_values(&self) -> Result<(), Error> {
        let none = |name, value, expected| Err(Error::Parameter { name, value, expected });
        let additive = self.additive.as_ref();
        let variances = [
            ("trend", self.trend),
            ("simulation", self.simulation),
            ("residual", self.residual),
            ("noise", self.noise),
            ("assembly", self.assembly),
            ("variance of the additive part", additive.map_or(0.0, |additive| additive.variance)),
        ];
        if let Some(&(name, value)) = variances.iter().find(|(_, value)| !(*value >= 0.0 && value.is_finite())) {
            return none(name, value, "a finite variance from 0 on");
        }
        let lengths = self.lengths.iter().chain(additive.into_iter().flat_map(|additive| &additive.lengths));
        match lengths.copied().find(|length| !(*length > 0.0 && length.is_finite())) {
            Some(length) => none("length", length, "a finite length above 0"),
            None => Ok(()),
        }
    }

    /// The terms of Matérn covariance: the residual, if there is one, and the additive part.
    pub(crate) fn matern_terms(&self, structure: Structure) -> Vec<Matern> {
        let rate = |length: &f64| 1.0 / (length * length);
        let is_rough = structure.residual == Residual::Rough;
        let residual = (structure.residual != Residual::None).then(|| {
            let rates = self.lengths.iter().map(rate).collect();
            Matern { variance: self.residual, rates, is_rough }
        });
        let additive = self.additive.as_ref().map(|additive| {
            let mut rates = vec![0.0; self.lengths.len()];
            additive.axes.iter().zip(&additive.lengths).for_each(|(&axis, length)| rates[axis] = rate(length));
            Matern { variance: additive.variance, rates, is_rough }
        });
        residual.into_iter().chain(additive).collect()
    }
}

/// The covariance of a process before anything was measured, for those who build on it.
#[derive(Debug, Clone)]
pub struct Covariance<'a> {
    structure: Structure,
    hyper: &'a Hyperparameters,
    constant: f64,
}

impl<'a> Covariance<'a> {
    /// Of a structure with these hyperparameters, which have a length for each factor; simulated responses count as they are.
    ///
    /// # Errors
    ///
    /// [`Error::Count`] for the number of lengths, [`Error::Parameter`] for a variance that is negative, a length that is not
    /// positive or an axis of the additive part that is not there, [`Error::Length`] unless that has a length for each axis.
    pub fn of(structure: Structure, hyper: &'a Hyperparameters) -> Result<Self, Error> {
        let n_factors = hyper.lengths.len();
        check_factors(n_factors)?;
        hyper.check(n_factors)?;
        Ok(Self { structure, hyper, constant: CONSTANT })
    }

    /// The same without the variance of the constant, 4.
    #[must_use]
    pub fn without_constant(self) -> Self {
        Self { constant: 0.0, ..self }
    }

    /// Covariances of places (rows) with others (columns), without noise.
    ///
    /// # Errors
    ///
    /// [`Error::FactorMismatch`] unless the places have as many factors as there are lengths.
    pub fn between(&self, rows: &Places, columns: &Places) -> Result<Mat<f64>, Error> {
        self.check(rows)?;
        self.check(columns)?;
        let mut matrix = Parts::between(rows, columns, Units::NONE).covariance(self.structure, self.hyper);
        matrix.col_iter_mut().for_each(|column| column.iter_mut().for_each(|value| *value += self.constant - CONSTANT));
        Ok(matrix)
    }

    /// Variance at each place, without noise.
    ///
    /// # Errors
    ///
    /// As [`between`](Self::between).
    pub fn variances(&self, places: &Places) -> Result<Vec<f64>, Error> {
        self.check(places)?;
        let variances = prior_variances(places, self.structure, self.hyper, Units::NONE);
        Ok(variances.into_iter().map(|variance| variance + self.constant - CONSTANT).collect())
    }

    fn check(&self, places: &Places) -> Result<(), Error> {
        places.check_factors(self.hyper.lengths.len())
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
    /// What that may be off by, scaled.
    deviations: Vec<[Vec<f64>; 2]>,
    /// Covariances of what is not known of it, scaled, where there is any of both.
    unknown: Option<Mat<f64>>,
}

impl<'a> Parts<'a> {
    /// Between these places, in these units.
    pub(crate) fn between(rows: &'a Places, columns: &Places, units: Units) -> Self {
        let (left, right) = (rows.trend(), columns.trend());
        let mut trend = Mat::zeros(rows.n_places(), columns.n_places());
        matmul(trend.as_mut(), Accum::Replace, &left, right.transpose(), 1.0, Par::Seq);
        let scaled = |places: &Places| Some(places.simulated()?.iter().map(|&s| units.simulated(s)).collect());
        let simulated = scaled(rows).zip(scaled(columns)).map(|(rows, columns)| [rows, columns]);
        let scaled = |all: &Vec<f64>| all.iter().map(|&deviation| units.deviation(deviation)).collect();
        let deviations = rows.deviations().iter().zip(columns.deviations());
        let deviations = deviations.map(|(rows, columns)| [scaled(rows), scaled(columns)]).collect();
        let points: Vec<Vec<f64>> = (0..columns.n_places()).map(|place| columns.point(place)).collect();
        let unknown = [rows, columns].map(|places| scaled(&places.unknown().to_vec()));
        let unknown =
            unknown.iter().all(|all: &Vec<f64>| !all.is_empty()).then(|| unknown_parts(rows, &points, &unknown));
        Self { rows, columns: points, trend, simulated, deviations, unknown }
    }

    /// The covariance without noise, a row per place of `rows`.
    pub(crate) fn covariance(mut self, structure: Structure, hyper: &Hyperparameters) -> Mat<f64> {
        let mut matrix = std::mem::replace(&mut self.trend, Mat::new());
        for column in 0..self.columns.len() {
            if let Some(into) = matrix.col_mut(column).try_as_col_major_mut() {
                let into = into.as_slice_mut();
                constant_and_trend(hyper.trend, into);
                self.add_simulation(structure, hyper, column, 0, into);
            }
        }
        self.add_residuals(structure, hyper, false, &mut matrix);
        matrix
    }

    /// The lower half of a covariance of places with themselves; the rest is zero.
    pub(crate) fn lower_half(&self, structure: Structure, hyper: &Hyperparameters) -> Mat<f64> {
        let mut matrix = Mat::zeros(self.rows.n_places(), self.columns.len());
        for column in 0..self.columns.len() {
            if let Some(into) = matrix.col_mut(column).try_as_col_major_mut() {
                let into = &mut into.as_slice_mut()[column..];
                if let Some(trend) = self.trend.col(column).try_as_col_major() {
                    into.copy_from_slice(&trend.as_slice()[column..]);
                    constant_and_trend(hyper.trend, into);
                }
                self.add_simulation(structure, hyper, column, column, into);
            }
        }
        self.add_residuals(structure, hyper, true, &mut matrix);
        matrix
    }

    /// Adds the covariances of what the simulation says at the places from `first` on with that at one of the columns.
    fn add_simulation(
        &self,
        structure: Structure,
        hyper: &Hyperparameters,
        column: usize,
        first: usize,
        into: &mut [f64],
    ) {
        if let (SimulationUse::Scaled, Some([rows, columns])) = (structure.simulation, &self.simulated) {
            add_times(hyper.simulation * columns[column], &rows[first..], into);
        }
        if structure.simulation != SimulationUse::Ignored {
            for [rows, columns] in &self.deviations {
                add_times(columns[column], &rows[first..], into);
            }
            if let Some(unknown) = self.unknown.as_ref().and_then(|unknown| unknown.col(column).try_as_col_major()) {
                add_times(1.0, &unknown.as_slice()[first..], into);
            }
        }
    }

    /// Adds the terms of Matérn covariance: all of each, or the lower half of a square.
    fn add_residuals(&self, structure: Structure, hyper: &Hyperparameters, is_lower: bool, matrix: &mut Mat<f64>) {
        for Matern { variance, rates, is_rough } in hyper.matern_terms(structure) {
            let pairs = Pairs { rows: self.rows, columns: &self.columns, rates: &rates, variance, is_lower };
            pairs.add(matrix, if is_rough { rough } else { smooth });
        }
    }
}

/// The covariances of the unknown parts of these standard deviations.
fn unknown_parts(rows: &Places, columns: &[Vec<f64>], deviations: &[Vec<f64>; 2]) -> Mat<f64> {
    let mut matrix = Mat::zeros(rows.n_places(), columns.len());
    let rates = vec![1.0; rows.n_factors()];
    Pairs { rows, columns, rates: &rates, variance: 1.0, is_lower: false }.add(&mut matrix, smooth);
    for (column, of_column) in matrix.col_iter_mut().zip(&deviations[1]) {
        column.iter_mut().zip(&deviations[0]).for_each(|(value, of_row)| *value *= of_row * of_column);
    }
    matrix
}

/// What a term of Matérn covariance is computed from.
struct Pairs<'a> {
    rows: &'a Places,
    columns: &'a [Vec<f64>],
    /// The inverse squared lengths.
    rates: &'a [f64],
    variance: f64,
    is_lower: bool,
}

impl Pairs<'_> {
    /// Adds them, for [`LANES`] rows and two columns at a time.
    fn add(&self, matrix: &mut Mat<f64>, correlations: Correlations) {
        let (n_rows, mut block) = (self.rows.n_places(), vec![[0.0; LANES]; self.rates.len()]);
        let mut both = [[0.0; LANES]; 2];
        for start in (0..n_rows).step_by(LANES) {
            let end = n_rows.min(start + LANES);
            for (axis, lanes) in block.iter_mut().enumerate() {
                lanes[..end - start].copy_from_slice(&self.rows.axis(axis)[start..end]);
            }
            let n_columns = if self.is_lower { end } else { self.columns.len() };
            for column in (0..n_columns).step_by(2) {
                let other = n_columns.min(column + 2) - 1;
                correlations(&block, [&self.columns[column], &self.columns[other]], self.rates, &mut both);
                for (column, of_column) in (column..=other).zip(&both) {
                    let from = if self.is_lower { start.max(column) } else { start };
                    if let Some(into) = matrix.col_mut(column).try_as_col_major_mut() {
                        add_times(self.variance, &of_column[from - start..], &mut into.as_slice_mut()[from..end]);
                    }
                }
            }
        }
    }
}

/// Correlations of places side by side with two points; the third are the inverse squared lengths.
type Correlations = fn(&[Lanes], [&[f64]; 2], &[f64], &mut [Lanes; 2]);

/// The prior variance without noise at places, in these units.
pub(crate) fn prior_variances(
    places: &Places,
    structure: Structure,
    hyper: &Hyperparameters,
    units: Units,
) -> Vec<f64> {
    let trend = places.trend();
    let residual: f64 = hyper.matern_terms(structure).iter().map(|term| term.variance).sum();
    let simulation = |place: usize| match (structure.simulation, places.simulated()) {
        (SimulationUse::Scaled, Some(all)) => hyper.simulation * units.simulated(all[place]).powi(2),
        _ => 0.0,
    };
    let deviation = |place: usize| match structure.simulation {
        SimulationUse::Ignored => 0.0,
        _ => {
            let unknown = places.unknown().get(place).map_or(0.0, |unknown| units.deviation(*unknown).powi(2));
            unknown + places.deviations().iter().map(|all| units.deviation(all[place]).powi(2)).sum::<f64>()
        }
    };
    let of_trend = |place: usize| (0..trend.ncols()).map(|column| trend[(place, column)].powi(2)).sum::<f64>();
    (0..places.n_places())
        .map(|place| CONSTANT + hyper.trend * of_trend(place) + simulation(place) + deviation(place) + residual)
        .collect()
}

/// A constant and so many times each number.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx+avx2"))]
fn constant_and_trend(factor: f64, numbers: &mut [f64]) {
    numbers.iter_mut().for_each(|number| *number = CONSTANT + factor * *number);
}

/// Adds so many times each of these numbers.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx+avx2"))]
fn add_times(factor: f64, numbers: &[f64], into: &mut [f64]) {
    into.iter_mut().zip(numbers).for_each(|(value, number)| *value += factor * number);
}

/// Matérn-5/2: (1 + r + r²/3) exp(−r) with r = √5 d.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx+avx2"))]
fn smooth(block: &[Lanes], points: [&[f64]; 2], rates: &[f64], correlations: &mut [Lanes; 2]) {
    let (mut r, mut factors) = (squared_distances(block, points, rates), [[0.0; LANES]; 2]);
    for row in 0..2 {
        for lane in 0..LANES {
            let square = 5.0 * r[row][lane];
            r[row][lane] = square.sqrt();
            factors[row][lane] = 1.0 + r[row][lane] + square / 3.0;
        }
    }
    let exponentials = exp_of_minus(&r);
    for row in 0..2 {
        for lane in 0..LANES {
            correlations[row][lane] = factors[row][lane] * exponentials[row][lane];
        }
    }
}

/// Matérn-3/2: (1 + r) exp(−r) with r = √3 d.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx+avx2"))]
fn rough(block: &[Lanes], points: [&[f64]; 2], rates: &[f64], correlations: &mut [Lanes; 2]) {
    let mut r = squared_distances(block, points, rates);
    r.as_flattened_mut().iter_mut().for_each(|square| *square = (3.0 * *square).sqrt());
    let exponentials = exp_of_minus(&r);
    for row in 0..2 {
        for lane in 0..LANES {
            correlations[row][lane] = (1.0 + r[row][lane]) * exponentials[row][lane];
        }
    }
}

/// Squared distances of places with two points, in lengths.
#[inline(always)]
fn squared_distances(block: &[Lanes], points: [&[f64]; 2], rates: &[f64]) -> [Lanes; 2] {
    let mut squares = [[0.0; LANES]; 2];
    for (axis, (x, &rate)) in block.iter().zip(rates).enumerate() {
        for (of_point, point) in squares.iter_mut().zip(points) {
            let center = point[axis];
            for lane in 0..LANES {
                of_point[lane] += rate * ((x[lane] - center) * (x[lane] - center));
            }
        }
    }
    squares
}
