//! The TOML file that the examples `design_from_toml` and `evaluate_design` share.

#![allow(dead_code, reason = "evaluate_design does not search and needs only a part")]

use std::collections::BTreeMap;
use std::error::Error;
use std::io::{self, Write as _};
use std::process::ExitCode;
use std::time::Duration;

use doe::{
    Criterion, Design, DesignSpaceError, EvaluationSettings, Forbidden, Levels, Model, Parameter, Problem, Region,
    Replicates, Settings, Space, Term,
};
use serde::Deserialize;

/// Complains about an error; a reader that has seen enough, as `head`, is none.
pub(crate) fn finish(result: Result<(), Box<dyn Error>>) -> ExitCode {
    match result {
        Err(error)
            if error.downcast_ref::<io::Error>().is_none_or(|error| error.kind() != io::ErrorKind::BrokenPipe) =>
        {
            // Where nobody listens to complaints either, the exit code has to do.
            let _ = writeln!(io::stderr(), "{error}");
            ExitCode::FAILURE
        }
        _ => ExitCode::SUCCESS,
    }
}

/// A digit, a comma and a digit in what stands after the equals sign.
fn has_decimal_comma(line: &str) -> bool {
    let value = line.split('#').next().unwrap_or_default().split('=').nth(1).unwrap_or_default().trim_start();
    // Lists in a list are exponents, which need no space after a comma.
    if value.starts_with("[[") {
        return false;
    }
    value.as_bytes().windows(3).any(|three| three[0].is_ascii_digit() && three[1] == b',' && three[2].is_ascii_digit())
}

/// What a value between two levels lies between; nothing on a level and where any value is one.
fn off_levels(parameter: &Parameter, value: f64) -> Result<Option<String>, doe::Error> {
    const ROUNDING: f64 = 1e-9;
    let Levels::Count(count) = parameter.levels() else { return Ok(None) };
    let index = parameter.nearest_level(value)?;
    let nearest = parameter.level(index)?;
    if (parameter.coded(value) - parameter.coded(nearest)).abs() <= ROUNDING {
        return Ok(None);
    }
    let other = parameter.level(if value > nearest { (index + 1).min(count - 1) } else { index.saturating_sub(1) })?;
    // Twelve digits: 49.01 and not 49.010000000000005, and still the level when it is typed in.
    let plain = |level: f64| format!("{level:.11e}").parse().unwrap_or(level);
    let (below, above) = (plain(nearest.min(other)), plain(nearest.max(other)));
    let (name, unit) = (parameter.name(), parameter.unit());
    Ok(Some(format!("`{name}` is {value:?}, which is no level: the nearest are {below:?} and {above:?} {unit}")))
}

/// The file as it stands; a key that is not here is an error.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ProblemFile {
    runs: Whole,
    model: ModelName,
    criterion: Criterion,
    replicates: Option<Whole>,
    starts: Option<Whole>,
    seconds: Option<f64>,
    judged_levels: Option<JudgedLevels>,
    seed: Option<Whole>,
    pub(crate) order_seed: Option<Whole>,
    parameters: Vec<Parameter>,
    #[serde(default)]
    forbidden: Vec<BTreeMap<String, Vec<f64>>>,
    #[serde(default)]
    fixed: Vec<BTreeMap<String, f64>>,
}

/// Levels of the grid that predictions are asked for on: the same of every parameter, or of each.
#[derive(Deserialize)]
#[serde(untagged, expecting = "expected a whole number of levels, or a list of them, one for each parameter")]
enum JudgedLevels {
    Same(Whole),
    Each(Vec<Whole>),
}

/// More runs need `seconds`: a start takes minutes to hours, and there are 200.
const MOST_RUNS_UNLIMITED: u64 = 2000;

/// A whole number that is not negative. Its errors say so, and not of which type of a program it is.
#[derive(Clone, Copy)]
pub(crate) struct Whole(pub(crate) u64);

impl Whole {
    fn count(self) -> usize {
        usize::try_from(self.0).unwrap_or(usize::MAX)
    }
}

impl<'de> Deserialize<'de> for Whole {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Expected;
        impl serde::de::Visitor<'_> for Expected {
            type Value = Whole;

            fn expecting(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                formatter.write_str("a whole number from 0 up")
            }

