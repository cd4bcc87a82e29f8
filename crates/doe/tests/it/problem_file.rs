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
