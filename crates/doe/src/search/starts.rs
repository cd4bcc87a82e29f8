//! Many starts side by side, the same result whatever the number of threads.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use rayon::prelude::*;

use super::report::StopReason;
use super::settings::Settings;

/// How one start ended.
#[derive(Debug, Clone)]
pub(crate) enum Attempt {
    /// With free runs at x, the logarithm of the criterion there, smoothed for G, and its values on the way.
    Found {
        x: Vec<f64>,
        value: f64,
        stages: Vec<f64>,
    },
    Abandoned,
    Failed,
    /// The search was over before the start was: what it had, not singular.
    Cut {
        x: Vec<f64>,
        value: f64,
    },
}

/// Whether a search is over, asked wherever it may have to end: cheap, and true from some time on.
pub(crate) type IsOver<'a> = &'a (dyn Fn() -> bool + Sync);

/// What ends a search from outside.
#[derive(Clone, Copy)]
pub(crate) struct Ending<'a> {
    pub(crate) began: Instant,
    pub(crate) time_limit: Option<Duration>,
    pub(crate) is_interrupted: IsOver<'a>,
}

impl Ending<'_> {
    fn reason(&self) -> Option<StopReason> {
        if (self.is_interrupted)() {
            Some(StopReason::Interrupted)
        } else if self.time_limit.is_some_and(|limit| self.began.elapsed() >= limit) {
            Some(StopReason::TimeLimit)
        } else {
            None
        }
    }
}

/// The best designs of the rounds before.
#[derive(Debug, Clone, Default)]
pub(crate) struct Incumbents {
    /// Least value after each stage of a start.
    stages: Vec<f64>,
    /// Least value before refinement.
    coarse: Option<f64>,
    /// Value, start, runs; the best first.
    ranked: Vec<(f64, u64, Vec<f64>)>,
}

/// Designs kept to start from.
const ELITE: usize = 12;
/// Values closer than this count as the same design found again.
const SAME_VALUE: f64 = 1e-6;

/// Starts per round: those of one round know the results of the rounds before, and no others.
const ROUND: u64 = 16;

impl Incumbents {
    pub(crate) fn best_log_value(&self) -> f64 {
        self.ranked.first().map_or(f64::INFINITY, |best| best.0)
    }

    /// Least value after this stage of a start; infinite if none came so far.
    pub(crate) fn best_at_stage(&self, stage: usize) -> f64 {
        self.stages.get(stage).copied().unwrap_or(f64::INFINITY)
    }

    fn note(&mut self, stages: &[f64], value: f64) {
        for (stage, &reached) in stages.iter().enumerate() {
            match self.stages.get_mut(stage) {
                Some(least) => *least = least.min(reached),
                None => self.stages.push(reached),
            }
        }
        self.coarse = Some(self.coarse.map_or(value, |least| least.min(value)));
    }

    /// A design to change: with even chance none, else one of the best.
    pub(crate) fn pick(&self, generator: &mut Pcg64) -> Option<&[f64]> {
        if self.ranked.is_empty() || generator.random::<bool>() {
            return None;
        }
        let index = generator.random_range(0..self.ranked.len());
        Some(&self.ranked[index].2)
    }

    fn insert(&mut self, value: f64, start: u64, x: Vec<f64>) {
        if self.ranked.iter().any(|other| (other.0 - value).abs() < 1e-9) {
            return;
        }
        self.ranked.push((value, start, x));
        self.ranked.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        self.ranked.truncate(ELITE);
    }
}

/// What all starts together found.
#[derive(Debug)]
pub(crate) struct Outcome {
    pub(crate) best: Option<(f64, u64, Vec<f64>)>,
    pub(crate) stop: StopReason,
    pub(crate) starts: u64,
    pub(crate) times_found: u64,
    pub(crate) abandoned: u64,
    pub(crate) failed: u64,
    pub(crate) unfinished: u64,
}

/// A start this far behind the best before refinement is not refined.
const WORTH_REFINING: f64 = 0.004;
/// Starts refined per round at most.
const REFINED: usize = 2;

