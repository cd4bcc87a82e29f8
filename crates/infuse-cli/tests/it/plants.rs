//! Parameters that are hard to change: few plants in a batch, sheets ordered by plant, and what it cost.

use std::collections::BTreeSet;

use serde_json::Value;

use crate::pooled::ask;
use crate::rig::Rig;

fn rig_of(of_span: &str, of_loop: &str) -> Rig {
    let rig = Rig::empty();
    let parameter = |name: &str, role: &str, more: &str| {
        format!(
            "[[parameter]]\nname = \"{name}\"\nunit = \"mm\"\nlower = 0\nupper = 10\nstep = 1\nrole = \"{role}\"\n{more}"
        )
    };
    rig.write(
        "campaign.toml",
        &format!(
            "title = \"Tail\"\nseed = 1\n{}{}[response]\nname = \"cost\"\nunit = \"N\"\ngoal = \"minimize\"\n[simulator]\n\
             command = [\"sh\", \"simulate.sh\", \"{{span}}\", \"{{gain}}\"]\n[loop]\nexperiments = 9\nbatches = 3\n\
             simulations = \"all\"\n{of_loop}",
            parameter("span", "plant", of_span),
            parameter("gain", "controller", "")
        ),
    );
    rig.write("simulate.sh", "awk -v a=\"$1\" -v b=\"$2\" 'BEGIN { print (a-6)^2 + (b-3)^2 }'\n");
    rig
}

/// Runs a batch; how many spans it has.
fn batch(rig: &Rig) -> usize {
    let asked = ask(rig);
    let mut spans = BTreeSet::new();
    for experiment in asked["experiments"].as_array().unwrap() {
        let of = |name: &str| experiment["settings"][name].as_f64().unwrap();
        spans.insert(of("span").to_bits());
        let value = (of("span") - 4.0).powi(2) + (of("gain") - of("span")).powi(2);
        rig.infuse(&["tell", "--id", &experiment["id"].to_string(), "--value", &value.to_string()]).ok();
    }
    spans.len()
}

#[test]
fn a_batch_keeps_to_its_plants_and_its_sheet_goes_from_one_to_the_next() {
    let rig = rig_of("change_cost = 6\n", "plants = 3\nexperiment_cost = 0.5\ncost_unit = \"h\"\n");
    let mut n_plants = 0;
    for number in 1..=3 {
        let said = rig.infuse(&["ask"]).ok();
        assert!(said.contains("each put together once: another is put together after run "), "{said}");
        // Half an hour a run, and six for a plant, of which there are three at most.
        assert!(said.contains("They cost at most 22.5 h.") || said.contains("They cost at most 16.5 h."), "{said}");
        let spans = batch(&rig);
        assert!(spans <= 3, "{spans}");
        let mut sheet = csv::Reader::from_path(rig.path(&format!("sheet-{number}.csv"))).unwrap();
        let at = sheet.headers().unwrap().iter().position(|heading| heading == "span [mm]").unwrap();
        let mut in_order: Vec<String> = sheet.records().map(|record| record.unwrap()[at].to_owned()).collect();
        assert_eq!(in_order.len(), 9);
        in_order.dedup();
        assert_eq!(in_order.len(), spans, "each plant is put together once: {in_order:?}");
        n_plants += spans;
    }
    let status = rig.status();
    assert_eq!((status["best"]["span"].as_f64(), status["best"]["gain"].as_f64()), (Some(4.0), Some(4.0)));
    // The last plant of a batch may be the first of the next.
    let (cost, plants) = (status["spent"]["cost"].as_f64().unwrap(), status["spent"]["plants"].as_u64().unwrap());
    assert!((n_plants as u64 - 2..=n_plants as u64).contains(&plants), "{plants} of {n_plants}");
    assert!((cost - (27.0 * 0.5 + plants as f64 * 6.0)).abs() < 1e-9, "{cost}");
    let text = rig.infuse(&["status"]).ok();
    assert!(text.contains("Spent so far:") && text.contains(" h for 27 runs on"), "{text}");
    rig.infuse(&["report"]).ok();
    let page = rig.read("report.html").replace('\u{a0}', " ");
    assert!(page.contains("the bound against what the experiments so far have cost"), "the page draws it");
    assert!(page.contains("span (6 h to change); an experiment 0.5 h; at most 3 plants a batch"), "{page}");
}

