//! What a design in a file is worth: `evaluate_design [problem.toml design.csv [evaluation.json]]`.
//!
//! Of the problem the parameters, the model and the forbidden combinations count. `evaluation.json` holds the whole
//! evaluation, the runs, and the prediction variance on the plane of the first two factors through the center; in the
//! repository of this crate `cargo xtask design-page evaluation.json page.html` makes a page with pictures of it.

mod problem;

use std::error::Error;
use std::fs::File;
use std::io::{Write as _, stdout};
use std::process::ExitCode;

use doe::{Design, Evaluation, Forbidden, Model, Parameter, PredictionVariance, VarianceSlice, evaluate};
use problem::ProblemFile;
use serde::Serialize;

const BUNDLED: [&str; 2] = [
    concat!(env!("CARGO_MANIFEST_DIR"), "/examples/rig.toml"),
    concat!(env!("CARGO_MANIFEST_DIR"), "/examples/handmade.csv"),
];

/// Levels of both axes of the plane.
const N_LEVELS: usize = 61;

/// The file `evaluation.json`: coordinates are coded, −1 at the lower bound of a parameter and 1 at the upper.
#[derive(Serialize)]
struct Written<'a> {
    #[serde(flatten)]
    evaluation: &'a Evaluation,
    parameters: &'a [Parameter],
    runs: Vec<&'a [f64]>,
    forbidden_boxes: &'a [Forbidden],
    /// None with one factor, and where the runs do not determine the model.
    variance_slice: Option<VarianceSlice>,
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    problem::finish(score(&arguments))
}

fn score(arguments: &[String]) -> Result<(), Box<dyn Error>> {
    let (problem, csv, json) = match arguments {
        [] => (BUNDLED[0], BUNDLED[1], None),
        [problem, csv] => (problem.as_str(), csv.as_str(), None),
        [problem, csv, json] => (problem.as_str(), csv.as_str(), Some(json)),
        _ => return Err("expected none, two or three arguments: problem.toml design.csv evaluation.json".into()),
    };
    let file = ProblemFile::read(problem)?;
    let reader = File::open(csv).map_err(|error| format!("{csv}: {error}"))?;
    let read = Design::read_csv(&file.region()?, reader).map_err(|error| format!("{csv}: {error}"))?;
    let (region, model, space) = (file.region()?, file.model()?, file.space()?);
    let evaluation = evaluate(&model, &space, &read.design, &file.evaluation_settings())?;
    if let Some(path) = json {
        let written = Written {
            evaluation: &evaluation,
            parameters: region.parameters(),
            runs: read.design.runs().collect(),
            forbidden_boxes: space.forbidden(),
            variance_slice: slice(&model, &read.design, &evaluation)?,
        };
        let mut text = serde_json::to_vec_pretty(&written)?;
        text.push(b'\n');
        std::fs::write(path, text).map_err(|error| format!("{path}: {error}"))?;
    }
    writeln!(stdout(), "{evaluation}")?;
    if !read.ignored.is_empty() {
        writeln!(stdout(), "not read: {}", read.ignored.join(", "))?;
    }
    Ok(())
}

/// The plane of the first two factors through the center.
fn slice(model: &Model, design: &Design, evaluation: &Evaluation) -> Result<Option<VarianceSlice>, doe::Error> {
    if evaluation.precision.is_none() || model.n_factors() < 2 {
        return Ok(None);
    }
    let variance = PredictionVariance::of(model, design)?;
    VarianceSlice::of(&variance, [0, 1], &vec![0.0; model.n_factors()], N_LEVELS).map(Some)
}
