//! How much better than the recommended design another may be.

use design_space::Cell;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use surface::process::Joint;

use crate::Error;
use crate::pooled::knowledge::Knowledge;
use crate::pooled::measurements::Reading;
use crate::pooled::pool::Pool;
use crate::pooled::streams::{Purpose, stream};

/// The probability whose shares of the draws are those of [`Trust`]; with another one the share beyond the bound goes in proportion to
/// one less the probability.
const USUAL: f64 = 0.9;
/// Cells on which the response is drawn.
const CELLS: usize = 256;
const DRAWS: usize = 1080;
/// Draws that do not believe the simulation.
const DOUBTED: usize = 360;

/// How far what is drawn can be trusted: few readings show neither a well that the simulation does not have nor a process that is
/// too sure of itself. Chosen on campaigns of which the truth is known, as `docs/results-benchmark.md` says.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Trust {
    /// Share of the draws that do not believe the simulation, where some do.
    doubt: f64,
    /// By this the quantile is widened.
    allowance: f64,
    /// Share of the draws beyond the quantile, of a certificate that may fail in one case of ten.
    beyond: f64,
    /// Nothing is widened beyond so many times what the readings differ by.
    cap: f64,
}

impl Trust {
    /// Doubt and allowance fall as the readings outnumber the terms of a quadratic. A hundredth is beyond up to four readings a term,
    /// and more as there are more, up to three hundredths: what the surface says of itself has then been put to the test. The readings
    /// are those that tell of designs everywhere, not those that crowd at one place.
    fn after(n_readings: usize, n_terms: usize) -> Self {
        let scarcity = (n_terms as f64 / n_readings.max(1) as f64).min(1.0);
        Self {
            doubt: scarcity,
            allowance: 1.0 + 8.0 * scarcity * scarcity,
            beyond: 0.01 * (0.25 / scarcity).clamp(1.0, 3.0),
            cap: 1.0 + scarcity,
        }
    }
}

/// "With this probability no design is better than the recommended one by more than `bound`."
///
/// It rests on the measurements, on the simulation as far as these agree with it, and on the response being a polynomial, a
/// corrected simulation or as smooth as the priors of the surface say. What no measurement and no simulation shows, as a well
/// between all of them, it allows for by doubting the simulation and by widening what the surface says of itself, the less the
/// more readings there are. Without a simulation readings that crowd count for few, as many evenly spread ones as would leave the box
/// as far from any; with one they count in between, by the probability that it is of no use.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Certificate {
    /// The probability.
    pub probability: f64,
    /// In the unit of the response, at least 0.
    pub bound: f64,
    /// The same as the surface has it, without that allowance: never above the bound.
    pub quantile: f64,
}

impl Certificate {
    /// Batches until the bound is expected to be no more than `worth`, after as many readings: 0 if it is no more already.
    ///
    /// The bound is taken to fall as the square of the readings: so it does in the median of the campaigns of the benchmark, from
    /// batch to batch, whose page says how often that came true.
    #[must_use]
    pub fn further_batches(&self, worth: f64, n_readings: usize, n_experiments: usize) -> u64 {
        if self.bound <= worth {
            return 0;
        }
        let n_batches = n_readings as f64 / n_experiments.max(1) as f64 * ((self.bound / worth).sqrt() - 1.0);
        // Beyond all integers that is the largest.
        n_batches.ceil().max(1.0) as u64
    }
}

/// What may be gained over the recommended design, drawn from all that is possible.
#[derive(Debug, Clone)]
pub(crate) struct Draws {
    /// As the surface has it.
    believed: Gains,
    /// With the draws that do not believe the simulation.
    all: Gains,
    trust: Trust,
    /// What the readings differ by.
    spread: f64,
}

