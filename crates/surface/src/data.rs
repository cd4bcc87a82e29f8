//! What a surface is fitted to: points, values, weights.

use std::cmp::Ordering;

use doe::Design;
use serde::{Deserialize, Serialize};

use crate::Error;
use crate::lanes::check_factors;

/// Measured or simulated values at points, with a weight per point.
///
/// Coordinates are coded by the caller, and to the *original* box: a distance must not change its meaning when the
/// region of interest shrinks.
/// A weight belongs to a point, not to a group of points: with 0.7 for each of 9 experiments and 0.3 for each of 36
/// simulations the simulations hold 10.8/17.1 = 63 % of the total.
/// A point of weight zero is kept but not used.
///
/// ```
/// use surface::Data;
/// let experiments = Data::new(1, vec![-1.0, 1.0], vec![3.0, 5.0])?.weighted(0.7)?;
/// let simulations = Data::new(1, vec![-1.0, 0.0, 1.0], vec![2.0, 2.5, 4.0])?.weighted(0.3)?;
/// let both = experiments.followed_by(&simulations)?;
/// assert_eq!(both.weights(), [0.7, 0.7, 0.3, 0.3, 0.3]);
/// # Ok::<(), surface::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "UncheckedData", into = "UncheckedData")]
pub struct Data {
    n_factors: usize,
    coordinates: Vec<f64>,
    values: Vec<f64>,
    weights: Vec<f64>,
}

impl Data {
    /// The largest magnitude of a coordinate, a value or a weight, so that no square of one overflows.
    pub const LARGEST: f64 = 1e100;
    /// The smallest weight above zero.
    pub const SMALLEST_WEIGHT: f64 = 1e-100;

    /// Values at points given row by row, all of weight 1.
    ///
    /// # Errors
    ///
    /// [`Error::Count`] for the number of factors or no points, [`Error::RaggedPoints`], [`Error::Length`] if there is
    /// not one value per point, [`Error::Coordinate`], [`Error::Value`].
    pub fn new(n_factors: usize, coordinates: Vec<f64>, values: Vec<f64>) -> Result<Self, Error> {
        check_factors(n_factors)?;
        if !coordinates.len().is_multiple_of(n_factors) {
            return Err(Error::RaggedPoints { n_factors, n_coordinates: coordinates.len() });
        }
        let n_points = coordinates.len() / n_factors;
        if n_points == 0 {
            return Err(Error::Count { name: "data points", found: 0, least: 1, most: usize::MAX });
        }
        if values.len() != n_points {
            return Err(Error::Length { name: "values of data points", expected: n_points, found: values.len() });
        }
        let usable = |number: &f64| number.abs() <= Self::LARGEST;
        if let Some(at) = coordinates.iter().position(|x| !usable(x)) {
            let (point, factor) = (at / n_factors, at % n_factors);
            return Err(Error::Coordinate { point, factor, value: coordinates[at], most: Self::LARGEST });
        }
        if let Some(point) = values.iter().position(|value| !usable(value)) {
            return Err(Error::Value { point, value: values[point], most: Self::LARGEST });
        }
        Ok(Self { n_factors, coordinates, weights: vec![1.0; values.len()], values })
    }

    /// Values at the runs of a design, all of weight 1.
    ///
    /// # Errors
    ///
    /// As [`new`](Self::new).
    pub fn of_design(design: &Design, values: Vec<f64>) -> Result<Self, Error> {
        Self::new(design.n_factors(), design.coordinates().to_vec(), values)
    }

    /// The same points and values with these weights, one per point.
    ///
    /// # Errors
    ///
    /// [`Error::Length`], [`Error::Weight`], [`Error::NoWeight`].
    pub fn with_weights(mut self, weights: Vec<f64>) -> Result<Self, Error> {
        let (expected, found) = (self.n_points(), weights.len());
        if expected != found {
            return Err(Error::Length { name: "weights", expected, found });
        }
        let (least, most) = (Self::SMALLEST_WEIGHT, Self::LARGEST);
        let usable = |weight: f64| weight.to_bits() << 1 == 0 || (least..=most).contains(&weight);
        if let Some(point) = weights.iter().position(|&weight| !usable(weight)) {
            return Err(Error::Weight { point, value: weights[point], least, most });
        }
        if weights.iter().all(|&weight| weight <= 0.0) {
            return Err(Error::NoWeight { n_points: found });
        }
        self.weights = weights;
        Ok(self)
    }

