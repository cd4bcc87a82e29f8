//! What a design is worth, ours or anybody's.

mod fraction;
mod sample;
mod slice;
mod table;
mod terms;

use serde::Serialize;

pub use fraction::FractionOfSpace;
pub use sample::Sampling;
use sample::sample;
pub use slice::VarianceSlice;
pub use terms::{Alias, Coefficient, Correlations};

use crate::ascent::climb;
use crate::products::Products;
use crate::same::groups;
use crate::shape::Shape;
use crate::{
    Criterion, Design, Efficiency, Error, Information, Model, Over, PredictionVariance, Space,
    confounded_terms_of_design,
};
use design_space::factor_names;

/// Settings of an evaluation.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
pub struct EvaluationSettings {
    /// Number of points that stand for the space where it is not taken whole.
    pub n_samples: usize,
    /// What is random in the sample follows from this.
    pub seed: u64,
    /// Names of the factors in the names of the terms; `x1`, `x2`, … where missing.
    pub factors: Vec<String>,
}

impl Default for EvaluationSettings {
    /// 10,000 points, seed 1, no names.
    fn default() -> Self {
        Self { n_samples: 10_000, seed: 1, factors: Vec::new() }
    }
}

/// What a design says about a model, and how well it predicts in a space. All variances are for unit variance of a run;
/// all coordinates are coded. It serializes, and [`Display`](std::fmt::Display) writes it as a table.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Evaluation {
    /// Names of the factors.
    pub factors: Vec<String>,
    /// Names of the terms of the model.
    pub terms: Vec<String>,
    /// Number of runs, N.
    pub n_runs: usize,
    /// The set that predictions are asked for in.
    pub over: Over,
    /// Where the runs go.
    pub degrees_of_freedom: DegreesOfFreedom,
    /// Groups of two or more runs at one point, by index.
    pub replicates: Vec<Vec<usize>>,
    /// Runs that do not belong to the space, by index: no fault of itself, but perhaps a mistake.
    pub outside: Vec<usize>,
    /// Those of them that lie in a forbidden box, by index.
    pub forbidden: Vec<usize>,
    /// Correlations of the terms over the runs.
    pub correlations: Correlations,
    /// Terms that the runs cannot tell from others; none if the runs determine the model.
    pub aliases: Vec<Alias>,
    /// What only runs that determine the model have.
    pub precision: Option<Precision>,
}

/// How the N runs divide: model + lack of fit + pure error = N.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct DegreesOfFreedom {
    /// Independent terms, the constant among them: the rank of R.
    pub model: usize,
    /// Distinct points beyond these: to see that the model does not fit.
    pub lack_of_fit: usize,
    /// Runs beyond the distinct points: to see the noise whatever the model.
    pub pure_error: usize,
}

/// How precisely a design determines the coefficients and the predictions.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Precision {
    /// By every criterion, in the order of [`Criterion::ALL`].
    pub efficiencies: Vec<Efficiency>,
    /// One per term.
    pub coefficients: Vec<Coefficient>,
    /// Prediction variance at each run: the diagonal of R (R'R)⁻¹ R'. Leverages sum to the number of terms; at 1
    /// the model goes through the run, whatever was measured.
    pub leverages: Vec<f64>,
    /// Extremes and mean of the prediction variance over the space.
    pub predictions: Predictions,
    /// The prediction variance over the space as a curve.
    pub fraction_of_space: FractionOfSpace,
}

/// Extremes and mean of the prediction variance over a space.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Predictions {
    /// The largest, as for G.
    pub maximum: f64,
    /// Where it is, coded.
    pub maximum_at: Vec<f64>,
    /// The smallest: over all points of a list or a small grid, else by descent from the best points of the sample.
    pub minimum: f64,
    /// Where it is, coded.
    pub minimum_at: Vec<f64>,
    /// The mean, as for I: exact, not of the sample.
    pub mean: f64,
}

/// Number of points of the sample from which a descent starts.
const DESCENTS: usize = 16;

