//! `cargo xtask design-page`: what a design is worth, from the JSON of doe's example `evaluate_design`, as one page.

use std::path::Path;

use anyhow::{Context as _, Result, ensure};
use serde::{Deserialize, Deserializer};

use page::Page;
use page::{
    Axis, CellFigure, CellPanel, Landscape, LineFigure, Panel, Points, Series, cell_figure, landscape_figure,
    line_figure,
};
use page::{Column, Table};

/// The part of an evaluation that the page shows; variances are for unit variance of a run.
#[derive(Deserialize)]
struct Evaluation {
    terms: Vec<String>,
    over: String,
    degrees_of_freedom: DegreesOfFreedom,
    replicates: Vec<Vec<usize>>,
    outside: Vec<usize>,
    forbidden: Vec<usize>,
    correlations: Correlations,
    aliases: Vec<Alias>,
    #[serde(deserialize_with = "null_or")]
    precision: Option<Precision>,
    parameters: Vec<Parameter>,
    /// Coded, as all coordinates.
    runs: Vec<Vec<f64>>,
    forbidden_boxes: Vec<ForbiddenBox>,
    #[serde(deserialize_with = "null_or")]
    variance_slice: Option<Slice>,
}

#[derive(Deserialize)]
struct DegreesOfFreedom {
    model: usize,
    lack_of_fit: usize,
    pure_error: usize,
}

#[derive(Deserialize)]
struct Correlations {
    terms: Vec<String>,
    values: Vec<Option<f64>>,
}

#[derive(Deserialize)]
struct Alias {
    term: String,
    equals: Vec<(String, f64)>,
}

#[derive(Deserialize)]
struct Precision {
    efficiencies: Vec<Efficiency>,
    coefficients: Vec<Coefficient>,
    leverages: Vec<f64>,
    predictions: Predictions,
    fraction_of_space: Fractions,
}

#[derive(Deserialize)]
struct Efficiency {
    criterion: String,
    value: f64,
    percent: f64,
    #[serde(deserialize_with = "null_or")]
    over: Option<String>,
}

#[derive(Deserialize)]
struct Coefficient {
    term: String,
    standard_error: f64,
    #[serde(deserialize_with = "null_or")]
    variance_inflation: Option<f64>,
}

#[derive(Deserialize)]
struct Predictions {
    maximum: f64,
    maximum_at: Vec<f64>,
    minimum: f64,
    mean: f64,
}

#[derive(Deserialize)]
struct Fractions {
    fractions: Vec<f64>,
    variances: Vec<f64>,
}

#[derive(Deserialize)]
struct Parameter {
    name: String,
    unit: String,
    lower: f64,
    upper: f64,
}

#[derive(Deserialize)]
struct ForbiddenBox {
    ranges: Vec<Option<[f64; 2]>>,
}

#[derive(Deserialize)]
struct Slice {
    factors: [usize; 2],
    through: Vec<f64>,
    levels: Vec<f64>,
    variances: Vec<f64>,
}

/// A key that must be there, though perhaps with `null`.
fn null_or<'de, D: Deserializer<'de>, T: Deserialize<'de>>(deserializer: D) -> Result<Option<T>, D::Error> {
    Option::deserialize(deserializer)
}

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
    Ok(page(&evaluation).html())
}

impl Parameter {
    fn natural(&self, coded: f64) -> f64 {
        0.5 * (self.lower * (1.0 - coded) + self.upper * (1.0 + coded))
    }

    /// To a ten-thousandth of the range.
    fn text(&self, coded: f64) -> String {
        let decimals = (4.0 - (self.upper - self.lower).log10().ceil()).clamp(0.0, 12.0) as usize;
        let text = format!("{:.decimals$}", self.natural(coded));
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
    }

    fn unit(&self) -> &str {
        if self.unit.is_empty() { "1" } else { &self.unit }
    }

    fn axis(&self) -> Axis {
        Axis::new(&self.name, self.unit())
    }
}

fn check_length(what: &str, found: usize, expected: usize) -> Result<()> {
    ensure!(found == expected, "`{what}` is of length {found}, expected {expected}");
    Ok(())
}

