//! Campaigns of the pooled loop, the default: what they find, what they say, and what can't happen.

use std::collections::BTreeSet;

use serde_json::{Value, json};

use crate::rig::{Rig, truth};

/// A problem of two parameters on 9 × 15 levels; the simulation is a table of this function.
pub(crate) fn rig_of(simulated: impl Fn(f64, f64) -> f64, more: &str) -> Rig {
    let rig = Rig::empty();
    let rows: String = (0..135)
        .map(|index| {
            let (a, b) = (f64::from(index / 15), f64::from(index % 15));
            format!("{a},{b},{:.6}\n", simulated(a, b))
        })
        .collect();
    rig.write("simulation.csv", &format!("a [mm],b [mm],y [N]\n{rows}"));
    let parameter = |name: &str, upper: u32| {
        format!(
            "[[parameter]]\nname = \"{name}\"\nunit = \"mm\"\nlower = 0\nupper = {upper}\nstep = 1\nrole = \"plant\"\n"
        )
    };
    rig.write(
        "campaign.toml",
        &format!(
            "title = \"Two wells\"\nseed = 1\n{}{}[response]\nname = \"y\"\nunit = \"N\"\ngoal = \"minimize\"\n\
             [simulator]\ntable = \"simulation.csv\"\n[loop]\nexperiments = 10\nbatches = 5\n{more}",
            parameter("a", 8),
            parameter("b", 14)
        ),
    );
    rig
}

pub(crate) fn ask(rig: &Rig) -> Value {
    serde_json::from_str(&rig.infuse(&["ask", "--json"]).ok()).unwrap()
}

/// Runs a batch by a function of settings, in the order of their names, and id; false at the end of the campaign.
pub(crate) fn batch(rig: &Rig, measure: impl FnMut(f64, f64, u64) -> Result<f64, String>) -> bool {
    let asked = ask(rig);
    let Some(experiments) = asked["experiments"].as_array() else {
        return false;
    };
    tell(rig, experiments, measure);
    true
}

pub(crate) fn tell(rig: &Rig, experiments: &[Value], mut measure: impl FnMut(f64, f64, u64) -> Result<f64, String>) {
    let told = |experiment: &&Value| experiment["told"] != json!(true);
    for experiment in experiments.iter().filter(told) {
        let mut settings = experiment["settings"].as_object().unwrap().values().map(|value| value.as_f64().unwrap());
        let (a, b) = (settings.next().unwrap(), settings.next().unwrap());
        let id = experiment["id"].as_u64().unwrap();
        let number = id.to_string();
        match measure(a, b, id) {
            Ok(value) => rig.infuse(&["tell", "--id", &number, "--value", &format!("{value:.4}")]).ok(),
            Err(reason) => rig.infuse(&["tell", "--id", &number, "--failed", &reason]).ok(),
        };
    }
}

/// Noise of an experiment, the same for the same number: about ± 1.
pub(crate) fn wobble(id: u64) -> f64 {
    (12.9898 * id as f64).sin() + (78.233 * id as f64).cos()
}

/// Two wells, of which the simulation has the wrong one deeper.
pub(crate) fn wells(a: f64, b: f64, depths: [f64; 2]) -> f64 {
    let well =
        |at_a: f64, at_b: f64, depth: f64| -depth * (-((a - at_a) / 1.8).powi(2) - ((b - at_b) / 2.6).powi(2)).exp();
    100.0 + 1.5 * (a - 4.0).powi(2) + 0.4 * (b - 7.0).powi(2) + well(2.0, 3.0, depths[0]) + well(6.0, 11.0, depths[1])
}

pub(crate) fn best(rig: &Rig) -> (f64, f64) {
    let best = rig.status()["best"].clone();
    (best["a"].as_f64().unwrap(), best["b"].as_f64().unwrap())
}

/// The rig is as simulated until the third batch; from then on half of the box is another.
#[test]
fn a_bound_that_rises_says_what_it_was() {
    let bowl = |a: f64, b: f64| 100.0 + 2.0 * (a - 4.0).powi(2) + 0.5 * (b - 7.0).powi(2);
    let rig = rig_of(bowl, "[stop]\nsmooth = true\n");
    let later = |id: u64, b: f64| if id > 20 && b > 8.0 { -25.0 } else { 0.0 };
    let mut bounds = Vec::new();
    for n_batches in 1..=3 {
        assert!(batch(&rig, |a, b, id| Ok(bowl(a, b) + 0.2 * wobble(id) + later(id, b))));
        bounds.push(rig.status()["bound"].as_f64().unwrap());
        let said = rig.infuse(&["status"]).ok();
        let was = format!("After batch {} the bound was", n_batches - 1);
        let has_risen = n_batches > 1 && bounds[n_batches - 1] > 1.02 * bounds[n_batches - 2];
        assert_eq!(said.contains(&was), has_risen, "{bounds:?}\n{said}");
    }
    assert!(bounds[2] > 2.0 * bounds[1], "{bounds:?}");
    let said = rig.infuse(&["status"]).ok();
    let why = said.split("It has risen: ").nth(1).and_then(|rest| rest.lines().next()).expect("why");
    assert!(why.contains("the noise of one run is taken for"), "{why}");
    let then: Value = rig.status()["batches"][1]["best"].clone();
    let (a, b) = (then["a"].as_f64().unwrap(), then["b"].as_f64().unwrap());
    let is_another = best(&rig) != (a, b);
    assert_eq!(
        why.contains(&format!("another design is recommended than then, a {a} mm, b {b} mm")),
        is_another,
        "{why}"
    );
    // It is said while the next batch is waited for, too.
    ask(&rig);
    assert!(rig.infuse(&["status"]).ok().contains(why));
    // Who asks for more certainty is told that this is why.
    rig.edit("[loop]\n", "[loop]\nconfidence = 0.97\n");
    let said = rig.infuse(&["status"]).ok();
    assert!(said.contains("It has risen: `confidence` was 0.9 and is 0.97"), "{said}");
}

/// What is recommended is run thrice, and is not what it was expected to be.
#[test]
fn a_design_that_was_worse_than_expected_is_named_where_the_bound_rises() {
    let bowl = |a: f64, b: f64| 100.0 + 2.0 * (a - 4.0).powi(2) + 0.5 * (b - 7.0).powi(2);
    let rig = rig_of(bowl, "[stop]\nsmooth = true\n");
    for _ in 0..2 {
        assert!(batch(&rig, |a, b, id| Ok(bowl(a, b) + 0.2 * wobble(id))));
    }
    let (at, before) = (best(&rig), rig.status());
    let asked: Value = serde_json::from_str(&rig.infuse(&["confirm", "--json"]).ok()).unwrap();
    let worse = |a: f64, b: f64| if (a, b) == at { 9.0 } else { 0.0 };
    tell(&rig, asked["experiments"].as_array().unwrap(), |a, b, id| Ok(bowl(a, b) + worse(a, b) + 0.2 * wobble(id)));
    let (text, after) = (rig.infuse(&["status"]).ok(), rig.status());
    assert!(after["bound"].as_f64() > before["bound"].as_f64(), "{text}");
    let said = "It has risen: 3 runs of the design recommended then measured 109";
    assert!(text.contains(said) && text.contains(" was expected, give or take "), "{text}");
}

/// One run of the second batch is far worse than all others: results differ by more, and so does what is held in reserve for so few.
#[test]
fn a_reserve_that_rises_is_said_to_be_one() {
    let rig = rig_of(|a, b| 100.0 + a + b, "");
    for n_batches in 1..=2 {
        let worse = |id: u64| if id == 15 { 80.0 } else { 0.0 };
        assert!(batch(&rig, |a, b, id| Ok(100.0 + a + b + worse(id) + 0.2 * wobble(id))));
        let said = rig.infuse(&["status"]).ok();
        let why = "It has risen: since then results differ by more, so more is held for a narrow well.";
        assert_eq!(said.contains(why), n_batches == 2, "{said}");
    }
}

