//! A Python function as a simulation.

use design_space::Cell;
use infuse::pooled::{Responses, Simulate};
use numpy::{PyArray1, PyArrayMethods, PyReadonlyArray1};
use pyo3::prelude::*;

use crate::arrays::matrix;
use crate::background::Caller;
use crate::error::Error;

/// What a function said of a design.
#[derive(Debug)]
pub(crate) struct Answer {
    pub(crate) cell: Cell,
    pub(crate) value: f64,
    /// One per constraint, if it gave them.
    pub(crate) constrained: Vec<Option<f64>>,
}

/// A Python function, from the thread that works: the one that called runs it.
pub(crate) struct RemoteSimulator<'a> {
    caller: &'a Caller,
    /// What it was asked, with its answers.
    pub(crate) answers: Vec<Answer>,
}

impl<'a> RemoteSimulator<'a> {
    pub(crate) fn new(caller: &'a Caller) -> Self {
        Self { caller, answers: Vec::new() }
    }
}

/// One response at each of these points.
pub(crate) fn one_each(py: Python<'_>, function: &Py<PyAny>, points: &[Vec<f64>]) -> PyResult<Vec<f64>> {
    let responses = call(py, function, points)?;
    if responses.len() == points.len() { Ok(responses) } else { Err(wrong_number(responses.len(), points.len())) }
}

/// The responses of a function at these points, as many at each. It takes an array of n × k settings; NaN is none.
pub(crate) fn call(py: Python<'_>, function: &Py<PyAny>, points: &[Vec<f64>]) -> PyResult<Vec<f64>> {
    let n_columns = points.first().map_or(0, Vec::len);
    let argument = matrix(py, n_columns, points.concat())?;
    let answer = function.bind(py).call1((argument,))?;
    let responses: PyReadonlyArray1<'_, f64> = answer.cast::<PyArray1<f64>>()?.try_readonly()?;
    let responses: Vec<f64> = responses.as_array().iter().copied().collect();
    if points.is_empty() || !responses.len().is_multiple_of(points.len()) {
        return Err(wrong_number(responses.len(), points.len()));
    }
    Ok(responses)
}

fn wrong_number(found: usize, expected: usize) -> PyErr {
    Error::new_err(format!("the simulation gave {found} responses for {expected} designs"))
}

/// A response as the loops want it.
pub(crate) fn result(response: f64) -> Result<f64, String> {
    if response.is_finite() { Ok(response) } else { Err(format!("the simulation returned {response}")) }
}

impl RemoteSimulator<'_> {
    /// The response, and behind it those on which there are constraints.
    fn answer(&mut self, cell: Cell, values: &[f64]) -> Result<Responses, String> {
        let constrained: Vec<Option<f64>> =
            values[1..].iter().map(|value| value.is_finite().then_some(*value)).collect();
        self.answers.push(Answer { cell, value: values[0], constrained: constrained.clone() });
        result(values[0]).map(|objective| Responses { objective, constrained })
    }
}

impl Simulate for RemoteSimulator<'_> {
    fn responses(&mut self, cells: &[Cell], points: &[Vec<f64>]) -> Vec<Result<Responses, String>> {
        let responses = self.caller.call(points);
        let per_design = responses.len() / points.len().max(1);
        let of_designs = responses.chunks(per_design.max(1)).zip(cells);
        of_designs.map(|(values, &cell)| self.answer(cell, values)).collect()
    }
}