#[test]
fn what_is_dearest_to_change_is_changed_least() {
    // The cheaper part comes first in the file: the order is by cost.
    let rig = Rig::empty();
    let parameter = |name: &str, more: &str| {
        format!("[[parameter]]\nname = \"{name}\"\nunit = \"mm\"\nlower = 0\nupper = 10\nstep = 5\n{more}")
    };
    rig.write(
        "campaign.toml",
        &format!(
            "title = \"Tail\"\nseed = 3\n{}{}{}[response]\nname = \"cost\"\nunit = \"N\"\ngoal = \"minimize\"\n\
             [simulator]\ncommand = [\"sh\", \"one.sh\", \"{{pad}}\", \"{{spring}}\", \"{{gain}}\"]\n[loop]\nexperiments = 18\nbatches = 2\nexperiment_cost = 0.5\n",
            parameter("pad", "change_cost = 2\n"),
            parameter("spring", "change_cost = 6\n"),
            parameter("gain", ""),
        ),
    );
    rig.write("one.sh", "awk -v a=\"$1\" -v b=\"$2\" 'BEGIN { print a + b }'\n");
    ask(&rig);
    let mut sheet = csv::Reader::from_path(rig.path("sheet-1.csv")).unwrap();
    let at = |name: &str, sheet: &mut csv::Reader<std::fs::File>| {
        sheet.headers().unwrap().iter().position(|heading| heading == format!("{name} [mm]")).unwrap()
    };
    let (spring, pad) = (at("spring", &mut sheet), at("pad", &mut sheet));
    let rows: Vec<csv::StringRecord> = sheet.records().map(|record| record.unwrap()).collect();
    let blocks = |of: &dyn Fn(&csv::StringRecord) -> String| {
        let mut in_order: Vec<String> = rows.iter().map(of).collect();
        let distinct: BTreeSet<String> = in_order.iter().cloned().collect();
        in_order.dedup();
        (in_order.len(), distinct.len())
    };
    let (changes, springs) = blocks(&|row| row[spring].to_owned());
    assert!(springs > 1, "one spring alone shows nothing");
    assert_eq!(changes, springs, "each spring is mounted once");
    let (changes, plants) = blocks(&|row| format!("{} {}", &row[spring], &row[pad]));
    assert!(plants > springs, "the pad has to change on a spring");
    assert_eq!(changes, plants, "each plant is put together once");
}

#[test]
fn without_costs_what_has_the_role_of_a_plant_is_the_plant() {
    let rig = rig_of("", "plants = 2\n");
    assert!(batch(&rig) <= 2 && batch(&rig) <= 2);
    let status: Value = rig.status();
    assert!(status["shared_error_of_a_plant"].as_f64().is_some(), "{status}");
}

#[test]
fn every_key_can_be_got_wrong_in_a_way_that_is_said() {
    for (of_span, of_loop, expected) in [
        ("change_cost = -1\n", "", "`change_cost` is -1.0, expected 0 to 1e9"),
        ("change_cost = nan\n", "", "`change_cost` is NaN"),
        ("change_cost = 1\n", "experiment_cost = 0\n", "`experiment_cost` is 0.0, expected a positive number"),
        ("", "plants = 0\n", "`plants` is 0, expected at least 1"),
        ("change_cost = 1\n", "method = \"dissertation\"\n", "`change_cost` belongs to `method` = \"pooled\""),
    ] {
        let said = rig_of(of_span, of_loop).infuse(&["ask"]).error();
        assert!(said.contains(expected), "{said}\nexpected {expected}");
    }
    let rig = rig_of("", "plants = 2\n");
    rig.edit("role = \"plant\"", "role = \"controller\"");
    let said = rig.infuse(&["ask"]).error();
    assert!(said.contains("`plants` needs a parameter with `change_cost`"), "{said}");
}
