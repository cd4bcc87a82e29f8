//! A campaign's problem: what `campaign.toml` says, checked.

mod constraints;
mod costs;
pub(crate) mod file;
mod keys;
mod levels;
mod queue;
mod read;
mod reserved;
mod response;
mod setting;
mod settings;

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Duration;

use design_space::Region;
use infuse::Role;
use infuse::pooled::{LinearConstraint, StopBy};
use serde_json::{Value, json};

pub(crate) use constraints::{Held, linear_in_words};
pub(crate) use costs::Costs;
use file::LoopEntry;
pub(crate) use file::{Goal, Input, Method, PROBLEM, Scale, SheetFormat};
pub(crate) use keys::by_key;
pub(crate) use queue::Queue;
pub(crate) use response::{Response, heading};
pub(crate) use setting::{parse_setting, said, shown, step, written};

use crate::number::with_unit;

/// What a campaign is about.
#[derive(Debug, Clone)]
pub(crate) struct Problem {
    pub(crate) title: String,
    pub(crate) region: Region,
    pub(crate) roles: Vec<Option<Role>>,
    pub(crate) response: Response,
    pub(crate) simulator: Simulator,
    pub(crate) experiment: Option<Experiment>,
    /// Responses that have to stay within bounds.
    pub(crate) constraints: Vec<Held>,
    /// Settings that go together.
    pub(crate) linear_constraints: Vec<LinearConstraint>,
    /// Says whether a design can be built.
    pub(crate) can_be_built: Option<Program>,
    /// Which parameters are hard to change, and what runs cost.
    pub(crate) costs: Option<Costs>,
    pub(crate) seed: u64,
    pub(crate) sheets: SheetFormat,
    /// As it stands in the file.
    pub(crate) rule: LoopEntry,
    /// The smallest improvement that another batch is worth, in the unit of the response.
    pub(crate) worth: Option<f64>,
    /// What has to be no more than that for the campaign to end.
    pub(crate) stop_by: Option<StopBy>,
    /// Whether it is known to have no narrow well.
    pub(crate) smooth: Option<bool>,
}

/// Where simulated values come from.
#[derive(Debug, Clone)]
pub(crate) enum Simulator {
    /// There is none: experiments alone tell.
    Nothing,
    Table(PathBuf),
    Program {
        program: Program,
        /// How many run side by side on this machine.
        jobs: usize,
        /// Where they run elsewhere.
        queue: Option<Queue>,
    },
}

impl Simulator {
    /// Whether there is one.
    pub(crate) fn is_there(&self) -> bool {
        !matches!(self, Self::Nothing)
    }

    /// The program and its queue, if it runs elsewhere.
    pub(crate) fn queue(&self) -> Option<(&Program, &Queue)> {
        match self {
            Self::Program { program, queue: Some(queue), .. } => Some((program, queue)),
            _ => None,
        }
    }
}

/// How an experiment is made, if not by people.
#[derive(Debug, Clone)]
pub(crate) struct Experiment {
    pub(crate) program: Program,
    /// Where it is made elsewhere.
    pub(crate) queue: Option<Queue>,
}

/// A command to run per point.
#[derive(Debug, Clone)]
pub(crate) struct Program {
    pub(crate) command: Vec<String>,
    pub(crate) input: Input,
    pub(crate) timeout: Duration,
}

impl Problem {
    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        self.region.parameters().iter().map(design_space::Parameter::name)
    }

    /// Settings by the names of their parameters.
    pub(crate) fn named(&self, point: &[f64]) -> Value {
        let pairs = self.region.parameters().iter().zip(point);
        Value::Object(pairs.map(|(parameter, &value)| (parameter.name().to_owned(), said(parameter, value))).collect())
    }

    /// "spring 21000 N/m, damper 1450 N s/m".
    pub(crate) fn describe(&self, point: &[f64]) -> String {
        let pairs = self.region.parameters().iter().zip(point);
        let parts = pairs.map(|(parameter, &value)| {
            format!("{} {}", parameter.name(), with_unit(&shown(parameter, value), parameter.unit()))
        });
        parts.collect::<Vec<_>>().join(", ")
    }

    /// The parameters that make a plant, by their places, the dearest to change first; none where all are as easy to set.
    pub(crate) fn plant(&self) -> Vec<usize> {
        self.costs.as_ref().map_or_else(Vec::new, Costs::by_falling_cost)
    }

    /// Those numbers that belong to constraints.
    pub(crate) fn of_constraints(&self, mut others: BTreeMap<String, f64>) -> BTreeMap<String, f64> {
        others.retain(|name, value| {
            self.constraints.iter().any(|held| held.name() == name) && crate::number::fault(*value).is_none()
        });
        others
    }

    /// Whether values keep to every constraint, as far as they were measured.
    pub(crate) fn allows(&self, value_of: impl Fn(&str) -> Option<f64>) -> bool {
        let mut constraints = self.constraints.iter();
        constraints.all(|held| value_of(held.name()).is_none_or(|value| held.constraint.allows(value)))
    }

    /// The units of those constraints of which there is a value.
    pub(crate) fn units_of(&self, constrained: &BTreeMap<String, f64>) -> BTreeMap<String, String> {
        let measured = self.constraints.iter().filter(|held| constrained.contains_key(held.name()));
        measured.map(|held| (held.name().to_owned(), held.unit.clone())).collect()
    }

    /// Values by the names of constraints, in their order.
    pub(crate) fn in_order(&self, constrained: &BTreeMap<String, f64>) -> Vec<Option<f64>> {
        self.constraints.iter().map(|held| constrained.get(held.name()).copied()).collect()
    }

    /// What every journal rests on: parameters and response. Once it has begun, none of this may change.
    pub(crate) fn core(&self) -> Value {
        let parameters = self.region.parameters().iter().zip(&self.roles).map(|(parameter, role)| {
            let mut core = json!({
                "name": parameter.name(), "unit": parameter.unit(),
                "lower": parameter.lower(), "upper": parameter.upper(), "levels": parameter.levels(), "role": role,
            });
            if let Some(choices) = parameter.choices() {
                core["choices"] = json!(choices);
            }
            core
        });
        let response = &self.response;
        json!({
            "parameter": parameters.collect::<Vec<_>>(),
            "response": {
                "name": response.name, "unit": response.unit,
                "goal": match response.goal { Goal::Minimize => "minimize", Goal::Maximize => "maximize" },
            },
        })
    }
}

impl Method {
    /// The method of a journal, as its first line has it; the first journals had but one.
    pub(crate) fn of_core(core: &Value) -> Self {
        match core.get("method") {
            Some(_) => Self::Pooled,
            None => Self::Dissertation,
        }
    }

    /// As it stands in the file.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Pooled => "pooled",
            Self::Dissertation => "dissertation",
        }
    }
}
