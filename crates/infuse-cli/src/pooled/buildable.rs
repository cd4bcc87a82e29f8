//! Whether designs can be built, as a command of the campaign says.

use anyhow::{Context as _, Result, bail, ensure};
use design_space::Cell;

use super::campaign::Campaign;
use crate::journal::{Event, now};
use crate::number::rounded;
use crate::problem::{PROBLEM, Program};
use crate::program::Ran;
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
        for &cell in cells {
            if self.checked.get(&cell).is_some_and(|known| known.by == by) || asked.contains(&cell) {
                continue;
            }
            asked.push(cell);
            let point = self.grid.point(cell)?;
            let can_be_built = self
                .ask_program(program, &point)
                .with_context(|| format!("{PROBLEM}: [can_be_built] at {}", self.problem.describe(&point)))?;
            let point = point.into_iter().map(rounded).collect();
            events.push(Event::Checked { cell, point, can_be_built, by: by.clone(), at: now() });
        }
        Ok(events)
    }

    fn ask_program(&self, program: &Program, point: &[f64]) -> Result<bool> {
        const EXPECTED: &str = "expected 1 on its last line if the design can be built, 0 if not";
        match program.run(&self.folder, &self.problem.region, point, None)? {
            Ran::Value(value, _) => {
                let answers = [0.0, 1.0];
                ensure!(answers.iter().any(|answer| (value - answer).abs() < 1e-12), "it printed {value}, {EXPECTED}");
                Ok(value > 0.5)
            }
            Ran::Failed(reason) => bail!("it failed: {reason}; {EXPECTED}"),
            Ran::Interrupted => bail!("interrupted: ask again to go on"),
        }
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