impl Draws {
    /// As many of the readings tell of designs everywhere as `n_telling` says.
    pub(crate) fn of(
        knowledge: &mut Knowledge<'_, '_>,
        pool: &Pool,
        recommended: Cell,
        readings: &[Reading],
        n_telling: usize,
        seed: u64,
        batch: usize,
    ) -> Result<Self, Error> {
        let mut order = pool.by_lower_bound(2.0);
        order.truncate(CELLS);
        let mut doubted = match &knowledge.sceptic {
            Some(sceptic) => pool.by_lower_bound_of(&sceptic.marginals(&pool.places), 2.0),
            None => Vec::new(),
        };
        doubted.truncate(CELLS / 2);
        order.truncate(CELLS - doubted.len());
        let mut cells: Vec<Cell> = order.iter().chain(&doubted).map(|&row| pool.cells[row]).collect();
        cells.sort_unstable();
        cells.dedup();
        cells.retain(|&cell| cell != recommended);
        cells.insert(0, recommended);
        let places = knowledge.places(&cells)?;
        let kept = Kept::of(knowledge, &cells, seed, batch)?;
        let of_each = knowledge.joint_of_each(&places);
        let doubts = knowledge.sceptic.as_ref().map(|sceptic| sceptic.joint_of_each(&places)).unwrap_or_default();
        let trust = Trust::after(n_telling, knowledge.designs.n_terms());
        let first = of_each.len() as u128;
        let believed = gains(&of_each, DRAWS, seed, batch, 0, &kept);
        let doubted = gains(&doubts, DOUBTED, seed, batch, first, &kept);
        let all = if doubted.is_empty() {
            Gains::of(vec![(believed.clone(), 1.0)])
        } else {
            Gains::of(vec![(believed.clone(), 1.0 - trust.doubt), (doubted, trust.doubt)])
        };
        Ok(Self { believed: Gains::of(vec![(believed, 1.0)]), all, trust, spread: spread(readings) })
    }

    pub(crate) fn certificate(&self, probability: f64) -> Certificate {
        let sure = 1.0 - self.trust.beyond * (1.0 - probability) / (1.0 - USUAL);
        let (quantile, drawn) = (self.believed.quantile(probability), self.all.quantile(sure));
        let bound = (self.trust.allowance * drawn).min(self.trust.cap * self.spread).max(drawn).max(quantile);
        Certificate { probability, bound, quantile }
    }
}

/// The highest reading less the lowest.
fn spread(readings: &[Reading]) -> f64 {
    let responses = || readings.iter().map(|reading| reading.response);
    responses().fold(f64::NEG_INFINITY, f64::max) - responses().fold(f64::INFINITY, f64::min)
}

/// Gains with their shares, ascending.
#[derive(Debug, Clone)]
struct Gains(Vec<(f64, f64)>);

impl Gains {
    /// Of several samples, each with the share that it has altogether.
    fn of(samples: Vec<(Vec<f64>, f64)>) -> Self {
        let each = samples.into_iter().flat_map(|(sample, share)| {
            let share = share / sample.len() as f64;
            sample.into_iter().map(move |gain| (gain, share))
        });
        let mut gains: Vec<(f64, f64)> = each.collect();
        gains.sort_by(|a, b| a.0.total_cmp(&b.0));
        Self(gains)
    }

    /// The lowest gain that at least this share of them does not exceed.
    fn quantile(&self, level: f64) -> f64 {
        let mut beyond = 0.0;
        let exceeding = self.0.iter().rev().find(|(_, share)| {
            beyond += share;
            // Shares are sums of fractions.
            beyond > 1.0 - level + 1e-9
        });
        exceeding.or(self.0.first()).map_or(0.0, |(gain, _)| *gain)
    }
}

/// Which cells keep to their bounds, drawn from what is known of the constrained responses.
struct Kept {
    /// One list per draw; none where nothing is constrained.
    draws: Vec<Vec<bool>>,
}

/// Draws of each constrained response.
const KEPT: usize = 1080;

