//! Campaigns from the first sheet to the last.

use serde_json::{Value, json};

use crate::rig::{Rig, measured, told, truth};

#[test]
fn the_template_finds_the_optimum_of_the_rig_and_not_that_of_its_simulation() {
    let rig = Rig::new();
    let mut n_batches = 0;
    while rig.batch() {
        n_batches += 1;
    }
    assert!((2..=6).contains(&n_batches), "{n_batches}");
    let status = rig.status();
    let best = |name: &str| status["best"][name].as_f64().unwrap();
    assert!(truth(best("spring"), best("damper gain")) < 7.2, "{status}");
    assert_eq!(status["batches"][0]["simulation_alone"]["spring"], json!(18.0));
    assert!(truth(18.0, 1.3) > 8.0, "what the simulation alone would have cost");
    assert!(status["left"].as_u64() < Some(40), "{status}");
    // Uniform noise of at most 0.2, as a sine of a number: its standard deviation is 0.2/√2.
    let noise = status["noise"]["standard_deviation"].as_f64().unwrap();
    assert!((0.02..0.4).contains(&noise), "{noise}");
    let text = rig.infuse(&["status"]).ok();
    for words in [
        "Best design: spring",
        "Batch",
        "lack of fit",
        "Left:",
        "dropped",
        "Guarantee",
        "Ended: another batch may gain",
    ] {
        assert!(text.contains(words), "{words} is not in {text}");
    }
    assert!(rig.infuse(&["ask"]).ok().contains("To go on all the same: infuse ask --anyway"));
    assert!(rig.infuse(&["ask", "--anyway"]).ok().contains(&format!("Batch {}: 10 experiments", n_batches + 1)));
}

#[test]
fn asking_again_gives_the_same_experiments_and_leaves_the_sheet_alone() {
    let rig = Rig::new();
    let ask = || -> Value { serde_json::from_str(&rig.infuse(&["ask", "--json"]).ok()).unwrap() };
    let first = ask();
    assert_eq!((&first["sheet_is_new"], &first["simulations_made"]), (&json!(true), &json!(20)));
    rig.fill("sheet-1.csv", |id| id == 4);
    let filled = rig.read("sheet-1.csv");
    let again = ask();
    assert_eq!(again["experiments"], first["experiments"]);
    assert_eq!((&again["sheet_is_new"], &again["simulations_made"]), (&json!(false), &json!(0)));
    assert_eq!(rig.read("sheet-1.csv"), filled, "a person is filling it in");
    rig.infuse(&["tell", "sheet-1.csv"]).ok();
    assert_eq!(rig.infuse(&["ask"]).ok().matches("Results so far: 1; 9 to go.").count(), 1);
}

#[test]
fn the_same_folder_gives_the_same_answer_with_any_number_of_jobs_and_in_any_order() {
    let status = |jobs: usize, one_by_one: bool| {
        let rig = Rig::new();
        rig.edit(
            "table = \"simulation.csv\"",
            &format!("command = [\"sh\", \"-c\", \"{SHELL_SIMULATION}\"]\njobs = {jobs}"),
        );
        rig.infuse(&["ask"]).ok();
        rig.fill("sheet-1.csv", |_| true);
        if one_by_one {
            let sheet = rig.read("sheet-1.csv");
            let (headings, rows) = sheet.split_once('\n').unwrap();
            for row in rows.lines().rev() {
                rig.write("row.csv", &format!("{headings}\n{row}\n"));
                rig.infuse(&["tell", "row.csv"]).ok();
            }
        } else {
            rig.infuse(&["tell", "sheet-1.csv"]).ok();
        }
        rig.infuse(&["ask"]).ok();
        (rig.status(), rig.read("sheet-2.csv"))
    };
    let one = status(1, false);
    assert_eq!(one, status(4, true));
}

/// The simulation of the template, in a shell.
pub(crate) const SHELL_SIMULATION: &str = "awk 'BEGIN { a = ({spring} - 18) / 12; b = ({damper gain} - 1.3) / 1.2; \
     print 8 + 5 * a * a + 4 * b * b + 2 * a * b }'";

