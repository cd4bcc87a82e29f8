//! Which terms a design or a space cannot tell apart.

use faer::Mat;
use rand::{RngExt as _, SeedableRng};
use rand_pcg::Pcg64;

use crate::measure::Measure;
use crate::shape::Shape;
use crate::{Confounding, Design, Error, Model, Space, Term};

/// A part of a column below this fraction of its length counts as nothing.
const DEPENDENT: f64 = 1e-9;
/// A coefficient below this fraction of the largest is not listed.
const LISTED: f64 = 1e-6;

/// The terms that a space cannot tell from earlier ones, wherever its points are run; none if it supports the model.
///
/// A list is looked at as a whole, a box in a sample of its allowed points large enough to show every dependence.
///
/// ```
/// use doe::{Model, Space};
/// // On two levels the square of a factor is the constant.
/// let confounded = doe::confounded_terms(&Model::additive_quadratic(2)?, &Space::grid(&[2, 3])?)?;
/// assert_eq!(confounded.len(), 1);
/// assert_eq!(confounded[0].term, 3);
/// assert_eq!(confounded[0].to_string(), "`x1^2` = 1");
/// # Ok::<(), doe::Error>(())
/// ```
///
/// # Errors
///
/// [`Error::FactorMismatch`].
pub fn confounded_terms(model: &Model, space: &Space) -> Result<Vec<Confounding>, Error> {
    let (expected, found) = (model.n_factors(), space.n_factors());
    if expected != found {
        return Err(Error::FactorMismatch { what: "the space", expected, found });
    }
    Ok(match space.shape() {
        Shape::List(list) => {
            let points: Vec<&[f64]> = list.points().collect();
            if are_surely_independent(model, &points) {
                return Ok(Vec::new());
            }
            dependent(model, points.into_iter())
        }
        Shape::Box(shape) => {
            let mut generator = Pcg64::seed_from_u64(1);
            let measure = Measure::of(shape);
            let points: Vec<Vec<f64>> =
                (0..100 + 30 * model.n_terms()).map(|_| measure.sample(&mut generator)).collect();
            dependent(model, points.iter().map(Vec::as_slice))
        }
    })
}

/// The terms that the runs of a design cannot tell from earlier ones.
///
/// # Errors
///
/// [`Error::FactorMismatch`].
pub fn confounded_terms_of_design(model: &Model, design: &Design) -> Result<Vec<Confounding>, Error> {
    let (expected, found) = (model.n_factors(), design.n_factors());
    if expected != found {
        return Err(Error::FactorMismatch { what: "the design", expected, found });
    }
    Ok(dependent(model, design.runs()))
}

/// Nothing if the space supports the model.
pub(crate) fn check_support(model: &Model, space: &Space) -> Result<(), Error> {
    let confounded = confounded_terms(model, space)?;
    if confounded.is_empty() { Ok(()) } else { Err(Error::Confounded { what: "space", confounded }) }
}

/// Whether some of many points already show that no term depends on others over all of them.
///
/// What is left of a column beside all others, by least squares, is no shorter over all points than over some, so it need only be
/// long enough over these.
fn are_surely_independent(model: &Model, points: &[&[f64]]) -> bool {
    let n_some = 100 + 30 * model.n_terms();
    if points.len() < 4 * n_some {
        return false;
    }
    let mut generator = Pcg64::seed_from_u64(1);
    let some: Vec<&[f64]> = (0..n_some).map(|_| points[generator.random_range(0..points.len())]).collect();
    let columns = triangle(model, some.into_iter());
    let largest = points.iter().copied().flatten().fold(1.0_f64, |largest, x| largest.max(x.abs()));
    let longest = |term: &Term| largest.powf(f64::from(term.degree())) * (points.len() as f64).sqrt();
    let n_rows = columns.first().map_or(0, Vec::len);
    // The triangle's diagonal is what is left beside the columns before.
    n_rows == model.n_terms()
        && model.terms().iter().enumerate().all(|(j, term)| columns[j][j].abs() > DEPENDENT * longest(term))
}

