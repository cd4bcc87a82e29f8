//! Response surfaces.

use std::sync::Arc;

use numpy::{PyArray1, PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;
use surface::process::{AveragedProcess, Hyperparameters, Marginals, Places, SamplerSettings, Sites, Structure};
use surface::{Data, LeaveOneOut, Rows, Surface};

use crate::arrays::{Matrix, matrix};
use crate::background::interruptible;
use crate::error::{Error, refusal, settings_of};
use crate::parameters::ModelChoice;

fn data(points: &PyReadonlyArray2<'_, f64>, values: Vec<f64>, weights: Option<Vec<f64>>) -> PyResult<Data> {
    let points = Matrix::of(points);
    let data = Data::new(points.n_columns, points.numbers, values).map_err(refusal)?;
    match weights {
        Some(weights) => data.with_weights(weights).map_err(refusal),
        None => Ok(data),
    }
}

/// Estimates at points of as many coordinates as the surface has factors.
fn predict<'py>(
    py: Python<'py>,
    surface: &dyn Surface,
    points: &PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let points = checked(surface, points)?;
    let mut estimates = vec![0.0; points.numbers.len() / points.n_columns.max(1)];
    py.detach(|| surface.predict_into(&points.numbers, &mut estimates)).map_err(refusal)?;
    Ok(PyArray1::from_vec(py, estimates))
}

fn checked(surface: &dyn Surface, points: &PyReadonlyArray2<'_, f64>) -> PyResult<Matrix> {
    let points = Matrix::of(points);
    let (expected, found) = (surface.n_factors(), points.n_columns);
    if expected != found {
        return Err(refusal(surface::Error::FactorMismatch { what: "the points", expected, found }));
    }
    Ok(points)
}

/// Slopes at points, NaN where there is none.
fn gradient<'py>(
    py: Python<'py>,
    surface: &dyn Surface,
    points: &PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let points = checked(surface, points)?;
    let none = || vec![f64::NAN; points.n_columns];
    let slopes = points.rows().flat_map(|point| surface.gradient(point).unwrap_or_else(none)).collect();
    matrix(py, points.n_columns, slopes)
}

/// The smallest estimate at points: which, and what.
fn minimum(py: Python<'_>, surface: &dyn Surface, points: &PyReadonlyArray2<'_, f64>) -> PyResult<Option<(u64, f64)>> {
    let points = checked(surface, points)?;
    let rows = Rows::new(points.n_columns, &points.numbers).map_err(refusal)?;
    let found = py.detach(|| surface.minimum_over(&rows)).map_err(refusal)?;
    Ok(found.map(|minimum| (minimum.index, minimum.value)))
}

fn residuals(py: Python<'_>, left_out: LeaveOneOut) -> Bound<'_, PyArray1<f64>> {
    PyArray1::from_slice(py, left_out.residuals())
}

/// (30), (31).
#[pyclass(module = "infuse._native")]
#[derive(Debug)]
pub(crate) struct Regression(surface::Regression);

#[pymethods]
impl Regression {
    #[new]
    fn new(
        py: Python<'_>,
        points: PyReadonlyArray2<'_, f64>,
        values: Vec<f64>,
        weights: Option<Vec<f64>>,
        model: ModelChoice,
    ) -> PyResult<Self> {
        let data = data(&points, values, weights)?;
        let model = model.model(data.n_factors())?;
        Ok(Self(py.detach(|| surface::Regression::fit(&model, &data)).map_err(refusal)?))
    }

    fn predict<'py>(&self, py: Python<'py>, points: PyReadonlyArray2<'py, f64>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        predict(py, &self.0, &points)
    }

    fn gradient<'py>(
        &self,
        py: Python<'py>,
        points: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        gradient(py, &self.0, &points)
    }

    fn minimum(&self, py: Python<'_>, points: PyReadonlyArray2<'_, f64>) -> PyResult<Option<(u64, f64)>> {
        minimum(py, &self.0, &points)
    }

    /// NaN without degrees of freedom.
    fn variance<'py>(
        &self,
        py: Python<'py>,
        points: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let points = checked(&self.0, &points)?;
        let variances = points.rows().map(|point| self.0.variance(point).unwrap_or(f64::NAN));
        Ok(PyArray1::from_vec(py, variances.collect()))
    }

    fn leave_one_out<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(residuals(py, self.0.leave_one_out().map_err(refusal)?))
    }

    fn coefficients<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, self.0.coefficients())
    }

    fn standard_errors<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        self.0.standard_errors().map(|errors| PyArray1::from_vec(py, errors))
    }

    fn terms(&self) -> Vec<String> {
        self.0.model().term_names(&[])
    }

    fn degrees_of_freedom(&self) -> usize {
        self.0.degrees_of_freedom()
    }

    fn sigma_squared(&self) -> Option<f64> {
        self.0.sigma_squared()
    }

    fn r_squared(&self) -> Option<f64> {
        self.0.r_squared()
    }

    /// F and its probability if the model is right.
    fn lack_of_fit(&self) -> PyResult<(f64, f64)> {
        self.0.lack_of_fit().map(|test| (test.f, test.p_value)).map_err(refusal)
    }
}

