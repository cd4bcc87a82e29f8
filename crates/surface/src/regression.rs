//! Weighted least squares, (30) and (31).

use doe::{Confounding, Design, Model, confounded_terms_of_design};
use faer::{Mat, MatRef};
use serde::{Deserialize, Serialize};

use crate::lanes::is_usable;
use crate::polynomial::Polynomial;
use crate::{Data, Error, GridPoints, Lanes, LeaveOneOut, OverGrid, Surface};

/// A polynomial whose coefficients minimize the weighted sum of squared residuals.
///
/// ```text
/// Ĵ(p) = r(p)'b        b = arg min Σ w_i (J_i − r_i'b)²
/// ```
///
/// Source: (30), (31)
///
/// The weights are relative precisions: the error of point i has the variance σ²/w_i, with one σ² for all, estimated
/// by the weighted residual mean square Σ w e²/(n − p). Scaling all weights changes σ² and nothing else.
/// n counts the points of positive weight.
///
/// ```
/// use doe::Model;
/// use surface::{Data, Regression, Surface};
/// let data = Data::new(1, vec![-1.0, 0.0, 1.0, 1.0], vec![0.0, 1.0, 4.0, 5.0])?;
/// let line = Regression::fit(&Model::linear(1)?, &data)?;
/// // Sums: x 1, x² 3, J 10, x J 9; so b = (21, 26)/11.
/// assert!((line.coefficients()[0] - 21.0 / 11.0).abs() < 1e-14);
/// assert!((line.coefficients()[1] - 26.0 / 11.0).abs() < 1e-14);
/// assert!((line.predict(&[0.5]) - 34.0 / 11.0).abs() < 1e-14);
/// assert_eq!(line.degrees_of_freedom(), 2);
/// # Ok::<(), surface::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Unchecked", into = "Unchecked")]
pub struct Regression {
    requested: Model,
    confounded: Confounded,
    model: Model,
    data: Data,
    dropped: Vec<Confounding>,
    coefficients: Vec<f64>,
    /// U with (R'WR)⁻¹ = U U', p × p, row by row, for weights relative to the largest.
    inverse_factor: Vec<f64>,
    leverages: Vec<f64>,
    residuals: Vec<f64>,
    polynomial: Polynomial,
}

/// What to do about terms that the data cannot tell from others.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Confounded {
    /// Refuse the fit and name them.
    #[default]
    Refuse,
    /// Leave them out of the model, keeping the earlier terms, and report them.
    Drop,
}

impl Regression {
    /// A pivot below this fraction of the largest makes the weighted regressors dependent.
    ///
    /// The pivots are the diagonal elements of R in the QR factorization with column pivoting of the regressors, each
    /// column scaled to unit length after each row has been multiplied by the root of its weight.
    pub const SMALLEST_PIVOT: f64 = 1e-10;
    /// A leverage closer to 1 than this leaves no other point to determine some combination of the terms.
    pub const LEVERAGE_MARGIN: f64 = 1e-10;

    /// The regression of these data on a model, all of whose terms they must determine.
    ///
    /// # Errors
    ///
    /// As [`fit_with`](Self::fit_with), and [`Error::Confounded`] naming the terms that the points of positive weight
    /// cannot tell apart.
    pub fn fit(model: &Model, data: &Data) -> Result<Self, Error> {
        Self::fit_with(model, data, Confounded::Refuse)
    }

    /// The regression of these data on a model, with a choice what to do about confounded terms.
    ///
    /// # Errors
    ///
    /// [`Error::FactorMismatch`]; [`Error::TooFewPoints`] for fewer points of positive weight than terms (those left,
    /// if confounded ones are dropped); [`Error::Confounded`]; [`Error::Regressor`] if a term overflows;
    /// [`Error::IllConditioned`] if the weights are so different that the terms cannot be told apart in double
    /// precision although the points would do.
    pub fn fit_with(model: &Model, data: &Data, confounded: Confounded) -> Result<Self, Error> {
        let (expected, found) = (model.n_factors(), data.n_factors());
        if expected != found {
            return Err(Error::FactorMismatch { what: "the data", expected, found });
        }
        check_regressors(model, data)?;
        if confounded == Confounded::Refuse {
            check_count(model, data)?;
        }
        let found = confounded_terms(model, data)?;
        if found.is_empty() {
            return Self::of_estimable(model.clone(), data.clone(), confounded, found);
        }
        if confounded == Confounded::Refuse {
            return Err(Error::Confounded { names: model.term_names(&[]), confounded: found });
        }
        Self::of_estimable(model.clone(), data.clone(), confounded, found)
    }

