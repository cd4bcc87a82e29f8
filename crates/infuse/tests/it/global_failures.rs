//! Experiments and simulations that fail, and settings that were not made.

use infuse::{
    Error, GlobalAsk, GlobalLoop, GlobalStopReason, Outcome, Spread, SpreadFallback, SpreadFault, TrialId, TrialUse,
};

use crate::global_problems::{asked, experiment, planar, save, simulation, truth};

fn failed() -> Outcome {
    Outcome::Failed { reason: "a tether broke".to_owned() }
}

fn campaign() -> GlobalLoop {
    let (region, settings) = planar();
    GlobalLoop::new(&region, settings).unwrap()
}

#[test]
fn a_failed_trial_is_left_out_and_reported() {
    let mut campaign = campaign();
    for trial in asked(campaign.ask(&mut simulation).unwrap()) {
        let outcome = if trial.id.number() == 5 { failed() } else { Outcome::Value(experiment(&trial)) };
        campaign.tell(trial.id, outcome).unwrap();
    }
    let report = &campaign.reports()[0];
    assert_eq!(report.failed_trials().count(), 1);
    assert_eq!(report.not_corrected, None);
    let surface = campaign.surfaces()[0].experiment.as_ref().unwrap();
    assert!(!surface.trials().contains(&TrialId::new(5)) && surface.trials().len() == 11);
}

#[test]
fn validation_runs_that_all_failed_give_no_spread() {
    for fallback in [SpreadFallback::KeepAll, SpreadFallback::Given(0.2), SpreadFallback::Stop] {
        let (region, mut settings) = planar();
        settings.fallback = fallback;
        let mut campaign = GlobalLoop::new(&region, settings).unwrap();
        for trial in asked(campaign.ask(&mut simulation).unwrap()) {
            let is_training = trial.used_for == TrialUse::Training;
            let outcome = if is_training { Outcome::Value(experiment(&trial)) } else { failed() };
            campaign.tell(trial.id, outcome).unwrap();
        }
        let (because, screening) = (SpreadFault::TooFew, &campaign.reports()[0].screening);
        match fallback {
            SpreadFallback::Given(s) => {
                assert_eq!(screening.spread, Spread::Given { s, because });
                assert!(screening.n_after < 576);
            }
            SpreadFallback::KeepAll | SpreadFallback::Stop => {
                assert_eq!((screening.spread, screening.n_after), (Spread::Undefined { because }, 576));
            }
        }
    }
}

#[test]
fn too_many_failures_end_the_campaign_without_information() {
    let mut campaign = campaign();
    // 12 experiments less 7 are fewer than the 6 terms.
    let trials = asked(campaign.ask(&mut simulation).unwrap());
    for trial in &trials {
        let outcome = if trial.id.number() <= 7 { failed() } else { Outcome::Value(experiment(trial)) };
        campaign.tell(trial.id, outcome).unwrap();
    }
    assert_eq!(campaign.stop(), Some(GlobalStopReason::NoInformation));
    let report = &campaign.reports()[0];
    assert!(report.not_corrected.as_ref().unwrap().contains("cannot determine 6 terms"), "{report:?}");
    assert!(report.changes.gap.is_none() && campaign.surfaces()[0].experiment.is_none());
    assert_eq!(campaign.ask(&mut simulation).unwrap(), GlobalAsk::Stopped(GlobalStopReason::NoInformation));
    // And the file with it can be read.
    let read: GlobalLoop = serde_json::from_str(&save(&campaign)).unwrap();
    assert_eq!(read.stop(), Some(GlobalStopReason::NoInformation));
}

#[test]
fn every_trial_may_fail() {
    let mut campaign = campaign();
    let stop = campaign.run(&mut simulation, &mut |_| Err("no water".to_owned())).unwrap();
    assert_eq!(stop, GlobalStopReason::NoInformation);
    assert_eq!(campaign.retained().n_retained(), 576);
}

