//! Campaigns that mind what they have run, beside those that do not.

use std::collections::BTreeSet;

use design_space::{Cell, Model};
use infuse::{
    Outcome,
    global::reported::{Spread, SpreadFault},
    global::{self, Report, TrialRecord, TrialUse},
};

use crate::global_problems::{asked, coded, grid, save, settings};

/// 9 x 15 designs, ten experiments a batch of which two repeat others, six terms; nothing is dropped by the first batch.
fn campaign(seed: u64, careful: bool) -> global::Loop {
    let mut settings = settings(Model::quadratic(2).unwrap(), 10, 20);
    (settings.replicates, settings.first_screening, settings.max_batches) = (2, 2, 4);
    (settings.seed, settings.careful) = (seed, careful);
    global::Loop::new(&grid(&[9, 15]), settings).unwrap()
}

/// A slope with a well that the simulation lacks; near two corners the rig cannot run.
fn rig(trial: &global::Trial, seed: u64) -> Outcome {
    let x = coded(&trial.point);
    if (x[0] - x[1]).abs() > 1.7 {
        return Outcome::Failed { reason: "it stalls".to_owned() };
    }
    let noise = 0.05 * (12.9898 * (trial.id.number() + 100 * seed) as f64).sin();
    Outcome::Value(slope(&x) - 6.0 * (-8.0 * ((x[0] + 0.4).powi(2) + (x[1] - 0.1).powi(2))).exp() + noise)
}

fn slope(x: &[f64]) -> f64 {
    10.0 - 2.0 * x[0] + 0.5 * x[1] * x[1]
}

fn without_the_well(_: Cell, point: &[f64]) -> Result<f64, String> {
    Ok(slope(&coded(point)))
}

/// The campaign to its end, read from its file before every batch.
fn run(seed: u64, careful: bool) -> global::Loop {
    let mut campaign = campaign(seed, careful);
    while campaign.stop().is_none() {
        campaign = serde_json::from_str(&save(&campaign)).unwrap();
        for trial in asked(campaign.ask(&mut without_the_well).unwrap()) {
            campaign.tell(trial.id, rig(&trial, seed)).unwrap();
        }
    }
    campaign
}

fn cells(report: &Report) -> Vec<Cell> {
    let mut cells: Vec<Cell> = report.trials.iter().map(|record| record.trial.cell).collect();
    cells.sort_unstable();
    cells
}

fn failed_before(campaign: &global::Loop, batch: usize) -> BTreeSet<Cell> {
    let past = campaign.reports().iter().take(batch - 1);
    past.flat_map(Report::failed_trials).map(|record| record.trial.cell).collect()
}

/// The validation experiments with a response at cells where nothing was taught.
fn unseen<'a>(campaign: &'a global::Loop, report: &'a Report) -> Vec<&'a TrialRecord> {
    let before = campaign.reports().iter().take(report.number - 1).flat_map(|report| &report.trials);
    let own = report.trials.iter().filter(|record| record.trial.used_for == TrialUse::Training);
    let gave = |record: &&TrialRecord| record.cost().is_some();
    let taught: BTreeSet<Cell> = before.chain(own).filter(gave).map(|record| record.trial.cell).collect();
    let validation = report.trials.iter().filter(|record| record.trial.used_for == TrialUse::Validation);
    validation.filter(gave).filter(|record| !taught.contains(&record.trial.cell)).collect()
}

fn s_of(campaign: &global::Loop, report: &Report, records: &[&TrialRecord]) -> f64 {
    let combined = &campaign.surfaces()[report.number - 1].combined;
    let square = |record: &&TrialRecord| {
        let predicted = combined.surface().predict(&campaign.coded(record.trial.cell).unwrap());
        (predicted - record.cost().unwrap()).powi(2)
    };
    (records.iter().map(square).sum::<f64>() / (records.len() - 1) as f64).sqrt()
}

#[test]
fn by_default_failures_are_asked_for_again_and_taught_settings_called_unseen() {
    let [mut failed_again, mut taught] = [0; 2];
    for seed in 1..=20 {
        let campaign = run(seed, false);
        for report in campaign.reports() {
            let failed = failed_before(&campaign, report.number);
            failed_again += cells(report).iter().filter(|cell| failed.contains(cell)).count();
            if let Spread::Estimated { n_validation, .. } = report.screening.spread {
                taught += n_validation - unseen(&campaign, report).len();
            }
        }
    }
    assert!(failed_again > 20 && taught > 100, "{failed_again} failures again, {taught} taught settings");
}

