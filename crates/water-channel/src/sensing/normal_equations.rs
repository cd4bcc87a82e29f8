//! The normal equations of a pose: sums over the sightings, their solution and what they say of its error.

#![expect(clippy::needless_range_loop, reason = "loops over indices stay in registers here; iterators are not inlined")]

use bat_dynamics::{LANES, Lanes, Real};
use nalgebra::{Cholesky, Matrix6};

use super::bundle::Bundle;
use super::triple::{Triple, add, constant, cross, times};

/// A pivot below this share of its diagonal entry is zero but for rounding.
const SMALLEST_PIVOT: f64 = 1e-12;

/// Unknowns: three shifts in m, three turns in rad.
const UNKNOWNS: usize = 6;
/// Entries of the upper triangle.
const ENTRIES: usize = UNKNOWNS * (UNKNOWNS + 1) / 2;

/// A matrix `Jᵀ J`, of which the upper triangle is read; of one pose or of several side by side.
pub(crate) type Matrix<T> = [[T; UNKNOWNS]; UNKNOWNS];

/// What a pose leaves of the pixels, e, as the equations have it; of one pose or of several side by side.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Misfit<T> {
    /// `Jᵀ e`, which way and how strongly the sum of squares falls.
    pull: [T; UNKNOWNS],
    /// `eᵀ e` in px².
    cost: T,
}

/// The misfit of one pose in four shares, of as many sightings each, that are still to be added up.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MisfitShares(Misfit<Lanes>);

/// The equations of one pose in four shares, of as many sightings each, that are still to be added up.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shares {
    /// The upper triangle of `Jᵀ J`, row by row.
    matrix: [Lanes; ENTRIES],
    pub(crate) misfit: MisfitShares,
}

impl MisfitShares {
    /// No sighting.
    const NONE: Self = Self(Misfit { pull: [Lanes([0.0; LANES]); UNKNOWNS], cost: Lanes([0.0; LANES]) });

    /// The misfit that [`Shares::new`] has, without the matrix, in less than half the time: a sighting pulls its dot by
    /// `f = Σ w e` over u and v, and the pose by f and `a × f`.
    #[inline(always)]
    pub(crate) fn new(bundles: &[Bundle], position: Triple, rows: &[Triple; 3]) -> Option<Self> {
        let r_gb: [Triple<Lanes>; 3] = [constant(rows[0]), constant(rows[1]), constant(rows[2])];
        let position = constant(position);
        let mut sums = Self::NONE.0;
        for bundle in bundles {
            let arm = times(&r_gb, bundle.place);
            let seen = bundle.eye.project(add(position, arm));
            if !is_ahead(seen.depth) {
                return None;
            }
            let mut left = [bundle.pixel[0] - seen.pixel[0], bundle.pixel[1] - seen.pixel[1]];
            if !bundle.is_full {
                left = [left[0] * bundle.weight, left[1] * bundle.weight];
            }
            let [u, v] = seen.slopes;
            let force =
                [u[0] * left[0] + v[0] * left[1], u[1] * left[0] + v[1] * left[1], u[2] * left[0] + v[2] * left[1]];
            let moment = cross(arm, force);
            let pull = [force[0], force[1], force[2], moment[0], moment[1], moment[2]];
            for k in 0..UNKNOWNS {
                sums.pull[k] = sums.pull[k] + pull[k];
            }
            sums.cost = sums.cost + (left[0] * left[0] + left[1] * left[1]);
        }
        Some(Self(sums))
    }

    /// `eᵀ e` in px².
    #[inline(always)]
    pub(crate) fn cost(&self) -> f64 {
        total(self.0.cost)
    }

    /// Those of four poses, added up and side by side.
    #[inline(always)]
    pub(crate) fn abreast([a, b, c, d]: [&Self; LANES]) -> Misfit<Lanes> {
        let mut pull = [Lanes::constant(0.0); UNKNOWNS];
        for k in 0..UNKNOWNS {
            pull[k] = totals(a.0.pull[k], b.0.pull[k], c.0.pull[k], d.0.pull[k]);
        }
        Misfit { pull, cost: totals(a.0.cost, b.0.cost, c.0.cost, d.0.cost) }
    }
}

