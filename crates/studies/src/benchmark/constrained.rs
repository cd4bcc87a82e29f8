//! Campaigns with a response that has to stay within a bound, or in which runs fail: is what is recommended allowed as often as
//! promised, and how good is it?

use anyhow::{Context as _, Result};
use design_space::{Cell, Grid, Parameter, Region};
use infuse::Outcome;
use infuse::pooled::{Ask, Constraint, Loop, Responses, Settings};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde::{Deserialize, Serialize};
use surface::process::{Residual, SimulationUse, Structure};

use super::families::{FAMILIES, Family, Pair};
use super::task::Task;

pub(super) const BATCHES: usize = 4;
/// Seeds of each family, from 1.
pub(super) const SEEDS: u64 = 10;
/// So many of all designs keep to the bound.
pub(super) const ALLOWED: f64 = 0.4;
/// So many of all designs give a value, where runs fail.
pub(super) const RESPONDING: f64 = 0.6;
/// The constrained response is that of the same family with this much added to the seed.
const OTHER: u64 = 1000;
/// A kind of problem.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Case {
    pub(super) name: &'static str,
    family: &'static str,
    pub(super) kind: Kind,
}

/// What is special about a problem.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// All parameters are numbers.
    Numbers,
    /// The last parameter is a choice among [`PLACES`] instead.
    Choice,
    /// A run beyond the bound gives nothing, and there is nothing else to measure.
    Failing,
    /// The same where the first parameter is beyond [`EDGE`].
    FailingEdge,
    /// The same with one [way to choose](NEVER), whatever the other parameters are.
    FailingChoice,
}

impl Kind {
    /// Whether runs fail.
    pub(super) fn fails(self) -> bool {
        matches!(self, Self::Failing | Self::FailingEdge | Self::FailingChoice)
    }

    fn has_choice(self) -> bool {
        matches!(self, Self::Choice | Self::FailingChoice)
    }
}

const fn case(name: &'static str, family: &'static str, kind: Kind) -> Case {
    Case { name, family, kind }
}

/// What is run: two to four factors, smooth and not, with numbers only and with a choice.
pub(super) const CASES: [Case; 19] = [
    case("bowl-2", "bowl-2", Kind::Numbers),
    case("wells-2", "wells-2", Kind::Numbers),
    case("branin", "branin", Kind::Numbers),
    case("stall-4", "stall-4", Kind::Numbers),
    case("bowl-4", "bowl-4", Kind::Numbers),
    case("borehole-4", "borehole-4", Kind::Numbers),
    case("branin, a choice", "branin", Kind::Choice),
    case("stall-4, a choice", "stall-4", Kind::Choice),
    case("bowl-4, a choice", "bowl-4", Kind::Choice),
    case("bowl-2, runs fail", "bowl-2", Kind::Failing),
    case("wells-2, runs fail", "wells-2", Kind::Failing),
    case("branin, runs fail", "branin", Kind::Failing),
    case("stall-4, runs fail", "stall-4", Kind::Failing),
    case("bowl-4, runs fail", "bowl-4", Kind::Failing),
    case("borehole-4, runs fail", "borehole-4", Kind::Failing),
    case("branin, an edge fails", "branin", Kind::FailingEdge),
    case("stall-4, an edge fails", "stall-4", Kind::FailingEdge),
    case("wells-2, a choice fails", "wells-2", Kind::FailingChoice),
    case("bowl-4, a choice fails", "bowl-4", Kind::FailingChoice),
];

/// Where on the axis of a number the ways to choose are, in an order that says nothing of it.
const PLACES: [f64; 4] = [0.62, 0.08, 0.91, 0.35];
/// The way that never gives a value.
const NEVER: usize = 2;
/// Of the first parameter, which goes from 0 to 1.
pub(super) const EDGE: f64 = 0.6;