/// Evaluates any design; runs may lie outside the space, and runs that do not determine the model are told with the
/// terms that they confound instead of an error.
///
/// ```
/// use doe::{Design, EvaluationSettings, Model, Space, evaluate};
/// let factorial = Design::from_runs(&[[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]])?;
/// let evaluation = evaluate(&Model::linear(2)?, &Space::cube(2)?, &factorial, &EvaluationSettings::default())?;
/// let precision = evaluation.precision.expect("a factorial determines a linear model");
/// assert!(precision.leverages.iter().all(|leverage| (leverage - 0.75).abs() < 1e-12));
/// assert!((precision.coefficients[1].variance_inflation.unwrap_or(0.0) - 1.0).abs() < 1e-12);
///
/// // Squares are the constant on two levels.
/// let evaluation = evaluate(&Model::quadratic(2)?, &Space::cube(2)?, &factorial, &EvaluationSettings::default())?;
/// assert!(evaluation.precision.is_none());
/// assert_eq!(evaluation.aliases[0].to_string(), "`x1^2` = 1");
/// # Ok::<(), doe::Error>(())
/// ```
///
/// # Errors
///
/// [`Error::FactorMismatch`] if model, space and design differ in the number of factors, [`Error::Count`] for the number
/// of samples, [`Error::Singular`] if the runs determine the model, but not in double precision.
pub fn evaluate(
    model: &Model,
    space: &Space,
    design: &Design,
    settings: &EvaluationSettings,
) -> Result<Evaluation, Error> {
    let (expected, found) = (model.n_factors(), space.n_factors());
    if expected != found {
        return Err(Error::FactorMismatch { what: "the space", expected, found });
    }
    let named: Vec<&str> = settings.factors.iter().map(String::as_str).collect();
    let terms = model.term_names(&named);
    let confounded = confounded_terms_of_design(model, design)?;
    let replicates = groups(design.n_factors(), design.coordinates());
    let n_distinct = design.n_runs() - replicates.iter().map(|group| group.len() - 1).sum::<usize>();
    let outside: Vec<usize> =
        design.runs().enumerate().filter(|(_, run)| !space.contains(run)).map(|(index, _)| index).collect();
    let lies_in_box = |&index: &usize| match space.shape() {
        Shape::Box(shape) => shape.forbids(&design.coordinates()[index * design.n_factors()..][..design.n_factors()]),
        Shape::List(_) => false,
    };
    let rank = model.n_terms() - confounded.len();
    let precision = if confounded.is_empty() { Some(precision(model, space, design, settings, &terms)?) } else { None };
    let own = factor_names(model.n_factors());
    Ok(Evaluation {
        factors: (0..model.n_factors())
            .map(|j| settings.factors.get(j).cloned().unwrap_or_else(|| own[j].clone()))
            .collect(),
        n_runs: design.n_runs(),
        over: space.over(),
        degrees_of_freedom: DegreesOfFreedom {
            model: rank,
            lack_of_fit: n_distinct.saturating_sub(rank),
            pure_error: design.n_runs() - n_distinct,
        },
        replicates,
        forbidden: outside.iter().copied().filter(lies_in_box).collect(),
        outside,
        correlations: terms::correlations(model, design, &terms)?,
        aliases: confounded.iter().map(|confounding| Alias::of(confounding, &terms)).collect(),
        precision,
        terms,
    })
}

fn precision(
    model: &Model,
    space: &Space,
    design: &Design,
    settings: &EvaluationSettings,
    terms: &[String],
) -> Result<Precision, Error> {
    let information = Information::of(model, design)?;
    let variance = PredictionVariance::from_information(model, &information)?;
    let (points, sampling) = sample(space, settings.n_samples, settings.seed)?;
    let mut values = vec![0.0; points.len() / model.n_factors()];
    variance.fill_values(&points, &mut values);
    let efficiencies: Vec<Efficiency> =
        Criterion::ALL.iter().map(|criterion| criterion.efficiency(model, space, design)).collect::<Result<_, _>>()?;
    let maximum = variance.maximum(space)?;
    let (minimum_at, minimum) = minimum(model, space, &information, &points, &values);
    let mean = efficiencies.iter().find(|efficiency| efficiency.criterion == Criterion::I);
    let mean = mean.map_or(f64::NAN, |efficiency| efficiency.value);
    Ok(Precision {
        coefficients: terms::coefficients(model, design, &information, terms)?,
        leverages: information.leverages(model, design)?,
        fraction_of_space: FractionOfSpace::of(values, sampling, maximum.value),
        predictions: Predictions { maximum: maximum.value, maximum_at: maximum.at, minimum, minimum_at, mean },
        efficiencies,
    })
}

/// The smallest value over the sample; in a box every one of the best points then climbs on −v.
fn minimum(model: &Model, space: &Space, information: &Information, points: &[f64], values: &[f64]) -> (Vec<f64>, f64) {
    let k = model.n_factors();
    let point = |index: usize| points[index * k..][..k].to_vec();
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]).then(a.cmp(&b)));
    let best = (point(order[0]), values[order[0]]);
    match space.shape() {
        Shape::List(_) => best,
        Shape::Box(shape) => {
            let negative: Vec<f64> = information.inverse().iter().map(|value| -value).collect();
            let negative = PredictionVariance::with_products(std::sync::Arc::new(Products::of(model)), &negative);
            let descents = order.iter().take(DESCENTS).map(|&start| {
                let (at, value) = climb(&negative, shape, &point(start));
                (at, -value)
            });
            descents.fold(best, |a, b| if b.1 < a.1 { b } else { a })
        }
    }
}
