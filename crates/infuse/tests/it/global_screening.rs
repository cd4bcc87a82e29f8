//! The z-test, its spread, and why a cell was dropped.

use design_space::{Cell, Model};
use infuse::{
    Error, TrialId,
    global::reported::{Spread, SpreadFault},
    global::{self, Observations, SpreadFallback, TracedSurface, TrialUse, quality_of_fit},
};
use proptest::prelude::*;
use surface::{Confounded, Kind};

use crate::global_problems::{after, coded, experiment, grid, least, planar, settings, simulation, truth};

/// A surface that is 1 everywhere, resting on trial 1.
fn one() -> TracedSurface {
    let mut observations = Observations::none(1);
    observations.add_experiment(TrialId::new(1), &[0.0], 1.0).unwrap();
    let model = Model::new(1, vec![design_space::Term::new(vec![0])]).unwrap();
    TracedSurface::fit(&Kind::Regression { model, confounded: Confounded::Refuse }, &observations).unwrap()
}

fn validation(costs: &[(u64, f64)]) -> Observations {
    let mut observations = Observations::none(1);
    for &(trial, cost) in costs {
        observations.add_experiment(TrialId::new(trial), &[0.5], cost).unwrap();
    }
    observations
}

#[test]
fn the_quality_of_fit_divides_by_one_less_than_the_points() {
    // (1 + 1 + 4)/2.
    let s = quality_of_fit(&one(), &validation(&[(2, 2.0), (3, 0.0), (4, 3.0)])).unwrap();
    assert!((s.unwrap() - 3.0_f64.sqrt()).abs() < 1e-15);
    assert_eq!(quality_of_fit(&one(), &validation(&[(2, 2.0)])).unwrap(), None);
    assert_eq!(quality_of_fit(&one(), &validation(&[])).unwrap(), None);
}

#[test]
fn an_experiment_that_is_in_the_surface_cannot_validate_it() {
    let leak = quality_of_fit(&one(), &validation(&[(2, 2.0), (1, 0.0)])).unwrap_err();
    assert_eq!(leak, Error::ValidationLeak { trials: vec![TrialId::new(1)] });
    assert!(leak.to_string().contains("validation trials 1, expected"), "{leak}");
}

/// Simulations of the first batch corrected by that batch's own correction, the same-batch reading of 5.4.
#[test]
fn the_correction_of_the_same_batch_leaks_and_is_refused() {
    let campaign = after(1, planar().1);
    let (report, surfaces) = (&campaign.reports()[0], &campaign.surfaces()[0]);
    let mut observations = Observations::none(2);
    for record in &report.simulations {
        observations.add_simulation(&coded(&record.point), simulation(record.cell, &record.point).unwrap()).unwrap();
    }
    assert!(observations.trials().is_empty(), "a simulation rests on no trial");
    let mut validation = Observations::none(2);
    for record in report.trials.iter().filter(|record| record.trial.used_for == TrialUse::Validation) {
        validation.add_experiment(record.trial.id, &coded(&record.trial.point), experiment(&record.trial)).unwrap();
    }
    let kind = Kind::Regression { model: Model::quadratic(2).unwrap(), confounded: Confounded::Refuse };
    let honest = TracedSurface::fit(&kind, &observations).unwrap();
    assert!(quality_of_fit(&honest, &validation).unwrap().unwrap() > 0.1);
    let corrected = observations.corrected_by(&surfaces.correction).unwrap();
    let leaky = TracedSurface::fit(&kind, &corrected).unwrap();
    let Err(Error::ValidationLeak { trials }) = quality_of_fit(&leaky, &validation) else {
        panic!("expected a leak");
    };
    assert_eq!(trials.len(), 6);
}

#[test]
fn the_combined_surface_rests_on_its_training_runs_and_on_everything_before() {
    let campaign = after(4, planar().1);
    for (report, surfaces) in campaign.reports().iter().zip(campaign.surfaces()) {
        let own = |used_for| report.trials.iter().filter(move |record| record.trial.used_for == used_for);
        let earlier = (1..report.trials[0].trial.id.number()).map(TrialId::new);
        let expected = earlier.chain(own(TrialUse::Training).map(|record| record.trial.id)).collect();
        assert_eq!(surfaces.combined.trials(), &expected);
        assert!(own(TrialUse::Validation).all(|record| !surfaces.combined.trials().contains(&record.trial.id)));
    }
}

