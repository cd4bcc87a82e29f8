//! One unit of work: a study on a plant, in both worlds, by all methods; or by the pooled loop alone, beside what is kept of the others.

use std::collections::BTreeSet;
use std::time::Instant;

use anyhow::{Context as _, Result, bail, ensure};
use design_space::Model;
use infuse::global;
use rayon::prelude::*;

use super::facts;
use super::file::Setup;
use super::loops::{self, Measured, Read, Step, Task, sobol_points};
use super::row::{Fact, Method, Readings, Row, Study, World};
use super::site::{Noise, Site};
use super::store::Found;
use crate::bat::{Bat, MODEL, STAND_IN};
use crate::calibration::{CAMPAIGN_TABLES, Plant};
use crate::chapter4::{self, Lattice};
use crate::chapter7::Case;
use crate::gridded::{CellCosts, Designs, FlownGrid, OnDemand, Space};

/// Levels of the grid on which methods choose in Chapter 4, which has none.
const LEVELS: u32 = 24;
/// Designs among which the search for the optimum of a model of four parameters starts.
const STARTS: usize = 256;
/// The scramble of the designs that nobody chose.
const RANDOM: u32 = 0;

/// Whose campaigns are run.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Methods {
    All,
    /// Beside what is kept of the others.
    PooledAlone,
}

/// A study on a plant with what all worlds share.
struct Common<'a> {
    setup: &'a Setup,
    plant: &'a Plant,
    study: Study,
    space: Space,
    model: &'a dyn CellCosts,
    /// The optimum of the numerical model.
    numerical: Vec<f64>,
    /// The best in still water, where it was looked for.
    best: Option<Vec<f64>>,
    /// Experiments and simulations of a batch, and batches.
    budget: [usize; 3],
    seeds: u64,
    methods: Methods,
}

/// What a campaign leaves: its steps, what it measured, and the loop itself where cells are dropped.
struct Campaign {
    steps: Vec<Step>,
    measured: Vec<Measured>,
    global: Option<global::Loop>,
}

/// One world of a unit.
#[derive(Default)]
struct InWorld {
    rows: Vec<Row>,
    facts: Vec<Fact>,
    n_flights: usize,
}

/// Runs a study on a plant.
pub(super) fn run(setup: &Setup, study: Study, plant: &Plant, designs: &Designs) -> Result<(Found, usize)> {
    let start = Instant::now();
    let worlds = in_worlds(setup, study, plant, designs, Methods::All);
    let mut found = Found::default();
    let mut n_flights = 0;
    for world in worlds? {
        found.rows.extend(world.rows);
        found.facts.extend(world.facts);
        n_flights += world.n_flights;
    }
    found.seconds = start.elapsed().as_secs_f64();
    Ok((found, n_flights))
}

/// The same with new campaigns of the pooled loop alone; none where that cannot be: a campaign failed, or found a design that is better than
/// all that were known, so that it is to be said anew whether the other loop keeps it.
pub(super) fn run_pooled(
    setup: &Setup,
    study: Study,
    plant: &Plant,
    designs: &Designs,
    kept: &Found,
) -> Result<Option<Found>> {
    let mut rows = Vec::with_capacity(kept.rows.len());
    let worlds = in_worlds(setup, study, plant, designs, Methods::PooledAlone)?;
    for (world, in_world) in World::OF_CAMPAIGNS.into_iter().zip(worlds) {
        // As they will be read again.
        let anew = in_world.rows.iter().map(|row| Row::read(&row.cells())).collect::<Result<Vec<Row>>>()?;
        let before: Vec<&Row> = kept.rows.iter().filter(|row| row.world == world).collect();
        let Some(merged) = merged(&before, &anew) else { return Ok(None) };
        rows.extend(merged);
    }
    Ok(Some(Found { rows, ..kept.clone() }))
}