#[test]
fn failures_actual_settings_repeats_and_remarks_come_back_with_the_sheet() {
    let rig = Rig::new();
    rig.infuse(&["ask"]).ok();
    rig.fill("sheet-1.csv", |id| id != 3 && id != 5);
    let sheet = rig.read("sheet-1.csv");
    let rows: Vec<String> = sheet
        .lines()
        .map(|row| {
            let mut cells: Vec<String> = row.split(',').map(str::to_owned).collect();
            match cells[1].as_str() {
                "3" => cells[6] = "lamp broke".to_owned(),
                "5" => {
                    let spring: f64 = cells[3].parse().unwrap();
                    cells[5] = measured(5, spring + 0.5, cells[4].parse().unwrap());
                    (cells[7], cells[9]) = ((spring + 0.5).to_string(), "washer missing".to_owned());
                }
                _ => {}
            }
            cells.join(",")
        })
        .collect();
    // One more run of experiment 1, in a row of its own.
    rig.write("sheet-1.csv", &format!("{}\n,,1,,,21.5,,,,\n", rows.join("\n")));
    let text = rig.infuse(&["tell", "sheet-1.csv"]).ok();
    assert!(
        text.contains("Taken: 11 results, 1 of them without a value.") && text.contains("1 experiment gave no result"),
        "{text}"
    );
    let journal = rig.journal();
    let line = |id: u64| journal.iter().find(|line| line["event"] == "told" && line["id"] == id).unwrap();
    assert_eq!(line(3)["failed"], "lamp broke");
    assert_eq!(line(5)["note"], "washer missing");
    assert!(line(5)["actual"]["spring"].is_number());
    assert_eq!(journal.iter().filter(|line| line["repeat"] == 1).count(), 1);
    // Three runs at the settings of experiment 1 and its planned repeat, two at those of another.
    let noise = rig.status()["noise"]["degrees_of_freedom"].clone();
    assert!(noise == 3 || noise == 2, "{noise}: the repeat of a failed or moved run is none");
    let again = rig.infuse(&["tell", "sheet-1.csv"]).ok();
    assert!(again.contains("Taken: 0 results, 11 known before."), "{again}");
}

#[test]
fn earlier_experiments_are_imported_with_where_they_come_from() {
    let rig = Rig::new();
    rig.write("old.csv", "damper gain [N s/mm];spring [N/mm];vibration [mm/s];source\n1.9;22;7.1;run A\n1.3;18;8.4;\n");
    let text = rig.infuse(&["import", "old.csv", "--source", "notebook 3"]).ok();
    assert!(text.contains("Imported: 2 experiments. From batch 1 on"), "{text}");
    let sources: Vec<Value> = rig.journal().iter().filter_map(|line| line.get("source").cloned()).collect();
    assert_eq!(sources, ["notebook 3: run A", "notebook 3"]);
    let error = rig.infuse(&["import", "old.csv", "--source", "notebook 3"]).error();
    assert!(error.contains("is in the journal already"), "{error}");
    rig.batch();
    assert_eq!(rig.status()["imported"], 2);
}

/// `--source` is for what no column says; beside one it is a name for the whole table.
#[test]
fn a_column_says_where_each_earlier_experiment_comes_from() {
    let rig = Rig::pooled();
    let heading = "damper gain [N s/mm],spring [N/mm],vibration [mm/s]";
    let import = ["import", "old.csv"];
    rig.write("old.csv", &format!("{heading}\n1.9,22,7.1\n"));
    let error = rig.infuse(&import).error();
    assert!(error.contains("old.csv: there is no column `source`, and --source is missing"), "{error}");
    rig.write("old.csv", &format!("{heading},source\n1.9,22,7.1,run A\n1.3,18,8.4, \n"));
    let error = rig.infuse(&import).error();
    assert!(
        error.contains("row 3, column `source`: is empty, expected where this experiment comes from; or --source"),
        "{error}"
    );
    rig.write("old.csv", &format!("{heading},source\n1.9,22,7.1,run A\n1.3,18,8.4,run B\n"));
    rig.infuse(&import).ok();
    let sources: Vec<Value> = rig.journal().iter().filter_map(|line| line.get("source").cloned()).collect();
    assert_eq!(sources, ["run A", "run B"]);
    assert!(rig.infuse(&["import", "--withdraw", "run B"]).ok().contains("Withdrawn: 1 experiment."));
    let error = Rig::pooled().infuse(&["import", rig.folder().to_str().unwrap()]).error();
    assert!(error.contains("is a folder: --source is missing"), "{error}");
}

