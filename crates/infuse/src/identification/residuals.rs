//! Weighted residuals of a model at unknowns.

use std::cell::{Cell, RefCell};

use super::measurements::{Measurements, Row};
use super::settings::Noise;
use super::unknowns::Unknowns;
use crate::Error;
use crate::checks::check_count;

/// What a model says at one design: the responses in their order, or why there are none.
pub type Answer = Result<Vec<f64>, String>;

/// A model: for every vector of unknowns and every design an [`Answer`], `answers[unknowns][design]`.
pub(super) type Model<'a> = dyn FnMut(&[Vec<f64>], &[Vec<f64>]) -> Vec<Vec<Answer>> + 'a;

/// c (f(θ, p) − y) / σ over all readings, as a function of shares of the ranges. c is 1 where the noise is known, else the largest
/// σ: a common factor of all σ then changes nothing, not even which of several minima the search ends in.
pub(super) struct Residuals<'a> {
    pub(super) unknowns: &'a Unknowns,
    responses: &'a [String],
    rows: Vec<&'a Row>,
    designs: Vec<Vec<f64>>,
    model: RefCell<&'a mut Model<'a>>,
    /// c.
    pub(super) factor: f64,
    n_simulations: Cell<usize>,
    n_failures: Cell<usize>,
}

impl<'a> Residuals<'a> {
    pub(super) fn new(
        unknowns: &'a Unknowns,
        measurements: &'a Measurements,
        noise: Noise,
        model: &'a mut Model<'a>,
    ) -> Self {
        let rows = measurements.in_order();
        let factor = match noise {
            Noise::Known => 1.0,
            Noise::Estimated => rows.iter().flat_map(|row| &row.deviations).copied().fold(0.0, f64::max),
        };
        Self {
            unknowns,
            responses: measurements.responses(),
            designs: rows.iter().map(|row| row.design.clone()).collect(),
            rows,
            model: RefCell::new(model),
            factor,
            n_simulations: Cell::new(0),
            n_failures: Cell::new(0),
        }
    }

    /// Readings.
    pub(super) fn len(&self) -> usize {
        self.rows.len() * self.responses.len()
    }

    pub(super) fn n_simulations(&self) -> usize {
        self.n_simulations.get()
    }

    /// Vectors of unknowns at which some design had no answer.
    pub(super) fn n_failures(&self) -> usize {
        self.n_failures.get()
    }

    /// The residuals at each of these vectors, or why there are none.
    pub(super) fn at(&self, shares: &[Vec<f64>]) -> Result<Vec<Result<Vec<f64>, String>>, Error> {
        let unknowns: Vec<Vec<f64>> = shares.iter().map(|shares| self.unknowns.values(shares)).collect();
        let answers = (self.model.borrow_mut())(&unknowns, &self.designs);
        self.n_simulations.set(self.n_simulations.get() + unknowns.len() * self.designs.len());
        check_count("answers of the model", unknowns.len(), answers.len(), "vector of unknowns")?;
        answers.into_iter().map(|answers| self.of_answers(answers)).collect()
    }

    fn of_answers(&self, answers: Vec<Answer>) -> Result<Result<Vec<f64>, String>, Error> {
        check_count("answers of the model", self.designs.len(), answers.len(), "design")?;
        let mut residuals = Vec::with_capacity(self.len());
        for (answer, row) in answers.into_iter().zip(&self.rows) {
            let values = match answer {
                Ok(values) => values,
                Err(reason) => return Ok(self.failed(format!("at {:?}: {reason}", row.design))),
            };
            check_count("responses of the model", self.responses.len(), values.len(), "response")?;
            if let Some(k) = values.iter().position(|value| !value.is_finite()) {
                let (name, value) = (&self.responses[k], values[k]);
                return Ok(self.failed(format!("at {:?}: response `{name}` is {value}", row.design)));
            }
            let both = values.iter().zip(&row.values).zip(&row.deviations);
            residuals.extend(both.map(|((model, measured), deviation)| (model - measured) / (deviation / self.factor)));
        }
        Ok(Ok(residuals))
    }

    fn failed(&self, reason: String) -> Result<Vec<f64>, String> {
        self.n_failures.set(self.n_failures.get() + 1);
        Err(reason)
    }
}

pub(super) fn sum_of_squares(residuals: &[f64]) -> f64 {
    residuals.iter().map(|residual| residual * residual).sum()
}
