//! How much better than the recommended design another may be.

use design_space::Cell;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF as _, Normal};
use surface::process::Joint;

use crate::Error;
use crate::pooled::bands::NINE_IN_TEN;
use crate::pooled::knowledge::Knowledge;
use crate::pooled::measurements::Reading;
use crate::pooled::pool::Pool;
use crate::pooled::run_means::{OfMeans, RunMeans};
use crate::pooled::streams::{Purpose, stream};

/// The probability whose shares of the draws are those of [`Trust`]; with another one the share beyond the bound goes in proportion to
/// one less the probability.
const USUAL: f64 = 0.9;
/// Cells on which the response is drawn.
const CELLS: usize = 256;
const DRAWS: usize = 1080;
/// Draws that do not believe the simulation.
const DOUBTED: usize = 360;

/// With no more readings than a quadratic has terms, what is drawn is widened by so many times itself.
const WIDENED: f64 = 6.0;
/// Of readings that crowd, the share that is not counted where they are to tell of the height of wells that the simulation does not
/// have: all of it where the simulation is of no use.
const CROWDING: f64 = 0.3;
/// From so many designs a parameter on, nothing is held beyond what is drawn: twice what is asked of a first sample of a computer
/// experiment (Loeppky, Sacks and Welch, Technometrics 51 (2009) 366), beside a simulation, too: it tells what lies between the
/// readings, but may lack what nobody thought of. A repeat counts half.
const ENOUGH: f64 = 20.0;
/// With fewer, so many times what the readings differ by is held in reserve, times the square of how many times fewer they are, less one.
const RESERVE: f64 = 1.5;
/// Never more.
const MOST_RESERVED: f64 = 2.0;

/// What is known of the readings, whatever they say.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Evidence {
    pub(crate) n_readings: usize,
    /// Designs that were run.
    pub(crate) n_tried: usize,
    /// As many evenly spread readings would leave as much of the box unseen.
    pub(crate) n_even: usize,
    /// Designs of the campaign all of whose experiments failed: none of them is the best.
    pub(crate) n_failed: usize,
    /// Of the designs run, a repeat counting half, those outside of the campaign alone, beyond as many evenly spread ones as leave as much
    /// of the box unseen.
    pub(crate) crowded: f64,
    /// The probability that the simulation is of no use.
    pub(crate) ignored: f64,
    /// All that may be run.
    pub(crate) n_designs: u64,
    /// None has a narrow well, so that those that were never run are like those that were.
    pub(crate) is_smooth: bool,
    pub(crate) n_parameters: usize,
    /// The share of all designs that the best well of the simulation takes, unless the response is known to have one as narrow.
    pub(crate) narrow: Option<f64>,
    /// Terms of a full quadratic.
    pub(crate) n_terms: usize,
}

impl Evidence {
    /// Terms to a reading, at most 1; of the readings that crowd this share is not counted.
    fn scarcity(&self, uncounted: f64) -> f64 {
        // Where every design was run nothing is left that runs which crowd have not seen.
        let n_seeing = if self.never_run() > 0.0 { self.n_even } else { self.n_readings };
        let n_crowded = self.n_readings.saturating_sub(n_seeing) as f64;
        let n_telling = self.n_readings as f64 - (uncounted * n_crowded).round();
        (self.n_terms as f64 / n_telling.max(1.0)).min(1.0)
    }

    /// The share of all designs that were never run.
    pub(crate) fn never_run(&self) -> f64 {
        (1.0 - self.n_tried as f64 / self.n_designs as f64).max(0.0)
    }

    /// The same, as far as these may be unlike those that were.
    fn untried(&self) -> f64 {
        if self.is_smooth { 0.0 } else { self.never_run() }
    }
}

/// As many designs run, where a repeat counts half: it shows no other well, but that what was seen is not the noise. One that failed
/// counts, for no well is there; those that were run outside of the campaign do as far as they do not crowd.
fn designs_counted([n_tried, n_readings, n_failed]: [usize; 3], crowded: f64) -> f64 {
    (0.5 * (n_tried + n_readings) as f64 + n_failed as f64 - crowded).max(1.0)
}

/// So many times what the readings differ by may be missing anyway: a narrow well is as likely to lie where nobody looked.
fn reserve_after(n_designs: f64, enough: f64) -> f64 {
    let too_few = enough / n_designs;
    (RESERVE * (too_few * too_few - 1.0)).clamp(0.0, MOST_RESERVED)
}

