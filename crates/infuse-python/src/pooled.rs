//! The pooled loop.

use std::collections::BTreeMap;

use design_space::{Cell, Grid, Parameter, Region};
use infuse::pooled::{Ask, Assessment, Loop, Record, Responses, Settings, Simulate, StopReason, Trial};
use infuse::{Outcome, TrialId};
use numpy::{PyArray1, PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;
use serde::{Deserialize, Serialize};

use crate::arrays::{Matrix, matrix};
use crate::background::interruptible_with;
use crate::error::{Error, refusal, settings_of};
use crate::parameters::{ParameterTuple, region, snap, tuples};
use crate::saved::{saved_as, unpacked};
use crate::simulator::{RemoteSimulator, call};

const FORMAT: u32 = 2;

/// A campaign in a file.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Saved {
    format: u32,
    kind: String,
    stopped: Option<StopReason>,
    campaign: Loop,
}

const KIND: &str = "pooled";

/// `infuse::pooled::Loop`.
#[pyclass(module = "infuse._native")]
#[derive(Debug, Clone)]
pub(crate) struct PooledLoop {
    campaign: Loop,
    stopped: Option<StopReason>,
}

#[pymethods]
impl PooledLoop {
    #[new]
    fn new(parameters: Vec<ParameterTuple>, settings: &str) -> PyResult<Self> {
        Self::begin(&region(parameters)?, read(settings)?)
    }

    #[staticmethod]
    fn from_json(text: &str) -> PyResult<Self> {
        let Saved { stopped, campaign, .. } = unpacked(saved_as(KIND, FORMAT, text)?)?;
        Ok(Self { campaign, stopped })
    }

    fn to_json(&self) -> PyResult<String> {
        let (kind, stopped, campaign) = (KIND.to_owned(), self.stopped, self.campaign.clone());
        serde_json::to_string_pretty(&Saved { format: FORMAT, kind, stopped, campaign }).map_err(refusal)
    }

    fn copy(&self) -> Self {
        self.clone()
    }

    fn parameters(&self) -> Vec<ParameterTuple> {
        tuples(self.campaign.region())
    }

    fn settings(&self) -> PyResult<String> {
        serde_json::to_string(self.campaign.settings()).map_err(refusal)
    }

    fn set_settings(&mut self, settings: &str) -> PyResult<()> {
        self.campaign.set_settings(read(settings)?).map_err(refusal)?;
        self.stopped = None;
        Ok(())
    }

    fn batch(&self) -> usize {
        self.campaign.batch()
    }

    fn n_simulated(&self) -> usize {
        self.campaign.n_simulated()
    }

    fn stopped(&self) -> PyResult<Option<String>> {
        Ok(match self.stopped.map(serde_json::to_value).transpose().map_err(refusal)? {
            Some(serde_json::Value::String(word)) => Some(word),
            _ => None,
        })
    }

    /// Outstanding trials as JSON; new ones if there are none, or with `more`.
    fn ask(&mut self, py: Python<'_>, simulate: Option<Py<PyAny>>, more: bool) -> PyResult<String> {
        let waits = !self.campaign.outstanding().is_empty() || !self.campaign.due().is_empty();
        if more || !waits {
            match self.with(py, simulate, |campaign, simulate| campaign.ask_more(simulate))? {
                Ask::Run { .. } => self.stopped = None,
                Ask::Stopped(reason) => self.stopped = Some(reason),
            }
        }
        self.outstanding()
    }

    fn outstanding(&self) -> PyResult<String> {
        serde_json::to_string(&self.campaign.outstanding()).map_err(refusal)
    }

    fn records(&self) -> PyResult<String> {
        serde_json::to_string(self.campaign.records()).map_err(refusal)
    }

    /// Experiments that the experimenter wants, at the designs nearest to these settings.
    fn hand_out(&mut self, points: PyReadonlyArray2<'_, f64>) -> PyResult<String> {
        let cells = self.cells(&points)?;
        let trials: Vec<Trial> = self.campaign.hand_out(&cells).map_err(refusal)?;
        serde_json::to_string(&trials).map_err(refusal)
    }

