//! The largest prediction variance over a space.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::ascent::{best_level, climb};
use crate::lattice::{Lattice, level_values};
use crate::nested::{MOST_STORED, Nested};
use crate::shape::{BoxShape, List, Shape};
use crate::{Error, Over, PredictionVariance, Space};

/// The largest prediction variance, where it is, over which set and how it was found.
///
/// Over a continuous box v is a polynomial: every local maximum of a lattice is improved coordinate by coordinate,
/// each time to the maximum uphill of the polynomial of one variable, until nothing improves.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Maximum {
    /// v there, for unit variance of a run.
    pub value: f64,
    /// The coded point.
    pub at: Vec<f64>,
    /// The set that was maximized over.
    pub over: Over,
    /// How.
    pub method: Method,
}

/// How a maximum was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Method {
    /// Every point was looked at.
    Scan {
        /// How many.
        n_points: u64,
    },
    /// By ascent from the local maxima of a lattice.
    Ascent {
        /// Number of lattice points looked at.
        n_lattice: usize,
        /// Number of ascents.
        n_starts: usize,
    },
}

impl Maximum {
    /// Grids up to this many points are looked at point by point.
    pub const MOST_SCANNED: u64 = 50_000_000;
}

/// Largest number of lattice points of a search for maxima.
const LATTICE: usize = 80_000;
/// Ascents start from lattice maxima above this fraction of the largest.
const PROMISING: f64 = 0.5;
/// And from this many at most.
const MOST_STARTS: usize = 400;

impl PredictionVariance {
    /// The largest v over a space, and where: over every point of a list or of a grid up to
    /// [`Maximum::MOST_SCANNED`] points, else by ascent from every local maximum of a lattice; see [`Maximum`].
    ///
    /// # Errors
    ///
    /// [`Error::FactorMismatch`].
    pub fn maximum(&self, space: &Space) -> Result<Maximum, Error> {
        let (expected, found) = (self.n_factors(), space.n_factors());
        if expected != found {
            return Err(Error::FactorMismatch { what: "the space", expected, found });
        }
        Ok(over(self, space))
    }
}

fn over(variance: &PredictionVariance, space: &Space) -> Maximum {
    let over = space.over();
    match space.shape() {
        Shape::List(list) => {
            let (at, value) = scan_list(variance, list);
            let method = Method::Scan { n_points: list.n_points() as u64 };
            Maximum { value, at: list.point(at).to_vec(), over, method }
        }
        Shape::Box(shape) => match space.n_points() {
            Some(n_points) if n_points <= Maximum::MOST_SCANNED => {
                let (at, value) = scan_grid(variance, shape);
                Maximum { value, at, over, method: Method::Scan { n_points } }
            }
            _ => {
                let (at, value, method) = ascents(variance, shape, LATTICE, &|| false);
                Maximum { value, at, over, method }
            }
        },
    }
}

/// The highest maximum from a lattice of moderate size, for use within a search; once `is_over` says so no further ascent
/// begins, and points of the lattice count as they are.
pub(crate) fn highest(
    variance: &PredictionVariance,
    shape: &BoxShape,
    is_over: &(dyn Fn() -> bool + Sync),
) -> (Vec<f64>, f64) {
    let (at, value, _) = ascents(variance, shape, LATTICE / 8, is_over);
    (at, value)
}

/// As [`highest`], from as many points as [`PredictionVariance::maximum`] takes.
pub(crate) fn highest_as_judged(
    variance: &PredictionVariance,
    shape: &BoxShape,
    is_over: &(dyn Fn() -> bool + Sync),
) -> (Vec<f64>, f64) {
    let (at, value, _) = ascents(variance, shape, LATTICE, is_over);
    (at, value)
}

fn ascents(
    variance: &PredictionVariance,
    shape: &BoxShape,
    most: usize,
    is_over: &(dyn Fn() -> bool + Sync),
) -> (Vec<f64>, f64, Method) {
    let lattice = Lattice::of(shape, most, |axis| variance.is_convex_along(axis));
    let values = lattice.values(variance);
    let highest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let starts = lattice.local_maxima(&values, PROMISING * highest, MOST_STARTS);
    let method = Method::Ascent { n_lattice: lattice.n_points(), n_starts: starts.len() };
    let ascent = |&start: &usize| match is_over() {
        true => (lattice.point(start), values[start]),
        false => climb(variance, shape, &lattice.point(start)),
    };
    let climbed = starts.par_iter().map(ascent);
    let best = climbed.collect::<Vec<_>>().into_iter().reduce(|a, b| if b.1 > a.1 { b } else { a });
    let (at, value) = best.unwrap_or_else(|| (vec![f64::NAN; shape.axes.len()], f64::NAN));
    (at, value, method)
}