/// The number of designs run, a repeat counting half, from which on no more than so many times what the readings differ by is held.
fn enough_for(reserve: f64, enough: f64) -> f64 {
    enough / (1.0 + reserve / RESERVE).sqrt()
}

/// From so many designs on, a repeat counting half, nothing is held: as many a parameter as [`ENOUGH`], and no fewer than would have met a
/// well as narrow as one that the simulation has with a probability of [`USUAL`], had they been evenly spread.
fn enough(n_parameters: usize, narrow: Option<f64>) -> f64 {
    let to_meet = narrow.map_or(0.0, |share| (1.0 - USUAL).ln() / (-share).ln_1p());
    to_meet.max(ENOUGH * n_parameters as f64)
}

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
    /// Doubt and allowance fall as the readings outnumber the terms of a quadratic. A hundredth is beyond up to ten readings to three
    /// terms, and more as there are more, up to three hundredths: what the surface says of itself has then been put to the test.
    fn after(evidence: &Evidence) -> Self {
        let scarcity = evidence.scarcity(evidence.ignored);
        let of_wells = evidence.scarcity(CROWDING + (1.0 - CROWDING) * evidence.ignored);
        Self {
            doubt: scarcity,
            allowance: 1.0 + WIDENED * of_wells * of_wells,
            beyond: 0.01 * (0.3 / scarcity).clamp(1.0, 3.0),
            cap: 1.0 + scarcity,
        }
    }
}

/// "With this probability no design is better than the recommended one by more than `bound`."
///
/// It rests on the measurements, on the simulation as far as these agree with it, and on the response being a polynomial, a
/// corrected simulation or as smooth as the priors of the surface say. What no measurement and no simulation shows, as a well
/// between all of them, it allows for by doubting the simulation and by widening what the surface says of itself, the less the
/// more readings there are. Readings that crowd count for fewer, without a simulation for as many evenly spread ones as would leave
/// the box as far from any. Until twenty designs a parameter were run, or as many as would meet a well that is as narrow as the best one of
/// the simulation, up to twice what the readings differ by is held in reserve, whatever the surface says; and where a run was far better
/// than runs elsewhere say, until it was looked around on all sides, a well twice as deep as was seen, or as deep as half of what they differ by; unless the response is
/// [known](crate::pooled::Settings::smooth) to have no narrow well. Where every design was run, and a quadratic has as many terms, it is
/// Student's bound on the differences of the means of their runs. It is never less than what a measured design is better by that
/// [contradicts](crate::pooled::Assessment::contradiction) the recommendation; and never more than is left down to the
/// [least](crate::pooled::Settings::least) that a response can be, unless a reading is less or contradicts the recommendation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Certificate {
    /// The probability.
    pub probability: f64,
    /// In the unit of the response, at least 0.
    pub bound: f64,
    /// The same as the surface has it, without that allowance: never above the bound.
    pub quantile: f64,
}

/// How the bound is expected to fall with further readings.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Forecast {
    /// The bound of what is drawn alone.
    pub drawn: f64,
    /// The same as the surface has it: the [quantile](Certificate::quantile) of the certificate.
    #[serde(default)]
    pub believed: f64,
    /// What the readings differ by, times the share of designs that were never run; 0 where nothing of it is held in reserve.
    pub spread: f64,
    /// How much better than the recommended design a well may be of which a run found a part, or a design is that was measured and
    /// contradicts the recommendation; 0 where there is neither, or it was looked around.
    #[serde(default)]
    pub found: f64,
    /// What is left down to the least that a response can be, where that is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub most: Option<f64>,
    /// Where the bound is that of the [means of runs](Certificate), how it falls.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub of_means: Option<OfMeans>,
    /// Readings until now.
    pub n_readings: usize,
    /// Designs that they are of.
    pub n_tried: usize,
    /// Designs that failed in every experiment: they are as good as seen.
    #[serde(default)]
    pub n_failed: usize,
    /// As many designs, a repeat counting half, were run outside of the campaign and crowd, so that fewer, evenly spread, would tell as
    /// much: these do not count for the reserve.
    #[serde(default)]
    pub crowded: f64,
    /// Designs that there are.
    pub n_designs: u64,
    /// Readings to a batch.
    pub n_experiments: usize,
    /// Parameters, a choice counting as one.
    pub n_parameters: usize,
    /// The share of all designs that the best well of the simulation takes, if it is so narrow that more designs than usual have to be run
    /// before nothing is held in reserve for one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub narrow: Option<f64>,
}

