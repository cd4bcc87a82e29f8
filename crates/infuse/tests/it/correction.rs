//! The correction on pairs of parabolas, against closed forms.

use infuse::{codesign::Strategy, correction::Form, gradient};
use proptest::prelude::*;

use crate::problems::{Parabola, measured, optimizer, pair, pair_loop, simulated, single, single_settings};

const MODEL: Parabola = Parabola { curvature: 2.0, optimum: 0.0 };
const RIG: Parabola = Parabola { curvature: 3.0, optimum: 1.0 };

/// Optimum of each iteration over −10 to 10.
fn path(mut settings: gradient::Settings, form: Form, model: Parabola, rig: Parabola) -> Vec<f64> {
    settings.correction_form = form;
    let mut campaign = gradient::Loop::new(single(-10.0, 10.0), settings).unwrap();
    let reason = campaign.run(&mut |p| Ok(model.cost(p)), &mut |trial| Ok(rig.cost(&trial.point))).unwrap();
    assert_eq!(reason, gradient::StopReason::IterationLimit, "the test runs to its limit");
    campaign.reports().iter().map(|report| report.numerical.point[0]).collect()
}

/// The distance to the rig's optimum is multiplied by `factor` per iteration.
#[track_caller]
fn check_path(path: &[f64], model: Parabola, rig: Parabola, factor: f64) {
    for (iteration, optimum) in path.iter().enumerate() {
        let expected = rig.optimum + (model.optimum - rig.optimum) * factor.powi(i32::try_from(iteration).unwrap());
        assert!((optimum - expected).abs() < 1e-6, "iteration {iteration}: {optimum}, closed form {expected}");
    }
}

#[test]
fn printed_27_walks_away_from_the_optimum_of_the_experiment() {
    let r = 0.4;
    let path = path(single_settings(r, 0.5, 5), Form::AsPrinted, MODEL, RIG);
    check_path(&path, MODEL, RIG, 1.0 + r * RIG.curvature / MODEL.curvature);
    let costs: Vec<f64> = path.iter().map(|p| RIG.cost(&[*p])).collect();
    assert!(costs.is_sorted(), "every iteration is worse: {costs:?}");
    assert!(path[4] < -14.0 + 10.0, "and it goes far: {path:?}");
}

#[test]
fn printed_27_ends_on_a_bound_and_is_not_called_converged() {
    let mut settings = single_settings(0.4, 0.5, 20);
    settings.tolerances = None;
    let path = path(settings, Form::AsPrinted, MODEL, RIG);
    assert!(path[19] <= -10.0, "the far bound: {path:?}");
}

#[test]
fn repaired_27_approaches_the_optimum_of_the_experiment_geometrically() {
    for r in [0.1, 0.5, 1.0] {
        let path = path(single_settings(r, 0.5, 8), Form::Repaired, MODEL, RIG);
        check_path(&path, MODEL, RIG, 1.0 - r * RIG.curvature / MODEL.curvature);
    }
}

#[test]
fn repaired_27_contracts_below_twice_the_ratio_of_curvatures_and_not_above() {
    // 2 H_mod / H_exp = 1.25.
    let rig = Parabola { curvature: 3.2, optimum: 1.0 };
    for (r, contracts) in [(1.2, true), (1.3, false)] {
        let path = path(single_settings(r, 0.5, 6), Form::Repaired, MODEL, rig);
        check_path(&path, MODEL, rig, 1.0 - r * 1.6);
        let nearer = (path[5] - 1.0).abs() < (path[0] - 1.0).abs();
        assert_eq!(nearer, contracts, "R = {r}: {path:?}");
    }
}

#[test]
fn an_active_bound_does_not_wind_the_correction_up() {
    // The first parameter rests on its lower bound, because both optima lie below it. The second is
    // corrected so slowly that the campaign goes on.
    let (r, step) = (0.3, 0.4);
    let model = |p: &[f64]| (p[0] + 1.0).powi(2) + p[1].powi(2);
    let rig = |p: &[f64]| 1.5 * (p[0] + 2.0).powi(2) + (p[1] - 0.5).powi(2);
    let mut settings = gradient::Settings::new(vec![r, 0.02], vec![step, 0.1]);
    settings.optimizer = optimizer(Strategy::Simultaneous);
    settings.optimizer.final_radius = 1e-8;
    settings.tolerances = Some(vec![1e-6; 2]);
    settings.max_iterations = 30;
    let mut campaign = gradient::Loop::new(pair(0.0, 4.0), settings).unwrap();
    let reason = campaign.run(&mut |p| Ok(model(p)), &mut |trial| Ok(rig(&trial.point))).unwrap();
    assert_eq!(reason, gradient::StopReason::IterationLimit, "the second still moves");
    // The rig's forward difference at 0 is its slope there plus half the curvature times the step;
    // the model's own difference is exact.
    let gap = (6.0 + 1.5 * step) - 2.0;
    let mut kept = 1.0;
    for (index, report) in campaign.reports().iter().enumerate() {
        assert!(report.numerical.point[0] <= 0.0, "it rests on the bound");
        assert_eq!(report.experiment_gradient[0].map(|g| (g - 6.6).abs() < 1e-9), Some(true));
        kept *= 1.0 - r;
        let (slope, expected) = (report.correction.slope()[0], (1.0 - kept) * gap);
        assert!((slope - expected).abs() < 1e-8, "iteration {index}: {slope}, closed form {expected}");
    }
}

