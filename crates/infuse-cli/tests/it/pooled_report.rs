//! The page that `infuse report` makes of a campaign of the pooled loop.

use std::collections::BTreeMap;

use serde_json::Value;

use crate::report_page::{EVIL, assert_gives_the_same_bytes, page, table};
use crate::rig::{Rig, told};

const SECTIONS: [&str; 7] = [
    "Where the campaign stands",
    "History",
    "Surfaces",
    "Fit",
    "Best and most telling experiments",
    "Sheets",
    "Provenance",
];

/// Two batches, the second with a failure, other settings and a note; and one that is waited for.
fn eventful() -> Rig {
    let rig = Rig::pooled();
    rig.edit("worth = 0.2", "worth = 0.000001");
    rig.write("old.csv", "spring [N/mm],damper gain [N s/mm],vibration [mm/s],source\n21.3,1.85,7.1,p. <i>&\"'\n");
    rig.infuse(&["import", "old.csv", "--source", "notebook"]).ok();
    assert!(rig.batch());
    rig.infuse(&["ask", "--anyway"]).ok();
    rig.fill("sheet-2.csv", |id| ![11, 12].contains(&id));
    rig.infuse(&["tell", "sheet-2.csv"]).ok();
    rig.infuse(&["tell", "--id", "12", "--failed", &format!("belt {EVIL} slipped")]).ok();
    rig.infuse(&["tell", "--id", "11", "--value", "17.77", "--actual", "spring=21.37", "--note", EVIL]).ok();
    rig.infuse(&["ask", "--anyway"]).ok();
    rig
}

/// What a pointer is shown on each cell of a map of this class, with the middle of the cell in pixels.
fn cells(page: &str, class: &str) -> Vec<((f64, f64), String)> {
    let cell = |text: &str| {
        let (head, title) = text.split_once("<title>").unwrap();
        let [x, y, width, height] = ["x", "y", "width", "height"].map(|name| number(head, name));
        ((x + 0.5 * width, y + 0.5 * height), title.split_once("</title>").unwrap().0.to_owned())
    };
    page.split(&format!("<rect class=\"{class}\"")).skip(1).map(cell).collect()
}

fn number(text: &str, name: &str) -> f64 {
    let from = text.split_once(&format!(" {name}=\"")).unwrap().1;
    from.split_once('"').unwrap().0.parse().unwrap()
}

/// The value that a pointer on a cell is shown.
fn shown(title: &str) -> f64 {
    title.split(": ").nth(1).unwrap().split([' ', ',']).next().unwrap().parse().unwrap()
}

#[track_caller]
fn check(page: &str) {
    let mut rest = page;
    for section in SECTIONS {
        rest = rest.split_once(&format!(">{section}</h2>")).expect(section).1;
    }
    for foreign in ["http:", "https:", "<script", "src=", "@import", "url(", "<link", "NaN", "inf\"", "<i>"] {
        assert!(!page.contains(foreign), "{foreign}");
    }
    let mut open: Vec<&str> = Vec::new();
    for tag in page.split('<').skip(2).map(|text| text.split_once('>').unwrap().0) {
        let name = tag.split([' ', '\n']).next().unwrap();
        if let Some(name) = name.strip_prefix('/') {
            assert_eq!(open.pop(), Some(name), "</{name}>");
        } else if !tag.ends_with('/') && !["meta", "br"].contains(&name) {
            open.push(name);
        }
    }
    assert_eq!(open, Vec::<&str>::new());
}

#[track_caller]
fn close(cell: &str, value: &Value) {
    let (shown, value) = (cell.parse::<f64>().unwrap(), value.as_f64().unwrap());
    assert!((shown - value).abs() <= 1e-3 * value.abs(), "{cell} for {value}");
}

#[test]
fn every_section_is_there_from_the_first_day() {
    let asked = Rig::pooled();
    asked.infuse(&["ask"]).ok();
    let first_result = Rig::pooled();
    first_result.infuse(&["ask"]).ok();
    first_result.infuse(&["tell", "--id", "3", "--value", "8.6"]).ok();
    for rig in [Rig::pooled(), asked, first_result, eventful()] {
        check(&page(&rig));
    }
}

