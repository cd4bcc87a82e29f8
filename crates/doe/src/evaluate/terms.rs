//! How far the terms of a model can be told apart by the runs.

use serde::Serialize;

use crate::wording::combination;
use crate::{Confounding, Design, Error, Information, Model};

/// What the runs say about one coefficient.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Coefficient {
    /// The term.
    pub term: String,
    /// Standard error for unit standard deviation of a run: the root of the diagonal element of (R'R)⁻¹.
    pub standard_error: f64,
    /// Variance inflation factor: none for the constant.
    ///
    /// With R² of a regression of the term on all others, 1/(1 − R²); equal to the term's diagonal element of (R'R)⁻¹
    /// times the sum of squares of the term over the runs, about its mean if the model has a constant, about zero if it
    /// has none. 1 is a term unrelated to all others. Squares and products are those of coded factors: with
    /// another center they inflate differently, though every prediction stays the same.
    pub variance_inflation: Option<f64>,
}

pub(super) fn coefficients(
    model: &Model,
    design: &Design,
    information: &Information,
    names: &[String],
) -> Result<Vec<Coefficient>, Error> {
    let columns = columns(model, design)?;
    let has_constant = model.terms().iter().any(|term| term.degree() == 0);
    let of = |(j, name): (usize, &String)| {
        let variance = information.inverse()[j * model.n_terms() + j];
        let center = if has_constant { mean(&columns[j]) } else { 0.0 };
        let squares: f64 = columns[j].iter().map(|value| (value - center).powi(2)).sum();
        let variance_inflation = (model.terms()[j].degree() > 0).then_some(variance * squares);
        Coefficient { term: name.clone(), standard_error: variance.sqrt(), variance_inflation }
    };
    Ok(names.iter().enumerate().map(of).collect())
}

/// Correlation of each pair of terms over the runs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Correlations {
    /// The terms, without the constant.
    pub terms: Vec<String>,
    /// Row by row, −1 to 1; none where a term does not vary over the runs.
    pub values: Vec<Option<f64>>,
}

impl Correlations {
    /// Row and column of the pair of terms with the largest correlation in magnitude, and that correlation; the first of
    /// equals.
    #[must_use]
    pub fn largest(&self) -> Option<(usize, usize, f64)> {
        let n = self.terms.len();
        let pairs = (0..n).flat_map(|i| (i + 1..n).map(move |j| (i, j)));
        let valued = pairs.filter_map(|(i, j)| self.values[i * n + j].map(|value| (i, j, value)));
        valued.reduce(|a, b| if b.2.abs() > a.2.abs() { b } else { a })
    }
}

pub(super) fn correlations(model: &Model, design: &Design, names: &[String]) -> Result<Correlations, Error> {
    let kept: Vec<usize> = (0..model.n_terms()).filter(|&j| model.terms()[j].degree() > 0).collect();
    let columns = columns(model, design)?;
    let centered: Vec<Vec<f64>> = kept
        .iter()
        .map(|&j| {
            let mean = mean(&columns[j]);
            columns[j].iter().map(|value| value - mean).collect()
        })
        .collect();
    // A column whose spread is rounding does not vary.
    let varies: Vec<bool> = kept.iter().zip(&centered).map(|(&j, c)| norm(c) > 1e-12 * norm(&columns[j])).collect();
    let n = kept.len();
    let value = |(i, j): (usize, usize)| {
        let product: f64 = centered[i].iter().zip(&centered[j]).map(|(a, b)| a * b).sum();
        (varies[i] && varies[j]).then(|| (product / (norm(&centered[i]) * norm(&centered[j]))).clamp(-1.0, 1.0))
    };
    let values = (0..n).flat_map(|i| (0..n).map(move |j| (i, j))).map(value).collect();
    Ok(Correlations { terms: kept.iter().map(|&j| names[j].clone()).collect(), values })
}

/// A term that the runs cannot tell from others, by name.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Alias {
    /// The dependent term.
    pub term: String,
    /// The earlier terms whose combination it equals on every run, with coefficients; empty if it is zero on every run.
    pub equals: Vec<(String, f64)>,
}

impl Alias {
    pub(super) fn of(confounding: &Confounding, names: &[String]) -> Self {
        let equals = confounding.equals.iter().map(|&(term, coefficient)| (names[term].clone(), coefficient));
        Self { term: names[confounding.term].clone(), equals: equals.collect() }
    }
}

impl std::fmt::Display for Alias {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let parts = self.equals.iter().map(|(name, coefficient)| (name.as_str(), *coefficient));
        write!(formatter, "`{}` = {}", self.term, combination(parts))
    }
}

fn columns(model: &Model, design: &Design) -> Result<Vec<Vec<f64>>, Error> {
    let rows: Vec<Vec<f64>> = design.runs().map(|run| model.regressor(run)).collect::<Result<_, _>>()?;
    Ok((0..model.n_terms()).map(|j| rows.iter().map(|row| row[j]).collect()).collect())
}

fn mean(column: &[f64]) -> f64 {
    column.iter().sum::<f64>() / column.len() as f64
}

fn norm(column: &[f64]) -> f64 {
    column.iter().map(|value| value * value).sum::<f64>().sqrt()
}
