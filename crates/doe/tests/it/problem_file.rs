//! The problem in TOML of the examples: where its errors point, and what they say.

#[path = "../../examples/problem/mod.rs"]
mod problem;

use problem::ProblemFile;

/// What is said of a file of this text.
fn fault(name: &str, text: &str) -> String {
    let path = std::env::temp_dir().join(format!("infuse-doe-{}-{name}.toml", std::process::id()));
    std::fs::write(&path, text).unwrap();
    let read = ProblemFile::read(path.to_str().unwrap());
    std::fs::remove_file(&path).unwrap();
    read.err().map(|error| error.to_string()).unwrap_or_default()
}

fn parameter(name: &str, lower: f64) -> String {
    format!("[[parameters]]\nname = \"{name}\"\nunit = \"m\"\nlower = {lower:?}\nupper = 1.0\n")
}

#[test]
fn a_number_below_zero_is_told_what_is_allowed() {
    let rest = parameter("a", 0.0);
    for key in ["runs", "replicates", "starts", "seed", "order_seed"] {
        let runs = if key == "runs" { "" } else { "runs = 8\n" };
        let text = format!("{runs}model = \"quadratic\"\ncriterion = \"G\"\n{key} = -4\n{rest}");
        let fault = fault(key, &text);
        assert!(fault.contains("invalid value: integer `-4`, expected a whole number from 0 up"), "{fault}");
    }
}

#[test]
fn a_fault_in_a_parameter_points_at_it_and_not_at_the_first() {
    let head = "runs = 8\nmodel = \"quadratic\"\ncriterion = \"G\"\n";
    let text = format!("{head}{}{}{}", parameter("a", 0.0), parameter("b", 2.0), parameter("c", 0.0));
    let fault = fault("bounds", &text);
    assert!(
        fault.ends_with("line 9, parameter 2: parameter `b`: the lower bound 2.0 is above the upper bound 1.0, expected lower < upper"),
        "{fault}"
    );
}

/// A problem with two continuous parameters and these further lines.
fn two_parameters(name: &str, lines: &str) -> ProblemFile {
    let path = std::env::temp_dir().join(format!("infuse-doe-{}-{name}.toml", std::process::id()));
    let head = format!("model = \"quadratic\"\ncriterion = \"G\"\n{lines}\n");
    std::fs::write(&path, head + &parameter("a", 0.0) + &parameter("b", 0.0)).unwrap();
    let read = ProblemFile::read(path.to_str().unwrap());
    std::fs::remove_file(&path).unwrap();
    read.unwrap()
}

#[test]
fn many_runs_need_a_limit_of_the_time() {
    let error = two_parameters("many", "runs = 100000").settings().unwrap_err().to_string();
    assert_eq!(
        error,
        "runs = 100000: the search may take hours, expected at most 2000 without `seconds`, which limits it"
    );
    assert!(two_parameters("limited", "runs = 100000\nseconds = 5.0").settings().is_ok());
    assert!(two_parameters("few", "runs = 2000").settings().is_ok());
}

#[test]
fn a_word_for_a_number_is_told_so_in_plain_words() {
    let text = "runs = 8\nmodel = \"quadratic\"\ncriterion = \"G\"\n[[parameters]]\nname = \"a\"\nunit = \"m\"\nlower = \"x\"\nupper = 1.0\n";
    let said = fault("word", text);
    assert!(said.contains("invalid type: string \"x\", expected a number") && said.contains("line 7"), "{said}");
    let listed = fault("exponents", &text.replace("\"quadratic\"", "[[0],[-1]]").replace("\"x\"", "0.0"));
    assert!(listed.contains("a list of exponents") && !listed.contains("decimal comma"), "{listed}");
}

/// The best published design of seven runs has 80.239 %, judged on five levels of each parameter.
#[test]
fn a_file_may_ask_for_predictions_on_a_grid_only() {
    let judged = |name, lines: &str| two_parameters(name, lines).problem();
    let problem = judged("judged", "runs = 7\njudged_levels = 5").unwrap();
    let found = doe::search(&problem, &doe::Settings::default()).unwrap();
    assert!(found.efficiency.percent > 80.238, "{}", found.efficiency);
    let said = problem.judged().over().to_string();
    assert_eq!(said, "grid of 5 x 5 levels");
    let each = judged("each", "runs = 7\njudged_levels = [5, 3]").unwrap();
    assert_eq!(each.judged().over().to_string(), "grid of 5 x 3 levels");
    let refused = |name, lines: &str| judged(name, lines).unwrap_err().to_string();
    assert_eq!(
        refused("three", "runs = 7\njudged_levels = [5, 5, 5]"),
        "judged_levels: 3 numbers, expected one for each of the 2 parameters, or one for all"
    );
    assert_eq!(refused("one", "runs = 7\njudged_levels = 1"), "judged_levels: 1, expected 2 to 100000");
}

/// Predictions may be asked for on levels that a forbidden box lies between; only the box of a typo forbids nothing.
#[test]
fn a_forbidden_box_between_the_levels_to_judge_over_forbids_none_of_them() {
    let lines = |range: &str| format!("runs = 9\njudged_levels = 3\nforbidden = [{{ a = {range}, b = [0.5, 1.0] }}]");
    let between = two_parameters("between", &lines("[0.6, 0.9]")).problem().unwrap();
    assert_eq!((between.judged().n_points(), between.space().forbidden().len()), (Some(9), 1));
    let corner = two_parameters("corner", &lines("[0.6, 1.0]")).problem().unwrap();
    assert_eq!(corner.judged().n_points(), Some(7), "two of them lie in the box");
    let outside = two_parameters("outside", &lines("[60.0, 90.0]")).problem().unwrap_err().to_string();
    assert!(
        outside.starts_with("forbidden 1: parameter `a`: the forbidden range 60.0 to 90.0 lies outside"),
        "{outside}"
    );
}