/// Runs starts in rounds on all threads of the current rayon pool: first the starts of a round, then the refinement of
/// its best.
///
/// A start begins only if all before it have begun. Where a search is over, the starts on their way are cut, and the
/// first of them and all after it do not count, so the starts made are 0 to some number however the search is stopped;
/// refinements on their way end with what they have reached. Without a whole start the best of those cut is the result.
/// A time limit lets the first round begin until one of its starts has a design. `target` is a value at which to stop;
/// `progress` hears of every round.
pub(crate) fn run(
    settings: &Settings,
    ending: Ending<'_>,
    target: Option<f64>,
    attempt: impl Fn(&mut Pcg64, &Incumbents, IsOver<'_>) -> Attempt + Sync,
    refine: impl Fn(Vec<f64>, f64, &Incumbents, IsOver<'_>) -> Option<(Vec<f64>, f64)> + Sync,
    mut progress: impl FnMut(u64, f64),
) -> Outcome {
    let mut incumbents = Incumbents::default();
    let mut best: Option<(f64, u64, Vec<f64>)> = None;
    let mut values: Vec<f64> = Vec::new();
    let (mut abandoned, mut failed, mut unfinished) = (0, 0, 0);
    let mut done = 0;
    let has_design = AtomicBool::new(false);
    let is_over = || ending.reason().is_some();
    let begins_no_more = |start: u64| {
        let waits = start < ROUND && !has_design.load(Ordering::Relaxed);
        ending.reason().filter(|reason| !(waits && *reason == StopReason::TimeLimit))
    };
    let mut stop = StopReason::StartsDone;
    while done < settings.starts && stop == StopReason::StartsDone {
        let end = (done + ROUND).min(settings.starts);
        let next = AtomicU64::new(done);
        let why = Mutex::new(None);
        let results = Mutex::new(Vec::new());
        let work = || {
            loop {
                let reason = begins_no_more(next.load(Ordering::Relaxed));
                let mut said = lock(&why);
                if said.is_some() || reason.is_some() {
                    *said = said.or(reason);
                    break;
                }
                drop(said);
                let start = next.fetch_add(1, Ordering::Relaxed);
                if start >= end {
                    break;
                }
                let mut generator = stream(settings.seed, start);
                let attempt = attempt(&mut generator, &incumbents, &is_over);
                if matches!(attempt, Attempt::Cut { .. }) {
                    let mut said = lock(&why);
                    *said = said.or_else(|| ending.reason());
                }
                if matches!(attempt, Attempt::Cut { .. } | Attempt::Found { .. }) {
                    has_design.store(true, Ordering::Relaxed);
                }
                lock(&results).push((start, attempt));
            }
        };
        rayon::scope(|scope| {
            for _ in 1..rayon::current_num_threads() {
                scope.spawn(|_| work());
            }
            work();
        });
        let mut results = results.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
        results.sort_by_key(|result| result.0);
        let n_whole = results.iter().take_while(|(_, attempt)| !matches!(attempt, Attempt::Cut { .. })).count();
        let rest = results.split_off(n_whole);
        let cut = rest.into_iter().filter_map(|(start, attempt)| match attempt {
            Attempt::Cut { x, value } => Some((value, start, x)),
            _ => None,
        });
        let cut: Vec<(f64, u64, Vec<f64>)> = cut.collect();
        unfinished += cut.len() as u64;
        done += results.len() as u64;
        let mut worth = Vec::new();
        for (start, attempt) in results {
            match attempt {
                Attempt::Found { x, value, stages } => {
                    incumbents.note(&stages, value);
                    worth.push((value, start, x));
                }
                Attempt::Abandoned => abandoned += 1,
                Attempt::Failed | Attempt::Cut { .. } => failed += 1,
            }
        }
        let least = incumbents.coarse.unwrap_or(f64::INFINITY);
        worth.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let n_worth = worth.iter().take_while(|start| start.0 <= least + WORTH_REFINING).count();
        abandoned += worth.len().saturating_sub(n_worth.min(REFINED)) as u64;
        worth.truncate(n_worth.min(REFINED));
        if worth.is_empty() && best.is_none() {
            worth = cut;
        }
        let refined: Vec<_> = worth
            .into_par_iter()
            .map(|(value, start, x)| {
                let was_cut = AtomicBool::new(false);
                let is_over = || {
                    let is_over = is_over();
                    was_cut.fetch_or(is_over, Ordering::Relaxed);
                    is_over
                };
                let refined = refine(x, value, &incumbents, &is_over);
                (start, refined, was_cut.into_inner())
            })
            .collect();
        for (start, refined, was_cut) in refined {
            if was_cut {
                unfinished += 1;
                let mut said = lock(&why);
                *said = said.or_else(|| ending.reason());
            }
            match refined {
                Some((x, value)) => {
                    values.push(value);
                    if best.as_ref().is_none_or(|best| value < best.0) {
                        best = Some((value, start, x.clone()));
                    }
                    incumbents.insert(value, start, x);
                }
                None => failed += 1,
            }
        }
        if target.is_some_and(|target| incumbents.best_log_value() <= target) {
            stop = StopReason::TargetReached;
        }
        if let Some(reason) = lock(&why).take()
            && stop == StopReason::StartsDone
        {
            stop = reason;
        }
        progress(done, incumbents.best_log_value());
    }
    let least = best.as_ref().map_or(f64::INFINITY, |best| best.0);
    let times_found = values.iter().filter(|value| **value <= least + SAME_VALUE).count() as u64;
    Outcome { best, stop, starts: done, times_found, abandoned, failed, unfinished }
}

/// The random numbers of one start: they depend on seed and start and on nothing else.
pub(crate) fn stream(seed: u64, start: u64) -> Pcg64 {
    let mut generator = Pcg64::seed_from_u64(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15).wrapping_add(start));
    // The first draws decorrelate neighboring streams.
    for _ in 0..4 {
        let _: u64 = generator.random();
    }
    generator
}

/// A panic of another thread ends the scope anyway; its data is not used.
fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}