    /// The same points and values, every point with this weight.
    ///
    /// # Errors
    ///
    /// [`Error::Weight`], [`Error::NoWeight`].
    pub fn weighted(self, weight: f64) -> Result<Self, Error> {
        let weights = vec![weight; self.n_points()];
        self.with_weights(weights)
    }

    /// These data followed by others, as experiments are pooled with simulations.
    ///
    /// # Errors
    ///
    /// [`Error::FactorMismatch`].
    pub fn followed_by(&self, other: &Self) -> Result<Self, Error> {
        let (expected, found) = (self.n_factors, other.n_factors);
        if expected != found {
            return Err(Error::FactorMismatch { what: "the second set of data", expected, found });
        }
        Ok(Self {
            n_factors: expected,
            coordinates: [&self.coordinates[..], &other.coordinates].concat(),
            values: [&self.values[..], &other.values].concat(),
            weights: [&self.weights[..], &other.weights].concat(),
        })
    }

    /// Number of factors, K.
    #[must_use]
    pub fn n_factors(&self) -> usize {
        self.n_factors
    }

    /// Number of points, used or not.
    #[must_use]
    pub fn n_points(&self) -> usize {
        self.values.len()
    }

    /// Number of points of positive weight.
    #[must_use]
    pub fn n_used(&self) -> usize {
        self.weights.iter().filter(|&&weight| weight > 0.0).count()
    }

    /// The points, coded, in order.
    pub fn points(&self) -> std::slice::ChunksExact<'_, f64> {
        self.coordinates.chunks_exact(self.n_factors)
    }

    /// All coded coordinates, row by row.
    #[must_use]
    pub fn coordinates(&self) -> &[f64] {
        &self.coordinates
    }

    /// The value at each point.
    #[must_use]
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// The weight of each point.
    #[must_use]
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// Indices of the points of positive weight, grouped by place: points with the same coordinates are repeats.
    #[must_use]
    pub fn sites(&self) -> Vec<Vec<usize>> {
        let mut order: Vec<usize> = (0..self.n_points()).filter(|&point| self.weights[point] > 0.0).collect();
        let by_place = |&a: &usize, &b: &usize| {
            let pairs = self.point(a).iter().zip(self.point(b));
            pairs.map(|(x, y)| x.partial_cmp(y).unwrap_or(Ordering::Equal)).find(|order| order.is_ne())
        };
        order.sort_by(|a, b| by_place(a, b).unwrap_or(Ordering::Equal));
        let mut sites: Vec<Vec<usize>> =
            order.chunk_by(|a, b| by_place(a, b).is_none()).map(<[usize]>::to_vec).collect();
        sites.sort_by_key(|site| site[0]);
        sites
    }

    pub(crate) fn point(&self, index: usize) -> &[f64] {
        &self.coordinates[index * self.n_factors..][..self.n_factors]
    }

    /// Weights divided by the largest, so that sums of them neither overflow nor vanish.
    pub(crate) fn relative_weights(&self) -> impl Iterator<Item = f64> {
        let largest = self.weights.iter().fold(0.0, |largest: f64, &weight| largest.max(weight));
        self.weights.iter().map(move |&weight| weight / largest)
    }
}

/// Data as they stand in a file: weights may be left out and are then 1.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename = "Data")]
struct UncheckedData {
    points: Vec<Vec<f64>>,
    values: Vec<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    weights: Option<Vec<f64>>,
}

impl TryFrom<UncheckedData> for Data {
    type Error = Error;

    fn try_from(unchecked: UncheckedData) -> Result<Self, Error> {
        let n_factors = unchecked.points.first().map_or(1, Vec::len);
        if let Some(point) = unchecked.points.iter().find(|point| point.len() != n_factors) {
            return Err(Error::Length { name: "coordinates of a point", expected: n_factors, found: point.len() });
        }
        let data = Self::new(n_factors, unchecked.points.concat(), unchecked.values)?;
        match unchecked.weights {
            Some(weights) => data.with_weights(weights),
            None => Ok(data),
        }
    }
}

impl From<Data> for UncheckedData {
    fn from(data: Data) -> Self {
        let points = data.points().map(<[f64]>::to_vec).collect();
        let weighted = data.weights.iter().any(|&weight| weight.total_cmp(&1.0).is_ne());
        Self { points, values: data.values, weights: weighted.then_some(data.weights) }
    }
}
