//! Problems with slips: the field, the value, and what is allowed.

use crate::rig::Rig;

#[track_caller]
fn assert_refused(from: &str, to: &str, words: &[&str]) {
    let rig = Rig::new();
    rig.edit(from, to);
    let error = rig.infuse(&["ask"]).error();
    for word in words {
        assert!(error.contains(word), "`{word}` is not in {error}");
    }
    assert!(!rig.path("journal.jsonl").exists(), "nothing has begun");
}

#[test]
fn what_a_parameter_is_called_for_may_be_changed_at_any_time() {
    let rig = Rig::pooled();
    rig.batch();
    let status = rig.status();
    rig.edit("role = \"plant\"\n", "");
    assert_eq!(rig.status()["best"], status["best"]);
    rig.edit("unit = \"N/mm\"", "unit = \"kN/m\"");
    assert!(rig.infuse(&["status"]).error().contains("`parameter[spring].unit` was"), "all else stands");
}

#[test]
fn sections_that_are_missing_are_named_with_what_belongs_into_them() {
    let rig = Rig::empty();
    let response = "[response]\nname = \"y\"\nunit = \"N\"\ngoal = \"minimize\"\n";
    rig.write("campaign.toml", &format!("title = \"A\"\n{response}"));
    let error = rig.infuse(&["check"]).error();
    assert!(error.contains("write a section [[parameter]] for each thing that can be set"), "{error}");
    rig.write("campaign.toml", "title = \"A\"\n[[parameter]]\nname = \"a\"\nunit = \"mm\"\nlower = 0\nupper = 1\n");
    assert!(rig.infuse(&["check"]).error().contains("write a section [response]"));
    let of_table = Rig::pooled();
    of_table.edit("simulation.csv", "nowhere.csv");
    let error = of_table.infuse(&["check"]).error();
    assert!(error.ends_with("there is none of that name\n") && !error.contains("os error"), "{error}");
}

#[test]
fn slips_in_the_problem_are_told() {
    assert_refused("seed = 1", "sead = 1", &["campaign.toml", "sead", "line 6"]);
    assert_refused("lower = 10", "lower = 10,5", &["a decimal comma? write 20.5 and not 20,5"]);
    assert_refused("lower = 10", "lower = .5", &["write 0.5 and not .5"]);
    assert_refused("title = \"", "# title = \"", &["missing field `title`", "as the first line, above all sections"]);
    assert_refused("name = \"damper gain\"", "name = \"Spring\"", &["`spring` and `Spring` differ in case alone"]);
    assert_refused("[response]", "[responce]", &["responce", "expected one of"]);
    assert_refused(
        "experiments = 10",
        "experimints = 10",
        &["experimints", "are for `method` = \"dissertation\" alone"],
    );
    assert_refused("lower = 10", "lower = nan", &["`spring`", "NaN"]);
    assert_refused("lower = 10", "lower = 40", &["spring", "40"]);
    assert_refused("step = 2\n", "", &["`spring` needs `levels`", "dissertation"]);
    assert_refused("step = 2\n", "step = 5\n", &["`spring`", "expected an upper bound of 30 or 35"]);
    assert_refused("name = \"spring\"", "name = \"damper gain\"", &["damper gain"]);
    assert_refused("name = \"spring\"", "name = \"id\"", &["`id` is a heading of sheets"]);
    assert_refused("role = \"plant\"", "role = \"plan\"", &["plan", "`plant` or `controller`"]);
    assert_refused("goal = \"minimize\"", "goal = \"less\"", &["less", "minimize"]);
    assert_refused("lower = 0\n", "lower = 3\nupper = 2\n", &["`lower` is 3.0, expected less than `upper`"]);
    assert_refused("model = \"quadratic\"", "model = \"cubic\"", &["`model` is \"cubic\""]);
    assert_refused("experiments = 10", "experiments = 5", &["`experiments` is 5"]);
    assert_refused("replicates = 2", "replicates = 6", &["`replicates` is 6"]);
    assert_refused("simulations = 20", "simulations = 2", &["`simulations` is 2"]);
    assert_refused("batches = 6", "batches = 0", &["`batches` is 0"]);
    assert_refused("worth = 0.2", "worth = -1", &["`worth` is -1"]);
    assert_refused("table = \"simulation.csv\"", "", &["[simulator]", "needs `command`"]);
    let command = "command = [\"sim\", \"{spring}\", \"{dumper}\"]";
    assert_refused("table = \"simulation.csv\"", command, &["has {spring}, {dumper}, but no {damper gain}"]);
    let command = "command = [\"sim\", \"{spring}\"]";
    assert_refused("table = \"simulation.csv\"", command, &["but no {damper gain}", "`input` = \"json\""]);
    let command = "command = [\"sim\", \"{spring}\", \"{damper gain}\"]\ntimeout_seconds = 0";
    assert_refused("table = \"simulation.csv\"", command, &["`timeout_seconds` is 0"]);
}

