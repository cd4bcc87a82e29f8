//! Campaigns of people who have no simulation: experiments alone tell.

use serde_json::json;
use statrs::distribution::{ContinuousCDF as _, StudentsT};

use crate::pooled::{ask, batch, best, rig_of, tell, wells, wobble};
use crate::rig::Rig;

const DEPTHS: [f64; 2] = [25.0, 60.0];
const SIMULATOR: &str = "[simulator]\ntable = \"simulation.csv\"\n";

/// The two wells, of which the left one is deeper for the simulation, where that is put back.
fn rig(more: &str) -> Rig {
    let rig = rig_of(|a, b| wells(a, b, [60.0, 20.0]), more);
    rig.edit(SIMULATOR, "");
    rig
}

fn lowest() -> f64 {
    (0..135).map(|i| wells(f64::from(i / 15), f64::from(i % 15), DEPTHS)).fold(f64::INFINITY, f64::min)
}

#[test]
fn experiments_alone_lead_to_the_best_design_and_the_certificate_holds() {
    for seed in 1..=4 {
        let rig = rig("[stop]\nworth = 3\n");
        rig.edit("seed = 1", &format!("seed = {seed}"));
        while batch(&rig, |a, b, id| Ok(wells(a, b, DEPTHS) + wobble(id))) {
            let ((a, b), bound) = (best(&rig), rig.status()["bound"].as_f64());
            let regret = wells(a, b, DEPTHS) - lowest();
            let holds = bound.is_none_or(|bound| regret <= bound.max(1e-9));
            assert!(holds, "seed {seed}: {regret} from the best, {bound:?} promised");
        }
        assert!(rig.status()["bound"].is_f64(), "seed {seed}: something is promised at the end");
        let (a, b) = best(&rig);
        assert!(wells(a, b, DEPTHS) - lowest() <= 3.0, "seed {seed}: {a}, {b}");
    }
}

#[test]
fn nothing_is_said_of_a_simulation_but_that_there_is_none() {
    let rig = rig("[stop]\nworth = 3\n");
    let checked = rig.infuse(&["check"]).ok();
    assert!(checked.contains("There is no [simulator]: experiments alone tell which designs are good."), "{checked}");
    assert!(
        checked.contains(
            "Until 40 designs were run, a repeat counting half, in 4 batches or more, what the certificate promises"
        ),
        "{checked}"
    );
    let mentions = |text: &str| text.to_lowercase().matches("simulat").count();
    assert_eq!(mentions(&checked), 1, "{checked}");
    let first = rig.infuse(&["ask"]).ok();
    assert!(first.contains("spread over all that can be set") && mentions(&first) == 0, "{first}");
    assert!(batch(&rig, |a, b, id| Ok(wells(a, b, DEPTHS) + wobble(id))));
    let second = rig.infuse(&["ask"]).ok();
    assert!(second.contains("one more run is expected to improve") && mentions(&second) == 0, "{second}");
    assert!(batch(&rig, |a, b, id| Ok(wells(a, b, DEPTHS) + wobble(id))));
    let status = rig.infuse(&["status"]).ok();
    assert!(status.contains("There is no simulation: experiments alone tell"), "{status}");
    assert_eq!(mentions(&status), 1, "{status}");
    assert!(status.contains("would have met a larger one with 90 % probability."), "{status}");
    // Twenty a parameter.
    let until = "It falls away at 40 designs run (20 so far, a repeat counting half), or by `smooth` in [stop]";
    assert!(status.contains(until), "{status}");
    // As evenly spread runs as there are have seen that much: 1 − 0.1^(1/n), n no more than those told.
    let (share, told) = (rig.status()["unseen_share"].as_f64().unwrap(), rig.status()["told"].as_u64().unwrap());
    let of = |n: u64| 1.0 - 0.1_f64.powf(1.0 / n as f64);
    assert!(share >= of(told) - 1e-12 && share <= of(told / 2), "{share} after {told} runs");
    let json = rig.status();
    assert!(json["simulation"].is_null() && json["simulation_alone"].is_null(), "{json}");
    rig.infuse(&["report"]).ok();
    let report = rig.read("report.html");
    let report = report.split("</style>").last().unwrap();
    let text: String = report.split('<').filter_map(|part| part.split_once('>')).map(|(_, text)| text).collect();
    // In `status`, in the table of settings twice: the key and what stands for it.
    assert!(mentions(&text) <= 3, "{} times", mentions(&text));
    let confirm = rig.infuse(&["confirm"]).ok();
    assert_eq!(mentions(&confirm), 0, "{confirm}");
    assert!(rig.infuse(&["ask", "--resimulate"]).error().contains("--resimulate: campaign.toml has no [simulator]"));
}