            fn visit_i64<E: serde::de::Error>(self, value: i64) -> Result<Whole, E> {
                u64::try_from(value)
                    .map(Whole)
                    .map_err(|_| E::invalid_value(serde::de::Unexpected::Signed(value), &self))
            }

            fn visit_u64<E: serde::de::Error>(self, value: u64) -> Result<Whole, E> {
                Ok(Whole(value))
            }
        }
        deserializer.deserialize_any(Expected)
    }
}

/// The first parameter that is wrong by itself: the line where its table begins, its number from 1, and the fault. An error of many
/// tables under one name is otherwise said to be at the first of them.
fn fault_of_parameter(text: &str) -> Option<String> {
    #[derive(Deserialize)]
    struct Parameters {
        parameters: Vec<toml::Spanned<toml::Table>>,
    }
    let parameters = toml::from_str::<Parameters>(text).ok()?.parameters;
    parameters.into_iter().enumerate().find_map(|(index, table)| {
        let line = text.get(..table.span().start)?.matches('\n').count() + 1;
        let error = Parameter::deserialize(table.into_inner()).err()?;
        Some(format!("line {line}, parameter {}: {}", index + 1, in_plain_words(error.message())))
    })
}

/// A message without the types of a program.
fn in_plain_words(message: &str) -> String {
    message.replace("expected f64", "expected a number").replace("floating point `", "number `")
}

