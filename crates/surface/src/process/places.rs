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
    /// What the simulated responses may be off by: one per place, one column for each way.
    deviations: Vec<Vec<f64>>,
    /// Standard deviations of what is not known of the simulated responses at all; nothing where all is.
    unknown: Vec<f64>,
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
        let (axes, deviations, unknown) = (axes.collect(), Vec::new(), Vec::new());
        Ok(Self { n_factors, n_places, axes, simulated: None, deviations, unknown })
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

    /// The same places where the simulated responses are not quite known: each column is a way in which they may be off, by a
    /// standard deviation at each place, all together. A simulation of which the place is not known well is off by what it says
    /// next to that.
    ///
    /// # Errors
    ///
    /// [`Error::Length`] unless each column has one per place, and all are simulated, [`Error::Value`].
    pub fn with_deviations(mut self, deviations: Vec<Vec<f64>>) -> Result<Self, Error> {
        let expected = if self.simulated.is_some() { self.n_places } else { 0 };
        let most = crate::Data::LARGEST;
        for column in &deviations {
            if column.len() != expected {
                return Err(Error::Length { name: "deviations of simulated responses", expected, found: column.len() });
            }
            if let Some(point) = column.iter().position(|d| d.is_nan() || d.abs() > most) {
                return Err(Error::Value { point, value: column[point], most });
            }
        }
        self.deviations = deviations;
        Ok(self)
    }

    /// The same places where the simulation tells of some less than of others, or nothing: each simulated response lacks a part of this
    /// standard deviation, which is as smooth as a Matérn-5/2 process of the length 1, half of the box.
    ///
    /// # Errors
    ///
    /// [`Error::Length`] unless there is one per place, and all are simulated, [`Error::Value`] for one that is negative, too.
    pub fn with_unknown(mut self, unknown: Vec<f64>) -> Result<Self, Error> {
        let expected = if self.simulated.is_some() { self.n_places } else { 0 };
        if unknown.len() != expected {
            return Err(Error::Length { name: "unknown parts of simulated responses", expected, found: unknown.len() });
        }
        let most = crate::Data::LARGEST;
        if let Some(point) = unknown.iter().position(|deviation| !(0.0..=most).contains(deviation)) {
            return Err(Error::Value { point, value: unknown[point], most });
        }
        let is_known = unknown.iter().all(|deviation| *deviation <= 0.0);
        self.unknown = if is_known { Vec::new() } else { unknown };
        Ok(self)
    }

    /// Number of factors, K.
    #[must_use]
    pub fn n_factors(&self) -> usize {
        self.n_factors
    }

    /// That these are places of a process of so many factors.
    pub(crate) fn check_factors(&self, expected: usize) -> Result<(), Error> {
        match self.n_factors == expected {
            true => Ok(()),
            false => Err(Error::FactorMismatch { what: "the places", expected, found: self.n_factors }),
        }
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

    /// The ways in which the simulated responses may be off.
    #[must_use]
    pub fn deviations(&self) -> &[Vec<f64>] {
        &self.deviations
    }

    /// Standard deviations of what is not known of the simulated responses; nothing where all of them are.
    #[must_use]
    pub fn unknown(&self) -> &[f64] {
        &self.unknown
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
        let some = |all: &Vec<f64>| places.iter().map(|&place| all[place]).collect();
        let (simulated, deviations) = (self.simulated.as_ref().map(some), self.deviations.iter().map(some).collect());
        let unknown = if self.unknown.is_empty() { Vec::new() } else { some(&self.unknown) };
        Self { n_factors: self.n_factors, n_places: places.len(), axes: axes.collect(), simulated, deviations, unknown }
    }

    /// As far along each axis from these as told, at most to the edge of the box; nothing is simulated there.
    ///
    /// # Panics
    ///
    /// Unless there is one step per axis.
    #[must_use]
    pub fn moved(&self, by: &[f64]) -> Self {
        assert_eq!(by.len(), self.n_factors, "one step per axis");
        let axes =
            (0..self.n_factors).flat_map(|axis| self.axis(axis).iter().map(move |x| (x + by[axis]).clamp(-1.0, 1.0)));
        let (axes, deviations, unknown) = (axes.collect(), Vec::new(), Vec::new());
        Self { n_factors: self.n_factors, n_places: self.n_places, axes, simulated: None, deviations, unknown }
    }

    /// These points in their order, at most so many at a time.
    pub(crate) fn blocks(&self, most: usize) -> impl Iterator<Item = Self> {
        (0..self.n_places).step_by(most).map(move |first| {
            let range = first..self.n_places.min(first + most);
            let axes = (0..self.n_factors).flat_map(|axis| self.axis(axis)[range.clone()].iter().copied()).collect();
            let some = |all: &Vec<f64>| all[range.clone()].to_vec();
            let (simulated, deviations) =
                (self.simulated.as_ref().map(some), self.deviations.iter().map(some).collect());
            let unknown = if self.unknown.is_empty() { Vec::new() } else { some(&self.unknown) };
            Self { n_factors: self.n_factors, n_places: range.len(), axes, simulated, deviations, unknown }
        })
    }

    /// These points and then others; simulated only where both are, and off in as many ways as both are.
    ///
    /// # Errors
    ///
    /// [`Error::FactorMismatch`] unless they have as many factors.
    pub fn followed_by(&self, other: &Self) -> Result<Self, Error> {
        if other.n_factors != self.n_factors {
            let (expected, found) = (self.n_factors, other.n_factors);
            return Err(Error::FactorMismatch { what: "the places that follow", expected, found });
        }
        let axes =
            (0..self.n_factors).flat_map(|axis| self.axis(axis).iter().chain(other.axis(axis))).copied().collect();
        let one = |(own, others): (&Vec<f64>, &Vec<f64>)| own.iter().chain(others).copied().collect();
        let simulated = self.simulated.as_ref().zip(other.simulated.as_ref()).map(one);
        let deviations = self.deviations.iter().zip(&other.deviations).map(one).collect();
        let n_places = self.n_places + other.n_places;
        let is_known = simulated.is_none() || (self.unknown.is_empty() && other.unknown.is_empty());
        let unknown = if is_known { Vec::new() } else { [self.padded_unknown(), other.padded_unknown()].concat() };
        Ok(Self { n_factors: self.n_factors, n_places, axes, simulated, deviations, unknown })
    }

    /// One for each place, zeros where all is known.
    fn padded_unknown(&self) -> Vec<f64> {
        if self.unknown.is_empty() { vec![0.0; self.n_places] } else { self.unknown.clone() }
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