#[test]
fn a_simulation_may_come_later_and_go_again() {
    let rig = rig("");
    assert!(batch(&rig, |a, b, id| Ok(wells(a, b, DEPTHS) + wobble(id))));
    let without = rig.status();
    rig.edit("[loop]", &format!("{SIMULATOR}[loop]"));
    let with = rig.status();
    assert!(with["simulation"]["explained"].is_number() && with["simulation_alone"].is_object(), "{with}");
    let asked = ask(&rig);
    tell(&rig, asked["experiments"].as_array().unwrap(), |a, b, id| Ok(wells(a, b, DEPTHS) + wobble(id)));
    let status = rig.infuse(&["status"]).ok();
    assert!(status.contains("A well that the simulation lacks, of less than"), "{status}");
    let log = rig.infuse(&["log"]).ok();
    assert!(log.contains("the simulator was not there and is table simulation.csv."), "{log}");
    rig.infuse(&["undo"]).ok();
    rig.edit(SIMULATOR, "");
    assert!(rig.status()["simulation"].is_null());
    assert_eq!(without["batches"].as_array().unwrap().len(), 1);
}

/// Who knows that there is no narrow well is promised more, and can take it back.
#[test]
fn nothing_is_held_in_reserve_where_the_response_is_known_to_be_smooth() {
    let rig = rig("[stop]\nworth = 3\n");
    for _ in 0..2 {
        assert!(batch(&rig, |a, b, id| Ok(wells(a, b, DEPTHS) + wobble(id))));
    }
    let bound = || rig.status()["bound"].as_f64().unwrap();
    let careful = bound();
    rig.edit("worth = 3", "worth = 3\nsmooth = true");
    let smooth = bound();
    let status = rig.infuse(&["status"]).ok();
    assert!(smooth < 0.9 * careful && !status.contains("a narrow well"), "{careful}, {smooth}: {status}");
    assert!(status.contains("surface assumes, without narrow wells as `smooth` says."), "{status}");
    assert!(!status.contains("may be unseen"), "{status}");
    assert!(batch(&rig, |a, b, id| Ok(wells(a, b, DEPTHS) + wobble(id))));
    let log = rig.infuse(&["log"]).ok();
    assert!(log.contains("campaign.toml: `smooth` was not set and is true."), "{log}");
    rig.edit("smooth = true", "smooth = 1");
    let error = rig.infuse(&["check"]).error();
    assert!(error.contains("`smooth` is 1, expected true or false"), "{error}");
    let rig = rig_of(|a, b| wells(a, b, DEPTHS), "method = \"dissertation\"\n[stop]\nsmooth = true\n");
    let error = rig.infuse(&["check"]).error();
    assert!(error.contains("`smooth` belongs to `method` = \"pooled\""), "{error}");
}