    fn of_estimable(
        requested: Model,
        data: Data,
        confounded: Confounded,
        dropped: Vec<Confounding>,
    ) -> Result<Self, Error> {
        let terms: Vec<usize> = dropped.iter().map(|confounding| confounding.term).collect();
        let model = requested.without_terms(&terms)?;
        check_count(&model, &data)?;
        let p = model.n_terms();
        let used: Vec<usize> = (0..data.n_points()).filter(|&point| data.weights()[point] > 0.0).collect();
        let roots: Vec<f64> = data.relative_weights().map(f64::sqrt).collect();

        // Rows times the roots of their weights, columns to unit length.
        let mut scaled =
            Mat::from_fn(used.len(), p, |i, k| roots[used[i]] * model.terms()[k].value(data.point(used[i])));
        let lengths: Vec<f64> = scaled.col_iter().map(|column| column.norm_l2()).collect();
        for (column, &length) in scaled.col_iter_mut().zip(&lengths) {
            column.iter_mut().for_each(|value| *value /= length);
        }
        let factors = scaled.col_piv_qr();
        let (r, q) = (factors.thin_R(), factors.compute_thin_Q());
        let (order, _) = factors.P().arrays();
        let pivots = (0..p).map(|k| r[(k, k)].abs());
        let ratio = pivots.clone().fold(f64::INFINITY, f64::min) / pivots.fold(0.0, f64::max);
        if ratio.is_nan() || ratio < Self::SMALLEST_PIVOT {
            return Err(Error::IllConditioned { ratio, least: Self::SMALLEST_PIVOT });
        }

        // b = P R⁻¹ Q'y and U = P R⁻¹, rows divided by the lengths of the columns.
        let weighted_value = |i: usize| roots[used[i]] * data.values()[used[i]];
        let projected = (0..p).map(|k| (0..used.len()).map(|i| q[(i, k)] * weighted_value(i)).sum()).collect();
        let solution = solve_upper(r, projected);
        let mut coefficients = vec![0.0; p];
        for (k, &term) in order.iter().enumerate() {
            coefficients[term] = solution[k] / lengths[term];
        }
        let mut inverse_factor = vec![0.0; p * p];
        for column in 0..p {
            let unit = (0..p).map(|k| if k == column { 1.0 } else { 0.0 }).collect();
            for (value, &term) in solve_upper(r, unit).iter().zip(order) {
                inverse_factor[term * p + column] = value / lengths[term];
            }
        }
        let mut leverages = vec![0.0; data.n_points()];
        for (i, &point) in used.iter().enumerate() {
            leverages[point] = (0..p).map(|k| q[(i, k)] * q[(i, k)]).sum::<f64>().min(1.0);
        }
        let polynomial = Polynomial::new(&model, &coefficients)?;
        let residuals =
            data.points().zip(data.values()).map(|(point, value)| value - polynomial.predict(point)).collect();
        Ok(Self {
            requested,
            confounded,
            model,
            data,
            dropped,
            coefficients,
            inverse_factor,
            leverages,
            residuals,
            polynomial,
        })
    }

    /// The model as fitted, without the terms that were dropped.
    #[must_use]
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// The data it was fitted to.
    #[must_use]
    pub fn data(&self) -> &Data {
        &self.data
    }

    /// The terms of the model asked for that were left out, and what they equal; term indices are those of that model.
    #[must_use]
    pub fn dropped(&self) -> &[Confounding] {
        &self.dropped
    }

    /// One coefficient per term of [`model`](Self::model), b of (31).
    #[must_use]
    pub fn coefficients(&self) -> &[f64] {
        &self.coefficients
    }

    /// r'b, the estimate itself.
    #[must_use]
    pub fn polynomial(&self) -> &Polynomial {
        &self.polynomial
    }

    /// Number of points of positive weight less number of terms.
    #[must_use]
    pub fn degrees_of_freedom(&self) -> usize {
        self.data.n_used() - self.model.n_terms()
    }

    /// Value minus estimate at each point, those of weight zero too.
    #[must_use]
    pub fn residuals(&self) -> &[f64] {
        &self.residuals
    }

    /// w_i r_i'(R'WR)⁻¹ r_i at each point, 0 for a weight of zero; they sum to the number of terms.
    #[must_use]
    pub fn leverages(&self) -> &[f64] {
        &self.leverages
    }