/// Rows of a world with those of the pooled loop replaced, seed by seed; none if a seed has none on either side, or if the best of all is
/// another design.
fn merged(before: &[&Row], anew: &[Row]) -> Option<Vec<Row>> {
    let seeds = |rows: &mut dyn Iterator<Item = &Row>| {
        rows.filter(|row| row.method == Method::Pooled).map(|row| row.seed).collect::<BTreeSet<u64>>()
    };
    if seeds(&mut before.iter().copied()) != seeds(&mut anew.iter()) {
        return None;
    }
    let mut rows: Vec<Row> = Vec::with_capacity(before.len());
    let mut done = BTreeSet::new();
    for row in before {
        if row.method != Method::Pooled {
            rows.push((*row).clone());
        } else if done.insert(row.seed) {
            rows.extend(anew.iter().filter(|one| one.seed == row.seed).cloned());
        }
    }
    let is_judged = before.iter().any(|row| !row.keeps_best.is_nan());
    let [then, now] = [best(before.iter().copied()), best(&rows)].map(|best| best.map(|row| &row.point));
    (!is_judged || then == now).then_some(rows)
}

/// The cheapest of the designs that flew.
fn best<'a>(rows: impl IntoIterator<Item = &'a Row>) -> Option<&'a Row> {
    let flown = rows.into_iter().filter(|row| row.cost().is_finite());
    flown.min_by(|a, b| a.cost().total_cmp(&b.cost()))
}

fn in_worlds(setup: &Setup, study: Study, plant: &Plant, designs: &Designs, methods: Methods) -> Result<Vec<InWorld>> {
    let worlds = match study {
        Study::Chapter4 => of_chapter4(setup, plant, methods),
        Study::Two => of_chapter7(setup, plant, Study::Two, 0, designs, methods),
        Study::Four => of_chapter7(setup, plant, Study::Four, 1, designs, methods),
        Study::Chapter3 | Study::Chapter6 => bail!("no campaign is judged in it"),
    };
    worlds.with_context(|| format!("{}, plant {}", study.words(), plant.number))
}

/// Chapter 4 on a plant, on a lattice so much coarser.
fn chapter4_on(setup: &Setup, plant: &Plant, coarser: f64) -> chapter4::Setup {
    let bat = setup.chapter4.bat.on(plant.rig.clone(), plant.weights[0], setup.still.clone());
    setup.chapter4.on(bat, coarser)
}

/// The grid on which methods choose in Chapter 4, what its model says there, and what may be spent.
fn gridded(
    study: &chapter4::Setup,
    simulate: &dyn Fn(&[f64]) -> Result<f64, String>,
) -> Result<(Space, FlownGrid, [usize; 3])> {
    let space = Space::over(study.problem.region(), study.bat.variables().to_vec(), LEVELS)?;
    let grid = FlownGrid::of_costs(space.points()?.iter().map(|point| simulate(point)).collect());
    let iterations = study.loop_settings(&study.file.variant[0]).max_iterations;
    let budget = [2 * space.variables.len() + 1, 4 * space.variables.len(), iterations];
    Ok((space, grid, budget))
}

/// That the pooled loop still chooses what was kept of its first campaign on a plant in still water.
pub(super) fn choose_again(setup: &Setup, plant: &Plant, kept: &[Row]) -> Result<()> {
    let study = chapter4_on(setup, plant, setup.campaigns.coarser);
    let lattice = Lattice::fly(&study, MODEL, |_| {});
    let (space, grid, budget) = gridded(&study, &lattice.interpolant()?)?;
    let site = Site::new(setup, &setup.chapter4.bat, plant, plant.weights[0], World::Still)?;
    let read = |seed: u64, experiments: &[(u64, Vec<f64>)]| {
        site.read(seed, experiments, Noise::OfCost(study.file.noise.share))
    };
    let steps = loops::pooled_loop(&Task { space: &space, model: &grid, read: &read, budget }, 1)?;
    let is_meant = |row: &&Row| (row.world, row.method, row.seed) == (World::Still, Method::Pooled, 1);
    let kept: Vec<&Row> = kept.iter().filter(is_meant).collect();
    let close = |(a, b): (&f64, &f64)| (a - b).abs() <= 1e-5 * a.abs().max(1.0);
    let same = |(step, row): (&Step, &&Row)| step.step == row.step && step.point.iter().zip(&row.point).all(close);
    ensure!(
        steps.len() == kept.len() && steps.iter().zip(&kept).all(same),
        "{}: on plant {} the pooled loop chooses otherwise than when it was kept: remove all of {} there and run \
         `cargo xtask reproduce-all --ensemble`",
        setup.origin.folder(),
        plant.number,
        CAMPAIGN_TABLES.join(", ")
    );
    Ok(())
}

