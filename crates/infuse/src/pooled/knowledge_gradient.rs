//! Which experiments teach most about the lowest response: a joint knowledge gradient, one pick after the other.

use design_space::Cell;
use rayon::prelude::*;
use statrs::distribution::{ContinuousCDF, Normal};
use surface::process::Joint;

use crate::Error;
use crate::pooled::admission::{Admission, Step};
use crate::pooled::coverage::Coverage;
use crate::pooled::economy::Economy;
use crate::pooled::held::FEASIBLE;
use crate::pooled::knowledge::Knowledge;
use crate::pooled::outcomes::{OUTCOMES, outcomes};
use crate::pooled::pool::Pool;
use crate::pooled::reason::{Pick, Reason};

/// One pick in so many, and at least one of a batch of so many, is for the one who does not believe the simulation. With one in eight
/// wells that the simulation lacks are found later, with one in four more of the best is missed elsewhere.
const DOUBTED: usize = 6;
/// One in so many while there are fewer readings than for two batches: nothing has been seen yet of where the simulation misleads.
const DOUBTED_AT_FIRST: usize = 2;
const FEWEST: usize = 4;
/// Without a simulation one pick in so many, and nearly half of the batch after the first, goes to where no run is near: so campaigns
/// on two wells, the deeper one narrow, stop after fewer batches and hardly ever at the wrong one. Beside a simulation as many of one
/// in so many as it is likely to be of no use: the more, if at all, the less it points to.
const COVERING: usize = 4;
/// Beside a simulation a run that is expected to lower the response by no more than so much of what the designs differ by is made where
/// no run is near instead, as many of a batch as one in [`COVERING`]. A surface that is sure of the best would measure it again and
/// again, and leave a well that the simulation lacks to be found by nobody.
const NEGLIGIBLE: f64 = 5e-4;
/// The same for any number of a batch, with a simulation or without, where the noise of a run is no more than [`QUIET`] of that: repeats
/// would then teach nothing. Where it is larger they are what tells the best from the next best, each by next to nothing.
const NOTHING: f64 = 2e-4;
const QUIET: f64 = 0.02;

/// Of a batch no more than one run in so many is made where it is more likely to fail than not: what nothing is known of seems
/// endless, and could otherwise swallow all of it.
const RISKED: usize = 4;
/// Below this a run is more likely to fail.
const RISKY: f64 = 0.5;

/// Picks `count` cells of the pool, repeats allowed: each makes the expected minimum of the mean after the batch as low as a
/// single pick can, those before it and the pending experiments counted in. A cell where experiments may fail counts as much
/// less as they are likely to (Frazier et al. 2009; Wu and Frazier 2016 for batches). The last picks, as many as [`Shares`] says,
/// go to where the sceptic sees least of what may still be best, so that a simulation that misleads is found out sooner, and to where
/// most of the box is far from any run, as nothing else would find a well that is narrower than the surface expects. So do those that
/// would gain next to nothing.
///
/// Where responses have to stay within bounds, a design is worth its mean as far as it is likely to keep to them, and the highest
/// mean of all otherwise; so a run is worth what it teaches of either (Ungredda and Branke 2024).
///
/// # Errors
///
/// [`Error::Surface`] if a constrained response cannot be evaluated.
pub(crate) fn pick(
    knowledge: &Knowledge<'_, '_>,
    pool: &Pool,
    coverage: &Coverage,
    pending: &[Cell],
    count: usize,
    scramble: u32,
    mut economy: Economy<'_>,
) -> Result<Vec<Pick>, Error> {
    let noise = knowledge.reading_variance();
    let mut believed = Gradient::of(&knowledge.joint_of_each(&pool.places)?, pool, noise);
    believed.admissions = admissions(knowledge, pool, scramble)?;
    let doubted = knowledge.sceptic.as_ref().map(|sceptic| {
        let noise = sceptic.noise().powi(2) + sceptic.assembly_deviation().powi(2);
        let joints = sceptic.joint_of_each(&pool.places)?;
        Ok::<_, Error>(Gradient { least_feasible: FEASIBLE, ..Gradient::of(&joints, pool, noise) })
    });
    let mut doubted = doubted.transpose()?;
    let pending: Vec<usize> =
        pending.iter().filter_map(|cell| pool.cells.iter().position(|candidate| candidate == cell)).collect();
    let sites = knowledge.process.sites();
    let is_early = sites.places().n_places() + sites.n_repeats() < 2 * count;
    let shares = Shares::of(count, is_early, knowledge.is_simulated().then(|| knowledge.ignored()));
    let coded = pool.cells.iter().map(|&cell| knowledge.designs.coded_of(cell)).collect::<Result<Vec<_>, _>>()?;
    let mut coverage = coverage.clone();
    let (mut picks, mut cells) = (Vec::with_capacity(count), Vec::with_capacity(count));
    let (mut n_risked, mut n_spared) = (0, 0);
    let is_quiet = noise.sqrt() <= QUIET * believed.range();
    for step in 0..pending.len() + count {
        let normals = outcomes(step as u32, scramble);
        let (row, reason) = match (pending.get(step), &doubted) {
            (Some(&row), _) => (row, Reason::Gain),
            (None, Some(doubted)) if cells.len() >= count - shares.covering => {
                (doubted.widest(&coverage, &coded, &economy), Reason::Coverage)
            }
            (None, Some(doubted)) if cells.len() >= count - shares.doubted => {
                // Beside a simulation each of his picks is another design.
                let picked = if knowledge.is_simulated() { &cells[..] } else { &[] };
                (doubted.clearest(&economy, picked), Reason::Doubt)
            }
            (None, doubted) => {
                let (row, gain) = believed.most_telling(&normals, step as u32, &economy);
                match doubted {
                    Some(doubted) if gain <= shares.least_gain(n_spared, is_quiet) * believed.range() => {
                        n_spared += 1;
                        (doubted.widest(&coverage, &coded, &economy), Reason::Coverage)
                    }
                    _ if gain <= NEGLIGIBLE * believed.range() => (row, Reason::Little),
                    _ => (row, Reason::Gain),
                }
            }
        };
        if step >= pending.len() {
            picks.push(Pick { cell: pool.cells[row], reason });
            cells.push(pool.cells[row]);
            economy.take(pool.cells[row]);
            n_risked += usize::from(pool.chances.responding[row] < RISKY);
            if n_risked >= (count / RISKED).max(1) {
                believed.least_feasible = RISKY;
            }
        }
        coverage.add(&coded[row]);
        believed.measure(row, &normals, step as u32);
        if let Some(doubted) = &mut doubted {
            doubted.measure(row, &normals, step as u32);
        }
    }
    Ok(picks)
}