    /// The settings to simulate before the next batch.
    fn due<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let grid = self.campaign.grid();
        let due = self.campaign.due().iter();
        let points = due.map(|&cell| grid.point(cell)).collect::<Result<Vec<_>, _>>().map_err(refusal)?;
        matrix(py, self.campaign.region().n_parameters(), points.concat())
    }

    #[pyo3(signature = (id, value, failed, actual, again))]
    fn tell(
        &mut self,
        id: u64,
        value: Option<f64>,
        failed: Option<String>,
        actual: Option<Vec<f64>>,
        again: bool,
    ) -> PyResult<()> {
        let actual = actual.map(|actual| self.snapped(id, actual));
        let (id, outcome) = (TrialId::new(id), outcome(value, failed));
        match (again, actual) {
            (true, actual) => self.campaign.correct(id, actual.as_deref(), outcome),
            (false, Some(actual)) => self.campaign.tell_at(id, &actual, outcome),
            (false, None) => self.campaign.tell(id, outcome),
        }
        .map_err(refusal)
    }

    /// What was told of the constrained responses of trials, by their numbers, in the order of the constraints.
    fn constrained(&self) -> BTreeMap<u64, Vec<Option<f64>>> {
        self.told_constrained()
    }

    /// Whether a constrained response was measured or simulated anywhere.
    fn has_constrained(&self) -> bool {
        self.campaign.has_constrained()
    }

    /// The constrained responses of a trial, in the order of the constraints.
    fn tell_constrained(&mut self, id: u64, values: Vec<Option<f64>>) -> PyResult<()> {
        self.campaign.tell_constrained(TrialId::new(id), &values).map_err(refusal)
    }

    fn tell_simulations(&mut self, points: PyReadonlyArray2<'_, f64>, values: Vec<f64>) -> PyResult<()> {
        let cells = self.cells(&points)?;
        let n_columns = 1 + self.campaign.settings().constraints.len();
        if !cells.is_empty() && values.len() != cells.len() && values.len() != n_columns * cells.len() {
            let (found, expected) = (values.len(), cells.len());
            return Err(Error::new_err(format!("`values` has {found} entries, expected {expected}: one per design")));
        }
        let per_design = values.len() / cells.len().max(1);
        for (cell, values) in cells.into_iter().zip(values.chunks(per_design.max(1))) {
            let constrained: Vec<Option<f64>> =
                values[1..].iter().map(|value| value.is_finite().then_some(*value)).collect();
            // A cost that is no number counts as a failure.
            let said = Ok(Responses { cost: values[0], constrained });
            self.campaign.tell_simulation(cell, said).map_err(refusal)?;
        }
        Ok(())
    }

    fn forget_simulations(&mut self) {
        self.campaign.forget_simulations();
    }

    fn add_earlier(
        &mut self,
        point: Vec<f64>,
        value: Option<f64>,
        failed: Option<String>,
        source: String,
        constrained: Vec<Option<f64>>,
    ) -> PyResult<()> {
        match outcome(value, failed) {
            Outcome::Value(cost) => self.campaign.add_earlier(&point, Responses { cost, constrained }, source),
            Outcome::Failed { reason } => self.campaign.add_earlier_failure(&point, reason, source),
        }
        .map_err(refusal)
    }

    fn withdraw_earlier(&mut self, source: &str) -> usize {
        self.campaign.withdraw_earlier(source)
    }

    fn earlier(&self) -> PyResult<String> {
        serde_json::to_string(self.campaign.earlier()).map_err(refusal)
    }

    fn assess(&mut self, py: Python<'_>, simulate: Option<Py<PyAny>>) -> PyResult<Option<String>> {
        let assessment: Option<Assessment> = self.with(py, simulate, |campaign, simulate| campaign.assess(simulate))?;
        assessment.map(|assessment| serde_json::to_string(&assessment).map_err(refusal)).transpose()
    }

    /// Standings of the designs nearest to these settings, as JSON.
    fn standings(
        &mut self,
        py: Python<'_>,
        points: PyReadonlyArray2<'_, f64>,
        simulate: Option<Py<PyAny>>,
    ) -> PyResult<Option<String>> {
        let cells = self.cells(&points)?;
        let standings = self.with(py, simulate, move |campaign, simulate| campaign.standings(&cells, simulate))?;
        standings.map(|standings| serde_json::to_string(&standings).map_err(refusal)).transpose()
    }

    /// n × 3: mean, deviation and probability to give a response, at the designs nearest to these settings.
    fn expectations<'py>(
        &mut self,
        py: Python<'py>,
        points: PyReadonlyArray2<'py, f64>,
        simulate: Option<Py<PyAny>>,
    ) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        let cells = self.cells(&points)?;
        let found = self.with(py, simulate, move |campaign, simulate| campaign.expectations(&cells, simulate))?;
        let numbers = found.map(|all| all.iter().flat_map(|one| [one.mean, one.deviation, one.feasible]).collect());
        numbers.map(|numbers| matrix(py, 3, numbers)).transpose()
    }

    fn surprises<'py>(
        &mut self,
        py: Python<'py>,
        simulate: Option<Py<PyAny>>,
    ) -> PyResult<Option<Bound<'py, PyArray1<f64>>>> {
        let found = self.with(py, simulate, |campaign, simulate| campaign.surprises(simulate))?;
        Ok(found.map(|surprises| PyArray1::from_vec(py, surprises)))
    }
}

