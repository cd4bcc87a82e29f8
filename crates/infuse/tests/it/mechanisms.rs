//! The two mechanisms of Section 3.5 and their combination, on pairs of model and truth with known optima.

use design_space::{Parameter, Region};
use infuse::gradient::{self, Ask, IdentifyingLoop, Mechanism, Reading, StopReason, Trial, UncertainModel};
use infuse::identification::{Answer, Settings, Unknowns};
use infuse::{Error, Outcome};

use crate::problems::pair;

/// Two responses that sum to the cost: bowls about an unknown place in each parameter, both tilted by what the family lacks.
fn responses(theta: &[f64], p: &[f64], tilt: f64) -> Vec<f64> {
    vec![
        1.0 + (p[0] - theta[0]).powi(2) + tilt * p[1],
        2.0 + 0.5 * (p[1] - theta[1]).powi(2) + 0.3 * p[0] * p[1] - tilt * p[0],
    ]
}

/// Where their sum is lowest: 2 (p0 − a) + 0.3 p1 = t and (p1 − b) + 0.3 p0 = −t.
fn optimum(theta: &[f64], tilt: f64) -> [f64; 2] {
    let (a, b) = (2.0 * theta[0] + tilt, theta[1] - tilt);
    let determinant = 2.0 - 0.09;
    [(a - 0.3 * b) / determinant, (2.0 * b - 0.3 * a) / determinant]
}

struct Family;

impl UncertainModel for Family {
    fn cost(&mut self, unknowns: &[f64], design: &[f64]) -> Result<f64, String> {
        Ok(responses(unknowns, design, 0.0).iter().sum())
    }

    fn responses(&mut self, unknowns: &[Vec<f64>], designs: &[Vec<f64>]) -> Vec<Vec<Answer>> {
        unknowns.iter().map(|theta| designs.iter().map(|p| Ok(responses(theta, p, 0.0))).collect()).collect()
    }
}

const TRUTH: [f64; 2] = [0.8, -0.5];

fn unknowns(start: [f64; 2]) -> Unknowns {
    let parameter = |name: &str| Parameter::continuous(name, "m", -2.0, 2.0).unwrap();
    Unknowns::new(Region::new(vec![parameter("a"), parameter("b")]).unwrap(), start.to_vec()).unwrap()
}

fn settings(trust: f64, iterations: usize) -> gradient::Settings {
    let mut settings = gradient::Settings::new(vec![trust; 2], vec![0.1; 2]);
    settings.max_iterations = iterations;
    settings.tolerances = Some(vec![1e-4; 2]);
    settings.optimizer.final_radius = 1e-6;
    settings
}

fn experiments(tilt: f64) -> impl FnMut(&[Trial]) -> Vec<Result<Reading, String>> {
    move |trials| {
        let read = |trial: &Trial| {
            let responses = responses(&TRUTH, &trial.point, tilt);
            Ok(Reading { cost: responses.iter().sum(), responses, standard_deviations: vec![0.01; 2] })
        };
        trials.iter().map(read).collect()
    }
}

fn campaign(mechanism: Mechanism, settings: gradient::Settings, unknowns: Unknowns) -> IdentifyingLoop {
    let names = vec!["first".into(), "second".into()];
    IdentifyingLoop::new(pair(-3.0, 3.0), settings, mechanism, unknowns, names, Settings::default()).unwrap()
}