#[test]
fn a_folder_without_a_campaign_says_how_to_make_one() {
    let rig = Rig::empty();
    let error = rig.infuse(&["ask"]).error();
    assert!(error.contains("campaign.toml: no such file") && error.contains("infuse new"), "{error}");
    rig.infuse(&["new", "."]).ok();
    let error = rig.infuse(&["new", "."]).error();
    assert!(error.contains("is there already, and was left alone"), "{error}");
}

#[test]
fn a_folder_that_cannot_be_used_is_named_with_what_to_do() {
    for (name, command) in [(".infuse.lock", "ask"), ("journal.jsonl", "status"), ("campaign.toml", "status")] {
        let rig = Rig::pooled();
        let _ = std::fs::remove_file(rig.path(name));
        std::fs::create_dir(rig.path(name)).unwrap();
        let error = rig.infuse(&[command]).error();
        assert!(
            error.contains(name) && error.contains("a folder stands where a file is expected: move it away"),
            "{error}"
        );
    }
    let rig = Rig::pooled();
    let error = rig.infuse(&["-C", "campaign.toml", "status"]).error();
    assert!(error.contains("campaign.toml is no folder, expected the folder of a campaign"), "{error}");
    // Whatever is wrong with the file, the folder is named.
    rig.edit("[loop]\n", "[loop]\nnoise = -1\n");
    let error = rig.infuse(&["-C", &rig.folder().display().to_string(), "check"]).error();
    assert!(
        error.contains(&format!("{}: [loop]: setting `noise` is -1", rig.path("campaign.toml").display())),
        "{error}"
    );
}

#[test]
fn a_table_that_does_not_fit_is_told_by_its_cells() {
    let rig = Rig::new();
    let table = rig.read("simulation.csv").replace("\n12,0.5,", "\n12.5,0.5,").replace("\n14,0.5,", "\n14,x,");
    rig.write("simulation.csv", &table);
    let error = rig.infuse(&["ask"]).error();
    assert!(
        error.contains("column `spring [N/mm]`: is `12.5`, expected a level of the parameter, the nearest is 12 N/mm"),
        "{error}"
    );
    assert!(error.contains("column `damper gain [N s/mm]`: is `x`"), "{error}");
}

