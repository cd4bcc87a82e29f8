//! What flown points cost, in memory and, where a file was given, on disk.

use std::collections::HashMap;
#[cfg(feature = "global")]
use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};

use bat_dynamics::Fidelity;

use super::cost::Flown;
use super::journal::Journal;

/// The bits of a point.
type Bits = Vec<u64>;

fn bits(point: &[f64]) -> Bits {
    point.iter().map(|x| x.to_bits()).collect()
}

/// The costs of flown points, looked up by their bits: flights carry no noise, so each point is flown once per fidelity.
#[derive(Debug, Default)]
pub(crate) struct Store {
    known: Mutex<HashMap<Fidelity, Known>>,
}

#[derive(Debug, Default)]
struct Known {
    costs: HashMap<Bits, Flown>,
    journal: Option<Journal>,
}

impl Store {
    /// Goes on with a file in this fidelity: what it knows counts as flown, what is flown is written to it.
    #[cfg(feature = "global")]
    pub(crate) fn keep_in(&self, path: &Path, fidelity: Fidelity) -> std::io::Result<()> {
        let (journal, costs) = Journal::open(path)?;
        let mut all = self.lock();
        let known = all.entry(fidelity).or_default();
        known.costs.extend(costs.into_iter().map(|(point, cost)| (bits(&point), cost)));
        known.journal = Some(journal);
        Ok(())
    }

    pub(crate) fn get(&self, point: &[f64], fidelity: Fidelity) -> Option<Flown> {
        self.lock().get(&fidelity)?.costs.get(&bits(point)).cloned()
    }

    /// Remembers what these points cost.
    pub(crate) fn add<'a>(&self, fidelity: Fidelity, costs: impl IntoIterator<Item = (&'a [f64], &'a Flown)>) {
        let mut all = self.lock();
        let Known { costs: known, journal } = all.entry(fidelity).or_default();
        let mut new = Vec::new();
        for (point, cost) in costs {
            if known.insert(bits(point), cost.clone()).is_none() {
                new.push((point, cost));
            }
        }
        if let Some(journal) = journal.as_mut().filter(|_| !new.is_empty()) {
            journal.add(new);
        }
    }

    /// How many different points are known in a fidelity.
    pub(crate) fn len(&self, fidelity: Fidelity) -> usize {
        self.lock().get(&fidelity).map_or(0, |known| known.costs.len())
    }

    /// Held for look-ups and notes only, never while something flies.
    fn lock(&self) -> MutexGuard<'_, HashMap<Fidelity, Known>> {
        // A panic elsewhere cannot leave the map half written.
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
