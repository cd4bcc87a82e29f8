//! The prediction variance as a function of where one predicts.

use std::sync::Arc;

use multiversion::multiversion;

use crate::products::Products;
use crate::{Design, Error, Information, Model};

/// v(x) = r(x)' (R'R)⁻¹ r(x), the variance of the prediction at x for unit variance of a run, as the polynomial it is.
///
/// ```
/// use doe::{Design, Model, PredictionVariance, Space};
/// let model = Model::quadratic(1)?;
/// let design = Design::new(1, vec![-1.0, 0.0, 1.0])?;
/// let variance = PredictionVariance::of(&model, &design)?;
/// assert!((variance.at(&[0.0])? - 1.0).abs() < 1e-12);
/// let worst = variance.maximum(&Space::cube(1)?)?;
/// assert!((worst.value - 1.0).abs() < 1e-12);
/// # Ok::<(), doe::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct PredictionVariance {
    products: Arc<Products>,
    coefficients: Vec<f64>,
}

impl PredictionVariance {
    /// The prediction variance of a design.
    ///
    /// # Errors
    ///
    /// As [`Information::of`].
    pub fn of(model: &Model, design: &Design) -> Result<Self, Error> {
        Self::from_information(model, &Information::of(model, design)?)
    }

    /// The prediction variance with this information about the terms of the model.
    ///
    /// # Errors
    ///
    /// [`PointLength`](design_space::Error::PointLength) if model and information differ in the number of terms.
    pub fn from_information(model: &Model, information: &Information) -> Result<Self, Error> {
        let (expected, found) = (model.n_terms(), information.n_terms());
        if expected != found {
            return Err(Error::DesignSpace(design_space::Error::PointLength { expected, found }));
        }
        let products = Arc::new(Products::of(model));
        Ok(Self::with_products(products, information.inverse()))
    }

    pub(crate) fn with_products(products: Arc<Products>, inverse: &[f64]) -> Self {
        let mut coefficients = vec![0.0; products.n_monomials()];
        products.collect(inverse, &mut coefficients);
        Self { products, coefficients }
    }

    /// Whether v is convex along an axis: its maxima are at the ends then.
    pub(crate) fn is_convex_along(&self, axis: usize) -> bool {
        self.products.is_convex_along(axis)
    }

    pub(crate) fn update(&mut self, inverse: &[f64]) {
        self.products.collect(inverse, &mut self.coefficients);
    }

    /// v at a coded point.
    ///
    /// # Errors
    ///
    /// [`PointLength`](design_space::Error::PointLength).
    pub fn at(&self, point: &[f64]) -> Result<f64, Error> {
        self.check(point)?;
        Ok(self.value(point))
    }

    /// Gradient of v at a coded point.
    ///
    /// # Errors
    ///
    /// [`PointLength`](design_space::Error::PointLength).
    pub fn gradient(&self, point: &[f64]) -> Result<Vec<f64>, Error> {
        self.check(point)?;
        let mut line = vec![0.0; self.products.largest + 1];
        let slope = |j: usize| {
            self.along(point, j, &mut line);
            crate::polynomial::slope(&line, point[j])
        };
        Ok((0..point.len()).map(slope).collect())
    }

    /// Number of factors, K.
    #[must_use]
    pub fn n_factors(&self) -> usize {
        self.products.n_factors
    }

    /// The monomials that products of two terms consist of.
    pub(crate) fn products(&self) -> &Products {
        &self.products
    }

    /// Coefficients of the monomials that products of two terms consist of.
    pub(crate) fn coefficients(&self) -> &[f64] {
        &self.coefficients
    }

    /// Largest power of one coordinate, 4 for models with squares.
    pub(crate) fn largest_power(&self) -> usize {
        self.products.largest
    }

    pub(crate) fn value(&self, point: &[f64]) -> f64 {
        let mut table = [[0.0; 17]; Model::MOST_FACTORS];
        self.fill_powers(point, &mut table);
        let monomials = self.products.powers().zip(&self.coefficients);
        let term = |(powers, c): (&[(u8, u8)], &f64)| {
            powers.iter().fold(*c, |product, &(axis, e)| product * table[usize::from(axis)][usize::from(e)])
        };
        monomials.map(term).sum()
    }

    /// v at many coded points, one after the other in `points`: each to the bit as [`Self::value`] has it.
    pub(crate) fn fill_values(&self, points: &[f64], values: &mut [f64]) {
        let k = self.n_factors();
        let (factors, ends) = self.products.sparse();
        let monomials = Sparse { coefficients: &self.coefficients, factors, ends };
        let mut powers = vec![[1.0; LANES]; k * (self.largest_power() + 1)];
        let (blocks, rest) = values.as_chunks_mut::<LANES>();
        let (in_blocks, of_rest) = points.split_at((blocks.len() * LANES * k).min(points.len()));
        sum_in_lanes(&monomials, in_blocks, k, &mut powers, blocks);
        for (value, point) in rest.iter_mut().zip(of_rest.chunks_exact(k)) {
            *value = self.value(point);
        }
    }

