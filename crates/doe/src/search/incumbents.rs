//! The best designs so far: what later starts begin from and are measured against.

use std::cmp::Ordering;

use rand::RngExt;
use rand_pcg::Pcg64;

/// A design that a start has reached.
#[derive(Debug, Clone)]
pub(crate) struct Contender {
    /// The logarithm of the criterion.
    pub(crate) value: f64,
    pub(crate) start: u64,
    /// Coordinates of the free runs.
    pub(crate) x: Vec<f64>,
}

impl Contender {
    /// The better first, of equals that of the earlier start.
    pub(crate) fn order(&self, other: &Self) -> Ordering {
        self.value.total_cmp(&other.value).then(self.start.cmp(&other.start))
    }
}

/// The best designs of the rounds before.
#[derive(Debug, Clone, Default)]
pub(crate) struct Incumbents {
    /// Least value after each stage of a start.
    stages: Vec<f64>,
    /// Least value before refinement.
    coarse: Option<f64>,
    /// Refined designs, the best first.
    ranked: Vec<Contender>,
}

/// Designs kept to start from.
const ELITE: usize = 12;
/// Values closer than this are of the same design.
const SAME_DESIGN: f64 = 1e-9;

impl Incumbents {
    pub(crate) fn best_log_value(&self) -> f64 {
        self.ranked.first().map_or(f64::INFINITY, |best| best.value)
    }

    /// Least value after this stage of a start; infinite if none came so far.
    pub(crate) fn best_at_stage(&self, stage: usize) -> f64 {
        self.stages.get(stage).copied().unwrap_or(f64::INFINITY)
    }

    /// Least value before refinement; infinite without any.
    pub(crate) fn best_before_refinement(&self) -> f64 {
        self.coarse.unwrap_or(f64::INFINITY)
    }

    /// A design to change: with even chance none, else one of the best.
    pub(crate) fn pick(&self, generator: &mut Pcg64) -> Option<&[f64]> {
        if self.ranked.is_empty() || generator.random::<bool>() {
            return None;
        }
        let index = generator.random_range(0..self.ranked.len());
        Some(&self.ranked[index].x)
    }

    /// Takes note of what a start reached: its values on the way, and the last.
    pub(crate) fn note(&mut self, stages: &[f64], value: f64) {
        for (stage, &reached) in stages.iter().enumerate() {
            match self.stages.get_mut(stage) {
                Some(least) => *least = least.min(reached),
                None => self.stages.push(reached),
            }
        }
        self.coarse = Some(self.coarse.map_or(value, |least| least.min(value)));
    }

    /// Takes a refined design among the best, if it is one of them and not there yet.
    pub(crate) fn insert(&mut self, contender: Contender) {
        if self.ranked.iter().any(|other| (other.value - contender.value).abs() < SAME_DESIGN) {
            return;
        }
        self.ranked.push(contender);
        self.ranked.sort_by(Contender::order);
        self.ranked.truncate(ELITE);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_best_is_kept_and_no_design_twice() {
        let mut incumbents = Incumbents::default();
        for (start, value) in [(0, 0.5), (1, 0.3), (2, 0.5 + 1e-12), (3, 0.4)] {
            incumbents.insert(Contender { value, start, x: vec![value] });
        }
        let kept: Vec<u64> = incumbents.ranked.iter().map(|contender| contender.start).collect();
        assert_eq!(kept, [1, 3, 0], "the best first");
        assert_eq!(incumbents.best_log_value().to_bits(), 0.3_f64.to_bits());
        for start in 4..40 {
            incumbents.insert(Contender { value: 1.0 + start as f64, start, x: Vec::new() });
        }
        assert_eq!((incumbents.ranked.len(), incumbents.ranked[0].start), (ELITE, 1));
    }
}
