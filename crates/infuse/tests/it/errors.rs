//! One test per way of being wrong; the state is never changed by one.

use design_space::Region;
use infuse::codesign::{OptimizerSettings, Strategy, codesign};
use infuse::{CodesignProblem, Error, Outcome, Role, TrialId, gradient};

use crate::problems::{failed, optimizer, pair, pair_loop, region, simulated, single, trials};

fn settings() -> gradient::Settings {
    gradient::Settings::new(vec![0.5, 0.8], vec![0.1, 0.05])
}

#[track_caller]
fn check(change: impl FnOnce(&mut gradient::Settings), message: &str) {
    let mut settings = settings();
    change(&mut settings);
    let error = gradient::Loop::new(pair(-1.0, 1.0), settings).unwrap_err();
    assert_eq!(error.to_string(), message);
}

#[test]
fn rejects_lists_of_another_length() {
    let expected = "has 1 entries, expected 2: one per parameter";
    check(|s| s.trust = vec![0.5], &format!("`trust` {expected}"));
    check(|s| s.experiment_steps = vec![0.1], &format!("`experiment_steps` {expected}"));
    check(|s| s.model_steps = Some(vec![0.1]), &format!("`model_steps` {expected}"));
    check(|s| s.tolerances = Some(vec![0.1]), &format!("`tolerances` {expected}"));
    check(|s| s.move_limits = Some(vec![0.1]), &format!("`move_limits` {expected}"));
    let roles = CodesignProblem::new(region(&[(0.0, 1.0); 2]), vec![Role::Plant]).unwrap_err();
    assert_eq!(roles.to_string(), format!("`roles` {expected}"));
    let correction = pair_loop().correction();
    assert!(matches!(correction.cost(&[0.0]), Err(Error::WrongLength { name: "point", .. })));
}

#[test]
fn rejects_trust_factors_that_cannot_settle() {
    for r in ["0.0", "-0.1", "2.0", "NaN", "inf"] {
        let value: f64 = r.parse().unwrap();
        let message = format!("setting `trust` of parameter `p1` is {r}, expected 0 < R < 2");
        check(|s| s.trust[1] = value, &message);
    }
}

#[test]
fn rejects_steps_that_cannot_be_made() {
    for step in ["0.0", "-0.1", "1.0", "NaN", "inf", "1e-13"] {
        let value: f64 = step.parse().unwrap();
        let tail =
            format!("of parameter `p0` is {step}, expected a step above rounding and under half the parameter's width");
        check(|s| s.experiment_steps[0] = value, &format!("setting `experiment_steps` {tail}"));
        let model = Some(vec![value, 0.1]);
        check(|s| s.model_steps = model, &format!("setting `model_steps` {tail}"));
    }
}

#[test]
fn rejects_tolerances_and_move_limits_that_mean_nothing() {
    let tail = "of parameter `p0` is 0.0, expected a positive number";
    check(|s| s.tolerances = Some(vec![0.0, 0.1]), &format!("setting `tolerances` {tail}"));
    let above_rounding =
        |limit: &str| format!("setting `move_limits` of parameter `p0` is {limit}, expected a length above rounding");
    check(|s| s.move_limits = Some(vec![0.0, 0.1]), &above_rounding("0.0"));
    check(|s| s.move_limits = Some(vec![1e-30, 0.1]), &above_rounding("1e-30"));
    check(|s| s.move_limits = Some(vec![f64::INFINITY, 0.1]), &above_rounding("inf"));
    check(
        |s| s.tolerances = Some(vec![0.1, 1e-4]),
        "setting `tolerances` of parameter `p1` is 0.0001, \
         expected at least the optimizer's final_radius times half the parameter's width",
    );
}

#[test]
fn rejects_a_start_outside_the_region() {
    let message = "parameter `p1`: the value is 1.5, expected -1.0 to 1.0 m";
    check(|s| s.start = Some(vec![0.0, 1.5]), message);
    let start = codesign(&pair(-1.0, 1.0), &OptimizerSettings::default(), &[0.0, 1.5], &mut simulated);
    assert_eq!(start.unwrap_err().to_string(), message);
    let short = codesign(&pair(-1.0, 1.0), &OptimizerSettings::default(), &[0.0], &mut simulated);
    assert!(matches!(short, Err(Error::DesignSpace(design_space::Error::WrongDimension { .. }))));
}