/// A note of an older table is kept as that of a sheet is, and stands on the page beside what it was written for.
#[test]
fn a_note_comes_with_an_earlier_experiment() {
    let rig = Rig::pooled();
    let heading = "damper gain [N s/mm],spring [N/mm],vibration [mm/s]";
    let rows: String = (0..12)
        .map(|at| {
            let (spring, damper) = (10.0 + 8.0 * f64::from(at % 4), 0.5 + 1.2 * f64::from(at / 4));
            let (off, note) = if at == 5 { (25.0, "it sang") } else { (0.0, "") };
            format!("{damper},{spring},{:.3},{note}\n", truth(spring, damper) + off)
        })
        .collect();
    rig.write("old.csv", &format!("{heading},note\n{rows}"));
    rig.infuse(&["import", "old.csv", "--source", "notebook"]).ok();
    let notes: Vec<Value> = rig.journal().iter().filter_map(|line| line.get("note").cloned()).collect();
    assert_eq!(notes, ["it sang"], "where there is none, none is written");
    rig.infuse(&["report"]).ok();
    assert!(rig.read("report.html").contains("it sang"), "beside the experiment that taught most");
    rig.write("old.csv", &format!("{heading},remark\n1.9,22,7.1,it sang\n"));
    let error = rig.infuse(&["import", "old.csv", "--source", "another"]).error();
    assert!(error.contains("`remark` is not known, expected one of ") && error.contains("`note`"), "{error}");
}

#[test]
fn imports_are_withdrawn_by_their_source() {
    let rig = Rig::new();
    rig.write("old.csv", "damper gain [N s/mm],spring [N/mm],vibration [mm/s]\n1.9,22,71\n");
    rig.infuse(&["import", "old.csv", "--source", "slip"]).ok();
    let error = rig.infuse(&["import", "--withdraw", "slop"]).error();
    assert!(error.contains("nothing that is in use was imported from `slop`, expected one of `slip`"), "{error}");
    assert!(rig.infuse(&["import", "--withdraw", "slip"]).ok().contains("Withdrawn: 1 experiment."));
    let error = rig.infuse(&["import", "--withdraw", "slip"]).error();
    assert!(error.contains("expected a source of imported experiments, of which there are none"), "{error}");
    rig.batch();
    let reference = Rig::new();
    reference.batch();
    assert_eq!(rig.status()["predicted"], reference.status()["predicted"]);
    assert!(rig.infuse(&["import"]).error().contains("required"));
}

/// The same rows under another name may be other runs, so they are taken, and it is said how to be rid of them.
#[test]
fn rows_that_were_imported_from_elsewhere_are_said_to_count_twice() {
    let rig = Rig::new();
    let heading = "damper gain [N s/mm],spring [N/mm],vibration [mm/s]";
    rig.write("old.csv", &format!("{heading}\n1.9,22,71\n1.3,18,84\n"));
    let said = rig.infuse(&["import", "old.csv", "--source", "notebook 3"]).ok();
    assert!(!said.contains("settings and results of others"), "{said}");
    rig.write("more.csv", &format!("{heading},source\n1.9,22,71,p. 4\n1.9,22,70,p. 5\n1.3,22,84,p. 5\n"));
    let said = rig.infuse(&["import", "more.csv", "--source", "notebook 4"]).ok();
    assert!(said.contains("Imported: 3 experiments."), "{said}");
    let twice = "1 row from `notebook 4: p. 4` has settings and results of others from `notebook 3`, and counts as a run of its own.";
    assert!(said.contains(twice), "{said}");
    assert!(said.contains("infuse import --withdraw \"notebook 4: p. 4\""), "{said}");
    assert!(said.contains("infuse import --withdraw \"notebook 3\""), "either may be the copy: {said}");
    let log = rig.infuse(&["log"]).ok();
    assert!(log.contains("2 experiments from old.csv, as `notebook 3`."), "{log}");
    assert!(log.contains("3 experiments from more.csv, as `notebook 4: p. 4` and `notebook 4: p. 5`."), "{log}");
    assert!(rig.infuse(&["import", "--withdraw", "notebook 4: p. 4"]).ok().contains("Withdrawn: 1 experiment."));
    assert_eq!(rig.status()["imported"], 4);
}

