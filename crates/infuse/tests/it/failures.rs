//! What fails is reported, is never taken for data, and does not end the study.

use infuse::codesign::{CodesignStop, Strategy, codesign};
use infuse::{Error, Outcome, gradient};

use crate::problems::{failed, measured, optimizer, pair, pair_loop, simulated, single, single_settings, trials};

#[test]
fn a_simulation_that_fails_beside_the_optimum_is_walked_around() {
    for strategy in [Strategy::Nested, Strategy::Simultaneous, Strategy::Iterative] {
        let mut asked = Vec::new();
        let mut cost = |p: &[f64]| {
            asked.push(p.to_vec());
            if p[0] > 0.35 && p[1] > 0.0 {
                return Err(format!("diverged at {:.2}", p[0]));
            }
            Ok((p[0] - 0.3).powi(2) + (p[1] + 0.2).powi(2))
        };
        let report = codesign(&pair(-1.0, 1.0), &optimizer(strategy), &[0.0, 0.2], &mut cost).unwrap();
        assert!((report.point[0] - 0.3).abs() < 1e-2, "{strategy}: {report:?}");
        assert!((report.point[1] + 0.2).abs() < 1e-2, "{strategy}: {report:?}");
        assert_eq!(report.n_simulations, asked.len(), "every call is counted");
        let expected: Vec<_> = asked.iter().filter(|p| p[0] > 0.35 && p[1] > 0.0).collect();
        let listed: Vec<_> = report.failures.iter().map(|failure| &failure.point).collect();
        assert_eq!(listed, expected, "every failure, in order");
        assert!(!listed.is_empty(), "{strategy} met the hole");
        assert!(report.failures.iter().all(|f| f.reason.starts_with("diverged")), "its own words");
    }
}

#[test]
fn an_optimum_on_the_edge_of_the_flyable_region_is_a_point_that_flew() {
    let mut cost = |p: &[f64]| {
        if p[0] + p[1] > 0.5 {
            return Err("slack tether".to_owned());
        }
        Ok(100.0 - p[0] - p[1])
    };
    let report = codesign(&pair(-1.0, 1.0), &optimizer(Strategy::Nested), &[0.0, 0.0], &mut cost).unwrap();
    assert!(report.point[0] + report.point[1] <= 0.5, "{report:?}");
    assert_eq!(Ok(report.cost), cost(&report.point), "its own cost, not the barrier");
    assert!(report.cost < 99.6, "and near the edge: {}", report.cost);
}

#[test]
fn a_cost_that_is_not_finite_is_a_failure() {
    let mut cost = |p: &[f64]| Ok(if p[0] > 0.5 { f64::NAN } else { -p[0] });
    let settings = optimizer(Strategy::Simultaneous);
    let report = codesign(&pair(-1.0, 1.0), &settings, &[0.0, 0.0], &mut cost).unwrap();
    assert_eq!(report.failures[0].reason, "the simulation returned NaN");
    assert!(report.point[0] <= 0.5 && report.cost.is_finite(), "{report:?}");
}

#[test]
fn a_plant_on_which_no_controller_flies_is_left() {
    let mut cost = |p: &[f64]| {
        if p[0] < 0.2 {
            return Err("no controller holds this plant".to_owned());
        }
        Ok((p[0] - 0.4).powi(2) + (p[1] - 0.1).powi(2))
    };
    // The start itself does not fly.
    let report = codesign(&pair(-1.0, 1.0), &optimizer(Strategy::Nested), &[-0.5, 0.0], &mut cost).unwrap();
    assert!((report.point[0] - 0.4).abs() < 1e-2, "{report:?}");
}

#[test]
fn when_every_simulation_fails_the_error_says_where_and_why() {
    let mut campaign = pair_loop();
    let before = campaign.clone();
    let error = campaign.ask(&mut |_| Err("no water".to_owned())).unwrap_err();
    let Error::EverySimulationFailed { n_simulations, first_point, first_reason } = error else {
        panic!("{error}");
    };
    assert_eq!((first_point, first_reason.as_str()), (vec![0.0, 0.0], "no water"));
    assert_eq!(n_simulations, 25, "five controllers on each of five plants");
    assert_eq!(campaign, before, "nothing has changed");
    assert!(matches!(campaign.ask(&mut simulated), Ok(gradient::Ask::Trials(_))), "the next one may work");
}

#[test]
fn the_limit_on_simulations_ends_the_search_with_the_best_so_far() {
    let mut settings = optimizer(Strategy::Nested);
    settings.max_simulations = 40;
    let mut count = 0;
    let mut cost = |p: &[f64]| {
        count += 1;
        simulated(p)
    };
    let report = codesign(&pair(-1.0, 1.0), &settings, &[0.0, 0.0], &mut cost).unwrap();
    assert_eq!((count, report.n_simulations), (40, 40));
    assert_eq!(report.stop, CodesignStop::SimulationLimit);
    assert!(report.failures.is_empty(), "what was not run has not failed");
}

#[test]
fn the_limit_on_steps_of_one_search_is_reported() {
    let mut settings = optimizer(Strategy::Simultaneous);
    settings.max_search_steps = 8;
    let mut cost = |p: &[f64]| Ok((1.0 - p[0]).powi(2) + 100.0 * (p[1] - p[0] * p[0]).powi(2));
    let report = codesign(&pair(-1.0, 1.0), &settings, &[-0.9, 0.9], &mut cost).unwrap();
    assert_eq!(report.stop, CodesignStop::SearchLimit);
}