impl PooledLoop {
    fn begin(region: &Region, settings: Settings) -> PyResult<Self> {
        let campaign = Loop::new(region, settings).map_err(refusal)?;
        Ok(Self { campaign, stopped: None })
    }

    /// What was told of the constrained responses of trials.
    fn told_constrained(&self) -> BTreeMap<u64, Vec<Option<f64>>> {
        let of = |record: &Record| (record.trial.id.number(), self.campaign.constrained(record.trial.id).to_vec());
        self.campaign.records().iter().map(of).filter(|(_, values)| !values.is_empty()).collect()
    }

    /// Settings that were made, the asked ones with all their digits where they are those but for rounding to twelve.
    fn snapped(&self, id: u64, mut actual: Vec<f64>) -> Vec<f64> {
        let trial = self.campaign.records().iter().map(|record| &record.trial).find(|trial| trial.id.number() == id);
        snap(&mut actual, trial.map_or(&[], |trial| &trial.point));
        actual
    }

    /// Lets the loop work while other Python threads run. Where the simulation raises, and after Ctrl-C, the campaign stays as
    /// it was.
    fn with<T: Send + 'static>(
        &mut self,
        py: Python<'_>,
        simulate: Option<Py<PyAny>>,
        work: impl FnOnce(&mut Loop, Option<&mut dyn Simulate>) -> Result<T, infuse::Error> + Send + 'static,
    ) -> PyResult<T> {
        let (mut campaign, is_simulated) = (self.campaign.clone(), simulate.is_some());
        let answer = |points: &[Vec<f64>]| match &simulate {
            Some(function) => call(py, function, points),
            None => Ok(Vec::new()),
        };
        let (campaign, outcome) = interruptible_with(py, answer, move |caller| {
            let mut simulator = RemoteSimulator::new(caller);
            let outcome = work(&mut campaign, is_simulated.then_some(&mut simulator as &mut dyn Simulate));
            (campaign, outcome)
        })?;
        self.campaign = campaign;
        outcome.map_err(refusal)
    }

    /// The designs nearest to these settings.
    fn cells(&self, points: &PyReadonlyArray2<'_, f64>) -> PyResult<Vec<Cell>> {
        nearest(self.campaign.grid(), self.campaign.region(), &Matrix::of(points))
    }
}

/// The cells nearest to these settings, which must be within the bounds, but for rounding to twelve digits.
fn nearest(grid: &Grid, region: &Region, points: &Matrix) -> PyResult<Vec<Cell>> {
    let lower: Vec<f64> = region.parameters().iter().map(Parameter::lower).collect();
    let upper: Vec<f64> = region.parameters().iter().map(Parameter::upper).collect();
    let cell = |point: &[f64]| {
        let mut point = point.to_vec();
        snap(&mut point, &lower);
        snap(&mut point, &upper);
        grid.nearest(&point)
    };
    points.rows().map(cell).collect::<Result<Vec<_>, _>>().map_err(refusal)
}

fn read(settings: &str) -> PyResult<Settings> {
    settings_of(serde_json::from_str(settings).map_err(refusal)?, &["n_experiments"])
}

/// A failure with its reason, or a response; one that is not finite is refused by the loop.
fn outcome(value: Option<f64>, failed: Option<String>) -> Outcome {
    match (value, failed) {
        (Some(value), None) => Outcome::Value(value),
        (_, reason) => Outcome::Failed { reason: reason.unwrap_or_default() },
    }
}