#[test]
fn the_first_screen_says_what_was_found() {
    let rig = eventful();
    let (page, status) = (page(&rig), rig.status());
    let begin = page.split_once(">History</h2>").unwrap().0;
    let findings = status["findings"].as_array().unwrap();
    let sentences: Vec<&str> = findings.iter().map(|finding| finding["sentence"].as_str().unwrap()).collect();
    for begins in
        ["Recommended: ", "With 90 % probability", "By the surface alone", "The simulation", "Noise of one run"]
    {
        assert!(sentences.iter().any(|sentence| sentence.starts_with(begins)), "{begins}");
    }
    for sentence in sentences {
        let mut words = sentence.split('`').next().unwrap().replace(" %", "\u{a0}%");
        for (plain, escaped) in [("&", "&amp;"), ("<", "&lt;"), (">", "&gt;"), ("\"", "&quot;"), ("'", "&#39;")] {
            words = words.replace(plain, escaped);
        }
        assert!(begin.contains(&words), "{words}");
    }
    assert!(begin.contains("Next: run what is left in sheet-3.csv"), "what to do next");
}

#[test]
fn the_history_agrees_with_the_status() {
    let rig = eventful();
    let (page, status) = (page(&rig), rig.status());
    let rows = table(&page, "What was known after each batch");
    let batches = status["batches"].as_array().unwrap();
    assert_eq!((rows.len(), batches.len()), (2, 2));
    for (row, batch) in rows.iter().zip(batches) {
        assert_eq!(row[0], batch["batch"].to_string());
        close(&row[2], &batch["expected"]);
        close(&row[4], &batch["bound"]);
        close(&row[5], &batch["bound_by_the_surface_alone"]);
        close(&row[7], &batch["noise"]);
        let half = 1.645 * batch["deviation"].as_f64().unwrap();
        close(&row[3], &half.into());
    }
    let values = told(&rig.journal());
    let batch_of = |id: u64| if id <= 10 { 1 } else { 2 };
    for (batch, row) in [1, 2].into_iter().zip(&rows) {
        let of_batch = values.iter().filter(|(id, _)| batch_of(**id) == batch).map(|(_, value)| *value);
        let least = of_batch.fold(f64::INFINITY, f64::min);
        assert!((row[8].parse::<f64>().unwrap() - least).abs() <= 1e-3 * least, "{row:?}");
    }
}

#[test]
fn the_same_folder_gives_the_same_bytes() {
    assert_gives_the_same_bytes(&eventful());
}

#[test]
fn a_map_shows_what_is_expected_and_a_failed_run_is_a_cross() {
    let rig = eventful();
    let page = page(&rig);
    let mut all = cells(&page, "expected");
    all.extend(cells(&page, "unlikely"));
    assert_eq!(all.len(), 169);
    for setting in ["spring 22 N/mm, damper gain 1.9 N s/mm", "spring 10 N/mm, damper gain 2.9 N s/mm"] {
        let title = &all.iter().find(|(_, title)| title.starts_with(setting)).unwrap().1;
        let asked = setting.replace(" N/mm", "").replace(" N s/mm", "").replace("spring ", "spring=");
        let asked = asked.replace("damper gain ", "damper gain=");
        let said: Value = serde_json::from_str(&rig.infuse(&["what-if", &asked, "--json"]).ok()).unwrap();
        close(&shown(title).to_string(), &said["expected"]);
    }
    let failed = table(&page, "<h3>Batch 2</h3>").into_iter().find(|row| row[1] == "12").unwrap();
    let settings: Vec<&String> = failed.iter().filter(|cell| cell.parse::<f64>().is_ok()).collect();
    let (spring, damper) = (settings[settings.len() - 3], settings[settings.len() - 2]);
    let here = format!("spring {spring} N/mm, damper gain {damper} N s/mm:");
    let ((x, y), title) = all.iter().find(|(_, title)| title.starts_with(&here)).expect(&here);
    assert!(title.contains("a run gives a value with"), "no run is recommended there: {title}");
    let map = page.split_once("Over pairs of parameters").unwrap().1.split_once("</svg>").unwrap().0;
    let strokes = map.split("<polyline points=\"").skip(1).filter(|line| line.contains("stroke-width=\"2\""));
    let middles: Vec<(f64, f64)> = strokes
        .map(|line| {
            let ends: Vec<f64> =
                line.split_once('"').unwrap().0.split([' ', ',']).map(|end| end.parse().unwrap()).collect();
            (0.5 * (ends[0] + ends[2]), 0.5 * (ends[1] + ends[3]))
        })
        .collect();
    assert_eq!(middles.len(), 2, "one cross of two strokes");
    assert!(middles.iter().all(|at| (at.0 - x).abs() < 1.5 && (at.1 - y).abs() < 1.5), "{middles:?} for {x}, {y}");
    assert!(page.contains("experiment without a result"), "the legend names it");
}

