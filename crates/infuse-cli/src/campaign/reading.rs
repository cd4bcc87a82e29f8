//! What was told about one experiment, repeats and all.

use std::collections::BTreeMap;

use infuse::Outcome;

use crate::journal::{Constrained, Measured};
use crate::problem::Response;

#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Reading {
    /// Of the run that was asked for; nothing while only others have been told.
    pub(crate) first: Option<Measured>,
    /// Of further runs at the same settings.
    pub(crate) again: BTreeMap<usize, Measured>,
    pub(crate) actual: BTreeMap<String, f64>,
    /// Of the responses that have to stay within bounds, run by run, the one that was asked for being 0.
    pub(crate) constrained: BTreeMap<usize, Constrained>,
    pub(crate) note: String,
}

impl Reading {
    /// Of the run that was asked for, 0, or of a further one.
    pub(crate) fn result(&self, repeat: usize) -> Option<&Measured> {
        if repeat == 0 { self.first.as_ref() } else { self.again.get(&repeat) }
    }

    /// The mean of a constrained response over all runs that measured it.
    pub(crate) fn mean_of(&self, name: &str) -> Option<f64> {
        let values = || self.constrained.values().filter_map(|of_a_run| of_a_run.get(name));
        let n = values().count();
        (n > 0).then(|| values().sum::<f64>() / n as f64)
    }

    /// All values, as measured.
    pub(crate) fn values(&self) -> impl Iterator<Item = f64> + '_ {
        self.first.iter().chain(self.again.values()).filter_map(|result| match result {
            Measured::Value(value) => Some(*value),
            Measured::Failed(_) => None,
        })
    }

    /// What the loop is told: the mean cost of all values, or the failure if there is none. Nothing while the run that was asked
    /// for has not been told.
    pub(crate) fn outcome(&self, response: &Response) -> Option<Outcome> {
        let first = self.first.as_ref()?;
        let costs = self.values().map(|value| response.cost(value));
        let (sum, n) = costs.fold((0.0, 0), |(sum, n), cost| (sum + cost, n + 1));
        Some(match first {
            _ if n > 0 => Outcome::Value(sum / f64::from(n)),
            Measured::Failed(reason) => Outcome::Failed { reason: reason.clone() },
            // No value among the values cannot be.
            Measured::Value(value) => Outcome::Value(response.cost(*value)),
        })
    }
}
