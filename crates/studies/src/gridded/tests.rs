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
    let entry = |name: &str, unit: &str, lower, upper| ParameterEntry {
        name: name.to_owned(),
        unit: unit.to_owned(),
        lower,
        upper,
    };
    let entries = [entry("center_of_mass", "% chord", 46.0, 50.0), entry("pitch_set_point", "deg", 0.0, 16.0)];
    Space::of(&entries, &entries.each_ref().map(|entry| entry.name.clone()), LEVELS).expect("a space")
}

/// A bowl that (61) can follow, with this much on top, at the cells of the space.
fn bowl(space: &Space, key: &str, on_top: impl Fn(f64, f64) -> f64) -> FlownGrid {
    let costs = (0..space.n_cells()).map(|cell| {
        let point = space.point(cell).expect("a cell");
        let (x, y) = (point[0] - 48.5, (point[1] - 6.0) / 4.0);
        Ok(2.0 + x * x + 0.5 * y * y + on_top(x, y))
    });
    FlownGrid::of_costs(key, costs.collect())
}

fn settings(law: Law, k: f64, iterations: usize) -> global::Settings {
    let model = Regressor::AdditiveQuadratic.model(2).expect("a model");
    let mut settings = global::Settings::new(model, 12, 24);
    settings.correction = Rule::new(law, Gain::constant(k).expect("a gain"));
    settings.max_iterations = iterations;
    settings
}

fn directory(name: &str) -> std::path::PathBuf {
    std::env::temp_dir().join(format!("xtask-{}-{name}", std::process::id()))
}

/// Without noise and misfit both surfaces are exact, so what is left of the gap is known: (47) with e1 = e2 = 0.
#[test]
fn a_constant_gap_falls_as_a_power_of_one_less_the_gain_and_attains_its_bound() {
    let space = space();
    let (model, truth) = (bowl(&space, "model", |_, _| 0.0), bowl(&space, "truth", |_, _| GAP));
    for (law, k) in [(Law::ProofRecursion, 0.5), (Law::CurrentSimulation, 0.3)] {
        let rig = SurrogateRig { space: &space, model: &model, truth: &truth, noise: 0.0, seed: 1 };
        let out = directory(&format!("gap-{law:?}"));
        let campaign = Campaigns::new(out.clone()).run(&rig, &settings(law, k, 6), |_| {}).expect("a campaign");
        std::fs::remove_dir_all(&out).expect("just written");
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
    let model = bowl(&space, "model", |_, _| 0.0);
    let truth = bowl(&space, "truth", |x, y| 0.4 * x * y + 0.3 * (2.0 * x).sin());
    for seed in 0..10 {
        let rig = SurrogateRig { space: &space, model: &model, truth: &truth, noise: 0.03, seed };
        let out = directory(&format!("noise-{seed}"));
        let settings = settings(Law::ProofRecursion, 0.5, 8);
        let campaign = Campaigns::new(out.clone()).run(&rig, &settings, |_| {}).expect("a campaign");
        std::fs::remove_dir_all(&out).expect("just written");
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
    let (model, truth) = (bowl(&space, "model", |_, _| 0.0), bowl(&space, "truth", |x, y| 0.4 * x * y));
    let rig = SurrogateRig { space: &space, model: &model, truth: &truth, noise: 0.05, seed: 7 };
    let settings = settings(Law::ProofRecursion, 0.5, 5);
    let (whole, torn) = (directory("whole"), directory("torn"));
    let expected = Campaigns::new(whole.clone()).run(&rig, &settings, |_| {}).expect("a campaign");

    let made = AtomicUsize::new(0);
    let stop_after_two = |n: usize| assert!(made.fetch_add(n, Ordering::Relaxed) + n < 3, "interrupted");
    let campaigns = Campaigns::new(torn.clone());
    let interrupted = catch_unwind(AssertUnwindSafe(|| campaigns.run(&rig, &settings, stop_after_two)));
    assert!(interrupted.is_err(), "it was interrupted");
    let remembered = AtomicUsize::new(0);
    let note_first = |n: usize| {
        let _ = remembered.compare_exchange(0, n, Ordering::Relaxed, Ordering::Relaxed);
    };
    let resumed = campaigns.run(&rig, &settings, note_first).expect("a campaign");
    assert_eq!(remembered.load(Ordering::Relaxed), 3, "iterations that were not made again");
    assert_eq!(resumed, expected);

    // A file that makes no sense is as good as none.
    for file in std::fs::read_dir(&torn).expect("the folder").flatten() {
        std::fs::write(file.path(), "{").expect("a writable file");
    }
    assert_eq!(campaigns.run(&rig, &settings, |_| {}).expect("a campaign"), expected);
    for out in [whole, torn] {
        std::fs::remove_dir_all(&out).expect("just written");
    }
}
