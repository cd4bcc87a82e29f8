//! A batch chosen, and what has to be simulated for it.

use anyhow::{Result, bail, ensure};
use design_space::Cell;
use infuse::pooled::{Ask, Reason};

use super::buildable::some_are_refused;
use super::campaign::{Batch, Campaign, Origin, tells_designs_apart};
use crate::campaign::{Campaign as _, HandedOut, Stage, Wish, busy, failed_in_words, simulate_missing};
use crate::journal::{Event, Measured, Writer, now};
use crate::simulator::identity;

/// Brings the campaign to the point where experiments are waited for, or to its end.
pub(super) fn hand_out(campaign: &mut Campaign, writer: &mut Writer, wish: Wish) -> Result<HandedOut> {
    let mut done = HandedOut::default();
    let mut is_new = false;
    loop {
        simulate(campaign, writer, wish.anyway, &mut done)?;
        if is_new {
            return Ok(done);
        }
        match campaign.stage()? {
            Stage::Ready => {}
            Stage::Pending if wish.more => {
                ensure!(!campaign.is_full(), "--more: all batches of [loop] were handed out (`batches` may be raised)");
            }
            Stage::Ended { may_go_on: true, .. } if wish.anyway => {}
            _ => return Ok(done),
        }
        let (batch, simulations) = choose(campaign, writer)?;
        is_new = !batch.cells.is_empty();
        ensure!(is_new || !simulations.is_empty(), "the loop asked for nothing");
        plan(campaign, writer, batch, simulations)?;
    }
}

/// Hands these cells out as a batch of their own.
pub(super) fn plan(campaign: &mut Campaign, writer: &mut Writer, planned: Batch, simulations: Vec<Cell>) -> Result<()> {
    let batch = campaign.batches.len() + 1;
    let Batch { cells: experiments, purpose, reasons } = planned;
    let settings = Some(campaign.settings_as_said());
    let planned = Event::Planned { batch, at: now(), experiments, simulations, purpose, reasons, settings };
    campaign.write_down(writer, vec![planned])
}

/// The next batch, and what to simulate.
fn choose(campaign: &mut Campaign, writer: &mut Writer) -> Result<(Batch, Vec<Cell>)> {
    campaign.check_the_recommended(writer)?;
    for _ in 0..MOST_ROUNDS {
        let (batch, simulations) = choose_of_all(campaign)?;
        let checks = campaign.check(&batch.cells)?;
        let is_refused = some_are_refused(&checks);
        if !checks.is_empty() {
            campaign.write_down(writer, checks)?;
        }
        if !is_refused {
            // What was refused meanwhile may have led to another.
            campaign.check_the_recommended(writer)?;
            return Ok((batch, simulations));
        }
    }
    bail!(
        "{MOST_ROUNDS} times a batch was chosen of which [can_be_built] refused a design; ask again to go on, or confine the settings with [[linear_constraint]]"
    )
}

/// So often a batch is chosen anew because some of it cannot be built.
const MOST_ROUNDS: usize = 200;

fn choose_of_all(campaign: &Campaign) -> Result<(Batch, Vec<Cell>)> {
    let choosing = busy(format!("choosing batch {}", campaign.batches.len() + 1));
    let asked = campaign.with_loop(|now, simulate| {
        let mut next = now.clone();
        Ok((next.ask_more(simulate)?, next))
    });
    choosing.finish_and_clear();
    let (Ask::Run { trials, simulations }, next) = asked? else { bail!("the loop stopped without being asked to") };
    let known = campaign.n_handed_out();
    let new = trials.into_iter().filter(|trial| trial.id.number() > known);
    let (cells, reasons): (Vec<Cell>, Vec<Option<Reason>>) =
        new.map(|trial| (trial.cell, next.reason(trial.id))).unzip();
    Ok((Batch { cells, purpose: None, reasons: reasons.into_iter().flatten().collect() }, simulations))
}

/// Runs what is still to be simulated.
fn simulate(campaign: &mut Campaign, writer: &mut Writer, anyway: bool, done: &mut HandedOut) -> Result<()> {
    let missing = campaign.missing_simulations()?;
    if missing.is_empty() {
        return Ok(());
    }
    let (folder, problem, grid) = (campaign.folder.clone(), campaign.problem.clone(), campaign.grid.clone());
    // Who went on without it once was asked, and is not asked again.
    let by = identity(&problem.simulator);
    let went_on = campaign.memory.values().any(|known| known.by == by);
    let submitted = campaign.submitted.clone();
    let simulated = simulate_missing(&folder, &problem, &grid, &missing, &submitted, |event| {
        campaign.write_simulation(writer, event)
    })?;
    done.n_simulated += simulated.n_done;
    if simulated.failed.len() == simulated.n_done && !anyway && !went_on && campaign.simulated()?.is_empty() {
        let of = |cell: &Cell| campaign.memory.get(cell).map(|known| known.result.clone());
        let reason = match missing.first().and_then(|(cell, _)| of(cell)) {
            Some(Measured::Failed(reason)) => reason,
            _ => "nobody knows why".to_owned(),
        };
        // A simulator that was repaired is to be tried again.
        campaign.write_down(writer, vec![Event::Discarded { at: now() }])?;
        bail!(
            "every one of {} simulations failed; the first one: {reason}\nRepair the simulator and ask again, or go on \
             without it: --anyway. Nothing is lost",
            simulated.n_done
        );
    }
    done.notices.extend(failed_in_words(&problem, simulated.n_done, &simulated.failed));
    let values = campaign.simulated()?;
    if values.len() > 1 && !tells_designs_apart(&values) {
        done.notices.push(format!(
            "all {} simulations gave the same value: they tell nothing. Does the simulation take its settings?",
            values.len()
        ));
    }
    Ok(())
}

impl Campaign {
    /// Whether every batch of the limit was handed out.
    pub(super) fn is_full(&self) -> bool {
        self.batches.len() - self.n_confirming() >= self.settings.max_batches
    }

    /// How many batches the limit leaves.
    pub(super) fn n_left(&self) -> usize {
        self.settings.max_batches.saturating_sub(self.batches.len() - self.n_confirming())
    }

    /// How an experiment is called where its settings are not said beside it.
    pub(super) fn full_name_of(&self, origin: Origin) -> String {
        let name = self.name_of(origin);
        let Origin::Imported(index) = origin else { return name };
        let at = self.imported.get(index).map(|imported| self.problem.describe(&imported.point));
        at.map_or(name.clone(), |at| format!("{name} at {at}"))
    }

    /// How an experiment is called.
    pub(super) fn name_of(&self, origin: Origin) -> String {
        match origin {
            Origin::Own(id) => format!("experiment {id}"),
            Origin::Imported(index) => match self.imported.get(index) {
                Some(imported) => format!("an experiment of `{}`", imported.source),
                None => "an imported experiment".to_owned(),
            },
        }
    }
}