/// The triangular factor of all regressors has the same dependences as the regressors, in p rows; blocks of points
/// are folded into it one after the other, so a long list costs no memory.
fn dependent<'a>(model: &Model, points: impl Iterator<Item = &'a [f64]>) -> Vec<Confounding> {
    in_order(&triangle(model, points), &model.term_names(&[]))
}

/// Its columns.
fn triangle<'a>(model: &Model, points: impl Iterator<Item = &'a [f64]>) -> Vec<Vec<f64>> {
    const BLOCK: usize = 512;
    let p = model.n_terms();
    let mut rows: Vec<f64> = Vec::with_capacity((BLOCK + p) * p);
    let mut regressor = vec![0.0; p];
    let mut pending = 0;
    for point in points {
        model.fill_regressor(point, &mut regressor);
        rows.extend_from_slice(&regressor);
        pending += 1;
        if pending == BLOCK {
            fold(&mut rows, p);
            pending = 0;
        }
    }
    fold(&mut rows, p);
    let n_rows = rows.len() / p;
    (0..p).map(|j| (0..n_rows).map(|i| rows[i * p + j]).collect()).collect()
}

/// Replaces rows by the triangular factor of their QR factorization.
fn fold(rows: &mut Vec<f64>, p: usize) {
    let matrix = Mat::from_fn(rows.len() / p, p, |i, j| rows[i * p + j]);
    let factorization = matrix.qr();
    let triangle = factorization.thin_R();
    rows.clear();
    rows.extend((0..triangle.nrows()).flat_map(|i| (0..p).map(move |j| if j < i { 0.0 } else { triangle[(i, j)] })));
}

/// Gram-Schmidt in the order of the columns, orthogonalized twice, each dependent column expressed by the kept ones.
fn in_order(columns: &[Vec<f64>], names: &[String]) -> Vec<Confounding> {
    // Per kept column: its index, its unit direction, and its components along the directions before and its own.
    let mut kept: Vec<(usize, Vec<f64>, Vec<f64>)> = Vec::new();
    let mut confounded = Vec::new();
    for (term, column) in columns.iter().enumerate() {
        let length = norm(column);
        let mut rest = column.clone();
        let mut components = vec![0.0; kept.len()];
        for _ in 0..2 {
            for (component, (_, direction, _)) in components.iter_mut().zip(&kept) {
                let along: f64 = rest.iter().zip(direction).map(|(a, b)| a * b).sum();
                *component += along;
                rest.iter_mut().zip(direction).for_each(|(a, b)| *a -= along * b);
            }
        }
        let left = norm(&rest);
        if left > DEPENDENT * length {
            rest.iter_mut().for_each(|value| *value /= left);
            components.push(left);
            kept.push((term, rest, components));
            continue;
        }
        // Back substitution: the components in terms of the kept columns themselves.
        let mut coefficients = components;
        for k in (0..kept.len()).rev() {
            let row = &kept[k].2;
            coefficients[k] /= row[k];
            let coefficient = coefficients[k];
            coefficients[..k].iter_mut().zip(row).for_each(|(value, r)| *value -= coefficient * r);
        }
        let sized = |k: usize| coefficients[k].abs() * norm(&columns[kept[k].0]);
        let largest = (0..kept.len()).map(sized).fold(0.0, f64::max);
        let listed = (0..kept.len()).filter(|&k| length > 0.0 && sized(k) > LISTED * largest);
        let equals: Vec<(usize, f64)> = listed.map(|k| (kept[k].0, coefficients[k])).collect();
        let equal_names = equals.iter().map(|&(term, _)| names[term].clone()).collect();
        confounded.push(Confounding { term, name: names[term].clone(), equals, equal_names });
    }
    confounded
}

fn norm(column: &[f64]) -> f64 {
    column.iter().map(|value| value * value).sum::<f64>().sqrt()
}