impl Evaluation {
    /// Whether all lists are as long as they must be.
    fn check(&self) -> Result<()> {
        let (k, n) = (self.parameters.len(), self.runs.len());
        ensure!(k > 0 && n > 0, "`parameters` and `runs` are of length {k} and {n}, expected at least 1");
        for (index, parameter) in self.parameters.iter().enumerate() {
            let Parameter { lower, upper, .. } = parameter;
            ensure!(lower < upper, "`parameters[{index}]` reaches from {lower} to {upper}, expected lower < upper");
        }
        for (index, run) in self.runs.iter().enumerate() {
            check_length(&format!("runs[{index}]"), run.len(), k)?;
        }
        for (index, one) in self.forbidden_boxes.iter().enumerate() {
            check_length(&format!("forbidden_boxes[{index}].ranges"), one.ranges.len(), k)?;
        }
        let n_correlated = self.correlations.terms.len();
        check_length("correlations.values", self.correlations.values.len(), n_correlated * n_correlated)?;
        if let Some(precision) = &self.precision {
            check_length("precision.coefficients", precision.coefficients.len(), self.terms.len())?;
            check_length("precision.leverages", precision.leverages.len(), n)?;
            check_length("precision.predictions.maximum_at", precision.predictions.maximum_at.len(), k)?;
            let Fractions { fractions, variances } = &precision.fraction_of_space;
            check_length("precision.fraction_of_space.variances", variances.len(), fractions.len())?;
        }
        if let Some(slice) = &self.variance_slice {
            let levels = slice.levels.len();
            let rises = slice.levels.windows(2).all(|pair| pair[0] < pair[1]);
            ensure!(
                levels >= 2 && rises,
                "`variance_slice.levels` is of length {levels}, expected 2 or more that rise"
            );
            check_length("variance_slice.variances", slice.variances.len(), levels * levels)?;
            check_length("variance_slice.through", slice.through.len(), k)?;
            let [a, b] = slice.factors;
            ensure!(a < k && b < k && a != b, "`variance_slice.factors` are {a} and {b}, expected two below {k}");
        }
        Ok(())
    }

    /// Whether a coded point is forbidden; a range that reaches a bound goes on beyond it.
    fn forbids(&self, point: &[f64]) -> bool {
        let meets = |(range, x): (&Option<[f64; 2]>, &f64)| {
            range.is_none_or(|[lower, upper]| (lower <= -1.0 || lower < *x) && (upper >= 1.0 || *x < upper))
        };
        self.forbidden_boxes.iter().any(|one| one.ranges.iter().zip(point).all(meets))
    }

    /// A coded point in units.
    fn place(&self, point: &[f64]) -> String {
        let text = |(parameter, x): (&Parameter, &f64)| {
            format!("{} {} {}", parameter.name, parameter.text(*x), parameter.unit).trim_end().to_owned()
        };
        self.parameters.iter().zip(point).map(text).collect::<Vec<_>>().join(", ")
    }
}

fn page(evaluation: &Evaluation) -> Page {
    let names: Vec<&str> = evaluation.parameters.iter().map(|parameter| parameter.name.as_str()).collect();
    let (n, p) = (evaluation.runs.len(), evaluation.terms.len());
    let mut page = Page::new(&format!("A design of {n} runs for {p} terms of {}", names.join(", ")));
    warn(&mut page, evaluation);
    let DegreesOfFreedom { model, lack_of_fit, pure_error } = evaluation.degrees_of_freedom;
    page.paragraph(&format!(
        "Predictions are asked for over the {}. Of the {n} degrees of freedom {model} go to the model, {lack_of_fit} tell \
         lack of fit, {pure_error} pure error. All variances are for unit variance of a run; terms are those of coded \
         parameters, from -1 at the lower bound to 1 at the upper.",
        evaluation.over
    ));
    if let Some(precision) = &evaluation.precision {
        let Predictions { maximum, maximum_at, minimum, mean } = &precision.predictions;
        page.heading("Predictions");
        page.paragraph(&format!(
            "The prediction variance is {mean:.4} in the mean, from {minimum:.4} to {maximum:.4}, the latter at {}.",
            evaluation.place(maximum_at)
        ));
        if let Some(slice) = &evaluation.variance_slice {
            page.figure(&landscape_figure(&plane(evaluation, slice)), &plane_caption(evaluation, slice));
        }
        page.figure(
            &fractions(precision),
            "Fraction of design space: the prediction variance that a share of the space does not exceed, and the mean.",
        );
        page.table(&efficiencies(precision), "Efficiencies by every criterion.");
        page.heading("Terms and runs");
        page.table(&coefficients(precision), "What the runs say about each coefficient, for unit noise of a run.");
        page.figure(
            &leverages(precision),
            "Above, the leverage of each run: at 1 the model goes through the run, whatever was measured. Below, the \
             variance inflation of each term without the constant, numbered as in the map of correlations: 1 is a term \
             unrelated to all others.",
        );
    } else {
        page.heading("Terms and runs");
    }
    if evaluation.correlations.terms.len() >= 2 {
        page.figure(&correlations(&evaluation.correlations), &correlations_caption(&evaluation.correlations));
    }
    page.table(&runs(evaluation), "The runs.");
    page
}