fn scan_list(variance: &PredictionVariance, list: &List) -> (usize, f64) {
    let highest = |(block, points): (usize, &[f64])| {
        let mut values = [0.0; SCANNED_AT_ONCE];
        let values = &mut values[..points.len() / list.n_factors];
        variance.fill_values(points, values);
        let places = (block * SCANNED_AT_ONCE..).zip(values.iter().copied());
        places.fold((0, f64::NEG_INFINITY), higher)
    };
    list.coordinates
        .par_chunks(list.n_factors * SCANNED_AT_ONCE)
        .enumerate()
        .map(highest)
        .reduce(|| (0, f64::NEG_INFINITY), higher)
}

/// Points of a list that one thread looks at before it takes others.
const SCANNED_AT_ONCE: usize = 1024;

/// The larger value, and of equals the first.
fn higher(a: (usize, f64), b: (usize, f64)) -> (usize, f64) {
    if b.1 > a.1 || b.1 >= a.1 && b.0 < a.0 { b } else { a }
}

/// The highest of all points: line by line, or axis by axis where lines times monomials are many.
fn scan_grid(variance: &PredictionVariance, shape: &BoxShape) -> (Vec<f64>, f64) {
    let last = shape.axes.len() - 1;
    let n_lines: usize = shape.axes[..last].iter().map(|axis| level_values(axis).len()).product();
    if n_lines.saturating_mul(variance.products().n_monomials()) > MOST_STORED {
        scan_by_axes(variance, shape)
    } else {
        scan_by_lines(variance, shape)
    }
}

/// In parts of the grid, each of which is at hand as a whole.
fn scan_by_axes(variance: &PredictionVariance, shape: &BoxShape) -> (Vec<f64>, f64) {
    const PART: usize = 1 << 16;
    let grid = Lattice::whole(shape);
    let mut best: (Vec<f64>, f64) = (vec![f64::NAN; shape.axes.len()], f64::NEG_INFINITY);
    Nested::of(variance.products(), grid.levels().to_vec()).parts(variance.coefficients(), PART, |first, values| {
        for (index, &value) in (first..).zip(values) {
            if value > best.1 {
                let point = grid.point(index);
                if !shape.forbids(&point) {
                    best = (point, value);
                }
            }
        }
    });
    let value = variance.value(&best.0);
    (best.0, value)
}

/// Along the last axis, where v is a polynomial of one variable.
fn scan_by_lines(variance: &PredictionVariance, shape: &BoxShape) -> (Vec<f64>, f64) {
    let last = shape.axes.len() - 1;
    let lattice = Lattice::new(shape.axes[..last].iter().map(level_values).collect());
    let levels = level_values(&shape.axes[last]);
    let scan = |index: usize| {
        let mut point = lattice.point(index);
        point.push(0.0);
        let mut line = vec![0.0; variance.largest_power() + 1];
        variance.along(&point, last, &mut line);
        let best = best_level(shape, &point, last, &levels, &line);
        best.map_or((index, 0.0, f64::NEG_INFINITY), |(x, value)| (index, x, value))
    };
    let larger = |a: (usize, f64, f64), b: (usize, f64, f64)| if b.2 > a.2 || b.2 >= a.2 && b.0 < a.0 { b } else { a };
    let none = || (usize::MAX, 0.0, f64::NEG_INFINITY);
    let (index, x, value) = (0..lattice.n_points()).into_par_iter().with_min_len(64).map(scan).reduce(none, larger);
    let mut at = lattice.point(index);
    at.push(x);
    (at, value)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Axis, Design, Forbidden, Model};

    #[test]
    fn a_grid_scanned_by_lines_and_by_axes_has_the_same_highest_point() {
        let runs = [[-1.0, -1.0], [1.0, -0.9], [-0.8, 1.0], [1.0, 1.0], [0.2, -1.0], [-0.1, 1.0], [-1.0, 0.3]];
        let design = Design::from_runs(&runs).expect("a design");
        let variance = PredictionVariance::of(&Model::quadratic(2).expect("a model"), &design).expect("not singular");
        let axes = vec![Axis::equally_spaced(9).expect("levels"), Axis::equally_spaced(7).expect("levels")];
        let mut forbidden = Vec::new();
        // The highest point is forbidden again and again.
        for _ in 0..20 {
            let shape = BoxShape { axes: axes.clone(), forbidden: forbidden.clone() };
            let (lines, whole) = (scan_by_lines(&variance, &shape), scan_by_axes(&variance, &shape));
            assert_eq!(lines.0, whole.0, "{} and {}", lines.1, whole.1);
            assert!((lines.1 - whole.1).abs() < 1e-12 * lines.1, "{} is not {}", lines.1, whole.1);
            forbidden.push(Forbidden::new(lines.0.iter().map(|&x| Some([x, x])).collect()).expect("a point"));
        }
    }
}