#[test]
fn what_was_dropped_has_a_reason_and_what_was_not_has_none() {
    let campaign = after(5, planar().1);
    let sets: Vec<_> = (1..=6).map(|batch| campaign.retained_at(batch).unwrap()).collect();
    let mut n_dropped = 0;
    for cell in campaign.grid().cells() {
        let Some(dropped) = campaign.why_dropped(cell) else {
            assert!(campaign.is_retained(cell), "cell {cell}");
            continue;
        };
        n_dropped += 1;
        assert!(!campaign.is_retained(cell), "cell {cell}");
        assert!(sets[dropped.batch - 1].contains(cell) && !sets[dropped.batch].contains(cell), "cell {cell}");
        // (39), with the quantile of tables.
        let z = (dropped.value - dropped.optimum_value) / (dropped.spread * 2.0_f64.sqrt());
        assert!((dropped.z - z).abs() < 1e-12 * z && dropped.z >= dropped.z0);
        assert!((dropped.z0 - 1.281_551_565_544_600_4).abs() < 1e-9, "{}", dropped.z0);
    }
    assert_eq!(n_dropped, 576 - campaign.retained().n_retained());
    assert!(n_dropped > 100, "long enough to mean something");
    assert_eq!(campaign.why_dropped(Cell::new(576)), None);
    assert!(!campaign.is_retained(Cell::new(576)) && !campaign.is_retained(Cell::new(u64::MAX)));
}

/// (40) and the numbers of the z-test from the reported runs alone, by hand.
#[test]
fn the_spread_of_an_batch_is_that_of_its_validation_runs() {
    let campaign = after(3, planar().1);
    for (report, surfaces) in campaign.reports().iter().zip(campaign.surfaces()) {
        let runs = report.trials.iter().filter(|record| record.trial.used_for == TrialUse::Validation);
        let squares: Vec<f64> = runs
            .map(|record| {
                let predicted = surfaces.combined.surface().predict(&coded(&record.trial.point));
                (predicted - experiment(&record.trial)).powi(2)
            })
            .collect();
        let expected = (squares.iter().sum::<f64>() / 5.0).sqrt();
        let Spread::Estimated { s, n_validation } = report.screening.spread else { panic!("an estimate") };
        assert_eq!((n_validation, squares.len()), (6, 6));
        assert!((s - expected).abs() < 1e-12 * expected, "{s} {expected}");
    }
}

#[test]
fn without_a_spread_the_settings_decide() {
    // The simulation is exact and so is the experiment: S is zero but for rounding.
    let run = |fallback| {
        let (region, mut settings) = planar();
        settings.fallback = fallback;
        settings.max_batches = 1;
        let mut campaign = global::Loop::new(&region, settings).unwrap();
        let stop = campaign.run(&mut |_, p| Ok(truth(p)), &mut |trial| Ok(truth(&trial.point))).unwrap();
        (stop, campaign.reports()[0].screening.clone())
    };
    let because = SpreadFault::Zero;
    let (stop, kept) = run(SpreadFallback::KeepAll);
    assert_eq!((stop, kept.n_after), (infuse::global::StopReason::BatchLimit, 576));
    assert_eq!(kept.spread, Spread::Undefined { because });
    let (stop, given) = run(SpreadFallback::Given(0.1));
    assert_eq!((stop, given.spread), (infuse::global::StopReason::BatchLimit, Spread::Given { s: 0.1, because }));
    // 0.1 times the root of 2 times 1.2816 above the smallest.
    let (region, settings) = planar();
    let campaign = global::Loop::new(&region, settings).unwrap();
    let best = least(&campaign, truth).1;
    let expected = campaign.grid().cells().filter(|&cell| truth(&campaign.point(cell).unwrap()) < best + 0.181_238_76);
    assert_eq!(given.n_after, expected.count() as u64);
    let (stop, stopped) = run(SpreadFallback::Stop);
    assert_eq!((stop, stopped.n_after), (infuse::global::StopReason::NoSpread, 576));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]
    #[test]
    fn the_optimum_is_never_dropped_when_the_surfaces_are_exact(
        optimum in prop::array::uniform2(-1.3_f64..1.3),
        curvature in prop::array::uniform2(0.1_f64..3.0),
        coupling in -0.9_f64..0.9,
        spread in 1e-6_f64..2.0,
        seed in any::<u64>(),
    ) {
        let cost = |p: &[f64]| {
            let x = coded(p);
            let (a, b) = (curvature[0].sqrt() * (x[0] - optimum[0]), curvature[1].sqrt() * (x[1] - optimum[1]));
            a * a + 2.0 * coupling * a * b + b * b
        };
        let mut settings = settings(Model::quadratic(2).unwrap(), 8, 8);
        settings.seed = seed;
        settings.max_batches = 3;
        settings.fallback = SpreadFallback::Given(spread);
        let mut campaign = global::Loop::new(&grid(&[9, 11]), settings).unwrap();
        campaign.run(&mut |_, p| Ok(cost(p)), &mut |trial| Ok(cost(&trial.point))).unwrap();
        let (_, best) = least(&campaign, cost);
        let left = campaign.retained().cells().map(|cell| cost(&campaign.point(cell).unwrap()));
        prop_assert!(left.fold(f64::INFINITY, f64::min) <= best + 1e-9);
        let last = &campaign.reports().last().unwrap().screening;
        prop_assert!(cost(&last.optimum) <= best + 1e-9);
    }
}
