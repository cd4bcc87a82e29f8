//! Many starts side by side, the same result whatever the number of threads.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use super::attempt::{Attempt, Designer, Refinement};
use super::ending::Ending;
use super::incumbents::{Contender, Incumbents};
use super::report::StopReason;
use super::round::{ROUND, Round};
use super::settings::Settings;

/// What all starts together found.
#[derive(Debug)]
pub(crate) struct Outcome {
    pub(crate) best: Option<Contender>,
    pub(crate) stop: StopReason,
    pub(crate) times_found: u64,
    pub(crate) counts: Counts,
}

/// How many starts went which way.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Counts {
    /// Made as a whole.
    pub(crate) starts: u64,
    pub(crate) abandoned: u64,
    pub(crate) failed: u64,
    /// Cut on their way, as starts or while they were refined.
    pub(crate) unfinished: u64,
}

/// Values closer than this count as the same design found again.
const SAME_VALUE: f64 = 1e-6;

/// What runs the starts of any search.
pub(crate) struct Runner<'a> {
    pub(crate) settings: &'a Settings,
    pub(crate) ending: Ending<'a>,
    /// A value at which to stop.
    pub(crate) target: Option<f64>,
    /// For T.
    pub(crate) least_log_determinant: f64,
    /// Called after every round with the number of starts made and the best value.
    pub(crate) progress: &'a mut dyn FnMut(u64, f64),
}

impl Runner<'_> {
    /// Runs starts in rounds on all threads of the current rayon pool: first the starts of a round, then the refinement
    /// of its best.
    ///
    /// A start begins only if all before it have begun. Where a search is over, the starts on their way are cut, and the
    /// first of them and all after it do not count, so the starts made are 0 to some number however the search is stopped;
    /// refinements on their way end with what they have reached. Without a whole start the best of those cut is the
    /// result.
    pub(crate) fn run(self, designer: &dyn Designer) -> Outcome {
        let mut search = Search::new(self.settings, self.ending, self.target, designer);
        while search.counts.starts < self.settings.starts && search.stop == StopReason::StartsDone {
            search.round();
            (self.progress)(search.counts.starts, search.incumbents.best_log_value());
        }
        search.outcome()
    }
}

/// A search between two rounds.
struct Search<'a> {
    settings: &'a Settings,
    ending: Ending<'a>,
    target: Option<f64>,
    designer: &'a dyn Designer,
    incumbents: Incumbents,
    best: Option<Contender>,
    /// The best that the search was over before anything was known of but what its start said: nothing is held against it.
    unjudged: Option<Contender>,
    /// Of every refined design.
    values: Vec<f64>,
    counts: Counts,
    stop: StopReason,
}

/// What refinement made of a design of a start.
struct Refined {
    contender: Contender,
    refinement: Refinement,
    was_cut: bool,
}

impl<'a> Search<'a> {
    fn new(settings: &'a Settings, ending: Ending<'a>, target: Option<f64>, designer: &'a dyn Designer) -> Self {
        Self {
            settings,
            ending,
            target,
            designer,
            incumbents: Incumbents::default(),
            best: None,
            unjudged: None,
            values: Vec::new(),
            counts: Counts::default(),
            stop: StopReason::StartsDone,
        }
    }

    fn round(&mut self) {
        let Round { attempts, stop, .. } = self.make_starts();
        let (whole, cut) = split_at_first_cut(attempts);
        let found = self.count(whole, cut.len());
        let chosen = self.choose(found, cut);
        let refined = self.refine(chosen);
        let was_cut = refined.iter().any(|refined| refined.was_cut);
        let stop = stop.or_else(|| if was_cut { self.ending.reason() } else { None });
        refined.into_iter().for_each(|refined| self.note(refined));
        self.decide(stop);
        if let Some(unjudged) = self.unjudged.take().filter(|_| self.best.is_none()) {
            self.take(unjudged);
        }
    }

    fn make_starts(&self) -> Round {
        let first = self.counts.starts;
        let end = (first + ROUND).min(self.settings.starts);
        Round::make(first, end, (self.designer, self.settings.seed), &self.incumbents, self.ending)
    }