/// What is likely to be a mistake comes first.
fn warn(page: &mut Page, evaluation: &Evaluation) {
    let numbers = |runs: &[usize]| {
        let noun = if runs.len() == 1 { "run" } else { "runs" };
        format!("{noun} {}", runs.iter().map(|run| (run + 1).to_string()).collect::<Vec<_>>().join(", "))
    };
    let elsewhere: Vec<usize> =
        evaluation.outside.iter().copied().filter(|run| !evaluation.forbidden.contains(run)).collect();
    if !evaluation.forbidden.is_empty() {
        page.note(&format!("In a forbidden box: {}.", numbers(&evaluation.forbidden)));
    }
    if !elsewhere.is_empty() {
        page.note(&format!("Outside of the space, or off its levels: {}.", numbers(&elsewhere)));
    }
    if evaluation.precision.is_none() {
        page.note(
            "The runs do not determine the model: no prediction and no coefficient has a finite variance. On them:",
        );
        let parts = |alias: &Alias| alias.equals.iter().map(|(term, by)| format!("{by:.4} ({term})")).collect();
        let right = |parts: Vec<String>| if parts.is_empty() { "0".to_owned() } else { parts.join(" + ") };
        let items = evaluation.aliases.iter().map(|alias| format!("{} = {}", alias.term, right(parts(alias))));
        page.list(&items.collect::<Vec<String>>());
    }
}

fn plane(evaluation: &Evaluation, slice: &Slice) -> Landscape {
    let [a, b] = slice.factors;
    let (first, second) = (&evaluation.parameters[a], &evaluation.parameters[b]);
    let mut point = slice.through.clone();
    let rows = slice.levels.iter().zip(slice.variances.chunks(slice.levels.len()));
    let z = rows.map(|(y, row)| {
        let values = slice.levels.iter().zip(row).map(|(x, variance)| {
            (point[a], point[b]) = (*x, *y);
            if evaluation.forbids(&point) { f64::NAN } else { *variance }
        });
        values.collect()
    });
    let z: Vec<Vec<f64>> = z.collect();
    // The whole range: where a design predicts worst is what the picture is for.
    let finite = || z.iter().flatten().copied().filter(|value| value.is_finite());
    let (lowest, highest) = (finite().fold(f64::INFINITY, f64::min), finite().fold(0.0, f64::max));
    let z_axis = Axis::new("prediction variance / variance of a run", "1");
    let z_axis = if lowest < highest { z_axis.with_range(lowest, highest) } else { z_axis };
    let repeated: Vec<usize> = evaluation.replicates.iter().flatten().copied().collect();
    let points = |label: &str, wants_repeated: bool, fill: &'static str, radius_px: f64| {
        let chosen = evaluation.runs.iter().enumerate().filter(|(run, _)| repeated.contains(run) == wants_repeated);
        let points = chosen.map(|(_, run)| (first.natural(run[a]), second.natural(run[b]))).collect();
        Points { label: label.to_owned(), points, fill, radius_px }
    };
    let mut points = vec![points("run", false, "#ffffff", 5.0), points("runs at one point", true, "#e69f00", 7.0)];
    points.retain(|points| !points.points.is_empty());
    Landscape {
        title: "Prediction variance".to_owned(),
        x_axis: first.axis(),
        y_axis: second.axis(),
        z_axis,
        x: slice.levels.iter().map(|x| first.natural(*x)).collect(),
        y: slice.levels.iter().map(|y| second.natural(*y)).collect(),
        z,
        missing_label: "forbidden".to_owned(),
        points,
        verticals: Vec::new(),
        verticals_label: String::new(),
        paths: Vec::new(),
        minimum: None,
        minimum_label: String::new(),
    }
}

fn plane_caption(evaluation: &Evaluation, slice: &Slice) -> String {
    let held: Vec<String> = (0..evaluation.parameters.len())
        .filter(|factor| !slice.factors.contains(factor))
        .map(|factor| {
            let parameter = &evaluation.parameters[factor];
            format!("{} at {} {}", parameter.name, parameter.text(slice.through[factor]), parameter.unit)
        })
        .collect();
    let caption = "How well the design predicts where";
    match held.as_slice() {
        [] => format!("{caption}, and its runs."),
        held => format!("{caption}, on the plane with {}, and all runs seen from above.", held.join(", ")),
    }
}

fn fractions(precision: &Precision) -> String {
    let Fractions { fractions, variances } = &precision.fraction_of_space;
    let shares: Vec<f64> = fractions.iter().map(|fraction| 100.0 * fraction).collect();
    let series = vec![
        Series::line("variance not exceeded", &shares, variances),
        Series::line("mean", &[0.0, 100.0], &[precision.predictions.mean; 2]).dashed(),
    ];
    line_figure(&LineFigure {
        title: "How much of the space is predicted how well".to_owned(),
        x_axis: Axis::new("share of the space", "%"),
        panels: vec![Panel { x_axis: None, y_axis: Axis::new("prediction variance", "1"), series }],
        shaded: None,
    })
}

