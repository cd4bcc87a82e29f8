//! A run that is to be queued, and by what its result is known.

use design_space::Cell;

use crate::journal::Submitted;

/// A run.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Task {
    pub(crate) key: Key,
    /// Natural.
    pub(crate) point: Vec<f64>,
}

/// Which run it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Key {
    /// A design is simulated once.
    Simulation(Cell),
    /// A design may be run more than once, each time under an id of its own.
    Experiment(u64, Cell),
}

impl Key {
    /// The design.
    pub(crate) fn cell(self) -> Cell {
        match self {
            Self::Simulation(cell) | Self::Experiment(_, cell) => cell,
        }
    }

    /// The number of the experiment, if it is one.
    pub(crate) fn id(self) -> Option<u64> {
        match self {
            Self::Simulation(_) => None,
            Self::Experiment(id, _) => Some(id),
        }
    }

    /// Those of a submission.
    pub(super) fn of(submitted: &Submitted) -> Vec<Self> {
        let Submitted { cells, experiments, .. } = submitted;
        match submitted.is_of_experiments() {
            true => experiments.iter().zip(cells).map(|(&id, &cell)| Self::Experiment(id, cell)).collect(),
            false => cells.iter().map(|&cell| Self::Simulation(cell)).collect(),
        }
    }
}