impl Forecast {
    /// Beyond so many batches there is no forecast: nobody waits for them, and no law holds as far.
    pub const MOST_BATCHES: u64 = 100;

    /// Batches until the bound is expected to be no more than `worth`: 0 if it is no more already, none if it takes more than
    /// [so many](Self::MOST_BATCHES).
    ///
    /// What is drawn is taken to fall as the readings to the power of 2.5, near what it did from batch to batch in the median of the
    /// campaigns of the benchmark, whose page says how often that came true. Where it is the bound of the means of runs, their means stay,
    /// their errors fall as the root of the readings, and the noise is known by then. The reserve falls as it is defined, with as many repeats as there were until now.
    #[must_use]
    pub fn further_batches(&self, worth: f64) -> Option<u64> {
        Some(self.batches_by_the_law(worth)).filter(|batches| *batches <= Self::MOST_BATCHES)
    }

    /// The same until no more than `worth` is left [by the surface alone](Self::by_the_surface), taken to fall as the readings to the power of
    /// 1.5.
    #[must_use]
    pub fn further_batches_by_the_surface(&self, worth: f64) -> Option<u64> {
        if self.by_the_surface() <= worth {
            return Some(0);
        }
        if self.of_means.is_some() {
            return self.further_batches(worth);
        }
        let enough = self.n_readings as f64 * (self.believed / worth).powf(1.0 / POWER_BELIEVED);
        Some(self.batches_from(enough)).filter(|batches| *batches <= Self::MOST_BATCHES)
    }

    /// How much better than the recommended design another may be, as the surface has it; as much as a find may hide, or as a measured design
    /// is better by that contradicts the recommendation. No more than the bound.
    #[must_use]
    pub fn by_the_surface(&self) -> f64 {
        self.believed.max(self.found).min(self.bound())
    }

    /// By how much two designs have to differ for [as many batches](Self::MOST_BATCHES) to tell which is better, with 95 % probability, were
    /// all their runs of these two: less than that no campaign can find.
    #[must_use]
    pub fn told_apart(&self, noise: f64) -> f64 {
        let n_runs = (Self::MOST_BATCHES as f64 * self.n_experiments.max(1) as f64).max(2.0);
        NINE_IN_TEN * noise * (4.0 / n_runs).sqrt()
    }

    /// Batches until the bound is expected to be no more than `worth`, however many.
    fn batches_by_the_law(&self, worth: f64) -> u64 {
        let (reserve, n) = (self.reserve(), self.n_readings as f64);
        if self.bound() <= worth {
            return 0;
        }
        let for_drawn = n * match self.of_means {
            Some(OfMeans { behind, error }) => (error / (worth + behind)).powi(2).max(1.0),
            None => (self.drawn / worth).powf(1.0 / POWER),
        };
        let for_reserve = match reserve > worth {
            true => {
                let enough = enough_for(worth / self.spread, self.enough()).min(self.n_designs as f64);
                enough * n / self.n_counted()
            }
            false => 0.0,
        };
        self.batches_from(for_drawn.max(for_reserve))
    }

    /// Batches, one at least, until there are so many readings.
    fn batches_from(&self, enough: f64) -> u64 {
        let n_batches = (enough - self.n_readings as f64) / self.n_experiments.max(1) as f64;
        // Beyond all integers that is the largest; what was just enough may differ by the last bit.
        (n_batches - 1e-9).ceil().max(1.0) as u64
    }

    /// The number of designs run, a repeat counting half, from which on nothing is held in reserve, if that is what the bound is now.
    #[must_use]
    pub fn reserves_until(&self) -> Option<usize> {
        let enough = at_most(self.enough(), self.n_designs);
        (self.reserve() > self.drawn.max(self.found) && !self.is_for_the_least()).then_some(enough)
    }

    /// The largest of what is drawn, what is held in reserve and what a find may hide; no more than responses leave.
    fn bound(&self) -> f64 {
        self.by_readings().min(self.most.unwrap_or(f64::INFINITY))
    }

    /// The same, whatever responses leave.
    fn by_readings(&self) -> f64 {
        self.drawn.max(self.reserve()).max(self.found)
    }

    /// Whether the bound is what is left down to the least that a response can be.
    #[must_use]
    pub fn is_for_the_least(&self) -> bool {
        self.most.is_some_and(|most| most < self.by_readings())
    }