#[test]
fn no_message_about_the_file_names_a_type_of_the_program() {
    for (from, to, words) in [
        ("seed = 1", "seed = -1", "`seed` is -1, expected a whole number from 0 on"),
        ("step = 2", "levels = 2.5", "`levels` is 2.5, expected a whole number from 2 to 4294967295"),
        ("lower = 10", "lower = \"a\"", "`lower` is \"a\", expected a number"),
        ("experiments = 10", "experiments = \"ten\"", "`experiments` is \"ten\", expected a whole number from 1 on"),
        ("experiments = 10", "experiments = -3", "`experiments` is -3, expected a whole number from 1 on"),
        ("batches = 6", "batches = -1", "`batches` is -1, expected a whole number from 1 on"),
        ("batches = 6", "replicates = -2", "`replicates` is -2, expected a whole number from 0 on"),
        ("batches = 6", "simulations = -5", "`simulations` is -5, expected a whole number from 2 on"),
        ("batches = 6", "plants = -1", "`plants` is -1, expected a whole number from 1 on"),
        ("[stop]", "[stop]\nsmooth = \"yes\"", "`smooth` is \"yes\", expected true or false"),
        ("table = \"simulation.csv\"", "table = 5", "`table` is 5, expected the name of a file"),
        ("table = \"simulation.csv\"", "command = \"a b\"", "expected a list, like [\"program\""),
        ("table = \"simulation.csv\"", "command = [\"a\", 3]", "`command` has 3, expected a text in quotes"),
        ("role = \"plant\"", "role = 3", "`role` is 3, expected `plant` or `controller`"),
        ("goal = \"minimize\"", "goal = \"min\"", "`goal` is \"min\", expected `minimize` or `maximize`"),
        ("[loop]", "[loop]\nsurfaces = \"x\"", "`surfaces` is \"x\", expected a table, like { combined = "),
        ("[response]", "[[response]]", "write [response] with one bracket"),
        ("\n[response]", "\n[responses]", "write [response]: there is but one"),
        ("\n[[parameter]]", "\n[[parameters]]", "write [[parameter]]: there may be several"),
        ("\n[[parameter]]", "\n[parameters]", "write [[parameter]] with two brackets: there may be several"),
        ("\n[stop]", "\n[stops] # when", "write [stop]: there is but one"),
        ("goal = \"minimize\"", "", "write a section [response] with name, unit and goal"),
    ] {
        let rig = Rig::pooled();
        rig.edit(from, to);
        let error = rig.infuse(&["status"]).error();
        assert!(error.contains(words), "{words} is not in {error}");
        for name in ["u64", "u32", "usize", "f64", "boolean", "struct", "sequence", "variant", "invalid type"] {
            assert!(!error.contains(name), "{name} is in {error}");
        }
    }
    let rig = Rig::empty();
    rig.write(
        "campaign.toml",
        "title = \" \"\n[response]\nname = \"y\"\nunit = \"mm\"\ngoal = \"minimize\"\n[[parameter]]\nname = \"x\"\n",
    );
    let error = rig.infuse(&["status"]).error();
    assert!(error.contains("`title` is \" \", expected what is optimized, in words"), "{error}");
    let rig = Rig::pooled();
    rig.edit("seed = 1", &format!("seed = \"{}\"", "x".repeat(3_000_000)));
    assert!(rig.infuse(&["status"]).error().len() < 1000);
}

#[test]
fn a_key_in_the_wrong_section_is_told_where_it_stands() {
    for (from, to, expected) in [
        (
            "table = \"simulation.csv\"",
            "table = \"simulation.csv\"\nsimulations = 30",
            "`simulations` stands under [loop]",
        ),
        ("batches = 6", "batches = 6\nworth = 0.3", "`worth` stands under [stop]"),
        ("batches = 6", "batches = 6\nseed = 3", "`seed` stands at the top of the file, above all sections"),
        ("batches = 6", "batches = 6\njobs = 3", "`jobs` stands under [simulator]"),
        ("batches = 6", "batches = 6\nprobability = 0.9", "`probability` stands under [[constraint]]"),
    ] {
        let rig = Rig::pooled();
        rig.edit(from, to);
        let error = rig.infuse(&["check"]).error();
        assert!(error.contains("unknown field") && error.contains(expected), "{error}");
    }
    let rig = Rig::pooled();
    rig.edit("batches = 6", "batchez = 6");
    assert!(!rig.infuse(&["check"]).error().contains("stands under"));
}

#[test]
fn a_key_that_is_not_known_is_answered_with_all_that_are() {
    let rig = Rig::pooled();
    rig.edit("batches = 6", "batchez = 6");
    let error = rig.infuse(&["check"]).error();
    for key in ["method", "experiments", "simulations", "batches", "confidence", "noise", "surfaces", "without_spread"]
    {
        assert!(error.contains(&format!("`{key}`")), "`{key}` is not in {error}");
    }
    assert!(!error.contains("..."), "{error}");
    // What was written there may be cut, what is allowed is not.
    rig.edit("batchez", &"x".repeat(10_000));
    let error = rig.infuse(&["check"]).error();
    assert!(error.contains("`without_spread`") && error.len() < 1500, "{error}");
}
