//! The TOML file that the examples `design_from_toml` and `evaluate_design` share.

#![allow(dead_code, reason = "evaluate_design does not search and needs only a part")]

use std::collections::BTreeMap;
use std::error::Error;
use std::io;
use std::process::ExitCode;
use std::time::Duration;

use doe::{
    Criterion, Design, EvaluationSettings, Forbidden, Model, Parameter, Problem, Region, Replicates, Settings, Space,
    Term,
};
use serde::Deserialize;

/// Complains about an error; a reader that has seen enough, as `head`, is none.
#[expect(clippy::print_stderr, reason = "this is where a program complains")]
pub(crate) fn finish(result: Result<(), Box<dyn Error>>) -> ExitCode {
    match result {
        Err(error)
            if error.downcast_ref::<io::Error>().is_none_or(|error| error.kind() != io::ErrorKind::BrokenPipe) =>
        {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
        _ => ExitCode::SUCCESS,
    }
}

/// A digit, a comma and a digit in what stands after the equals sign.
fn has_decimal_comma(line: &str) -> bool {
    let value = line.split('#').next().unwrap_or_default().split('=').nth(1).unwrap_or_default().as_bytes();
    value.windows(3).any(|three| three[0].is_ascii_digit() && three[1] == b',' && three[2].is_ascii_digit())
}

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
    forbidden: Vec<BTreeMap<String, Vec<f64>>>,
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
        toml::from_str(&text).map_err(|error| {
            let at = error.span().map_or(0, |span| span.start);
            let line = text.lines().nth(text[..at.min(text.len())].matches('\n').count()).unwrap_or_default();
            let hint = if has_decimal_comma(line) { "a decimal comma? write 20.5 and not 20,5\n" } else { "" };
            format!("{path}: {error}{hint}").into()
        })
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

    pub(crate) fn space<'a>(&'a self) -> Result<Space, Box<dyn Error>> {
        let region = self.region()?;
        let forbidden = self.forbidden.iter().enumerate().map(|(index, ranges)| {
            let range = |(name, ends): (&'a String, &Vec<f64>)| match ends[..] {
                [a, b] => Ok((name.as_str(), a, b)),
                _ => Err(format!(
                    "forbidden {}: `{name}` has {} {}, expected 2 as in [20.0, 22.5]{}",
                    index + 1,
                    ends.len(),
                    if ends.len() == 1 { "number" } else { "numbers" },
                    if ends.len() > 2 { "; a decimal comma separates numbers" } else { "" },
                )),
            };
            let ranges = ranges.iter().map(range).collect::<Result<Vec<(&str, f64, f64)>, String>>()?;
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
        let model = self.model()?;
        let names: Vec<&str> = self.parameters.iter().map(Parameter::name).collect();
        let terms = model.term_names(&names);
        let mut problem = Problem::new(model, self.space()?, self.runs, self.criterion)
            .map_err(|error| error.with_term_names(&terms))?;
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