#[test]
fn the_template_ends_at_the_optimum_of_the_rig_in_five_batches() {
    let campaigns = (1..=6).map(|seed| {
        let rig = Rig::pooled();
        rig.edit("seed = 1", &format!("seed = {seed}"));
        let n_batches = (0..).take_while(|_| rig.batch()).count();
        assert_eq!(rig.status()["best"], json!({ "spring": 22.0, "damper gain": 1.9 }), "seed {seed}");
        (rig, n_batches)
    });
    let mut campaigns: Vec<(Rig, usize)> = campaigns.collect();
    let n_batches: usize = campaigns.iter().map(|(_, n_batches)| n_batches).sum();
    assert!(n_batches <= 30, "{n_batches} in six campaigns");
    let (rig, n_batches) = campaigns.swap_remove(0);
    let status = rig.status();
    // The smallest of the table, as anyone can look it up.
    assert_eq!(status["simulation_alone"], json!({ "spring": 18.0, "damper gain": 1.3 }));
    assert!(status["bound"].as_f64() <= Some(0.2), "{status}");
    assert!(rig.infuse(&["status"]).ok().contains("probability no design is better than the recommended one"));
    assert!(rig.infuse(&["ask"]).ok().contains("To go on all the same: infuse ask --anyway"));
    let more = rig.infuse(&["ask", "--anyway"]).ok();
    assert!(more.contains(&format!("Batch {}: 10 experiments", n_batches + 1)), "{more}");
    // The best is known: what a repeat would gain is nothing.
    assert!(more.contains("is far from any run") && !more.contains("repeats that measure the noise"), "{more}");
    // Every setting of the loop may change from batch to batch.
    rig.edit("batches = 6", "batches = 8");
    rig.edit("experiments = 10", "experiments = 4\nconfidence = 0.95\nnoise = 0.15");
    rig.fill(&format!("sheet-{}.csv", n_batches + 1), |_| true);
    rig.infuse(&["tell", &format!("sheet-{}.csv", n_batches + 1)]).ok();
    assert!(rig.infuse(&["ask", "--anyway"]).ok().contains(": 4 experiments"));
    assert_eq!(rig.status()["probability"], json!(0.95));
}

#[test]
fn a_campaign_with_failing_designs_ends_near_the_best_and_asks_for_no_failed_one_again() {
    // What a user met: 135 designs, a well that the simulation thinks shallow, some designs that cannot run, `worth` set.
    let (real, simulated) = ([25.0, 60.0], [60.0, 20.0]);
    let fails = |a: f64, b: f64| b > 12.0 || (a < 1.0 && b < 2.0);
    let mut regrets = Vec::new();
    for seed in 1..=5 {
        let rig = rig_of(|a, b| wells(a, b, simulated), "[stop]\nworth = 3\n");
        rig.edit("seed = 1", &format!("seed = {seed}"));
        let measure = |a: f64, b: f64, id: u64| {
            if fails(a, b) { Err("it cannot be built".to_owned()) } else { Ok(wells(a, b, real) + wobble(id)) }
        };
        let mut failed = BTreeSet::new();
        loop {
            let asked = ask(&rig);
            let Some(experiments) = asked["experiments"].as_array() else { break };
            for experiment in experiments {
                let settings = experiment["settings"].to_string();
                assert!(!failed.contains(&settings), "{settings} failed before");
            }
            let of_failed = experiments.iter().map(|experiment| &experiment["settings"]);
            let of_failed = of_failed.filter(|s| fails(s["a"].as_f64().unwrap(), s["b"].as_f64().unwrap()));
            failed.extend(of_failed.map(Value::to_string));
            tell(&rig, experiments, measure);
        }
        let (a, b) = best(&rig);
        assert!(!fails(a, b), "a design that fails is recommended");
        let lowest = (0..135).map(|i| (f64::from(i / 15), f64::from(i % 15))).filter(|&(a, b)| !fails(a, b));
        let lowest = lowest.map(|(a, b)| wells(a, b, real)).fold(f64::INFINITY, f64::min);
        let (regret, bound) = (wells(a, b, real) - lowest, rig.status()["bound"].as_f64().unwrap());
        assert!(regret <= bound.max(3.0), "seed {seed}: {regret} although {bound} was promised");
        regrets.push(regret);
    }
    // Noise is 1; the simulation's own choice is 35 worse, the center of the box 39.
    regrets.sort_by(f64::total_cmp);
    assert!(regrets[3] <= 1.0 && regrets[4] < 10.0, "{regrets:?}");
}

/// A table that no quadratic follows: what the simulation alone would choose is its least row, as anyone can look it up.
#[test]
fn the_choice_of_the_simulation_is_the_least_row_of_its_table() {
    let simulated = |a: f64, b: f64| wells(a, b, [25.0, 60.0]) + 9.0 * (3.0 * a + 5.0 * b).sin();
    let rig = rig_of(simulated, "");
    batch(&rig, |a, b, id| Ok(wells(a, b, [60.0, 25.0]) + 0.1 * wobble(id)));
    let cells = (0..135).map(|i| (f64::from(i / 15), f64::from(i % 15)));
    let least = cells.min_by(|x, y| simulated(x.0, x.1).total_cmp(&simulated(y.0, y.1))).unwrap();
    assert_eq!(rig.status()["simulation_alone"], json!({ "a": least.0, "b": least.1 }));
}

/// A `worth` that the noise lets nobody find, and one that is only out of reach of such small batches: no number of batches is told.
#[test]
fn a_worth_that_nobody_can_find_is_said_to_be_one_and_has_no_forecast() {
    let rig = rig_of(|a, b| wells(a, b, [60.0, 20.0]), "[stop]\nworth = 1e-9\nsmooth = true\n");
    assert!(batch(&rig, |a, b, id| Ok(wells(a, b, [25.0, 60.0]) + wobble(id))));
    assert!(batch(&rig, |a, b, id| Ok(wells(a, b, [25.0, 60.0]) + wobble(id))));
    let (text, status) = (rig.infuse(&["status"]).ok(), rig.status());
    assert!(text.contains(" is more than the 1e-9 N of `worth`: more than 100 batches may be needed."), "{text}");
    let noise = status["noise"]["standard_deviation"].as_f64().expect("a number");
    let said = text.split("all of two designs, tell which is better only where they differ by ").nth(1).expect("why");
    let differ: f64 = said.split(' ').next().and_then(|number| number.parse().ok()).expect("a number");
    // By hand: 500 runs of each of two designs, one time in twenty by chance.
    assert!((differ / (1.645 * noise * (2.0 / 500.0_f64).sqrt()) - 1.0).abs() < 1e-3, "{differ} by {noise}");
    assert!(text.contains("or the campaign ends with the 3 batches that [loop] `batches` leaves."), "{text}");
    assert_eq!(status["further_batches"], Value::Null);
    assert!(!text.contains("may do") && !text.contains("go on"), "{text}");
    rig.edit("worth = 1e-9", "worth = 3");
    let (text, status) = (rig.infuse(&["status"]).ok(), rig.status());
    let is_foretold = status["further_batches"].as_u64().is_some_and(|batches| (1..100).contains(&batches));
    assert!(is_foretold && !text.contains("more than 100 batches"), "{text}");
    rig.edit("worth = 3", "worth = 1e-9");
    rig.edit("batches = 5", "batches = 5\nnoise = 0");
    let text = rig.infuse(&["status"]).ok();
    assert!(text.contains("By batches of 10 runs it is out of reach: choose a larger `worth`"), "{text}");
}

/// One design, two designs: nothing to choose from is no reason to fail.
#[test]
fn two_designs_or_one_that_is_left_are_enough() {
    for (most, expected) in [(1, (1.0, 0.0)), (0, (0.0, 0.0))] {
        // With a + 2 b at most 1 there are (0, 0) and (1, 0).
        let rig = rig_of(|a, b| a + b, &format!("[[linear_constraint]]\nsum = {{ a = 1, b = 2 }}\nupper = {most}\n"));
        rig.edit("experiments = 10", "experiments = 4");
        for _ in 0..2 {
            batch(&rig, |a, b, id| Ok(b - a + 0.01 * wobble(id)));
        }
        assert_eq!(best(&rig), expected);
        let text = rig.infuse(&["status"]).ok();
        assert!(text.contains("By the surface alone, no other design may still be the best."), "{text}");
    }
}

#[test]
fn a_prediction_beyond_what_can_be_measured_is_said() {
    let rig = rig_of(|a, b| 20.0 - 2.0 * a - b, "");
    rig.edit("goal = \"minimize\"", "goal = \"minimize\"\nlower = 0");
    batch(&rig, |a, b, _| Ok((20.0 - 2.0 * a - b).max(0.0)));
    let (status, text) = (rig.status(), rig.infuse(&["status"]).ok());
    let is_beyond = status["predicted"].as_f64() < Some(0.0);
    assert_eq!(text.contains("That cannot be measured, only"), is_beyond, "{text}");
    let said = rig.infuse(&["what-if", "a=8,b=14"]).ok();
    assert!(is_beyond || said.contains("-"), "somewhere the plane goes on: {said}");
}

