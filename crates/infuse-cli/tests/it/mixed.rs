//! What campaigns have together: choices, constraints that come and go, plants, failures, workbooks, and the page beside the rig.

use std::collections::BTreeMap;

use calamine::{Data, Reader as _, Xlsx};
use serde_json::{Value, json};

use crate::pooled::ask;
use crate::rig::Rig;
use crate::served::{Served, field};

const HEAD: &str = "title = \"Mixed\"\nseed = 1\n";
const X: &str = "[[parameter]]\nname = \"x\"\nunit = \"mm\"\nlower = 0\nupper = 10\nstep = 1\nrole = \"plant\"\n";
const Y: &str = "[[parameter]]\nname = \"y\"\nunit = \"mm\"\nlower = 0\nupper = 10\nrole = \"controller\"\n";
const KIND: &str = "[[parameter]]\nname = \"kind\"\nchoices = [\"foam\", \"film\"]\nrole = \"controller\"\n";
const TRAVEL: &str = "[[constraint]]\nname = \"travel\"\nunit = \"mm\"\nupper = 9\n";
const REST: &str = "[response]\nname = \"cost\"\nunit = \"EUR\"\ngoal = \"minimize\"\n[simulator]\n";

/// The simulation says how far the travel is, too, whether that is asked for or not.
const SIMULATE: &str = "[ \"$3\" = foam ] && k=3 || k=0\n\
    awk -v x=$1 -v y=$2 -v k=$k 'BEGIN { printf \"{\\\"value\\\": %.9g, \\\"travel\\\": %.9g}\\n\", \
    (x - 6)^2 / 4 + (y - 6)^2 / 4 + k, x + y }'\n";

/// Two numbers and a choice; `more` stands after the simulator.
fn rig_of(x: &str, of_loop: &str, more: &str) -> Rig {
    let rig = Rig::empty();
    let command = "command = [\"sh\", \"simulate.sh\", \"{x}\", \"{y}\", \"{kind}\"]\n";
    rig.write(
        "campaign.toml",
        &format!(
            "{HEAD}{x}{Y}{KIND}{REST}{command}{more}[loop]\nexperiments = 8\nsimulations = 30\nbatches = 8\n{of_loop}"
        ),
    );
    rig.write("simulate.sh", SIMULATE);
    rig
}

fn number(experiment: &Value, name: &str) -> f64 {
    experiment["settings"][name].as_f64().unwrap()
}

/// The cost and the travel; nothing where it breaks.
fn measure(experiment: &Value) -> Option<(f64, f64)> {
    let (x, y) = (number(experiment, "x"), number(experiment, "y"));
    let kind = if experiment["settings"]["kind"] == "foam" { 2.0 } else { 0.0 };
    (x <= 9.0).then(|| ((x - 7.0).powi(2) / 4.0 + (y - 6.0).powi(2) / 4.0 + kind, x + y + 0.1 * kind))
}

/// Fills in a batch as a table of ids; the experiments that were asked for.
fn batch(rig: &Rig, with_travel: bool) -> Vec<Value> {
    let asked = ask(rig);
    let experiments = asked["experiments"].as_array().unwrap().clone();
    let mut table = format!("id,cost [EUR],failed{}\n", if with_travel { ",travel [mm]" } else { "" });
    for experiment in &experiments {
        let (cost, failed, travel) = match measure(experiment) {
            Some((cost, travel)) => (cost.to_string(), "", travel.to_string()),
            None => (String::new(), "it broke", String::new()),
        };
        let travel = if with_travel { format!(",{travel}") } else { String::new() };
        table.push_str(&format!("{},{cost},{failed}{travel}\n", experiment["id"]));
    }
    rig.write("filled.csv", &table);
    rig.infuse(&["tell", "filled.csv"]).ok();
    experiments
}

fn simulated(rig: &Rig) -> Vec<Value> {
    rig.journal().into_iter().filter(|line| line["event"] == "simulated").collect()
}

