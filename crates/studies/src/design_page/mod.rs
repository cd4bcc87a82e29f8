//! `cargo xtask design-page`: what a design is worth, from the JSON of doe's example `evaluate_design`, as one page.

mod evaluation;
mod figures;
mod page;
mod tables;

use std::path::Path;

use anyhow::{Context as _, Result};

use evaluation::Evaluation;

/// Reads an evaluation and writes its page.
///
/// # Errors
/// When a file cannot be read or written, or the first is no evaluation with its runs: which file, and what is missing.
pub(crate) fn run(evaluation: &Path, page: &Path) -> Result<()> {
    let text = std::fs::read_to_string(evaluation).with_context(|| evaluation.display().to_string())?;
    let html = html(&text).with_context(|| evaluation.display().to_string())?;
    std::fs::write(page, html).with_context(|| page.display().to_string())
}

fn html(text: &str) -> Result<String> {
    let evaluation: Evaluation = serde_json::from_str(text).context("no evaluation as `evaluate_design` writes it")?;
    evaluation.check()?;
    Ok(page::page(&evaluation).html())
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::*;

    /// Three runs at the corners of a square, for a plane through them.
    fn small() -> Value {
        json!({
            "terms": ["1", "depth", "width"],
            "over": "cube of 2 factors",
            "degrees_of_freedom": { "model": 3, "lack_of_fit": 0, "pure_error": 0 },
            "replicates": [], "outside": [], "forbidden": [],
            "correlations": { "terms": ["depth", "width"], "values": [1.0, 0.5, 0.5, 1.0] },
            "aliases": [],
            "precision": {
                "efficiencies": [{ "criterion": "G", "value": 3.0, "percent": 33.3, "over": "cube of 2 factors" }],
                "coefficients": [
                    { "term": "1", "standard_error": 0.7, "variance_inflation": null },
                    { "term": "depth", "standard_error": 0.7, "variance_inflation": 1.33 },
                    { "term": "width", "standard_error": 0.7, "variance_inflation": 1.33 }
                ],
                "leverages": [1.0, 1.0, 1.0],
                "predictions": { "maximum": 3.0, "maximum_at": [1.0, 1.0], "minimum": 0.33, "mean": 0.8 },
                "fraction_of_space": { "fractions": [0.0, 0.5, 1.0], "variances": [0.33, 0.7, 3.0] }
            },
            "parameters": [
                { "name": "depth", "unit": "m", "lower": 2.0, "upper": 4.0, "levels": "continuous" },
                { "name": "width", "unit": "", "lower": 0.0, "upper": 1.0, "levels": 3 }
            ],
            "runs": [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0]],
            "forbidden_boxes": [{ "ranges": [[0.5, 1.0], [0.5, 1.0]] }],
            "variance_slice": {
                "factors": [0, 1], "through": [0.0, 0.0], "levels": [-1.0, 0.0, 1.0],
                "variances": [1.0, 0.5, 1.0, 0.5, 0.5, 1.5, 1.0, 1.5, 3.0]
            }
        })
    }

    fn without(path: &str) -> String {
        let mut value = small();
        let (parent, key) = path.rsplit_once('/').expect("a path");
        let parent = value.pointer_mut(parent).and_then(Value::as_object_mut).expect("an object");
        parent.remove(key).expect("a key of the small evaluation");
        format!("{:#}", html(&value.to_string()).expect_err(path))
    }

    #[test]
    fn small_evaluation_is_drawn() {
        let html = html(&small().to_string()).expect("a whole evaluation");
        assert_eq!(html.matches("<svg ").count(), 4, "plane, fractions, leverages, correlations");
        assert_eq!(html.matches("<table>").count(), 3, "efficiencies, coefficients, runs");
        for text in ["depth (m)", ">width<", "blank: forbidden (1 of 9)", "depth 4 m, width 1", "1 depth; 2 width"] {
            assert!(html.contains(text), "{text}: {html}");
        }
        assert!(!html.contains("NaN"), "only numbers");
    }

    #[test]
    fn undetermined_model_is_told_with_its_aliases() {
        let mut value = small();
        value["precision"] = Value::Null;
        value["variance_slice"] = Value::Null;
        value["aliases"] = json!([{ "term": "width", "equals": [["depth", -1.0]] }]);
        let html = html(&value.to_string()).expect("an evaluation");
        assert!(html.contains("<li>width = -1.0000 (depth)</li>"), "{html}");
        assert_eq!(html.matches("<svg ").count(), 1, "the correlations");
    }

    #[test]
    fn missing_field_is_named() {
        for path in [
            "/runs",
            "/parameters",
            "/precision",
            "/variance_slice",
            "/precision/leverages",
            "/precision/coefficients/1/variance_inflation",
            "/variance_slice/levels",
        ] {
            let (error, key) = (without(path), path.rsplit('/').next().expect("a key"));
            assert!(error.contains(&format!("missing field `{key}`")), "{path}: {error}");
        }
    }

    #[test]
    fn file_is_named() {
        let path = std::env::temp_dir().join(format!("xtask-{}-design-page.json", std::process::id()));
        std::fs::write(&path, "{}").expect("a writable directory");
        let error = run(&path, Path::new("never-written.html")).expect_err("nothing is there");
        std::fs::remove_file(&path).expect("just written");
        let text = format!("{error:#}");
        assert!(text.starts_with(&path.display().to_string()) && text.contains("missing field `terms`"), "{text}");
    }

    #[test]
    fn list_of_the_wrong_length_is_named() {
        let mut value = small();
        value["precision"]["leverages"] = json!([1.0]);
        let error = html(&value.to_string()).expect_err("one leverage of three");
        assert_eq!(error.to_string(), "`precision.leverages` is of length 1, expected 3");
    }
}
