//! Points as a process sees them: coordinates, trend regressors, the simulation there.

use faer::Mat;

use crate::Error;
use crate::lanes::check_factors;

/// Points, coded, with what the simulation says at each of them if there is one.
///
/// Coordinates lie in the box \[-1, 1\]^K, or near it; the trend and the priors of the lengths are meant for that box.
#[derive(Debug, Clone, PartialEq)]
pub struct Places {
    n_factors: usize,
    n_places: usize,
    /// Coordinate j of all places, one axis after the other.
    axes: Vec<f64>,
    simulated: Option<Vec<f64>>,
}

impl Places {
    /// Points given row by row.
    ///
    /// # Errors
    ///
    /// [`Error::Count`] for the number of factors, [`Error::RaggedPoints`], [`Error::Coordinate`].
    pub fn new(n_factors: usize, coordinates: &[f64]) -> Result<Self, Error> {
        check_factors(n_factors)?;
        if !coordinates.len().is_multiple_of(n_factors) {
            return Err(Error::RaggedPoints { n_factors, n_coordinates: coordinates.len() });
        }
        let most = 1e100;
        let wrong = coordinates.iter().position(|x| x.is_nan() || x.abs() > most);
        if let Some(position) = wrong {
            let (point, factor) = (position / n_factors, position % n_factors);
            return Err(Error::Coordinate { point, factor, value: coordinates[position], most });
        }
        let n_places = coordinates.len() / n_factors;
        let axes = (0..n_factors).flat_map(|axis| coordinates.iter().skip(axis).step_by(n_factors)).copied();
        Ok(Self { n_factors, n_places, axes: axes.collect(), simulated: None })
    }

    /// The same points with the simulated response at each.
    ///
    /// # Errors
    ///
    /// [`Error::Length`] unless there is one per point, [`Error::Value`].
    pub fn with_simulated(mut self, simulated: Vec<f64>) -> Result<Self, Error> {
        if simulated.len() != self.n_places {
            let (expected, found) = (self.n_places, simulated.len());
            return Err(Error::Length { name: "simulated responses", expected, found });
        }
        let most = crate::Data::LARGEST;
        if let Some(point) = simulated.iter().position(|s| s.is_nan() || s.abs() > most) {
            return Err(Error::Value { point, value: simulated[point], most });
        }
        self.simulated = Some(simulated);
        Ok(self)
    }

    /// Number of factors, K.
    #[must_use]
    pub fn n_factors(&self) -> usize {
        self.n_factors
    }

    /// Number of points.
    #[must_use]
    pub fn n_places(&self) -> usize {
        self.n_places
    }

    /// The simulated response at each point, if there is a simulation.
    #[must_use]
    pub fn simulated(&self) -> Option<&[f64]> {
        self.simulated.as_deref()
    }

    /// Coordinates of one point.
    #[must_use]
    pub fn point(&self, place: usize) -> Vec<f64> {
        (0..self.n_factors).map(|axis| self.axis(axis)[place]).collect()
    }

    /// Some of these points, in this order.
    #[must_use]
    pub fn select(&self, places: &[usize]) -> Self {
        let axes = (0..self.n_factors).flat_map(|axis| places.iter().map(move |&place| self.axis(axis)[place]));
        let simulated = self.simulated.as_ref().map(|all| places.iter().map(|&place| all[place]).collect());
        Self { n_factors: self.n_factors, n_places: places.len(), axes: axes.collect(), simulated }
    }

    /// These points in their order, at most so many at a time.
    pub(crate) fn blocks(&self, most: usize) -> impl Iterator<Item = Self> {
        (0..self.n_places).step_by(most).map(move |first| {
            let range = first..self.n_places.min(first + most);
            let axes = (0..self.n_factors).flat_map(|axis| self.axis(axis)[range.clone()].iter().copied()).collect();
            let simulated = self.simulated.as_ref().map(|all| all[range.clone()].to_vec());
            Self { n_factors: self.n_factors, n_places: range.len(), axes, simulated }
        })
    }

    /// These points and then others, of as many factors; simulated only where both are.
    #[must_use]
    pub fn followed_by(&self, other: &Self) -> Self {
        let axes =
            (0..self.n_factors).flat_map(|axis| self.axis(axis).iter().chain(other.axis(axis))).copied().collect();
        let both = self.simulated.as_ref().zip(other.simulated.as_ref());
        let simulated = both.map(|(own, others)| own.iter().chain(others).copied().collect());
        Self { n_factors: self.n_factors, n_places: self.n_places + other.n_places, axes, simulated }
    }

    pub(crate) fn axis(&self, axis: usize) -> &[f64] {
        &self.axes[axis * self.n_places..][..self.n_places]
    }

    /// The trend regressors but for the constant, orthogonal over the box: x_i, x_i² − 1/3, x_i x_j. One row per point.
    pub(crate) fn trend(&self) -> Mat<f64> {
        let k = self.n_factors;
        let pairs = (0..k).flat_map(|i| (i..k).map(move |j| (i, j)));
        let columns: Vec<(usize, Option<usize>)> =
            (0..k).map(|i| (i, None)).chain(pairs.map(|(i, j)| (i, Some(j)))).collect();
        let mut trend = Mat::zeros(self.n_places, columns.len());
        for (column, (i, other)) in trend.col_iter_mut().zip(columns) {
            let Some(into) = column.try_as_col_major_mut() else { continue };
            let (into, a) = (into.as_slice_mut(), self.axis(i));
            match other {
                None => into.copy_from_slice(a),
                Some(j) => {
                    let shift = if i == j { 1.0 / 3.0 } else { 0.0 };
                    for (value, (a, b)) in into.iter_mut().zip(a.iter().zip(self.axis(j))) {
                        *value = a * b - shift;
                    }
                }
            }
        }
        trend
    }
}
