//! Numpy arrays to lists of numbers and back.

use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;

/// An array of n × k numbers, row by row, whatever its layout.
pub(crate) struct Matrix {
    pub(crate) n_columns: usize,
    pub(crate) numbers: Vec<f64>,
}

impl Matrix {
    pub(crate) fn of(array: &PyReadonlyArray2<'_, f64>) -> Self {
        Self { n_columns: array.shape()[1], numbers: array.as_array().iter().copied().collect() }
    }

    /// The rows; an array without columns has none.
    pub(crate) fn rows(&self) -> impl Iterator<Item = &[f64]> {
        self.numbers.chunks_exact(self.n_columns.max(1))
    }
}

/// Numbers, row by row, as an array with so many columns.
pub(crate) fn matrix(py: Python<'_>, n_columns: usize, numbers: Vec<f64>) -> PyResult<Bound<'_, PyArray2<f64>>> {
    let n_rows = numbers.len().checked_div(n_columns).unwrap_or(0);
    PyArray1::from_vec(py, numbers).reshape([n_rows, n_columns])
}
