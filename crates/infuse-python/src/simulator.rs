//! A Python function as a simulation.

use design_space::Cell;
use infuse::pooled::{Responses, Simulate};
use numpy::{PyArray1, PyArrayMethods, PyReadonlyArray1};
use pyo3::prelude::*;

use crate::arrays::matrix;
use crate::background::Caller;
use crate::error::Error;

/// A Python function, from the thread that works: the one that called runs it.
pub(crate) struct RemoteSimulator<'a> {
    caller: &'a Caller,
}

impl<'a> RemoteSimulator<'a> {
    pub(crate) fn new(caller: &'a Caller) -> Self {
        Self { caller }
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

/// The response, and behind it those on which there are constraints.
fn answer(values: &[f64]) -> Result<Responses, String> {
    let constrained = values[1..].iter().map(|value| value.is_finite().then_some(*value)).collect();
    result(values[0]).map(|cost| Responses { cost, constrained })
}

impl Simulate for RemoteSimulator<'_> {
    fn responses(&mut self, _: &[Cell], points: &[Vec<f64>]) -> Vec<Result<Responses, String>> {
        let responses = self.caller.call(points);
        let per_design = responses.len() / points.len().max(1);
        responses.chunks(per_design.max(1)).take(points.len()).map(answer).collect()
    }
}