/// Tells the first iteration, failing the trials of these roles.
fn first_iteration(failing: &[gradient::TrialRole]) -> gradient::Loop {
    let mut campaign = pair_loop();
    for trial in trials(campaign.ask(&mut simulated).unwrap()) {
        let outcome =
            if failing.contains(&trial.role) { failed("line tangled") } else { measured(&trial.point).into() };
        campaign.tell(trial.id, outcome).unwrap();
    }
    assert_eq!(campaign.reports().len(), 1, "closed");
    campaign
}

/// Forward, backward and central differences of the rig at the first optimum.
fn differences(campaign: &gradient::Loop, index: usize, step: f64) -> [f64; 3] {
    let center = &campaign.reports()[0].numerical.point;
    let at = |offset: f64| {
        let mut point = center.clone();
        point[index] += offset;
        measured(&point).unwrap()
    };
    [(at(step) - at(0.0)) / step, (at(0.0) - at(-step)) / step, (at(step) - at(-step)) / (2.0 * step)]
}

#[track_caller]
fn check_slope(campaign: &gradient::Loop, index: usize, expected: f64) {
    let report = &campaign.reports()[0];
    let slope = report.experiment_gradient[index].expect("the slope is known");
    assert!((slope - expected).abs() < 1e-9, "{slope} is not {expected}");
    assert!(report.is_corrected[index], "{report:?}");
}

#[test]
fn a_failed_side_leaves_a_one_sided_difference() {
    let campaign = first_iteration(&[gradient::TrialRole::Plus(0), gradient::TrialRole::Minus(1)]);
    check_slope(&campaign, 0, differences(&campaign, 0, 0.1)[1]);
    check_slope(&campaign, 1, differences(&campaign, 1, 0.05)[0]);
    assert_eq!(campaign.reports()[0].failed_trials().count(), 2);
    assert_eq!(campaign.reports()[0].n_experiments(), 5, "failed ones cost water too");
}

#[test]
fn a_failed_center_leaves_the_central_differences() {
    let campaign = first_iteration(&[gradient::TrialRole::Center]);
    check_slope(&campaign, 0, differences(&campaign, 0, 0.1)[2]);
    check_slope(&campaign, 1, differences(&campaign, 1, 0.05)[2]);
    assert_eq!(campaign.reports()[0].experiment_cost, None);
}

#[test]
fn an_unknown_slope_leaves_the_correction_of_that_parameter_as_it_was() {
    let campaign = first_iteration(&[gradient::TrialRole::Center, gradient::TrialRole::Plus(0)]);
    let report = &campaign.reports()[0];
    assert_eq!(report.experiment_gradient[0], None);
    assert_eq!(report.is_corrected, [false, true]);
    assert_eq!(report.correction.slope()[0].to_bits(), 0.0_f64.to_bits(), "untouched");
    check_slope(&campaign, 1, differences(&campaign, 1, 0.05)[2]);
    assert_eq!(campaign.stop(), None, "the other parameter was learned");
}

#[test]
fn an_iteration_that_teaches_nothing_ends_the_campaign() {
    let every = [0, 1].map(|j| [gradient::TrialRole::Plus(j), gradient::TrialRole::Minus(j)]).concat();
    let campaign = first_iteration(&every);
    assert_eq!(campaign.stop(), Some(gradient::StopReason::NoInformation));
    assert!(!campaign.is_converged(), "that is not convergence");
}

#[test]
fn an_unlearned_parameter_does_not_count_as_settled() {
    let mut campaign = pair_loop();
    let reason = campaign
        .run(&mut simulated, &mut |trial| match trial.role {
            gradient::TrialRole::Plus(0) | gradient::TrialRole::Minus(0) => Err("jammed".to_owned()),
            _ => measured(&trial.point),
        })
        .unwrap();
    assert_eq!(reason, gradient::StopReason::IterationLimit);
}

#[test]
fn a_model_that_fails_beside_its_optimum_has_a_one_sided_slope() {
    let mut campaign = gradient::Loop::new(single(-10.0, 10.0), single_settings(0.5, 0.5, 3)).unwrap();
    // Around the optimum 1, only the step of the model gradient to 1.05 meets the hole.
    let mut cost = |p: &[f64]| {
        if (p[0] - 1.05).abs() < 1e-4 {
            return Err("hole".to_owned());
        }
        Ok((p[0] - 1.0).powi(2))
    };
    campaign.ask(&mut cost).unwrap();
    let numerical = campaign.current_optimum().unwrap();
    assert_eq!(numerical.failures.len(), 1);
    let slope = numerical.model_gradient[0].unwrap();
    assert!(slope.abs() < 1e-6, "two points below, exact on a parabola: {slope}");
}

#[test]
fn an_outcome_from_a_result_keeps_the_reason() {
    assert_eq!(Outcome::from(Ok(2.0)), Outcome::Value(2.0));
    assert_eq!(Outcome::from(Err("rain".to_owned())), failed("rain"));
    assert_eq!(Outcome::from(Ok(f64::INFINITY)), failed("the experiment returned inf"));
    assert!(matches!(Outcome::from(Ok(1e101)), Outcome::Failed { .. }), "no surface takes it");
    assert_eq!(Outcome::from(Ok(-1e100)), Outcome::Value(-1e100));
}