/// A name with quotes is suggested as one word of a shell, which takes back just what has it; one row is "it".
#[test]
fn a_source_with_quotes_is_withdrawn_as_it_is_suggested() {
    let rig = Rig::pooled();
    let heading = "damper gain [N s/mm],spring [N/mm],vibration [mm/s]";
    let source = "Bob's \"new\" `rig` $HOME";
    rig.write("old.csv", &format!("{heading}\n1.9,44,71\n"));
    let said = rig.infuse(&["import", "old.csv", "--source", source]).ok();
    assert!(said.contains("Imported: 1 experiment. It counts as much as the experiments of the campaign."), "{said}");
    let suggested = r#"import --withdraw 'Bob'\''s "new" `rig` $HOME'"#;
    assert!(said.contains(&format!("`infuse {suggested}`")), "{said}");
    let program = rig.command(&[]).get_program().to_str().unwrap().to_owned();
    let mut shell = std::process::Command::new("sh");
    shell.arg("-c").arg(format!("'{program}' {suggested}")).current_dir(rig.folder());
    let output = shell.output().unwrap();
    assert!(String::from_utf8_lossy(&output.stdout).contains("Withdrawn: 1 experiment."), "{output:?}");
}

/// A row that was copied is more often a slip than a run that gave the same to the last digit.
#[test]
fn rows_of_one_source_that_say_the_same_are_said_to_be_alike() {
    let rig = Rig::pooled();
    let heading = "damper gain [N s/mm],spring [N/mm],vibration [mm/s]";
    rig.write("old.csv", &format!("{heading}\n1.9,22,71.25\n1.9,22,71.26\n1.3,18,84\n1.9,22,71.25\n"));
    let said = rig.infuse(&["import", "old.csv", "--source", "notebook"]).ok();
    let alike = "1 row has settings and result of another row from the same source, and counts as a run of its own.";
    assert!(said.contains(alike) && said.contains("`infuse import --withdraw \"notebook\"`"), "{said}");
    rig.write("more.csv", &format!("{heading}\n1.9,22,70\n1.9,22,71.2\n"));
    let said = rig.infuse(&["import", "more.csv", "--source", "diary"]).ok();
    assert!(!said.contains("of another row"), "runs of one design are not alike if they gave something else: {said}");
}

#[test]
fn a_sheet_of_headings_alone_is_refused() {
    let rig = Rig::pooled();
    rig.infuse(&["ask"]).ok();
    let sheet = rig.read("sheet-1.csv");
    rig.write("sheet-1.csv", sheet.lines().next().unwrap());
    let error = rig.infuse(&["tell", "sheet-1.csv"]).error();
    assert!(error.contains("sheet-1.csv: no rows under the headings, expected at least one experiment"), "{error}");
}

