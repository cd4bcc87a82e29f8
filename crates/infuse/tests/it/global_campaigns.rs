//! What people who run campaigns need: plans, repeats, earlier experiments, noise, and whether to go on.

use design_space::{Cell, Model};
use infuse::{Error, Outcome, global};
use statrs::distribution::{Continuous, ContinuousCDF, Normal};
use surface::{Confounded, Data, Regression, Surface};

use crate::global_problems::{after, asked, coded, experiment, grid, planar, save, settings, simulation, truth};

fn planned(campaign: &global::Loop) -> global::Plan {
    campaign.plan().unwrap().expect("no trials are outstanding")
}

#[test]
fn planning_and_opening_is_asking() {
    let (region, settings) = planar();
    let mut asking = global::Loop::new(&region, settings).unwrap();
    let mut planning = asking.clone();
    for _ in 0..3 {
        let trials = asked(asking.ask(&mut simulation).unwrap());
        let plan = planned(&planning);
        assert_eq!(planning.open(&plan, &mut simulation).unwrap(), trials);
        assert_eq!(planning.plan().unwrap(), None, "trials are outstanding");
        for trial in &trials {
            let outcome = Outcome::Value(experiment(trial));
            asking.tell(trial.id, outcome.clone()).unwrap();
            planning.tell(trial.id, outcome).unwrap();
        }
        assert_eq!(asking.reports(), planning.reports());
    }
}

#[test]
fn plans_that_no_batch_can_have_are_refused_and_change_nothing() {
    let (region, settings) = planar();
    let mut campaign = global::Loop::new(&region, settings).unwrap();
    let plan = planned(&campaign);
    let before = save(&campaign);
    let short = global::Plan { experiments: plan.experiments[1..].to_vec(), ..plan.clone() };
    let mut outside = plan.clone();
    outside.simulations[0] = Cell::new(576);
    for wrong in [short, outside] {
        let error = campaign.open(&wrong, &mut simulation).unwrap_err();
        assert!(matches!(error, Error::Plan { batch: 1, .. }), "{error}");
        assert_eq!(save(&campaign), before);
    }
    campaign.open(&plan, &mut simulation).unwrap();
    let error = campaign.open(&plan, &mut simulation).unwrap_err();
    assert_eq!(error.to_string(), "the plan of batch 1 is not usable, expected none while trials are outstanding");
}

#[test]
fn as_many_experiments_repeat_others_as_the_settings_say() {
    let (region, mut settings) = planar();
    for replicates in [0, 1, 3, 6] {
        settings.replicates = replicates;
        let plan = planned(&global::Loop::new(&region, settings.clone()).unwrap());
        let mut cells = plan.experiments.clone();
        cells.sort_unstable();
        cells.dedup();
        assert_eq!(cells.len(), 12 - replicates, "{replicates}");
    }
    settings.replicates = 7;
    let error = global::Loop::new(&region, settings).unwrap_err();
    assert!(error.to_string().starts_with("setting `replicates` is 7, expected at most half"), "{error}");
}

#[test]
fn pure_error_is_the_pooled_scatter_of_equal_settings() {
    let (region, mut settings) = planar();
    settings.replicates = 3;
    let mut campaign = global::Loop::new(&region, settings).unwrap();
    assert_eq!(campaign.pure_error(), None, "nothing was told");
    let trials = asked(campaign.ask(&mut simulation).unwrap());
    let reading = |number: u64| (number * number % 7) as f64;
    for trial in &trials {
        campaign.tell(trial.id, Outcome::Value(reading(trial.id.number()))).unwrap();
    }
    // By pairs: two readings a and b scatter (a - b)²/2 about their mean.
    let mut squares = 0.0;
    for (index, trial) in trials.iter().enumerate() {
        for other in trials[..index].iter().filter(|other| other.cell == trial.cell) {
            squares += 0.5 * (reading(trial.id.number()) - reading(other.id.number())).powi(2);
        }
    }
    let error = campaign.pure_error().expect("repeats");
    // Three pairs, or a triple that counts each of its pairs once where two thirds are due.
    let groups: std::collections::BTreeSet<Cell> = trials.iter().map(|trial| trial.cell).collect();
    assert_eq!((groups.len(), error.degrees_of_freedom), (9, 3));
    assert!(squares > 0.0);
    assert!((error.variance - squares / 3.0).abs() < 1e-12, "{} {squares}", error.variance);
}