#[test]
fn sheets_show_every_experiment_with_what_is_expected() {
    let rig = eventful();
    let page = page(&rig);
    let values = told(&rig.journal());
    let mut by_id: BTreeMap<u64, Vec<String>> = BTreeMap::new();
    for batch in 1..=3 {
        by_id.extend(table(&page, &format!("<h3>Batch {batch}</h3>")).into_iter().map(|row| {
            let id = row[1].parse().unwrap();
            (id, row)
        }));
    }
    assert_eq!(by_id.keys().copied().collect::<Vec<_>>(), (1..=30).collect::<Vec<_>>());
    for (id, row) in by_id {
        match id {
            12 => assert!(row.iter().any(|cell| cell.starts_with("failed: belt &lt;i&gt;")), "{row:?}"),
            21.. => assert!(row.contains(&"no result yet".to_owned()), "{row:?}"),
            _ => assert!(row.contains(&values[&id].to_string()), "{row:?}"),
        }
        assert_eq!(row.iter().any(|cell| cell.starts_with("21.37 (asked: ")), id == 11, "{row:?}");
    }
    let imported = table(&page, "<h3>Imported</h3>");
    assert_eq!(imported[0][..3], ["21.3", "1.85", "7.1"]);
    assert!(imported[0][4].starts_with("notebook: p. &lt;i&gt;"), "{imported:?}");
}

#[test]
fn the_most_telling_experiment_comes_first_with_its_note() {
    let rig = eventful();
    let page = page(&rig);
    let telling = table(&page, "The experiments that taught most");
    assert_eq!(telling.len(), 5);
    let first = &telling[0];
    assert_eq!((first[0].as_str(), first[1].as_str(), first[3].as_str()), ("11", "21.37", "17.77"));
    assert!(first[5].ends_with(" above") && first[6] == "&lt;i&gt;&amp;&quot;&#39;", "{first:?}");
    let best = table(&page, "The designs that measured best");
    assert_eq!(best.len(), 10);
    let measured: Vec<f64> = best.iter().map(|row| row[2].parse().unwrap()).collect();
    assert!(measured.is_sorted(), "{measured:?}");
}

#[test]
fn what_is_maximized_is_shown_as_it_is_measured() {
    let rig = Rig::pooled();
    rig.edit("goal = \"minimize\"", "goal = \"maximize\"");
    rig.edit("unit = \"mm/s\"", "unit = \"\"");
    rig.write("simulation.csv", &rig.read("simulation.csv").replace("vibration [mm/s]", "vibration"));
    rig.infuse(&["ask"]).ok();
    for id in 1..=10 {
        rig.infuse(&["tell", "--id", &id.to_string(), "--value", &format!("{}", 20 + id)]).ok();
    }
    let (page, status) = (page(&rig), rig.status());
    check(&page);
    let largest = cells(&page, "expected").iter().map(|(_, title)| shown(title)).fold(f64::NEG_INFINITY, f64::max);
    let predicted = status["predicted"].as_f64().unwrap();
    assert!(predicted > 0.0 && (largest - predicted).abs() <= 1e-3 * predicted, "{largest} and {predicted}");
    assert!(page.contains("vibration below the highest, "), "the bar of colors says so, without a unit");
    let best = table(&page, "The designs that measured best");
    assert_eq!(best[0][2], "30", "{best:?}");
    let history = table(&page, "What was known after each batch");
    close(&history[0][2], &status["predicted"]);
    assert_eq!(history[0][8], "30");
}

#[test]
fn nothing_but_failures_has_a_page() {
    let rig = Rig::pooled();
    rig.infuse(&["ask"]).ok();
    for id in 1..=10 {
        rig.infuse(&["tell", "--id", &id.to_string(), "--failed", "no oil"]).ok();
    }
    let page = page(&rig);
    check(&page);
    assert_eq!(page.matches("failed: no oil").count(), 10);
    assert!(page.contains("10 of them without a result"), "the first screen says so");
}