#[test]
fn a_measurement_that_contradicts_the_recommendation_is_said() {
    let rig = rig_of(|a, b| wells(a, b, [40.0, 40.0]), "");
    let spoilt = ask(&rig)["experiments"][0]["id"].as_u64().unwrap();
    batch(&rig, |a, b, id| Ok(if id == spoilt { -400.0 } else { wells(a, b, [40.0, 40.0]) + 0.1 * wobble(id) }));
    let text = rig.infuse(&["status"]).ok();
    assert!(text.contains("Careful:") && text.contains(&format!("experiment {spoilt}")), "{text}");
    // Put right, nothing speaks against it any more, though a later batch was asked for.
    let settings = rig.journal().into_iter().find(|line| line["event"] == "planned").unwrap();
    assert!(settings["experiments"].is_array());
    batch(&rig, |a, b, id| Ok(wells(a, b, [40.0, 40.0]) + 0.1 * wobble(id)));
    rig.infuse(&["tell", "--id", &spoilt.to_string(), "--failed", "sensor unplugged", "--correct"]).ok();
    let text = rig.infuse(&["status"]).ok();
    assert!(!text.contains("Careful:"), "{text}");
}

#[test]
fn a_recommendation_on_a_bound_or_never_run_is_said_and_can_be_confirmed() {
    let rig = rig_of(|a, b| 20.0 + a + b, "");
    let measure = |a: f64, b: f64, id: u64| Ok(10.0 + 3.0 * a + 2.0 * b + 0.05 * wobble(id));
    batch(&rig, measure);
    let text = rig.infuse(&["status"]).ok();
    assert!(text.contains("a is on its lower bound, 0 mm") && text.contains("b is on its lower bound"), "{text}");
    let n_runs = rig.status()["runs_there"].as_u64().unwrap();
    assert_eq!(text.contains("It was never run: `infuse confirm`"), n_runs == 0, "{text}");
    let asked: Value = serde_json::from_str(&rig.infuse(&["confirm", "--runs", "4", "--json"]).ok()).unwrap();
    let experiments = asked["experiments"].as_array().unwrap();
    assert_eq!(experiments.len() % 4, 0, "{asked}");
    assert!(rig.infuse(&["confirm"]).error().contains("waited for"));
    let planned = rig.infuse(&["ask"]).ok();
    assert_eq!(planned.matches("\n  4 runs: ").count(), experiments.len() / 4, "{planned}");
    assert!(planned.contains("\n  4 runs: what was recommended, a 0 mm, b 0 "), "{planned}");
    tell(&rig, experiments, measure);
    let status = rig.status();
    let designs = status["confirmed"]["designs"].as_array().unwrap();
    assert_eq!(designs[0]["settings"], json!({ "a": 0.0, "b": 0.0 }));
    for design in designs.iter().skip(1) {
        let truth = 3.0 * design["settings"]["a"].as_f64().unwrap() + 2.0 * design["settings"]["b"].as_f64().unwrap();
        let (gain, half) = (design["gain"].as_f64().unwrap(), design["give_or_take"].as_f64().unwrap());
        assert!((gain - truth).abs() <= 2.0 * half, "{gain} ± {half} for {truth}");
    }
    let words = match designs.len() {
        1 => "Measured, with no other design to compare it with, by 4 runs",
        _ => "Compared by",
    };
    let text = rig.infuse(&["status"]).ok();
    assert!(text.contains(words) && text.contains(", the mean of "), "{text}");
    assert!(designs.len() > 1 || text.contains(", give or take "), "{text}");
    assert!(designs.iter().all(|design| design["mean_give_or_take"].as_f64().unwrap() > 0.0), "{designs:?}");
}

#[test]
fn a_useless_simulation_and_a_constant_one_are_said() {
    let chaotic = |a: f64, b: f64| 50.0 + 40.0 * (17.3 * a + 29.1 * b + a * b * 7.7).sin();
    for (simulated, words) in
        [(&chaotic as &dyn Fn(f64, f64) -> f64, "it is of little use"), (&|_, _| 7.0, "the same value everywhere")]
    {
        let rig = rig_of(simulated, "");
        for _ in 0..3 {
            batch(&rig, |a, b, id| Ok((a - 3.0).powi(2) + 0.5 * (b - 9.0).powi(2) + 0.02 * wobble(id)));
        }
        let text = rig.infuse(&["status"]).ok();
        assert!(text.contains(words), "{text}");
        // What is the same everywhere has no choice.
        let is_constant = simulated(0.0, 0.0).to_bits() == simulated(1.0, 0.0).to_bits();
        assert_eq!(text.contains("The simulation alone would have chosen"), !is_constant, "{text}");
        assert_eq!(best(&rig), (3.0, 9.0));
    }
}

/// At `check`, with a table and with a command, and at `ask`: not only once experiments were made.
#[test]
fn a_constant_simulation_is_said_before_any_experiment() {
    let of_table = rig_of(|_, _| 7.0, "");
    let said = of_table.infuse(&["check"]).ok();
    assert!(said.contains("all of them have the same value"), "{said}");
    let with_command = |command: &str| {
        let rig = Rig::pooled();
        rig.edit(
            "table = \"simulation.csv\"",
            &format!("command = [\"sh\", \"-c\", \"{command} # {{spring}} {{damper gain}}\"]"),
        );
        rig
    };
    let deaf = with_command("echo 7");
    let said = deaf.infuse(&["check"]).ok();
    assert!(said.contains("exactly the same: does the simulation take its settings?"), "{said}");
    let asked = deaf.infuse(&["ask"]);
    assert!(asked.is_success && asked.stderr.contains("gave the same value: they tell nothing"), "{}", asked.stderr);
    let hears = with_command("echo 1{spring}");
    assert!(!hears.infuse(&["check"]).ok().contains("Careful"));
    assert!(!hears.infuse(&["ask"]).stderr.contains("the same value"));
}

/// With `lower` the certificate is no more than what is left down to it, and the campaign stops where nothing is left to gain.
#[test]
fn no_certificate_goes_beyond_what_the_response_allows() {
    let rig = rig_of(|a, b| 2.0 + a + b, "[stop]\nworth = 0.3\n");
    rig.edit("goal = \"minimize\"", "goal = \"minimize\"\nlower = 1.9");
    let measure = |a: f64, b: f64, id: u64| Ok(2.0 + a + b + 0.01 * wobble(id));
    batch(&rig, measure);
    batch(&rig, measure);
    let status = rig.status();
    let (bound, expected) = (status["bound"].as_f64().unwrap(), status["predicted"].as_f64().unwrap());
    assert_eq!(status["bound_is_what_the_response_allows"], json!(true));
    assert_eq!((best(&rig), status["runs_there"].as_u64() > Some(0)), ((0.0, 0.0), true), "{status}");
    // As far as the recommended design may be above it, nine times in ten, or as was measured there.
    let sure = expected - 1.9 + 1.281_55 * status["deviation"].as_f64().unwrap();
    assert!((sure - 1e-3..sure + 0.05).contains(&bound), "{bound} at {expected}");
    let text = rig.infuse(&["status"]).ok();
    assert!(
        text.contains("More is not to be had: that is what is left down to 1.9 N, the best that [response] allows"),
        "{text}"
    );
    assert!(text.contains("Even more is held for a narrow well that no run may have met, until 40 designs"), "{text}");
    assert!(text.contains("Ended: with 90 % probability") && text.contains("Next: "), "{text}");
    assert!(rig.infuse(&["ask"]).ok().contains("confirm, a few runs that measure what was gained"));
    rig.edit("lower = 1.9", "lower = -100");
    assert!(rig.status()["bound"].as_f64() > Some(2.0 * bound), "what is far away cuts nothing");
    // A bound that results are beyond is not believed, and said to be wrong.
    let without = rig.status()["bound"].as_f64().unwrap();
    rig.edit("lower = -100", "lower = 2.5");
    assert_eq!(rig.status()["bound"].as_f64(), Some(without));
    let text = rig.infuse(&["status"]).ok();
    assert!(
        text.contains("not at least 2.5 N, the bound of the response") && !text.contains("More is not to be had"),
        "{text}"
    );
}

