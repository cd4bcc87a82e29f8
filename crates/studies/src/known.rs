//! What is known by a key: each is made once, by whoever asks for it first, or was made by somebody else.

use std::collections::{HashMap, HashSet};
use std::hash::Hash;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Values by their keys.
#[derive(Debug)]
pub(crate) struct Known<K, V>(Mutex<State<K, V>>);

#[derive(Debug)]
struct State<K, V> {
    values: HashMap<K, V>,
    n_made: usize,
}

impl<K, V> Default for Known<K, V> {
    fn default() -> Self {
        Self(Mutex::new(State { values: HashMap::new(), n_made: 0 }))
    }
}

impl<K: Clone + Ord + Hash, V: Clone> Known<K, V> {
    /// The values of all keys. Those that are not known are made together, each once: `make` is told at which places their keys
    /// stand, and has to give a value for each.
    pub(crate) fn of(&self, keys: &[K], make: impl FnOnce(&[usize]) -> Vec<V>) -> Vec<V> {
        let mut missing: Vec<usize> = Vec::new();
        {
            let known = self.lock();
            let mut new = HashSet::new();
            missing.extend((0..keys.len()).filter(|k| !known.values.contains_key(&keys[*k]) && new.insert(&keys[*k])));
        }
        let made = if missing.is_empty() { Vec::new() } else { make(&missing) };
        assert_eq!(made.len(), missing.len(), "a value for each key");
        let mut known = self.lock();
        known.n_made += made.len();
        known.values.extend(missing.into_iter().map(|k| keys[k].clone()).zip(made));
        keys.iter().map(|key| known.values[key].clone()).collect()
    }

    /// Knows this value from now on, which somebody else made.
    pub(crate) fn know(&self, key: K, value: V) {
        self.lock().values.insert(key, value);
    }

    /// How many were made here.
    pub(crate) fn n_made(&self) -> usize {
        self.lock().n_made
    }

    /// All that is known, by key.
    pub(crate) fn all(&self) -> Vec<(K, V)> {
        let known = self.lock();
        let mut all: Vec<(K, V)> = known.values.iter().map(|(key, value)| (key.clone(), value.clone())).collect();
        all.sort_by(|a, b| a.0.cmp(&b.0));
        all
    }

    /// Held for look-ups and notes only, never while something is made.
    fn lock(&self) -> MutexGuard<'_, State<K, V>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_is_made_once_and_found_in_its_place() {
        let known = Known::default();
        let double = |keys: &[i32], expected: &[usize]| {
            known.of(keys, |missing| {
                assert_eq!(missing, expected);
                missing.iter().map(|k| 2 * keys[*k]).collect()
            })
        };
        assert_eq!(double(&[4, 3, 4], &[0, 1]), [8, 6, 8]);
        assert_eq!(double(&[5, 3], &[0]), [10, 6]);
        assert_eq!(known.of(&[3, 4], |_| panic!("all are known")), [6, 8]);
        known.know(1, 7);
        assert_eq!(known.of(&[1], |_| panic!("all are known")), [7]);
        assert_eq!(known.n_made(), 3);
        assert_eq!(known.all(), [(1, 7), (3, 6), (4, 8), (5, 10)]);
    }

    #[test]
    #[should_panic(expected = "a value for each key")]
    fn who_makes_too_few_is_told() {
        Known::<i32, i32>::default().of(&[1, 2], |_| vec![1]);
    }
}