/// How many of a batch are for the one who does not believe the simulation.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Shares {
    /// All of these.
    doubted: usize,
    /// Those of them that go to where no run is near.
    covering: usize,
    /// As many of the others do so where they would gain next to nothing, and where there is little noise any number that would gain
    /// even less; none where none do so.
    spared: Option<usize>,
}

impl Shares {
    /// As a share of what the designs differ by: what gains no more is made where no run is near, after so many that were.
    fn least_gain(&self, n_spared: usize, is_quiet: bool) -> f64 {
        match self.spared {
            Some(spared) if n_spared < spared => NEGLIGIBLE,
            Some(_) if is_quiet => NOTHING,
            _ => f64::NEG_INFINITY,
        }
    }

    /// Of a batch of so many, with the probability that the simulation is of no use, if there is one.
    fn of(count: usize, is_early: bool, ignored: Option<f64>) -> Self {
        if count < FEWEST {
            return Self { doubted: 0, covering: 0, spared: None };
        }
        let doubted = (count / if is_early { DOUBTED_AT_FIRST } else { DOUBTED }).max(1);
        match ignored {
            Some(ignored) => {
                let covering = ((count / COVERING) as f64 * ignored).round() as usize;
                Self { doubted: doubted.max(covering + covering.min(1)), covering, spared: Some(count / COVERING) }
            }
            None => {
                let doubted = doubted.max(count / COVERING + 1);
                Self { doubted, covering: doubted - 1, spared: Some(0) }
            }
        }
    }
}

/// What is known of each constrained response that was measured.
fn admissions(knowledge: &Knowledge<'_, '_>, pool: &Pool, scramble: u32) -> Result<Vec<Admission>, Error> {
    let joints = knowledge.constrained_joints(&pool.cells)?;
    let known = knowledge.held.iter().zip(joints).zip(0..);
    let known = known.filter_map(|((held, joint), number)| {
        Some(Admission::of(&held.constraint, Joint::of_mixture(&joint?), held.noise()?, number, scramble))
    });
    Ok(known.collect())
}

/// What one surface says of the pool, and how it may turn out after the picks so far.
struct Gradient<'a> {
    pool: &'a Pool,
    joint: Joint,
    noise: f64,
    /// Means of each outcome; infinite where a design may not be recommended, because it is not likely enough to give a response.
    futures: Vec<Vec<f64>>,
    /// Means of each outcome where it gives one; none where all may be recommended.
    hoped: Vec<Vec<f64>>,
    /// Cells that are less likely to give a response are not picked.
    least_feasible: f64,
    /// The responses that have to stay within bounds.
    admissions: Vec<Admission>,
}

impl<'a> Gradient<'a> {
    fn of(of_each: &[Joint], pool: &'a Pool, noise: f64) -> Self {
        let joint = Joint::of_mixture(of_each);
        // A cell that cannot be recommended before an experiment gave a response there is not the lowest.
        let means = joint.means().to_vec();
        let is_sure = |feasible: &f64| *feasible >= FEASIBLE;
        let sure = pool.chances.responding.iter().filter(|feasible| is_sure(feasible)).count();
        let (mut now, mut hoped) = (means.clone(), Vec::new());
        if (1..means.len()).contains(&sure) {
            let unsure = now.iter_mut().zip(&pool.chances.responding).filter(|(_, feasible)| !is_sure(feasible));
            unsure.for_each(|(mean, _)| *mean = f64::INFINITY);
            hoped = vec![means; OUTCOMES as usize];
        }
        let futures = vec![now; OUTCOMES as usize];
        Self { pool, joint, noise, futures, hoped, least_feasible: 0.0, admissions: Vec::new() }
    }

