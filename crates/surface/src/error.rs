//! What can be wrong with data, a surface or a request to it.

use doe::Confounding;

/// Every fault of this crate, each naming the field, the value and what was allowed.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// Too few or too many of something.
    #[error("number of {name}: {found}, expected {}", count_range(*least, *most))]
    Count {
        /// Of what.
        name: &'static str,
        /// The number given.
        found: usize,
        /// The smallest number allowed.
        least: usize,
        /// The largest number allowed; `usize::MAX` if there is no limit.
        most: usize,
    },
    /// Flat coordinates that do not fill whole points.
    #[error("{n_coordinates} coordinates do not fill points of {n_factors} coordinates each")]
    RaggedPoints {
        /// Number of factors.
        n_factors: usize,
        /// Number of coordinates given.
        n_coordinates: usize,
    },
    /// A list of another length than something it belongs to.
    #[error("number of {name}: {found}, expected {expected}")]
    Length {
        /// Of what.
        name: &'static str,
        /// The length needed.
        expected: usize,
        /// The length given.
        found: usize,
    },
    /// Two things that must agree in their number of factors.
    #[error("number of factors of {what}: {found}, expected {expected}")]
    FactorMismatch {
        /// What does not fit.
        what: &'static str,
        /// Number of factors needed.
        expected: usize,
        /// Number of factors found.
        found: usize,
    },
    /// A coordinate that is NaN, infinite or of a datum and too large to be squared.
    #[error(
        "coordinate {factor} of point {point} is {value:?}, expected a finite number of magnitude at most {most:e}"
    )]
    Coordinate {
        /// Index of the point.
        point: usize,
        /// Index of the coordinate.
        factor: usize,
        /// The value given.
        value: f64,
        /// The largest magnitude allowed.
        most: f64,
    },
    /// A value at a data point that is NaN, infinite or too large to be squared.
    #[error("the value at point {point} is {value:?}, expected a finite number of magnitude at most {most:e}")]
    Value {
        /// Index of the point.
        point: usize,
        /// The value given.
        value: f64,
        /// The largest magnitude allowed.
        most: f64,
    },
    /// A weight that is negative, not finite, or so small or large that a product with it is not a number.
    #[error("the weight of point {point} is {value:?}, expected 0 (not used) or {least:e} to {most:e}")]
    Weight {
        /// Index of the point.
        point: usize,
        /// The weight given.
        value: f64,
        /// The smallest weight above zero allowed.
        least: f64,
        /// The largest weight allowed.
        most: f64,
    },
    /// All weights are zero.
    #[error("all {n_points} weights are 0, expected at least one above")]
    NoWeight {
        /// Number of points.
        n_points: usize,
    },
    /// A parameter of a surface outside what is allowed.
    #[error("`{name}` is {value:?}, expected {expected}")]
    Parameter {
        /// Name of the parameter.
        name: &'static str,
        /// The value given.
        value: f64,
        /// What is expected.
        expected: &'static str,
    },
    /// Fewer points with a weight than the model has terms.
    #[error("{n_points} points of positive weight cannot determine {n_terms} terms, expected at least {n_terms}")]
    TooFewPoints {
        /// Number of points with a weight above zero.
        n_points: usize,
        /// Number of terms.
        n_terms: usize,
    },
    /// Terms that are linear combinations of others on the data.
    #[error("the data cannot tell the terms apart: {list}", list = confounding_list(names, confounded))]
    Confounded {
        /// Name of every term of the model.
        names: Vec<String>,
        /// Each term that is a combination of earlier ones.
        confounded: Vec<Confounding>,
    },
    /// A term of the model that is too large at a data point to be squared.
    #[error(
        "the term `{term}` is {value:?} at point {point}, expected a magnitude of at most {most:e}: code the coordinates"
    )]
    Regressor {
        /// Index of the point.
        point: usize,
        /// Name of the term.
        term: String,
        /// Its value there.
        value: f64,
        /// The largest magnitude allowed.
        most: f64,
    },
    /// Weighted regressors so close to dependent that their coefficients would be rounding.
    #[error(
        "the weighted regressors are dependent in double precision: a pivot of {ratio:e} of the largest, expected at least {least:e}; \
         the unweighted points do tell the terms apart to within 1e-9, so look at the spread of the weights"
    )]
    IllConditioned {
        /// Smallest over largest diagonal element of the triangular factor.
        ratio: f64,
        /// The smallest ratio accepted.
        least: f64,
    },
    /// A point without which the rest cannot determine the model, so that it has no leave-one-out residual.
    #[error("the leverage of point {point} is 1: without it the other points cannot determine the model")]
    LeverageOne {
        /// Index of the point.
        point: usize,
    },
    /// Too few different points of positive weight.
    #[error("{found} different points of positive weight, expected at least {least} to {what}")]
    TooFewSites {
        /// Number of different points with a weight above zero.
        found: usize,
        /// The smallest number allowed.
        least: usize,
        /// What they are needed for.
        what: &'static str,
    },
    /// As many terms as points, so that nothing tells the errors of the points.
    #[error(
        "{n_points} points of positive weight and {n_terms} terms leave no degree of freedom, expected more points than terms"
    )]
    NoDegreesOfFreedom {
        /// Number of points with a weight above zero.
        n_points: usize,
        /// Number of terms.
        n_terms: usize,
    },
    /// No degrees of freedom for pure error or for lack of fit.
    #[error(
        "{n_points} points at {n_sites} places and {n_terms} terms leave no test for lack of fit, expected more points \
         than places (repeats) and more places than terms"
    )]
    NoLackOfFitTest {
        /// Number of points with a weight above zero.
        n_points: usize,
        /// Number of different points among them.
        n_sites: usize,
        /// Number of terms.
        n_terms: usize,
    },
    /// A range of points that ends behind the last.
    #[error("{n_wanted} points from index {first}, expected to end at {n_points} at most")]
    NoSuchPoints {
        /// Index of the first point asked for.
        first: u64,
        /// Number of points asked for.
        n_wanted: usize,
        /// Number of points there are.
        n_points: u64,
    },
    /// An axis without levels, or a list of candidates where a grid is needed.
    #[error("{what} has no levels, expected a grid")]
    NotAGrid {
        /// `"a list of candidates"` or `"a continuous axis"`.
        what: &'static str,
    },
    /// A grid with more points than a 64-bit index can count.
    #[error("a grid of {n_factors} axes has more than 2^64 - 1 points, expected fewer levels")]
    GridTooLarge {
        /// Number of axes.
        n_factors: usize,
    },
    /// A model that cannot be made or used.
    #[error(transparent)]
    Design(#[from] doe::Error),
    /// A model that cannot be used.
    #[error(transparent)]
    Model(#[from] design_space::Error),
}

fn count_range(least: usize, most: usize) -> String {
    if most == usize::MAX { format!("at least {least}") } else { format!("{least} to {most}") }
}

/// Dependences with the names of the terms: `x1^2 = 1; x2^2 = 0.5 x1 + 0.25`.
fn confounding_list(names: &[String], confounded: &[Confounding]) -> String {
    let name = |term: usize| names.get(term).map_or("?", String::as_str);
    let product = |coefficient: f64, name: &str| {
        // Six decimals, without the zeros at their end.
        let rounded = format!("{coefficient:.6}");
        let number = rounded.trim_end_matches('0').trim_end_matches('.');
        match (number, name) {
            (number, "1") => number.to_owned(),
            ("1", name) => name.to_owned(),
            (number, name) => format!("{number} {name}"),
        }
    };
    let written = |confounding: &Confounding| {
        let parts = confounding.equals.iter().enumerate().map(|(position, &(term, coefficient))| {
            let sign = match (position, coefficient < 0.0) {
                (0, false) => "",
                (0, true) => "-",
                (_, false) => " + ",
                (_, true) => " - ",
            };
            format!("{sign}{}", product(coefficient.abs(), name(term)))
        });
        let right: String = parts.collect();
        format!("{} = {}", name(confounding.term), if right.is_empty() { "0" } else { &right })
    };
    confounded.iter().map(written).collect::<Vec<_>>().join("; ")
}
