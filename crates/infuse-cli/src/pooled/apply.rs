//! How each line of a journal changes a campaign.

use std::collections::BTreeMap;

use anyhow::{Context as _, Result, bail, ensure};
use design_space::Cell;
use infuse::TrialId;
use infuse::pooled::Trial;

use super::buildable::some_are_refused;
use super::campaign::{Batch, Campaign, Checked, Remembered, Withdrawn};
use super::drift;
use super::findings::promised;
use crate::campaign::{Imported, checked};
use crate::journal::{Assessed, Event, JOURNAL, OfSimulation, Submitted, Writer};
use crate::problem::PROBLEM;
use crate::simulator::identity;

impl Campaign {
    /// An event of the journal; an error names its line.
    pub(super) fn apply_line(&mut self, line: usize, event: Event) -> Result<()> {
        self.apply(event).with_context(|| format!("{JOURNAL}, line {line}, does not follow from what comes before it"))
    }

    /// Writes these events down, all or none, and lets them happen; what a batch taught is written down with its last result.
    pub(super) fn write_down(&mut self, writer: &mut Writer, mut events: Vec<Event>) -> Result<()> {
        // Only what can happen is written down.
        let mut next = self.clone();
        for event in &events {
            next.apply(event.clone())?;
        }
        let n_before = self.n_closed_in_order();
        while let Some((recommended, assessed)) = next.taught(n_before)? {
            // What nobody can build is not recommended.
            let checks = next.check(&[recommended])?;
            let is_refused = some_are_refused(&checks);
            for event in checks {
                next.apply(event.clone())?;
                events.push(event);
            }
            if !is_refused {
                next.apply(Event::Assessed(assessed.clone()))?;
                events.push(Event::Assessed(assessed));
            }
        }
        if !events.is_empty() {
            writer.add(&events)?;
        }
        *self = next;
        Ok(())
    }

    /// A single event after which nothing is asked of the campaign before the next one.
    pub(super) fn write_simulation(&mut self, writer: &mut Writer, event: Event) -> Result<()> {
        writer.add(std::slice::from_ref(&event))?;
        self.apply(event)
    }

    /// So many batches from the first on are complete; a later one may be, too, that was asked for while others were waited for.
    fn n_closed_in_order(&self) -> usize {
        let first_open = self.experiments.open_batches().into_iter().min();
        first_open.map_or(self.batches.len(), |batch| batch - 1)
    }

    /// What the last batch taught of those that are complete in order, with the design that is recommended now, if it has been completed
    /// since there were so many, or is the last of all, and the journal does not have it as it stands.
    fn taught(&mut self, n_before: usize) -> Result<Option<(Cell, Assessed)>> {
        let batch = self.n_closed_in_order();
        let is_due = batch > n_before || batch == self.batches.len();
        if batch == 0 || !is_due || self.history.contains_key(&batch) {
            return Ok(None);
        }
        let assessment = match self.assessment() {
            Ok(assessment) => assessment,
            // The results are worth more than what can be said about them.
            Err(error) => {
                self.notices.push(format!("the results are taken, and cannot be assessed: {error:#}"));
                None
            }
        };
        let drifting =
            assessment.as_ref().map(|found| drift::sure(self, found)).and_then(Result::ok).unwrap_or_default();
        Ok(assessment.map(|found| {
            let bound = promised(self, &found);
            let assessed = Assessed {
                batch,
                bound,
                alone: bound.map(|_| found.certificate.quantile),
                recommended: found.recommended.point,
                expected: self.problem.response.of_cost(found.recommended.mean),
                deviation: found.recommended.deviation,
                probability: found.certificate.probability,
                left: found.left,
                noise: found.noise,
                scale: self.problem.response.scale,
                settings: self.settings_as_said(),
                by: Some(identity(&self.problem.simulator)),
                simulation: found.simulation.map(|worth| OfSimulation {
                    factor: worth.factor,
                    ignored: worth.ignored,
                    displacement: found.displacement.clone(),
                    deviations: found
                        .registration
                        .as_ref()
                        .filter(|told| told.is_sure())
                        .map(|told| told.deviations.clone()),
                }),
                drifting,
                check: String::new(),
            };
            (found.recommended.cell, assessed)
        }))
    }