#[derive(Deserialize)]
#[serde(untagged, expecting = "expected a name, as \"quadratic\", or a list of exponents")]
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
            match fault_of_parameter(&text) {
                Some(fault) if line.trim_start().starts_with("[[parameters]]") => format!("{path}: {fault}").into(),
                _ => format!("{path}: {}{hint}", in_plain_words(&error.to_string())).into(),
            }
        })
    }

    pub(crate) fn region(&self) -> Result<Region, doe::Error> {
        Ok(Region::new(self.parameters.clone())?)
    }

    pub(crate) fn model(&self) -> Result<Model, Box<dyn Error>> {
        let k = self.parameters.len();
        Ok(match &self.model {
            ModelName::Named(name) => Model::named(name, k)?,
            ModelName::Listed(exponents) => {
                let terms: Vec<Term> = exponents.iter().map(|term| Term::new(term.clone())).collect();
                Model::new(k, terms.clone()).map_err(|error| self.in_own_names(&terms, error))?
            }
        })
    }

    fn names(&self) -> Vec<&str> {
        self.parameters.iter().map(Parameter::name).collect()
    }

    /// An error about a term, by the names of the parameters.
    fn in_own_names(&self, terms: &[Term], error: DesignSpaceError) -> Box<dyn Error> {
        let name = |index: usize| terms.get(index).map(|term| term.name(&self.names())).unwrap_or_default();
        match error {
            DesignSpaceError::DuplicateTerm { first, second, .. } => {
                let (a, b) = (first + 1, second + 1);
                format!("model: terms {a} and {b} are both `{}`, expected distinct terms", name(first)).into()
            }
            DesignSpaceError::ExponentTooLarge { term, exponent, largest, .. } => {
                DesignSpaceError::ExponentTooLarge { term, name: name(term), exponent, largest }.into()
            }
            other => other.into(),
        }
    }

    /// The forbidden boxes, each by itself and coded.
    fn boxes<'a>(&'a self, region: &Region) -> Result<Vec<Forbidden>, Box<dyn Error>> {
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
            Forbidden::in_region(region, &ranges).map_err(|error| format!("forbidden {}: {error}", index + 1))
        });
        Ok(forbidden.collect::<Result<_, String>>()?)
    }

    pub(crate) fn space(&self) -> Result<Space, Box<dyn Error>> {
        let region = self.region()?;
        Ok(Space::of_region(&region)?.forbid(self.boxes(&region)?)?)
    }

    /// The grid that predictions are asked for on, less what is forbidden; none where that is the space.
    fn judged(&self) -> Result<Option<Space>, Box<dyn Error>> {
        let k = self.parameters.len();
        let levels: Vec<u64> = match &self.judged_levels {
            None => return Ok(None),
            Some(JudgedLevels::Same(levels)) => vec![levels.0; k],
            Some(JudgedLevels::Each(levels)) => levels.iter().map(|levels| levels.0).collect(),
        };
        if levels.len() != k {
            let found = levels.len();
            let noun = if found == 1 { "number" } else { "numbers" };
            return Err(format!(
                "judged_levels: {found} {noun}, expected one for each of the {k} parameters, or one for all"
            )
            .into());
        }
        let most = Problem::MOST_JUDGED as u64;
        let count = |levels: u64| {
            let fits = u32::try_from(levels).ok().filter(|_| (2..=most).contains(&levels));
            fits.ok_or_else(|| format!("judged_levels: {levels}, expected 2 to {most}"))
        };
        let counts = levels.into_iter().map(count).collect::<Result<Vec<u32>, String>>()?;
        // A box between the levels that predictions are asked for on forbids none of them.
        let mut grid = Space::grid(&counts)?;
        for forbidden in self.boxes(&self.region()?)? {
            match grid.clone().forbid(vec![forbidden]) {
                Err(doe::Error::ForbidsNoPoint { .. }) => (),
                less => grid = less?,
            }
        }
        Ok(Some(grid))
    }

    /// Why a run within the bounds is not in the space; nothing if it is.
    fn fault_of(&self, region: &Region, run: &[f64]) -> Result<Option<String>, Box<dyn Error>> {
        let coded = region.coded(run)?;
        if self.space()?.contains(&coded) {
            return Ok(None);
        }
        let whole = Space::of_region(region)?;
        if whole.contains(&coded) {
            for (index, one) in self.boxes(region)?.into_iter().enumerate() {
                if !whole.clone().forbid(vec![one])?.contains(&coded) {
                    return Ok(Some(format!("{run:?} lies in forbidden box {}", index + 1)));
                }
            }
        }
        let off = self.parameters.iter().zip(run).map(|(parameter, &value)| off_levels(parameter, value));
        let off: Vec<String> = off.collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect();
        Ok(Some(off.join("; ")))
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
            if let Some(fault) = self.fault_of(&region, &run)? {
                return Err(at(fault).into());
            }
            runs.push(run);
        }
        Ok(if runs.is_empty() { None } else { Some(Design::from_natural(&region, &runs)?) })
    }

    pub(crate) fn problem(&self) -> Result<Problem, Box<dyn Error>> {
        let model = self.model()?;
        let terms = model.term_names(&self.names());
        let mut problem = Problem::new(model, self.space()?, self.runs.count(), self.criterion)
            .map_err(|error| error.with_term_names(&terms))?;
        if let Some(fixed) = self.fixed()? {
            problem = problem.with_fixed_runs(fixed)?;
        }
        if let Some(judged) = self.judged()? {
            problem = problem.judged_over(judged)?;
        }
        Ok(match self.replicates {
            Some(planned) => problem.with_replicates(Replicates::Planned(planned.count())).map_err(|error| match error {
                doe::Error::TooFewRuns { n_runs, n_terms } => {
                    let (runs, planned) = (self.runs.0, planned.0);
                    let noun = if planned == 1 { "replicate" } else { "replicates" };
                    format!(
                        "{runs} runs less {planned} planned {noun} leave {n_runs} distinct runs, {n_terms} are needed"
                    )
                }
                other => other.to_string(),
            })?,
            None => problem,
        })
    }

    pub(crate) fn settings(&self) -> Result<Settings, Box<dyn Error>> {
        let mut settings = Settings::default();
        if self.seconds.is_none() && self.runs.0 > MOST_RUNS_UNLIMITED {
            let runs = self.runs.0;
            return Err(format!(
                "runs = {runs}: the search may take hours, expected at most {MOST_RUNS_UNLIMITED} without `seconds`, which limits it"
            )
            .into());
        }
        settings.seed = self.seed.map_or(settings.seed, |seed| seed.0);
        settings.starts = self.starts.map_or(settings.starts, |starts| starts.0);
        if let Some(seconds) = self.seconds {
            let limit = Duration::try_from_secs_f64(seconds).ok().filter(|limit| !limit.is_zero());
            let refused = || format!("seconds = {seconds:?}: expected a positive finite number below 1e19");
            settings.time_limit = Some(limit.ok_or_else(refused)?);
        }
        Ok(settings)
    }

    pub(crate) fn evaluation_settings(&self) -> EvaluationSettings {
        let mut settings = EvaluationSettings::default();
        settings.factors = self.parameters.iter().map(|parameter| parameter.name().to_owned()).collect();
        settings
    }
}
