//! The page that `infuse report` makes.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::Value;

use crate::report_page::{EVIL, assert_gives_the_same_bytes, page, table};
use crate::rig::{Rig, told};

const SECTIONS: [&str; 7] =
    ["Where the campaign stands", "History", "Surfaces", "What is left", "Bounds", "Sheets", "Provenance"];

/// Two batches, the second with failures, other settings and notes; and one that is waited for.
fn eventful() -> Rig {
    let rig = Rig::new();
    rig.edit("Spring and damper of a seat", "Seat <i>&\\\"'");
    rig.edit("worth = 0.2", "worth = 0.000001");
    rig.write("old.csv", "spring [N/mm],damper gain [N s/mm],vibration [mm/s],source\n21.3,1.85,7.1,p. <i>&\"'\n");
    rig.infuse(&["import", "old.csv", "--source", "notebook"]).ok();
    assert!(rig.batch());
    rig.infuse(&["ask"]).ok();
    let ids: Vec<u64> = (11..=20).collect();
    rig.fill("sheet-2.csv", |id| id != ids[0] && id != ids[1]);
    rig.infuse(&["tell", "sheet-2.csv"]).ok();
    rig.infuse(&["tell", "--id", "11", "--failed", &format!("belt {EVIL} slipped")]).ok();
    let actual = ["tell", "--id", "12", "--value", "7.77", "--actual", "spring=21.37", "--note", EVIL];
    rig.infuse(&actual).ok();
    rig.infuse(&["ask", "--anyway"]).ok();
    rig
}

fn maximized() -> Rig {
    let rig = Rig::new();
    rig.edit("goal = \"minimize\"", "goal = \"maximize\"");
    rig.edit("[loop]", "[loop]\ndrop_from = 1");
    assert!(rig.batch());
    rig
}

/// Rectangles of this class: corner in pixels, and what a pointer is shown.
fn cells(page: &str, class: &str) -> Vec<((f64, f64), String)> {
    let number = |text: &str, name: &str| {
        let from = text.split_once(&format!(" {name}=\"")).unwrap().1;
        from.split_once('"').unwrap().0.parse::<f64>().unwrap()
    };
    let cell = |text: &str| {
        let (head, title) = text.split_once("<title>").unwrap();
        ((number(head, "x"), number(head, "y")), title.split_once("</title>").unwrap().0.to_owned())
    };
    page.split(&format!("<rect class=\"{class}\"")).skip(1).map(cell).collect()
}

#[test]
fn the_page_stands_alone() {
    let page = page(&eventful());
    for foreign in ["http:", "https:", "<script", "src=", "@import", "url(", "<link", "<iframe", "<object", "file:"] {
        assert!(!page.contains(foreign), "{foreign}");
    }
    assert!(page.starts_with("<!DOCTYPE html>") && page.contains("<meta charset=\"utf-8\">"));
}

#[test]
fn tags_are_closed_in_the_order_in_which_they_were_opened() {
    for rig in [eventful(), Rig::new(), maximized()] {
        let page = page(&rig);
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
        let anchors: Vec<&str> = page.split("href=\"#").skip(1).map(|text| text.split_once('"').unwrap().0).collect();
        assert_eq!(anchors.len(), SECTIONS.len());
        assert!(anchors.iter().all(|anchor| page.contains(&format!("id=\"{anchor}\""))), "{anchors:?}");
    }
}

#[test]
fn every_section_is_there_from_the_first_day() {
    let asked = Rig::new();
    asked.infuse(&["ask"]).ok();
    for rig in [Rig::new(), asked, eventful()] {
        let page = page(&rig);
        let mut rest = &page[..];
        for section in SECTIONS {
            rest = rest.split_once(&format!(">{section}</h2>")).expect(section).1;
        }
    }
}

#[test]
fn what_people_wrote_is_shown_and_never_obeyed() {
    let page = page(&eventful());
    assert!(!page.contains("<i>"), "obeyed");
    // Title twice, reason, note, source; with what stands around each.
    let shown = "&lt;i&gt;&amp;&quot;&#39;";
    for text in [
        format!("<h1>Seat {shown}</h1>"),
        format!("<title>Seat {shown}</title>"),
        format!("failed: belt {shown} slipped"),
        format!("<td class=\"words\">{shown}</td>"),
        format!("notebook: p. {shown}"),
    ] {
        assert!(page.contains(&text), "{text}");
    }
}

#[test]
fn the_same_folder_gives_the_same_bytes() {
    assert_gives_the_same_bytes(&eventful());
}