impl Shares {
    /// No sighting.
    pub(crate) const NONE: Self = Self { matrix: [Lanes([0.0; LANES]); ENTRIES], misfit: MisfitShares::NONE };

    /// The sums over all bundles at `position`, where the attitude is `rows`; `None` where a dot would not be ahead of a camera that
    /// sees it.
    ///
    /// A dot at `a` from the point of the pose moves by `shift + turn × a`, so that with the slope w of a pixel by the
    /// dot's place its slopes by shift and turn are w and `a × w`.
    #[inline(always)]
    pub(crate) fn new(bundles: &[Bundle], position: Triple, rows: &[Triple; 3]) -> Option<Self> {
        let r_gb: [Triple<Lanes>; 3] = [constant(rows[0]), constant(rows[1]), constant(rows[2])];
        let position = constant(position);
        let mut sums = Self::NONE;
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
                [w[0], w[1], w[2], turned[0], turned[1], turned[2]]
            };
            sums.add_products(&row(0), &row(1), left);
        }
        Some(sums)
    }

    /// Adds the products of the rows of u and of v with themselves and with what is left.
    #[inline(always)]
    fn add_products(&mut self, u: &[Lanes; UNKNOWNS], v: &[Lanes; UNKNOWNS], left: [Lanes; 2]) {
        let Misfit { pull, cost } = &mut self.misfit.0;
        let mut k = 0;
        for i in 0..UNKNOWNS {
            for j in i..UNKNOWNS {
                self.matrix[k] = self.matrix[k] + (u[i] * u[j] + v[i] * v[j]);
                k += 1;
            }
            pull[i] = pull[i] + (u[i] * left[0] + v[i] * left[1]);
        }
        *cost = *cost + (left[0] * left[0] + left[1] * left[1]);
    }

    /// `eᵀ e` in px².
    #[inline(always)]
    pub(crate) fn cost(&self) -> f64 {
        self.misfit.cost()
    }

    /// The matrices of four poses, added up and side by side.
    #[inline(always)]
    pub(crate) fn abreast([a, b, c, d]: [&Self; LANES]) -> Matrix<Lanes> {
        let mut entries = [Lanes::constant(0.0); ENTRIES];
        for k in 0..ENTRIES {
            entries[k] = totals(a.matrix[k], b.matrix[k], c.matrix[k], d.matrix[k]);
        }
        upper(&entries)
    }

    /// `(Jᵀ J)⁻¹`: the covariance of shifts and turns for pixels of variance 1; `None` where it is open.
    pub(crate) fn inverse(&self) -> Option<Matrix6<f64>> {
        let matrix = upper(&self.matrix.map(total));
        let is_regular = Factor::new(&matrix, 1.0).is_regular();
        let full = Matrix6::from_fn(|i, j| matrix[i.min(j)][i.max(j)]);
        (is_regular > 0.0).then(|| Cholesky::new(full))?.map(|factor| factor.inverse())
    }
}

/// The upper triangle as a matrix, with zeros below.
#[inline(always)]
fn upper<T: Real>(entries: &[T; ENTRIES]) -> Matrix<T> {
    let mut matrix = [[T::constant(0.0); UNKNOWNS]; UNKNOWNS];
    let mut k = 0;
    for i in 0..UNKNOWNS {
        for j in i..UNKNOWNS {
            matrix[i][j] = entries[k];
            k += 1;
        }
    }
    matrix
}

/// A matrix `Jᵀ J` after its elimination, which serves for any number of right-hand sides.
///
/// Elimination of a symmetric matrix, of which the upper triangle is read, without exchange of rows, in a third of the time of a
/// general Cholesky factor; [`Shares::inverse`] uses that of the library, and a test holds the two together.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Factor<T> {
    /// What elimination leaves at and above the diagonal; below it nobody looks.
    rows: Matrix<T>,
    /// One over the diagonal.
    inverse: [T; UNKNOWNS],
    is_regular: T,
}

impl Factor<Lanes> {
    /// Of no matrix.
    pub(crate) const NONE: Self = {
        let zero = Lanes([0.0; LANES]);
        Self { rows: [[zero; UNKNOWNS]; UNKNOWNS], inverse: [zero; UNKNOWNS], is_regular: zero }
    };
}