#[test]
fn careful_campaigns_ask_for_no_failure_again_repeat_no_batch_and_validate_where_nothing_was_taught() {
    let mut n_estimated = 0;
    for seed in 1..=20 {
        let campaign = run(seed, true);
        assert!(campaign.reports().len() > 1, "seed {seed}");
        for report in campaign.reports() {
            let place = format!("seed {seed}, batch {}", report.number);
            let failed = failed_before(&campaign, report.number);
            assert!(cells(report).iter().all(|cell| !failed.contains(cell)), "{place}: a failed setting again");
            let failed = failed_before(&campaign, report.number + 1);
            assert!(!failed.contains(&report.screening.optimum_cell), "{place}: {:?}", report.screening);
            let earlier = campaign.reports().iter().take(report.number - 1);
            assert!(earlier.clone().all(|earlier| cells(earlier) != cells(report)), "{place}: a batch again");

            let unseen = unseen(&campaign, report);
            match report.screening.spread {
                Spread::Estimated { s, n_validation } => {
                    assert_eq!(n_validation, unseen.len(), "{place}");
                    let expected = s_of(&campaign, report, &unseen);
                    assert!((s - expected).abs() < 1e-9 * expected, "{place}: {s} {expected}");
                    n_estimated += 1;
                }
                spread => {
                    assert!(unseen.len() < 2, "{place}: {spread:?}");
                    assert_eq!(spread, Spread::Undefined { because: SpreadFault::TooFew }, "{place}");
                }
            }
        }
        let last = campaign.reports().len() + 1;
        assert_eq!(campaign.retained_at(last).as_ref(), Some(campaign.retained()), "seed {seed}");
        for &cell in &failed_before(&campaign, last) {
            assert!(!campaign.is_retained(cell), "seed {seed}: {cell:?} may be asked for");
            assert!(
                campaign.failed_in(cell).is_some() != campaign.why_dropped(cell).is_some(),
                "seed {seed}: {cell:?}"
            );
        }
        let read: global::Loop = serde_json::from_str(&save(&campaign)).unwrap();
        assert_eq!(read, campaign, "seed {seed}");
    }
    assert!(n_estimated > 40, "S in {n_estimated} batches");
}

/// What the search finds for batch 2 was, by chance, run in batch 1.
#[test]
fn no_batch_repeats_an_earlier_one_where_other_cells_are_left() {
    for seed in 1..=20 {
        let told = |campaign: &mut global::Loop, plan: &global::Plan| {
            for trial in campaign.open(plan, &mut without_the_well).unwrap() {
                campaign.tell(trial.id, Outcome::Value(slope(&coded(&trial.point)))).unwrap();
            }
            campaign.plan().unwrap().unwrap()
        };
        let mut first = campaign(seed, false);
        let plan = first.plan().unwrap().unwrap();
        let again = told(&mut first, &plan);
        for careful in [false, true] {
            let next = told(&mut campaign(seed, careful), &again).experiments;
            let new = next.iter().filter(|cell| !again.experiments.contains(cell)).count();
            assert_eq!(new, if careful { 10 } else { 0 }, "seed {seed}, careful {careful}: {next:?} after {again:?}");
        }
    }
}

/// Where fewer new cells are left than a batch needs, it is planned as if nothing had been run.
#[test]
fn too_few_new_cells_are_not_preferred() {
    for seed in 1..=5 {
        let next = |careful: bool, first: Option<&global::Plan>| {
            let settings = campaign(seed, careful).settings().clone();
            let mut campaign = global::Loop::new(&grid(&[5, 3]), settings).unwrap();
            let own = campaign.plan().unwrap().unwrap();
            for trial in campaign.open(first.unwrap_or(&own), &mut without_the_well).unwrap() {
                campaign.tell(trial.id, Outcome::Value(slope(&coded(&trial.point)))).unwrap();
            }
            campaign.plan().unwrap().unwrap()
        };
        // What a second batch would run was run in the first.
        let again = next(false, None);
        let (careful, careless) = (next(true, Some(&again)), next(false, Some(&again)));
        let run: BTreeSet<Cell> = again.experiments.iter().copied().collect();
        assert!(run.len() == 8 && careless.experiments.iter().all(|cell| run.contains(cell)), "seed {seed}: {again:?}");
        assert_eq!(careful.experiments, careless.experiments, "seed {seed}: seven new cells are too few for eight");
    }
}

