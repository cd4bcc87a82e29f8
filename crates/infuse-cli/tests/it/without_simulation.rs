//! Campaigns of people who have no simulation: experiments alone tell.

use serde_json::json;

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
            let ((a, b), bound) = (best(&rig), rig.status()["bound"].as_f64().unwrap());
            let regret = wells(a, b, DEPTHS) - lowest();
            assert!(regret <= bound.max(1e-9), "seed {seed}: {regret} from the best, {bound} promised");
        }
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
    let now = "By what the surface alone says it may end now: `by = \"surface\"` under [stop] does so, at the risk of";
    let or_smooth = "write `smooth = true` under [stop], and it may end now; `by = \"surface\"` under [stop] ends it";
    assert!(status.contains(now) || status.contains(or_smooth), "{status}");
    rig.edit("worth = 10", "worth = 10\nby = \"surface\"");
    let by_the_surface = rig.status();
    assert_eq!((&by_the_surface["stage"], &by_the_surface["stops_by"]), (&json!("ended"), &json!("surface")));
    assert_eq!((&by_the_surface["bound"], &by_the_surface["further_batches"]), (&by_the_bound["bound"], &json!(0)));
    let status = rig.infuse(&["status"]).ok();
    assert!(
        status.contains("What the surface alone says, by which `by` in [stop] stops, is no more than the 10"),
        "{status}"
    );
    assert!(status.contains("Ended: by the surface alone, with 90 % probability no design is better"), "{status}");
    let checked = rig.infuse(&["check"]).ok();
    assert!(checked.contains("The campaign does not wait for that: it stops by the surface alone"), "{checked}");
    rig.edit("by = \"surface\"", "by = \"bound\"");
    assert!(batch(&rig, |a, b, id| Ok(wells(a, b, DEPTHS) + wobble(id))), "it goes on");
    rig.infuse(&["report"]).ok();
    assert!(rig.read("report.html").contains("by the surface alone"), "the history has both");
    rig.edit("by = \"bound\"", "by = \"surfaces\"");
    let error = rig.infuse(&["check"]).error();
    assert!(error.contains("`by` is \"surfaces\", expected `bound` or `surface`"), "{error}");
    let rig = rig_of(|a, b| wells(a, b, DEPTHS), "method = \"dissertation\"\n[stop]\nby = \"surface\"\n");
    let error = rig.infuse(&["check"]).error();
    assert!(error.contains("`by` belongs to `method` = \"pooled\""), "{error}");
}

/// What is measured is higher in the second batch and lower in the third, by far more than the noise.
#[test]
fn a_rig_that_drifts_is_said_and_allowed_for() {
    let rig = rig("");
    for shift in [0.0, 12.0, -12.0] {
        assert!(batch(&rig, |a, b, id| Ok(50.0 + (a - 4.0).powi(2) + (b - 9.0).powi(2) + wobble(id) + shift)));
    }
    let status = rig.infuse(&["status"]).ok();
    let said = "Careful: runs of one batch read alike, beyond what their settings explain: batch 1 ";
    assert!(status.contains(said) && status.contains("`blocks = true` in [loop] allows for it"), "{status}");
    let json = rig.status();
    assert_eq!(json["drift"]["is_sure"], true, "{json}");
    let by = |at: usize| json["drift"]["shifts"][at]["by"].as_f64().unwrap();
    assert!(by(1) - by(0) > 6.0 && by(0) - by(2) > 6.0, "{}", json["drift"]);
    rig.edit("[loop]", "[loop]\nblocks = true");
    let json = rig.status();
    assert!(json["drift"].is_null() && json["shared_error_of_a_batch"].as_f64().unwrap() > 4.0, "{json}");
    let status = rig.infuse(&["status"]).ok();
    assert!(
        status.contains("share an error, as `blocks` in [loop] says") && !status.contains("read alike"),
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
