//! The normal equations of a pose: sums over the sightings, their solution and what they say of its error.

#![expect(clippy::needless_range_loop, reason = "loops over indices stay in registers here; iterators are not inlined")]

use bat_dynamics::{LANES, Lanes, Real};
use nalgebra::{Cholesky, Matrix6};

use super::bundle::Bundle;
use super::triple::{Triple, add, constant, cross, times};

/// A pivot below this share of its diagonal entry is zero but for rounding.
const SMALLEST_PIVOT: f64 = 1e-12;

/// Columns of a row: three shifts in m, three turns in rad, and what is left over in px.
const COLUMNS: usize = 7;
/// Entries of the upper triangle.
const ENTRIES: usize = COLUMNS * (COLUMNS + 1) / 2;

/// Sums of products of rows, the upper triangle row by row: `Jᵀ J`, `Jᵀ e` and `eᵀ e`, e what the pose leaves of the pixels; of one
/// pose or of several side by side.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NormalEquations<T = f64> {
    sums: [T; ENTRIES],
}

impl NormalEquations {
    /// The sums over all bundles at `position`, where the attitude is `rows`; `None` where a dot would not be ahead of a camera that
    /// sees it.
    ///
    /// A dot at `a` from the point of the pose moves by `shift + turn × a`, so that with the slope w of a pixel by the
    /// dot's place its slopes by shift and turn are w and `a × w`.
    #[inline(always)]
    pub(crate) fn new(bundles: &[Bundle], position: Triple, rows: &[Triple; 3]) -> Option<Self> {
        let r_gb: [Triple<Lanes>; 3] = [constant(rows[0]), constant(rows[1]), constant(rows[2])];
        let position = constant(position);
        let mut sums = [Lanes::constant(0.0); ENTRIES];
        for bundle in bundles {
            let arm = times(&r_gb, bundle.place);
            let seen = bundle.eye.project(add(position, arm));
            if !is_ahead(seen.depth) {
                return None;
            }
            let mut slopes = seen.slopes;
            let mut left = [bundle.pixel[0] - seen.pixel[0], bundle.pixel[1] - seen.pixel[1]];
            // A weight of 1 changes nothing, and is that of all bundles but the last.
            if !bundle.is_full {
                let weigh = |w: Triple<Lanes>| [w[0] * bundle.weight, w[1] * bundle.weight, w[2] * bundle.weight];
                slopes = [weigh(slopes[0]), weigh(slopes[1])];
                left = [left[0] * bundle.weight, left[1] * bundle.weight];
            }
            let row = |k: usize| {
                let (w, turned) = (slopes[k], cross(arm, slopes[k]));
                [w[0], w[1], w[2], turned[0], turned[1], turned[2], left[k]]
            };
            add_products(&mut sums, &row(0), &row(1));
        }
        Some(Self { sums: totals(&sums) })
    }

    /// Equations without a sighting.
    pub(crate) const NONE: Self = Self { sums: [0.0; ENTRIES] };

    /// `eᵀ e` in px².
    #[inline(always)]
    pub(crate) fn cost(&self) -> f64 {
        self.sums[ENTRIES - 1]
    }

    /// `(Jᵀ J)⁻¹`: the covariance of shifts and turns for pixels of variance 1; `None` where it is open.
    pub(crate) fn inverse(&self) -> Option<Matrix6<f64>> {
        let (_, is_regular) = self.step(1.0);
        let matrix = self.matrix();
        let full = Matrix6::from_fn(|i, j| matrix[i.min(j)][i.max(j)]);
        (is_regular > 0.0).then(|| Cholesky::new(full))?.map(|factor| factor.inverse())
    }
}

impl NormalEquations<Lanes> {
    /// Four side by side.
    #[inline(always)]
    pub(crate) fn abreast([a, b, c, d]: [&NormalEquations; LANES]) -> Self {
        let mut sums = [Lanes::constant(0.0); ENTRIES];
        for k in 0..ENTRIES {
            sums[k] = Lanes([a.sums[k], b.sums[k], c.sums[k], d.sums[k]]);
        }
        Self { sums }
    }
}

impl<T: Real> NormalEquations<T> {
    /// The step in shifts and turns that takes the linearized pixels closest to what was seen, with the diagonal of
    /// `Jᵀ J` multiplied by `raised`; then 1, and 0 where the step is open and means nothing.
    #[inline(always)]
    pub(crate) fn step(&self, raised: T) -> ([T; 6], T) {
        solve(&self.matrix(), raised)
    }

