//! What the loop arrives at, and by which law.

use design_space::{Cell, Model};
use infuse::{
    correction::{Field, Gain, Law, Rule},
    global::{self, TrialUse},
};

use crate::global_problems::{after, coded, experiment, grid, least, planar, settings, simulation, truth};

/// Nearly flat, so that the test drops nothing and the laws are compared over the whole grid.
fn flat(point: &[f64]) -> f64 {
    0.004 * truth(point)
}

fn by(law: Law) -> global::Loop {
    let (region, mut settings) = planar();
    settings.correction = Rule::new(law, Gain::constant(0.5).unwrap());
    settings.confidence = 1.0 - 1e-15;
    settings.max_batches = 7;
    let mut campaign = global::Loop::new(&region, settings).unwrap();
    let mut biased = |cell: Cell, p: &[f64]| Ok(flat(p) + simulation(cell, p)? - truth(p));
    campaign.run(&mut biased, &mut |trial| Ok(flat(&trial.point) + experiment(trial) - truth(&trial.point))).unwrap();
    assert_eq!(campaign.retained().n_retained(), 576);
    campaign
}

/// Largest error of the corrected model over the whole grid, per batch.
fn model_errors(campaign: &global::Loop) -> Vec<f64> {
    let of = |surfaces: &infuse::global::BatchSurfaces| {
        let error = |cell| {
            let estimate = surfaces.numerical.surface().predict(&campaign.coded(cell).unwrap());
            (estimate - flat(&campaign.point(cell).unwrap())).abs()
        };
        campaign.grid().cells().map(error).fold(0.0, f64::max)
    };
    campaign.surfaces().iter().map(of).collect()
}

#[test]
fn the_optimum_of_the_experiment_is_found_although_the_simulation_has_another() {
    let campaign = after(8, planar().1);
    let (best_cell, best) = least(&campaign, truth);
    let regret = |point: &[f64]| truth(point) - best;
    let (first, last) = (&campaign.reports()[0].screening, &campaign.reports().last().unwrap().screening);
    assert!(regret(&first.simulation_optimum) > 0.8, "the simulation alone is far off");
    assert!(regret(&last.optimum) < 0.005, "regret {}", regret(&last.optimum));
    assert!(campaign.is_retained(best_cell), "the optimum was never dropped");
    assert!(campaign.retained().share() < 0.1, "share {}", campaign.retained().share());
}

#[test]
fn the_retained_set_never_grows() {
    let campaign = after(6, planar().1);
    let mut before = campaign.retained_at(1).unwrap();
    assert_eq!(before.n_retained(), 576);
    for (number, report) in campaign.reports().iter().enumerate() {
        let left = campaign.retained_at(number + 2).unwrap();
        assert!(left.cells().all(|cell| before.contains(cell)), "batch {}", number + 1);
        assert_eq!((report.screening.n_before, report.screening.n_after), (before.n_retained(), left.n_retained()));
        assert!(left.contains(report.screening.optimum_cell), "the optimum stays");
        before = left;
    }
    assert_eq!(&before, campaign.retained());
    assert_eq!(campaign.retained_at(8), None);
}

#[test]
fn the_proofs_recursion_leaves_the_closed_form_of_the_gap_and_36_as_printed_goes_astray() {
    // Every surface is exact but for the experiments' error of 0.02, so only the law decides. The gap is
    // 1 + 2.2 + 1.6 at one corner.
    let gap: f64 = 4.8;
    let proof = model_errors(&by(Law::ProofRecursion));
    for (n, error) in (1..).zip(&proof) {
        let left = gap * 0.5_f64.powi(n);
        assert!((error - left).abs() < 0.06, "batch {n}: {error} instead of {left}");
    }
    let printed = model_errors(&by(Law::AsPrinted36));
    for (n, error) in (2..).zip(&printed[1..]) {
        // k, then 2k, 4k, 8k, ... of the gap are added.
        let left = gap * (0.5 * 2.0_f64.powi(n - 1) - 1.0).abs();
        assert!((error - left).abs() < 0.05 * 2.0_f64.powi(n), "batch {n}: {error} instead of {left}");
    }
    assert!(printed[6] > 30.0 * gap, "{printed:?}");
}

