//! The TOML file that the examples `design_from_toml` and `evaluate_design` share.

#![allow(dead_code, reason = "evaluate_design does not search and needs only a part")]

use std::cmp::Ordering::{Equal, Less};
use std::collections::BTreeMap;
use std::error::Error;
use std::time::Duration;

use doe::{
    Criterion, Design, EvaluationSettings, Forbidden, Model, Parameter, Problem, Region, Replicates, Settings, Space,
    Term,
};
use serde::Deserialize;

/// The file as it stands; a key that is not here is an error.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ProblemFile {
    runs: usize,
    model: ModelName,
    criterion: Criterion,
    replicates: Option<usize>,
    starts: Option<u64>,
    seconds: Option<f64>,
    seed: Option<u64>,
    pub(crate) order_seed: Option<u64>,
    parameters: Vec<Parameter>,
    #[serde(default)]
    forbidden: Vec<BTreeMap<String, [f64; 2]>>,
    #[serde(default)]
    fixed: Vec<BTreeMap<String, f64>>,
}

#[derive(Deserialize)]
#[serde(untagged, expecting = "expected \"linear\", \"additive quadratic\", \"quadratic\" or a list of exponents")]
enum ModelName {
    Named(String),
    Listed(Vec<Vec<u8>>),
}

impl ProblemFile {
    pub(crate) fn read(path: &str) -> Result<Self, Box<dyn Error>> {
        let text = std::fs::read_to_string(path).map_err(|error| format!("{path}: {error}"))?;
        toml::from_str(&text).map_err(|error| format!("{path}: {error}").into())
    }

    pub(crate) fn region(&self) -> Result<Region, doe::Error> {
        Region::new(self.parameters.clone())
    }

    pub(crate) fn model(&self) -> Result<Model, Box<dyn Error>> {
        let k = self.parameters.len();
        Ok(match &self.model {
            ModelName::Named(name) => match name.as_str() {
                "linear" => Model::linear(k)?,
                "additive quadratic" => Model::additive_quadratic(k)?,
                "quadratic" => Model::quadratic(k)?,
                _ => {
                    let expected = "expected \"linear\", \"additive quadratic\", \"quadratic\" or a list of exponents";
                    return Err(format!("model \"{name}\": {expected}").into());
                }
            },
            ModelName::Listed(terms) => Model::new(k, terms.iter().map(|term| Term::new(term.clone())).collect())?,
        })
    }

    pub(crate) fn space(&self) -> Result<Space, Box<dyn Error>> {
        let region = self.region()?;
        let forbidden = self.forbidden.iter().enumerate().map(|(index, ranges)| {
            if let Some((name, [a, b])) =
                ranges.iter().find(|(_, [a, b])| !matches!(a.partial_cmp(b), Some(Less | Equal)))
            {
                return Err(format!("forbidden {}: `{name}` from {a} to {b}, expected a range that rises", index + 1));
            }
            let ranges: Vec<(&str, f64, f64)> = ranges.iter().map(|(name, [a, b])| (name.as_str(), *a, *b)).collect();
            Forbidden::in_region(&region, &ranges).map_err(|error| format!("forbidden {}: {error}", index + 1))
        });
        Ok(Space::of_region(&region)?.forbid(forbidden.collect::<Result<_, _>>()?)?)
    }

    /// The settled runs, coded.
    fn fixed(&self) -> Result<Option<Design>, Box<dyn Error>> {
        let region = self.region()?;
        let mut runs = Vec::new();
        for (index, settings) in self.fixed.iter().enumerate() {
            let at = |error: String| format!("fixed run {}: {error}", index + 1);
            if let Some(name) = settings.keys().find(|name| region.index_of(name).is_none()) {
                return Err(at(format!("the region has no parameter `{name}`")).into());
            }
            let value = |parameter: &Parameter| {
                let value = settings.get(parameter.name());
                value.copied().ok_or_else(|| at(format!("no value of `{}`", parameter.name())))
            };
            let run: Vec<f64> = self.parameters.iter().map(value).collect::<Result<_, _>>()?;
            region.check(&run).map_err(|error| at(error.to_string()))?;
            if !self.space()?.contains(&region.coded(&run)?) {
                let nearest = region.snap(&run)?;
                return Err(at(format!("{run:?} is forbidden, or not on the levels (nearest: {nearest:?})")).into());
            }
            runs.push(run);
        }
        Ok(if runs.is_empty() { None } else { Some(Design::from_natural(&region, &runs)?) })
    }

    pub(crate) fn problem(&self) -> Result<Problem, Box<dyn Error>> {
        let mut problem = Problem::new(self.model()?, self.space()?, self.runs, self.criterion)?;
        if let Some(fixed) = self.fixed()? {
            problem = problem.with_fixed_runs(fixed)?;
        }
        Ok(match self.replicates {
            Some(planned) => problem.with_replicates(Replicates::Planned(planned))?,
            None => problem,
        })
    }

    pub(crate) fn settings(&self) -> Result<Settings, Box<dyn Error>> {
        let mut settings = Settings::default();
        settings.seed = self.seed.unwrap_or(settings.seed);
        settings.starts = self.starts.unwrap_or(settings.starts);
        let limit = self.seconds.map(Duration::try_from_secs_f64).transpose();
        settings.time_limit = limit.map_err(|error| format!("seconds: {error}"))?;
        Ok(settings)
    }

    pub(crate) fn evaluation_settings(&self) -> EvaluationSettings {
        let mut settings = EvaluationSettings::default();
        settings.factors = self.parameters.iter().map(|parameter| parameter.name().to_owned()).collect();
        settings
    }
}