    fn apply(&mut self, event: Event) -> Result<()> {
        // What is assessed, and where a sheet is, changes no answer that was given before the next plan.
        if !matches!(event, Event::Assessed(_) | Event::Sheet { .. }) {
            self.forget_the_loop();
        }
        match event {
            Event::Planned { batch, experiments, simulations, purpose, reasons, .. } => {
                self.plan(batch, &simulations, Batch { cells: experiments, purpose, reasons })?;
            }
            Event::Simulated { cell, result, constrained, by, .. } => {
                // The scale may be another than when it was simulated.
                let (result, constrained) = checked(&self.problem, result, constrained);
                self.memory.insert(cell, Remembered { by, result, constrained });
            }
            Event::Checked { cell, can_be_built, by, .. } => {
                self.grid.point(cell)?;
                self.checked.insert(cell, Checked { by, can_be_built });
            }
            Event::Submitted(submitted) => self.submitted.push(submitted),
            Event::Discarded { .. } => {
                self.memory.clear();
                // Results of runs that were to be thrown away are not read again.
                self.submitted.retain(Submitted::is_of_experiments);
            }
            Event::Sheet { batch, path, .. } => self.experiments.note_sheet(batch, path),
            Event::Told(told) => {
                self.check_units(&told.units)?;
                self.experiments.tell(told)?;
                // What is known now is to be said anew; what was known before stands.
                self.history.remove(&self.batches.len());
            }
            Event::Imported { point, result, constrained, units, source, note, .. } => {
                self.check_units(&units)?;
                self.imported.push(Imported { point, result, constrained, source, note });
            }
            Event::Withdrawn { source, .. } => {
                let before = self.imported.len();
                self.imported.retain(|imported| imported.source != source);
                let n = before - self.imported.len();
                ensure!(n > 0, "nothing that is in use was imported from `{source}`");
                let after = self.history.keys().next_back().copied().unwrap_or(0);
                self.withdrawn.push(Withdrawn { source, n, after });
            }
            Event::Assessed(assessed) => {
                ensure!(
                    (1..=self.batches.len()).contains(&assessed.batch),
                    "batch {} is assessed, which was never planned",
                    assessed.batch
                );
                // What is said anew was said without these.
                let before = self.withdrawn.iter_mut().filter(|withdrawn| withdrawn.after >= assessed.batch);
                before.for_each(|withdrawn| withdrawn.after = assessed.batch - 1);
                // What was said on another scale cannot be compared.
                if assessed.scale == self.problem.response.scale {
                    self.on_another_scale = None;
                    self.history.insert(assessed.batch, assessed);
                } else {
                    self.on_another_scale = Some(assessed);
                }
            }
            Event::Undone { .. } => bail!("what was taken back is left out before"),
            Event::Campaign { .. } => bail!("expected the event `campaign` on the first line only"),
            Event::Opened { .. } | Event::Learned(_) => bail!("the event belongs to `method` = \"dissertation\""),
        }
        Ok(())
    }

    /// What was measured in one unit is not read in another; a constraint that is no more has none.
    fn check_units(&self, units: &BTreeMap<String, String>) -> Result<()> {
        for held in &self.problem.constraints {
            if let Some(then) = units.get(held.name()).filter(|then| **then != held.unit) {
                bail!(
                    "{PROBLEM} was changed after `{}` was measured: its `unit` was {then:?} and is {:?}; change it back, or call \
                     the constraint otherwise",
                    held.name(),
                    held.unit
                );
            }
        }
        Ok(())
    }

    fn plan(&mut self, batch: usize, simulations: &[Cell], planned: Batch) -> Result<()> {
        let expected = self.batches.len() + 1;
        ensure!(batch == expected, "batch {batch} is planned, expected batch {expected}");
        let (n, n_reasons) = (planned.cells.len(), planned.reasons.len());
        ensure!(n_reasons == 0 || n_reasons == n, "batch {batch} has {n} experiments and {n_reasons} reasons");
        for &cell in simulations {
            self.grid.point(cell)?;
        }
        self.planned.extend(simulations);
        if planned.cells.is_empty() {
            return Ok(());
        }
        let first = self.n_handed_out() + 1;
        let trial = |(index, &cell): (usize, &Cell)| {
            let id = TrialId::new(first + index as u64);
            Ok(Trial { id, batch, cell, point: self.grid.point(cell)? })
        };
        let trials = planned.cells.iter().enumerate().map(trial).collect::<Result<Vec<_>>>()?;
        self.experiments.hand_out(trials);
        self.batches.push(planned);
        Ok(())
    }
}
