//! What the model cost with unknowns and a design, term by term: each pair is flown once.

use std::collections::HashMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

use water_channel::CostBreakdown;

/// The cost of a flight, term by term, or why there is none.
pub(super) type Flown = Result<CostBreakdown, String>;

/// Unknowns and a design.
pub(super) type Pair<'a> = (&'a [f64], &'a [f64]);

/// The flights that are known, by the bits of both. Those of one study: of other files nothing is known.
#[derive(Debug, Default)]
pub(super) struct Flights(Mutex<HashMap<[Vec<u64>; 2], Flown>>);

fn bits((unknowns, design): Pair<'_>) -> [Vec<u64>; 2] {
    [unknowns, design].map(|values| values.iter().map(|x| x.to_bits()).collect())
}

impl Flights {
    /// Those of all pairs: what is not known, each pair once, by `fly`.
    pub(super) fn of(&self, pairs: &[Pair<'_>], fly: impl FnOnce(&[Pair<'_>]) -> Vec<Flown>) -> Vec<Flown> {
        let keys: Vec<[Vec<u64>; 2]> = pairs.iter().map(|pair| bits(*pair)).collect();
        let mut missing: HashMap<&[Vec<u64>; 2], Pair<'_>> = HashMap::new();
        let mut order = Vec::new();
        {
            let known = self.lock();
            for (key, pair) in keys.iter().zip(pairs).filter(|(key, _)| !known.contains_key(*key)) {
                if missing.insert(key, *pair).is_none() {
                    order.push(key);
                }
            }
        }
        let unknown: Vec<Pair<'_>> = order.iter().map(|key| missing[*key]).collect();
        let flown = if unknown.is_empty() { Vec::new() } else { fly(&unknown) };
        let mut known = self.lock();
        known.extend(order.into_iter().cloned().zip(flown));
        let none = || Err("no flight".to_owned());
        keys.iter().map(|key| known.get(key).cloned().unwrap_or_else(none)).collect()
    }

    /// Held for look-ups and notes only, never while something flies.
    fn lock(&self) -> MutexGuard<'_, HashMap<[Vec<u64>; 2], Flown>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_pair_is_flown_once_and_found_in_its_place() {
        let flights = Flights::default();
        let flown = |pairs: &[Pair<'_>]| -> Vec<Flown> {
            pairs.iter().map(|(unknowns, design)| Err(format!("{unknowns:?} {design:?}"))).collect()
        };
        let (a, b, c): (Pair<'_>, Pair<'_>, Pair<'_>) = ((&[1.0], &[2.0]), (&[1.0], &[3.0]), (&[1.0, 2.0], &[3.0]));
        let first = flights.of(&[a, b, a], |pairs| {
            assert_eq!(pairs, [a, b]);
            flown(pairs)
        });
        assert_eq!(first, flown(&[a, b, a]));
        let second = flights.of(&[c, b], |pairs| {
            assert_eq!(pairs, [c]);
            flown(pairs)
        });
        assert_eq!(second, flown(&[c, b]));
        assert_eq!(flights.of(&[b, a], |_| panic!("all are known")), flown(&[b, a]));
    }
}
