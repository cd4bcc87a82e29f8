//! Campaigns on costs that are known in closed form.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicUsize, Ordering};

use infuse::{
    correction::{Gain, Law, Rule},
    global,
};

use super::*;

const LEVELS: u32 = 9;
/// The model lacks this much everywhere.
const GAP: f64 = 0.75;

fn space() -> Space {
    Space::of_two([46.0, 50.0], [0.0, 16.0], LEVELS)
}

/// A bowl that (61) can follow, with this much on top, at the cells of the space.
fn bowl(space: &Space, on_top: impl Fn(f64, f64) -> f64) -> FlownGrid {
    let costs = space.cells().map(|cell| {
        let point = space.point(cell).expect("a cell");
        let (x, y) = (point[0] - 48.5, (point[1] - 6.0) / 4.0);
        Ok(2.0 + x * x + 0.5 * y * y + on_top(x, y))
    });
    FlownGrid::of_costs(costs.collect())
}

fn settings(law: Law, k: f64, iterations: usize) -> global::Settings {
    let model = Regressor::AdditiveQuadratic.model(2).expect("a model");
    let mut settings = global::Settings::new(model, 12, 24);
    settings.correction = Rule::new(law, Gain::constant(k).expect("a gain"));
    settings.max_batches = iterations;
    settings
}

fn designs() -> (tempfile::TempDir, Designs) {
    let folder = tempfile::tempdir().expect("a writable directory");
    let designs = Designs::keep_in(folder.path(), None).expect("no designs yet");
    (folder, designs)
}

/// Without noise and misfit both surfaces are exact, so what is left of the gap is known: (47) with e1 = e2 = 0.
#[test]
fn a_constant_gap_falls_as_a_power_of_one_less_the_gain_and_attains_its_bound() {
    let space = space();
    let (model, truth) = (bowl(&space, |_, _| 0.0), bowl(&space, |_, _| GAP));
    for (law, k) in [(Law::ProofRecursion, 0.5), (Law::CurrentSimulation, 0.3)] {
        let rig = StandInRig { space: &space, model: &model, truth: &truth, noise: 0.0, seed: 1 };
        let (_folder, designs) = designs();
        let campaign = rig.run(&settings(law, k, 6), &designs, |_| {}).expect("a campaign");
        let accuracy = Accuracy::of(&campaign, &space, &model, &truth).expect("as many cells");
        assert!(accuracy.iterations.len() >= 4, "{law:?}: {} iterations", accuracy.iterations.len());
        for i in &accuracy.iterations {
            let left = GAP * (1.0 - k).powi(i.iteration as i32);
            // q = 1 and 2 over the cells that were left, in coordinates coded to a box of measure 4.
            let measure = 4.0 * i.share_before;
            for (norm, expected) in i.norms.iter().zip([left * measure, left * measure.sqrt(), left]) {
                assert!((norm.error - expected).abs() < 1e-9, "{law:?} {}: {} {expected}", i.iteration, norm.error);
                assert!((norm.finite_bound - expected).abs() < 1e-9, "{law:?} {}: the bound is attained", i.iteration);
                assert!(norm.simulation < 1e-9 && norm.experiment < 1e-9, "{law:?}: exact surfaces");
            }
            assert!(i.certified_regret >= i.retained_regret - 1e-9, "{law:?} {}", i.iteration);
        }
    }
}

#[test]
fn a_wrong_model_with_noise_stays_inside_its_bound_and_its_certificate() {
    let space = space();
    let model = bowl(&space, |_, _| 0.0);
    let truth = bowl(&space, |x, y| 0.4 * x * y + 0.3 * (2.0 * x).sin());
    let (_folder, designs) = designs();
    for seed in 0..10 {
        let rig = StandInRig { space: &space, model: &model, truth: &truth, noise: 0.03, seed };
        let settings = settings(Law::ProofRecursion, 0.5, 8);
        let campaign = rig.run(&settings, &designs, |_| {}).expect("a campaign");
        let accuracy = Accuracy::of(&campaign, &space, &model, &truth).expect("as many cells");
        assert!(accuracy.largest_share_of_bound() <= 1.0 + 1e-9, "seed {seed}");
        for i in &accuracy.iterations {
            assert!(i.certified_regret >= i.retained_regret - 1e-9, "seed {seed}, iteration {}", i.iteration);
            assert!(i.share_after <= i.share_before, "seed {seed}, iteration {}", i.iteration);
        }
    }
}