impl Kept {
    fn of(knowledge: &Knowledge<'_, '_>, cells: &[Cell], seed: u64, batch: usize) -> Result<Self, Error> {
        if knowledge.held.is_empty() {
            return Ok(Self { draws: Vec::new() });
        }
        let mut draws = vec![vec![true; cells.len()]; KEPT];
        let joints = knowledge.constrained_joints(cells)?;
        for (number, (held, joints)) in knowledge.held.iter().zip(joints).enumerate() {
            // What nobody has measured may keep to its bounds or not.
            let Some(joints) = joints else { continue };
            let per_process = KEPT.div_ceil(joints.len().max(1));
            let tasks: Vec<(u128, &Joint)> = (0..).zip(&joints).collect();
            let drawn: Vec<Vec<Vec<f64>>> = tasks
                .into_par_iter()
                .map(|(process, joint)| {
                    let mut rng = stream(seed, Purpose::Constraints, batch);
                    rng.set_word_pos(((number as u128) << 60) | (process << 40));
                    joint.draws(per_process, &mut rng)
                })
                .collect();
            // Neighbors come from different processes, so that each meets each of the objective.
            for (index, kept) in draws.iter_mut().enumerate() {
                let (process, draw) = (index % drawn.len(), index / drawn.len());
                kept.iter_mut()
                    .zip(&drawn[process][draw])
                    .for_each(|(kept, &value)| *kept &= held.constraint.allows(value));
            }
        }
        Ok(Self { draws })
    }

    fn draw(&self, index: usize) -> Option<&[bool]> {
        if self.draws.is_empty() { None } else { Some(&self.draws[index % self.draws.len()]) }
    }
}

/// As many gains of each process, altogether at least `count`; the random numbers are those of the processes from `first` on.
fn gains(of_each: &[Joint], count: usize, seed: u64, batch: usize, first: u128, kept: &Kept) -> Vec<f64> {
    let per_process = count.div_ceil(of_each.len().max(1));
    let tasks: Vec<_> = of_each.iter().enumerate().zip(first..).collect();
    tasks
        .into_par_iter()
        .flat_map_iter(|((place, joint), process)| {
            let mut rng = stream(seed, Purpose::Certificate, batch);
            rng.set_word_pos(process << 40);
            let draws = joint.draws(per_process, &mut rng).into_iter().enumerate();
            draws.map(move |(index, draw)| gain(&draw, kept.draw(place * per_process + index)))
        })
        .collect()
}

