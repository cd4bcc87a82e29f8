//! What could be promised after each batch: a campaign says it only of its last one, so it is followed again.

use std::collections::HashMap;

use anyhow::Result;
use design_space::Cell;
use infuse::{
    Outcome,
    global::{self, ObservedErrors},
};

use crate::dissertation::campaign::Campaign;

/// After each closed batch, first to last; nothing where no bound could be given.
pub(super) fn observed_errors(campaign: &Campaign) -> Result<Vec<Option<ObservedErrors>>> {
    let done = &campaign.now;
    let mut replay = global::Loop::new(done.region(), done.settings().clone())?;
    let mut earlier = done.earlier().iter().peekable();
    let mut observed = Vec::new();
    for report in done.reports() {
        while let Some(one) = earlier.next_if(|one| one.since <= report.number) {
            replay.add_earlier(&one.point, one.cost, one.source.clone())?;
        }
        let plan = global::Plan {
            experiments: report.trials.iter().map(|record| record.trial.cell).collect(),
            simulations: report.simulations.iter().map(|record| record.cell).collect(),
        };
        let known: HashMap<Cell, &Outcome> =
            report.simulations.iter().map(|record| (record.cell, &record.outcome)).collect();
        let mut look_up = |cell: Cell, _: &[f64]| match known.get(&cell) {
            Some(Outcome::Value(cost)) => Ok(*cost),
            Some(Outcome::Failed { reason }) => Err(reason.clone()),
            None => Err("it was never simulated".to_owned()),
        };
        replay.open(&plan, &mut look_up)?;
        for record in &report.trials {
            if let Some(outcome) = &record.outcome {
                replay.tell_at(record.trial.id, record.settings(), outcome.clone())?;
            }
        }
        observed.push(replay.observed_certificate()?);
    }
    Ok(observed)
}