#[test]
fn further_runs_are_put_right_and_never_lost() {
    let rig = Rig::new();
    rig.infuse(&["ask"]).ok();
    let headings = "id,repeats,vibration [mm/s]";
    rig.write("a.csv", &format!("{headings}\n3,,9\n,3,99\n,3,9.2\n"));
    assert!(rig.infuse(&["tell", "a.csv"]).ok().contains("Taken: 3 results."));
    rig.write("a.csv", &format!("{headings}\n3,,9\n,3,9.9\n,3,9.2\n"));
    let error = rig.infuse(&["tell", "a.csv"]).error();
    assert!(error.contains("the result known before, 99 mm/s; to replace it") && error.contains("--again"), "{error}");
    assert!(rig.infuse(&["tell", "a.csv", "--correct"]).ok().contains("Taken: 1 result, 2 known before."));
    // (9 + 9.9 + 9.2)/3
    let mean = rig.status()["best_measured"]["value"].as_f64().unwrap();
    assert!((mean - 28.1 / 3.0).abs() < 1e-12, "{mean}");
    // An equal reading is a reading.
    for _ in 0..2 {
        assert!(rig.infuse(&["tell", "--id", "3", "--value", "9", "--again"]).ok().contains("Taken: 1 result."));
    }
    let mean = rig.status()["best_measured"]["value"].as_f64().unwrap();
    assert!((mean - 46.1 / 5.0).abs() < 1e-12, "{mean}");
    assert!(
        rig.infuse(&["tell", "--id", "3", "--value", "9", "--again", "--correct"])
            .error()
            .contains("expected one of them")
    );
    let text = rig.infuse(&["status"]).ok();
    assert!(text.contains("0 batches closed, 1 experiment made, 4 further runs of these; batch 1 waits for"), "{text}");
    let error = rig.infuse(&["tell", "--id", "4", "--value", "8", "--correct"]).error();
    assert!(
        error.contains("--correct: experiment 4 has no result yet, expected one that is to be replaced"),
        "{error}"
    );
    // Of several runs it has to be said which is put right.
    let error = rig.infuse(&["tell", "--id", "3", "--value", "8", "--correct"]).error();
    assert!(error.contains("had 5 runs: 9 mm/s; 9.9 mm/s; 9.2 mm/s; 9 mm/s; 9 mm/s; expected --run"), "{error}");
    let error = rig.infuse(&["tell", "--id", "3", "--value", "8", "--correct", "--run", "6"]).error();
    assert!(error.contains("--run is 6") && error.contains("expected at most 5"), "{error}");
    assert!(rig.infuse(&["tell", "--id", "3", "--value", "8", "--run", "2"]).error().contains("--correct beside it"));
    for (run, value, sum) in [("2", "10", 46.2), ("1", "8", 45.2), ("5", "7", 43.2)] {
        rig.infuse(&["tell", "--id", "3", "--value", value, "--correct", "--run", run]).ok();
        let mean = rig.status()["best_measured"]["value"].as_f64().unwrap();
        assert!((mean - sum / 5.0).abs() < 1e-12, "{mean} after run {run}");
    }
}

#[test]
fn a_batch_of_failures_is_reopened_by_a_result() {
    let rig = Rig::new();
    rig.infuse(&["ask"]).ok();
    for id in 1..=10 {
        rig.infuse(&["tell", "--id", &id.to_string(), "--failed", "no water"]).ok();
    }
    let text = rig.infuse(&["ask"]).ok();
    assert!(text.contains("every experiment of the last batch failed; `infuse tell --correct`"), "{text}");
    assert!(!text.contains("The best design"), "{text}");
    rig.fill("sheet-1.csv", |_| true);
    rig.infuse(&["tell", "sheet-1.csv", "--correct"]).ok();
    assert!(rig.infuse(&["ask"]).ok().contains("Batch 2"));
}

#[test]
fn commands_that_are_shown_can_be_typed() {
    let rig = Rig::empty();
    rig.infuse(&["new", "my rig"]).ok();
    let text = rig.infuse(&["-C", "my rig", "ask"]).ok();
    assert!(text.contains("then: infuse -C 'my rig' tell 'my rig/sheet-1.csv'"), "{text}");
    let text = rig.infuse(&["-C", "my rig", "status"]).ok();
    assert!(text.contains("then: infuse -C 'my rig' tell 'my rig/sheet-1.csv'"), "{text}");
}