/// All that is left failed: it is kept, since there would be nothing else.
#[test]
fn nothing_is_dropped_for_its_failures_where_nothing_else_is_left() {
    let mut settings = campaign(1, true).settings().clone();
    settings.model = Model::linear(2).unwrap();
    let mut campaign = global::Loop::new(&grid(&[2, 2]), settings).unwrap();
    let stop = campaign.run(&mut without_the_well, &mut |_| Err("it stalls".to_owned())).unwrap();
    assert_eq!(stop, global::StopReason::NoInformation);
    assert_eq!(campaign.retained().n_retained(), 4);
}

/// Experiments from outside were made at every cell of the batch: none is unseen, nothing is dropped, and a plan goes elsewhere.
#[test]
fn what_was_measured_outside_of_the_campaign_is_not_unseen() {
    let mut settings = campaign(1, true).settings().clone();
    settings.first_screening = 1;
    let mut campaign = global::Loop::new(&grid(&[9, 15]), settings).unwrap();
    let plan = campaign.plan().unwrap().unwrap();
    for &cell in &plan.experiments {
        let point = campaign.point(cell).unwrap();
        campaign.add_earlier(&point, slope(&coded(&point)), "last year").unwrap();
    }
    let elsewhere = campaign.plan().unwrap().unwrap().experiments;
    assert!(elsewhere.iter().all(|cell| !plan.experiments.contains(cell)), "{elsewhere:?} after {plan:?}");
    for trial in campaign.open(&plan, &mut without_the_well).unwrap() {
        // Settings that were made count, here beside those asked for and in the same cell.
        let actual: Vec<f64> = trial.point.iter().map(|x| x + 0.01).collect();
        campaign.tell_at(trial.id, &actual, Outcome::Value(slope(&coded(&actual)))).unwrap();
    }
    let screening = &campaign.reports()[0].screening;
    assert_eq!(screening.spread, Spread::Undefined { because: SpreadFault::TooFew });
    assert_eq!((screening.n_before, screening.n_after), (135, 135));
}

/// Of the first batch so many experiments fail that six settings are left for six terms, two of them read twice: the residuals
/// know the noise, and nothing of the shape.
#[test]
fn as_many_settings_as_terms_show_no_misfit_and_drop_nothing() {
    for careful in [false, true] {
        let mut settings = settings(Model::quadratic(2).unwrap(), 10, 20);
        (settings.replicates, settings.careful) = (2, careful);
        let mut campaign = global::Loop::new(&grid(&[9, 15]), settings).unwrap();
        let trials = asked(campaign.ask(&mut without_the_well).unwrap());
        let mut cells: Vec<Cell> = trials.iter().map(|trial| trial.cell).collect();
        cells.sort_unstable();
        let repeated: BTreeSet<Cell> = cells.windows(2).filter(|pair| pair[0] == pair[1]).map(|pair| pair[0]).collect();
        let single = cells.iter().filter(|cell| !repeated.contains(cell));
        let run: BTreeSet<Cell> = repeated.iter().chain(single.take(6 - repeated.len())).copied().collect();
        for trial in &trials {
            let fails = Outcome::Failed { reason: "it stalls".to_owned() };
            let noise = 0.05 * (12.9898 * trial.id.number() as f64).sin();
            let runs = Outcome::Value(slope(&coded(&trial.point)) + noise);
            campaign.tell(trial.id, if run.contains(&trial.cell) { runs } else { fails }).unwrap();
        }
        let report = &campaign.reports()[0];
        assert_eq!(report.not_corrected, None, "six settings determine six terms");
        let (screening, misfit) = (&report.screening, campaign.outlook(10, None).unwrap().unwrap().misfit_gain);
        let failed: BTreeSet<Cell> = report.failed_trials().map(|record| record.trial.cell).collect();
        assert!(screening.spread.s().is_some() && !failed.is_empty(), "{screening:?}");
        if careful {
            assert_eq!((screening.tested, misfit), (false, None));
            assert_eq!(screening.n_after, screening.n_before - failed.len() as u64, "only what failed is dropped");
        } else {
            assert!(screening.tested && misfit.is_some() && screening.n_after < 20, "{screening:?}");
        }
    }
}