/// The simulation with a wave that no term of the model has: its surface is another one in every batch.
fn waved(cell: Cell, point: &[f64]) -> Result<f64, String> {
    let x = coded(point);
    Ok(simulation(cell, point)? + 0.4 * (4.0 * x[0] + 1.0).sin() + 0.3 * (3.0 * x[1]).cos())
}

fn of_waves(n_batches: usize, rule: Rule) -> global::Loop {
    let (region, mut settings) = planar();
    settings.correction = rule;
    settings.max_batches = n_batches;
    let mut campaign = global::Loop::new(&region, settings).unwrap();
    campaign.run(&mut waved, &mut |trial| Ok(experiment(trial))).unwrap();
    assert_eq!(campaign.reports().len(), n_batches);
    campaign
}

fn sampled(campaign: &global::Loop, surface: &infuse::global::TracedSurface) -> Vec<f64> {
    let cells = campaign.grid().cells();
    cells.map(|cell| surface.surface().predict(&campaign.coded(cell).unwrap())).collect()
}

fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn the_correction_is_that_of_the_value_recursion_at_every_cell() {
    for law in [Law::ProofRecursion, Law::CurrentSimulation, Law::AsPrinted36] {
        for gain in [Gain::constant(0.3).unwrap(), Gain::harmonic()] {
            let campaign = of_waves(4, Rule::new(law, gain));
            let sampled = |surface| sampled(&campaign, surface);
            let n_cells = usize::try_from(campaign.retained().n_cells()).unwrap();
            let simulations: Vec<_> = campaign.surfaces().iter().map(|at| sampled(&at.simulation)).collect();
            for pair in simulations.windows(2) {
                assert!(largest_difference(&pair[0], &pair[1]) > 0.01, "each simulation surface is another one");
            }
            let mut field = Field::new(campaign.settings().correction, n_cells).unwrap();
            for surfaces in campaign.surfaces() {
                field.update(&sampled(surfaces.experiment.as_ref().unwrap()), &sampled(&surfaces.simulation)).unwrap();
                let pairs = [(&surfaces.correction, field.correction()), (&surfaces.numerical, field.model().unwrap())];
                for (surface, expected) in pairs {
                    let size = expected.iter().fold(1.0_f64, |size, value| size.max(value.abs()));
                    let largest = largest_difference(&sampled(surface), expected);
                    assert!(largest < 1e-9 * size, "{law:?} {gain:?}: {largest}");
                }
            }
        }
    }
}

/// A full quadratic of two coordinates.
#[derive(Clone, Copy)]
struct Quadratic([f64; 6]);

impl Quadratic {
    fn regressor(x: &[f64]) -> [f64; 6] {
        [1.0, x[0], x[1], x[0] * x[0], x[0] * x[1], x[1] * x[1]]
    }

    fn at(&self, x: &[f64]) -> f64 {
        self.0.iter().zip(Self::regressor(x)).map(|(b, r)| b * r).sum()
    }

    /// R'WR b = R'WJ by elimination with pivots; each datum a point, a cost and a weight.
    fn fit(data: &[(Vec<f64>, f64, f64)]) -> Self {
        let mut rows = [[0.0; 7]; 6];
        for (x, cost, weight) in data {
            let r = Self::regressor(x);
            for i in 0..6 {
                (0..6).for_each(|j| rows[i][j] += weight * r[i] * r[j]);
                rows[i][6] += weight * r[i] * cost;
            }
        }
        for k in 0..6 {
            let pivot = (k..6).max_by(|&a, &b| rows[a][k].abs().total_cmp(&rows[b][k].abs())).unwrap();
            rows.swap(k, pivot);
            let own = rows[k].map(|value| value / rows[k][k]);
            for (i, row) in rows.iter_mut().enumerate() {
                let factor = row[k];
                row.iter_mut().zip(own).for_each(|(value, own)| *value -= factor * own);
                if i == k {
                    *row = own;
                }
            }
        }
        Self(rows.map(|row| row[6]))
    }

    fn plus(self, times: f64, other: Self) -> Self {
        let mut sum = self;
        sum.0.iter_mut().zip(other.0).for_each(|(a, b)| *a += times * b);
        sum
    }
}

