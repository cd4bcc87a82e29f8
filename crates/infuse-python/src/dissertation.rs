//! The loop of the dissertation.

use infuse::global::{Loop, Settings};
use infuse::{Outcome, TrialId};
use pyo3::prelude::*;
use serde_json::{Value, json};

use crate::background::interruptible;
use crate::error::{refusal, settings_of};
use crate::parameters::{ModelChoice, ParameterTuple, region_of_numbers, snap, tuples};
use crate::saved::{saved_as, unpacked};
use crate::simulator::{one_each, result};

const FORMAT: u32 = 1;
const KIND: &str = "global";
/// Surfaces that are drawn for the outlook.
const DRAWS: usize = 200;

/// `infuse::global::Loop`.
#[pyclass(module = "infuse._native")]
#[derive(Debug, Clone)]
pub(crate) struct DissertationLoop {
    campaign: Loop,
}

#[pymethods]
impl DissertationLoop {
    /// `settings` is a JSON object with the keys of `infuse::global::Settings`, the model left out.
    #[new]
    fn new(parameters: Vec<ParameterTuple>, model: ModelChoice, settings: &str) -> PyResult<Self> {
        let region = region_of_numbers(parameters)?;
        let mut settings: Value = serde_json::from_str(settings).map_err(refusal)?;
        settings["model"] = serde_json::to_value(model.model(region.n_parameters())?).map_err(refusal)?;
        let settings: Settings = settings_of(settings, &["model", "n_experiments", "n_simulations"])?;
        Ok(Self { campaign: Loop::new(&region, settings).map_err(refusal)? })
    }

    /// Follows the campaign again: what was computed must come out as it was.
    #[staticmethod]
    fn from_json(py: Python<'_>, text: &str) -> PyResult<Self> {
        let mut saved = saved_as(KIND, FORMAT, text)?;
        let campaign = interruptible(py, move || unpacked(saved["campaign"].take()))??;
        Ok(Self { campaign })
    }

    fn to_json(&self) -> PyResult<String> {
        let campaign = serde_json::to_value(&self.campaign).map_err(refusal)?;
        serde_json::to_string_pretty(&json!({ "format": FORMAT, "kind": KIND, "campaign": campaign })).map_err(refusal)
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

    /// Number of closed batches.
    fn batch(&self) -> usize {
        self.campaign.reports().len()
    }

    /// Why the campaign has ended: the word of a file, and a sentence.
    fn stopped(&self) -> PyResult<Option<(String, String)>> {
        let Some(reason) = self.campaign.stop() else { return Ok(None) };
        let word = serde_json::to_value(reason).map_err(refusal)?;
        Ok(Some((word.as_str().unwrap_or_default().to_owned(), reason.to_string())))
    }

    /// Outstanding trials as JSON; those of a new batch if there are none. All its simulations are asked for at once.
    fn ask(&mut self, py: Python<'_>, simulate: Py<PyAny>) -> PyResult<String> {
        open(py, &mut self.campaign, &simulate)?;
        self.outstanding()
    }

    fn outstanding(&self) -> PyResult<String> {
        serde_json::to_string(&self.campaign.outstanding()).map_err(refusal)
    }

    fn tell(
        &mut self,
        py: Python<'_>,
        id: u64,
        value: Option<f64>,
        failed: Option<String>,
        actual: Option<Vec<f64>>,
    ) -> PyResult<()> {
        let outcome = match (value, failed) {
            (Some(value), None) => Outcome::Value(value),
            (_, reason) => Outcome::Failed { reason: reason.unwrap_or_default() },
        };
        let mut actual = actual;
        if let Some(actual) = &mut actual {
            let asked = self.campaign.outstanding().into_iter().find(|trial| trial.id.number() == id);
            snap(actual, asked.as_ref().map_or(&[], |trial| &trial.point));
        }
        let (id, mut campaign) = (TrialId::new(id), self.campaign.clone());
        self.campaign = interruptible(py, move || {
            match actual {
                Some(actual) => campaign.tell_at(id, &actual, outcome),
                None => campaign.tell(id, outcome),
            }
            .map(|()| campaign)
        })?
        .map_err(refusal)?;
        Ok(())
    }

    /// The trials of the batch that is open, with what is known of them, as JSON.
    fn open_records(&self) -> PyResult<String> {
        let state = serde_json::to_value(&self.campaign).map_err(refusal)?;
        let trials = &state["open"]["trials"];
        Ok(if trials.is_array() { trials.to_string() } else { "[]".to_owned() })
    }

    fn add_earlier(&mut self, point: Vec<f64>, value: f64, source: String) -> PyResult<()> {
        self.campaign.add_earlier(&point, value, source).map_err(refusal)
    }

    fn withdraw_earlier(&mut self, source: &str) -> usize {
        self.campaign.withdraw_earlier(source)
    }

    /// The closed batches as JSON.
    fn reports(&self) -> PyResult<String> {
        serde_json::to_string(self.campaign.reports()).map_err(refusal)
    }

    /// What the last closed batch came to, as JSON.
    fn assess(&self, py: Python<'_>) -> PyResult<Option<String>> {
        let campaign = self.campaign.clone();
        interruptible(py, move || assessment(&campaign))?.map_err(refusal)
    }
}

/// Opens the next batch, unless there is one, or the campaign has ended.
fn open(py: Python<'_>, campaign: &mut Loop, simulate: &Py<PyAny>) -> PyResult<()> {
    let now = campaign.clone();
    let Some(plan) = interruptible(py, move || now.plan())?.map_err(refusal)? else { return Ok(()) };
    let points = plan.simulations.iter().map(|&cell| campaign.point(cell));
    let points: Vec<Vec<f64>> = points.collect::<Result<_, _>>().map_err(refusal)?;
    // The plan has them in the order in which the loop asks.
    let mut responses = one_each(py, simulate, &points)?.into_iter();
    let mut now = campaign.clone();
    let (now, opened) = interruptible(py, move || {
        let mut answer = |_, _: &[f64]| responses.next().map_or_else(|| Err("no response".to_owned()), result);
        let opened = now.open(&plan, &mut answer).map(drop);
        (now, opened)
    })?;
    *campaign = now;
    opened.map_err(refusal)
}

fn assessment(campaign: &Loop) -> Result<Option<String>, infuse::Error> {
    let Some(report) = campaign.reports().last() else { return Ok(None) };
    let screening = &report.screening;
    let noise = campaign.pure_error();
    let outlook = campaign.outlook(DRAWS, noise)?.map(|outlook| {
        json!({ "mean_gain": outlook.mean_gain, "upper_gain": outlook.upper_gain, "misfit_gain": outlook.misfit_gain })
    });
    let certificate = campaign.observed_certificate()?.map(|observed| {
        let regret = observed.certificate.regret;
        json!({ "regret": regret, "eps": observed.eps, "simulation": observed.simulation, "experiment": observed.experiment })
    });
    let found = json!({
        "batch": report.number,
        "optimum": screening.optimum,
        "optimum_value": screening.optimum_value,
        "simulation_optimum": screening.simulation_optimum,
        "spread": screening.spread.s(),
        "n_left": screening.n_after,
        "left": campaign.retained().share(),
        "noise": noise.map(|noise| noise.standard_deviation()),
        "certificate": certificate,
        "outlook": outlook,
    });
    Ok(Some(found.to_string()))
}