#[test]
fn a_response_to_maximize_is_maximized() {
    let rig = Rig::new();
    rig.edit("goal = \"minimize\"\nlower = 0", "goal = \"maximize\"");
    let table = rig.read("simulation.csv");
    let negated = table.lines().enumerate().map(|(index, row)| match (index, row.rsplit_once(',')) {
        (1.., Some((settings, value))) => format!("{settings},-{value}\n"),
        _ => format!("{row}\n"),
    });
    rig.write("simulation.csv", &negated.collect::<String>());
    let reference = Rig::new();
    for _ in 0..2 {
        rig.infuse(&["ask"]).ok();
        let batch = if rig.path("sheet-2.csv").exists() { 2 } else { 1 };
        let sheet = format!("sheet-{batch}.csv");
        rig.fill(&sheet, |_| true);
        let text = rig.read(&sheet);
        let rows = text.lines().enumerate().map(|(index, row)| {
            let mut cells: Vec<String> = row.split(',').map(str::to_owned).collect();
            if index > 0 {
                cells[5] = format!("-{}", cells[5]);
            }
            cells.join(",") + "\n"
        });
        rig.write(&sheet, &rows.collect::<String>());
        rig.infuse(&["tell", &sheet]).ok();
        reference.batch();
    }
    let (negated, status) = (rig.status(), reference.status());
    assert_eq!(negated["best"], status["best"]);
    assert_eq!(negated["left"], status["left"]);
    assert_eq!(negated["predicted"].as_f64(), status["predicted"].as_f64().map(|value| -value));
    assert_eq!(negated["response"]["better"], "higher");
}

#[test]
fn one_experiment_is_told_without_a_sheet_and_put_right() {
    let rig = Rig::new();
    rig.infuse(&["ask"]).ok();
    rig.infuse(&["tell", "--id", "3", "--value", "12.5", "--note", "by hand"]).ok();
    let error = rig.infuse(&["tell", "--id", "3", "--value", "12.6"]).error();
    assert!(
        error.contains("experiment 3 has a result already, 12.5 mm/s, and 12.6 mm/s was not taken")
            && error.contains("infuse tell --id 3 --value 12.6 --correct"),
        "{error}"
    );
    rig.infuse(&["tell", "--id", "3", "--value", "12.6", "--correct"]).ok();
    rig.infuse(&["tell", "--id", "4", "--failed", "no power"]).ok();
    assert_eq!(told(&rig.journal()).get(&3), Some(&12.6));
    rig.fill("sheet-1.csv", |id| !(3..=4).contains(&id));
    rig.infuse(&["tell", "sheet-1.csv"]).ok();
    // Complete, and still to be put right until the next batch rests on it.
    rig.infuse(&["tell", "--id", "3", "--value", "12.7", "--correct"]).ok();
    rig.infuse(&["ask"]).ok();
    let error = rig.infuse(&["tell", "--id", "3", "--value", "12.8", "--correct"]).error();
    assert!(error.contains("one of batch 2: later batches rest on the results of the others"), "{error}");
    let error = rig.infuse(&["tell", "--id", "99", "--value", "1"]).error();
    assert!(error.contains("experiment 99 was never asked for, expected an id from 1 to 20"), "{error}");
}

#[test]
fn options_of_tell_that_do_not_go_together_are_answered_with_those_that_do() {
    let rig = Rig::new();
    rig.infuse(&["ask"]).ok();
    for (options, words) in [
        (&[][..], "nothing to take, expected a sheet, or --id with --value or --failed"),
        (&["--id", "1"], "expected --value or --failed beside it"),
        (&["--value", "3"], "--value needs --id beside it"),
        (&["sheet-1.csv", "--value", "3"], "--value needs --id beside it"),
        (&["sheet-1.csv", "--id", "1", "--value", "3"], "a sheet and --id at once, expected one of them"),
        (&["--id", "1", "--value", "3", "--failed", "x"], "--value and --failed at once, expected one of them"),
        (&["--id", "1", "--result", "3"], "unexpected argument '--result'"),
        (&["1", "3"], "unexpected argument '3'"),
    ] {
        let error = rig.infuse(&[&["tell"], options].concat()).error();
        let is_shown =
            error.contains("infuse tell --id 3 --value 12.5\n") && error.contains("infuse tell sheet-1.csv\n");
        assert!(error.contains(words) && is_shown, "{options:?}: {error}");
    }
    for (option, value, words) in [
        ("--value", "3,5", "expected a number with a decimal point, not a comma"),
        ("--value", "x", "expected a number like 12.5, without its unit"),
        ("--id", "-1", "expected a whole number from 1 on"),
        ("--id", "one", "expected a whole number from 1 on"),
    ] {
        let error = rig.infuse(&["tell", option, value]).error();
        assert!(error.contains(words), "{option} {value}: {error}");
    }
    assert!(told(&rig.journal()).is_empty(), "nothing was taken");
}