#[test]
fn sheets_show_every_experiment_as_it_was_made() {
    let rig = eventful();
    let page = page(&rig);
    let values = told(&rig.journal());
    // run, id, repeats, spring, damper gain, vibration, predicted, use
    let rows: Vec<Vec<String>> =
        [1, 2, 3].iter().flat_map(|batch| table(&page, &format!("<h3>Batch {batch}</h3>"))).collect();
    let by_id: BTreeMap<u64, &Vec<String>> = rows.iter().map(|row| (row[1].parse().unwrap(), row)).collect();
    assert_eq!(by_id.keys().copied().collect::<Vec<_>>(), (1..=30).collect::<Vec<_>>());
    for (id, row) in by_id {
        match id {
            11 => assert!(row[5].starts_with("failed: belt"), "{row:?}"),
            21.. => assert_eq!(row[5], "no result yet"),
            _ => assert_eq!(row[5].parse::<f64>().ok(), values.get(&id).copied(), "{row:?}"),
        }
        assert_eq!(row[3].starts_with("21.37 (asked: "), id == 12, "{row:?}");
        assert!(row[6].parse::<f64>().is_ok() && ["training", "validation"].contains(&&*row[7]), "{row:?}");
    }
    let imported = table(&page, "<h3>Imported</h3>");
    assert_eq!(imported[0][..4], ["21.3", "1.85", "7.1", "1"]);
}

#[test]
fn a_map_grays_exactly_the_cells_that_were_dropped() {
    let rig = eventful();
    let (page, status) = (page(&rig), rig.status());
    let mut places = BTreeSet::new();
    let mut corners: Vec<((f64, f64), (f64, f64))> = Vec::new();
    let batches = status["batches"].as_array().unwrap();
    let mut classes: Vec<(String, u64)> = batches
        .iter()
        .map(|batch| {
            let n = batch["left_before"].as_u64().unwrap() - batch["left"].as_u64().unwrap();
            (format!("dropped by-{}", batch["batch"]), n)
        })
        .collect();
    classes.push(("left".to_owned(), status["left"].as_u64().unwrap()));
    for (class, n) in classes {
        let found = cells(&page, &class);
        assert_eq!(found.len() as u64, n, "{class}");
        for (corner, title) in found {
            let place = title.split_once(':').unwrap().0;
            assert!(places.insert(place.to_owned()), "{place} twice");
            let words: Vec<&str> = place.split([' ', ',']).collect();
            let (spring, damper) = (words[1], words[6]);
            corners.push((corner, (spring.parse().unwrap(), damper.parse().unwrap())));
            let why = rig.infuse(&["status", "--why", &format!("spring={spring},damper gain={damper}"), "--json"]).ok();
            let why = serde_json::from_str::<Value>(&why).unwrap()["why"].clone();
            match class.strip_prefix("dropped by-") {
                Some(batch) => assert_eq!(why["numbers"][0]["value"].as_f64(), batch.parse().ok(), "{why}"),
                None => assert!(why["sentence"].as_str().unwrap().contains("still among the designs left"), "{why}"),
            }
        }
    }
    assert_eq!(places.len(), 169);
    // Springs to the right, damper gains up; steps of 2 and 0.2 are all of one size, to the pixel.
    let at = |spring: f64, damper: f64| {
        let is_here = |(_, place): &&((f64, f64), (f64, f64))| (place.0 - spring).hypot(place.1 - damper) < 1e-9;
        corners.iter().find(is_here).unwrap().0
    };
    let (first, last) = (at(10.0, 0.5), at(34.0, 2.9));
    for &((x, y), (spring, damper)) in &corners {
        let (right, up) = ((spring - 10.0) / 24.0, (damper - 0.5) / 2.4);
        assert!((x - first.0 - right * (last.0 - first.0)).abs() <= 1.0, "{spring}");
        assert!((y - first.1 - up * (last.1 - first.1)).abs() <= 1.0, "{damper}");
    }
    assert!(last.0 > first.0 && last.1 < first.1, "right and up");
}