fn of_chapter4(setup: &Setup, plant: &Plant, methods: Methods) -> Result<Vec<InWorld>> {
    let study = chapter4_on(setup, plant, setup.campaigns.coarser);
    let lattice = Lattice::fly(&study, MODEL, |_| {});
    let simulate = lattice.interpolant()?;
    let (space, grid, budget) = gridded(&study, &simulate)?;
    let mut common = Common {
        setup,
        plant,
        study: Study::Chapter4,
        model: &grid,
        numerical: Vec::new(),
        best: None,
        budget,
        seeds: setup.campaigns.seeds,
        space,
        methods,
    };
    let rough = chapter4_on(setup, plant, 2.0 * setup.campaigns.coarser);
    let mut shared = Vec::new();
    if methods == Methods::All {
        shared = facts::codesign(&study, &simulate)?;
        common.numerical = facts::numerical(&study, &simulate)?;
        common.best = Some(Lattice::fly(&rough, STAND_IN, |_| {}).lowest().0.to_vec());
    }
    let noise = |_: &[Readings]| Noise::OfCost(study.file.noise.share);
    let campaign = |read: &Read<'_>, seed: u64| {
        let (steps, measured) = loops::gradient_loop(&study, &simulate, read, seed)?;
        Ok(Campaign { steps, measured, global: None })
    };
    let model = Model::additive_quadratic(2)?;
    let mut worlds = common.all_worlds(&setup.chapter4.bat, 0, &model, &noise, &campaign)?;
    worlds[0].facts.append(&mut shared);
    worlds[0].n_flights += study.bat.n_known(MODEL) + rough.bat.n_known(STAND_IN);
    Ok(worlds)
}

fn of_chapter7(
    setup: &Setup,
    plant: &Plant,
    study: Study,
    case: usize,
    designs: &Designs,
    methods: Methods,
) -> Result<Vec<InWorld>> {
    let case = setup.chapter7.cases.get(case).context("chapter7.toml has too few cases")?;
    let variant = setup.chapter7.file.variant.first().context("no variant")?;
    let settings = setup.chapter7.settings(case, variant)?;
    let bat = case.bat.on(plant.rig.clone(), plant.weights[1], setup.still.clone());
    let flown = if case.is_flown_whole() {
        let fly = |fidelity| FlownGrid::fly(&bat, &case.space, fidelity, |_| {});
        Some((fly(MODEL)?, fly(STAND_IN)?))
    } else {
        None
    };
    let demand = OnDemand { bat: &bat, space: &case.space, fidelity: MODEL, range: f64::NAN };
    let model: &dyn CellCosts = flown.as_ref().map_or(&demand, |(model, _)| model);
    let lowest = |grid: &FlownGrid| case.space.point(grid.lowest()?.0);
    let common = Common {
        setup,
        plant,
        study,
        space: case.space.clone(),
        model,
        numerical: match &flown {
            _ if methods == Methods::PooledAlone => Vec::new(),
            Some((model, _)) => lowest(model)?,
            None => lowest_of(&bat, case)?,
        },
        best: flown.as_ref().map(|(_, truth)| lowest(truth)).transpose()?,
        budget: [settings.n_experiments, settings.n_simulations, settings.max_batches],
        seeds: if study == Study::Four { setup.campaigns.seeds_of_four } else { setup.campaigns.seeds },
        methods,
    };
    let share = setup.chapter7.file.noise.share;
    let range = flown.as_ref().map(|(_, truth)| truth.range());
    let noise = |random: &[Readings]| Noise::Absolute(share * range.unwrap_or_else(|| range_of(random)));
    let campaign = |read: &Read<'_>, seed: u64| {
        let task = Task { space: &common.space, model: common.model, read, budget: common.budget };
        let campaign = loops::global_loop(&task, &settings, designs, seed)?;
        let steps = loops::steps_of(&campaign, &common.space, seed);
        Ok(Campaign { steps, measured: loops::measured_by(&campaign), global: Some(campaign) })
    };
    let mut worlds = common.all_worlds(&case.bat, 1, &settings.model, &noise, &campaign)?;
    if study == Study::Two && methods == Methods::All {
        worlds[0].facts.extend(facts::line_mass(setup, &case.bat, plant, &common.space.region().center()));
    }
    worlds[0].n_flights += bat.n_known(MODEL) + bat.n_known(STAND_IN);
    Ok(worlds)
}

