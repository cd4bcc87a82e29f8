//! Whether something holds without noise, and for how many of its seeds.

use crate::claims::Verdict;
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

    /// It holds if it does without noise and for nine in ten seeds, in part if it ever does.
    pub(super) fn verdict(&self) -> Verdict {
        match (self.quiet, by_seeds(&self.noisy)) {
            (true, Verdict::InKind) => Verdict::InKind,
            (false, Verdict::NotReproduced) => Verdict::NotReproduced,
            _ => Verdict::InPart,
        }
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

/// The verdict of the seeds alone, for what is said of noise.
pub(super) fn by_seeds(holds: &[bool]) -> Verdict {
    match count(holds) {
        0 => Verdict::NotReproduced,
        n if 10 * n < 9 * holds.len() => Verdict::InPart,
        _ => Verdict::InKind,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_verdict_needs_the_quiet_campaign_and_nine_in_ten_seeds() {
        let votes = |quiet, n: usize| Votes { quiet, noisy: (0..10).map(|k| k < n).collect() };
        let verdicts = [(true, 10), (true, 9), (true, 8), (false, 10), (true, 0), (false, 1), (false, 0)]
            .map(|(quiet, n)| votes(quiet, n).verdict());
        use Verdict::{InKind, InPart, NotReproduced};
        assert_eq!(verdicts, [InKind, InKind, InPart, InPart, InPart, InPart, NotReproduced]);
    }
}