impl Case {
    pub(super) fn family(&self) -> Result<&'static Family> {
        FAMILIES.iter().find(|family| family.name == self.family).context(self.family)
    }

    /// The point of the functions that a point of the campaign is.
    fn place(&self, point: &[f64]) -> Vec<f64> {
        let mut place = point.to_vec();
        if let (true, Some(last)) = (self.kind.has_choice(), place.last_mut()) {
            *last = PLACES[*last as usize];
        }
        place
    }

    /// The same without the functions.
    fn task<'a>(&self, family: &Family, pair: &'a Pair, seed: u64) -> Result<Task<'a>> {
        let task = Task::new(family, pair, seed)?;
        if !self.kind.has_choice() {
            return Ok(task);
        }
        let mut parameters = task.region.parameters().to_vec();
        parameters.pop();
        parameters.push(Parameter::categorical("choice", ["a", "b", "c", "d"])?);
        let region = Region::new(parameters)?;
        Ok(Task { grid: Grid::of(&region)?, region, ..task })
    }
}

/// How a campaign goes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Way {
    pub(super) name: &'static str,
    pub(super) words: &'static str,
    has_simulation: bool,
    is_blind: bool,
}

pub(super) const WAYS: [Way; 3] = [
    Way { name: "pooled", words: "pooled loop", has_simulation: true, is_blind: false },
    Way { name: "without", words: "pooled loop, no simulation", has_simulation: false, is_blind: false },
    Way { name: "sobol", words: "Sobol points, Gaussian processes", has_simulation: false, is_blind: true },
];

/// After a batch.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Row {
    pub(super) family: String,
    pub(super) way: String,
    pub(super) seed: u64,
    /// From 1.
    pub(super) batch: usize,
    /// The probability to keep to the bound, or to give a value, that was printed.
    pub(super) promised: f64,
    /// Whether the loop said that it suffices.
    pub(super) suffices: bool,
    /// Whether the recommended design does keep to it, or give a value.
    pub(super) keeps: bool,
    /// Truth there less the lowest of all designs that keep to it; the truth goes from 0 to 1.
    pub(super) regret: f64,
    /// No design that keeps to it is better by more, said the certificate.
    pub(super) bound: f64,
    /// Share of the runs so far that gave no value.
    pub(super) failed: f64,
}

impl Row {
    pub(super) fn agrees(&self, other: &Self) -> bool {
        let close = |a: f64, b: f64| (a - b).abs() <= 1e-6 * (1.0 + a.abs());
        let of = |row: &Self| (row.family.clone(), row.way.clone(), row.seed, row.batch, row.suffices, row.keeps);
        of(self) == of(other)
            && close(self.promised, other.promised)
            && close(self.regret, other.regret)
            && close(self.bound, other.bound)
            && close(self.failed, other.failed)
    }
}

/// A pair for the cost, one for the constraint, and what follows from the truth of both.
struct Problem {
    case: Case,
    cost: Pair,
    constrained: Pair,
    limit: f64,
    best: f64,
}

impl Problem {
    fn of(case: Case, seed: u64) -> Result<Self> {
        let family = case.family()?;
        let (cost, constrained) = (family.pair(seed), family.pair(seed + OTHER));
        let grid = case.task(family, &cost, seed)?.grid;
        let points = grid.cells().map(|cell| Ok(grid.point(cell)?)).collect::<Result<Vec<_>>>()?;
        let mut problem = Self { case, cost, constrained, limit: f64::INFINITY, best: f64::INFINITY };
        let values: Vec<f64> = points.iter().map(|point| problem.limited(point)).collect();
        problem.limit = match case.kind {
            Kind::Numbers | Kind::Choice => page::quantile(&values, ALLOWED).context("designs")?,
            Kind::Failing => page::quantile(&values, RESPONDING).context("designs")?,
            Kind::FailingEdge => EDGE,
            Kind::FailingChoice => 0.5,
        };
        let allowed = points.iter().zip(&values).filter(|(_, value)| **value <= problem.limit);
        problem.best = allowed.map(|(point, _)| (problem.cost.truth)(&case.place(point))).fold(f64::INFINITY, f64::min);
        Ok(problem)
    }