#[test]
fn earlier_experiments_train_the_surfaces_and_validate_nothing() {
    let (region, settings) = planar();
    let mut campaign = global::Loop::new(&region, settings).unwrap();
    let earlier = [([11.07, 12.9], 4.4), ([14.3, 9.8], 6.1)];
    for (point, cost) in earlier {
        campaign.add_earlier(&point, cost, "notebook 3, page 12").unwrap();
    }
    let trials = asked(campaign.ask(&mut simulation).unwrap());
    trials.iter().for_each(|trial| campaign.tell(trial.id, Outcome::Value(experiment(trial))).unwrap());
    assert_eq!(campaign.reports()[0].n_earlier, 2);

    // The experiment surface by hand, all fourteen.
    let own = trials.iter().map(|trial| (coded(&trial.point), experiment(trial)));
    let all: Vec<_> = own.chain(earlier.map(|(point, cost)| (coded(&point), cost))).collect();
    let points = all.iter().flat_map(|(point, _)| point.clone()).collect();
    let data = Data::new(2, points, all.iter().map(|(_, cost)| *cost).collect()).unwrap();
    let by_hand = Regression::fit_with(&Model::quadratic(2).unwrap(), &data, Confounded::Refuse).unwrap();
    let found = campaign.surfaces()[0].experiment.as_ref().unwrap();
    for point in [[0.1, 0.2], [-0.9, 0.6]] {
        assert!((found.surface().predict(&point) - by_hand.predict(&point)).abs() < 1e-12);
    }
    let n_training =
        trials.len() - trials.iter().filter(|trial| trial.used_for == infuse::global::TrialUse::Validation).count();
    let combined = campaign.surfaces()[0].combined.regression().unwrap().data();
    assert_eq!(combined.n_points(), n_training + 2 + 18, "training, earlier, simulations");

    let restored: global::Loop = serde_json::from_str(&save(&campaign)).unwrap();
    assert_eq!(restored, campaign);
    assert_eq!(save(&restored), save(&campaign));
}

#[test]
fn an_earlier_experiment_is_forgotten_with_its_cell_and_counts_from_its_batch_on() {
    let (_, settings) = planar();
    let mut campaign = after(2, settings);
    // (10, 14) is far from the optimum at (13, 11.4).
    assert!(campaign.retained().share() < 0.9 && !campaign.is_retained(campaign.cell(&[10.0, 14.0]).unwrap()));
    let kept = campaign.reports()[1].screening.optimum.clone();
    campaign.add_earlier(&[10.0, 14.0], 9.0, "far").unwrap();
    campaign.add_earlier(&kept, truth(&kept), "near").unwrap();
    let plan = global::Loop::plan(&campaign).unwrap();
    assert_eq!(plan, None, "the limit of two batches was reached");
    let mut text: serde_json::Value = serde_json::from_str(&save(&campaign)).unwrap();
    text["settings"]["max_batches"] = 3.into();
    let mut campaign: global::Loop = serde_json::from_value(text).unwrap();
    let trials = asked(campaign.ask(&mut simulation).unwrap());
    trials.iter().for_each(|trial| campaign.tell(trial.id, Outcome::Value(experiment(trial))).unwrap());
    let counted: Vec<usize> = campaign.reports().iter().map(|report| report.n_earlier).collect();
    assert_eq!(counted, [0, 0, 1]);
    assert_eq!((campaign.withdraw_earlier("near"), campaign.withdraw_earlier("near")), (1, 0));
    assert_eq!(campaign.earlier()[1].until, Some(4), "batches that rest on it stand");
    let restored: global::Loop = serde_json::from_str(&save(&campaign)).unwrap();
    assert_eq!(restored, campaign);
}

