//! Parameters and models as Python gives them.

use design_space::{Model, Parameter, Region};
use numpy::{PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::arrays::{Matrix, matrix};
use crate::error::refusal;

/// Name, unit, lower and upper bound, number of levels if there are any; choices of what is no number, which has no unit and
/// no bounds but the places of the first and the last choice.
pub(crate) type ParameterTuple = (String, String, f64, f64, Option<u32>, Option<Vec<String>>);

/// The region of these parameters.
pub(crate) fn region(parameters: Vec<ParameterTuple>) -> PyResult<Region> {
    let one = |(name, unit, lower, upper, levels, choices): ParameterTuple| {
        if let Some(choices) = choices {
            return Parameter::categorical(name, choices);
        }
        let parameter = Parameter::continuous(name, unit, lower, upper)?;
        match levels {
            Some(count) => parameter.with_levels(count),
            None => Ok(parameter),
        }
    };
    let parameters = parameters.into_iter().map(one).collect::<Result<Vec<_>, _>>().map_err(refusal)?;
    Region::new(parameters).map_err(refusal)
}

/// The region of parameters that all have to be numbers.
pub(crate) fn region_of_numbers(parameters: Vec<ParameterTuple>) -> PyResult<Region> {
    let region = region(parameters)?;
    region.parameters().iter().try_for_each(Parameter::check_number).map_err(refusal)?;
    Ok(region)
}

/// A region as Python sees it.
pub(crate) fn tuples(region: &Region) -> Vec<ParameterTuple> {
    let one = |parameter: &Parameter| {
        let choices = parameter.choices().map(<[String]>::to_vec);
        let levels = match parameter.levels() {
            design_space::Levels::Count(count) if choices.is_none() => Some(count),
            _ => None,
        };
        let (name, unit) = (parameter.name().to_owned(), parameter.unit().to_owned());
        (name, unit, parameter.lower(), parameter.upper(), levels, choices)
    };
    region.parameters().iter().map(one).collect()
}

/// Numbers that are these but for rounding to twelve digits, with all digits.
pub(crate) fn snap(numbers: &mut [f64], exact: &[f64]) {
    for (number, &exact) in numbers.iter_mut().zip(exact) {
        if (*number - exact).abs() <= 1e-11 * exact.abs() {
            *number = exact;
        }
    }
}

/// A model by its name, or by the exponents of its terms.
#[derive(FromPyObject, Debug)]
pub(crate) enum ModelChoice {
    Name(String),
    Terms(Vec<Vec<u8>>),
}

impl ModelChoice {
    pub(crate) fn model(self, n_factors: usize) -> PyResult<Model> {
        match self {
            Self::Name(name) => Model::named(&name, n_factors),
            Self::Terms(terms) => Model::new(n_factors, terms.into_iter().map(design_space::Term::new).collect()),
        }
        .map_err(refusal)
    }
}

/// Refuses parameters that make no region.
#[pyfunction]
pub(crate) fn check_parameters(parameters: Vec<ParameterTuple>) -> PyResult<()> {
    region(parameters).map(drop)
}

/// Natural settings, coded to the box of the parameters.
#[pyfunction]
pub(crate) fn coded<'py>(
    py: Python<'py>,
    parameters: Vec<ParameterTuple>,
    points: PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    turned(py, parameters, &points, Region::coded)
}

/// Coded settings, natural.
#[pyfunction]
pub(crate) fn natural<'py>(
    py: Python<'py>,
    parameters: Vec<ParameterTuple>,
    points: PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    turned(py, parameters, &points, Region::natural)
}

fn turned<'py>(
    py: Python<'py>,
    parameters: Vec<ParameterTuple>,
    points: &PyReadonlyArray2<'py, f64>,
    turn: impl Fn(&Region, &[f64]) -> Result<Vec<f64>, design_space::Error>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let (region, points) = (region(parameters)?, Matrix::of(points));
    let mut numbers = Vec::with_capacity(points.numbers.len());
    for row in points.rows() {
        numbers.extend(turn(&region, row).map_err(refusal)?);
    }
    matrix(py, region.n_parameters(), numbers)
}