/// Highest less lowest cost.
fn range_of(readings: &[Readings]) -> f64 {
    let costs = readings.iter().map(|readings| readings[0]).filter(|cost| cost.is_finite());
    let [low, high] =
        costs.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], cost| [low.min(cost), high.max(cost)]);
    if high > low { high - low } else { 0.0 }
}

/// The lowest cost of a model that is not flown in whole: the end of a search from the best of many.
fn lowest_of(bat: &Bat, case: &Case) -> Result<Vec<f64>> {
    let starts = sobol_points(&case.space, STARTS, RANDOM);
    let costs = bat.costs(&starts, MODEL, |_| {});
    let flown = starts.into_iter().zip(costs).filter_map(|(point, cost)| Some((cost.ok()?, point)));
    let (_, start) = flown.min_by(|a, b| a.0.total_cmp(&b.0)).context("no design of the model flies")?;
    facts::descend(case.space.region(), &start, |point| bat.cost(point, MODEL))
}

type Run<'a> = dyn Fn(&Read<'_>, u64) -> Result<Campaign> + Sync + 'a;

impl Common<'_> {
    fn all_worlds(
        &self,
        base: &Bat,
        weights: usize,
        regressor: &Model,
        noise: &dyn Fn(&[Readings]) -> Noise,
        campaign: &Run<'_>,
    ) -> Result<Vec<InWorld>> {
        let in_world = |world: World| {
            let site = Site::new(self.setup, base, self.plant, self.plant.weights[weights], world)?;
            let random = sobol_points(&self.space, self.setup.campaigns.random_designs as usize, RANDOM);
            let seen = site.observe(&random);
            let noise = noise(&seen);
            let read = |seed: u64, experiments: &[(u64, Vec<f64>)]| site.read(seed, experiments, noise);
            if self.methods == Methods::PooledAlone {
                return self.pooled_in_world(&site, world, &read);
            }
            self.in_world(&site, world, (&random, &seen), regressor, &read, campaign)
        };
        World::OF_CAMPAIGNS.into_iter().map(in_world).collect()
    }

    fn in_world(
        &self,
        site: &Site,
        world: World,
        (random, seen): (&[Vec<f64>], &[Readings]),
        regressor: &Model,
        read: &Read<'_>,
        campaign: &Run<'_>,
    ) -> Result<InWorld> {
        let task = Task { space: &self.space, model: self.model, read, budget: self.budget };
        let of_seed = |seed: u64| self.of_seed(&task, regressor, seed, campaign);
        let campaigns: Vec<OfSeed> = (1..=self.seeds).into_par_iter().map(of_seed).collect();
        let mut steps = vec![
            Step::new(Method::Numerical, 0, 0, self.numerical.clone()),
            Step::new(Method::Center, 0, 0, self.space.region().center()),
        ];
        steps.extend(self.best.iter().map(|point| Step::new(Method::Best, 0, 0, point.clone())));
        steps.extend((0..).zip(random).map(|(number, point)| Step::new(Method::Random, number, 0, point.clone())));
        steps.extend(campaigns.iter().flat_map(|one| one.steps.iter().cloned()));
        let points: Vec<Vec<f64>> = steps.iter().map(|step| step.point.clone()).collect();
        let mut rows: Vec<Row> = steps
            .into_iter()
            .zip(site.observe(&points))
            .map(|(step, readings)| self.row(world, step, readings))
            .collect();
        self.note_kept(&mut rows, &campaigns)?;
        let n_failed = campaigns.iter().map(|one| one.n_failed).sum::<usize>();
        let mut facts = self.diagnostics(world, regressor, random, seen)?;
        facts.push(self.fact(world, "failed_campaigns", n_failed as f64));
        for (seed, one) in (1..).zip(&campaigns) {
            let of = |(name, value): (&str, f64)| self.fact(world, &format!("{name}/{seed}"), value);
            facts.extend(facts::surfaces(&self.space, regressor, &one.first_batch, random, seen)?.into_iter().map(of));
        }
        if self.study == Study::Chapter4 {
            let pulls = facts::pulls(site.rig(), &self.numerical);
            facts.extend(pulls.into_iter().map(|(name, value)| self.fact(world, name, value)));
        }
        Ok(InWorld { rows, facts, n_flights: site.n_flights() })
    }

    /// Campaigns of the pooled loop alone; of those that fail nothing.
    fn pooled_in_world(&self, site: &Site, world: World, read: &Read<'_>) -> Result<InWorld> {
        let task = Task { space: &self.space, model: self.model, read, budget: self.budget };
        let of_seed = |seed: u64| loops::pooled_loop(&task, seed).unwrap_or_default();
        let steps: Vec<Step> = (1..=self.seeds).into_par_iter().flat_map_iter(of_seed).collect();
        let points: Vec<Vec<f64>> = steps.iter().map(|step| step.point.clone()).collect();
        let rows = steps.into_iter().zip(site.observe(&points)).map(|(step, readings)| self.row(world, step, readings));
        Ok(InWorld { rows: rows.collect(), ..InWorld::default() })
    }

    fn fact(&self, world: World, name: &str, value: f64) -> Fact {
        Fact { study: self.study, world, name: name.to_owned(), value }
    }

    fn row(&self, world: World, step: Step, readings: Readings) -> Row {
        let Step { method, seed, step, point, share, spread } = step;
        Row { study: self.study, world, method, seed, step, point, share, spread, keeps_best: f64::NAN, readings }
    }

    /// Whether the best design known is still there after each step.
    fn note_kept(&self, rows: &mut [Row], campaigns: &[OfSeed]) -> Result<()> {
        let Some(best) = best(rows.iter()) else { return Ok(()) };
        let best = self.space.nearest(&best.point)?;
        for row in rows.iter_mut().filter(|row| row.method == Method::Dissertation) {
            let campaign = campaigns.get(row.seed as usize - 1).and_then(|one| one.global.as_ref());
            let left = campaign.and_then(|campaign| campaign.retained_at(row.step + 1));
            row.keeps_best = left.map_or(f64::NAN, |left| f64::from(u8::from(left.contains(best))));
        }
        Ok(())
    }

    /// What the model is worth, by designs that nobody chose.
    fn diagnostics(
        &self,
        world: World,
        regressor: &Model,
        random: &[Vec<f64>],
        seen: &[Readings],
    ) -> Result<Vec<Fact>> {
        let cells = random.iter().map(|point| self.space.nearest(point)).collect::<Result<Vec<_>>>()?;
        let model: Vec<f64> = self.model.costs(&cells).into_iter().map(|cost| cost.unwrap_or(f64::NAN)).collect();
        let truth: Vec<f64> = seen.iter().map(|readings| readings[0]).collect();
        let found = facts::worth(&self.space, regressor, random, &model, &truth)?;
        Ok(found.into_iter().map(|(name, value)| self.fact(world, name, value)).collect())
    }
}