/// From the end on: what measures the gain, then the report; what failed is said to have failed wherever it is asked about.
#[test]
fn what_to_do_next_is_said_once_it_is_confirmed_and_what_failed_has_no_band() {
    let rig = rig_of(|a, b| a + b, "[stop]\nworth = 1000\n");
    let measure = |a: f64, b: f64, id: u64| match a > 7.5 {
        true => Err("it broke".to_owned()),
        false => Ok(a + b + 0.1 * wobble(id)),
    };
    batch(&rig, measure);
    let text = rig.infuse(&["status"]).ok();
    assert!(text.contains("Ended: ") && text.contains("confirm, a few runs that measure what was gained"), "{text}");
    let asked: Value = serde_json::from_str(&rig.infuse(&["confirm", "--json"]).ok()).unwrap();
    let open = rig.infuse(&["status"]).ok();
    assert!(!open.contains("`infuse confirm` plans a few runs there"), "{open}");
    tell(&rig, asked["experiments"].as_array().unwrap(), measure);
    let text = rig.infuse(&["status"]).ok();
    assert!(
        text.contains("report, which draws all that was found") && !text.contains("Next: infuse confirm"),
        "{text}"
    );
    let rows = rig.read("sheet-1.csv");
    let broken = rows.lines().skip(1).map(|row| row.split(',').collect::<Vec<_>>()).find(|row| row[3] == "8");
    let broken = broken.expect("a run with the highest a");
    let said = rig.infuse(&["what-if", &format!("a=8,b={}", broken[4])]).ok();
    assert!(said.contains("a run there failed (it broke)") && !said.contains("One run there would read"), "{said}");
}

/// Between settings that can be any there is always another a hair away: runs beside it are said, and no more are asked for.
#[test]
fn runs_beside_a_recommendation_that_was_never_run_are_said() {
    let rig = Rig::empty();
    let parameter = "[[parameter]]\nname = \"a\"\nunit = \"mm\"\nlower = 0\nupper = 10\n";
    rig.write(
        "campaign.toml",
        &format!("title = \"A\"\n{parameter}[response]\nname = \"y\"\nunit = \"N\"\ngoal = \"minimize\"\n[loop]\nexperiments = 8\n"),
    );
    let truth = |a: f64| (a - 6.2).powi(2);
    for number in 0..3 {
        let asked = match number {
            2 => serde_json::from_str(&rig.infuse(&["confirm", "--json"]).ok()).unwrap(),
            _ => ask(&rig),
        };
        for one in asked["experiments"].as_array().unwrap() {
            let (id, a) = (one["id"].as_u64().unwrap(), one["settings"]["a"].as_f64().unwrap());
            let value = truth(a) + 0.01 * wobble(id);
            rig.infuse(&["tell", "--id", &id.to_string(), "--value", &value.to_string()]).ok();
        }
    }
    let (text, status) = (rig.infuse(&["status"]).ok(), rig.status());
    let was_run = status["runs_there"].as_u64() > Some(0);
    assert!(was_run || text.contains("within 1 % of its settings"), "{text}");
    assert!(!text.contains("`infuse confirm` plans a few runs there"), "{text}");
}

#[test]
fn a_probability_is_written_alike_wherever_it_stands() {
    let rig = rig_of(|a, b| a + b, "");
    batch(&rig, |a, b, id| Ok(a + b + 0.1 * wobble(id)));
    for command in ["status", "log"] {
        let text = rig.infuse(&[command]).ok();
        assert!(text.contains("ith 90 % probability no"), "{text}");
        assert!(!text.contains(".0 %"), "{text}");
    }
    rig.infuse(&["report"]).ok();
    assert!(!rig.read("report.html").replace('\u{a0}', " ").contains(".0 %"));
}

#[test]
fn noise_from_two_chance_repeats_is_not_called_known() {
    let rig = rig_of(|a, b| a + b, "");
    batch(&rig, |a, b, id| Ok(a + b + 0.1 * wobble(id)));
    let text = rig.infuse(&["status"]).ok();
    assert!(text.contains("it is not known"), "{text}");
    rig.edit("batches = 5", "batches = 5\nnoise = 0.1");
    let text = rig.infuse(&["status"]).ok();
    assert!(text.contains("Noise of one run: 0.1 N (standard deviation), as `noise` in [loop] says."), "{text}");
    assert!(text.contains("says. Nothing was run twice, so nothing has put it to the test."), "{text}");
}

#[test]
fn what_if_gives_a_band_that_holds_the_truth_and_a_table() {
    let rig = rig_of(|a, b| wells(a, b, [30.0, 40.0]), "");
    let measure = |a: f64, b: f64, id: u64| Ok(1.1 * wells(a, b, [30.0, 40.0]) + 0.3 * wobble(id));
    assert!(rig.infuse(&["what-if", "a=2,b=3"]).error().contains("no experiment gave a result yet"));
    for _ in 0..3 {
        batch(&rig, measure);
    }
    let said: Value = serde_json::from_str(&rig.infuse(&["what-if", "a=4.2,b=7", "--json"]).ok()).unwrap();
    assert_eq!(said["settings"], json!({ "a": 4.0, "b": 7.0 }), "the nearest that can be set");
    let (expected, deviation) = (said["expected"].as_f64().unwrap(), said["deviation"].as_f64().unwrap());
    let truth = 1.1 * wells(4.0, 7.0, [30.0, 40.0]);
    assert!((expected - truth).abs() <= 4.0 * deviation, "{expected} ± {deviation} for {truth}");
    rig.infuse(&["what-if", "--grid", "all.csv"]).ok();
    let table = rig.read("all.csv");
    assert_eq!(table.lines().count(), 136);
    let [low, high] = [0, 1].map(|end| said["one_run"][end].as_f64().unwrap());
    assert!(low < expected && expected < high, "{said}");
    let row = table.lines().find(|line| line.starts_with("4,7,")).unwrap();
    let cells: Vec<f64> = row.split(',').map(|cell| cell.parse().unwrap()).collect();
    assert!(
        (cells[2] - expected).abs() <= 1e-3 * expected.abs() && cells[3] < cells[2] && cells[2] < cells[4],
        "{row}"
    );
    assert!(rig.infuse(&["what-if", "--grid", "all.csv"]).error().contains("is there already"));
    assert!(rig.infuse(&["what-if", "a=4"]).error().contains("no value of `b`"));
    assert!(rig.infuse(&["what-if", "a=40,b=7"]).error().contains('a'));
    let why = rig.infuse(&["status", "--why", "a=8,b=0"]).ok();
    assert!(why.contains("is not thought to be the best"), "{why}");
}

#[test]
fn results_in_any_order_from_any_number_of_jobs_are_the_same_campaign() {
    let status = |jobs: usize, backwards: bool| {
        let rig = Rig::pooled();
        let command = format!("command = [\"sh\", \"-c\", \"{}\"]\njobs = {jobs}", crate::campaigns::SHELL_SIMULATION);
        rig.edit("table = \"simulation.csv\"", &command);
        rig.edit("experiments = 10", "experiments = 8\nsimulations = 20");
        let asked = ask(&rig);
        assert!(asked["simulations_made"].as_u64() >= Some(20), "{asked}");
        let mut experiments = asked["experiments"].as_array().unwrap().clone();
        if backwards {
            experiments.reverse();
        }
        tell(&rig, &experiments, |damper, spring, id| Ok(truth(spring, damper) + 0.1 * wobble(id)));
        ask(&rig);
        (rig.status(), rig.read("sheet-2.csv"))
    };
    let one = status(1, false);
    assert_eq!(one, status(3, true));
}

#[test]
fn more_experiments_can_be_had_while_others_are_waited_for() {
    let rig = rig_of(|a, b| wells(a, b, [30.0, 40.0]), "");
    let first = ask(&rig);
    let experiments = first["experiments"].as_array().unwrap();
    tell(&rig, &experiments[..6], |a, b, id| Ok(wells(a, b, [30.0, 40.0]) + wobble(id)));
    let more: Value = serde_json::from_str(&rig.infuse(&["ask", "--more", "--json"]).ok()).unwrap();
    assert_eq!((&more["batch"], more["experiments"].as_array().unwrap().len()), (&json!(2), 10));
    let keys = |asked: &Value| asked.as_object().unwrap().keys().cloned().collect::<Vec<_>>();
    assert_eq!(keys(&more), keys(&first), "one answer, whichever way it was asked for");
    tell(&rig, more["experiments"].as_array().unwrap(), |a, b, id| Ok(wells(a, b, [30.0, 40.0]) + wobble(id)));
    assert_eq!(rig.status()["outstanding"], json!(4));
    let words = rig.infuse(&["status"]).ok();
    assert!(words.contains("batch 1 waits for 4 of 10"), "the first sheet and not the last: {words}");
    assert!(words.contains("run what is left in") && words.contains("sheet-1.csv"), "{words}");
    tell(&rig, &experiments[6..], |a, b, id| Ok(wells(a, b, [30.0, 40.0]) + wobble(id)));
    assert_eq!((&rig.status()["outstanding"], &rig.status()["told"]), (&json!(0), &json!(20)));
}