/// Two batches are enough by what the surface alone says, and not by the bound; who stops by the first may think better of it.
#[test]
fn a_campaign_may_end_by_what_the_surface_alone_says() {
    let rig = rig("[stop]\nworth = 10\n");
    for _ in 0..2 {
        assert!(batch(&rig, |a, b, id| Ok(wells(a, b, DEPTHS) + wobble(id))));
    }
    let by_the_bound = rig.status();
    let number = |key: &str| by_the_bound[key].as_f64().unwrap();
    assert!(number("bound") > 10.0 && number("bound_by_the_surface_alone") <= 10.0, "{by_the_bound}");
    assert_eq!((&by_the_bound["stage"], &by_the_bound["stops_by"]), (&json!("ready"), &json!("bound")));
    let status = rig.infuse(&["status"]).ok();
    assert!(
        status.contains("; by the surface alone, by more than ") && status.contains("The bound is more than the 10"),
        "{status}"
    );
    assert!(rig.infuse(&["log"]).ok().contains(", by the surface alone by more than "));
    let now = "By the surface alone it may end now: `by = \"surface\"` under [stop] does so, at the risk of";
    assert!(status.contains(now), "{status}");
    // With what so few results may not have shown it is 30, and the reserve alone is more than that.
    rig.edit("worth = 10", "worth = 40");
    let status = rig.infuse(&["status"]).ok();
    assert!(
        status.contains("Nothing but what is held for a narrow well keeps the campaign going: if the response"),
        "{status}"
    );
    rig.edit("worth = 40", "worth = 10");
    rig.edit("worth = 10", "worth = 10\nby = \"surface\"");
    let by_the_surface = rig.status();
    assert_eq!((&by_the_surface["stage"], &by_the_surface["stops_by"]), (&json!("ended"), &json!("surface")));
    assert_eq!((&by_the_surface["bound"], &by_the_surface["further_batches"]), (&by_the_bound["bound"], &json!(0)));
    let status = rig.infuse(&["status"]).ok();
    assert!(
        status.contains("By the surface alone, by which `by` in [stop] stops, it is no more than the 10"),
        "{status}"
    );
    assert!(status.contains("of `worth`: stop, unless such a well may be there."), "{status}");
    assert_eq!(status.matches("of all designs may be unseen").count(), 1, "how large it may be: {status}");
    let ended = status.lines().find(|line| line.starts_with("Ended: ")).unwrap();
    assert!(ended.starts_with("Ended: by the surface alone, with 90 % probability no design is better"), "{ended}");
    assert!(
        ended.contains(", unless a well of less than ")
            && ended.contains(" of all designs may be there; the bound is 139"),
        "{ended}"
    );
    let checked = rig.infuse(&["check"]).ok();
    assert!(checked.contains("The campaign does not wait for that: it stops by the surface alone"), "{checked}");
    rig.edit("worth = 10\n", "");
    let (status, checked) = (rig.infuse(&["status"]).ok(), rig.infuse(&["check"]).ok());
    assert!(status.contains("is worth its cost: without it `by` ends nothing."), "{status}");
    assert!(checked.contains("`by` in [stop] ends nothing without `worth`."), "{checked}");
    rig.edit("by = \"surface\"", "worth = 10\nby = \"surface\"");
    rig.edit("by = \"surface\"", "by = \"bound\"");
    assert!(batch(&rig, |a, b, id| Ok(wells(a, b, DEPTHS) + wobble(id))), "it goes on");
    rig.infuse(&["report"]).ok();
    assert!(rig.read("report.html").contains("by the surface alone"), "the history has both");
    rig.edit("worth = 10\nby = \"bound\"", "by = \"surface\"");
    assert!(batch(&rig, |a, b, id| Ok(wells(a, b, DEPTHS) + wobble(id))), "without `worth` it goes on");
    let log = rig.infuse(&["log"]).ok();
    assert!(log.contains("`by` was not set and is \"surface\""), "{log}");
    rig.edit("by = \"surface\"", "by = \"surfaces\"");
    let error = rig.infuse(&["check"]).error();
    assert!(error.contains("`by` is \"surfaces\", expected `bound` or `surface`"), "{error}");
    let rig = rig_of(|a, b| wells(a, b, DEPTHS), "method = \"dissertation\"\n[stop]\nby = \"surface\"\n");
    let error = rig.infuse(&["check"]).error();
    assert!(error.contains("`by` belongs to `method` = \"pooled\""), "{error}");
}

