//! Numbers that belong to a plant: what its model is worth, what strategies of co-design cost, what surfaces and pulls do.

use anyhow::{Context as _, Result};
use design_space::{Model, Region};
use doe::{Criterion, Problem, Replicates};
use infuse::codesign::{OptimizerSettings, Strategy, codesign as optimize};
use infuse::{CodesignProblem, Role};
use surface::{Confounded, Data, InverseDistance, Regression, SquaredExponential, Surface};

use super::file::Setup;
use super::loops::Measured;
use super::row::{Fact, Readings, Study, World};
use crate::bat::{Bat, STAND_IN};
use crate::calibration::Plant;
use crate::chapter4;
use crate::correlation::rank_correlation;
use crate::gridded::Space;
use crate::logged::Logged;
use crate::variable::Variable;

/// A number with its name.
pub(super) type Named = (&'static str, f64);

/// The optimum of the model of Chapter 4, by the loop's own optimizer.
pub(super) fn numerical(
    study: &chapter4::Setup,
    simulate: &impl Fn(&[f64]) -> Result<f64, String>,
) -> Result<Vec<f64>> {
    let settings = study.loop_settings(&study.file.variant[0]).optimizer;
    let start = study.problem.region().center();
    Ok(optimize(&study.problem, &settings, &start, &mut |point| simulate(point))?.point)
}

/// Every strategy on the model of Chapter 4: how many simulations it took, and where it ended.
pub(super) fn codesign(
    study: &chapter4::Setup,
    simulate: &impl Fn(&[f64]) -> Result<f64, String>,
) -> Result<Vec<Fact>> {
    let strategies = [
        ("nested", Strategy::Nested),
        ("simultaneous", Strategy::Simultaneous),
        ("sequential", Strategy::Sequential),
        ("iterative", Strategy::Iterative),
    ];
    let start = study.problem.region().center();
    let mut facts = Vec::new();
    for (name, strategy) in strategies {
        let mut settings = study.loop_settings(&study.file.variant[0]).optimizer;
        settings.strategy = strategy;
        let report = optimize(&study.problem, &settings, &start, &mut |point| simulate(point))?;
        for (what, value) in [("simulations", report.n_simulations as f64), ("cost_s", report.cost)] {
            let name = format!("{name}_{what}");
            facts.push(Fact { study: Study::Chapter4, world: World::Still, name, value });
        }
    }
    Ok(facts)
}

/// The lowest cost nearby.
pub(super) fn descend(
    region: &Region,
    start: &[f64],
    mut cost: impl FnMut(&[f64]) -> Result<f64, String>,
) -> Result<Vec<f64>> {
    let is_controller = |name: &str| name == Variable::PitchSetPoint.name();
    let roles =
        region.parameters().iter().map(|p| if is_controller(p.name()) { Role::Controller } else { Role::Plant });
    let problem = CodesignProblem::new(region.clone(), roles.collect())?;
    let mut settings = OptimizerSettings::default();
    (settings.strategy, settings.n_starts, settings.final_radius) = (Strategy::Simultaneous, 0, 5e-3);
    Ok(optimize(&problem, &settings, start, &mut cost)?.point)
}

/// What the model is worth: over designs that nobody chose.
pub(super) fn worth(
    space: &Space,
    regressor: &Model,
    points: &[Vec<f64>],
    model: &[f64],
    truth: &[f64],
) -> Result<Vec<Named>> {
    let both: Vec<usize> = (0..truth.len()).filter(|k| model[*k].is_finite() && truth[*k].is_finite()).collect();
    let of = |values: &[f64]| both.iter().map(|k| values[*k]).collect::<Vec<f64>>();
    let (model, true_costs) = (of(model), of(truth));
    let fit = |regressor: &Model| -> Result<f64> {
        let coded: Vec<Vec<f64>> =
            both.iter().map(|k| Ok(space.region().coded(&points[*k])?)).collect::<Result<_>>()?;
        let data = Data::new(space.variables.len(), coded.concat(), true_costs.clone())?;
        Ok(Regression::fit_with(regressor, &data, Confounded::Drop)?.r_squared().unwrap_or(f64::NAN))
    };
    Ok(vec![
        ("rank_correlation", rank_correlation(&model, &true_costs)),
        ("fit_of_61", fit(regressor)?),
        ("fit_of_quadratic", fit(&Model::quadratic(space.variables.len())?)?),
        ("failed_designs", (truth.len() - true_costs.len()) as f64 / truth.len().max(1) as f64),
    ])
}

/// How far surfaces through the first batch are from what other designs truly cost: root mean squares in s.
pub(super) fn surfaces(
    space: &Space,
    regressor: &Model,
    batch: &[Measured],
    points: &[Vec<f64>],
    seen: &[Readings],
) -> Result<Vec<Named>> {
    if batch.len() <= regressor.terms().len() || space.variables.len() > 2 {
        return Ok(Vec::new());
    }
    let region = space.region();
    let coded = batch.iter().map(|(point, _)| Ok(region.coded(point)?)).collect::<Result<Vec<_>>>()?.concat();
    let data = Data::new(space.variables.len(), coded, batch.iter().map(|(_, cost)| *cost).collect())?;
    let error = |surface: &dyn Surface| -> Result<f64> {
        let (mut sum, mut n) = (0.0, 0);
        for (point, readings) in points.iter().zip(seen).filter(|(_, readings)| readings[0].is_finite()) {
            sum += (surface.predict(&region.coded(point)?) - readings[0]).powi(2);
            n += 1;
        }
        Ok((sum / f64::from(n)).sqrt())
    };
    Ok(vec![
        ("error_of_61", error(&Regression::fit_with(regressor, &data, Confounded::Drop)?)?),
        ("error_of_inverse_distance", error(&InverseDistance::fit(data.clone(), 2.0)?)?),
        ("error_of_squared_exponential", error(&SquaredExponential::fit_scale(data)?)?),
    ])
}

/// What the mass of the lines does to the cost of a design: the larger of the changes without it and with twice of it.
pub(super) fn line_mass(setup: &Setup, base: &Bat, plant: &Plant, point: &[f64]) -> Vec<Fact> {
    let cost = |factor: f64| {
        let mut rig = plant.rig.clone();
        rig.plant.tether.linear_density_kg_m *= factor;
        base.on(rig, plant.weights[1], setup.still.clone()).cost(point, STAND_IN)
    };
    let (Ok(as_it_is), Ok(none), Ok(twice)) = (cost(1.0), cost(0.0), cost(2.0)) else { return Vec::new() };
    let value = [none, twice].iter().map(|cost| (cost / as_it_is - 1.0).abs()).fold(0.0, f64::max);
    vec![Fact { study: Study::Two, world: World::Still, name: "line_mass_effect".to_owned(), value }]
}

/// When the pulls begin, and how long after it their effects are read, in s.
const PULLS_S: [f64; 3] = [20.0, 120.0, 220.0];
const EFFECT_S: f64 = 10.0;
/// How long before the next change of speed all should be back.
const BACK_S: f64 = 10.0;

/// What the pulls do to a design: the least over the three of each effect, and the most that is left of it.
pub(super) fn pulls(bat: &Bat, point: &[f64]) -> Vec<Named> {
    let Ok(logged) = bat.logged(point, STAND_IN) else { return Vec::new() };
    let [mut roll, mut pitch, mut lower, mut heading, mut left] =
        [f64::INFINITY, f64::INFINITY, f64::INFINITY, f64::INFINITY, 0.0_f64];
    for from in PULLS_S {
        let effect = Effect::of(&logged, from);
        roll = roll.min(effect.roll);
        pitch = pitch.min(effect.pitch);
        lower = lower.min(effect.lower);
        heading = heading.min(effect.heading);
        left = left.max(effect.left);
    }
    vec![
        ("pull_roll_deg", roll),
        ("pull_pitch_up_deg", pitch),
        ("pull_lower_cm", lower),
        ("pull_heading_deg", heading),
        ("pull_left", left),
    ]
}

/// Of one pull, beside the sample at which it begins.
struct Effect {
    roll: f64,
    /// The largest rise of the nose.
    pitch: f64,
    /// The largest loss of altitude.
    lower: f64,
    heading: f64,
    /// Root mean square of the heading at the end over the peak.
    left: f64,
}

impl Effect {
    fn of(logged: &Logged, from: f64) -> Self {
        let rows = &logged.log.rows;
        let within = |from: f64, to: f64| rows.iter().filter(move |row| (from..=to).contains(&row.time_s));
        let Some(start) = within(from, from + 1.0).next() else {
            return Self { roll: f64::NAN, pitch: f64::NAN, lower: f64::NAN, heading: f64::NAN, left: f64::NAN };
        };
        let most = |of: &dyn Fn(&water_channel::LogRow) -> f64| {
            within(from, from + EFFECT_S).map(of).fold(f64::NEG_INFINITY, f64::max)
        };
        let heading = most(&|row| (row.heading_rad - start.heading_rad).abs());
        let end: Vec<f64> = within(from + 80.0 - BACK_S, from + 80.0)
            .map(|row| (row.heading_rad - start.heading_rad).powi(2))
            .collect();
        Self {
            roll: most(&|row| (row.roll_rad - start.roll_rad).abs()).to_degrees(),
            pitch: most(&|row| row.pitch_rad - start.pitch_rad).to_degrees(),
            lower: 100.0 * most(&|row| start.altitude_m - row.altitude_m),
            heading: heading.to_degrees(),
            left: (end.iter().sum::<f64>() / end.len() as f64).sqrt() / heading,
        }
    }
}

/// Searches for designs of experiments, seeds from 1 on, however many seeds campaigns have.
pub(super) const N_SEARCHES: u64 = 5;

/// How the first batch of Chapter 7 with two parameters fills the space by the criteria G and D: how many of its runs differ, and how far
/// the cell is that is farthest from any, in coded units.
pub(super) fn designs(setup: &Setup) -> Result<Vec<Fact>> {
    let case = setup.chapter7.cases.first().context("chapter7.toml has no case")?;
    let space = &case.space;
    let mut facts = Vec::new();
    for (name, criterion) in [("g", Criterion::G), ("d", Criterion::D)] {
        for seed in 1..=N_SEARCHES {
            let model = Model::additive_quadratic(space.variables.len())?;
            let problem =
                Problem::new(model, doe::Space::of_region(space.region())?, case.entry.batch.experiments, criterion)?
                    .with_replicates(Replicates::Allowed)?;
            let mut settings = doe::Settings::default();
            settings.seed = seed;
            let mut cells = doe::search(&problem, &settings)?.cells;
            cells.sort();
            cells.dedup();
            let runs = cells.iter().map(|cell| space.coded(*cell)).collect::<Result<Vec<_>>>()?;
            let mut farthest = 0.0_f64;
            for cell in space.cells() {
                let coded = space.coded(cell)?;
                let distance =
                    |run: &Vec<f64>| run.iter().zip(&coded).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
                farthest = farthest.max(runs.iter().map(distance).fold(f64::INFINITY, f64::min));
            }
            for (what, value) in [("distinct", runs.len() as f64), ("farthest", farthest)] {
                facts.push(Fact {
                    study: Study::Two,
                    world: World::Still,
                    name: format!("{name}_{what}/{seed}"),
                    value,
                });
            }
        }
    }
    let value = case.entry.batch.experiments as f64;
    facts.push(Fact { study: Study::Two, world: World::Still, name: "runs".to_owned(), value });
    Ok(facts)
}