/// A batch that is completed while a later one is waited for has its line in the journal as any other, in `log` and in `status --json`.
#[test]
fn what_was_learned_is_kept_of_a_batch_that_closes_while_more_is_waited_for() {
    let rig = rig_of(|a, b| wells(a, b, [30.0, 40.0]), "");
    let measure = |a: f64, b: f64, id: u64| Ok(wells(a, b, [30.0, 40.0]) + wobble(id));
    let learned = || {
        let log: Value = serde_json::from_str(&rig.infuse(&["log", "--json"]).ok()).unwrap();
        let lines = log["log"].as_array().unwrap().iter().filter(|line| line["what"] == json!("learned"));
        let said: Vec<String> = lines.map(|line| line["sentence"].as_str().unwrap()[..13].to_owned()).collect();
        let batches = rig.status()["batches"].as_array().unwrap().len();
        (said, batches)
    };
    let first = ask(&rig);
    let first = first["experiments"].as_array().unwrap();
    tell(&rig, &first[..6], measure);
    let more: Value = serde_json::from_str(&rig.infuse(&["ask", "--more", "--json"]).ok()).unwrap();
    let more = more["experiments"].as_array().unwrap();
    tell(&rig, &more[..3], measure);
    assert_eq!(learned(), (Vec::new(), 0), "no batch is complete");
    tell(&rig, &first[6..], measure);
    assert_eq!(learned(), (vec!["after batch 1".to_owned()], 1));
    tell(&rig, &more[3..], measure);
    assert_eq!(learned(), (vec!["after batch 1".to_owned(), "after batch 2".to_owned()], 2));
    // What was told last can be taken back, with what it taught.
    rig.infuse(&["undo"]).ok();
    assert_eq!(rig.status()["batches"].as_array().unwrap().len(), 1);
    tell(&rig, &more[9..], measure);
    // Of batches that end in another order the last one says what is known.
    let third = ask(&rig);
    let fourth: Value = serde_json::from_str(&rig.infuse(&["ask", "--more", "--json"]).ok()).unwrap();
    tell(&rig, fourth["experiments"].as_array().unwrap(), measure);
    assert_eq!(learned().1, 2);
    tell(&rig, third["experiments"].as_array().unwrap(), measure);
    let batches: Vec<u64> =
        rig.status()["batches"].as_array().unwrap().iter().map(|one| one["batch"].as_u64().unwrap()).collect();
    assert_eq!(batches, [1, 2, 4]);
}

#[test]
fn imported_experiments_count_fully_from_the_first_batch_on() {
    let rig = rig_of(|a, b| wells(a, b, [60.0, 20.0]), "");
    let rows: String = (0..45)
        .map(|index| {
            let (a, b) = (f64::from(2 * (index / 9)).min(8.0), f64::from(index % 9 * 14 / 8));
            format!("{a},{b},{:.3}\n", wells(a, b, [25.0, 60.0]))
        })
        .collect();
    rig.write("old.csv", &format!("a [mm],b [mm],y [N]\n{rows}"));
    rig.infuse(&["import", "old.csv", "--source", "notebook 3"]).ok();
    let (a, b) = best(&rig);
    assert!(wells(a, b, [25.0, 60.0]) < 60.0, "the deep well is known before any batch: {a}, {b}");
    rig.infuse(&["import", "--withdraw", "notebook 3"]).ok();
    assert_eq!(rig.status()["best"], Value::Null);
}

#[test]
fn a_simulator_that_always_fails_is_said_and_can_be_done_without() {
    let rig = Rig::pooled();
    let broken = "command = [\"sh\", \"-c\", \"echo no license for {spring} {damper gain} >&2; exit 3\"]";
    rig.edit("table = \"simulation.csv\"", broken);
    let error = rig.infuse(&["ask"]).error();
    assert!(error.contains("every one of 30 simulations failed") && error.contains("no license"), "{error}");
    assert!(!rig.path("sheet-1.csv").exists());
    assert!(rig.infuse(&["ask", "--anyway"]).ok().contains("Batch 1: 10 experiments"));
}

/// Of a command: at `ask`, at `status` before any result and after; the reason once where all have the same, and long ones cut.
#[test]
fn simulations_that_failed_are_named_with_their_reasons() {
    let rig = Rig::pooled();
    let long = "x".repeat(100);
    let script = format!(
        "case {{spring}} in 10) echo '{{\"failed\": \"no equilibrium\"}}'; exit 0;; 34) echo '{{\"failed\": \"{long}\"}}'; exit 0;; esac; {}",
        crate::campaigns::SHELL_SIMULATION
    );
    let command = |script: &str| format!("command = [\"sh\", \"-c\", {}]", Value::from(script));
    rig.edit("table = \"simulation.csv\"", &command(&script));
    rig.edit("experiments = 10", "experiments = 10\nsimulations = \"all\"");
    let asked = rig.infuse(&["ask"]);
    let all = rig.journal().iter().filter(|line| line["event"] == json!("simulated")).count();
    let failed = rig.journal().iter().filter(|line| line["failed"].is_string()).count();
    let said = format!("{failed} of {all} simulations failed: spring 10 N/mm, damper gain ");
    assert!(failed > 3 && asked.stderr.contains(&said), "{said}\n{}", asked.stderr);
    assert!(asked.stderr.contains(": no equilibrium; spring 10 N/mm"), "{}", asked.stderr);
    for told in [false, true] {
        let (text, status) = (rig.infuse(&["status"]).ok(), rig.status());
        assert!(text.contains(&said) && text.contains(&format!("; and {} more, which", failed - 3)), "{told}: {text}");
        let simulations = &status["simulations"];
        assert_eq!((&simulations["failed"], &simulations["of"]), (&json!(failed), &json!(all)));
        assert_eq!(simulations["first"][0]["settings"]["spring"], json!(10.0));
        assert_eq!(simulations["first"][0]["reason"], json!("no equilibrium"));
        rig.fill("sheet-1.csv", |_| true);
        rig.infuse(&["tell", "sheet-1.csv"]).ok();
    }
    // Of a long reason the beginning; where there is one for all, it is said once.
    rig.edit(&command(&script), &command(&script.replace("in 10) ", "in 1) ")));
    let asked = rig.infuse(&["ask", "--anyway"]);
    let said = format!("simulations failed, all for one reason, {}...: spring 34 N/mm, damper gain", "x".repeat(60));
    assert!(asked.stderr.contains(&said), "{}", asked.stderr);
}

#[test]
fn designs_that_a_table_of_most_does_not_have_are_named() {
    let rig = rig_of(|a, b| a + b, "");
    let without = |row: &&str| !["0,3,", "2,5,", "7,14,", "8,0,"].iter().any(|gone| row.starts_with(gone));
    let table: String = rig.read("simulation.csv").lines().filter(without).map(|row| format!("{row}\n")).collect();
    rig.write("simulation.csv", &table);
    let said =
        "4 of 135 designs have no row in simulation.csv: a 0 mm, b 3 mm; a 2 mm, b 5 mm; a 7 mm, b 14 mm; and 1 more.";
    assert!(rig.infuse(&["ask"]).is_success);
    assert!(rig.infuse(&["status"]).ok().contains(said), "{}", rig.infuse(&["status"]).ok());
    batch(&rig, |a, b, id| Ok(a + b + 0.1 * wobble(id)));
    assert!(rig.infuse(&["status"]).ok().contains(said));
    assert_eq!(rig.status()["simulations"]["first"][3]["settings"], json!({ "a": 8.0, "b": 0.0 }));
    // Of a table with few designs the others are not missing.
    let few: String = table.lines().take(30).map(|row| format!("{row}\n")).collect();
    rig.write("simulation.csv", &few);
    assert!(!rig.infuse(&["status"]).ok().contains("no row in"));
}