    /// An experiment at this row, as it may turn out.
    fn measure(&mut self, row: usize, normals: &[f64], number: u32) {
        let effect = self.joint.effect(row, self.noise);
        for means in [&mut self.futures, &mut self.hoped] {
            for (future, z) in means.iter_mut().zip(normals) {
                future.iter_mut().zip(&effect).for_each(|(value, effect)| *value += z * effect);
            }
        }
        // What the batch goes on with is that it gave a response.
        for (future, hoped) in self.futures.iter_mut().zip(&self.hoped) {
            future[row] = hoped[row];
        }
        self.joint.measure(&effect);
        for admission in &mut self.admissions {
            let step = admission.step(row, number);
            admission.measure(&step);
        }
    }

    /// How much what is learnt at a row counts: as it is likely to give a response, and per cost.
    fn weight(&self, row: usize, economy: &Economy<'_>) -> f64 {
        let feasible = self.pool.chances.responding[row];
        if feasible < self.least_feasible { 0.0 } else { feasible * economy.weight(self.pool.cells[row]) }
    }

    /// Whether an experiment may give a response there, and whether the plants of the batch allow it: where nothing is left to learn,
    /// all rows are worth the same, but one that was refused or only ever failed is not picked.
    fn allows(&self, row: usize, economy: &Economy<'_>) -> (bool, bool) {
        (self.pool.chances.responding[row] > 0.0, economy.allows(self.pool.cells[row]))
    }

    /// The row after which least is uncertain where the best may still be: what an experiment takes from the variances of all rows,
    /// each counted as it is likely to be better than the best (targeted integrated error, Picheny et al. 2010); one that was not
    /// picked, if there is any.
    fn clearest(&self, economy: &Economy<'_>, picked: &[Cell]) -> usize {
        let n = self.pool.cells.len();
        let means = self.joint.means();
        let best = means.iter().copied().fold(f64::INFINITY, f64::min);
        let normal = Normal::standard();
        let better = |row: usize| {
            let sd = self.joint.variance(row).max(0.0).sqrt();
            let share = if sd > 0.0 { normal.cdf((best - means[row]) / sd) } else { 0.0 };
            share * self.pool.chances.within[row]
        };
        let shares: Vec<f64> = (0..n).map(better).collect();
        let learnt = |row: usize| {
            let effect = self.joint.effect(row, self.noise);
            self.weight(row, economy)
                * effect.iter().zip(&shares).map(|(effect, share)| effect * effect * share).sum::<f64>()
        };
        let learnt: Vec<f64> = (0..n).into_par_iter().map(learnt).collect();
        let allowed = |row: usize| (self.allows(row, economy), !picked.contains(&self.pool.cells[row]));
        let order =
            |&a: &usize, &b: &usize| allowed(a).cmp(&allowed(b)).then(learnt[a].total_cmp(&learnt[b])).then(b.cmp(&a));
        (0..n).max_by(order).unwrap_or(0)
    }

    /// The row that brings most of the box nearer to a run.
    fn widest(&self, coverage: &Coverage, coded: &[Vec<f64>], economy: &Economy<'_>) -> usize {
        let n = self.pool.cells.len();
        let gained = |row: usize| self.weight(row, economy) * coverage.gain(&coded[row]);
        let gained: Vec<f64> = (0..n).into_par_iter().map(gained).collect();
        let allowed = |row: usize| self.allows(row, economy);
        let order =
            |&a: &usize, &b: &usize| allowed(a).cmp(&allowed(b)).then(gained[a].total_cmp(&gained[b])).then(b.cmp(&a));
        (0..n).max_by(order).unwrap_or(0)
    }

    /// The highest mean less the lowest.
    fn range(&self) -> f64 {
        self.reserve() - self.joint.means().iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// The row that lowers the expected minimum most for what it costs, and by how much it does; of equals the one that is least
    /// certain, so that nothing to gain still teaches.
    fn most_telling(&self, normals: &[f64], number: u32, economy: &Economy<'_>) -> (usize, f64) {
        let n = self.pool.cells.len();
        let (still, stay): (Vec<f64>, Vec<Step>) =
            (vec![0.0; n], self.admissions.iter().map(Admission::stay).collect());
        let bounded = self.bounded(&stay);
        let now = self.lowest_of_each(&still, normals, &stay, &bounded, None);
        let gain = |row: usize| {
            let effect = self.joint.effect(row, self.noise);
            let steps: Vec<Step> = self.admissions.iter().map(|admission| admission.step(row, number)).collect();
            let then = self.lowest_of_each(&effect, normals, &steps, &bounded, Some(row));
            (now - then).max(0.0)
        };
        let gains: Vec<f64> = (0..n).into_par_iter().map(gain).collect();
        let uncertain = |row: usize| self.weight(row, economy) * self.joint.variance(row);
        let allowed = |row: usize| self.allows(row, economy);
        let order = |&a: &usize, &b: &usize| {
            let gain = || (self.weight(a, economy) * gains[a]).total_cmp(&(self.weight(b, economy) * gains[b]));
            allowed(a).cmp(&allowed(b)).then_with(gain).then(uncertain(a).total_cmp(&uncertain(b))).then(b.cmp(&a))
        };
        let row = (0..n).max_by(order).unwrap_or(0);
        (row, self.pool.chances.responding[row] * gains[row] / f64::from(OUTCOMES))
    }
}

impl Gradient<'_> {
    /// The highest mean: worth as much as a design that breaks a bound.
    fn reserve(&self) -> f64 {
        self.joint.means().iter().copied().fold(f64::NEG_INFINITY, f64::max)
    }