#[test]
fn rejects_optimizer_settings_out_of_range() {
    check(|s| s.max_iterations = 0, "setting `max_iterations` is 0, expected at least 1");
    check(|s| s.optimizer.max_sweeps = 0, "setting `max_sweeps` is 0, expected at least 1");
    check(|s| s.optimizer.max_simulations = 0, "setting `max_simulations` is 0, expected at least 1");
    check(|s| s.optimizer.max_search_steps = 0, "setting `max_search_steps` is 0, expected at least 1");
    check(|s| s.optimizer.initial_radius = 1.5, "setting `initial_radius` is 1.5, expected 0 < radius <= 1");
    let tail = "expected 0 < radius <= initial_radius";
    check(|s| s.optimizer.final_radius = f64::NAN, &format!("setting `final_radius` is NaN, {tail}"));
    check(|s| s.optimizer.inner_final_radius = 0.5, &format!("setting `inner_final_radius` is 0.5, {tail}"));
}

#[test]
fn a_strategy_that_needs_both_kinds_says_so() {
    for strategy in [Strategy::Nested, Strategy::Sequential, Strategy::Iterative] {
        let error = codesign(&single(0.0, 1.0), &optimizer(strategy), &[0.5], &mut |_| Ok(0.0));
        assert_eq!(
            error.unwrap_err().to_string(),
            format!(
                "the {strategy} strategy needs plant and controller parameters, found 1 and 0: \
                 use the simultaneous strategy"
            )
        );
    }
    let plant_only = gradient::Loop::new(single(0.0, 1.0), gradient::Settings::new(vec![0.5], vec![0.1]));
    assert!(matches!(plant_only, Err(Error::NeedsPlantAndController { .. })));
}

#[test]
fn a_region_of_its_own_faults_stays_its_error() {
    assert_eq!(
        Error::from(Region::new(vec![]).unwrap_err()).to_string(),
        design_space::Error::NoParameters.to_string()
    );
}

#[test]
fn a_wrong_tell_is_an_error_and_changes_nothing() {
    let mut campaign = pair_loop();
    let none = campaign.tell(TrialId::new(1), Outcome::Value(1.0)).unwrap_err();
    assert_eq!(none, Error::UnknownTrial { id: TrialId::new(1) });
    let asked = trials(campaign.ask(&mut simulated).unwrap());
    campaign.tell(asked[2].id, Outcome::Value(1.0)).unwrap();
    let before = campaign.clone();

    for number in [0, 6, u64::MAX] {
        let id = TrialId::new(number);
        assert_eq!(campaign.tell(id, Outcome::Value(1.0)), Err(Error::UnknownTrial { id }));
    }
    let id = asked[2].id;
    assert_eq!(campaign.tell(id, failed("late")), Err(Error::SecondOutcome { id }));
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let told = campaign.tell(asked[0].id, Outcome::Value(value));
        assert!(matches!(told, Err(Error::NonFiniteOutcome { .. })), "{told:?}");
    }
    for (trial, actual) in [
        (&asked[0], 0.0),
        (&asked[1], asked[0].point[0] - 0.1),
        (&asked[1], f64::NAN),
        (&asked[3], f64::INFINITY),
        (&asked[1], 1e9),
    ] {
        let told = campaign.tell_at(trial.id, actual, Outcome::Value(1.0));
        assert!(matches!(told, Err(Error::ActualSetting { .. })), "{told:?}");
    }
    assert_eq!(asked[1].role, gradient::TrialRole::Plus(0), "the trial the test is about");
    assert_eq!(campaign, before, "nothing has changed");
}

#[test]
fn a_trial_of_a_closed_iteration_has_been_told() {
    let mut campaign = pair_loop();
    for trial in trials(campaign.ask(&mut simulated).unwrap()) {
        campaign.tell(trial.id, Outcome::Value(1.0)).unwrap();
    }
    let id = TrialId::new(3);
    assert_eq!(campaign.tell(id, Outcome::Value(1.0)), Err(Error::SecondOutcome { id }));
}