#[test]
fn an_interrupted_campaign_goes_on_where_it_was() {
    let space = space();
    let (model, truth) = (bowl(&space, |_, _| 0.0), bowl(&space, |x, y| 0.4 * x * y));
    let rig = StandInRig { space: &space, model: &model, truth: &truth, noise: 0.05, seed: 7 };
    let settings = settings(Law::ProofRecursion, 0.5, 5);
    let (_whole, all) = designs();
    let expected = rig.run(&settings, &all, |_| {}).expect("a campaign");
    let n_batches = expected.reports().len();
    assert_eq!(all.n_searched(), n_batches, "one search for each");

    let (folder, begun) = designs();
    let made = AtomicUsize::new(0);
    let stop_after_two = |n: usize| assert!(made.fetch_add(n, Ordering::Relaxed) + n < 3, "interrupted");
    let interrupted = catch_unwind(AssertUnwindSafe(|| rig.run(&settings, &begun, stop_after_two)));
    assert!(interrupted.is_err(), "it was interrupted");
    let again = || Designs::keep_in(folder.path(), None).expect("its designs");
    let rest = again();
    let resumed = rig.run(&settings, &rest, |_| {}).expect("a campaign");
    assert_eq!(rest.n_searched(), n_batches - 3, "three iterations were not designed again");
    assert_eq!(resumed, expected);

    // A file that makes no sense is as good as none.
    for file in std::fs::read_dir(folder.path()).expect("the folder").flatten() {
        std::fs::write(file.path(), "{").expect("a writable file");
    }
    let anew = again();
    assert_eq!(rig.run(&settings, &anew, |_| {}).expect("a campaign"), expected);
    assert_eq!(anew.n_searched(), n_batches, "all anew");
}

#[test]
fn designs_kept_with_the_sources_are_taken_over_and_a_sample_is_searched_for_anew() {
    let space = space();
    let (model, truth) = (bowl(&space, |_, _| 0.0), bowl(&space, |x, y| 0.4 * x * y));
    let rig = StandInRig { space: &space, model: &model, truth: &truth, noise: 0.05, seed: 7 };
    let settings = settings(Law::ProofRecursion, 0.5, 2);
    let (kept, all) = designs();
    let expected = rig.run(&settings, &all, |_| {}).expect("a campaign");
    let with_kept = || {
        let folder = tempfile::tempdir().expect("a writable directory");
        let designs = Designs::keep_in(folder.path(), Some(kept.path())).expect("its designs");
        let found = rig.run(&settings, &designs, |_| {});
        (found, designs.n_searched())
    };
    let (found, n_searched) = with_kept();
    assert_eq!((found.expect("a campaign"), n_searched), (expected, 0));

    // The first of a file is of the sample.
    let [file] =
        std::fs::read_dir(kept.path()).expect("the folder").flatten().collect::<Vec<_>>().try_into().expect("one");
    let text = std::fs::read_to_string(file.path()).expect("just written");
    let digit = text.find("[").expect("a list") + 1;
    std::fs::write(file.path(), format!("{}1{}", &text[..digit], &text[digit..])).expect("a writable file");
    let error = with_kept().0.expect_err("another design than is found");
    assert!(error.to_string().contains("reproduce-all --keep"), "{error}");
}

#[test]
fn known_designs_make_the_campaign_that_the_loop_makes_of_its_own() {
    let space = space();
    let (model, truth) = (bowl(&space, |_, _| 0.0), bowl(&space, |x, y| 0.4 * x * y));
    let rig = StandInRig { space: &space, model: &model, truth: &truth, noise: 0.05, seed: 3 };
    let settings = settings(Law::ProofRecursion, 0.5, 4);
    let (_folder, designs) = designs();
    let mut itself = global::Loop::new(space.region(), settings.clone()).expect("a campaign");
    while let global::Ask::Trials(trials) = itself.ask(&mut |cell, _| rig.simulate(cell)).expect("a batch") {
        for (trial, outcome) in trials.iter().zip(rig.measure(&trials).expect("costs")) {
            itself.tell(trial.id, outcome).expect("an outcome");
        }
    }
    assert_eq!(rig.run(&settings, &designs, |_| {}).expect("a campaign"), itself);
}