    /// The upper triangle, with zeros below.
    #[inline(always)]
    fn matrix(&self) -> [[T; COLUMNS]; COLUMNS] {
        let mut matrix = [[T::constant(0.0); COLUMNS]; COLUMNS];
        let mut k = 0;
        for i in 0..COLUMNS {
            for j in i..COLUMNS {
                matrix[i][j] = self.sums[k];
                k += 1;
            }
        }
        matrix
    }
}

/// Solves the six equations whose right-hand sides are the seventh column, the diagonal multiplied by `raised`; the second number is 0
/// where they have no solution.
///
/// Elimination of a symmetric matrix, of which the upper triangle is read, without exchange of rows, in a third of the time of a
/// general Cholesky factor; `inverse` uses that of the library, and a test holds the two together.
#[inline(always)]
fn solve<T: Real>(equations: &[[T; COLUMNS]; COLUMNS], raised: T) -> ([T; 6], T) {
    let (zero, one) = (T::constant(0.0), T::constant(1.0));
    let mut a = *equations;
    for k in 0..6 {
        a[k][k] = a[k][k] * raised;
    }
    let mut inverse = [zero; 6];
    let mut is_regular = one;
    for k in 0..6 {
        let smallest = T::constant(SMALLEST_PIVOT) * equations[k][k];
        is_regular = smallest.select_below(a[k][k], is_regular, zero);
        inverse[k] = one / a[k][k];
        let pivot = a[k];
        for i in k + 1..6 {
            let factor = pivot[i] * inverse[k];
            // Below the diagonal too, where nobody looks: a loop of known length is written out.
            for j in 0..COLUMNS {
                a[i][j] = a[i][j] - factor * pivot[j];
            }
        }
    }
    let mut x = [zero; 6];
    for i in (0..6).rev() {
        let mut left = a[i][6];
        for j in i + 1..6 {
            left = left - a[i][j] * x[j];
        }
        x[i] = left * inverse[i];
    }
    (x, is_regular)
}

#[inline(always)]
fn is_ahead(depth: Lanes) -> bool {
    let [a, b, c, d] = depth.0;
    a > 0.0 && b > 0.0 && c > 0.0 && d > 0.0
}

/// Adds the products of the rows of u and of v with themselves, upper triangle row by row.
#[inline(always)]
fn add_products(sums: &mut [Lanes; ENTRIES], u: &[Lanes; COLUMNS], v: &[Lanes; COLUMNS]) {
    let mut k = 0;
    for i in 0..COLUMNS {
        for j in i..COLUMNS {
            sums[k] = sums[k] + (u[i] * u[j] + v[i] * v[j]);
            k += 1;
        }
    }
}

/// The sums over the lanes.
#[inline(always)]
fn totals(sums: &[Lanes; ENTRIES]) -> [f64; ENTRIES] {
    let mut totals = [0.0; ENTRIES];
    for k in 0..ENTRIES {
        let [a, b, c, d] = sums[k].0;
        totals[k] = (a + b) + (c + d);
    }
    totals
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector6;

    use super::*;

    /// A matrix `Jᵀ J + I` of made-up numbers with a right-hand side.
    fn equations() -> [[f64; COLUMNS]; COLUMNS] {
        let j = Matrix6::from_fn(|i, k| ((3 * i + 5 * k * k + i * k) as f64).sin());
        let matrix = j.transpose() * j + Matrix6::identity();
        let mut equations = [[0.0; COLUMNS]; COLUMNS];
        for i in 0..6 {
            for k in 0..6 {
                equations[i][k] = matrix[(i, k)];
            }
            equations[i][6] = (i as f64 - 2.5) * 0.7;
        }
        equations
    }

    #[test]
    fn elimination_solves_as_the_factor_of_the_library_does() {
        let equations = equations();
        let right = Vector6::from_fn(|i, _| equations[i][6]);
        for damping in [0.0, 0.3] {
            let matrix = Matrix6::from_fn(|i, k| equations[i][k] * if i == k { 1.0 + damping } else { 1.0 });
            let expected = Cholesky::new(matrix).unwrap().solve(&right);
            let found = Vector6::from(solve(&equations, 1.0 + damping).0);
            assert!((found - expected).amax() < 1e-14, "{found} and {expected}");
        }
    }

    #[test]
    fn column_that_is_the_sum_of_two_others_leaves_the_equations_open() {
        let mut equations = equations();
        for k in 0..6 {
            equations[k][5] = equations[k][0] + equations[k][1];
        }
        for k in 0..6 {
            equations[5][k] = equations[0][k] + equations[1][k];
        }
        assert!(solve(&equations, 1.0).1 < 1.0, "one unknown can be anything");
        assert!(solve(&equations, 1.1).1 > 0.0, "damped, they have a solution");
    }
}