    /// Whether the bound is what a well may hide of which a run found a part.
    #[must_use]
    pub fn is_for_a_find(&self) -> bool {
        self.found > self.drawn.max(self.reserve()) && !self.is_for_the_least()
    }

    /// Whether anything is held in reserve, be it the bound or less.
    #[must_use]
    pub fn holds_reserve(&self) -> bool {
        self.reserve() > 0.0
    }

    /// In the unit of the response.
    fn reserve(&self) -> f64 {
        self.spread * reserve_after(self.n_counted(), self.enough())
    }

    fn enough(&self) -> f64 {
        enough(self.n_parameters, self.narrow)
    }

    /// Designs run until now, a repeat counting half, with those that failed and without those that crowd.
    #[must_use]
    pub fn n_counted(&self) -> f64 {
        designs_counted([self.n_tried, self.n_readings, self.n_failed], self.crowded)
    }
}

/// From so many designs on, of so many parameters, a repeat counting half, nothing is held in reserve for a narrow well; never more than
/// there are.
pub(crate) fn designs_without_reserve(n_parameters: usize, n_designs: u64) -> usize {
    at_most(enough(n_parameters, None), n_designs)
}

/// A whole number of designs.
fn at_most(enough: f64, n_designs: u64) -> usize {
    (enough.ceil() as usize).min(usize::try_from(n_designs).unwrap_or(usize::MAX))
}

/// By this power of the readings what is drawn falls.
const POWER: f64 = 2.5;
/// By this power what the surface alone says.
const POWER_BELIEVED: f64 = 1.5;

/// What may be gained over the recommended design, drawn from all that is possible.
#[derive(Debug, Clone)]
pub(crate) struct Draws {
    /// As the surface has it.
    believed: Gains,
    /// With the draws that do not believe the simulation.
    all: Gains,
    evidence: Evidence,
    trust: Trust,
    /// What the readings differ by.
    spread: f64,
    /// How much better a well may be of which a part was found.
    found: f64,
    /// How far the recommended design is expected to be above the least that a response can be, and the standard deviation of that.
    above: Option<(f64, f64)>,
    /// How much better a plant may be by what the surface takes for an error, and no plant that was put together again shows to be one.
    of_plants: f64,
    /// The runs of each design, where they say all there is.
    run_means: Option<RunMeans>,
}