#[test]
fn linear_constraints_hold_where_every_setting_is_allowed() {
    let x = X.replace("step = 1\n", "");
    let linear = "[[linear_constraint]]\nsum = { x = 1, y = 1 }\nupper = 8\n[[linear_constraint]]\nsum = { x = 2, y = -1 }\nlower = -1\n";
    let rig = rig_of(&x, "", linear);
    // The middle of all bounds is not among them, and is not simulated.
    rig.write(
        "simulate.sh",
        &format!(
            "awk -v x=$1 -v y=$2 'BEGIN {{ exit !(x + y > 8.000001 || 2 * x - y < -1.000001) }}' && exit 7\n{SIMULATE}"
        ),
    );
    let checked: Value = serde_json::from_str(&rig.infuse(&["check", "--json"]).ok()).unwrap();
    assert_eq!(checked["simulation"]["failed"], json!([]), "{checked}");
    // Of a square with sides of 10 the triangle under x + y = 8, less what lies above y = 2 x + 1.
    let corner = 7.0 / 3.0;
    let share = (32.0 - 0.5 * 7.0 * corner) / 100.0;
    let found = checked["share_allowed"].as_f64().unwrap();
    assert!((found - share).abs() < 0.005, "{found} for {share}");
    for _ in 0..3 {
        for experiment in batch(&rig, false) {
            let (x, y) = (number(&experiment, "x"), number(&experiment, "y"));
            assert!(x + y <= 8.0 + 1e-9 && 2.0 * x - y >= -1.0 - 1e-9, "{x} {y}");
        }
    }
    assert!(simulated(&rig).iter().all(|line| line.get("failed").is_none()));
    // On the line x + y = 8 the best is (4.5, 3.5).
    let best = rig.status()["best"].clone();
    let (x, y) = (best["x"].as_f64().unwrap(), best["y"].as_f64().unwrap());
    assert!((x - 4.5).abs() < 0.6 && (y - 3.5).abs() < 0.6 && best["kind"] == "film", "{best}");
    let said = rig.infuse(&["what-if", "x=9,y=9,kind=FILM"]).ok();
    assert!(said.contains("kind film"), "as headings are, whatever the case: {said}");
    assert!(said.contains("[[linear_constraint]] asks for x + y at most 8."), "{said}");
    rig.infuse(&["confirm"]).ok();
    rig.infuse(&["report"]).ok();
    assert!(rig.read("report.html").replace('\u{a0}', " ").contains("2 x - y at least -1"));
}

#[test]
fn what_can_be_built_may_change_from_one_batch_to_the_next() {
    let check = "[can_be_built]\ncommand = [\"sh\", \"check.sh\", \"{x}\", \"{y}\", \"{kind}\", \"v1\"]\n";
    let rig = rig_of(X, "", check);
    rig.write("check.sh", "[ $4 = v1 ] || [ $1 -le 4 ] && echo 1 || echo 0\n");
    for _ in 0..2 {
        batch(&rig, false);
    }
    assert!(rig.status()["best"]["x"].as_f64().unwrap() > 5.0);
    rig.edit("\"v1\"", "\"v2\"");
    let asked = rig.infuse(&["what-if", "x=7,y=2,kind=film"]).ok();
    assert!(asked.contains("It cannot be built, says the command of [can_be_built]"), "{asked}");
    let text = rig.infuse(&["status"]).ok();
    assert!(text.contains("Whether it can be built is not known: the command of [can_be_built]"), "{text}");
    rig.infuse(&["ask"]).ok();
    assert!(rig.status()["best"]["x"].as_f64().unwrap() <= 4.0, "asked of what is recommended, too");
    // Not even what was built and measured before is asked for again.
    for _ in 0..2 {
        for experiment in batch(&rig, false) {
            assert!(number(&experiment, "x") <= 4.0, "{experiment}");
        }
        let status = rig.status();
        assert!(status["best"]["x"].as_f64().unwrap() <= 4.0, "{status}");
    }
    let text = rig.infuse(&["status"]).ok();
    assert!(text.contains("[can_be_built] says that it cannot be built"), "of what measured best: {text}");
    assert!(!text.contains("Careful"), "{text}");
    rig.infuse(&["confirm"]).ok();
    let planned = rig.journal().into_iter().rfind(|line| line["event"] == "planned").unwrap();
    assert_eq!(planned["purpose"], "confirm");
    let sheet = rig.read("sheet-5.csv");
    for row in sheet.lines().skip(1) {
        let x: f64 = row.split(',').nth(3).unwrap().parse().unwrap();
        assert!(x <= 4.0, "{sheet}");
    }
    let log = rig.infuse(&["log"]).ok();
    assert!(log.contains("of them cannot be built"), "{log}");
    assert!(log.matches("  checked  ").count() <= 10, "what was asked at once is one line: {log}");
}