    /// Σ w e².
    #[must_use]
    pub fn residual_sum_of_squares(&self) -> f64 {
        self.residuals.iter().zip(self.data.weights()).map(|(e, w)| w * e * e).sum()
    }

    /// σ² of a point of weight 1: the weighted residual mean square. None without degrees of freedom.
    #[must_use]
    pub fn sigma_squared(&self) -> Option<f64> {
        match self.degrees_of_freedom() {
            0 => None,
            degrees => Some(self.residual_sum_of_squares() / degrees as f64),
        }
    }

    /// σ²(R'WR)⁻¹, p × p, row by row. None without degrees of freedom.
    #[must_use]
    pub fn covariance(&self) -> Option<Vec<f64>> {
        let scale = self.unit_variance()?;
        let rows = || self.inverse_factor.chunks_exact(self.model.n_terms());
        let dot = |a: &[f64], b: &[f64]| scale * a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        Some(rows().flat_map(|a| rows().map(move |b| dot(a, b))).collect())
    }

    /// The polynomial with the coefficients b + σ U z, with U U' = (R'WR)⁻¹: for independent standard normal z, a draw from the
    /// sampling distribution of the fit. None without degrees of freedom.
    ///
    /// # Errors
    ///
    /// [`Error::Count`] unless there is one z per term.
    pub fn drawn(&self, normals: &[f64]) -> Result<Option<Polynomial>, Error> {
        let p = self.model.n_terms();
        if normals.len() != p {
            return Err(Error::Count { name: "normals", found: normals.len(), least: p, most: p });
        }
        let Some(scale) = self.unit_variance().map(f64::sqrt) else {
            return Ok(None);
        };
        let rows = self.inverse_factor.chunks_exact(p);
        let moved = rows
            .zip(&self.coefficients)
            .map(|(row, coefficient)| coefficient + scale * row.iter().zip(normals).map(|(u, z)| u * z).sum::<f64>());
        Polynomial::new(&self.model, &moved.collect::<Vec<_>>()).map(Some)
    }

    /// Standard error of each coefficient. None without degrees of freedom.
    #[must_use]
    pub fn standard_errors(&self) -> Option<Vec<f64>> {
        let scale = self.unit_variance()?;
        let rows = self.inverse_factor.chunks_exact(self.model.n_terms());
        Some(rows.map(|row| (scale * row.iter().map(|x| x * x).sum::<f64>()).sqrt()).collect())
    }

    /// Share of the weighted variation about the weighted mean that the model explains, or about zero if the model
    /// has no constant. None if there is no variation.
    #[must_use]
    pub fn r_squared(&self) -> Option<f64> {
        let total = self.total_sum_of_squares();
        self.is_variation(total).then(|| 1.0 - self.residual_sum_of_squares() / total)
    }

    /// [`r_squared`](Self::r_squared) with mean squares in place of sums. None without degrees of freedom too.
    #[must_use]
    pub fn adjusted_r_squared(&self) -> Option<f64> {
        let total = self.total_sum_of_squares();
        let degrees = self.data.n_used() - usize::from(self.has_constant());
        let sigma_squared = self.sigma_squared()?;
        self.is_variation(total).then(|| 1.0 - sigma_squared / (total / degrees as f64))
    }

    /// Leave-one-out residuals e_i/(1 − h_i), as if the regression had been repeated without each point.
    ///
    /// # Errors
    ///
    /// [`Error::LeverageOne`] for a point without which the others cannot determine the model.
    pub fn leave_one_out(&self) -> Result<LeaveOneOut, Error> {
        let residual = |(point, (e, h)): (usize, (&f64, &f64))| {
            let rest = 1.0 - h;
            if rest > Self::LEVERAGE_MARGIN { Ok(e / rest) } else { Err(Error::LeverageOne { point }) }
        };
        let residuals = self.residuals.iter().zip(&self.leverages).enumerate().map(residual);
        Ok(LeaveOneOut::new(residuals.collect::<Result<_, _>>()?, self.data.weights().to_vec()))
    }

    fn has_constant(&self) -> bool {
        self.model.terms().iter().any(|term| term.degree() == 0)
    }

    /// Whether a sum of squares is more than what rounding leaves of values that are all equal.
    fn is_variation(&self, total: f64) -> bool {
        const ROUNDING: f64 = 1e-28;
        let of_values = self.data.values().iter().zip(self.data.weights()).map(|(value, w)| w * value * value);
        total > ROUNDING * of_values.sum::<f64>()
    }