    /// What a design of this mean is worth where it has to keep to bounds.
    fn worth(&self, row: usize, mean: f64, steps: &[Step], outcome: usize, reserve: f64) -> f64 {
        let of_each = self.admissions.iter().zip(steps);
        let chance: f64 = of_each.map(|(admission, step)| admission.chance(row, step, outcome)).product();
        reserve + chance * (mean - reserve)
    }

    /// What is the same for all runs that may be next: the rows in the order of what they are worth in the first outcome as things
    /// stand, none where there is no bound.
    fn bounded(&self, stay: &[Step]) -> Bounded {
        let reserve = self.reserve();
        if self.admissions.is_empty() {
            return Bounded { reserve, promising: Vec::new() };
        }
        let means = self.futures[0].iter().enumerate();
        let worths: Vec<f64> = means.map(|(row, mean)| self.worth(row, mean.min(reserve), stay, 0, reserve)).collect();
        let mut promising: Vec<usize> = (0..worths.len()).collect();
        promising.sort_by(|&a, &b| worths[a].total_cmp(&worths[b]));
        Bounded { reserve, promising }
    }

    /// What the best design is worth after a run of this effect, summed over the outcomes; the row that was run may then be
    /// recommended, as it gave a response.
    fn lowest_of_each(
        &self,
        effect: &[f64],
        normals: &[f64],
        steps: &[Step],
        bounded: &Bounded,
        run: Option<usize>,
    ) -> f64 {
        let hoped = |outcome: usize| run.and_then(|row| Some((row, self.hoped.get(outcome)?[row])));
        if self.admissions.is_empty() {
            let of_outcome = |(outcome, (future, z)): (usize, (&Vec<f64>, &f64))| {
                let all = lowest(future, effect, *z);
                hoped(outcome).map_or(all, |(row, mean)| all.min(mean + z * effect[row]))
            };
            return self.futures.iter().zip(normals).enumerate().map(of_outcome).sum();
        }
        let of_outcome = |(outcome, (future, z)): (usize, (&Vec<f64>, &f64))| {
            let mut best = bounded.reserve;
            if let Some((row, mean)) = hoped(outcome) {
                let mean = (mean + z * effect[row]).min(best);
                best = self.worth(row, mean, steps, outcome, bounded.reserve);
            }
            for &row in &bounded.promising {
                let mean = future[row] + z * effect[row];
                // Even a design that is sure to keep to its bounds is worth no less than its mean.
                if mean < best {
                    best = best.min(self.worth(row, mean, steps, outcome, bounded.reserve));
                }
            }
            best
        };
        self.futures.iter().zip(normals).enumerate().map(of_outcome).sum()
    }
}

/// What helps to find the best design that keeps to its bounds.
struct Bounded {
    reserve: f64,
    /// The rows in the order in which they are looked at: after a good one most need not be weighed.
    promising: Vec<usize>,
}