#[test]
fn a_constraint_may_come_move_and_go_and_be_taken_back() {
    let rig = rig_of(X, "plants = 4\ncost_unit = \"h\"\n", "");
    rig.edit("experiments = 8\nsimulations = 30", "experiments = 6\nsimulations = 20");
    rig.edit("role = \"plant\"", "role = \"plant\"\nchange_cost = 5");
    batch(&rig, false);
    batch(&rig, false);
    assert!(rig.status()["best_measured"]["value"].as_f64().unwrap() < 0.5);
    // What was simulated before is known of it already.
    assert!(simulated(&rig).iter().all(|line| line["constrained"]["travel"].is_number()));
    let open = ask(&rig)["experiments"].as_array().unwrap().len();
    rig.edit("[loop]", &format!("{TRAVEL}[loop]"));
    // The sheet that was written before has no column for it, and may be told.
    let sheet = rig.read("sheet-3.csv");
    assert!(!sheet.contains("travel"));
    rig.infuse(&["ask"]).ok();
    rig.infuse(&["undo"]).ok();
    std::fs::remove_file(rig.path("sheet-3.csv")).unwrap();
    assert_eq!(batch(&rig, true).len(), open);
    let status = rig.status();
    let best = &status["best"];
    assert!(best["x"].as_f64().unwrap() + best["y"].as_f64().unwrap() <= 9.0, "{best}");
    // A design that is sure to break the bound is neither called the best measured nor held against the recommended one.
    let settings = &status["best_measured"]["settings"];
    assert!(settings["x"].as_f64().unwrap() + settings["y"].as_f64().unwrap() <= 9.5, "{settings}");
    let text = rig.infuse(&["status"]).ok();
    assert!(!text.contains("standard errors better"), "{text}");
    rig.edit("upper = 9\n", "upper = 6\n");
    batch(&rig, true);
    let tighter = rig.status()["best"].clone();
    assert!(tighter["x"].as_f64().unwrap() + tighter["y"].as_f64().unwrap() <= 6.0, "{tighter}");
    // Taking the last results back and telling them again changes nothing.
    rig.infuse(&["undo"]).ok();
    rig.infuse(&["tell", "filled.csv"]).ok();
    assert_eq!(rig.status()["best"], tighter);
    let said = rig.infuse(&["what-if", "x=9,y=9,kind=film"]).ok();
    let (_, chance) = said.split_once("at most 6 mm with ").expect("a probability");
    let chance = chance.trim_start_matches("less than ").split(' ').next().expect("a number");
    assert!(chance.parse::<f64>().expect("percent") < 0.1, "18 mm: {said}");
    rig.infuse(&["confirm"]).ok();
    let confirming = rig.read("sheet-5.csv");
    for row in confirming.lines().skip(1) {
        let cells: Vec<&str> = row.split(',').collect();
        let (x, y): (f64, f64) = (cells[3].parse().unwrap(), cells[4].parse().unwrap());
        assert!(x + y <= 7.0, "{confirming}");
    }
    rig.infuse(&["undo"]).ok();
    // The page says of what measured best why it is not the best, and its maps set it off.
    let page = crate::report_page::page(&rig);
    assert!(page.contains("it would break the bound of travel") || page.contains("it breaks the bound of travel"));
    assert!(page.contains("not sure enough to keep to the bounds") && page.contains("class=\"unsure\""));
    assert!(page.contains(">foam</text>") && !page.contains("0 foam"));
    // Without it all is as if it had never been asked for, and a sheet that has its column says what to do.
    let toml = rig.read("campaign.toml").replace(&TRAVEL.replace("upper = 9", "upper = 6"), "");
    rig.write("campaign.toml", &toml);
    let free = rig.infuse(&["status"]);
    assert!(free.stderr.contains("`travel` was measured, but campaign.toml has no [[constraint]]"), "{}", free.stderr);
    let said = rig.infuse(&["tell", "filled.csv"]).error();
    assert!(said.contains("`travel [mm]` is not known") && said.contains("may be removed"), "{said}");
    let best = rig.status()["best"].clone();
    assert!(best["x"].as_f64().unwrap() + best["y"].as_f64().unwrap() > 10.0, "{best}");
}