#[test]
fn earlier_experiments_that_cannot_be_are_refused() {
    let (region, settings) = planar();
    let mut campaign = global::Loop::new(&region, settings).unwrap();
    let message = |campaign: &mut global::Loop, point: &[f64], cost| {
        campaign.add_earlier(point, cost, "").unwrap_err().to_string()
    };
    let far = message(&mut campaign, &[12.0, 16.1], 1.0);
    assert_eq!(
        far,
        "earlier experiment: parameter `p1` is 16.1, expected within half the parameter's width of its bounds"
    );
    assert!(message(&mut campaign, &[12.0, 12.0], f64::NAN).contains("`cost` is NaN"));
    assert!(message(&mut campaign, &[12.0], 1.0).contains('1'));
    assert!(campaign.earlier().is_empty());
}

#[test]
fn nothing_is_dropped_before_the_first_screening() {
    let (region, mut settings) = planar();
    settings.first_screening = 2;
    settings.max_batches = 2;
    let mut campaign = global::Loop::new(&region, settings.clone()).unwrap();
    campaign.run(&mut simulation, &mut |trial| Ok(experiment(trial))).unwrap();
    let left: Vec<u64> = campaign.reports().iter().map(|report| report.screening.n_after).collect();
    assert!(left[0] == 576 && left[1] < 576, "{left:?}");
    assert!(campaign.grid().cells().all(|cell| campaign.why_dropped(cell).is_none_or(|dropped| dropped.batch == 2)));
    assert_eq!(
        campaign.grid().cells().filter(|&cell| campaign.why_dropped(cell).is_some()).count() as u64,
        576 - left[1]
    );
    let restored: global::Loop = serde_json::from_str(&save(&campaign)).unwrap();
    assert_eq!(restored, campaign);
    settings.first_screening = 0;
    assert!(global::Loop::new(&region, settings).unwrap_err().to_string().contains("`first_screening` is 0"));
}

#[test]
fn outlook_over_two_cells_is_the_closed_form() {
    // One parameter, two cells, a straight line: the difference of the two costs is normal.
    let mut settings = settings(Model::linear(1).unwrap(), 6, 4);
    settings.max_batches = 1;
    settings.fallback = infuse::global::SpreadFallback::KeepAll;
    settings.confidence = 0.999_999;
    let mut campaign = global::Loop::new(&grid(&[2]), settings).unwrap();
    let readings = |number: u64| 0.3 * (12.9898 * number as f64).sin();
    let mut simulated = |_: Cell, p: &[f64]| Ok(1.0 + 0.05 * coded(p)[0]);
    campaign
        .run(&mut simulated, &mut |trial| Ok(1.0 - 0.02 * coded(&trial.point)[0] + readings(trial.id.number())))
        .unwrap();
    assert_eq!(campaign.retained().n_retained(), 2);
    let surfaces = &campaign.surfaces()[0];
    let at = |x: f64| surfaces.numerical.surface().predict(&[x]);
    let optimum = coded(&campaign.reports()[0].screening.optimum)[0];
    // By how much the other cell is worse, in the corrected model.
    let worse = at(-optimum) - at(optimum);
    // The gain of one half lets half of the error of the experiments into the correction.
    let sigma = 0.5 * 2.0 * surfaces.experiment.as_ref().unwrap().regression().unwrap().standard_errors().unwrap()[1];
    let (normal, u) = (Normal::standard(), worse / sigma);
    let exact = sigma * (normal.pdf(u) - u * normal.sf(u));
    let outlook = campaign.outlook(40_000, None).unwrap().expect("a regression");
    assert!((outlook.mean_gain / exact - 1.0).abs() < 0.03, "{} {exact}", outlook.mean_gain);
    // The quantile of max(0, X), X normal with the mean -worse.
    let upper = (sigma * normal.inverse_cdf(0.9) - worse).max(0.0);
    assert!((outlook.upper_gain - upper).abs() < 0.03 * sigma, "{} {upper}", outlook.upper_gain);
    assert_eq!((outlook.n_cells, outlook.n_draws), (2, 40_000));
    assert!(campaign.outlook(0, None).unwrap_err().to_string().contains("n_draws"));
}