/// What is measured is higher in the second batch and lower in the third, by far more than the noise: that is said and taken in, unless the
/// file forbids it.
#[test]
fn a_rig_that_drifts_is_said_and_taken_in() {
    let rig = rig("");
    for shift in [0.0, 12.0, -12.0] {
        assert!(batch(&rig, |a, b, id| Ok(50.0 + (a - 4.0).powi(2) + (b - 9.0).powi(2) + wobble(id) + shift)));
    }
    let status = rig.infuse(&["status"]).ok();
    let said = "Careful: runs of one batch, or of one source, read alike, beyond what their settings explain: batch 1 ";
    assert!(status.contains(said) && status.contains("That is taken in: they share an error of"), "{status}");
    let json = rig.status();
    assert_eq!(json["drift"]["is_sure"], true, "{json}");
    // One number of each, wherever it stands.
    assert_eq!(
        (&json["drift"]["shifts"], &json["drift"]["standard_deviation"]),
        (&json["shifts"], &json["shared_error_of_a_batch"])
    );
    let log = rig.infuse(&["log"]).ok();
    assert!(
        log.contains("after batch 3: `y` drifts, runs of one batch read alike.")
            || log.contains("after batch 2: `y` drifts"),
        "{log}"
    );
    let by = |json: &serde_json::Value, at: usize| json["shifts"][at]["by"].as_f64().unwrap();
    let are_far = |json: &serde_json::Value| by(json, 1) - by(json, 0) > 6.0 && by(json, 0) - by(json, 2) > 6.0;
    assert!(are_far(&json) && json["shared_error_of_a_batch"].as_f64().unwrap() > 4.0, "{json}");
    rig.edit("[loop]", "[loop]\nblocks = false");
    let json = rig.status();
    assert!(json["drift"]["is_sure"] == true && json["shared_error_of_a_batch"].is_null(), "{json}");
    assert_eq!((&json["drift"]["is_taken_in"], &json["shifts"]), (&json!(false), &json["drift"]["shifts"]), "{json}");
    assert!(are_far(&json), "by how much each is off is said, taken in or not: {json}");
    let status = rig.infuse(&["status"]).ok();
    assert!(status.contains(said) && status.contains("`blocks = false` in [loop] leaves it so"), "{status}");
    rig.edit("blocks = false", "blocks = true");
    let json = rig.status();
    assert_eq!((&json["drift"]["is_sure"], &json["drift"]["is_taken_in"]), (&json!(true), &json!(true)), "{json}");
    assert!(json["shared_error_of_a_batch"].as_f64().unwrap() > 4.0, "{json}");
    assert!(are_far(&json), "{json}");
    let status = rig.infuse(&["status"]).ok();
    assert!(
        status.contains("share an error, as `blocks` in [loop] says")
            && status.contains("In the mean batch 1 ")
            && !status.contains("read alike")
            && status.contains("is the mean over batches"),
        "{status}"
    );
    assert!(batch(&rig, |a, b, id| Ok(50.0 + (a - 4.0).powi(2) + (b - 9.0).powi(2) + wobble(id))));
    let log = rig.infuse(&["log"]).ok();
    assert!(log.contains("campaign.toml: `blocks` was not set and is true."), "{log}");
    rig.edit("blocks = true", "blocks = \"yes\"");
    let error = rig.infuse(&["check"]).error();
    assert!(error.contains("`blocks` is \"yes\", expected true or false"), "{error}");
    let rig = rig_of(|a, b| wells(a, b, DEPTHS), "blocks = true\nmethod = \"dissertation\"\n");
    let error = rig.infuse(&["check"]).error();
    assert!(error.contains("`blocks` belongs to `method` = \"pooled\""), "{error}");
}