#[test]
fn simulations_that_fail_are_reported_as_long_as_the_others_suffice() {
    let mut count = 0;
    let mut campaign = campaign();
    let trials = asked(
        campaign
            .ask(&mut |p| {
                count += 1;
                match count {
                    3 => Ok(f64::NAN),
                    4 => Err("slack tether".to_owned()),
                    _ => simulation(p),
                }
            })
            .unwrap(),
    );
    assert_eq!(count, 18);
    for trial in trials {
        campaign.tell(trial.id, Outcome::Value(experiment(&trial))).unwrap();
    }
    let reasons: Vec<_> = campaign.reports()[0].failed_simulations().map(|record| record.outcome.clone()).collect();
    let reason = |reason: &str| Outcome::Failed { reason: reason.to_owned() };
    assert_eq!(reasons, [reason("the simulation returned NaN"), reason("slack tether")]);
}

#[test]
fn too_few_simulations_are_an_error_that_changes_nothing() {
    let mut campaign = campaign();
    let before = save(&campaign);
    let error = campaign.ask(&mut |_| Err("no licence".to_owned())).unwrap_err();
    assert!(error.to_string().contains("all 18 simulations"), "{error}");
    assert!(matches!(error, Error::EverySimulationFailed { n_simulations: 18, .. }));
    let mut count = 0;
    let error = campaign.ask(&mut |p| {
        count += 1;
        if count > 5 { Err("diverged".to_owned()) } else { simulation(p) }
    });
    let error = error.unwrap_err();
    assert!(error.to_string().starts_with("13 of 18 simulations failed"), "{error}");
    assert_eq!(save(&campaign), before);
    assert_eq!(asked(campaign.ask(&mut simulation).unwrap()).len(), 12, "a mended simulation goes on");
}

#[test]
fn the_surfaces_use_the_settings_that_were_made() {
    let mut campaign = campaign();
    for trial in asked(campaign.ask(&mut simulation).unwrap()) {
        let wobble = 0.3 * (trial.id.number() as f64).cos();
        let actual = [trial.point[0] + wobble, trial.point[1] - 0.7 * wobble];
        campaign.tell_at(trial.id, &actual, Outcome::Value(truth(&actual))).unwrap();
    }
    // The truth is quadratic: at the actual settings it is reproduced exactly.
    let surface = campaign.surfaces()[0].experiment.clone().unwrap();
    for cell in (0..576).step_by(7) {
        let error = surface.surface().predict(&campaign.coded(cell).unwrap()) - truth(&campaign.point(cell).unwrap());
        assert!(error.abs() < 1e-10, "cell {cell}: {error}");
    }
}

#[test]
fn impossible_replies_are_refused_and_change_nothing() {
    let mut campaign = campaign();
    let id = asked(campaign.ask(&mut simulation).unwrap())[0].id;
    let before = save(&campaign);
    let mut refused = |id, actual: Option<&[f64]>, outcome| {
        let result = match actual {
            Some(actual) => campaign.tell_at(id, actual, outcome),
            None => campaign.tell(id, outcome),
        };
        let error = result.unwrap_err().to_string();
        assert_eq!(save(&campaign), before);
        error
    };
    let value = || Outcome::Value(1.0);
    assert!(refused(TrialId::new(13), None, value()).contains("never handed out"));
    assert!(refused(id, None, Outcome::Value(f64::INFINITY)).contains("told the value inf"));
    assert!(refused(id, Some(&[12.0]), value()).contains("a point has 1 coordinates"));
    assert!(refused(id, Some(&[12.0, 17.0]), value()).contains("of parameter `p1` is 17.0"));
    assert!(refused(id, Some(&[f64::NAN, 12.0]), value()).contains("of parameter `p0` is NaN"));
    campaign.tell(id, value()).unwrap();
    assert_eq!(campaign.tell(id, value()).unwrap_err(), Error::AlreadyTold { id });
}