    fn total_sum_of_squares(&self) -> f64 {
        let weighted = || self.data.values().iter().zip(self.data.weights());
        let total: f64 = self.data.weights().iter().sum();
        let center = if self.has_constant() { weighted().map(|(value, w)| w / total * value).sum() } else { 0.0 };
        weighted().map(|(value, w)| w * (value - center) * (value - center)).sum()
    }

    /// σ² of a point of the largest weight, to which the stored factor belongs.
    fn unit_variance(&self) -> Option<f64> {
        let largest = self.data.weights().iter().fold(0.0, |largest: f64, &weight| largest.max(weight));
        self.sigma_squared().map(|sigma_squared| sigma_squared / largest)
    }
}

impl Surface for Regression {
    fn n_factors(&self) -> usize {
        self.model.n_factors()
    }

    fn predict(&self, point: &[f64]) -> f64 {
        self.polynomial.predict(point)
    }

    fn predict_lanes(&self, block: &[Lanes], estimates: &mut Lanes) {
        self.polynomial.predict_lanes(block, estimates);
    }

    fn over_grid<'a>(&'a self, grid: &'a GridPoints) -> Option<Box<dyn OverGrid + 'a>> {
        self.polynomial.over_grid(grid)
    }

    fn gradient(&self, point: &[f64]) -> Option<Vec<f64>> {
        self.polynomial.gradient(point)
    }

    /// σ² r'(R'WR)⁻¹ r: the variance of the estimate of the mean response, to which a new observation of weight w adds
    /// σ²/w. None without degrees of freedom.
    fn variance(&self, point: &[f64]) -> Option<f64> {
        let scale = self.unit_variance()?;
        if !is_usable(point, self.n_factors()) {
            return None;
        }
        // |U'r|², a sum of squares, is never below zero.
        let mut projected = vec![0.0; self.model.n_terms()];
        for (term, row) in self.model.terms().iter().zip(self.inverse_factor.chunks_exact(projected.len())) {
            let regressor = term.value(point);
            projected.iter_mut().zip(row).for_each(|(sum, value)| *sum += regressor * value);
        }
        Some(scale * projected.iter().map(|value| value * value).sum::<f64>())
    }
}

/// Rx = y for an upper triangular R.
fn solve_upper(r: MatRef<'_, f64>, mut y: Vec<f64>) -> Vec<f64> {
    for k in (0..y.len()).rev() {
        let (left, rest) = y.split_at_mut(k);
        rest[0] /= r[(k, k)];
        left.iter_mut().enumerate().for_each(|(i, value)| *value -= r[(i, k)] * rest[0]);
    }
    y
}

fn check_count(model: &Model, data: &Data) -> Result<(), Error> {
    let (n_points, n_terms) = (data.n_used(), model.n_terms());
    if n_points < n_terms { Err(Error::TooFewPoints { n_points, n_terms }) } else { Ok(()) }
}

/// Every term at every point, used or not, must leave room for its square.
fn check_regressors(model: &Model, data: &Data) -> Result<(), Error> {
    for (point, x) in data.points().enumerate() {
        for (number, term) in model.terms().iter().enumerate() {
            let value = term.value(x);
            if value.is_nan() || value.abs() > Data::LARGEST {
                let term = model.term_names(&[]).swap_remove(number);
                return Err(Error::Regressor { point, term, value, most: Data::LARGEST });
            }
        }
    }
    Ok(())
}

/// Dependences among the terms on the points of positive weight.
fn confounded_terms(model: &Model, data: &Data) -> Result<Vec<Confounding>, Error> {
    let used = data.points().zip(data.weights()).filter(|&(_, &weight)| weight > 0.0);
    let design = Design::new(data.n_factors(), used.flat_map(|(point, _)| point.iter().copied()).collect())?;
    Ok(confounded_terms_of_design(model, &design)?)
}

/// The regression as it stands in a file: what it was fitted to.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename = "Regression")]
struct Unchecked {
    model: Model,
    data: Data,
    #[serde(default)]
    confounded: Confounded,
}

impl TryFrom<Unchecked> for Regression {
    type Error = Error;

    fn try_from(unchecked: Unchecked) -> Result<Self, Error> {
        Self::fit_with(&unchecked.model, &unchecked.data, unchecked.confounded)
    }
}

impl From<Regression> for Unchecked {
    fn from(regression: Regression) -> Self {
        Self { model: regression.requested, data: regression.data, confounded: regression.confounded }
    }
}