#[test]
fn a_linear_constraint_may_come_while_a_batch_is_open() {
    let rig = rig_of(X, "", "");
    batch(&rig, false);
    let experiments = ask(&rig)["experiments"].as_array().unwrap().clone();
    rig.edit("[loop]", "[[linear_constraint]]\nsum = { x = 1 }\nupper = 3\n[loop]");
    let n = experiments.iter().filter(|one| number(one, "x") > 3.0).count();
    assert!(n > 0);
    let said = rig.infuse(&["status"]);
    assert!(
        said.stderr.contains("would not be asked for any more ([[linear_constraint]] asks for x at most 3)"),
        "{}",
        said.stderr
    );
    batch(&rig, false);
    let text = rig.infuse(&["status"]).ok();
    assert!(text.contains("kind film; [[linear_constraint]] asks for x at most 3."), "of what measured best: {text}");
    assert!(rig.status()["best"]["x"].as_f64().unwrap() <= 3.0);
    assert!(batch(&rig, false).iter().all(|one| number(one, "x") <= 3.0));
    rig.edit("upper = 3\n", "upper = -1\n");
    assert!(rig.infuse(&["check"]).error().contains("[[linear_constraint]]: no design was found with"));
}

/// The cells of a workbook, by heading.
fn rows(rig: &Rig, name: &str) -> Vec<BTreeMap<String, Data>> {
    let mut book = Xlsx::new(std::io::Cursor::new(std::fs::read(rig.path(name)).unwrap())).unwrap();
    let range = book.worksheet_range_at(0).unwrap().unwrap();
    let headings: Vec<String> = range.headers().unwrap();
    range.rows().skip(1).map(|row| headings.iter().cloned().zip(row.iter().cloned()).collect()).collect()
}

#[test]
fn choices_go_into_workbooks_and_come_back() {
    let rig = rig_of(X, "", TRAVEL);
    rig.edit("seed = 1", "seed = 1\nsheets = \"xlsx\"");
    rig.infuse(&["ask"]).ok();
    let asked = rows(&rig, "sheet-1.xlsx");
    let text = |row: &BTreeMap<String, Data>, heading: &str| row[heading].to_string();
    let kinds: Vec<String> = asked.iter().map(|row| text(row, "kind")).collect();
    assert!(kinds.contains(&"foam".to_owned()) && kinds.contains(&"film".to_owned()), "{kinds:?}");
    let fill = |actual: &str| {
        let mut book = rust_xlsxwriter::Workbook::new();
        let sheet = book.add_worksheet();
        for (column, heading) in ["id", "kind", "cost [EUR]", "travel [mm]", "actual kind"].iter().enumerate() {
            sheet.write_string(0, column as u16, *heading).unwrap();
        }
        for (index, row) in asked.iter().enumerate() {
            let at = index as u32 + 1;
            sheet.write_number(at, 0, text(row, "id").parse::<f64>().unwrap()).unwrap();
            sheet.write_string(at, 1, text(row, "kind")).unwrap();
            sheet.write_number(at, 2, 5.0 + f64::from(at)).unwrap();
            sheet.write_number(at, 3, 8.0).unwrap();
            if at == 2 {
                sheet.write_string(at, 4, actual).unwrap();
            }
        }
        book.save(rig.path("back.xlsx")).unwrap();
    };
    fill("glass");
    let said = rig.infuse(&["tell", "back.xlsx"]).error();
    assert!(said.contains("`actual kind`: is `glass`, expected one of `foam`, `film`"), "{said}");
    fill("foam");
    rig.infuse(&["tell", "back.xlsx"]).ok();
    let told = rig.journal().into_iter().filter(|line| line["event"] == "told").count();
    assert_eq!(told, asked.len());
}