#[test]
fn a_count_below_one_is_told_what_is_allowed() {
    let rig = Rig::pooled();
    for (command, option) in [("confirm", "--runs"), ("run", "--batches")] {
        for count in ["-4", "0", "2.5", "many"] {
            let error = rig.infuse(&[command, option, count]).error();
            let words = format!("invalid value '{count}' for '{option} <N>': expected a whole number from 1 on");
            assert!(error.contains(&words), "{error}");
        }
    }
    assert!(
        rig.infuse(&["status", "--wait", "-1"]).error().contains("--wait is -1.0, expected a number of seconds from 0")
    );
}

#[test]
fn why_a_design_was_dropped_can_be_asked() {
    let rig = Rig::new();
    while rig.batch() {}
    let text = rig.infuse(&["status", "--why", "spring=34,damper gain=2.9"]).ok();
    assert!(text.contains("spring 34 N/mm, damper gain 2.9 N s/mm was dropped by batch 2"), "{text}");
    let best = rig.status()["best"].clone();
    let text = rig
        .infuse(&["status", "--why", &format!("spring={},damper gain={}", best["spring"], best["damper gain"])])
        .ok();
    assert!(text.contains("is still among the designs left"), "{text}");
    for (why, words) in [
        ("spring=34", "no value of `damper gain`"),
        ("springs=34", "no parameter is called `springs`, expected one of `spring`, `damper gain`"),
        ("spring=34,damper gain=nan", "expected a finite number"),
        ("spring=340,damper gain=1", "340"),
    ] {
        let error = rig.infuse(&["status", "--why", why]).error();
        assert!(error.contains(words), "{error}");
    }
}

#[test]
fn a_problem_that_was_changed_after_the_beginning_is_told_where() {
    let rig = Rig::new();
    rig.batch();
    rig.edit("upper = 34", "upper = 36");
    let error = rig.infuse(&["status"]).error();
    assert!(error.contains("`parameter[spring].upper` was 34.0 and is 36.0"), "{error}");
    rig.edit("upper = 36", "upper = 34");
    // What does not touch what was learned may change.
    rig.edit("batches = 6", "batches = 1");
    assert!(rig.infuse(&["ask"]).ok().contains("all 1 batch of [loop] were made") || rig.status()["stage"] == "ended");
    rig.edit("batches = 1", "batches = 3");
    assert!(rig.infuse(&["ask", "--anyway"]).ok().contains("Batch 2"));
}

/// What a machine reads is what a person reads, with the numbers beside it.
#[test]
fn findings_are_the_sentences_of_the_terminal() {
    fn sentences(finding: &Value, found: &mut Vec<String>) {
        found.push(finding["sentence"].as_str().unwrap().to_owned());
        for number in finding["numbers"].as_array().into_iter().flatten() {
            assert!(
                number["name"].is_string() && number["value"].is_number() && number["unit"].is_string(),
                "{number}"
            );
        }
        finding["details"].as_array().into_iter().flatten().for_each(|detail| sentences(detail, found));
    }
    let rig = Rig::new();
    assert!(rig.batch());
    let text = rig.infuse(&["status"]).ok();
    let status = rig.status();
    let mut found = Vec::new();
    status["findings"].as_array().unwrap().iter().for_each(|finding| sentences(finding, &mut found));
    let lines: Vec<&str> = text.lines().skip(1).map(str::trim).filter(|line| !line.is_empty()).collect();
    assert_eq!(found, lines);
    let best = &status["findings"][1];
    let predicted = best["details"][0]["numbers"][0]["value"].as_f64();
    assert_eq!((best["numbers"][0]["name"].as_str(), predicted), (Some("spring"), status["predicted"].as_f64()));
}
