//! The starts of one round, given out to threads in their order.

use std::sync::{Mutex, MutexGuard, PoisonError};

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::attempt::{Attempt, Designer};
use super::ending::Ending;
use super::incumbents::Incumbents;
use super::report::StopReason;

/// Starts per round: those of one round know the results of the rounds before, and no others.
pub(crate) const ROUND: u64 = 16;

/// What the threads of a round share.
#[derive(Debug, Default)]
pub(crate) struct Round {
    next: u64,
    end: u64,
    has_design: bool,
    /// Starts and how they ended, in any order until [`make`](Self::make) is over.
    pub(crate) attempts: Vec<(u64, Attempt)>,
    /// Why no further start began, if there were any left.
    pub(crate) stop: Option<StopReason>,
}

impl Round {
    /// Makes starts `first` to `end` less one on all threads of the current rayon pool, or as many of the first of them
    /// as there is time for.
    pub(crate) fn make(
        first: u64,
        end: u64,
        (designer, seed): (&dyn Designer, u64),
        incumbents: &Incumbents,
        ending: Ending<'_>,
    ) -> Self {
        let round = Mutex::new(Self { next: first, end, ..Self::default() });
        // The lock is held only while a start is given out or handed in.
        let next = || lock(&round).begin(ending);
        let work = || {
            while let Some(start) = next() {
                let attempt = designer.start(&mut stream(seed, start), incumbents, &|| ending.is_over());
                lock(&round).finish(start, attempt, ending);
            }
        };
        rayon::scope(|scope| {
            for _ in 1..rayon::current_num_threads() {
                scope.spawn(|_| work());
            }
            work();
        });
        let mut round = round.into_inner().unwrap_or_else(PoisonError::into_inner);
        round.attempts.sort_by_key(|attempt| attempt.0);
        round
    }

    /// The next start; none if all have begun or the search is over. A time limit lets the first round go on until one of
    /// its starts has a design.
    fn begin(&mut self, ending: Ending<'_>) -> Option<u64> {
        let waits = self.next < ROUND && !self.has_design;
        let reason = ending.reason().filter(|reason| !(waits && *reason == StopReason::TimeLimit));
        self.stop = self.stop.or(reason);
        if self.stop.is_some() || self.next >= self.end {
            return None;
        }
        self.next += 1;
        Some(self.next - 1)
    }

    fn finish(&mut self, start: u64, attempt: Attempt, ending: Ending<'_>) {
        if let Attempt::Cut { .. } = attempt {
            self.stop = self.stop.or_else(|| ending.reason());
        }
        self.has_design |= matches!(attempt, Attempt::Cut { .. } | Attempt::Found { .. });
        self.attempts.push((start, attempt));
    }
}

/// The random numbers of one start: they depend on seed and start and on nothing else.
fn stream(seed: u64, start: u64) -> Pcg64 {
    let mut generator = Pcg64::seed_from_u64(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15).wrapping_add(start));
    // The first draws decorrelate neighboring streams.
    for _ in 0..4 {
        let _: u64 = generator.random();
    }
    generator
}

/// A panic of another thread ends the scope anyway; its data is not used.
fn lock(round: &Mutex<Round>) -> MutexGuard<'_, Round> {
    round.lock().unwrap_or_else(PoisonError::into_inner)
}