impl Draws {
    pub(crate) fn of(
        knowledge: &mut Knowledge<'_, '_>,
        pool: &Pool,
        recommended: Cell,
        readings: &[Reading],
        evidence: Evidence,
        seed: u64,
        batch: usize,
    ) -> Result<Self, Error> {
        let mut order = pool.by_lower_bound(2.0);
        order.truncate(CELLS);
        let mut doubted = match &knowledge.sceptic {
            Some(sceptic) => pool.by_lower_bound_of(&sceptic.marginals(&pool.places)?, 2.0),
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
        let of_each = knowledge.joint_of_each(&places)?;
        let doubts = knowledge.sceptic.as_ref().map(|sceptic| sceptic.joint_of_each(&places));
        let doubts = doubts.transpose()?.unwrap_or_default();
        let trust = Trust::after(&evidence);
        let first = of_each.len() as u128;
        let believed = gains(&of_each, DRAWS, seed, batch, 0, &kept);
        let doubted = gains(&doubts, DOUBTED, seed, batch, first, &kept);
        let all = if doubted.is_empty() {
            Gains::of(vec![(believed.clone(), 1.0)])
        } else {
            Gains::of(vec![(believed.clone(), 1.0 - trust.doubt), (doubted, trust.doubt)])
        };
        Ok(Self {
            believed: Gains::of(vec![(believed, 1.0)]),
            all,
            evidence,
            trust,
            spread: Reading::range(readings),
            found: 0.0,
            above: None,
            of_plants: 0.0,
            run_means: None,
        })
    }

    /// The same where a part was found of a well that may be so much better.
    pub(crate) fn beside(self, found: f64) -> Self {
        Self { found, ..self }
    }

    /// The same where the recommended design is expected to be so far above the least that a response can be, with this deviation.
    pub(crate) fn above_the_least(self, above: Option<(f64, f64)>) -> Self {
        Self { above, ..self }
    }

    /// The same where a plant may be so much better by its own.
    pub(crate) fn with_plants(self, of_plants: f64) -> Self {
        Self { of_plants, ..self }
    }

    /// The same where the runs of each design say all there is.
    pub(crate) fn by_runs(self, run_means: Option<RunMeans>) -> Self {
        Self { run_means, ..self }
    }

    pub(crate) fn certificate(&self, probability: f64) -> Certificate {
        let forecast = self.forecast(probability, 0);
        let bound = forecast.bound();
        Certificate { probability, bound, quantile: forecast.believed.min(bound) }
    }

    /// The bound of what is drawn alone; where the runs of each design say all there is, of these.
    fn drawn(&self, probability: f64) -> f64 {
        if let Some(run_means) = &self.run_means {
            return run_means.bound(probability).max(self.believed.quantile(probability));
        }
        let sure = 1.0 - self.trust.beyond * (1.0 - probability) / (1.0 - USUAL);
        let (quantile, drawn) = (self.believed.quantile(probability), self.all.quantile(sure));
        (self.trust.allowance * drawn).min(self.trust.cap * self.spread).max(drawn).max(quantile) + self.of_plants
    }

    /// With so many experiments to a batch.
    pub(crate) fn forecast(&self, probability: f64, n_experiments: usize) -> Forecast {
        let Evidence { n_readings, n_tried, n_failed, crowded, n_parameters, n_designs, narrow, .. } = self.evidence;
        let narrow = narrow.filter(|_| enough(n_parameters, narrow) > enough(n_parameters, None));
        let drawn = self.drawn(probability);
        let spread = self.evidence.untried() * self.spread;
        let Self { found, above, trust, .. } = *self;
        // As little is believed of where the recommended design is as of what is drawn.
        let sure = trust.allowance * Normal::standard().inverse_cdf(probability);
        let most = above.map(|(above, deviation)| (above + sure * deviation).max(0.0));
        let of_means = self.run_means.as_ref().map(|run_means| run_means.of_means(probability));
        Forecast {
            drawn,
            believed: self.believed.quantile(probability),
            spread,
            found,
            most,
            of_means,
            n_readings,
            n_tried,
            n_failed,
            crowded,
            n_designs,
            n_experiments,
            n_parameters,
            narrow,
        }
    }
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
            // Neighbors come from different processes, so that each meets each of the cost.
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

    fn counted(evidence: &Evidence) -> f64 {
        designs_counted([evidence.n_tried, evidence.n_readings, evidence.n_failed], evidence.crowded)
    }

    fn reserve(evidence: &Evidence) -> f64 {
        evidence.untried() * reserve_after(counted(evidence), enough(evidence.n_parameters, evidence.narrow))
    }

    fn evidence() -> impl Strategy<Value = Evidence> {
        let counts = (1_usize..10_000).prop_flat_map(|n_readings| (Just(n_readings), 1..=n_readings, 1..=n_readings));
        let narrow = prop_oneof![Just(None), (1e-4..0.5_f64).prop_map(Some)];
        let unlike = (0_usize..20, 0.0..1.0_f64);
        (counts, unlike, 0.0..=1.0_f64, 0_u64..20_000, any::<bool>(), 1_usize..9, narrow).prop_map(
            |((n_readings, n_even, n_tried), (n_failed, crowded), ignored, more, is_smooth, n_parameters, narrow)| {
                Evidence {
                    n_readings,
                    n_tried,
                    n_even,
                    n_failed,
                    crowded: crowded * n_tried as f64,
                    ignored,
                    n_designs: n_tried as u64 + 1 + more,
                    is_smooth,
                    n_parameters,
                    narrow,
                    n_terms: (n_parameters + 1) * (n_parameters + 2) / 2,
                }
            },
        )
    }

    fn draws() -> impl Strategy<Value = Draws> {
        let sample = || prop::collection::vec(0.0..1.0_f64, 1..200);
        let found = prop_oneof![Just(0.0), 0.0..3.0_f64];
        (sample(), sample(), evidence(), 0.0..3.0_f64, found).prop_map(
            |(believed, doubted, evidence, spread, found)| {
                let trust = Trust::after(&evidence);
                let all = Gains::of(vec![(believed.clone(), 1.0 - trust.doubt), (doubted, trust.doubt)]);
                Draws {
                    believed: Gains::of(vec![(believed, 1.0)]),
                    all,
                    evidence,
                    trust,
                    spread,
                    found,
                    above: None,
                    of_plants: 0.0,
                    run_means: None,
                }
            },
        )
    }

    proptest! {
        /// What is left down to the least that a response can be cuts the bound, and changes nothing where it is more.
        #[test]
        fn bound_is_no_more_than_responses_leave(draws in draws(), most in 0.0..6.0_f64, p in 0.5..0.99_f64) {
            let (free, cut) = (draws.certificate(p), draws.clone().above_the_least(Some((most, 0.0))).certificate(p));
            prop_assert!((cut.bound - free.bound.min(most)).abs() <= 0.0 && cut.quantile <= cut.bound, "{free:?} {cut:?}");
            let wider = draws.clone().above_the_least(Some((most, 0.1))).certificate(p);
            prop_assert!(wider.bound >= cut.bound, "the less that is known of it: {wider:?} {cut:?}");
            let forecast = draws.above_the_least(Some((most, 0.0))).forecast(p, 4);
            prop_assert_eq!(forecast.is_for_the_least(), most < free.bound);
            prop_assert!(!forecast.is_for_the_least() || (!forecast.is_for_a_find() && forecast.reserves_until().is_none()));
            prop_assert_eq!(forecast.further_batches(most), Some(0));
        }

        /// Who wants to be surer is promised less, and never more than the surface itself says.
        #[test]
        fn bound_grows_with_the_probability(draws in draws(), p in 0.5..0.99_f64, q in 0.5..0.99_f64) {
            let [low, high] = [p.min(q), p.max(q)].map(|probability| draws.certificate(probability));
            prop_assert!(low.bound <= high.bound && low.quantile <= high.quantile, "{low:?} {high:?}");
            prop_assert!(low.quantile <= low.bound && high.quantile <= high.bound, "{low:?} {high:?}");
        }

        /// As the readings become more the doubt and the allowance fall, toward none, and more may be beyond; never more than fails.
        #[test]
        fn trust_grows_with_the_readings(evidence in evidence()) {
            let one_more = Evidence {
                n_readings: evidence.n_readings + 1,
                n_tried: evidence.n_tried + 1,
                n_even: evidence.n_even + 1,
                ..evidence
            };
            let held = reserve(&evidence);
            let again = Evidence { n_readings: evidence.n_readings + 1, ..evidence };
            prop_assert!(reserve(&again) <= held && reserve(&again) >= reserve(&one_more), "a repeat counts less");
            let (now, then) = (Trust::after(&evidence), Trust::after(&one_more));
            prop_assert!(reserve(&one_more) <= held && (0.0..=2.0).contains(&held), "{held}");
            prop_assert!(then.doubt <= now.doubt && then.allowance <= now.allowance);
            prop_assert!((0.0..=1.0).contains(&now.doubt) && (1.0..=1.0 + WIDENED).contains(&now.allowance));
            prop_assert!(now.beyond <= then.beyond && (0.01..1.0 - USUAL).contains(&now.beyond));
            prop_assert!((now.beyond <= 0.01) == (now.doubt >= 0.3), "{now:?}");
            prop_assert!(then.cap <= now.cap && (1.0..=2.0).contains(&now.cap));
        }

        /// The same readings are trusted the less the more of them crowd, and the likelier the simulation is of no use.
        #[test]
        fn readings_that_crowd_tell_less(evidence in evidence(), share in 0.0..=1.0_f64) {
            let crowded = Evidence { n_even: (share * evidence.n_even as f64) as usize, ..evidence };
            let useless = Evidence { ignored: evidence.ignored + share * (1.0 - evidence.ignored), ..evidence };
            let here = Trust::after(&evidence);
            for less in [crowded, useless] {
                prop_assert!(reserve(&less) >= reserve(&evidence));
                let less = Trust::after(&less);
                prop_assert!(less.doubt >= here.doubt && less.allowance >= here.allowance);
                prop_assert!(less.beyond <= here.beyond && less.cap >= here.cap, "{less:?} {here:?}");
            }
        }

        /// By the surface alone no more is left than the bound has, and no less than it is sure of or than a find may hide; it is foretold that
        /// nothing is to be waited for where that is enough, and sooner than for the bound where it is not.
        #[test]
        fn surface_alone_says_no_more_than_the_bound(draws in draws(), worth in 0.001..3.0_f64) {
            let (certificate, forecast) = (draws.certificate(0.9), draws.forecast(0.9, 12));
            let alone = forecast.by_the_surface();
            prop_assert!(alone <= certificate.bound && alone >= certificate.quantile, "{:?} {:?}", certificate, forecast);
            prop_assert!(alone >= forecast.found.min(certificate.bound), "{:?} {:?}", certificate, forecast);
            prop_assert_eq!(alone <= worth, forecast.further_batches_by_the_surface(worth) == Some(0), "{:?} {:?}", certificate, forecast);
        }

        /// What the certificate says and what its forecast starts from are the same.
        #[test]
        fn forecast_starts_from_the_certificate(draws in draws(), worth in 0.001..3.0_f64) {
            let (certificate, forecast) = (draws.certificate(0.9), draws.forecast(0.9, 12));
            prop_assert_eq!(certificate.bound <= worth, forecast.further_batches(worth) == Some(0), "{:?} {:?}", certificate, forecast);
            let is_reserved = certificate.bound > forecast.drawn.max(forecast.found);
            prop_assert_eq!(is_reserved, forecast.reserves_until().is_some(), "{:?} {:?}", certificate, forecast);
            prop_assert!(certificate.bound >= forecast.found && (!forecast.is_for_a_find() || certificate.bound <= forecast.found));
        }
    }

    /// By hand, with two parameters: nothing is held from 40 designs on, nine sixteenths of one and a half times the spread after 32, twice
    /// the spread up to 26; less by the share of designs that were run; whatever a simulation says.
    #[test]
    fn narrow_wells_are_allowed_for_until_twenty_designs_a_parameter_were_run() {
        let evidence = |n_readings, n_tried, ignored, n_designs| {
            let (n_parameters, n_terms, narrow) = (2, 6, None);
            Evidence {
                n_readings,
                n_tried,
                n_even: 1,
                n_failed: 0,
                crowded: 0.0,
                ignored,
                n_designs,
                is_smooth: false,
                n_parameters,
                narrow,
                n_terms,
            }
        };
        let reserve = |n_tried: usize, untried: f64| {
            // As many more as leave this share untried.
            let n_designs = (n_tried as f64 / (1.0 - untried)).round() as u64;
            let held = |ignored: f64| reserve(&evidence(n_tried, n_tried, ignored, n_designs));
            assert!((held(0.0) - held(1.0)).abs() <= 0.0);
            held(1.0) / evidence(1, n_tried, 1.0, n_designs).untried() * untried
        };
        // Of three designs that are run twice four are counted and a half.
        let thrice = evidence(6, 3, 1.0, 100);
        assert!((counted(&thrice) - 4.5).abs() < 1e-12);
        // Two more that failed are seen; one of three that crowd is not.
        assert!((counted(&Evidence { n_failed: 2, ..thrice }) - 6.5).abs() < 1e-12);
        assert!((counted(&Evidence { crowded: 1.0, ..thrice }) - 3.5).abs() < 1e-12);
        assert!((evidence(6, 25, 1.0, 100).untried() - 0.75).abs() < 1e-12);
        assert!(Evidence { is_smooth: true, ..evidence(6, 3, 1.0, 100) }.untried().abs() < 1e-12);
        for (n_tried, held) in [
            (4, 2.0),
            (26, 2.0),
            (27, 1.792_181_069_958_848),
            (32, 0.843_75),
            (36, 0.351_851_851_851_852),
            (40, 0.0),
            (400, 0.0),
        ] {
            for untried in [0.9, 0.4] {
                assert!((reserve(n_tried, untried) - untried * held).abs() < 1e-12, "{n_tried}");
            }
        }
    }

    /// As many draws as asked for of what is known at three places, none below zero, and not all of them zero.
    #[test]
    fn gains_are_drawn_from_what_is_known() {
        let data = surface::Data::new(1, vec![-1.0, -0.2, 0.4, 1.0], vec![1.0, 1.4, 0.7, 2.0]).unwrap();
        let sites = surface::process::Sites::new(&data, None).unwrap();
        let settings = surface::process::SamplerSettings { particles: 4, ..Default::default() };
        let process = surface::process::AveragedProcess::new(sites, &settings).unwrap();
        let joints = process.joint_of_each(&surface::process::Places::new(1, &[-0.6, 0.1, 0.8]).unwrap()).unwrap();
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

    /// As many more readings as the law takes, for what is drawn and for the reserve; one batch less would not do.
    #[test]
    fn further_batches_are_as_many_as_it_takes() {
        let plain = Forecast {
            drawn: 0.0,
            believed: 0.0,
            spread: 0.0,
            found: 0.0,
            most: None,
            of_means: None,
            n_readings: 10,
            n_tried: 10,
            n_failed: 0,
            crowded: 0.0,
            n_designs: 10_000,
            n_experiments: 5,
            n_parameters: 2,
            narrow: None,
        };
        // By the power of 1.5: from 8 to 1 takes four times the readings.
        let believed = Forecast { believed: 8.0, drawn: 9.0, ..plain };
        assert_eq!(
            [0.999, 1.0, 7.9, 8.0].map(|worth| believed.further_batches_by_the_surface(worth)),
            [7, 6, 1, 0].map(Some)
        );
        assert_eq!(Forecast { drawn: 9.0, found: 8.5, ..believed }.further_batches_by_the_surface(8.0), Some(1));
        for (drawn, spread, worth, n, n_tried, of) in [
            (8.0, 0.0, 1.1, 10, 10, 10),
            (3.0, 0.0, 0.4, 36, 36, 12),
            (0.2, 0.0, 0.19, 7, 7, 8),
            (1e6, 0.0, 1.0, 9, 9, 4),
            (0.1, 3.0, 0.4, 12, 12, 12),
            (0.1, 3.0, 0.4, 24, 12, 12),
            (0.1, 0.7, 0.01, 24, 20, 5),
            (0.1, 0.7, 0.3, 24, 24, 5),
            (0.5, 0.01, 0.012, 24, 24, 5),
            (0.5, 0.1, 0.49, 10, 10, 1),
        ] {
            let forecast = Forecast { drawn, spread, n_readings: n, n_tried, n_experiments: of, ..plain };
            let further = forecast.batches_by_the_law(worth);
            let after = |batches: u64| {
                let later = n as f64 + (batches as usize * of) as f64;
                let tried = later * 0.5 * (n_tried + n) as f64 / n as f64;
                let held = (2400.0 / (tried * tried) - 1.5).clamp(0.0, 2.0);
                (drawn * (n as f64 / later).powf(2.5)).max(spread * held)
            };
            let worth = worth * (1.0 + 1e-12);
            assert!(further >= 1 && after(further) <= worth && after(further - 1) > worth, "{forecast:?}: {further}");
            // What was found and not looked around is looked around with the next batch.
            let found = Forecast { found: 2.0 * worth, ..forecast };
            assert_eq!(
                [found.batches_by_the_law(worth), found.batches_by_the_law(2.0 * worth)],
                [further, forecast.batches_by_the_law(2.0 * worth)]
            );
            let found = Forecast { drawn: 0.0, spread: 0.0, ..found };
            assert_eq!([found.batches_by_the_law(worth), found.batches_by_the_law(2.1 * worth)], [1, 0]);
        }
        let of = |drawn: f64, worth: f64| Forecast { drawn, n_designs: 100, ..plain }.batches_by_the_law(worth);
        assert_eq!((of(1.0, 1.0), of(0.0, 0.0), of(1.0, 0.0)), (0, 0, u64::MAX));
        // The bound of means of runs, by hand: 0.6 = 0.8 - 0.2 is 0.2 after four times as many runs, 30 more, and 0.3 after 2.56 times as many.
        let of_means = Some(OfMeans { behind: 0.2, error: 0.8 });
        let forecast = Forecast { drawn: 0.6, of_means, n_tried: 3, n_designs: 3, n_parameters: 1, ..plain };
        assert_eq!([0.2, 0.3, 0.6].map(|worth| forecast.batches_by_the_law(worth)), [6, 4, 0]);
        // That of few is wide because the noise is not known.
        let of_means = Some(OfMeans { behind: 0.2, error: 0.45 });
        assert_eq!([0.2, 0.3].map(|worth| Forecast { of_means, ..forecast }.batches_by_the_law(worth)), [1, 1]);
        // Beyond a hundred there is no forecast: 10 readings in batches of 5 have to become 510 at most, 51 to the power of 2.5 times as sure.
        let forecast = Forecast { drawn: 51_f64.powf(2.5), ..plain };
        assert_eq!([1.001, 0.999].map(|worth| forecast.further_batches(worth)), [Some(100), None]);
        assert_eq!([forecast.drawn, 0.0].map(|worth| forecast.further_batches(worth)), [Some(0), None]);
        // 500 runs, half of them of each of two designs: both means are known to 3 / sqrt(250).
        assert!((forecast.told_apart(3.0) - 1.645 * 3.0 * (2.0 / 250.0_f64).sqrt()).abs() < 1e-9);
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