#[test]
fn a_digit_that_was_changed_in_any_line_of_a_closed_batch_is_noticed() {
    let rig = Rig::pooled();
    rig.batch();
    rig.batch();
    let journal = rig.read("journal.jsonl");
    let told = journal.lines().filter(|line| line.contains("\"told\"")).count();
    assert_eq!(told, 20);
    for (number, line) in journal.lines().enumerate() {
        let Some((before, value)) = line.split_once("\"value\":").or_else(|| line.split_once("\"bound\":")) else {
            continue;
        };
        let digit = value.chars().next().unwrap();
        let other = if digit == '9' { '8' } else { '9' };
        let changed = format!("{before}{}{other}{}", &line[before.len()..line.len() - value.len()], &value[1..]);
        rig.write("journal.jsonl", &journal.replacen(line, &changed, 1));
        let error = rig.infuse(&["status"]).error();
        assert!(error.contains("one of them was changed"), "line {}: {error}", number + 1);
    }
    rig.write("journal.jsonl", &journal);
    rig.infuse(&["status"]).ok();
}

#[test]
fn journals_go_on_with_the_method_that_they_began_with() {
    let rig = Rig::new();
    rig.infuse(&["ask"]).ok();
    rig.fill("sheet-1.csv", |_| true);
    rig.infuse(&["tell", "sheet-1.csv"]).ok();
    let before = rig.status();
    rig.edit("method = \"dissertation\"\n", "");
    assert_eq!(rig.status(), before, "a file from before there was a choice");
    rig.edit("[loop]\n", "[loop]\nmethod = \"pooled\"\n");
    let error = rig.infuse(&["ask"]).error();
    assert!(error.contains("`method` was \"dissertation\" and is \"pooled\""), "{error}");
}

#[test]
fn keys_of_the_other_method_are_said_to_be_of_no_use() {
    let rig = Rig::pooled();
    rig.edit("experiments = 10", "experiments = 10\nmodel = \"quadratic\"\nreplicates = 2");
    let said = rig.infuse(&["ask"]);
    assert!(said.stderr.contains("`model`, `replicates`"), "{}", said.stderr);
    let rig = Rig::new();
    rig.edit("replicates = 2", "noise = 0.1");
    assert!(rig.infuse(&["ask"]).error().contains("`noise` belongs to `method` = \"pooled\""));
    let rig = Rig::pooled();
    for (wrong, words) in [
        ("confidence = 1.5", "`confidence` is 1.5"),
        ("noise = -1", "`noise` is -1"),
        ("method = \"best\"", "`method` is \"best\", expected `pooled` or `dissertation`"),
        ("simulations = \"some\"", "expected a whole number from 2 on, simulations per batch, or \"all\""),
    ] {
        rig.edit("[loop]\n", &format!("[loop]\n{wrong}\n"));
        let error = rig.infuse(&["ask"]).error();
        assert!(error.contains(words), "{error}");
        rig.edit(&format!("{wrong}\n"), "");
    }
    assert!(!rig.path("journal.jsonl").exists());
}

#[test]
fn a_slip_in_the_problem_may_be_put_right_before_the_first_result() {
    let rig = Rig::pooled();
    rig.infuse(&["ask"]).ok();
    rig.edit("upper = 34", "upper = 26");
    // The sheet of before is a person's, and holds what can't be set any more.
    let table: String = rig
        .read("simulation.csv")
        .lines()
        .filter(|row| !row.starts_with('3') && !row.starts_with("28"))
        .map(|row| format!("{row}\n"))
        .collect();
    rig.write("simulation.csv", &table);
    let error = rig.infuse(&["ask"]).error();
    assert!(error.contains("sheet-1.csv is there already"), "{error}");
    std::fs::remove_file(rig.path("sheet-1.csv")).unwrap();
    rig.infuse(&["ask"]).ok();
    rig.fill("sheet-1.csv", |_| true);
    rig.infuse(&["tell", "sheet-1.csv"]).ok();
    rig.edit("upper = 26", "upper = 24");
    let error = rig.infuse(&["ask"]).error();
    assert!(error.contains("`parameter[spring].upper` was 26.0 and is 24.0"), "{error}");
}

#[test]
fn a_sheet_of_another_campaign_is_not_taken_for_this_one() {
    let rig = Rig::pooled();
    rig.infuse(&["ask"]).ok();
    std::fs::remove_file(rig.path("journal.jsonl")).unwrap();
    rig.edit("seed = 1", "seed = 2");
    let error = rig.infuse(&["ask"]).error();
    assert!(error.contains("there is sheet-1.csv, but no journal.jsonl"), "{error}");
    std::fs::rename(rig.path("sheet-1.csv"), rig.path("old.csv")).unwrap();
    rig.infuse(&["ask", "--sheet", "mine.csv"]).ok();
    // Beside a journal the sheet of another campaign is told by its settings.
    std::fs::rename(rig.path("old.csv"), rig.path("sheet-1.csv")).unwrap();
    let error = rig.infuse(&["ask"]).error();
    assert!(error.contains("sheet-1.csv is there already"), "{error}");
    rig.infuse(&["ask", "--sheet", "other.csv"]).ok();
}

#[test]
fn continuous_parameters_need_no_levels() {
    let rig = Rig::pooled();
    for step in ["step = 2\n", "step = 0.2\n"] {
        rig.edit(step, "");
    }
    let command = format!("command = [\"sh\", \"-c\", \"{}\"]", crate::campaigns::SHELL_SIMULATION);
    rig.edit("table = \"simulation.csv\"", &command);
    for _ in 0..3 {
        let asked = ask(&rig);
        let Some(experiments) = asked["experiments"].as_array() else { break };
        tell(&rig, experiments, |damper, spring, id| Ok(truth(spring, damper) + 0.02 * wobble(id)));
    }
    let best = rig.status()["best"].clone();
    let (spring, damper) = (best["spring"].as_f64().unwrap(), best["damper gain"].as_f64().unwrap());
    assert!(truth(spring, damper) < truth(22.0, 1.9) + 0.05, "{best}");
}

#[test]
fn responses_of_any_size_and_two_designs_are_no_trouble() {
    for scale in [1e-12, 1.0, 1e12] {
        let rig = rig_of(|a, b| scale * (a + b), "");
        for _ in 0..2 {
            batch(&rig, |a, b, _| Ok(scale * ((a - 2.0).powi(2) + (b - 5.0).powi(2))));
        }
        // Told with four decimals, the smallest are all the same: an answer, and no error.
        assert!(rig.status()["best"]["a"].is_number());
        rig.infuse(&["status"]).ok();
        rig.infuse(&["report"]).ok();
    }
    let rig = rig_of(|a, b| a + b, "");
    batch(&rig, |_, _, _| Ok(3.0));
    assert!(rig.infuse(&["status"]).ok().contains("Recommended"), "all responses equal");
}

#[test]
fn a_quote_that_was_never_closed_swallows_no_rows() {
    let rig = Rig::pooled();
    rig.infuse(&["ask"]).ok();
    rig.fill("sheet-1.csv", |_| true);
    let sheet = rig.read("sheet-1.csv");
    let third = sheet.lines().nth(2).unwrap().to_owned();
    rig.write("sheet-1.csv", &sheet.replacen(&third, &format!("{third}\"washer missing"), 1));
    let error = rig.infuse(&["tell", "sheet-1.csv"]).error();
    assert!(error.contains("row 3: a quote (\") begins a cell") && error.contains("expected a second one"), "{error}");
}

#[test]
fn sheets_whose_journal_is_gone_are_said() {
    let rig = Rig::pooled();
    rig.infuse(&["ask"]).ok();
    std::fs::remove_file(rig.path("journal.jsonl")).unwrap();
    let said = rig.infuse(&["status"]);
    assert!(said.stderr.contains("sheet-1.csv, but no journal.jsonl"), "{}", said.stderr);
}

#[test]
fn repeats_do_not_follow_their_original_where_others_can_stand_between() {
    let rig = Rig::pooled();
    for seed in 1..=6 {
        rig.edit(&format!("seed = {seed}"), &format!("seed = {}", seed + 1));
        rig.infuse(&["ask"]).ok();
        rig.fill("sheet-1.csv", |_| true);
        rig.infuse(&["tell", "sheet-1.csv"]).ok();
        let asked: Value = serde_json::from_str(&rig.infuse(&["confirm", "--runs", "3", "--json"]).ok()).unwrap();
        let settings: Vec<&Value> =
            asked["experiments"].as_array().unwrap().iter().map(|one| &one["settings"]).collect();
        let designs: BTreeSet<String> = settings.iter().map(|settings| settings.to_string()).collect();
        if designs.len() > 1 {
            assert!(settings.windows(2).all(|pair| pair[0] != pair[1]), "{asked}");
        }
        for file in ["journal.jsonl", "sheet-1.csv", "sheet-2.csv"] {
            std::fs::remove_file(rig.path(file)).unwrap();
        }
    }
}

