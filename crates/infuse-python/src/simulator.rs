//! A Python function as a simulation.

use design_space::Cell;
use infuse::pooled::{Responses, Simulate};
use numpy::{PyArray1, PyArrayMethods, PyReadonlyArray1};
use pyo3::prelude::*;

use crate::arrays::matrix;
use crate::error::Error;

/// A function that takes an array of n × k settings and returns n responses, NaN where there is none.
#[derive(Debug)]
pub(crate) struct PythonSimulator {
    function: Py<PyAny>,
    /// What it was asked, with its answers.
    pub(crate) answers: Vec<(Cell, f64)>,
    /// What it raised; it is not called again then.
    raised: Option<PyErr>,
}

impl PythonSimulator {
    pub(crate) fn new(function: Py<PyAny>) -> Self {
        Self { function, answers: Vec::new(), raised: None }
    }

    /// The answers, or the exception that the function raised.
    pub(crate) fn finish(self) -> PyResult<Vec<(Cell, f64)>> {
        self.raised.map_or(Ok(self.answers), Err)
    }

    /// The responses at these points.
    pub(crate) fn call(&self, points: &[Vec<f64>]) -> PyResult<Vec<f64>> {
        Python::attach(|py| {
            let n_columns = points.first().map_or(0, Vec::len);
            let argument = matrix(py, n_columns, points.concat())?;
            let answer = self.function.bind(py).call1((argument,))?;
            let responses: PyReadonlyArray1<'_, f64> = answer.cast::<PyArray1<f64>>()?.try_readonly()?;
            let responses: Vec<f64> = responses.as_array().iter().copied().collect();
            if responses.len() != points.len() {
                let message = format!("the simulation gave {} responses for {} designs", responses.len(), points.len());
                return Err(Error::new_err(message));
            }
            Ok(responses)
        })
    }
}

/// A response as the loops want it.
pub(crate) fn result(response: f64) -> Result<f64, String> {
    if response.is_finite() { Ok(response) } else { Err(format!("the simulation returned {response}")) }
}

impl Simulate for PythonSimulator {
    fn responses(&mut self, cells: &[Cell], points: &[Vec<f64>]) -> Vec<Result<Responses, String>> {
        let responses = match &self.raised {
            Some(_) => None,
            None => self.call(points).map_err(|raised| self.raised = Some(raised)).ok(),
        };
        match responses {
            Some(responses) => {
                self.answers.extend(cells.iter().copied().zip(responses.iter().copied()));
                responses.into_iter().map(|response| result(response).map(Responses::from)).collect()
            }
            None => vec![Err("the simulation raised an exception".to_owned()); points.len()],
        }
    }
}