    /// What has to keep to the limit at a point of the campaign: a response, or of what fails at an edge or with a choice that.
    fn limited(&self, point: &[f64]) -> f64 {
        match self.case.kind {
            Kind::FailingEdge => point[0],
            Kind::FailingChoice => f64::from(u8::from(point.last().is_some_and(|last| *last as usize == NEVER))),
            Kind::Numbers | Kind::Choice | Kind::Failing => (self.constrained.truth)(&self.case.place(point)),
        }
    }

    fn simulated(&self, point: &[f64]) -> Responses {
        let place = self.case.place(point);
        // Of failures it knows nothing.
        let is_known = !self.case.kind.fails();
        let constrained = is_known.then(|| Some((self.constrained.simulation)(&place))).into_iter().collect();
        Responses { cost: (self.cost.simulation)(&place), constrained }
    }
}

/// One campaign, a row for each batch.
pub(super) fn run(case: Case, way: Way, seed: u64) -> Result<Vec<Row>> {
    let problem = Problem::of(case, seed)?;
    let task = case.task(case.family()?, &problem.cost, seed)?;
    let mut settings = Settings::new(task.n_experiments);
    (settings.max_batches, settings.seed) = (BATCHES, seed);
    let fails = case.kind.fails();
    if !fails {
        settings.constraints = vec![Constraint::at_most("limited", problem.limit)];
    }
    if way.is_blind {
        settings.structures = vec![Structure { simulation: SimulationUse::Ignored, residual: Residual::Smooth }];
    }
    let mut campaign = Loop::new(&task.region, settings)?;
    let mut simulate = |_: Cell, point: &[f64]| Ok(problem.simulated(point));
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(2);
    let mut spread = task.spread(BATCHES * task.n_experiments).into_iter();
    let (mut rows, mut n_failed) = (Vec::new(), 0);
    for batch in 1..=BATCHES {
        let trials = if way.is_blind {
            campaign.hand_out(&spread.by_ref().take(task.n_experiments).collect::<Vec<_>>())?
        } else {
            let asked = if way.has_simulation { campaign.ask(Some(&mut simulate))? } else { campaign.ask(None)? };
            let Ask::Run { trials, .. } = asked else { anyhow::bail!("the campaign ended early") };
            trials
        };
        for trial in trials {
            let point = task.grid.point(trial.cell)?;
            if fails && problem.limited(&point) > problem.limit {
                n_failed += 1;
                campaign.tell(trial.id, Outcome::Failed { reason: "beyond the bound".to_owned() })?;
                continue;
            }
            let mut noisy = |value: f64, noise: f64| {
                let normal: f64 = StandardNormal.sample(&mut rng);
                value + noise * normal
            };
            let cost = noisy((problem.cost.truth)(&case.place(&point)), problem.cost.noise);
            campaign.tell(trial.id, Outcome::Value(cost))?;
            if !fails {
                let limited = noisy(problem.limited(&point), problem.constrained.noise);
                campaign.tell_constrained(trial.id, &[Some(limited)])?;
            }
        }
        let found = if way.has_simulation { campaign.assess(Some(&mut simulate))? } else { campaign.assess(None)? };
        let found = found.context("no response")?;
        let point = &found.recommended.point;
        rows.push(Row {
            family: case.name.to_owned(),
            way: way.name.to_owned(),
            seed,
            batch,
            promised: found.recommended.constrained.first().map_or(found.recommended.feasible, |one| one.within),
            suffices: found.recommended.suffices,
            keeps: problem.limited(point) <= problem.limit,
            regret: (problem.cost.truth)(&case.place(point)) - problem.best,
            bound: found.certificate.bound,
            failed: n_failed as f64 / (batch * task.n_experiments) as f64,
        });
    }
    Ok(rows)
}