#[test]
fn what_is_maximized_is_said_from_low_to_high() {
    let rig = rig_of(|a, b| 50.0 - (a - 3.0).powi(2) - 0.3 * (b - 6.0).powi(2), "");
    rig.edit("goal = \"minimize\"", "goal = \"maximize\"");
    for _ in 0..2 {
        batch(&rig, |a, b, id| Ok(60.0 - (a - 5.0).powi(2) - 0.3 * (b - 9.0).powi(2) + 0.1 * wobble(id)));
    }
    assert_eq!(best(&rig), (5.0, 9.0));
    let said: Value = serde_json::from_str(&rig.infuse(&["what-if", "a=4,b=7", "--json"]).ok()).unwrap();
    let [low, high] = [0, 1].map(|end| said["one_run"][end].as_f64().unwrap());
    let truth = 60.0 - 1.0 - 0.3 * 4.0;
    assert!(low < truth && truth < high, "{said}");
}

#[test]
fn status_says_where_runs_gave_no_value() {
    let of = |fails: fn(f64, f64) -> bool| {
        let rig = rig_of(|a, b| wells(a, b, [60.0, 20.0]), "");
        let measure = |a: f64, b: f64, id: u64| {
            if fails(a, b) { Err("it broke".to_owned()) } else { Ok(wells(a, b, [25.0, 60.0]) + wobble(id)) }
        };
        batch(&rig, measure);
        batch(&rig, measure);
        let (mut failed, mut lowest, mut highest) = (0, f64::INFINITY, f64::NEG_INFINITY);
        let made: Vec<(f64, bool)> = rig
            .journal()
            .iter()
            .filter(|line| line["event"] == json!("planned"))
            .flat_map(|line| line["experiments"].as_array().unwrap().clone())
            .map(|cell| (cell.as_u64().unwrap() / 15, cell.as_u64().unwrap() % 15))
            .map(|(a, b)| (b as f64, fails(a as f64, b as f64)))
            .collect();
        for &(b, _) in made.iter().filter(|one| one.1) {
            (failed, lowest, highest) = (failed + 1, lowest.min(b), highest.max(b));
        }
        let worked = |upper: f64| made.iter().filter(|(b, fails)| !fails && (lowest..=upper).contains(b)).count();
        (rig.infuse(&["status"]).ok(), failed, [lowest, highest], [worked(f64::INFINITY), worked(highest)])
    };
    let (said, failed, [lowest, _], [n_beyond, _]) = of(|_, b| b > 10.0);
    assert!(failed > 1 && n_beyond == 0, "{failed}");
    let expected = format!(
        "No value from {failed} of 20 runs: all with b {lowest} mm or more, where no run gave one. Reason told: it broke."
    );
    assert!(said.contains(&expected), "{expected}\n{said}");
    let (said, failed, [lowest, highest], [_, n]) = of(|a, b| (a - 4.0).abs() < 2.5 && (b - 7.0).abs() < 3.5);
    assert!(failed > 1, "{said}");
    let expected = format!(
        "No value from {failed} of 20 runs: all with b {lowest} to {highest} mm, where {n} of {} runs gave one.",
        failed + n
    );
    assert!(said.contains(&expected), "{expected}\n{said}");
    assert!(!of(|_, _| false).0.contains("No value from"));
}

/// A pit that the simulation does not have, and two runs of it that agree: the bottom was seen by none.
#[test]
fn what_runs_elsewhere_do_not_expect_is_said_with_its_settings_and_looked_around() {
    let bowl = |a: f64, b: f64| 100.0 + 2.0 * (a - 3.0).powi(2) + 0.5 * (b - 4.0).powi(2);
    let rig = rig_of(bowl, "noise = 0\n");
    let in_pit = |a: f64, b: f64| (a - 6.0).abs() < 1.5 && (b - 10.5).abs() < 1.2;
    let measured = |a: f64, b: f64| bowl(a, b) - if in_pit(a, b) { 40.0 } else { 0.0 };
    let at = |index: u32| (f64::from(2 * (index / 8)), f64::from(2 * (index % 8)));
    let rows = (0..40).map(at).chain([(6.0, 11.0)]);
    let rows: String = rows.map(|(a, b)| format!("{a},{b},{}\n", measured(a, b))).collect();
    rig.write("old.csv", &format!("a [mm],b [mm],y [N]\n{rows}"));
    rig.infuse(&["import", "old.csv", "--source", "notebook 3"]).ok();
    let (text, status) = (rig.infuse(&["status"]).ok(), rig.status());
    assert_eq!(status["find"], json!({ "a": 6.0, "b": 10.0 }), "{text}");
    assert_eq!(status["held_for_a_find"], json!(true));
    assert!(
        text.contains("far better than runs elsewhere say was a 6 mm, b 10 mm. The next batch looks around it."),
        "{text}"
    );
    let asked = rig.infuse(&["ask"]).ok();
    assert!(asked.contains("around a design that was measured to be far better than runs elsewhere say"), "{asked}");
    rig.edit("noise = 0", "noise = 0\n[stop]\nsmooth = true");
    let (text, status) = (rig.infuse(&["status"]).ok(), rig.status());
    assert_eq!((&status["find"], &status["held_for_a_find"]), (&Value::Null, &json!(false)), "{text}");
    assert!(!text.contains("looks around"), "{text}");
}

/// Of six runs the best is a lucky one, and another design has the better mean: that one is called the best measured, and run to confirm.
#[test]
fn the_best_measured_design_is_that_of_the_best_mean() {
    let rig = rig_of(|a, b| 10.0 + (a - 5.0).abs() + (b - 5.0).abs(), "[stop]\nsmooth = true\n");
    let runs = [8.9, 10.4, 10.6, 10.3, 10.9, 10.2].map(|y| format!("5,5,{y}\n")).concat();
    let others = "6,5,9.3\n6,5,9.4\n0,0,20\n8,14,22\n0,14,24\n8,0,18\n4,9,15\n";
    rig.write("old.csv", &format!("a [mm],b [mm],y [N]\n{runs}{others}"));
    rig.infuse(&["import", "old.csv", "--source", "notebook"]).ok();
    let status = rig.status();
    assert_eq!(status["best_measured"]["settings"], json!({ "a": 6.0, "b": 5.0 }), "{status}");
    assert!((status["best_measured"]["value"].as_f64().unwrap() - 9.35).abs() < 1e-12, "{status}");
    assert_eq!(status["best_measured"]["runs"], json!(2));
    let text = rig.infuse(&["status"]).ok();
    assert!(text.contains("Best measured: 9.35 N, the mean of 2 runs at a 6 mm, b 5 mm."), "{text}");
    rig.infuse(&["confirm"]).ok();
    let sheet = rig.read("sheet-1.csv");
    let planned = |row: &&str| row.contains(",6,5,");
    assert_eq!(sheet.lines().filter(planned).count(), 3, "{sheet}");
}

