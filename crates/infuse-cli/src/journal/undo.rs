//! What was taken back: a journal is only ever added to, so a line says that the last thing before it does not count.

use std::collections::BTreeSet;

use anyhow::{Context as _, Result, ensure};

use super::deed::Deed;
use super::event::{BY_ITSELF, Event, Purpose, Submitted, Told};

/// The lines of a journal as they count.
#[derive(Debug, Default)]
pub(crate) struct Standing {
    /// With the numbers of their lines.
    pub(crate) events: Vec<(usize, Event)>,
    /// The numbers of the lines that were taken back.
    pub(crate) taken_back: BTreeSet<usize>,
    /// What may be taken back, last thing last: each with the place among `events` at which it begins.
    deeds: Vec<(Deed, usize)>,
}

/// What would be taken back.
#[derive(Debug)]
pub(crate) struct Last {
    pub(crate) deed: Deed,
    pub(crate) events: Vec<(usize, Event)>,
}

impl Standing {
    /// # Errors
    ///
    /// A line that takes back what was not the last thing done, by its number.
    pub(crate) fn of(events: Vec<(usize, Event)>) -> Result<Self> {
        let mut standing = Self::default();
        for (line, event) in events {
            standing.add(line, event).with_context(|| format!("line {line}"))?;
        }
        Ok(standing)
    }

    fn add(&mut self, line: usize, event: Event) -> Result<()> {
        if let Event::Undone { deed, lines, .. } = event {
            let last = self.last();
            let found = last.as_ref().map(|last| (last.deed, last.events.len()));
            ensure!(
                found == Some((deed, lines)),
                "it takes back {}, which is not the last thing that was done before it",
                deed.in_words()
            );
            let (_, start) = self.deeds.pop().context("a deed")?;
            let after = self.events.split_off(start);
            let made_anew: BTreeSet<u64> = after.iter().filter_map(|(_, event)| made_by_itself(event)).collect();
            for (line, event) in after {
                if is_kept(&event) {
                    self.events.push((line, event));
                } else {
                    self.taken_back.insert(line);
                }
            }
            self.forget_results(&made_anew);
            return Ok(());
        }
        match self.begun_by(&event) {
            Some(deed) => self.deeds.push((deed, self.events.len())),
            None if matches!(event, Event::Campaign { .. }) => self.deeds.clear(),
            None => {}
        }
        self.events.push((line, event));
        Ok(())
    }

    /// The deed that this event is the first line of.
    fn begun_by(&self, event: &Event) -> Option<Deed> {
        let is_first = event.group().0 == 1;
        match event {
            Event::Told(_) if is_first => Some(Deed::Tell),
            Event::Imported { .. } if is_first => Some(Deed::Import),
            Event::Withdrawn { .. } => Some(Deed::Withdraw),
            Event::Planned { purpose: Some(Purpose::Confirm), .. } => Some(Deed::Confirm),
            // What was planned in several steps is one batch.
            Event::Planned { batch, .. } => (self.batch_being_asked_for() != Some(*batch)).then_some(Deed::Ask),
            _ => None,
        }
    }

    fn batch_being_asked_for(&self) -> Option<usize> {
        let &(Deed::Ask, start) = self.deeds.last()? else { return None };
        match self.events.get(start)? {
            (_, Event::Planned { batch, .. }) => Some(*batch),
            _ => None,
        }
    }

    /// Lets nobody read the results that a queue has of these experiments, and of those that are not asked for any more: they are
    /// made anew.
    fn forget_results(&mut self, made_anew: &BTreeSet<u64>) {
        let start = self.events.iter().rposition(|(_, event)| matches!(event, Event::Campaign { .. })).unwrap_or(0);
        let n_asked = self.events[start..].iter().map(|(_, event)| match event {
            Event::Planned { experiments, .. } => experiments.len() as u64,
            _ => 0,
        });
        let n_asked: u64 = n_asked.sum();
        for (_, event) in &mut self.events[start..] {
            let Event::Submitted(Submitted { experiments, .. }) = event else { continue };
            for id in experiments.iter_mut().filter(|id| **id > n_asked || made_anew.contains(id)) {
                *id = 0;
            }
        }
    }

    /// What could be taken back now.
    pub(crate) fn last(&self) -> Option<Last> {
        let &(deed, start) = self.deeds.last()?;
        let events = self.events[start..].iter().filter(|(_, event)| !is_kept(event));
        Some(Last { deed, events: events.cloned().collect() })
    }
}

/// The experiment that this is the result of, if `infuse run` made it.
fn made_by_itself(event: &Event) -> Option<u64> {
    match event {
        Event::Told(Told { id, from, .. }) if from == BY_ITSELF => Some(*id),
        _ => None,
    }
}

/// What was simulated stays known, whoever asked for it, and so does what can be built.
fn is_kept(event: &Event) -> bool {
    matches!(event, Event::Simulated { .. } | Event::Checked { .. } | Event::Submitted(_) | Event::Discarded { .. })
}