fn leverages(precision: &Precision) -> String {
    let inflations: Vec<f64> = precision.coefficients.iter().filter_map(|row| row.variance_inflation).collect();
    let panel = |axis: &str, quantity: &str, values: &[f64]| {
        let numbers: Vec<f64> = (1..=values.len()).map(|number| number as f64).collect();
        Panel {
            x_axis: Some(Axis::new(axis, "1").counting_to(values.len())),
            y_axis: Axis::new(quantity, "1"),
            series: vec![Series::line(quantity, &numbers, values)],
        }
    };
    let mut panels = vec![panel("run", "leverage", &precision.leverages)];
    if !inflations.is_empty() {
        panels.push(panel("term", "variance inflation", &inflations));
    }
    let title = "Leverage of the runs, inflation of the terms".to_owned();
    line_figure(&LineFigure { title, x_axis: Axis::new("", "1"), panels, shaded: None })
}

fn correlations(correlations: &Correlations) -> String {
    let n = correlations.terms.len();
    let numbers: Vec<f64> = (1..=n).map(|number| number as f64).collect();
    let values: Vec<f64> = correlations.values.iter().map(|value| value.map_or(f64::NAN, f64::abs)).collect();
    let axis = || Axis::new("term", "1").counting_to(n);
    cell_figure(&CellFigure {
        title: "Correlation of the terms over the runs".to_owned(),
        x_axis: axis(),
        y_axis: axis(),
        z_axis: Axis::new("magnitude of the correlation", "1").with_range(0.0, 1.0),
        panels: vec![CellPanel {
            title: String::new(),
            x: numbers.clone(),
            y: numbers,
            z: values.chunks(n).map(<[f64]>::to_vec).collect(),
            points: Vec::new(),
            minimum: None,
        }],
        missing_label: "a term does not vary over the runs".to_owned(),
        minimum_label: String::new(),
    })
}

fn correlations_caption(correlations: &Correlations) -> String {
    let numbered = correlations.terms.iter().enumerate().map(|(index, term)| format!("{} {term}", index + 1));
    let numbered: Vec<String> = numbered.collect();
    let n = correlations.terms.len();
    let pairs = (0..n).flat_map(|i| (i + 1..n).map(move |j| (i, j)));
    let valued = pairs.filter_map(|(i, j)| correlations.values[i * n + j].map(|value| (i, j, value)));
    let largest = valued.reduce(|a, b| if b.2.abs() > a.2.abs() { b } else { a });
    let largest = largest.map_or_else(String::new, |(i, j, value)| {
        format!(" The largest is {value:.4}, of {} and {}.", correlations.terms[i], correlations.terms[j])
    });
    format!("Terms that the runs tell apart badly are correlated.{largest} The terms: {}.", numbered.join("; "))
}

fn efficiencies(precision: &Precision) -> Table {
    let columns = [("criterion", ""), ("value", "1"), ("efficiency", "%"), ("over", "")];
    let mut table = Table::new(columns.map(|(name, unit)| Column::new(name, unit)).to_vec());
    for Efficiency { criterion, value, percent, over } in &precision.efficiencies {
        let over = over.clone().unwrap_or_default();
        table.push(vec![criterion.clone(), format!("{value:.5}"), format!("{percent:.2}"), over]);
    }
    table
}

fn coefficients(precision: &Precision) -> Table {
    let columns = [("number", "1"), ("term", ""), ("standard error", "1"), ("variance inflation", "1")];
    let mut table = Table::new(columns.map(|(name, unit)| Column::new(name, unit)).to_vec());
    let mut last = 0;
    for Coefficient { term, standard_error, variance_inflation } in &precision.coefficients {
        let mut cells = ["-".to_owned(), "-".to_owned()];
        if let Some(value) = variance_inflation {
            last += 1;
            cells = [last.to_string(), format!("{value:.4}")];
        }
        let [number, inflation] = cells;
        table.push(vec![number, term.clone(), format!("{standard_error:.4}"), inflation]);
    }
    table
}

fn runs(evaluation: &Evaluation) -> Table {
    let mut columns = vec![Column::new("run", "1")];
    columns.extend(evaluation.parameters.iter().map(|parameter| Column::new(&parameter.name, parameter.unit())));
    columns.extend(evaluation.precision.iter().map(|_| Column::new("leverage", "1")));
    let mut table = Table::new(columns);
    for (index, run) in evaluation.runs.iter().enumerate() {
        let mut row = vec![(index + 1).to_string()];
        row.extend(evaluation.parameters.iter().zip(run).map(|(parameter, x)| parameter.text(*x)));
        row.extend(evaluation.precision.iter().map(|precision| format!("{:.4}", precision.leverages[index])));
        table.push(row);
    }
    table
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