/// What is there twice may be the same runs: while it is in use, it is said with what there is to do about it.
#[test]
fn imported_experiments_that_two_sources_have_are_said_until_one_is_withdrawn() {
    let bowl = |a: f64, b: f64| 100.0 + 2.0 * (a - 4.0).powi(2) + 0.5 * (b - 7.0).powi(2);
    let rig = rig_of(bowl, "");
    let row = |(a, b): (u32, u32)| format!("{a},{b},{:.2}\n", bowl(f64::from(a), f64::from(b)));
    let rows: String = [(0, 0), (8, 0), (0, 14), (8, 14), (4, 7), (2, 10)].into_iter().map(row).collect();
    rig.write("old.csv", &format!("a [mm],b [mm],y [N]\n{rows}"));
    rig.infuse(&["import", "old.csv", "--source", "notebook"]).ok();
    assert!(!rig.infuse(&["status"]).ok().contains("settings and results of others"));
    rig.infuse(&["import", "old.csv", "--source", "copy"]).ok();
    let said = rig.infuse(&["status"]).ok();
    assert!(said.contains("6 experiments from `copy` have settings and results of others from `notebook`"), "{said}");
    for source in ["copy", "notebook"] {
        assert!(said.contains(&format!("`infuse import --withdraw \"{source}\"`")), "either may be the copy: {said}");
    }
    rig.infuse(&["import", "--withdraw", "copy"]).ok();
    assert!(!rig.infuse(&["status"]).ok().contains("settings and results of others"));
    // Of one table, and each two sources by themselves.
    rig.infuse(&["import", "--withdraw", "notebook"]).ok();
    let of = |source: &str, rows: &str| rows.lines().map(|row| format!("{row},{source}\n")).collect::<String>();
    let one_more = of("p. 7", "1,1,117\n");
    rig.write(
        "old.csv",
        &format!(
            "a [mm],b [mm],y [N],source\n{}{}{one_more}{}",
            of("p. 7", &rows),
            of("p. 8", &rows),
            of("p. 9", "1,1,117\n")
        ),
    );
    let at_once = rig.infuse(&["import", "old.csv"]).ok();
    let later = rig.infuse(&["status"]).ok();
    for (said, what) in [(at_once, ["row", "rows"]), (later, ["experiment", "experiments"])] {
        let [one, many] = what;
        assert!(
            said.contains(&format!("6 {many} from `p. 8` have settings and results of others from `p. 7`")),
            "{said}"
        );
        assert!(
            said.contains(&format!("1 {one} from `p. 9` has settings and results of others from `p. 7`")),
            "{said}"
        );
    }
}

/// Without what was withdrawn less is known, and that is the reason that is said, not what follows from it.
#[test]
fn a_bound_that_rises_after_a_withdrawal_names_it() {
    let rig = rig_of(|a, b| a + b, "");
    rig.edit("[simulator]\ntable = \"simulation.csv\"\n", "");
    let bowl = |a: f64, b: f64| 50.0 + (a - 4.0).powi(2) + (b - 9.0).powi(2);
    let grid = (0..25).map(|at| (f64::from(2 * (at / 5)), f64::from(3 * (at % 5)), 100 + at as u64));
    let rows: String = grid.map(|(a, b, id)| format!("{a},{b},{:.3}\n", bowl(a, b) + 0.5 * wobble(id))).collect();
    rig.write("old.csv", &format!("a [mm],b [mm],y [N]\n{rows}"));
    rig.infuse(&["import", "old.csv", "--source", "notebook"]).ok();
    for _ in 0..2 {
        assert!(batch(&rig, |a, b, id| Ok(bowl(a, b) + 0.5 * wobble(id))), "a batch");
    }
    let said = "It has risen: what had been imported was withdrawn, 25 experiments of `notebook`";
    assert!(!rig.infuse(&["status"]).ok().contains(said), "nothing was withdrawn yet");
    rig.infuse(&["import", "--withdraw", "notebook"]).ok();
    let now = rig.infuse(&["status"]).ok();
    assert!(now.contains(said), "at once: {now}");
    assert!(batch(&rig, |a, b, id| Ok(bowl(a, b) + 0.5 * wobble(id))), "a batch");
    let after = rig.infuse(&["status"]).ok();
    assert!(after.contains(said), "and after the next batch: {after}");
    assert!(batch(&rig, |a, b, id| Ok(bowl(a, b) + 0.5 * wobble(id))), "a batch");
    let later = rig.infuse(&["status"]).ok();
    assert!(!later.contains("was withdrawn"), "what is said last knows of it: {later}");
}

/// The simulation would choose what was run, and failed; and fewer batches are asked for than were made.
#[test]
fn a_choice_that_failed_is_left_out_with_a_word_and_a_lowered_limit_is_not_said_to_be_reached() {
    let rig = rig_of(|a, b| a + b, "");
    let measure = |a: f64, b: f64, _| if a + b < 0.5 { Err("it jams".to_owned()) } else { Ok(5.0 + a + b) };
    assert!(batch(&rig, measure));
    assert!(batch(&rig, measure));
    let is_tried = |line: &Value| line["failed"] == json!("it jams") || line["result"]["failed"] == json!("it jams");
    assert!(rig.journal().iter().any(is_tried), "what the simulation likes best was run");
    let said = rig.infuse(&["confirm"]).ok();
    assert!(said.contains("The simulation's own choice is left out, as it failed: it jams."), "{said}");
    rig.infuse(&["undo"]).ok();
    rig.edit("batches = 5", "batches = 1");
    let said = rig.infuse(&["status"]).ok();
    assert!(said.contains("Ended: 2 batches were made, and [loop] has 1 (`batches` may be raised)."), "{said}");
}

/// The model has its wells a millimetre and two off: `status` says so, and the design that it recommends is the best of the rig.
#[test]
fn a_displaced_simulation_is_said_and_made_up_for() {
    let well =
        |a: f64, b: f64, at: [f64; 2], depth: f64| depth * (-((a - at[0]).powi(2) + (b - at[1]).powi(2)) / 6.0).exp();
    let model = |a: f64, b: f64| 20.0 + 0.2 * a - well(a, b, [5.0, 4.0], 8.0) - well(a, b, [2.0, 10.0], 5.0);
    let measured = |a: f64, b: f64, id: u64| Ok(model(a + 1.0, b - 2.0) + 0.05 * (7.0 * id as f64).sin());
    let rig = rig_of(model, "");
    for _ in 0..2 {
        batch(&rig, measured);
    }
    let status = rig.status();
    assert_eq!(status["displacement"], json!({ "a": 1.0, "b": -2.0 }));
    let registration = &status["registration"];
    assert_eq!((&registration["displacement"], &registration["is_believed"]), (&status["displacement"], &json!(true)));
    let half = registration["give_or_take"]["a"].as_f64().expect("a number");
    assert!((0.4..2.0).contains(&half), "to about a level of a millimetre: {registration}");
    assert_eq!(status["best"], json!({ "a": 4.0, "b": 6.0 }));
    let text = rig.infuse(&["status"]).ok();
    let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
    for said in [
        "It is displaced: what is measured at a 4 mm, b 7 mm, it says of a 5 mm, b 5 mm: a higher by 1 mm (give or take",
        "It is taken from there, where it explains",
        "of the designs that is beyond the bounds, where",
        "The simulation alone, taken as it stands, would have chosen",
    ] {
        assert!(text.contains(said), "{said} is not in:\n{text}");
    }
    let log = rig.infuse(&["log"]).ok();
    let said = "after batch 1: the simulation is displaced: a higher by 1 mm (give or take";
    assert!(log.contains(said), "{log}");
    // At a 8 mm, b 0 mm it would tell of what is beyond both bounds; in the middle of neither.
    let there = rig.infuse(&["what-if", "a=8,b=0"]).ok();
    let said =
        "would tell of it what it says of a 9 mm, beyond 0 to 8; b -2 mm, beyond 0 to 14: it tells little or nothing";
    assert!(there.split_whitespace().collect::<Vec<_>>().join(" ").contains(said), "{there}");
    assert!(!rig.infuse(&["what-if", "a=4,b=7"]).ok().contains("would tell of it"));
    let confirmed = rig.infuse(&["confirm"]).ok();
    assert!(confirmed.contains("the simulation's own choice, taken as it stands"), "{confirmed}");
    rig.infuse(&["undo"]).ok();
    // A model that was put right has nothing to do with where the other one was.
    let row = |index: u32| (f64::from(index / 15), f64::from(index % 15));
    let rows = (0..135).map(row).map(|(a, b)| format!("{a},{b},{:.6}\n", model(a + 1.0, b - 2.0)));
    rig.write("right.csv", &format!("a [mm],b [mm],y [N]\n{}", rows.collect::<String>()));
    rig.edit("simulation.csv", "right.csv");
    let said = rig.infuse(&["status"]).ok().split_whitespace().collect::<Vec<_>>().join(" ");
    let expected = "it was taken to be displaced; but that was another simulator: this one is taken as it stands.";
    assert!(said.contains(expected), "{said}");
    rig.edit("right.csv", "simulation.csv");
    // Who knows better takes it as it stands.
    rig.edit("[loop]", "[loop]\ndisplaced = false");
    assert!(rig.status()["displacement"].is_null(), "{}", rig.status());
    assert!(!rig.infuse(&["status"]).ok().contains("displaced"));
    rig.infuse(&["report"]).ok();
    assert!(rig.read("report.html").contains("taken as it stands"));
    rig.edit("displaced = false", "displaced = 1");
    let error = rig.infuse(&["check"]).error();
    assert!(error.contains("`displaced` is 1, expected true or false"), "{error}");
}