/// Two batches of Section 5.3 from the costs in the reports, written out a second time.
#[test]
fn two_batches_are_those_of_the_normal_equations() {
    for law in [Law::ProofRecursion, Law::CurrentSimulation] {
        let campaign = of_waves(2, Rule::new(law, Gain::constant(0.5).unwrap()));
        let (mut correction, mut last) = (Quadratic([0.0; 6]), None);
        for (report, surfaces) in campaign.reports().iter().zip(campaign.surfaces()) {
            let (mut all, mut simulations, mut both) = (Vec::new(), Vec::new(), Vec::new());
            for record in &report.trials {
                let (x, cost) = (coded(&record.trial.point), record.outcome.as_ref().unwrap().cost().unwrap());
                if record.trial.used_for == TrialUse::Training {
                    both.push((x.clone(), cost, 0.7));
                }
                all.push((x, cost, 1.0));
            }
            assert_eq!((all.len(), both.len()), (12, 6));
            for record in &report.simulations {
                let (x, cost) = (coded(&record.point), record.outcome.cost().unwrap());
                both.push((x.clone(), cost + correction.at(&x), 0.3));
                simulations.push((x, cost, 1.0));
            }
            let (experiment, simulation) = (Quadratic::fit(&all), Quadratic::fit(&simulations));
            // Ĵnum,0 = Ĵsim,1.
            let compared = match law {
                Law::ProofRecursion => last.unwrap_or(simulation),
                _ => simulation.plus(1.0, correction),
            };
            correction = correction.plus(0.5, experiment).plus(-0.5, compared);
            last = Some(simulation.plus(1.0, correction));
            let pairs = [
                (surfaces.experiment.as_ref().unwrap(), experiment),
                (&surfaces.simulation, simulation),
                (&surfaces.combined, Quadratic::fit(&both)),
                (&surfaces.correction, correction),
                (&surfaces.numerical, simulation.plus(1.0, correction)),
            ];
            for (number, (surface, expected)) in pairs.into_iter().enumerate() {
                let cells = campaign.grid().cells().map(|cell| expected.at(&campaign.coded(cell).unwrap()));
                let largest = largest_difference(&sampled(&campaign, surface), &cells.collect::<Vec<_>>());
                assert!(largest < 1e-7, "{law:?}, batch {}, surface {number}: {largest}", report.number);
            }
        }
    }
}

#[test]
fn four_parameters_work_with_fewer_training_runs_than_terms() {
    // 9 training runs and 15 terms, as in Section 7.2.
    let mut settings = settings(Model::quadratic(4).unwrap(), 18, 36);
    settings.max_batches = 4;
    let region = grid(&[6, 6, 6, 6]);
    let cost = |p: &[f64]| truth(&p[..2]) + (p[2] - 11.0).powi(2) + 0.5 * (p[3] - 13.0).powi(2);
    let mut simulated = |_: Cell, p: &[f64]| Ok(cost(p) + 0.7 * p[0] - 0.9 * p[2]);
    let mut campaign = global::Loop::new(&region, settings).unwrap();
    campaign
        .run(&mut simulated, &mut |trial| Ok(experiment(trial) - truth(&trial.point) + cost(&trial.point)))
        .unwrap();
    let best = least(&campaign, cost).1;
    let last = &campaign.reports().last().unwrap().screening;
    assert!(cost(&last.optimum) - best < 0.05, "{last:?}");
}

#[test]
fn every_kind_of_surface_goes_through_the_loop() {
    use infuse::global::SurfaceKind::{InverseDistance, Regression, SquaredExponential};
    for kind in [Regression, InverseDistance { power: 2.0 }, SquaredExponential { scale: Some(3.0) }] {
        let (_, mut settings) = planar();
        settings.surfaces.experiment = kind;
        settings.surfaces.simulation = kind;
        settings.surfaces.combined = kind;
        let campaign = after(3, settings);
        assert_eq!(campaign.reports().len(), 3, "{kind:?}");
        // The changes say what the surfaces themselves say.
        let surfaces = campaign.surfaces();
        let at = campaign.retained_at(2).unwrap();
        let largest = at.cells().map(|cell| {
            let point = campaign.coded(cell).unwrap();
            (surfaces[1].numerical.surface().predict(&point) - surfaces[0].numerical.surface().predict(&point)).abs()
        });
        let largest = largest.fold(0.0, f64::max);
        let reported = campaign.reports()[1].changes.model;
        assert!((largest - reported).abs() < 1e-9, "{kind:?}: {largest} {reported}");
    }
}