/// A noise that is right is not contradicted by repeats of other batches, which differ by the drift; of nine batches the farthest off are named.
#[test]
fn of_a_rig_that_drifts_the_noise_is_not_blamed_and_the_farthest_batches_are_named() {
    let rig = rig("noise = 1\n");
    rig.edit("batches = 5", "batches = 9");
    rig.edit("experiments = 10", "experiments = 6");
    for at in 0..9 {
        let shift = 8.0 * f64::from(at) - 32.0;
        assert!(batch(&rig, |a, b, id| Ok(50.0 + (a - 4.0).powi(2) + (b - 9.0).powi(2) + wobble(id) + shift)));
    }
    let status = rig.infuse(&["status"]).ok();
    let said = status.lines().find(|line| line.contains("read alike")).unwrap_or_else(|| panic!("{status}"));
    assert!(
        said.contains(": batch 1 ") && said.contains(", batch 9 ") && said.contains(" (and 5 more, less far off)"),
        "{said}"
    );
    assert!(!said.contains("batch 5 "), "the middle one is not far off: {said}");
    assert!(
        !status.contains("`noise` in [loop] is 1 N, but") && !status.contains("Repeats contradict that"),
        "{status}"
    );
}

/// Forty experiments from elsewhere, all within a corner, leave as much unseen as a few would.
#[test]
fn imported_runs_that_crowd_are_said_to_count_for_few() {
    let rig = rig("");
    let rows: String = (0..40)
        .map(|at| {
            let (a, b) = (0.05 * f64::from(at % 8), 0.1 * f64::from(at / 8));
            format!("{a},{b},{:.4}\n", wells(a, b, DEPTHS) + wobble(at as u64))
        })
        .collect();
    rig.write("old.csv", &format!("a [mm],b [mm],y [N]\n{rows}"));
    rig.infuse(&["import", "old.csv", "--source", "notebook"]).ok();
    assert!(batch(&rig, |a, b, id| Ok(wells(a, b, DEPTHS) + wobble(id))));
    let status = rig.infuse(&["status"]).ok();
    let said = " so far, a repeat counting half, and imported ones that crowd for as few as would tell as much)";
    assert!(status.contains(said), "{status}");
    assert!(rig.status()["designs_counted"].as_f64() < Some(25.0), "{status}");
}

/// Of what is maximized more is left up to `upper`, and the best value is the highest.
#[test]
fn what_is_left_of_what_is_maximized_is_up_to_its_best() {
    let rig = rig("");
    rig.edit("goal = \"minimize\"", "goal = \"maximize\"\nupper = 21");
    for _ in 0..2 {
        assert!(batch(&rig, |a, b, id| Ok(20.0 - a - b + 0.01 * wobble(id))));
    }
    let status = rig.infuse(&["status"]).ok();
    assert!(status.contains("More is not to be had: that is what is left up to 21 N, the best that"), "{status}");
}

/// What was read otherwise in the second batch is put right: that the rig drifts is said no more, and that it was.
#[test]
fn a_drift_that_is_gone_is_said_to_be() {
    let rig = rig("");
    let mut told: Vec<(u64, f64)> = Vec::new();
    for shift in [0.0, 12.0, -12.0] {
        let asked = ask(&rig);
        tell(&rig, asked["experiments"].as_array().unwrap(), |a, b, id| {
            let value = 50.0 + (a - 4.0).powi(2) + (b - 9.0).powi(2) + wobble(id);
            told.push((id, value));
            Ok(value + shift)
        });
    }
    assert_eq!(rig.status()["drift"]["is_sure"], true, "{}", rig.status());
    let mut right = "id,y [N]\n".to_owned();
    told.iter().for_each(|(id, value)| right.push_str(&format!("{id},{value}\n")));
    rig.write("right.csv", &right);
    rig.infuse(&["tell", "right.csv", "--correct"]).ok();
    let status = rig.infuse(&["status"]).ok();
    let said = "Careful: after batch 2 the results were sure that runs of one batch read alike in `y`; by all that is known now they are not";
    assert!(status.contains(said), "{status}");
    assert!(batch(&rig, |a, b, id| Ok(50.0 + (a - 4.0).powi(2) + (b - 9.0).powi(2) + wobble(id))));
    let log = rig.infuse(&["log"]).ok();
    assert!(log.contains(": results are not sure any more that `y` drifts."), "{log}");
    assert!(!rig.infuse(&["status"]).ok().contains("read alike"), "it was said after the batch before");
}

