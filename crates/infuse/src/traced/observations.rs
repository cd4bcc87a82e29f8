//! Costs at points, and which trials they rest on.

use std::collections::BTreeSet;

use surface::Data;

use crate::traced::traced_surface::TracedSurface;
use crate::{Error, TrialId};

/// Costs at coded points that remember every trial whose outcome has gone into one of them.
///
/// A simulation rests on no trial until it is [corrected](Self::corrected_by): then it rests on every trial that the
/// correction rests on.
#[derive(Debug, Clone, PartialEq)]
pub struct Observations {
    n_factors: usize,
    coordinates: Vec<f64>,
    values: Vec<f64>,
    weights: Vec<f64>,
    trials: BTreeSet<TrialId>,
}

impl Observations {
    /// None yet, in this many factors.
    #[must_use]
    pub fn none(n_factors: usize) -> Self {
        let (coordinates, values, weights) = (Vec::new(), Vec::new(), Vec::new());
        Self { n_factors, coordinates, values, weights, trials: BTreeSet::new() }
    }

    /// One more experiment, at the coded point where it was made.
    ///
    /// # Errors
    ///
    /// [`Error::WrongLength`].
    pub fn add_experiment(&mut self, trial: TrialId, point: &[f64], cost: f64) -> Result<(), Error> {
        self.add_simulation(point, cost)?;
        self.trials.insert(trial);
        Ok(())
    }

    /// One more simulation, at a coded point.
    ///
    /// # Errors
    ///
    /// [`Error::WrongLength`].
    pub fn add_simulation(&mut self, point: &[f64], cost: f64) -> Result<(), Error> {
        crate::checks::check_length("point", self.n_factors, point.len())?;
        self.coordinates.extend(point);
        self.values.push(cost);
        self.weights.push(1.0);
        Ok(())
    }

    /// The responses with a correction added, J(p) + Ĵcor(p) at every point.
    ///
    /// # Errors
    ///
    /// [`Error::WrongLength`] if the correction has another number of factors.
    pub fn corrected_by(&self, correction: &TracedSurface) -> Result<Self, Error> {
        crate::checks::check_length("correction", self.n_factors, correction.surface().n_factors())?;
        let mut corrected = self.clone();
        for (value, point) in corrected.values.iter_mut().zip(self.points()) {
            *value += correction.surface().predict(point);
        }
        corrected.trials.extend(correction.trials());
        Ok(corrected)
    }

    /// The same, with this weight w of (31) at every point.
    #[must_use]
    pub fn weighted(mut self, weight: f64) -> Self {
        self.weights.fill(weight);
        self
    }

    /// These, followed by others.
    ///
    /// # Errors
    ///
    /// [`Error::WrongLength`] if the others have another number of factors.
    pub fn followed_by(mut self, others: &Self) -> Result<Self, Error> {
        crate::checks::check_length("observations", self.n_factors, others.n_factors)?;
        self.coordinates.extend(&others.coordinates);
        self.values.extend(&others.values);
        self.weights.extend(&others.weights);
        self.trials.extend(&others.trials);
        Ok(self)
    }

    /// How many there are.
    #[must_use]
    pub fn n_points(&self) -> usize {
        self.values.len()
    }

    /// The coded points, in order.
    pub fn points(&self) -> impl Iterator<Item = &[f64]> {
        self.coordinates.chunks_exact(self.n_factors.max(1))
    }

    /// The responses, in order.
    #[must_use]
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// The trials that the responses rest on.
    #[must_use]
    pub fn trials(&self) -> &BTreeSet<TrialId> {
        &self.trials
    }

    /// As data to fit a surface to.
    pub(super) fn data(&self) -> Result<Data, Error> {
        let data = Data::new(self.n_factors, self.coordinates.clone(), self.values.clone())?;
        Ok(data.with_weights(self.weights.clone())?)
    }
}
