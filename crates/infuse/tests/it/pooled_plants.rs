//! Parameters that are built: few plants in a batch, each with an error of its own.

use std::collections::BTreeSet;

use design_space::{Cell, Parameter, Region};
use infuse::Outcome;
use infuse::pooled::{Ask, Loop, Plants, Settings, Trial};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Two parameters that are built, and two that are typed.
fn region() -> Region {
    let parameter = |name: &str| Parameter::continuous(name, "", -1.0, 1.0).and_then(|p| p.with_levels(13));
    Region::new(["span", "mass", "gain", "set point"].map(|name| parameter(name).expect("a parameter")).to_vec())
        .expect("a region")
}

fn normal(rng: &mut ChaCha8Rng) -> f64 {
    (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0
}

/// Lowest, 0, at (0.5, 0, 0.5, −0.5); what gain is best depends on the span.
fn truth(p: &[f64]) -> f64 {
    (p[0] - 0.5).powi(2) + 0.5 * p[1].powi(2) + (p[2] - p[0]).powi(2) + 0.7 * (p[3] + 0.5).powi(2)
}

fn simulation(_: Cell, p: &[f64]) -> Result<f64, String> {
    Ok((p[0] + 0.2).powi(2) + 0.5 * p[1].powi(2) + (p[2] - 0.6 * p[0]).powi(2) + 0.7 * (p[3] + 0.3).powi(2))
}

fn plant(trial: &Trial) -> (u64, u64) {
    (trial.point[0].to_bits(), trial.point[1].to_bits())
}

/// Runs a campaign of so many batches; regret at the end, and plants in each batch.
fn campaign(batches: usize, plants: Option<Plants>) -> (f64, Vec<usize>) {
    let mut settings = Settings::new(12);
    (settings.max_batches, settings.plants) = (batches, plants);
    let mut campaign = Loop::new(&region(), settings).expect("a campaign");
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut counts = Vec::new();
    while let Ask::Run { trials, .. } = campaign.ask(Some(&mut simulation)).expect("a batch") {
        counts.push(trials.iter().map(plant).collect::<BTreeSet<_>>().len());
        for trial in trials {
            let response = truth(&trial.point) + 0.02 * normal(&mut rng);
            campaign.tell(trial.id, Outcome::Value(response)).expect("a trial");
        }
    }
    let found = campaign.assess(Some(&mut simulation)).expect("a fit").expect("responses");
    (truth(&found.recommended.point), counts)
}

#[test]
fn batch_has_no_more_plants_than_were_asked_for_and_finds_nearly_as_good_a_design() {
    let (few, of_few) = campaign(4, Some(Plants::at_most(3, vec![0, 1])));
    assert!(of_few.iter().all(|&count| count <= 3), "{of_few:?}");
    let (many, of_many) = campaign(4, None);
    let (n_few, n_many): (usize, usize) = (of_few.iter().sum(), of_many.iter().sum());
    // A design drawn at random is 1.8 off on average, the simulation's best 0.8.
    assert!(few < 0.06 && many < 0.06, "{few} {many}");
    assert!(2 * n_few < n_many, "{n_few} of {n_many} plants");
}

#[test]
fn plants_become_fewer_as_they_become_dear() {
    let count =
        |cost: f64| -> usize { campaign(2, Some(Plants::of_cost(vec![0, 1], vec![cost; 2]))).1[1..].iter().sum() };
    let (cheap, dear) = (count(0.0), count(20.0));
    assert!(2 * dear < cheap, "{dear} {cheap}");
}

/// Told of assemblies the loop learns their error; it is then not taken for that of the response.
#[test]
fn shared_error_of_an_assembly_is_learnt() {
    let mut settings = Settings::new(12);
    (settings.max_batches, settings.plants) = (3, Some(Plants::at_most(4, vec![0, 1])));
    let mut campaign = Loop::new(&region(), settings).expect("a campaign");
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    while let Ask::Run { mut trials, .. } = campaign.ask(None).expect("a batch") {
        trials.sort_by_key(plant);
        let (mut last, mut of_assembly) = (None, 0.0);
        for trial in trials {
            if last != Some(plant(&trial)) {
                (last, of_assembly) = (Some(plant(&trial)), 0.3 * normal(&mut rng));
            }
            let response = truth(&trial.point) + of_assembly + 0.02 * normal(&mut rng);
            campaign.tell(trial.id, Outcome::Value(response)).expect("a trial");
        }
    }
    let found = campaign.assess(None).expect("a fit").expect("responses");
    let assembly = found.assembly.expect("plants are told apart");
    assert!((0.1..0.9).contains(&assembly) && found.noise < 0.1, "{assembly} {}", found.noise);
}

#[test]
fn first_batch_keeps_to_few_plants_without_a_simulation_too_and_linear_constraints_hold() {
    let mut settings = Settings::new(10);
    settings.plants = Some(Plants::at_most(2, vec![0]));
    settings.linear_constraints = vec![infuse::pooled::LinearConstraint::at_most(vec![1.0, 1.0, 0.0, 0.0], 0.5)];
    let mut campaign = Loop::new(&region(), settings).expect("a campaign");
    let Ask::Run { trials, .. } = campaign.ask(None).expect("a batch") else { panic!("it stopped") };
    let spans: BTreeSet<u64> = trials.iter().map(|trial| trial.point[0].to_bits()).collect();
    assert!(spans.len() <= 2 && trials.len() == 10);
    assert!(trials.iter().all(|trial| trial.point[0] + trial.point[1] <= 0.5 + 1e-9));
}

#[test]
fn plants_that_cannot_be_are_refused() {
    let with = |plants: Plants| {
        let mut settings = Settings::new(4);
        settings.plants = Some(plants);
        Loop::new(&region(), settings).map(|_| ()).expect_err("it cannot be").to_string()
    };
    assert!(with(Plants::at_most(0, vec![0])).contains("`most` is 0, expected at least 1"));
    assert!(with(Plants::at_most(1, vec![])).contains("at least one"));
    assert!(with(Plants::at_most(1, vec![0, 0])).contains("each parameter once"));
    assert!(with(Plants::at_most(1, vec![4])).contains("places of parameters"));
    assert!(with(Plants::of_cost(vec![0, 1], vec![1.0])).contains("one per parameter of the plant"));
    assert!(with(Plants::of_cost(vec![0], vec![-1.0])).contains("0 to 1e9"));
}