/// min_j (m_j + z b_j)
fn lowest(means: &[f64], effect: &[f64], z: f64) -> f64 {
    let mut lanes = [f64::INFINITY; 16];
    let (blocks, rest) = means.as_chunks::<16>();
    let (effects, rest_of_effects) = effect.as_chunks::<16>();
    for (block, effects) in blocks.iter().zip(effects) {
        for lane in 0..16 {
            let value = block[lane] + z * effects[lane];
            lanes[lane] = if value < lanes[lane] { value } else { lanes[lane] };
        }
    }
    let rest = rest.iter().zip(rest_of_effects).map(|(mean, effect)| mean + z * effect);
    lanes.into_iter().chain(rest).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pooled::constraint::Constraint;
    use crate::pooled::scene::Scene;

    /// Seven levels of two numbers; the simulation has its lowest response elsewhere.
    fn misled(n: usize, unit: f64) -> Scene {
        with_errors(n, unit, 0.0)
    }

    /// The same, with errors up to so much.
    fn with_errors(n: usize, unit: f64, error: f64) -> Scene {
        let mut scene = Scene::new(&[7, 7]);
        for reading in 0..n as u64 {
            let (x, y) = (reading * 3 % 7, reading * 5 % 7 + reading / 7);
            let (a, b) = (x as f64 / 6.0, y as f64 / 6.0);
            let error = error * (7.0 * reading as f64).sin();
            scene.read(&[x, y], unit * ((a - 0.8).powi(2) + (b - 0.3).powi(2) + error));
        }
        scene
    }

    fn simulation(unit: f64) -> impl FnMut(Cell, &[f64]) -> Result<f64, String> {
        move |_, point| Ok(unit * ((point[0] - 0.1).powi(2) + (point[1] - 0.9).powi(2)))
    }

    /// What is picked: with the sceptic, and without.
    fn picks(scene: &mut Scene, unit: f64, count: usize) -> [Vec<Cell>; 2] {
        let (mut simulate, designs) = (simulation(unit), scene.designs.clone());
        let mut knowledge = scene.knowledge(Some(&mut simulate));
        let pool = Pool::gather(&mut knowledge, 1, 0).unwrap();
        let (economy, coverage) = (|| Economy::of(None, &designs), coverage(&knowledge, &pool));
        let with = Pick::cells(&pick(&knowledge, &pool, &coverage, &[], count, 7, economy()).unwrap());
        knowledge.sceptic = None;
        [with, Pick::cells(&pick(&knowledge, &pool, &coverage, &[], count, 7, economy()).unwrap())]
    }

    fn coverage(knowledge: &Knowledge<'_, '_>, pool: &Pool) -> Coverage {
        let coded = |&cell: &Cell| knowledge.designs.coded_of(cell).unwrap();
        let runs: Vec<Vec<f64>> = knowledge.measured.iter().map(coded).collect();
        Coverage::of(knowledge.designs, pool, &runs.iter().map(Vec::as_slice).collect::<Vec<_>>()).unwrap()
    }

    /// It is as far from the runs and the other picks as a cell that brings the others nearer than any: without a simulation, and with one
    /// that is of no use.
    #[test]
    fn the_last_pick_is_where_no_run_is_near() {
        let mut useless = |cell: Cell, _: &[f64]| Ok(f64::from(u32::try_from(cell.index() * 37 % 11).unwrap()));
        for is_simulated in [true, false] {
            let mut scene = misled(13, 1.0);
            let designs = scene.designs.clone();
            let mut knowledge = scene.knowledge(if is_simulated { Some(&mut useless) } else { None });
            let ignored = knowledge.ignored();
            assert!(if is_simulated { ignored > 0.7 } else { ignored >= 1.0 }, "{ignored}");
            let pool = Pool::gather(&mut knowledge, 1, 0).unwrap();
            let mut coverage = coverage(&knowledge, &pool);
            let picks =
                Pick::cells(&pick(&knowledge, &pool, &coverage, &[], 6, 7, Economy::of(None, &designs)).unwrap());
            let coded = |cell: Cell| designs.coded_of(cell).unwrap();
            picks[..5].iter().for_each(|&cell| coverage.add(&coded(cell)));
            let gained = |cell: Cell| coverage.gain(&coded(cell));
            let most = pool.cells.iter().map(|&cell| gained(cell)).fold(0.0, f64::max);
            assert!((gained(picks[5]) - most).abs() < 1e-12 && most > 0.0, "{} of {most}", gained(picks[5]));
        }
    }

    /// Beside a simulation that is right and readings that say so: all but the sceptic's, who has half of a batch while there are no
    /// readings for two.
    #[test]
    fn what_would_gain_nothing_is_run_where_no_run_is_near() {
        let mut right = |_: Cell, point: &[f64]| Ok((point[0] - 0.8).powi(2) + (point[1] - 0.3).powi(2));
        let mut scene = Scene::new(&[25, 25]);
        for reading in 0..24 {
            let (x, y) = (reading * 7 % 25, reading * 11 % 25);
            let (a, b) = (x as f64 / 24.0, y as f64 / 24.0);
            scene.read(&[x, y], (a - 0.8).powi(2) + (b - 0.3).powi(2) + 0.01 * (7.0 * reading as f64).sin());
        }
        let designs = scene.designs.clone();
        let mut knowledge = scene.knowledge(Some(&mut right));
        let pool = Pool::gather(&mut knowledge, 1, 0).unwrap();
        let before = coverage(&knowledge, &pool);
        // A run wherever most of the box is far from any, as far as this goes on from the first pick.
        let n_widest = |count: usize| {
            let picks =
                Pick::cells(&pick(&knowledge, &pool, &before, &[], count, 7, Economy::of(None, &designs)).unwrap());
            let mut coverage = before.clone();
            let is_widest = |cell: &&Cell| {
                let coded = designs.coded_of(**cell).unwrap();
                let gained = |cell: &Cell| coverage.gain(&designs.coded_of(*cell).unwrap());
                let most = pool.cells.iter().map(gained).fold(0.0, f64::max);
                let is_widest = (coverage.gain(&coded) - most).abs() < 1e-12;
                coverage.add(&coded);
                is_widest
            };
            picks.iter().take_while(is_widest).count()
        };
        assert_eq!([4, 8, 12, 13].map(n_widest), [3, 7, 10, 7]);
    }

    /// A quarter of a batch may gain more than the others, the others go only where there is little noise, and so does what there is
    /// without a simulation.
    #[test]
    fn what_a_run_has_to_gain_falls_after_a_quarter_of_the_batch() {
        let shares = Shares::of(12, true, Some(0.1));
        let at = |n_spared: usize| shares.least_gain(n_spared, true);
        assert!(at(0) >= NEGLIGIBLE && at(2) >= NEGLIGIBLE && at(3) < at(2) && at(3) > 0.0 && at(9) >= at(3));
        assert!(shares.least_gain(2, false) >= NEGLIGIBLE && shares.least_gain(3, false) < 0.0);
        let (alone, few) = (Shares::of(12, false, None), Shares::of(3, false, Some(0.1)));
        assert!(alone.least_gain(0, false) < 0.0 && few.least_gain(0, false) < 0.0 && few.least_gain(5, true) < 0.0);
        assert!((alone.least_gain(0, true) - shares.least_gain(9, true)).abs() < 1e-12);
    }

    /// Never all, none of a few; where no run is near the more, the less the simulation is likely to be of use, and one of the sceptic's
    /// is always where he knows least.
    #[test]
    fn shares_of_a_batch() {
        for (count, is_early, ignored, doubted, covering) in [
            (3, true, Some(1.0), 0, 0),
            (4, false, Some(0.0), 1, 0),
            (4, false, Some(0.6), 2, 1),
            (12, true, Some(0.1), 6, 0),
            (12, true, Some(0.5), 6, 2),
            (12, false, Some(0.0), 2, 0),
            (12, false, Some(0.4), 2, 1),
            (12, false, Some(1.0), 4, 3),
            (3, false, None, 0, 0),
            (12, true, None, 6, 5),
            (12, false, None, 4, 3),
            (18, false, None, 5, 4),
        ] {
            let shares = Shares::of(count, is_early, ignored);
            let spared = (count >= FEWEST).then_some(if ignored.is_none() { 0 } else { count / COVERING });
            assert_eq!(shares, Shares { doubted, covering, spared }, "{count} {is_early} {ignored:?}");
        }
        for count in FEWEST..200 {
            for (is_early, ignored) in
                [(true, Some(1.0)), (true, None), (false, Some(1.0)), (false, None), (false, Some(0.3))]
            {
                let shares = Shares::of(count, is_early, ignored);
                assert!(
                    shares.covering < shares.doubted && shares.doubted + shares.spared.unwrap() < count,
                    "{shares:?}"
                );
            }
        }
    }

    /// As many as are theirs, whether or not there are readings for two batches.
    #[test]
    fn the_last_picks_are_for_the_one_who_does_not_believe_the_simulation() {
        for (n_readings, count) in [(5, 6), (5, 5), (11, 6), (12, 6), (13, 5), (6, 3)] {
            let misled = || with_errors(n_readings, 1.0, 0.05);
            let ignored = misled().knowledge(Some(&mut simulation(1.0))).ignored();
            let shares = Shares::of(count, n_readings < 2 * count, Some(ignored));
            let [with, without] = picks(&mut misled(), 1.0, count);
            let same = with.iter().zip(&without).take_while(|(a, b)| a == b).count();
            assert_eq!(count - same, shares.doubted, "{count} picks after {n_readings} readings");
        }
    }

    /// However little he knows there, a second run of the same batch would not show him another design.
    #[test]
    fn beside_a_simulation_the_sceptic_picks_no_design_of_the_batch_again() {
        for (n_readings, count) in [(5, 6), (5, 24), (11, 12), (12, 12), (12, 24)] {
            let misled = || with_errors(n_readings, 1.0, 0.3);
            let ignored = misled().knowledge(Some(&mut simulation(1.0))).ignored();
            let shares = Shares::of(count, n_readings < 2 * count, Some(ignored));
            let [picks, _] = picks(&mut misled(), 1.0, count);
            for index in count - shares.doubted..count - shares.covering {
                assert!(!picks[..index].contains(&picks[index]), "{count} picks after {n_readings} readings");
            }
        }
    }

    #[test]
    fn a_simulation_that_says_the_same_everywhere_is_as_good_as_none() {
        assert!(misled(12, 1.0).knowledge(None).ignored() >= 1.0);
        let mut constant = |_: Cell, _: &[f64]| Ok(5.0);
        assert!(misled(12, 1.0).knowledge(Some(&mut constant)).ignored() >= 1.0);
        // Of what no quadratic is.
        let wave = |a: f64, b: f64| (9.0 * a).sin() + b;
        let mut scene = Scene::new(&[25, 25]);
        for reading in 0..24 {
            let (x, y) = (reading * 7 % 25, reading * 11 % 25);
            scene.read(&[x, y], wave(x as f64 / 24.0, y as f64 / 24.0));
        }
        let mut right = |_: Cell, point: &[f64]| Ok(wave(point[0], point[1]));
        let ignored = scene.knowledge(Some(&mut right)).ignored();
        assert!(ignored < 0.5, "{ignored}");
    }

    /// A cell that is a little less likely to give a response than one that may be recommended.
    #[test]
    fn the_sceptic_asks_only_where_a_design_may_be_recommended() {
        let (mut scene, mut simulate) = (misled(12, 1.0), simulation(1.0));
        let designs = scene.designs.clone();
        let knowledge = &mut scene.knowledge(Some(&mut simulate));
        let mut pool = Pool::gather(knowledge, 1, 0).unwrap();
        let coverage = coverage(knowledge, &pool);
        let last = |pool: &Pool| {
            let picks = Pick::cells(&pick(knowledge, pool, &coverage, &[], 4, 7, Economy::of(None, &designs)).unwrap());
            picks[3]
        };
        let before = last(&pool);
        let row = pool.cells.iter().position(|cell| *cell == before).unwrap();
        pool.chances.responding.fill(FEASIBLE);
        assert_eq!(last(&pool), before, "all are likely enough");
        pool.chances.responding[row] = FEASIBLE - 1e-9;
        assert_ne!(last(&pool), before);
    }

    /// A pool of some places on a line, and what is known of them.
    fn line(places: &[f64], shift: f64) -> (Pool, Joint) {
        let responses = [1.0, 1.4, 0.7, 2.0].map(|response| response + shift);
        let data = surface::Data::new(1, vec![-1.0, -0.2, 0.4, 1.0], responses.to_vec()).expect("valid data");
        let sites = surface::process::Sites::new(&data, None).expect("valid data");
        let settings = surface::process::SamplerSettings { particles: 4, ..Default::default() };
        let process = surface::process::AveragedProcess::new(sites, &settings).expect("a process");
        let places = surface::process::Places::new(1, places).expect("places");
        let n = places.n_places();
        let chances = crate::pooled::held::Chances {
            responding: vec![1.0; n],
            within: vec![1.0; n],
            suffices: vec![true; n],
            possible: vec![true; n],
        };
        let pool = Pool {
            cells: (0..n as u64).map(Cell::new).collect(),
            marginals: process.marginals(&places).unwrap(),
            chances,
            random: Vec::new(),
            places: places.clone(),
        };
        (pool, process.joint(&places).unwrap())
    }

    /// Of two designs: E min(m₁ + b₁ Z, m₂ + b₂ Z) is below the lower mean by s (φ(d/s) − d/s Φ(−d/s)), with s = |b₁ − b₂| and
    /// d = |m₁ − m₂| (Frazier, Powell and Dayanik 2009).
    #[test]
    fn of_two_designs_the_one_with_the_larger_knowledge_gradient_is_picked() {
        let (normal, scene) = (Normal::standard(), Scene::new(&[7]));
        let mut picked = [0; 2];
        for (places, responding, noise) in [
            ([-0.6, 0.1], 1.0, 0.01),
            ([-0.6, 0.7], 1.0, 0.01),
            ([0.3, 0.7], 1.0, 0.01),
            ([0.7, 0.3], 1.0, 0.5),
            ([0.25, 0.55], 0.8, 0.01),
            ([0.55, 0.25], 0.75, 0.01),
        ] {
            let (mut pool, joint) = line(&places, 10.0);
            pool.chances.responding[1] = responding;
            let (m, gradient) = (joint.means().to_vec(), Gradient::of(std::slice::from_ref(&joint), &pool, noise));
            let gain = |row: usize| {
                let [own, other] = [row, 1 - row].map(|place| joint.covariances(row)[place]);
                let s = (own - other).abs() / (joint.variance(row) + noise).sqrt();
                let t = (m[0] - m[1]).abs() / s;
                let density = (-0.5 * t * t).exp() / std::f64::consts::TAU.sqrt();
                pool.chances.responding[row] * s * (density - t * normal.cdf(-t))
            };
            let (gains, normals) = ([gain(0), gain(1)], outcomes(0, 7));
            let best = usize::from(gains[1] > gains[0]);
            assert!(gains[best] > 1.1 * gains[1 - best], "a clear case: {gains:?} for {places:?}");
            let (row, found) = gradient.most_telling(&normals, 0, &Economy::of(None, &scene.designs));
            assert_eq!(row, best, "{places:?}");
            let near = (found - gains[best]).abs() < 0.1 * gains[best].max(0.001);
            assert!(near, "{found} of {gains:?}");
            picked[best] += 1;
        }
        assert!(picked.iter().all(|times| *times > 0), "{picked:?}");
    }

    /// A design that may not be recommended before it gave a response is worth a run as far as it would then be the best: of two, the
    /// other one with the lower mean, p E[(m₁ − m₂ − s Z)⁺] with s² the variance of the difference of both effects.
    #[test]
    fn a_design_that_may_fail_is_worth_what_it_gains_if_it_does_not() {
        let (normal, noise, scene) = (Normal::standard(), 0.01, Scene::new(&[7]));
        for (places, feasible) in [([0.1, 0.4], 0.5), ([0.1, 0.4], 0.2), ([0.9, 0.4], 0.7), ([0.4, 0.1], 0.5)] {
            let (mut pool, joint) = line(&places, 10.0);
            pool.chances.responding[1] = feasible;
            let gradient = Gradient::of(std::slice::from_ref(&joint), &pool, noise);
            let (m, normals) = (joint.means(), outcomes(0, 7));
            let bounded = gradient.bounded(&[]);
            let n = normals.len() as f64;
            let lowest = |effect: &[f64], run| gradient.lowest_of_each(effect, &normals, &[], &bounded, run) / n;
            let effect = joint.effect(1, noise);
            let found = lowest(&[0.0; 2], None) - lowest(&effect, Some(1));
            let (s, d) = ((effect[0] - effect[1]).abs(), m[0] - m[1]);
            let density = (-0.5 * (d / s).powi(2)).exp() / std::f64::consts::TAU.sqrt();
            let expected = d * normal.cdf(d / s) + s * density;
            assert!((found - expected).abs() < 0.02 * expected.abs().max(0.1), "{found} {expected} for {places:?}");
            let economy = Economy::of(None, &scene.designs);
            assert!((gradient.weight(1, &economy) - feasible).abs() < 1e-15);
        }
    }

    /// What a run takes from the variances, each counted by how likely its design is the best.
    #[test]
    fn the_clearest_run_takes_most_from_the_variances_of_what_may_be_best() {
        let (normal, scene, noise) = (Normal::standard(), Scene::new(&[7]), 0.01);
        for within in [[1.0, 1.0, 1.0, 1.0], [1.0, 0.001, 1.0, 1.0], [0.001, 1.0, 1.0, 0.001], [1.0, 1.0, 0.01, 1.0]] {
            let (mut pool, joint) = line(&[-0.6, 0.1, 0.3, 0.75], 0.0);
            pool.chances.within = within.to_vec();
            let best = joint.means().iter().copied().fold(f64::INFINITY, f64::min);
            let learnt = |row: usize| {
                let mut after = joint.clone();
                after.measure(&joint.effect(row, noise));
                let of_place = |place: usize| {
                    let share = normal.cdf((best - joint.means()[place]) / joint.variance(place).sqrt());
                    share * within[place] * (joint.variance(place) - after.variance(place))
                };
                (0..4).map(of_place).sum::<f64>()
            };
            let learnt: Vec<f64> = (0..4).map(learnt).collect();
            let row = (0..4).max_by(|&a, &b| learnt[a].total_cmp(&learnt[b])).unwrap();
            let gradient = Gradient::of(std::slice::from_ref(&joint), &pool, noise);
            assert_eq!(gradient.clearest(&Economy::of(None, &scene.designs), &[]), row, "{within:?}: {learnt:?}");
        }
    }

    /// The order of the rows, and that most are not weighed, changes nothing.
    #[test]
    fn with_bounds_the_lowest_worth_is_that_of_all_rows() {
        let places = [-0.9, -0.6, 0.1, 0.3, 0.75];
        let (pool, joint) = line(&places, 0.0);
        let limits = Constraint::at_most("travel", 1.2);
        let mut gradient = Gradient::of(std::slice::from_ref(&joint), &pool, 0.01);
        gradient.admissions.push(Admission::of(&limits, line(&places, 0.3).1, 0.1, 0, 7));
        let stay: Vec<Step> = gradient.admissions.iter().map(Admission::stay).collect();
        let (bounded, normals) = (gradient.bounded(&stay), outcomes(0, 7));
        for row in 0..places.len() {
            let effect = gradient.joint.effect(row, gradient.noise);
            let steps = [gradient.admissions[0].step(row, 0)];
            let worth = |outcome: usize, other: usize| {
                let mean = gradient.futures[outcome][other] + normals[outcome] * effect[other];
                let chance = gradient.admissions[0].chance(other, &steps[0], outcome);
                bounded.reserve + chance * (mean - bounded.reserve).min(0.0)
            };
            let of_outcome =
                |outcome| (0..places.len()).map(|other| worth(outcome, other)).fold(f64::INFINITY, f64::min);
            let expected: f64 = (0..normals.len()).map(of_outcome).sum();
            let found = gradient.lowest_of_each(&effect, &normals, &steps, &bounded, Some(row));
            assert!((found - expected).abs() < 1e-12 * expected.abs(), "row {row}: {found} {expected}");
        }
    }

    /// A design that breaks a bound is worth as much as the worst: where the zero of the response lies is irrelevant.
    #[test]
    fn with_bounds_the_pick_does_not_depend_on_the_zero_of_the_response() {
        let (scene, places) = (Scene::new(&[7]), [-0.6, 0.1, 0.3, 0.75]);
        let admission = || {
            let limits = Constraint::at_most("travel", 1.2);
            Admission::of(&limits, line(&places, 0.0).1, 0.1, 0, 7)
        };
        let picks = [-100.0, 0.0, 100.0].map(|shift| {
            let (pool, joint) = line(&places, shift);
            let mut gradient = Gradient::of(std::slice::from_ref(&joint), &pool, 0.01);
            gradient.admissions.push(admission());
            let stay: Vec<Step> = gradient.admissions.iter().map(Admission::stay).collect();
            let lowest = gradient.lowest_of_each(&[0.0; 4], &[0.0; 48], &stay, &gradient.bounded(&stay), None);
            let (picked, _) = gradient.most_telling(&outcomes(0, 7), 0, &Economy::of(None, &scene.designs));
            (picked, lowest / f64::from(OUTCOMES) - shift)
        });
        for (picked, lowest) in picks {
            assert_eq!(picked, picks[1].0);
            assert!((lowest - picks[1].1).abs() < 1e-6, "{picks:?}");
        }
    }
}