/// The designs of all iterations.
fn designs(mechanism: Mechanism, settings: gradient::Settings, tilt: f64) -> (Vec<Vec<f64>>, IdentifyingLoop) {
    let mut campaign = campaign(mechanism, settings, unknowns([-0.4, 0.6]));
    campaign.run(&mut Family, &mut experiments(tilt)).unwrap();
    (campaign.turns().iter().map(|turn| turn.report.numerical.point.clone()).collect(), campaign)
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn with_the_truth_in_the_family_identification_ends_at_the_true_optimum_and_a_correction_need_not() {
    let best = optimum(&TRUTH, 0.0);
    for mechanism in [Mechanism::Identification, Mechanism::Both] {
        let (designs, campaign) = designs(mechanism, settings(0.1, 3), 0.0);
        assert!(distance(&designs[1], &best) < 1e-4, "{mechanism:?}: {designs:?}, not {best:?}");
        let turn = &campaign.turns()[1];
        assert!(distance(&turn.unknowns, &TRUTH) < 1e-6, "{turn:?}");
        // Counted once: of the differences that the first iteration measured nothing is left.
        assert!(turn.carried.slope().iter().all(|slope| slope.abs() < 1e-5), "{:?}", turn.carried);
    }
    let (designs, _) = designs(Mechanism::ResponseCorrection, settings(0.1, 3), 0.0);
    assert!(distance(&designs[2], &best) > 0.5, "{designs:?}");
}

#[test]
fn with_the_truth_outside_both_together_end_at_the_true_optimum_and_identification_alone_does_not() {
    let best = optimum(&TRUTH, 0.7);
    let (alone, _) = designs(Mechanism::Identification, settings(0.7, 30), 0.7);
    assert!(distance(alone.last().unwrap(), &best) > 0.05, "{alone:?}, {best:?}");
    let (both, campaign) = designs(Mechanism::Both, settings(0.7, 30), 0.7);
    assert!(distance(both.last().unwrap(), &best) < 2e-3, "{both:?}, {best:?}");
    assert_eq!(campaign.stop(), Some(StopReason::Converged));
    let found = campaign.identified(&mut Family).unwrap();
    assert!(found.p_of_misfit().unwrap() < 1e-3, "the fit says that the model is wrong");
}

/// A cost that is no number is refused where one is told, as by the other loops; where a rig answers at once it counts as a failure.
#[test]
fn a_cost_that_is_no_number_teaches_nothing() {
    let mut campaign = campaign(Mechanism::Both, settings(0.6, 2), unknowns([-0.4, 0.6]));
    let Ask::Trials(trials) = campaign.ask(&mut Family).unwrap() else { panic!("it has just begun") };
    let unusable = |cost: f64| Reading { cost, responses: vec![1.0, 2.0], standard_deviations: vec![0.01; 2] };
    let refused = campaign.tell(trials[0].id, Ok(unusable(f64::NAN)));
    assert!(matches!(refused, Err(Error::NonFiniteOutcome { .. })), "{refused:?}");
    assert_eq!((campaign.measurements().n_experiments(), campaign.measurements().n_failed()), (0, 0), "as before");
    let mut rig = |trials: &[Trial]| trials.iter().map(|_| Ok(unusable(f64::NAN))).collect();
    campaign.run(&mut Family, &mut rig).unwrap();
    let (n_experiments, n_failed) = (campaign.measurements().n_experiments(), campaign.measurements().n_failed());
    assert!(n_experiments == 0 && n_failed >= trials.len(), "{n_experiments} experiments, {n_failed} failures");
}

#[test]
fn the_correction_alone_is_the_gradient_loop_bit_for_bit() {
    let (_, campaign) = designs(Mechanism::ResponseCorrection, settings(0.6, 6), 0.7);
    let mut plain = gradient::Loop::new(pair(-3.0, 3.0), settings(0.6, 6)).unwrap();
    let mut experiment = |trial: &Trial| Ok(responses(&TRUTH, &trial.point, 0.7).iter().sum());
    plain.run(&mut |p| Family.cost(&[-0.4, 0.6], p), &mut experiment).unwrap();
    let reports: Vec<_> = campaign.turns().iter().map(|turn| turn.report.clone()).collect();
    assert_eq!(reports, plain.reports());
    assert!(campaign.turns().iter().all(|turn| turn.identification.is_none()));
}

/// With unknowns that change nothing, learning the correction anew gives the old one, bit for bit.
#[test]
fn with_nothing_to_identify_both_together_are_the_correction_alone() {
    struct Deaf;
    impl UncertainModel for Deaf {
        fn cost(&mut self, _: &[f64], design: &[f64]) -> Result<f64, String> {
            Family.cost(&[-0.4, 0.6], design)
        }

        fn responses(&mut self, unknowns: &[Vec<f64>], designs: &[Vec<f64>]) -> Vec<Vec<Answer>> {
            Family.responses(&vec![vec![-0.4, 0.6]; unknowns.len()], designs)
        }
    }
    let mut both = campaign(Mechanism::Both, settings(0.6, 6), unknowns([1.0, 1.0]));
    both.run(&mut Deaf, &mut experiments(0.7)).unwrap();
    let (_, alone) = designs(Mechanism::ResponseCorrection, settings(0.6, 6), 0.7);
    for (both, alone) in both.turns().iter().zip(alone.turns()) {
        assert_eq!((&both.report, &both.carried), (&alone.report, &alone.carried));
        assert!(distance(&both.unknowns, &[1.0, 1.0]) < 1e-9, "they keep their start");
    }
    assert_eq!(both.turns().len(), alone.turns().len());
}

#[test]
fn trials_come_back_in_any_order_and_some_fail() {
    let mut campaign = campaign(Mechanism::Both, settings(0.5, 2), unknowns([-0.4, 0.6]));
    while let Ask::Trials(trials) = campaign.ask(&mut Family).unwrap() {
        for trial in trials.iter().rev() {
            let mut read = experiments(0.0)(std::slice::from_ref(trial));
            let reading = if trial.id.number() == 2 { Err("the line broke".to_owned()) } else { read.remove(0) };
            campaign.tell(trial.id, reading).unwrap();
        }
    }
    assert_eq!((campaign.measurements().n_experiments(), campaign.measurements().n_failed()), (9, 1));
    assert!(distance(&campaign.identified(&mut Family).unwrap().values(), &TRUTH) < 1e-6);
    let failed = &campaign.turns()[0].report.trials[1];
    assert!(matches!(&failed.outcome, Some(Outcome::Failed { reason }) if reason == "the line broke"));
}

#[test]
fn readings_that_cannot_be_are_refused_and_change_nothing() {
    let mut campaign = campaign(Mechanism::Both, settings(0.5, 2), unknowns([-0.4, 0.6]));
    let Ask::Trials(trials) = campaign.ask(&mut Family).unwrap() else { panic!("nothing to do") };
    let before = campaign.clone();
    let reading = |responses, cost| Ok(Reading { cost, responses, standard_deviations: vec![0.1; 2] });
    let mut refused = |id, reading| {
        let error = campaign.tell(id, reading).unwrap_err();
        assert_eq!(campaign, before, "{error}");
        error
    };
    let id = trials[0].id;
    assert!(matches!(
        refused(id, reading(vec![1.0], 1.0)),
        Error::WrongCount { name: "values", found: 1, expected: 2, .. }
    ));
    assert!(matches!(refused(id, reading(vec![1.0, f64::NAN], 1.0)), Error::Entry { name: "values", index: 1, .. }));
    assert!(matches!(refused(infuse::TrialId::new(9), reading(vec![1.0; 2], 1.0)), Error::UnknownTrial { .. }));
}

fn text(campaign: &IdentifyingLoop) -> String {
    serde_json::to_string(campaign).unwrap()
}

fn again(campaign: &IdentifyingLoop) -> IdentifyingLoop {
    serde_json::from_str(&text(campaign)).unwrap()
}

/// A rig that loses a trial in nine, and reads digits that no decimal has.
fn awkward(trial: &Trial) -> Result<Reading, String> {
    if trial.id.number() % 9 == 4 {
        return Err("ballast lost".into());
    }
    let mut responses = responses(&TRUTH, &trial.point, 0.7);
    responses[0] += 1e-3 * (trial.id.number() as f64).sin();
    Ok(Reading { cost: responses.iter().sum(), responses, standard_deviations: vec![0.01, 0.02] })
}

#[test]
fn saving_and_loading_at_every_point_changes_no_bit() {
    for mechanism in [Mechanism::ResponseCorrection, Mechanism::Identification, Mechanism::Both] {
        let mut kept = campaign(mechanism, settings(0.5, 4), unknowns([-0.4, 0.6]));
        let mut restored = again(&kept);
        while let Ask::Trials(asked) = kept.ask(&mut Family).unwrap() {
            restored = again(&restored);
            assert_eq!(restored.ask(&mut Family).unwrap(), Ask::Trials(asked.clone()));
            for trial in asked.iter().rev() {
                restored = again(&restored);
                kept.tell(trial.id, awkward(trial)).unwrap();
                restored.tell(trial.id, awkward(trial)).unwrap();
                assert_eq!(restored, kept, "{mechanism:?}, after trial {}", trial.id);
            }
        }
        assert_eq!(kept.turns().len(), 4, "{mechanism:?}: long enough to mean something");
        assert_eq!(again(&kept), kept);
        assert_eq!(again(&kept).identified(&mut Family).unwrap(), kept.identified(&mut Family).unwrap());
    }
}

/// Two closed turns and one open with three trials told.
fn in_the_middle(mechanism: Mechanism) -> serde_json::Value {
    let mut campaign = campaign(mechanism, settings(0.5, 4), unknowns([-0.4, 0.6]));
    for told in [5, 5, 3] {
        let Ask::Trials(asked) = campaign.ask(&mut Family).unwrap() else { panic!("it goes on") };
        for trial in &asked[..told] {
            campaign.tell(trial.id, awkward(trial)).unwrap();
        }
    }
    serde_json::to_value(&campaign).unwrap()
}

#[track_caller]
fn check_refused(mechanism: Mechanism, pointer: &str, value: serde_json::Value, message: &str) {
    let mut state = in_the_middle(mechanism);
    *state.pointer_mut(pointer).expect("the field is there") = value;
    let error = serde_json::from_str::<IdentifyingLoop>(&state.to_string()).unwrap_err();
    assert!(error.to_string().contains(message), "{pointer}: {error}");
}

#[test]
fn a_saved_campaign_that_was_tampered_with_is_refused() {
    use serde_json::json;
    let check = |pointer: &str, value, message: &str| check_refused(Mechanism::Both, pointer, value, message);
    check("/format", json!(2), "format 2, expected 1");
    check("/settings/trust/0", json!(3.0), "expected 0 < R < 2");
    check("/settings/trust/0", json!(0.4), "follows from its optimum");
    check("/unknowns/start/0", json!(9.0), "the value is 9.0");
    check("/fit/max_steps", json!(0), "`max_steps`");
    check("/turns/0/unknowns/0", json!(0.1), "`unknowns` of turn 1, expected those that its identification found");
    check("/turns/1/unknowns/0", json!(0.1), "`unknowns` of turn 2, expected those that its identification found");
    check("/turns/0/carried/offset", json!(0.1), "`carried` of turn 1, expected nothing in the first turn");
    check("/turns/1/carried/slope", json!([0.1]), "`carried` of turn 2, expected a finite slope for each parameter");
    check("/turns/1/carried/slope/0", json!(0.1), "the correction that was known");
    check("/turns/1/report/trials/1/outcome", json!({"value": 9.0}), "follows from its optimum");
    check("/turns/1/report/correction/offset", json!(1.0), "follows from its optimum");
    check("/now/carried/slope/0", json!(0.5), "the correction that was known");
    check("/corrections", json!([]), "one for each turn, of finite numbers");
    check("/corrections/1/offset", json!(0.5), "the last one with which the open turn began");
    check("/measurements/rows/0/design/0", json!(0.5), "`measurements` of turn 3, expected the readings of all trials");
    check("/measurements/n_failed", json!(0), "expected the readings of all trials that were told");
    check("/measurements/rows/0/deviations/0", json!(0.0), "a positive number");
    check("/open/trials/0/outcome", json!(null), "expected the readings of all trials that were told");
    check_refused(Mechanism::Identification, "/settings/trust/0", json!(0.5), "zeros, where nothing is corrected");
    let carried = "`carried` of turn 2, expected the correction after the turn before";
    check_refused(Mechanism::ResponseCorrection, "/turns/1/carried/slope/0", json!(0.5), carried);
}

#[test]
fn unknown_keys_of_a_saved_campaign_are_refused() {
    for pointer in [
        "",
        "/unknowns",
        "/fit",
        "/measurements",
        "/measurements/rows/0",
        "/turns/1",
        "/turns/1/identification",
        "/now",
    ] {
        let mut state = in_the_middle(Mechanism::Both);
        state.pointer_mut(pointer).unwrap().as_object_mut().unwrap().insert("spare".into(), 1.into());
        let error = serde_json::from_str::<IdentifyingLoop>(&state.to_string()).unwrap_err();
        assert!(error.to_string().contains("unknown field `spare`"), "{pointer}: {error}");
    }
}
