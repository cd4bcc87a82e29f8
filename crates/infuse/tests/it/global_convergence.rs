//! What the loop arrives at, and by which law.

use doe::Model;
use infuse::{CorrectedField, CorrectionLaw, CorrectionRule, Gain, GlobalLoop};

use crate::global_problems::{after, experiment, grid, least, planar, settings, simulation, truth};

/// Nearly flat, so that the test drops nothing and the laws are compared over the whole grid.
fn flat(point: &[f64]) -> f64 {
    0.004 * truth(point)
}

fn by(law: CorrectionLaw) -> GlobalLoop {
    let (region, mut settings) = planar();
    settings.correction = CorrectionRule::new(law, Gain::constant(0.5).unwrap());
    settings.confidence = 1.0 - 1e-15;
    settings.max_iterations = 7;
    let mut campaign = GlobalLoop::new(&region, settings).unwrap();
    let mut biased = |p: &[f64]| Ok(flat(p) + simulation(p)? - truth(p));
    campaign.run(&mut biased, &mut |trial| Ok(flat(&trial.point) + experiment(trial) - truth(&trial.point))).unwrap();
    assert_eq!(campaign.retained().n_retained(), 576);
    campaign
}

/// Largest error of the corrected model over the whole grid, per iteration.
fn model_errors(campaign: &GlobalLoop) -> Vec<f64> {
    let cells = 0..campaign.retained().n_cells();
    let of = |surfaces: &infuse::IterationSurfaces| {
        let error = |cell| {
            let estimate = surfaces.numerical.surface().predict(&campaign.coded(cell).unwrap());
            (estimate - flat(&campaign.point(cell).unwrap())).abs()
        };
        cells.clone().map(error).fold(0.0, f64::max)
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
        assert!(left.cells().all(|cell| before.contains(cell)), "iteration {}", number + 1);
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
    let proof = model_errors(&by(CorrectionLaw::ProofRecursion));
    for (n, error) in (1..).zip(&proof) {
        let left = gap * 0.5_f64.powi(n);
        assert!((error - left).abs() < 0.06, "iteration {n}: {error} instead of {left}");
    }
    let printed = model_errors(&by(CorrectionLaw::AsPrinted36));
    for (n, error) in (2..).zip(&printed[1..]) {
        // k, then 2k, 4k, 8k, ... of the gap are added.
        let left = gap * (0.5 * 2.0_f64.powi(n - 1) - 1.0).abs();
        assert!((error - left).abs() < 0.05 * 2.0_f64.powi(n), "iteration {n}: {error} instead of {left}");
    }
    assert!(printed[6] > 30.0 * gap, "{printed:?}");
}

#[test]
fn the_correction_is_that_of_the_value_recursion_at_every_cell() {
    for law in [CorrectionLaw::ProofRecursion, CorrectionLaw::CurrentSimulation, CorrectionLaw::AsPrinted36] {
        for gain in [Gain::constant(0.3).unwrap(), Gain::harmonic()] {
            let (_, mut settings) = planar();
            settings.correction = CorrectionRule::new(law, gain);
            let campaign = after(4, settings);
            let n_cells = campaign.retained().n_cells();
            let sampled = |surface: &infuse::TracedSurface| -> Vec<f64> {
                (0..n_cells).map(|cell| surface.surface().predict(&campaign.coded(cell).unwrap())).collect()
            };
            let mut field =
                CorrectedField::new(campaign.settings().correction, usize::try_from(n_cells).unwrap()).unwrap();
            for surfaces in campaign.surfaces() {
                field.update(&sampled(surfaces.experiment.as_ref().unwrap()), &sampled(&surfaces.simulation)).unwrap();
                let pairs = [(&surfaces.correction, field.correction()), (&surfaces.numerical, field.model().unwrap())];
                for (surface, expected) in pairs {
                    let size = expected.iter().fold(1.0_f64, |size, value| size.max(value.abs()));
                    let largest = sampled(surface).iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                    assert!(largest < 1e-9 * size, "{law:?} {gain:?}: {largest}");
                }
            }
        }
    }
}

#[test]
fn four_parameters_work_with_fewer_training_runs_than_terms() {
    // 9 training runs and 15 terms, as in Section 7.2.
    let mut settings = settings(Model::quadratic(4).unwrap(), 18, 36);
    settings.max_iterations = 4;
    let region = grid(&[6, 6, 6, 6]);
    let cost = |p: &[f64]| truth(&p[..2]) + (p[2] - 11.0).powi(2) + 0.5 * (p[3] - 13.0).powi(2);
    let mut simulated = |p: &[f64]| Ok(cost(p) + 0.7 * p[0] - 0.9 * p[2]);
    let mut campaign = GlobalLoop::new(&region, settings).unwrap();
    campaign
        .run(&mut simulated, &mut |trial| Ok(experiment(trial) - truth(&trial.point) + cost(&trial.point)))
        .unwrap();
    let best = least(&campaign, cost).1;
    let last = &campaign.reports().last().unwrap().screening;
    assert!(cost(&last.optimum) - best < 0.05, "{last:?}");
}

#[test]
fn every_kind_of_surface_goes_through_the_loop() {
    use infuse::SurfaceKind::{InverseDistance, Regression, SquaredExponential};
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
