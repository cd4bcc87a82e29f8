//! An evaluation of a design, as the JSON of doe's example `evaluate_design` has it, checked.

use anyhow::{Result, ensure};
use serde::{Deserialize, Deserializer};

/// The part of an evaluation that the page shows; variances are for unit variance of a run.
#[derive(Deserialize)]
pub(super) struct Evaluation {
    pub(super) terms: Vec<String>,
    pub(super) over: String,
    pub(super) degrees_of_freedom: DegreesOfFreedom,
    pub(super) replicates: Vec<Vec<usize>>,
    pub(super) outside: Vec<usize>,
    pub(super) forbidden: Vec<usize>,
    pub(super) correlations: Correlations,
    pub(super) aliases: Vec<Alias>,
    #[serde(deserialize_with = "null_or")]
    pub(super) precision: Option<Precision>,
    pub(super) parameters: Vec<Parameter>,
    /// Coded, as all coordinates.
    pub(super) runs: Vec<Vec<f64>>,
    pub(super) forbidden_boxes: Vec<ForbiddenBox>,
    #[serde(deserialize_with = "null_or")]
    pub(super) variance_slice: Option<Slice>,
}

#[derive(Deserialize)]
pub(super) struct DegreesOfFreedom {
    pub(super) model: usize,
    pub(super) lack_of_fit: usize,
    pub(super) pure_error: usize,
}

#[derive(Deserialize)]
pub(super) struct Correlations {
    pub(super) terms: Vec<String>,
    pub(super) values: Vec<Option<f64>>,
}

#[derive(Deserialize)]
pub(super) struct Alias {
    pub(super) term: String,
    pub(super) equals: Vec<(String, f64)>,
}

#[derive(Deserialize)]
pub(super) struct Precision {
    pub(super) efficiencies: Vec<Efficiency>,
    pub(super) coefficients: Vec<Coefficient>,
    pub(super) leverages: Vec<f64>,
    pub(super) predictions: Predictions,
    pub(super) fraction_of_space: Fractions,
}

#[derive(Deserialize)]
pub(super) struct Efficiency {
    pub(super) criterion: String,
    pub(super) value: f64,
    pub(super) percent: f64,
    #[serde(deserialize_with = "null_or")]
    pub(super) over: Option<String>,
}

#[derive(Deserialize)]
pub(super) struct Coefficient {
    pub(super) term: String,
    pub(super) standard_error: f64,
    #[serde(deserialize_with = "null_or")]
    pub(super) variance_inflation: Option<f64>,
}

#[derive(Deserialize)]
pub(super) struct Predictions {
    pub(super) maximum: f64,
    pub(super) maximum_at: Vec<f64>,
    pub(super) minimum: f64,
    pub(super) mean: f64,
}

#[derive(Deserialize)]
pub(super) struct Fractions {
    pub(super) fractions: Vec<f64>,
    pub(super) variances: Vec<f64>,
}

#[derive(Deserialize)]
pub(super) struct Parameter {
    pub(super) name: String,
    pub(super) unit: String,
    pub(super) lower: f64,
    pub(super) upper: f64,
}

#[derive(Deserialize)]
pub(super) struct ForbiddenBox {
    pub(super) ranges: Vec<Option<[f64; 2]>>,
}

#[derive(Deserialize)]
pub(super) struct Slice {
    pub(super) factors: [usize; 2],
    pub(super) through: Vec<f64>,
    pub(super) levels: Vec<f64>,
    pub(super) variances: Vec<f64>,
}

/// A key that must be there, though perhaps with `null`.
fn null_or<'de, D: Deserializer<'de>, T: Deserialize<'de>>(deserializer: D) -> Result<Option<T>, D::Error> {
    Option::deserialize(deserializer)
}

impl Parameter {
    pub(super) fn natural(&self, coded: f64) -> f64 {
        0.5 * (self.lower * (1.0 - coded) + self.upper * (1.0 + coded))
    }

    /// To a ten-thousandth of the range.
    pub(super) fn text(&self, coded: f64) -> String {
        let decimals = (4.0 - (self.upper - self.lower).log10().ceil()).clamp(0.0, 12.0) as usize;
        let text = format!("{:.decimals$}", self.natural(coded));
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
    }

    pub(super) fn unit(&self) -> &str {
        if self.unit.is_empty() { "1" } else { &self.unit }
    }
}

fn check_length(what: &str, found: usize, expected: usize) -> Result<()> {
    ensure!(found == expected, "`{what}` is of length {found}, expected {expected}");
    Ok(())
}

impl Evaluation {
    /// Whether all lists are as long as they must be.
    pub(super) fn check(&self) -> Result<()> {
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
    pub(super) fn forbids(&self, point: &[f64]) -> bool {
        let meets = |(range, x): (&Option<[f64; 2]>, &f64)| {
            range.is_none_or(|[lower, upper]| (lower <= -1.0 || lower < *x) && (upper >= 1.0 || *x < upper))
        };
        self.forbidden_boxes.iter().any(|one| one.ranges.iter().zip(point).all(meets))
    }

    /// A coded point in units.
    pub(super) fn place(&self, point: &[f64]) -> String {
        let text = |(parameter, x): (&Parameter, &f64)| {
            format!("{} {} {}", parameter.name, parameter.text(*x), parameter.unit).trim_end().to_owned()
        };
        self.parameters.iter().zip(point).map(text).collect::<Vec<_>>().join(", ")
    }
}