    /// Counts the starts of a round; what the whole ones found.
    fn count(&mut self, whole: Vec<(u64, Attempt)>, n_cut: usize) -> Vec<Contender> {
        self.counts.unfinished += n_cut as u64;
        self.counts.starts += whole.len() as u64;
        let mut found = Vec::new();
        for (start, attempt) in whole {
            match attempt {
                Attempt::Found { x, value, stages } => {
                    self.incumbents.note(&stages, value);
                    found.push(Contender { value, start, x });
                }
                Attempt::Abandoned => self.counts.abandoned += 1,
                Attempt::Failed | Attempt::Cut { .. } => self.counts.failed += 1,
            }
        }
        found
    }

    /// Which designs of a round to refine: the best of those found; without any so far, those cut.
    fn choose(&mut self, mut found: Vec<Contender>, cut: Vec<Contender>) -> Vec<Contender> {
        let (behind, n_refined) = self.designer.worth_refining();
        let most = self.incumbents.best_before_refinement() + behind;
        found.sort_by(Contender::order);
        let n_worth = found.iter().take_while(|contender| contender.value <= most).count().min(n_refined);
        self.counts.abandoned += (found.len() - n_worth) as u64;
        found.truncate(n_worth);
        if found.is_empty() && self.best.is_none() { cut } else { found }
    }

    /// Refines designs side by side.
    fn refine(&self, chosen: Vec<Contender>) -> Vec<Refined> {
        let refine = |contender: Contender| {
            let was_cut = AtomicBool::new(false);
            let is_over = || {
                let is_over = self.ending.is_over();
                was_cut.fetch_or(is_over, Ordering::Relaxed);
                is_over
            };
            let refinement = self.designer.refine(contender.x.clone(), contender.value, &self.incumbents, &is_over);
            Refined { contender, refinement, was_cut: was_cut.into_inner() }
        };
        chosen.into_par_iter().map(refine).collect()
    }

    /// Takes note of a refined design.
    fn note(&mut self, refined: Refined) {
        self.counts.unfinished += u64::from(refined.was_cut);
        let start = refined.contender.start;
        match refined.refinement {
            Refinement::Reached { x, value } => self.take(Contender { value, start, x }),
            Refinement::Unjudged => {
                let others = self.unjudged.take().into_iter();
                self.unjudged = others.chain([refined.contender]).min_by(Contender::order);
            }
            Refinement::Failed => self.counts.failed += 1,
        }
    }

    /// Takes a design among those found.
    fn take(&mut self, contender: Contender) {
        self.values.push(contender.value);
        if self.best.as_ref().is_none_or(|best| contender.value < best.value) {
            self.best = Some(contender.clone());
        }
        self.incumbents.insert(contender);
    }

    /// Whether the search is over: at its target, or for a reason from outside.
    fn decide(&mut self, reason: Option<StopReason>) {
        if self.target.is_some_and(|target| self.incumbents.best_log_value() <= target) {
            self.stop = StopReason::TargetReached;
        } else if let Some(reason) = reason {
            self.stop = reason;
        }
    }

    fn outcome(self) -> Outcome {
        let least = self.best.as_ref().map_or(f64::INFINITY, |best| best.value);
        let times_found = self.values.iter().filter(|value| **value <= least + SAME_VALUE).count() as u64;
        Outcome { best: self.best, stop: self.stop, times_found, counts: self.counts }
    }
}

/// The starts before the first that was cut, and what of that one and those after it was cut.
fn split_at_first_cut(mut attempts: Vec<(u64, Attempt)>) -> (Vec<(u64, Attempt)>, Vec<Contender>) {
    let n_whole = attempts.iter().take_while(|(_, attempt)| !matches!(attempt, Attempt::Cut { .. })).count();
    let rest = attempts.split_off(n_whole).into_iter();
    let cut = rest.filter_map(|(start, attempt)| match attempt {
        Attempt::Cut { x, value } => Some(Contender { value, start, x }),
        _ => None,
    });
    (attempts, cut.collect())
}