#[test]
fn what_is_maximized_is_shown_as_it_is_measured() {
    let rig = maximized();
    let (page, status) = (page(&rig), rig.status());
    let left = cells(&page, "left");
    let values: Vec<f64> = left
        .iter()
        .map(|(_, title)| title.split(": ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap())
        .collect();
    let largest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let predicted = status["predicted"].as_f64().unwrap();
    assert!(predicted > 0.0 && (largest - predicted).abs() <= 1e-3 * predicted, "{largest} and {predicted}");
    let best = &table(&page, "Best design after each batch")[0];
    assert!((best[2].parse::<f64>().unwrap() - predicted).abs() <= 1e-3 * predicted, "{best:?}");
    let measured: f64 = best[4].parse().unwrap();
    let most = told(&rig.journal()).into_values().fold(0.0, f64::max);
    assert!((measured - most).abs() <= 1e-3 * most, "{best:?}");
    assert!(table(&page, "What each batch dropped")[0][2].starts_with("predicted below"));
}

#[test]
fn the_history_agrees_with_the_status() {
    let rig = eventful();
    let (page, status) = (page(&rig), rig.status());
    let close = |cell: &str, value: &Value| {
        let (shown, value) = (cell.parse::<f64>().unwrap(), value.as_f64().unwrap());
        assert!((shown - value).abs() <= 1e-3 * value.abs(), "{cell} for {value}");
    };
    let batches = status["batches"].as_array().unwrap();
    let (best, dropped, learned) = (
        table(&page, "Best design after each batch"),
        table(&page, "What each batch dropped"),
        table(&page, "What each batch taught"),
    );
    assert_eq!([best.len(), dropped.len(), learned.len()], [2; 3]);
    for (index, batch) in batches.iter().enumerate() {
        close(&best[index][2], &batch["predicted"]);
        close(&best[index][3], &batch["spread"]);
        close(&dropped[index][3], &batch["left"]);
        close(&learned[index][1], &batch["off_by_up_to"]);
        assert!(learned[index][4].starts_with(&format!("{} of ", batch["failed_experiments"])));
    }
    close(&learned[1][6], &status["noise"]["standard_deviation"]);
    close(&learned[1][3], &status["guarantee"]["eps"]);
}

#[test]
fn bounds_of_earlier_batches_are_those_that_were_given_then() {
    let rig = Rig::new();
    rig.edit("worth = 0.2", "worth = 0.000001");
    let mut given = Vec::new();
    while given.len() < 3 && rig.batch() {
        given.push(rig.status()["guarantee"]["eps"].as_f64().unwrap());
    }
    let shown: Vec<f64> =
        table(&page(&rig), "What each batch taught").iter().map(|row| row[3].parse().unwrap()).collect();
    assert_eq!(shown.len(), given.len());
    for (shown, given) in shown.iter().zip(&given) {
        assert!((shown - given).abs() <= 1e-3 * given, "{shown} for {given}");
    }
}

/// One parameter, so experiments lie where they were measured.
#[test]
fn experiments_are_drawn_to_scale() {
    let rig = Rig::empty();
    let simulated = |x: f64| 3.0 + 0.2 * (x - 4.0) * (x - 4.0);
    let rows: String = (0..=20).map(|x| format!("{x},{}\n", simulated(f64::from(x)))).collect();
    rig.write("simulation.csv", &format!("gap [mm],force [N]\n{rows}"));
    rig.write(
        "campaign.toml",
        "title = \"Gap\"\n[[parameter]]\nname = \"gap\"\nunit = \"mm\"\nlower = 0\nupper = 20\nstep = 1\nrole = \"plant\"\n\
         [response]\nname = \"force\"\nunit = \"N\"\ngoal = \"minimize\"\n[simulator]\ntable = \"simulation.csv\"\n[loop]\nmethod = \"dissertation\"\n",
    );
    let asked: Value = serde_json::from_str(&rig.infuse(&["ask", "--json"]).ok()).unwrap();
    for experiment in asked["experiments"].as_array().unwrap() {
        let (id, gap) = (experiment["id"].as_u64().unwrap(), experiment["settings"]["gap"].as_f64().unwrap());
        let value = simulated(gap) + 0.7 * gap + 0.1 * (id as f64).sin();
        rig.infuse(&["tell", "--id", &id.to_string(), "--value", &format!("{value:.3}")]).ok();
    }
    let page = page(&rig);
    let chart = page.split_once(">Surfaces</h2>").unwrap().1.split_once("</svg>").unwrap().0;
    let attribute = |text: &str, name: &str| {
        text.split_once(&format!("{name}=\"")).unwrap().1.split_once('"').unwrap().0.parse::<f64>().unwrap()
    };
    let drawn: Vec<(f64, f64)> =
        chart.split("<circle").skip(1).map(|circle| (attribute(circle, "cx"), attribute(circle, "cy"))).collect();
    let values = told(&rig.journal());
    assert_eq!(drawn.len(), values.len());
    // In the order of the ids. Pixels follow from values by one scale.
    let values: Vec<f64> = values.into_values().collect();
    let (low, high) = ((0..values.len()).min_by(|&a, &b| values[a].total_cmp(&values[b])).unwrap(), {
        (0..values.len()).max_by(|&a, &b| values[a].total_cmp(&values[b])).unwrap()
    });
    let scale = (drawn[high].1 - drawn[low].1) / (values[high] - values[low]);
    assert!(scale < -1.0, "up, by some pixels per newton: {scale}");
    for (value, (_, y)) in values.iter().zip(&drawn) {
        let expected = drawn[low].1 + scale * (value - values[low]);
        assert!((y - expected).abs() < 0.2, "{value}: {y} for {expected}");
    }
}

#[test]
fn nothing_but_a_page_is_overwritten() {
    let rig = Rig::new();
    assert!(rig.batch());
    let journal = rig.read("journal.jsonl");
    for path in ["journal.jsonl", "campaign.toml", "sheet-1.csv", "report"] {
        let error = rig.infuse(&["report", "--output", path]).error();
        assert!(error.contains(path) && error.contains(".html"), "{error}");
    }
    assert_eq!(journal, rig.read("journal.jsonl"));
    let error = rig.infuse(&["report", "--output", "no/such/folder.html"]).error();
    assert!(error.contains("no/such/folder.html"), "{error}");
}

#[test]
fn machines_are_told_where_the_page_is() {
    let rig = Rig::new();
    assert!(rig.batch());
    let said: Value = serde_json::from_str(&rig.infuse(&["report", "--json"]).ok()).unwrap();
    assert_eq!((said["report"].as_str(), said["batches"].as_u64()), (Some("report.html"), Some(1)));
    assert_eq!(said["bytes"].as_u64(), Some(rig.read("report.html").len() as u64));
    assert!(said["notices"].as_array().unwrap().is_empty());
}