    /// Coefficients of v along one axis through a point, from the constant up.
    pub(crate) fn along(&self, point: &[f64], axis: usize, line: &mut [f64]) {
        let mut table = [[0.0; 17]; Model::MOST_FACTORS];
        self.fill_powers(point, &mut table);
        line.fill(0.0);
        for (powers, c) in self.products.powers().zip(&self.coefficients) {
            let (mut product, mut power) = (*c, 0);
            for &(other, e) in powers {
                if usize::from(other) == axis {
                    power = usize::from(e);
                } else {
                    product *= table[usize::from(other)][usize::from(e)];
                }
            }
            line[power] += product;
        }
    }

    /// ∂²v/∂xᵢ∂xⱼ at a point.
    pub(crate) fn second(&self, point: &[f64], i: usize, j: usize) -> f64 {
        let mut table = [[0.0; 17]; Model::MOST_FACTORS];
        self.fill_powers(point, &mut table);
        let term = |(powers, c): (&[(u8, u8)], &f64)| {
            let exponent =
                |axis: usize| powers.iter().find(|power| usize::from(power.0) == axis).map_or(0, |power| power.1);
            // The second derivative along an axis lowers its exponent by two, one after the other.
            let (first, second) = (exponent(i), exponent(j) - u8::from(i == j).min(exponent(j)));
            if first == 0 || second == 0 {
                return 0.0;
            }
            let lowered = |&(axis, e): &(u8, u8)| {
                let by = u8::from(usize::from(axis) == i) + u8::from(usize::from(axis) == j);
                table[usize::from(axis)][usize::from(e - by)]
            };
            powers.iter().map(lowered).fold(*c * f64::from(first) * f64::from(second), |product, power| product * power)
        };
        self.products.powers().zip(&self.coefficients).map(term).sum()
    }

    fn fill_powers(&self, point: &[f64], powers: &mut [[f64; 17]; Model::MOST_FACTORS]) {
        for (powers, &x) in powers.iter_mut().zip(point) {
            powers[0] = 1.0;
            for e in 1..=self.products.largest {
                powers[e] = powers[e - 1] * x;
            }
        }
    }

    fn check(&self, point: &[f64]) -> Result<(), Error> {
        let (expected, found) = (self.products.n_factors, point.len());
        if expected == found {
            Ok(())
        } else {
            Err(Error::DesignSpace(design_space::Error::PointLength { expected, found }))
        }
    }
}

/// Points side by side.
const LANES: usize = 8;

/// A polynomial, without the powers that are 1.
struct Sparse<'a> {
    coefficients: &'a [f64],
    /// Axis and exponent, monomial after monomial.
    factors: &'a [(u8, u8)],
    /// Where those of each monomial end.
    ends: &'a [usize],
}

/// A block of points at a time; `powers` has a row per axis and power, of which the first, 1, is there already.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx+avx2"))]
fn sum_in_lanes(
    monomials: &Sparse<'_>,
    points: &[f64],
    k: usize,
    powers: &mut [[f64; LANES]],
    values: &mut [[f64; LANES]],
) {
    let n_powers = powers.len() / k;
    for (block, values) in points.chunks_exact(LANES * k).zip(values) {
        for (axis, powers) in powers.chunks_exact_mut(n_powers).enumerate() {
            let x: [f64; LANES] = std::array::from_fn(|lane| block[lane * k + axis]);
            for e in 1..n_powers {
                powers[e] = std::array::from_fn(|lane| powers[e - 1][lane] * x[lane]);
            }
        }
        let (mut sum, mut begin) = ([-0.0; LANES], 0);
        for (&coefficient, &end) in monomials.coefficients.iter().zip(monomials.ends) {
            let mut product = [coefficient; LANES];
            for &(axis, exponent) in &monomials.factors[begin..end] {
                let power = &powers[usize::from(axis) * n_powers + usize::from(exponent)];
                (0..LANES).for_each(|lane| product[lane] *= power[lane]);
            }
            (0..LANES).for_each(|lane| sum[lane] += product[lane]);
            begin = end;
        }
        *values = sum;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_points_at_once_are_each_point_alone_to_the_bit() {
        // 21 points are two blocks and a rest.
        for (k, model) in [(1, Model::quadratic(1)), (3, Model::additive_quadratic(3)), (4, Model::quadratic(4))] {
            let model = model.expect("a model");
            let p = model.n_terms();
            let mut state = 1.0_f64;
            let mut next = || {
                state = (state * 1.618_033_988_749 + 0.37).fract();
                2.0 * state - 1.0
            };
            let matrix: Vec<f64> = (0..p * p).map(|_| next()).collect();
            let variance = PredictionVariance::with_products(Arc::new(Products::of(&model)), &matrix);
            let points: Vec<f64> = (0..21 * k).map(|_| next()).collect();
            let mut values = vec![f64::NAN; 21];
            variance.fill_values(&points, &mut values);
            for (point, value) in points.chunks_exact(k).zip(values) {
                assert_eq!(value.to_bits(), variance.value(point).to_bits(), "K = {k}, at {point:?}");
            }
        }
    }
}
