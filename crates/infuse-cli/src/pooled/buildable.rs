//! Whether designs can be built, as a command of the campaign says.

use std::collections::{BTreeMap, BTreeSet};

use anyhow::{Context as _, Result};
use design_space::Cell;

use super::campaign::Campaign;
use crate::journal::{Event, Writer, now};
use crate::number::rounded;
use crate::problem::{Input, PROBLEM, Program};
use crate::simulator::identity_of;

impl Campaign {
    /// Asks of each cell whether it can be built, once. What is found out, as lines of the journal.
    pub(super) fn check(&self, cells: &[Cell]) -> Result<Vec<Event>> {
        let Some(program) = &self.problem.can_be_built else {
            return Ok(Vec::new());
        };
        let by = identity_of(program);
        let mut events: Vec<Event> = Vec::new();
        let mut asked: Vec<Cell> = Vec::new();
        // What the command is not told makes no difference to it.
        let mut answers: BTreeMap<String, bool> = BTreeMap::new();
        for (&cell, known) in self.checked.iter().filter(|(_, known)| known.by == by) {
            answers.insert(self.question(program, cell)?, known.can_be_built);
        }
        for &cell in cells {
            if self.checked.get(&cell).is_some_and(|known| known.by == by) || asked.contains(&cell) {
                continue;
            }
            asked.push(cell);
            let point = self.grid.point(cell)?;
            let question = self.question(program, cell)?;
            let can_be_built = match answers.get(&question) {
                Some(&known) => known,
                None => program
                    .says_yes(&self.folder, &self.problem.region, &point)
                    .with_context(|| format!("{PROBLEM}: [can_be_built] at {}", self.problem.describe(&point)))?,
            };
            answers.insert(question, can_be_built);
            let point = point.into_iter().map(rounded).collect();
            events.push(Event::Checked { cell, point, can_be_built, by: by.clone(), at: now() });
        }
        Ok(events)
    }

    /// What the command is told of a design.
    fn question(&self, program: &Program, cell: Cell) -> Result<String> {
        let (region, point) = (&self.problem.region, self.grid.point(cell)?);
        let words = program.words(&self.folder, region, &point, None);
        Ok(match program.input {
            Input::Arguments => words.join("\n"),
            Input::Json => program.input_text(region, &point, None),
        })
    }

    /// Which of these designs are not to be had: refused by the command, them or others that are the same to it, or by
    /// [[linear_constraint]].
    pub(super) fn not_to_be_had(&self, cells: &[Cell]) -> Result<Vec<bool>> {
        let mut refused: BTreeSet<String> = BTreeSet::new();
        if let Some(program) = &self.problem.can_be_built {
            for cell in self.refused() {
                refused.insert(self.question(program, cell)?);
            }
        }
        let is_refused = |&cell: &Cell| {
            let same = match &self.problem.can_be_built {
                Some(program) if !refused.is_empty() => refused.contains(&self.question(program, cell)?),
                _ => false,
            };
            Ok(same || self.why_not(cell).is_some())
        };
        cells.iter().map(is_refused).collect()
    }

    /// Whether the command, asked now, says that a design cannot be built; nothing is written down.
    pub(super) fn cannot_be_built(&self, cell: Cell) -> Result<bool> {
        Ok(self.is_refused(cell) || some_are_refused(&self.check(&[cell])?))
    }

    /// Whether the command of today says that a design cannot be built.
    pub(super) fn is_refused(&self, cell: Cell) -> bool {
        let Some((program, known)) = self.problem.can_be_built.as_ref().zip(self.checked.get(&cell)) else {
            return false;
        };
        !known.can_be_built && known.by == identity_of(program)
    }

    /// Whether the command of today was not asked about a design.
    pub(super) fn is_to_be_asked(&self, cell: Cell) -> bool {
        let Some(program) = &self.problem.can_be_built else { return false };
        self.checked.get(&cell).is_none_or(|known| known.by != identity_of(program))
    }

    /// Asks whether the recommended design can be built, and the next one until one can: the command may be another than when
    /// the last batch was complete.
    pub(super) fn check_the_recommended(&mut self, writer: &mut Writer) -> Result<()> {
        while self.problem.can_be_built.is_some() {
            let Some(found) = self.assessment()? else { return Ok(()) };
            let checks = self.check(&[found.recommended.cell])?;
            let is_refused = some_are_refused(&checks);
            if !checks.is_empty() {
                self.write_down(writer, checks)?;
            }
            if !is_refused {
                return Ok(());
            }
        }
        Ok(())
    }

    /// Designs of which the command of today says that they cannot be built.
    pub(super) fn refused(&self) -> Vec<Cell> {
        let Some(program) = &self.problem.can_be_built else {
            return Vec::new();
        };
        let by = identity_of(program);
        self.checked.iter().filter(|(_, known)| !known.can_be_built && known.by == by).map(|(&cell, _)| cell).collect()
    }
}

/// Whether some of these lines say that a design cannot be built.
pub(super) fn some_are_refused(events: &[Event]) -> bool {
    events.iter().any(|event| matches!(event, Event::Checked { can_be_built: false, .. }))
}