#[test]
fn the_page_asks_for_choices_by_name_and_for_constraints_with_their_bounds() {
    let rig = rig_of(X, "", TRAVEL);
    rig.infuse(&["ask"]).ok();
    let served = Served::new(&rig);
    let page = served.get("/").body;
    assert!(page.contains("travel [mm]: at most 9 mm"), "{page}");
    assert!(
        page.contains(
            "<select name=\"cell-1-5\"><option value=\"\" selected>as asked for</option><option value=\"foam\">"
        ),
        "{page}"
    );
    let save = |page: &str, id: u64, cells: [&str; 4]| {
        let name = |place: usize| format!("cell-{id}-{place}");
        let [value, travel, failed, kind] = cells.map(str::to_owned);
        let empty = String::new;
        let fields = [
            (format!("was-{id}"), field(page, &format!("was-{id}"))),
            (name(0), value),
            (name(1), travel),
            (name(2), failed),
            (name(3), empty()),
            (name(4), empty()),
            (name(5), kind),
            (name(6), empty()),
        ];
        let fields: Vec<(&str, &str)> = fields.iter().map(|(name, value)| (&**name, &**value)).collect();
        served.post("/tell", &fields)
    };
    assert_eq!(save(&page, 1, ["5", "8,5", "", "foam"]).status, 303);
    let page = served.get("/").body;
    assert!(page.contains("<option value=\"foam\" selected>"), "{page}");
    assert_eq!(field(&page, "cell-1-1"), "8.5");
    let refused = save(&page, 2, ["5", "long", "", ""]);
    assert_eq!(refused.status, 422);
    assert!(
        refused.body.contains("id=\"cell-2-1-fault\"") && field(&refused.body, "cell-2-1") == "long",
        "{}",
        refused.body
    );
    assert!(save(&page, 2, ["5", "8", "", "glass"]).body.contains("expected one of <code>foam</code>"));
    assert_eq!(save(&page, 3, ["", "", "it broke", ""]).status, 303);
    // Another constraint takes the place of this one while the page is open.
    rig.edit("name = \"travel\"", "name = \"stroke\"");
    let stale = save(&page, 4, ["5", "8", "", ""]);
    assert_eq!(stale.status, 422);
    assert!(stale.body.contains("the columns are others than when this page was made") && stale.body.contains("5, 8"));
    assert_eq!(rig.journal().iter().filter(|line| line["event"] == "told").count(), 2);
}

#[test]
fn the_page_hands_out_another_batch_and_stops_a_queue() {
    let rig = rig_of(X, "", "");
    batch(&rig, false);
    rig.infuse(&["ask"]).ok();
    let served = Served::new(&rig);
    let page = served.get("/").body;
    assert!(page.contains("href=\"/more\"") && !page.contains("href=\"/cancel\""), "{page}");
    let question = served.get("/more").body;
    let lines = field(&question, "lines");
    assert_eq!(served.post("/more", &[("lines", "1")]).status, 409, "something was written down since");
    assert_eq!(served.post("/more", &[("lines", &lines)]).status, 303);
    assert!(served.settled().contains("Batch 3"));
    assert_eq!(served.post("/cancel", &[]).status, 409, "there is no queue");
    rig.edit("[loop]", "[simulator.queue]\nsubmit = [\"sh\", \"-c\", \"echo 1\", \"{script}\", \"{tasks}\"]\nlist = [\"true\"]\ncancel = [\"true\"]\n[loop]");
    assert!(served.get("/").body.contains("href=\"/cancel\""));
    assert!(served.get("/cancel").body.contains("Stop them"));
    assert_eq!(served.post("/cancel", &[]).status, 303);
    assert!(served.get("/").body.contains("Nothing of this campaign is in the queue."));
}
