//! Whether something holds without noise, and for how many of its seeds.

use crate::rules::Count;
use crate::words::capitalized;

/// A yes or no without noise, and how often with it.
pub(super) struct Votes {
    quiet: bool,
    noisy: Vec<bool>,
}

impl Votes {
    pub(super) fn of<T>(quiet: &T, noisy: &[T], holds: impl Fn(&T) -> bool) -> Self {
        Self { quiet: holds(quiet), noisy: noisy.iter().map(holds).collect() }
    }

    /// The campaign without noise is one among all.
    pub(super) fn count(&self) -> Count {
        Count::of(std::iter::once(self.quiet).chain(self.noisy.iter().copied()))
    }

    /// The same as the beginning of a sentence.
    pub(super) fn sentence(&self) -> String {
        capitalized(&self.words())
    }

    pub(super) fn words(&self) -> String {
        let (n, all) = (count(&self.noisy), self.noisy.len());
        if self.quiet {
            format!("it holds without noise, and for {n} of {all} seeds")
        } else {
            format!("it does not hold without noise; it holds for {n} of {all} seeds")
        }
    }
}

pub(super) fn count(holds: &[bool]) -> usize {
    holds.iter().filter(|holds| **holds).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_campaign_without_noise_is_one_among_all() {
        let votes = |quiet, n: usize| Votes { quiet, noisy: (0..20).map(|k| k < n).collect() }.count();
        assert_eq!([votes(true, 20), votes(false, 3)].map(|count| (count.holding, count.cases)), [(21, 21), (3, 21)]);
        assert!(votes(true, 0).few() && votes(false, 2).few(), "one or two of 21");
        assert!(!votes(true, 2).few() && votes(true, 18).most() && !votes(true, 17).most(), "3, 19 and 18 of 21");
    }
}
