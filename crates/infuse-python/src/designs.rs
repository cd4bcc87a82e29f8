//! Optimal designs.

use std::time::Duration;

use doe::{Criterion, Design, Effort, EvaluationSettings, Model, Problem, Replicates, Settings, Space, StopReason};
use numpy::{PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{Matrix, matrix};
use crate::background::interruptible;
use crate::error::{Error, refusal};
use crate::parameters::ModelChoice;

/// Number of levels along each axis, nothing where it is continuous.
type Axes = Vec<Option<u32>>;

fn space(axes: Axes) -> PyResult<Space> {
    let axis = |count: Option<u32>| match count {
        // A level is where a parameter with as many levels has it.
        Some(count) => (0..count).map(|level| design_space::coded_level(level.into(), count.into())).collect(),
        None => Vec::new(),
    };
    let axes = axes.into_iter().map(axis);
    let axes =
        axes.map(|levels: Vec<f64>| if levels.is_empty() { doe::Axis::Continuous } else { doe::Axis::Levels(levels) });
    Space::of_axes(axes.collect()).map_err(refusal)
}

fn criterion_named(name: &str) -> PyResult<Criterion> {
    let found = Criterion::ALL.into_iter().find(|criterion| criterion.to_string() == name);
    found.ok_or_else(|| Error::new_err(format!("criterion is `{name}`: it must be D, A, G, E, T or I")))
}

fn design(runs: &PyReadonlyArray2<'_, f64>) -> PyResult<Design> {
    let runs = Matrix::of(runs);
    Design::new(runs.n_columns, runs.numbers).map_err(refusal)
}

/// How long and from where to search.
#[derive(FromPyObject, Debug)]
#[pyo3(from_item_all)]
pub(crate) struct Search {
    seed: u64,
    starts: u64,
    time_limit_s: Option<f64>,
    target_percent: Option<f64>,
    thorough: bool,
    replicates: Option<usize>,
}

impl Search {
    fn settings(&self) -> PyResult<Settings> {
        let mut settings = Settings::default();
        (settings.seed, settings.starts) = (self.seed, self.starts);
        let limit = self.time_limit_s.map(Duration::try_from_secs_f64).transpose();
        settings.time_limit = limit.map_err(|error| Error::new_err(format!("time_limit_s: {error}")))?;
        settings.target_percent = self.target_percent;
        settings.effort = if self.thorough { Effort::Thorough } else { Effort::Quick };
        settings.validate().map_err(refusal)?;
        Ok(settings)
    }
}

/// The best design that a search finds, with its efficiency and how the search went.
#[pyfunction]
pub(crate) fn search<'py>(
    py: Python<'py>,
    axes: Axes,
    model: ModelChoice,
    n_runs: usize,
    criterion: &str,
    fixed: Option<PyReadonlyArray2<'py, f64>>,
    options: Search,
) -> PyResult<Bound<'py, PyDict>> {
    let model = model.model(axes.len())?;
    let mut problem = Problem::new(model, space(axes)?, n_runs, criterion_named(criterion)?).map_err(refusal)?;
    if let Some(fixed) = fixed {
        problem = problem.with_fixed_runs(design(&fixed)?).map_err(refusal)?;
    }
    if let Some(count) = options.replicates {
        problem = problem.with_replicates(Replicates::Planned(count)).map_err(refusal)?;
    }
    let settings = options.settings()?;
    let found = interruptible(py, move || doe::search(&problem, &settings))?.map_err(refusal)?;
    let result = PyDict::new(py);
    result.set_item("runs", matrix(py, found.design.n_factors(), found.design.coordinates().to_vec())?)?;
    result.set_item("percent", found.efficiency.percent)?;
    result.set_item("value", found.efficiency.value)?;
    result.set_item("sentence", found.efficiency.to_string())?;
    let stop = match found.report.stop {
        StopReason::StartsDone => "starts done",
        StopReason::TimeLimit => "time limit",
        StopReason::TargetReached => "target reached",
        StopReason::Interrupted => "interrupted",
    };
    result.set_item("stop", stop)?;
    result.set_item("starts", found.report.starts)?;
    result.set_item("times_found", found.report.times_found)?;
    Ok(result)
}

/// Efficiency of any design in per cent, and as a sentence that says over which set.
#[pyfunction]
pub(crate) fn efficiency(
    py: Python<'_>,
    runs: PyReadonlyArray2<'_, f64>,
    axes: Axes,
    model: ModelChoice,
    criterion: &str,
) -> PyResult<(f64, String)> {
    let (design, criterion) = (design(&runs)?, criterion_named(criterion)?);
    let (model, space) = (model.model(axes.len())?, space(axes)?);
    let found = py.detach(|| criterion.efficiency(&model, &space, &design)).map_err(refusal)?;
    Ok((found.percent, found.to_string()))
}

/// All that is known of a design, as JSON, and as a table for people.
#[pyfunction]
pub(crate) fn evaluate(
    py: Python<'_>,
    runs: PyReadonlyArray2<'_, f64>,
    axes: Axes,
    model: ModelChoice,
    factors: Vec<String>,
) -> PyResult<(String, String)> {
    let design = design(&runs)?;
    let (model, space) = (model.model(axes.len())?, space(axes)?);
    let mut settings = EvaluationSettings::default();
    settings.factors = factors;
    let found = py.detach(|| doe::evaluate(&model, &space, &design, &settings)).map_err(refusal)?;
    Ok((serde_json::to_string(&found).map_err(refusal)?, found.to_string()))
}

/// The regressor at each point, a row each.
#[pyfunction]
pub(crate) fn regressor<'py>(
    py: Python<'py>,
    model: ModelChoice,
    points: PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let points = Matrix::of(&points);
    let model: Model = model.model(points.n_columns)?;
    let mut numbers = Vec::new();
    for point in points.rows() {
        numbers.extend(model.regressor(point).map_err(refusal)?);
    }
    matrix(py, model.n_terms(), numbers)
}

/// Names of the terms of a model.
#[pyfunction]
pub(crate) fn term_names(model: ModelChoice, factors: Vec<String>) -> PyResult<Vec<String>> {
    let names: Vec<&str> = factors.iter().map(String::as_str).collect();
    Ok(model.model(names.len())?.term_names(&names))
}