/// (32), (33).
#[pyclass(module = "infuse._native")]
#[derive(Debug)]
pub(crate) struct InverseDistance(surface::InverseDistance);

#[pymethods]
impl InverseDistance {
    #[new]
    fn new(
        points: PyReadonlyArray2<'_, f64>,
        values: Vec<f64>,
        weights: Option<Vec<f64>>,
        power: f64,
    ) -> PyResult<Self> {
        surface::InverseDistance::fit(data(&points, values, weights)?, power).map(Self).map_err(refusal)
    }

    fn predict<'py>(&self, py: Python<'py>, points: PyReadonlyArray2<'py, f64>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        predict(py, &self.0, &points)
    }

    fn gradient<'py>(
        &self,
        py: Python<'py>,
        points: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        gradient(py, &self.0, &points)
    }

    fn minimum(&self, py: Python<'_>, points: PyReadonlyArray2<'_, f64>) -> PyResult<Option<(u64, f64)>> {
        minimum(py, &self.0, &points)
    }

    fn leave_one_out<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(residuals(py, self.0.leave_one_out().map_err(refusal)?))
    }
}

/// (34).
#[pyclass(module = "infuse._native")]
#[derive(Debug)]
pub(crate) struct SquaredExponential(surface::SquaredExponential);

#[pymethods]
impl SquaredExponential {
    #[new]
    fn new(
        py: Python<'_>,
        points: PyReadonlyArray2<'_, f64>,
        values: Vec<f64>,
        weights: Option<Vec<f64>>,
        scale: Option<f64>,
    ) -> PyResult<Self> {
        let data = data(&points, values, weights)?;
        let fit = move || match scale {
            Some(scale) => surface::SquaredExponential::fit(data, scale),
            None => surface::SquaredExponential::fit_scale(data),
        };
        interruptible(py, fit)?.map(Self).map_err(refusal)
    }

    fn predict<'py>(&self, py: Python<'py>, points: PyReadonlyArray2<'py, f64>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        predict(py, &self.0, &points)
    }

    fn gradient<'py>(
        &self,
        py: Python<'py>,
        points: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        gradient(py, &self.0, &points)
    }

    fn minimum(&self, py: Python<'_>, points: PyReadonlyArray2<'_, f64>) -> PyResult<Option<(u64, f64)>> {
        minimum(py, &self.0, &points)
    }

    fn scale(&self) -> f64 {
        self.0.scale()
    }

    fn leave_one_out<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(residuals(py, self.0.leave_one_out().map_err(refusal)?))
    }
}

/// One process, or an average of those that the measurements leave possible.
#[derive(Debug)]
enum Process {
    Given(Box<surface::process::GaussianProcess>),
    Averaged(AveragedProcess),
}

/// A Gaussian process.
#[pyclass(module = "infuse._native")]
#[derive(Debug)]
pub(crate) struct GaussianProcess(Process);

#[pymethods]
impl GaussianProcess {
    /// `settings` is a JSON object: `structures`, `noise`, `particles`, `seed`.
    #[staticmethod]
    fn averaged(
        py: Python<'_>,
        points: PyReadonlyArray2<'_, f64>,
        values: Vec<f64>,
        weights: Option<Vec<f64>>,
        simulated: Option<Vec<f64>>,
        settings: &str,
    ) -> PyResult<Self> {
        let sites = sites(&data(&points, values, weights)?, simulated)?;
        let settings = sampler(settings, sites.places().simulated().is_some())?;
        interruptible(py, move || AveragedProcess::new(sites, &settings))?
            .map(|process| Self(Process::Averaged(process)))
            .map_err(refusal)
    }