/// What the best of the cells is better by than the first, of those that keep to their bounds.
fn gain(draw: &[f64], kept: Option<&[bool]>) -> f64 {
    let best = match kept {
        None => draw.iter().copied().fold(f64::INFINITY, f64::min),
        Some(kept) => draw.iter().zip(kept).filter(|(_, kept)| **kept).map(|(value, _)| *value).fold(draw[0], f64::min),
    };
    draw[0] - best
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn draws() -> impl Strategy<Value = Draws> {
        let sample = || prop::collection::vec(0.0..1.0_f64, 1..200);
        (sample(), sample(), 1_usize..200, 1_usize..50, 0.0..3.0_f64).prop_map(
            |(believed, doubted, n_readings, n_terms, spread)| {
                let trust = Trust::after(n_readings, n_terms);
                let all = Gains::of(vec![(believed.clone(), 1.0 - trust.doubt), (doubted, trust.doubt)]);
                Draws { believed: Gains::of(vec![(believed, 1.0)]), all, trust, spread }
            },
        )
    }

    proptest! {
        /// Who wants to be surer is promised less, and never more than the surface itself says.
        #[test]
        fn bound_grows_with_the_probability(draws in draws(), p in 0.5..0.99_f64, q in 0.5..0.99_f64) {
            let [low, high] = [p.min(q), p.max(q)].map(|probability| draws.certificate(probability));
            prop_assert!(low.bound <= high.bound && low.quantile <= high.quantile, "{low:?} {high:?}");
            prop_assert!(low.quantile <= low.bound && high.quantile <= high.bound, "{low:?} {high:?}");
        }

        /// As the readings become more the doubt and the allowance fall, toward none, and more may be beyond; never more than fails.
        #[test]
        fn trust_grows_with_the_readings(n_terms in 1_usize..900, n_readings in 1_usize..10_000) {
            let trust = |n| Trust::after(n, n_terms);
            let (now, then) = (trust(n_readings), trust(n_readings + 1));
            prop_assert!(then.doubt <= now.doubt && then.allowance <= now.allowance);
            prop_assert!((0.0..=1.0).contains(&now.doubt) && (1.0..=9.0).contains(&now.allowance));
            prop_assert!(now.beyond <= then.beyond && (0.01..1.0 - USUAL).contains(&now.beyond));
            prop_assert!((now.beyond <= 0.01) == (n_readings <= 4 * n_terms), "{}", now.beyond);
            prop_assert!(then.cap <= now.cap && (1.0..=2.0).contains(&now.cap));
        }
    }

    /// As many draws as asked for of what is known at three places, none below zero, and not all of them zero.
    #[test]
    fn gains_are_drawn_from_what_is_known() {
        let data = surface::Data::new(1, vec![-1.0, -0.2, 0.4, 1.0], vec![1.0, 1.4, 0.7, 2.0]).unwrap();
        let sites = surface::process::Sites::new(&data, None).unwrap();
        let settings = surface::process::SamplerSettings { particles: 4, ..Default::default() };
        let process = surface::process::AveragedProcess::new(sites, &settings).unwrap();
        let joints = process.joint_of_each(&surface::process::Places::new(1, &[-0.6, 0.1, 0.8]).unwrap());
        let found = gains(&joints, 100, 1, 1, 0, &Kept { draws: Vec::new() });
        assert_eq!(found.len(), 100);
        assert!(found.iter().all(|&gain| gain >= 0.0) && found.iter().filter(|&&gain| gain > 0.0).count() > 20);
    }

    /// Of three cells the best of those that keep to their bounds counts, and the first, which is there anyway.
    #[test]
    fn gain_is_over_what_keeps_to_its_bounds() {
        let free = Kept { draws: Vec::new() };
        assert_eq!(free.draw(3), None);
        let kept = Kept { draws: vec![vec![true, false, true], vec![false, false, false]] };
        for (number, expected) in [(0, 0.5), (1, 0.0), (2, 0.5), (3, 0.0)] {
            let found = gain(&[3.0, 1.0, 2.5], kept.draw(number));
            assert!((found - expected).abs() < 1e-15, "draw {number}: {found}");
        }
        assert!((gain(&[3.0, 1.0, 2.5], free.draw(0)) - 2.0).abs() < 1e-15, "nothing is constrained");
    }

    /// As many more readings as make the square of their number as much larger as the bound is too large; one batch less would not do.
    #[test]
    fn further_batches_are_as_many_as_it_takes() {
        for (bound, worth, n, of) in [(8.0, 1.1, 10, 10), (3.0, 0.4, 36, 12), (0.2, 0.19, 7, 8), (1e6, 1.0, 9, 4)] {
            let further = Certificate { probability: 0.9, bound, quantile: 0.0 }.further_batches(worth, n, of);
            let after = |batches: u64| bound * (n as f64 / (n as f64 + (batches as usize * of) as f64)).powi(2);
            assert!(further >= 1 && after(further) <= worth && after(further - 1) > worth, "{further} from {bound}");
        }
        let of = |bound: f64, worth: f64| {
            Certificate { probability: 0.9, bound, quantile: 0.0 }.further_batches(worth, 10, 5)
        };
        assert_eq!((of(1.0, 1.0), of(0.0, 0.0), of(1.0, 0.0)), (0, 0, u64::MAX));
    }

    #[test]
    fn quantile_is_of_the_shares_and_not_of_the_counts() {
        let gains = Gains::of(vec![((1..=9).map(f64::from).collect(), 0.9), (vec![10.0, 20.0], 0.1)]);
        for (level, expected) in [(0.5, 5.0), (0.9, 9.0), (0.95, 10.0), (0.99, 20.0)] {
            let found: f64 = gains.quantile(level);
            assert!((found - expected).abs() < 1e-12, "{level}: {found}");
        }
    }
}