#[test]
fn outlook_shrinks_as_a_campaign_learns() {
    let (region, settings) = planar();
    let gain = |n| after(n, settings.clone()).outlook(200, None).unwrap().expect("closed").mean_gain;
    assert!(gain(4) < 0.2 * gain(1), "{} {}", gain(1), gain(4));
    assert_eq!(global::Loop::new(&region, settings.clone()).unwrap().outlook(200, None).unwrap(), None);
}

#[test]
fn observed_certificate_covers_the_regret_where_the_regressor_is_right() {
    let (_, settings) = planar();
    for n in 1..=4 {
        let campaign = after(n, settings.clone());
        let observed = campaign.observed_certificate().unwrap().expect("regressions");
        let best = campaign.retained().cells().map(|cell| truth(&campaign.point(cell).unwrap()));
        let best = best.fold(f64::INFINITY, f64::min);
        let optimum = &campaign.reports().last().unwrap().screening.optimum;
        let regret = truth(optimum) - best;
        assert!(regret <= observed.certificate.regret, "{n}: {regret} {observed:?}");
        assert!(observed.simulation < 1e-9, "the simulation is a quadratic");
        assert!(observed.experiment < 0.2, "noise of 0.02: {observed:?}");
    }
}

#[test]
fn what_noise_does_not_explain_may_hide_the_better_of_two_level_designs() {
    let (region, mut settings) = planar();
    settings.replicates = 3;
    settings.max_batches = 1;
    let mut campaign = global::Loop::new(&region, settings).unwrap();
    // The truth has a ripple that no quadratic follows.
    let rippled = |trial: &infuse::global::Trial| experiment(trial) + 0.4 * (3.0 * trial.point[0]).sin();
    campaign.run(&mut simulation, &mut |trial| Ok(rippled(trial))).unwrap();
    let s = campaign.reports()[0].screening.spread.s().unwrap();
    let noise = campaign.pure_error().unwrap().variance;
    assert!(s * s > 2.0 * noise, "{s} {noise}");
    // Two misfits with that variance, by quantiles: the mean of the larger, over a fine lattice of probabilities.
    let fit = campaign.surfaces()[0].combined.regression().unwrap();
    let validation: Vec<_> = campaign.reports()[0]
        .trials
        .iter()
        .filter(|r| r.trial.used_for == infuse::global::TrialUse::Validation)
        .collect();
    let m = validation.len() as f64;
    // Variances for residuals of the fit, where those of an experiment of weight 0.7 scatter by the noise.
    let scale = 0.7 * noise / fit.sigma_squared().unwrap();
    let sampling = validation.iter().map(|r| scale * fit.variance(&coded(&r.trial.point)).unwrap()).sum::<f64>() / m;
    let sigma = (s * s - (noise + sampling) * m / (m - 1.0)).sqrt();
    let n = 400;
    let quantiles: Vec<f64> =
        (0..n).map(|i| Normal::standard().inverse_cdf((f64::from(i) + 0.5) / f64::from(n))).collect();
    let larger = quantiles.iter().flat_map(|a| quantiles.iter().map(move |b| a.max(*b))).sum::<f64>();
    let exact = sigma * larger / f64::from(n * n);
    let outlook = campaign.outlook(100, campaign.pure_error()).unwrap().expect("a regression");
    let found = outlook.misfit_gain.unwrap();
    assert!((found / exact - 1.0).abs() < 0.01, "{found} {exact}");
    assert!((outlook.total_gain().unwrap() - found - outlook.mean_gain).abs() < 1e-12);
    // With more noise less is left for the shape: the closed form of the mean of the larger.
    let noisy = infuse::global::PureError::of_readings([(vec![1.0], 0.0), (vec![1.0], (0.4 * s * s).sqrt())]);
    let larger = noisy.unwrap().variance;
    let sigma = (s * s - larger * (1.0 + sampling / noise) * m / (m - 1.0)).sqrt();
    let found = campaign.outlook(100, noisy).unwrap().unwrap().misfit_gain.unwrap();
    assert!((found / (sigma / std::f64::consts::PI.sqrt()) - 1.0).abs() < 1e-9, "{found} {sigma}");
}