#[test]
fn an_optimum_that_rests_on_a_bound_converges_there() {
    let (model, rig) = (Parabola { curvature: 2.0, optimum: -1.0 }, Parabola { curvature: 3.0, optimum: -2.0 });
    let mut campaign = gradient::Loop::new(single(0.0, 4.0), single_settings(0.3, 0.4, 9)).unwrap();
    let reason = campaign.run(&mut |p| Ok(model.cost(p)), &mut |trial| Ok(rig.cost(&trial.point))).unwrap();
    assert_eq!(reason, gradient::StopReason::Converged, "the rig agrees with the bound");
    assert_eq!(campaign.reports().len(), 2, "the second optimum is where the first was");
    assert_eq!(campaign.reports()[0].trials.len(), 2, "no step below the bound");
}

#[test]
fn an_optimum_held_by_a_bound_is_released_when_the_experiment_pulls_inward() {
    let (model, rig) = (Parabola { curvature: 1.0, optimum: -3.0 }, Parabola { curvature: 1.0, optimum: 2.0 });
    let mut settings = single_settings(0.3, 0.1, 100);
    settings.tolerances = Some(vec![1e-4]);
    let mut campaign = gradient::Loop::new(single(0.0, 4.0), settings).unwrap();
    let reason = campaign.run(&mut |p| Ok(model.cost(p)), &mut |trial| Ok(rig.cost(&trial.point))).unwrap();
    let path: Vec<f64> = campaign.reports().iter().map(|report| report.numerical.point[0]).collect();
    assert!(path[..3].iter().all(|p| *p <= 0.0), "it rests there at first: {path:?}");
    assert_eq!(reason, gradient::StopReason::Converged, "and is not called converged for that");
    assert!((path[path.len() - 1] - 2.0).abs() < 1e-3, "{path:?}");
}

#[test]
fn corrected_cost_is_that_of_the_correction_known_at_the_optimization() {
    let mut campaign = pair_loop();
    campaign.run(&mut simulated, &mut |trial| measured(&trial.point)).unwrap();
    assert!(campaign.is_converged(), "{:?}", campaign.stop());
    let reports = campaign.reports();
    assert_eq!(reports[0].numerical.correction_value.to_bits(), 0.0_f64.to_bits(), "nothing known");
    for (index, report) in reports.iter().enumerate() {
        let numerical = &report.numerical;
        let point = &numerical.point;
        assert_eq!(report.n_experiments(), 5, "2 n + 1");
        assert_eq!(Ok(numerical.model_cost), simulated(point), "J at the optimum");
        assert_eq!(report.experiment_cost, measured(point).ok(), "the center trial");
        if index > 0 {
            let known = reports[index - 1].correction.cost(point).unwrap();
            assert_eq!(numerical.correction_value.to_bits(), known.to_bits(), "that of the last round");
        }
        let sum = numerical.model_cost + numerical.correction_value;
        assert_eq!(numerical.corrected_cost.to_bits(), sum.to_bits(), "their sum");
    }
    let last = &reports[reports.len() - 1].numerical.point;
    assert!((last[0] - 0.7).abs() < 0.02 && (last[1] + 0.2).abs() < 0.02, "{last:?}");
}

#[test]
fn the_correction_is_the_sum_of_its_terms_at_any_point() {
    let mut campaign = pair_loop();
    campaign.run(&mut simulated, &mut |trial| measured(&trial.point)).unwrap();
    for point in [[0.0, 0.0], [0.9, -0.4], [-1.0, 1.0]] {
        let mut sum = 0.0;
        for report in campaign.reports() {
            let numerical = &report.numerical;
            for (j, trust) in [0.5, 0.8].into_iter().enumerate() {
                let experiment = report.experiment_gradient[j].unwrap();
                let gap = experiment - numerical.model_gradient[j].unwrap();
                sum += trust * gap * (point[j] - numerical.point[j]);
            }
            let cost = report.correction.cost(&point).unwrap();
            let iteration = report.iteration;
            assert!((cost - sum).abs() < 1e-12, "iteration {iteration}: {cost}, {sum}");
        }
    }
}