/// One parameter that can be set to anything, simulated by a command that is asked at few settings.
#[test]
fn a_continuous_parameter_has_a_curve_and_no_map() {
    let rig = Rig::empty();
    rig.write(
        "campaign.toml",
        "title = \"Gap\"\n[[parameter]]\nname = \"gap\"\nunit = \"mm\"\nlower = 0\nupper = 20\nrole = \"plant\"\n\
         [response]\nname = \"force\"\nunit = \"N\"\ngoal = \"minimize\"\n\
         [simulator]\ncommand = [\"awk\", \"BEGIN { print 3 + 0.2 * ({gap} - 4) ^ 2 }\"]\n[loop]\nsimulations = 8\n",
    );
    let asked: Value = serde_json::from_str(&rig.infuse(&["ask", "--json"]).ok()).unwrap();
    for experiment in asked["experiments"].as_array().unwrap() {
        let (id, gap) = (experiment["id"].as_u64().unwrap(), experiment["settings"]["gap"].as_f64().unwrap());
        let value = 3.0 + 0.2 * (gap - 6.0) * (gap - 6.0) + 0.1 * (id as f64).sin();
        rig.infuse(&["tell", "--id", &id.to_string(), "--value", &format!("{value:.3}")]).ok();
    }
    let page = page(&rig);
    check(&page);
    assert!(!page.contains("Over pairs of parameters"), "there is no pair");
    let chart = page.split_once(">Surfaces</h2>").unwrap().1.split_once("</svg>").unwrap().0;
    let curve = chart.split("<polyline points=\"").map(|line| line.split_once('"').unwrap().0.matches(' ').count());
    let n_points = curve.max().unwrap() + 1;
    assert!((100..=130).contains(&n_points), "{n_points} of 1001 settings");
    let n_told = told(&rig.journal()).len();
    let dots = chart.matches("r=\"4\" fill=\"#222222\"").count();
    assert_eq!(dots, n_told, "each where it was measured");
}

#[test]
fn provenance_names_the_settings_as_the_file_does() {
    let rig = Rig::pooled();
    assert!(rig.batch());
    let rows = table(&page(&rig), "The rest of");
    let value = |key: &str| {
        let key = format!("<code>{key}</code>");
        rows.iter().find(|row| row[0] == key).map(|row| row[1].clone()).expect(&key)
    };
    assert_eq!(value("experiments"), "10 per batch");
    assert_eq!(value("batches"), "6 at most");
    assert_eq!((value("confidence"), value("noise"), value("seed")), ("0.9".into(), "learnt".into(), "1".into()));
}

/// Of the template's truth, 7 + 4 a² + 5 b² + 1.5 a b over its 13 by 13 designs, each parameter alone explains what the mean over
/// the other leaves.
#[test]
fn what_each_parameter_explains_alone_is_that_of_the_truth() {
    let rig = Rig::pooled();
    rig.edit("worth = 0.2", "worth = 0.000001");
    for _ in 0..3 {
        rig.batch();
    }
    let table = table(&page(&rig), "What is expected where one parameter is moved");
    let (mut sums, mut total) = ([[0.0; 13]; 2], 0.0);
    let at = |i: usize, j: usize| crate::rig::truth(10.0 + 2.0 * i as f64, 0.5 + 0.2 * j as f64);
    let mean = (0..169).map(|k| at(k / 13, k % 13)).sum::<f64>() / 169.0;
    for k in 0..169 {
        let off = at(k / 13, k % 13) - mean;
        total += off * off;
        sums[0][k / 13] += off;
        sums[1][k % 13] += off;
    }
    for (row, sums) in table.iter().zip(&sums) {
        let between: f64 = sums.iter().map(|sum| sum * sum / 13.0).sum();
        let share: f64 = row[5].trim_end_matches('%').trim().trim_end_matches('\u{a0}').parse().unwrap();
        // Settings are taken together two by two, and the surface is not the truth.
        assert!((share - 100.0 * between / total).abs() < 6.0, "{row:?} for {}", between / total);
    }
    let best: Vec<f64> = [0, 1].map(|at| table[at][2].parse().unwrap()).to_vec();
    assert!(best.iter().all(|lowest| (lowest - 7.0).abs() < 0.3), "{best:?}");
}

#[test]
fn the_page_says_what_to_do_next_and_what_the_simulation_misses() {
    let rig = eventful();
    let text = page(&rig);
    for words in [
        ">What to do next</h3>",
        ">How much each parameter matters</h3>",
        ">What the simulation misses</h3>",
        "best so far",
        "measured less simulated",
        "with the line on which both are equal",
    ] {
        assert!(text.contains(words), "{words}");
    }
    // Once it has ended, what is next is to measure what was gained.
    let ended = Rig::pooled();
    ended.edit("batches = 6", "batches = 1");
    ended.batch();
    assert!(page(&ended).contains("infuse confirm, a few runs that measure what was gained"));
}