impl<T: Real> Factor<T> {
    /// Of a matrix with its diagonal multiplied by `raised`.
    #[inline(always)]
    pub(crate) fn new(matrix: &Matrix<T>, raised: T) -> Self {
        let (zero, one) = (T::constant(0.0), T::constant(1.0));
        let mut a = *matrix;
        for k in 0..UNKNOWNS {
            a[k][k] = a[k][k] * raised;
        }
        let mut inverse = [zero; UNKNOWNS];
        let mut is_regular = one;
        for k in 0..UNKNOWNS {
            let smallest = T::constant(SMALLEST_PIVOT) * matrix[k][k];
            is_regular = smallest.select_below(a[k][k], is_regular, zero);
            inverse[k] = one / a[k][k];
            let pivot = a[k];
            for i in k + 1..UNKNOWNS {
                let factor = pivot[i] * inverse[k];
                // Below the diagonal too: a loop of known length is written out.
                for j in 0..UNKNOWNS {
                    a[i][j] = a[i][j] - factor * pivot[j];
                }
            }
        }
        Self { rows: a, inverse, is_regular }
    }

    /// 1, and 0 where the matrix leaves steps open, which then mean nothing.
    #[inline(always)]
    pub(crate) fn is_regular(&self) -> T {
        self.is_regular
    }

    /// The step in shifts and turns that takes the linearized pixels closest to what was seen.
    #[inline(always)]
    pub(crate) fn step(&self, misfit: &Misfit<T>) -> [T; UNKNOWNS] {
        let mut x = misfit.pull;
        for k in 0..UNKNOWNS {
            let share = x[k] * self.inverse[k];
            for i in k + 1..UNKNOWNS {
                x[i] = x[i] - self.rows[k][i] * share;
            }
        }
        for i in (0..UNKNOWNS).rev() {
            let mut left = x[i];
            for j in i + 1..UNKNOWNS {
                left = left - self.rows[i][j] * x[j];
            }
            x[i] = left * self.inverse[i];
        }
        x
    }
}

#[inline(always)]
fn is_ahead(depth: Lanes) -> bool {
    let [a, b, c, d] = depth.0;
    a > 0.0 && b > 0.0 && c > 0.0 && d > 0.0
}

/// The sum over the lanes.
#[inline(always)]
fn total(Lanes([a, b, c, d]): Lanes) -> f64 {
    (a + b) + (c + d)
}

/// Four sums over lanes side by side.
#[inline(always)]
fn totals(a: Lanes, b: Lanes, c: Lanes, d: Lanes) -> Lanes {
    Lanes([total(a), total(b), total(c), total(d)])
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector6;

    use super::*;

    /// A matrix `Jᵀ J + I` of made-up numbers with a right-hand side.
    fn equations() -> (Matrix<f64>, Misfit<f64>) {
        let j = Matrix6::from_fn(|i, k| ((3 * i + 5 * k * k + i * k) as f64).sin());
        let matrix = j.transpose() * j + Matrix6::identity();
        let pull = core::array::from_fn(|i| (i as f64 - 2.5) * 0.7);
        (core::array::from_fn(|i| core::array::from_fn(|k| matrix[(i, k)])), Misfit { pull, cost: 0.0 })
    }

    #[test]
    fn elimination_solves_as_the_factor_of_the_library_does() {
        let (rows, misfit) = equations();
        let right = Vector6::from(misfit.pull);
        for damping in [0.0, 0.3] {
            let matrix = Matrix6::from_fn(|i, k| rows[i][k] * if i == k { 1.0 + damping } else { 1.0 });
            let expected = Cholesky::new(matrix).unwrap().solve(&right);
            let found = Vector6::from(Factor::new(&rows, 1.0 + damping).step(&misfit));
            assert!((found - expected).amax() < 1e-14, "{found} and {expected}");
        }
    }

    #[test]
    fn column_that_is_the_sum_of_two_others_leaves_the_equations_open() {
        let (mut rows, _) = equations();
        for row in &mut rows {
            row[5] = row[0] + row[1];
        }
        for k in 0..UNKNOWNS {
            rows[5][k] = rows[0][k] + rows[1][k];
        }
        assert!(Factor::new(&rows, 1.0).is_regular() < 1.0, "one unknown can be anything");
        assert!(Factor::new(&rows, 1.1).is_regular() > 0.0, "damped, they have a solution");
    }
}
