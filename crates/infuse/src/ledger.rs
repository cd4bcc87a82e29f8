//! The experiments of a batch that is open: which still wait for an outcome, and what is known of the others.

use serde::{Deserialize, Serialize};

use crate::trial::LARGEST;
use crate::{Error, Outcome, TrialId};

/// An experiment that is handed out under a number.
pub(crate) trait Numbered {
    /// Its number.
    fn id(&self) -> TrialId;
}

/// A trial `T` with what is known about it; settings that were made otherwise than asked are an `A`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename = "TrialRecord")]
pub struct Record<T, A> {
    /// What was asked.
    pub trial: T,
    /// What was really set, if that was reported; which settings these are, the loop says.
    pub actual: Option<A>,
    /// What came of it; nothing while the trial is outstanding.
    pub outcome: Option<Outcome>,
}

impl<T, A> Record<T, A> {
    /// The cost that was measured; none while the trial is outstanding or if it failed.
    #[must_use]
    pub fn cost(&self) -> Option<f64> {
        self.outcome.as_ref().and_then(Outcome::cost)
    }

    /// Whether the trial was reported as failed.
    #[must_use]
    pub fn is_failed(&self) -> bool {
        matches!(self.outcome, Some(Outcome::Failed { .. }))
    }
}

/// The records of one batch, in the order of the numbers of its trials.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub(crate) struct Ledger<T, A> {
    records: Vec<Record<T, A>>,
}

impl<T: Numbered + Clone, A: Clone> Ledger<T, A> {
    /// Trials that have just been handed out.
    pub(crate) fn of(trials: impl IntoIterator<Item = T>) -> Self {
        let record = |trial| Record { trial, actual: None, outcome: None };
        Self { records: trials.into_iter().map(record).collect() }
    }

    /// What a closed batch holds.
    pub(crate) fn of_records(records: Vec<Record<T, A>>) -> Self {
        Self { records }
    }

    #[cfg(feature = "global")]
    pub(crate) fn records(&self) -> &[Record<T, A>] {
        &self.records
    }

    pub(crate) fn into_records(self) -> Vec<Record<T, A>> {
        self.records
    }

    /// All trials, outstanding or not.
    pub(crate) fn trials(&self) -> impl Iterator<Item = &T> {
        self.records.iter().map(|record| &record.trial)
    }

    /// The trials without an outcome.
    pub(crate) fn outstanding(&self) -> impl Iterator<Item = &T> {
        self.records.iter().filter(|record| record.outcome.is_none()).map(|record| &record.trial)
    }

    pub(crate) fn is_complete(&self) -> bool {
        self.outstanding().next().is_none()
    }

    /// Writes the outcome of one trial down, `check` judging the settings that were made. On an error nothing changes.
    pub(crate) fn record(
        &mut self,
        id: TrialId,
        actual: Option<A>,
        outcome: Outcome,
        check: impl FnOnce(&T, &A) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let first = self.records.first().map_or(0, |record| record.trial.id().number());
        let record = self.records.iter_mut().find(|record| record.trial.id() == id);
        let record = record.ok_or_else(|| not_outstanding(id, first.saturating_sub(1)))?;
        if record.outcome.is_some() {
            return Err(Error::SecondOutcome { id });
        }
        if let Some(value) = outcome.cost().filter(|cost| cost.is_nan() || cost.abs() > LARGEST) {
            return Err(Error::NonFiniteOutcome { id, value });
        }
        if let Some(actual) = &actual {
            check(&record.trial, actual)?;
        }
        record.actual = actual;
        record.outcome = Some(outcome);
        Ok(())
    }

    /// These trials with the outcomes that a file has for them, each checked as if it came in now.
    pub(crate) fn with_outcomes_of(
        mut self,
        saved: &Self,
        turn: usize,
        check: impl Fn(&T, &A) -> Result<(), Error>,
    ) -> Result<Self, Error> {
        for record in &saved.records {
            match &record.outcome {
                Some(outcome) => self.record(record.trial.id(), record.actual.clone(), outcome.clone(), &check)?,
                None if record.actual.is_some() => {
                    let expected = "nothing while the trial is outstanding";
                    return Err(Error::State { field: "actual", turn, expected });
                }
                None => {}
            }
        }
        Ok(self)
    }
}

/// The numbers of the next trials, after this many.
pub(crate) fn ids_after(n_asked: u64) -> impl Iterator<Item = TrialId> {
    (n_asked + 1..).map(TrialId::new)
}

/// Why no outcome is expected for this id, with the first `n_closed` trials in closed batches and the id not in the open one.
pub(crate) fn not_outstanding(id: TrialId, n_closed: u64) -> Error {
    if (1..=n_closed).contains(&id.number()) { Error::SecondOutcome { id } } else { Error::UnknownTrial { id } }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, Clone, PartialEq)]
    struct Reading(TrialId);

    impl Numbered for Reading {
        fn id(&self) -> TrialId {
            self.0
        }
    }

    fn value(value: f64) -> Outcome {
        Outcome::Value(value)
    }

    /// Trials 4 to 6, after a closed batch of three.
    fn ledger() -> Ledger<Reading, f64> {
        Ledger::of(ids_after(3).take(3).map(Reading))
    }

    fn small(_: &Reading, actual: &f64) -> Result<(), Error> {
        if *actual < 1.0 { Ok(()) } else { Err(Error::EmptyRegion) }
    }

    #[test]
    fn outcomes_come_in_any_order_and_each_once() {
        let mut ledger = ledger();
        for number in [6, 4, 5] {
            assert!(!ledger.is_complete());
            ledger.record(TrialId::new(number), None, value(0.5), small).expect("an outstanding trial");
            let again = ledger.record(TrialId::new(number), None, value(0.7), small);
            assert_eq!(again, Err(Error::SecondOutcome { id: TrialId::new(number) }));
        }
        assert!(ledger.is_complete() && ledger.into_records().iter().all(|record| record.cost() == Some(0.5)));
    }

    #[test]
    fn what_is_refused_changes_nothing() {
        let (mut ledger, before) = (ledger(), ledger());
        let mut refused = |number, actual, outcome| {
            let error = ledger.record(TrialId::new(number), actual, outcome, small).expect_err("it is refused");
            assert_eq!(ledger, before);
            error
        };
        assert!(matches!(refused(3, None, value(1.0)), Error::SecondOutcome { .. }), "of a closed batch");
        assert!(matches!(refused(7, None, value(1.0)), Error::UnknownTrial { .. }));
        assert!(matches!(refused(5, None, value(f64::NAN)), Error::NonFiniteOutcome { .. }));
        assert!(matches!(refused(5, Some(2.0), value(1.0)), Error::EmptyRegion), "the check of the loop");
    }
}