/// Student's interval by all repeats of the campaign, those of earlier batches among them; with `blocks` by those of one batch.
#[test]
fn what_confirms_takes_its_noise_from_all_repeats() {
    let rig = rig("");
    let mut told: Vec<((u64, u64), u64, f64)> = Vec::new();
    let mut n_batches = 0;
    let mut batch_of = |asked: &serde_json::Value, rig: &Rig| {
        n_batches += 1;
        tell(rig, asked["experiments"].as_array().unwrap(), |a, b, id| {
            let value = 50.0 + (a - 4.0).powi(2) + (b - 9.0).powi(2) + wobble(id);
            told.push(((a as u64, b as u64), n_batches, (1e4 * value).round() / 1e4));
            Ok(value)
        });
    };
    for _ in 0..3 {
        let asked = ask(&rig);
        batch_of(&asked, &rig);
    }
    let asked: serde_json::Value = serde_json::from_str(&rig.infuse(&["confirm", "--json"]).ok()).unwrap();
    batch_of(&asked, &rig);
    // By hand: the squares about the mean of each group, and how many they are beyond one a group.
    let pure_error = |is_split: bool| {
        let mut groups: std::collections::BTreeMap<_, Vec<f64>> = std::collections::BTreeMap::new();
        for (settings, batch, value) in &told {
            groups.entry((settings, if is_split { *batch } else { 0 })).or_default().push(*value);
        }
        let squares = groups.values().map(|values| {
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            values.iter().map(|value| (value - mean).powi(2)).sum::<f64>()
        });
        let degrees: usize = groups.values().map(|values| values.len() - 1).sum();
        (squares.sum::<f64>() / degrees as f64, degrees)
    };
    let half = |rig: &Rig| rig.status()["confirmed"]["designs"][0]["mean_give_or_take"].as_f64().unwrap();
    let expected = |(variance, degrees): (f64, usize)| {
        let student = StudentsT::new(0.0, 1.0, degrees as f64).unwrap();
        student.inverse_cdf(0.95) * (variance / 3.0).sqrt()
    };
    let (all, within) = (pure_error(false), pure_error(true));
    assert!((half(&rig) / expected(all) - 1.0).abs() < 1e-6, "{} and {all:?}", half(&rig));
    assert!(within.1 < all.1, "some settings were run in several batches: {all:?} {within:?}");
    rig.edit("[loop]", "[loop]\nblocks = true");
    // The mean of a batch has in it what its runs share.
    let shared = rig.status()["shared_error_of_a_batch"].as_f64().unwrap();
    let expected = expected(within).hypot(1.645 * shared);
    assert!((half(&rig) / expected - 1.0).abs() < 1e-6, "{} and {within:?}, {shared}", half(&rig));
}

#[test]
fn what_needs_a_simulation_says_so() {
    let rig = rig("simulations = 30\n");
    let error = rig.infuse(&["check"]).error();
    assert!(error.contains("[loop]: `simulations` is set, but there is no [simulator]"), "{error}");
    rig.edit("simulations = 30\n", "method = \"dissertation\"\n");
    let error = rig.infuse(&["check"]).error();
    assert!(error.contains("no [simulator], which `method` = \"dissertation\" corrects by experiments"), "{error}");
    // A table that is there, but empty, is a slip.
    rig.edit("method = \"dissertation\"\n", "");
    rig.edit("[loop]", "[simulator]\n[loop]");
    let error = rig.infuse(&["check"]).error();
    assert!(error.contains("[simulator]: needs `command`"), "{error}");
}

/// Neither what the file may have instead nor another method would do: the journal has begun with a simulation.
#[test]
fn a_simulation_that_the_dissertation_corrects_cannot_be_taken_out() {
    let rig = rig_of(|a, b| wells(a, b, DEPTHS), "method = \"dissertation\"\n");
    batch(&rig, |a, b, _| Ok(wells(a, b, DEPTHS)));
    rig.edit(SIMULATOR, "");
    let error = rig.infuse(&["status"]).error();
    assert!(error.contains("[simulator] was taken out") && error.contains("put it back"), "{error}");
    assert!(!error.contains("`method` = \"pooled\""), "{error}");
}