/// All methods with one seed.
struct OfSeed {
    steps: Vec<Step>,
    first_batch: Vec<Measured>,
    global: Option<global::Loop>,
    n_failed: usize,
}

impl Common<'_> {
    /// Runs them; a method that cannot go on, because too much failed, is named and left out.
    fn of_seed(&self, task: &Task<'_>, regressor: &Model, seed: u64, campaign: &Run<'_>) -> OfSeed {
        let mut found = OfSeed { steps: Vec::new(), first_batch: Vec::new(), global: None, n_failed: 0 };
        match campaign(task.read, seed) {
            Ok(one) => {
                let last = one.steps.last().map_or(0, |step| step.step);
                found.first_batch = one.measured.iter().take(self.budget[0]).cloned().collect();
                found.steps.extend(one.steps);
                found.global = one.global;
                let alone = loops::alone(task.space, regressor, &one.measured, seed, last).map(|step| vec![step]);
                found.note(self, seed, alone);
            }
            Err(error) => found.note(self, seed, Err(error)),
        }
        found.note(self, seed, loops::pooled_loop(task, seed));
        found.note(self, seed, loops::process(task, seed).map(|step| vec![step]));
        found
    }
}

impl OfSeed {
    fn note(&mut self, common: &Common<'_>, seed: u64, steps: Result<Vec<Step>>) {
        match steps {
            Ok(steps) => self.steps.extend(steps),
            Err(error) => {
                self.n_failed += 1;
                eprintln!("{}, plant {}, seed {seed}: {error:#}", common.study.words(), common.plant.number);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::row::N_READINGS;
    use super::*;

    fn row(method: Method, seed: u64, step: usize, cost: f64) -> Row {
        let readings: Readings = core::array::from_fn::<f64, N_READINGS, _>(|k| if k == 0 { cost } else { 0.0 });
        let (study, world, point) = (Study::Two, World::Still, vec![cost, 1.0]);
        let keeps_best = if method == Method::Dissertation { 1.0 } else { f64::NAN };
        Row { study, world, method, seed, step, point, share: f64::NAN, spread: f64::NAN, keeps_best, readings }
    }

    fn words(rows: &[Row]) -> Vec<(Method, u64, usize, f64)> {
        rows.iter().map(|row| (row.method, row.seed, row.step, row.cost())).collect()
    }

    #[test]
    fn rows_of_the_pooled_loop_stand_where_they_stood() {
        use Method::{Dissertation, Pooled, Process};
        let kept = [
            row(Dissertation, 1, 1, 2.0),
            row(Pooled, 1, 1, 3.0),
            row(Pooled, 1, 2, 2.5),
            row(Process, 1, 9, 4.0),
            row(Dissertation, 2, 1, 1.0),
            row(Pooled, 2, 1, 3.5),
        ];
        let before: Vec<&Row> = kept.iter().collect();
        let anew = [row(Pooled, 2, 1, 1.5), row(Pooled, 1, 1, 1.25)];
        let found = merged(&before, &anew).expect("the best is as it was");
        let expected = [
            (Dissertation, 1, 1, 2.0),
            (Pooled, 1, 1, 1.25),
            (Process, 1, 9, 4.0),
            (Dissertation, 2, 1, 1.0),
            (Pooled, 2, 1, 1.5),
        ];
        assert_eq!(words(&found), expected);
        // Another best, or a campaign that failed: the other loop has to be asked again.
        assert!(merged(&before, &[row(Pooled, 1, 1, 0.5), row(Pooled, 2, 1, 2.0)]).is_none());
        assert!(merged(&before, &anew[..1]).is_none());
        assert!(merged(&before[..4], &anew).is_none());
        // Where nobody drops cells the best may be any.
        let free: Vec<&Row> = before.iter().copied().filter(|row| row.method != Dissertation).collect();
        assert!(merged(&free, &[row(Pooled, 1, 1, 0.5), row(Pooled, 2, 1, 2.0)]).is_some());
    }
}
