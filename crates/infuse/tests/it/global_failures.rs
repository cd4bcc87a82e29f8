//! Experiments and simulations that fail, and settings that were not made.

use design_space::Cell;
use infuse::{
    Error, Outcome, TrialId,
    correction::{Field, Gain, Law, Rule},
    global::reported::{Spread, SpreadFault},
    global::{self, SpreadFallback, TracedSurface, TrialUse},
};

use crate::global_problems::{asked, experiment, grid, planar, save, settings, simulation, truth};

fn failed() -> Outcome {
    Outcome::Failed { reason: "a tether broke".to_owned() }
}

fn campaign() -> global::Loop {
    let (region, settings) = planar();
    global::Loop::new(&region, settings).unwrap()
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
        let mut campaign = global::Loop::new(&region, settings).unwrap();
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

/// The experiments of batch 2 are too few for a surface: it is no round of the recursion, and the next one is.
#[test]
fn too_few_experiments_leave_the_correction_as_it_was() {
    for law in [Law::ProofRecursion, Law::CurrentSimulation] {
        let (region, mut settings) = planar();
        settings.correction = Rule::new(law, Gain::constant(0.5).unwrap());
        settings.max_batches = 4;
        let mut campaign = global::Loop::new(&region, settings).unwrap();
        let mut curved = |cell: Cell, p: &[f64]| Ok(simulation(cell, p)? + 0.3 * (2.0 * p[0]).sin());
        let mut field = Field::new(campaign.settings().correction, 576).unwrap();
        for batch in 1..=3 {
            for trial in asked(campaign.ask(&mut curved).unwrap()) {
                // 12 experiments less 7 are fewer than the 6 terms.
                let fails = batch == 2 && trial.id.number() <= 19;
                let outcome = if fails { failed() } else { Outcome::Value(experiment(&trial)) };
                campaign.tell(trial.id, outcome).unwrap();
            }
            assert_eq!(campaign.stop(), None);
            // What was saved is read, whatever failed.
            campaign = serde_json::from_str(&save(&campaign)).unwrap();
            let sampled = |surface: &TracedSurface| -> Vec<f64> {
                campaign.grid().cells().map(|cell| surface.surface().predict(&campaign.coded(cell).unwrap())).collect()
            };
            let (report, surfaces) = (&campaign.reports()[batch - 1], &campaign.surfaces()[batch - 1]);
            match &surfaces.experiment {
                Some(experiment) => field.update(&sampled(experiment), &sampled(&surfaces.simulation)).unwrap(),
                None => {
                    assert!(report.not_corrected.as_ref().unwrap().contains("cannot determine 6 terms"), "{report:?}");
                    assert!(report.changes.gap.is_none() && report.changes.experiment.is_none());
                }
            }
            assert_eq!(surfaces.experiment.is_none(), batch == 2);
            for (found, expected) in sampled(&surfaces.correction).iter().zip(field.correction()) {
                assert!((found - expected).abs() < 1e-9, "{law:?}, batch {batch}: {found} {expected}");
            }
        }
        for trial in asked(campaign.ask(&mut curved).unwrap()) {
            campaign.tell(trial.id, failed()).unwrap();
        }
        assert_eq!(campaign.stop(), Some(global::StopReason::NoInformation));
        let ask = campaign.ask(&mut curved).unwrap();
        assert_eq!(ask, global::Ask::Stopped(global::StopReason::NoInformation));
        let read: global::Loop = serde_json::from_str(&save(&campaign)).unwrap();
        assert_eq!(read.stop().unwrap().to_string(), "every experiment of the last batch failed");
    }
}

#[test]
fn every_trial_may_fail() {
    let mut campaign = campaign();
    let stop = campaign.run(&mut simulation, &mut |_| Err("no water".to_owned())).unwrap();
    assert_eq!(stop, global::StopReason::NoInformation);
    assert_eq!(campaign.retained().n_retained(), 576);
}

#[test]
fn simulations_that_fail_are_reported_as_long_as_the_others_suffice() {
    let mut count = 0;
    let mut campaign = campaign();
    let trials = asked(
        campaign
            .ask(&mut |cell, p| {
                count += 1;
                match count {
                    3 => Ok(f64::NAN),
                    4 => Err("slack tether".to_owned()),
                    _ => simulation(cell, p),
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
fn too_few_simulations_are_an_error_and_the_next_ask_simulates_elsewhere() {
    let mut campaign = campaign();
    let mut asked_before: Vec<Vec<f64>> = Vec::new();
    let error = campaign.ask(&mut |_, p| {
        asked_before.push(p.to_vec());
        Err("no licence".to_owned())
    });
    let error = error.unwrap_err();
    assert!(error.to_string().starts_with("all 18 simulations failed, the first at ["), "{error}");
    assert!(matches!(error, Error::EverySimulationFailed { n_simulations: 18, .. }));
    let mut count = 0;
    let mut restored: global::Loop = serde_json::from_str(&save(&campaign)).unwrap();
    assert_eq!(restored, campaign);
    let error = restored.ask(&mut |cell, p| {
        count += 1;
        assert!(!asked_before.contains(&p.to_vec()), "{p:?} had failed");
        if count > 5 { Err("diverged".to_owned()) } else { simulation(cell, p) }
    });
    let error = error.unwrap_err();
    assert!(error.to_string().starts_with("13 of 18 simulations failed"), "{error}");
    assert!(restored.reports().is_empty() && restored.outstanding().is_empty());
    assert_eq!(asked(restored.ask(&mut simulation).unwrap()).len(), 12, "a mended simulation goes on");
    assert!(save(&restored).ends_with(r#""failed_cells":[]}"#), "and forgets what had failed");
}

#[test]
fn a_simulation_that_never_works_is_tried_all_over_the_grid_again_and_again() {
    let settings = settings(design_space::Model::additive_quadratic(2).unwrap(), 6, 8);
    let mut campaign = global::Loop::new(&grid(&[5, 4]), settings).unwrap();
    let mut batches = Vec::new();
    for _ in 0..4 {
        let mut batch = Vec::new();
        campaign
            .ask(&mut |cell, p| {
                assert_eq!(cell, campaign_cell(p));
                batch.push(cell);
                Err("diverged".to_owned())
            })
            .unwrap_err();
        batch.sort_unstable();
        batches.push(batch);
    }
    // Of 20 cells 8, then 8 others; the last 4 do not determine 5 terms, so it begins anew.
    assert!(batches[1].iter().all(|cell| !batches[0].contains(cell)), "{batches:?}");
    assert_eq!((&batches[2], &batches[3]), (&batches[0], &batches[1]));
}

/// The cell of a natural point of the 5 x 4 grid.
fn campaign_cell(p: &[f64]) -> Cell {
    let settings = settings(design_space::Model::additive_quadratic(2).unwrap(), 6, 8);
    global::Loop::new(&grid(&[5, 4]), settings).unwrap().cell(p).unwrap()
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
    for cell in campaign.grid().cells().step_by(7) {
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
    assert!(
        refused(id, None, Outcome::Value(f64::INFINITY))
            .contains("is inf, expected a number of magnitude at most 1e100")
    );
    assert!(refused(id, Some(&[12.0]), value()).contains("coordinates of a point: 1, expected 2"));
    assert!(refused(id, Some(&[12.0, 17.0]), value()).contains("of parameter `p1` is 17.0"));
    assert!(refused(id, Some(&[f64::NAN, 12.0]), value()).contains("of parameter `p0` is NaN"));
    campaign.tell(id, value()).unwrap();
    assert_eq!(campaign.tell(id, value()).unwrap_err(), Error::SecondOutcome { id });
}