#[test]
fn an_actual_setting_replaces_the_one_asked_for_in_the_difference() {
    let mut campaign = gradient::Loop::new(single(-10.0, 10.0), single_settings(0.5, 0.5, 5)).unwrap();
    let asked = crate::problems::trials(campaign.ask(&mut |p| Ok(MODEL.cost(p))).unwrap());
    for trial in &asked {
        match trial.role {
            infuse::gradient::TrialRole::Plus(0) => {
                let actual = trial.point[0] + 0.2;
                campaign.tell_at(trial.id, actual, Ok(RIG.cost(&[actual])).into()).unwrap();
            }
            _ => campaign.tell(trial.id, Ok(RIG.cost(&trial.point)).into()).unwrap(),
        }
    }
    let slope = campaign.reports()[0].experiment_gradient[0].unwrap();
    let exact = RIG.slope(campaign.reports()[0].numerical.point[0]);
    assert!((slope - exact).abs() < 1e-9, "exact on a parabola: {slope}, {exact}");
}

#[test]
fn a_move_limit_holds_the_optimum_near_the_last() {
    let mut settings = single_settings(0.5, 0.1, 6);
    settings.move_limits = Some(vec![0.05]);
    let path = path(settings, Form::Repaired, MODEL, RIG);
    for (iteration, window) in path.windows(2).enumerate() {
        assert!((window[1] - window[0] - 0.05).abs() < 1e-9, "{iteration}: {path:?}");
    }
}

/// H = [[a, c], [c, b]] about an optimum.
fn bowl(h: [f64; 3], optimum: [f64; 2], p: &[f64]) -> f64 {
    let (x, y) = (p[0] - optimum[0], p[1] - optimum[1]);
    0.5 * (h[0] * x * x + h[1] * y * y) + h[2] * x * y
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// At the end the experiment's own difference is zero inside, and points out of the box at a
    /// bound: the conditions for an optimum of the experiment, whatever the model believes.
    #[test]
    fn the_fixed_point_is_stationary_for_the_experiment(
        model in [1.0..2.0, 1.0..2.0, -0.3..0.3],
        rig in [0.7..1.8, 0.7..1.8, -0.3..0.3],
        model_optimum in [-0.8..0.8, -0.8..0.8],
        rig_optimum in [-1.3..1.3, -1.3..1.3],
    ) {
        let problem = pair(-1.0, 1.0);
        let (r, tolerance) = (0.7, 1e-5);
        let mut settings = gradient::Settings::new(vec![r; 2], vec![0.05; 2]);
        settings.optimizer = optimizer(Strategy::Simultaneous);
        settings.optimizer.final_radius = 1e-6;
        settings.tolerances = Some(vec![tolerance; 2]);
        settings.max_iterations = 200;
        let mut campaign = gradient::Loop::new(problem, settings).unwrap();
        let simulation = &mut |p: &[f64]| Ok(bowl(model, model_optimum, p));
        let reason = campaign
            .run(simulation, &mut |trial| Ok(bowl(rig, rig_optimum, &trial.point)))
            .unwrap();
        prop_assert_eq!(reason, gradient::StopReason::Converged);
        let last = &campaign.reports()[campaign.reports().len() - 1];
        for j in 0..2 {
            let (here, slope) = (last.numerical.point[j], last.experiment_gradient[j].unwrap());
            if here <= -1.0 {
                prop_assert!(slope >= 0.0, "at the lower bound: {}", slope);
            } else if here >= 1.0 {
                prop_assert!(slope <= 0.0, "at the upper bound: {}", slope);
            } else {
                // A move within tolerance is the model's inverse curvature times R times the slope.
                prop_assert!(slope.abs() <= 4.0 * 2.3 * tolerance / r, "inside: {}", slope);
            }
        }
    }
}

#[test]
fn offset_is_the_cost_at_the_origin() {
    let mut campaign = pair_loop();
    campaign.run(&mut |p| simulated(p), &mut |trial| measured(&trial.point)).unwrap();
    let correction = campaign.correction();
    assert!(correction.offset().abs() > 0.01, "{correction:?}");
    assert_eq!(correction.offset().to_bits(), correction.cost(&[0.0, 0.0]).unwrap().to_bits());
}