    /// With these hyperparameters, as JSON; values count from the first of `units`, in multiples of the second.
    #[staticmethod]
    fn given(
        points: PyReadonlyArray2<'_, f64>,
        values: Vec<f64>,
        weights: Option<Vec<f64>>,
        simulated: Option<Vec<f64>>,
        structure: &str,
        hyperparameters: &str,
        units: (f64, f64),
    ) -> PyResult<Self> {
        let sites = sites(&data(&points, values, weights)?, simulated)?.in_units(units.0, units.1).map_err(refusal)?;
        let structure: Structure = parsed(structure)?;
        let hyperparameters: Hyperparameters = parsed(hyperparameters)?;
        let process = surface::process::GaussianProcess::new(Arc::new(sites), structure, hyperparameters);
        process.map(|process| Self(Process::Given(Box::new(process)))).map_err(refusal)
    }

    /// n × 2: mean and variance, without noise.
    fn predict<'py>(
        &self,
        py: Python<'py>,
        points: PyReadonlyArray2<'py, f64>,
        simulated: Option<Vec<f64>>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let points = Matrix::of(&points);
        let (expected, found) = (self.places().n_factors(), points.n_columns);
        if expected != found {
            return Err(refusal(surface::Error::FactorMismatch { what: "the points", expected, found }));
        }
        if self.places().simulated().is_some() != simulated.is_some() {
            let expected =
                if simulated.is_some() { "none: it was fitted without" } else { "one per point: it was fitted with" };
            return Err(Error::new_err(format!("simulated responses, expected {expected} simulated responses")));
        }
        let mut places = Places::new(points.n_columns, &points.numbers).map_err(refusal)?;
        if let Some(simulated) = simulated {
            places = places.with_simulated(simulated).map_err(refusal)?;
        }
        let marginals = py.detach(|| match &self.0 {
            Process::Given(process) => process.marginals(&places),
            Process::Averaged(process) => process.marginals(&places),
        });
        let Marginals { means, variances } = marginals.map_err(refusal)?;
        matrix(py, 2, means.into_iter().zip(variances).flat_map(|(mean, variance)| [mean, variance]).collect())
    }

    /// Standard deviation of one measurement of weight 1.
    fn noise(&self) -> Option<f64> {
        match &self.0 {
            Process::Given(_) => None,
            Process::Averaged(process) => Some(process.noise()),
        }
    }

    fn leave_one_out<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let found = match &self.0 {
            Process::Given(process) => process.standardized_leave_one_out(),
            Process::Averaged(process) => process.standardized_leave_one_out(),
        };
        PyArray1::from_vec(py, found)
    }
}

impl GaussianProcess {
    fn places(&self) -> &Places {
        match &self.0 {
            Process::Given(process) => process.sites().places(),
            Process::Averaged(process) => process.sites().places(),
        }
    }
}

fn sites(data: &Data, simulated: Option<Vec<f64>>) -> PyResult<Sites> {
    Sites::new(data, simulated.as_deref()).map_err(refusal)
}

fn parsed<T: serde::de::DeserializeOwned>(text: &str) -> PyResult<T> {
    settings_of(serde_json::from_str(text).map_err(refusal)?, &["particles", "seed"])
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct Sampler {
    structures: Option<Vec<Structure>>,
    noise: Option<f64>,
    particles: usize,
    seed: u64,
}

/// By default all structures that need no simulation, or all where there is one.
fn sampler(settings: &str, is_simulated: bool) -> PyResult<SamplerSettings> {
    let Sampler { structures, noise, particles, seed } = parsed(settings)?;
    let usable =
        |structure: &Structure| is_simulated || structure.simulation == surface::process::SimulationUse::Ignored;
    let structures = structures.unwrap_or_else(|| Structure::ALL.into_iter().filter(usable).collect());
    Ok(SamplerSettings { structures, noise, particles, seed, ..SamplerSettings::default() })
}
