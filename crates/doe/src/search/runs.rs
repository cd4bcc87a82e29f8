//! The regressors of free runs, their slopes, and the information they add to the fixed ones.

use crate::{Model, Term};

/// A model prepared for fast regressors and slopes.
#[derive(Debug, Clone)]
pub(crate) struct Regressors {
    pub(crate) n_factors: usize,
    pub(crate) n_terms: usize,
    /// Factors with their exponents, term by term.
    powers: Vec<Vec<(usize, i32)>>,
}

impl Regressors {
    pub(crate) fn of(model: &Model) -> Self {
        let powers = |term: &Term| {
            let pairs = term.exponents().iter().enumerate().filter(|&(_, &exponent)| exponent > 0);
            pairs.map(|(factor, &exponent)| (factor, i32::from(exponent))).collect()
        };
        let powers = model.terms().iter().map(powers).collect();
        Self { n_factors: model.n_factors(), n_terms: model.n_terms(), powers }
    }

    #[inline]
    pub(crate) fn fill(&self, point: &[f64], regressor: &mut [f64]) {
        for (value, powers) in regressor.iter_mut().zip(&self.powers) {
            *value = powers.iter().map(|&(factor, exponent)| power(point[factor], exponent)).product();
        }
    }

    /// slopes += weight · ∂(u · r)/∂x at a point.
    #[inline]
    pub(crate) fn add_slopes(&self, point: &[f64], u: &[f64], weight: f64, slopes: &mut [f64]) {
        for (powers, u) in self.powers.iter().zip(u) {
            for (at, &(factor, exponent)) in powers.iter().enumerate() {
                let mut product = weight * u * f64::from(exponent) * power(point[factor], exponent - 1);
                for (other, &(factor, exponent)) in powers.iter().enumerate() {
                    if other != at {
                        product *= power(point[factor], exponent);
                    }
                }
                slopes[factor] += product;
            }
        }
    }

    /// ∂r_t/∂x_factor at a point.
    #[inline]
    pub(crate) fn slope_of_term(&self, term: usize, point: &[f64], factor: usize) -> f64 {
        let powers = &self.powers[term];
        let Some(at) = powers.iter().position(|&(other, _)| other == factor) else {
            return 0.0;
        };
        let exponent = powers[at].1;
        let others = powers.iter().enumerate().filter(|&(other, _)| other != at);
        let product: f64 = others.map(|(_, &(factor, exponent))| power(point[factor], exponent)).product();
        f64::from(exponent) * power(point[factor], exponent - 1) * product
    }

    /// curvature += weight · ∂²(u · r)/∂x² at a point, K × K.
    pub(crate) fn add_curvature(&self, point: &[f64], u: &[f64], weight: f64, curvature: &mut [f64]) {
        for (powers, u) in self.powers.iter().zip(u) {
            for (a, &(first, e)) in powers.iter().enumerate() {
                for (b, &(second, f)) in powers.iter().enumerate() {
                    let own = if a == b {
                        f64::from(e * (e - 1)) * power_or_zero(point[first], e - 2)
                    } else {
                        f64::from(e * f) * power(point[first], e - 1) * power(point[second], f - 1)
                    };
                    let others = powers.iter().enumerate().filter(|&(c, _)| c != a && c != b);
                    let product: f64 = others.map(|(_, &(factor, exponent))| power(point[factor], exponent)).product();
                    curvature[first * self.n_factors + second] += weight * u * own * product;
                }
            }
        }
    }
}

#[inline(always)]
fn power_or_zero(x: f64, exponent: i32) -> f64 {
    if exponent < 0 { 0.0 } else { power(x, exponent) }
}

#[inline(always)]
fn power(x: f64, exponent: i32) -> f64 {
    match exponent {
        0 => 1.0,
        1 => x,
        2 => x * x,
        _ => crate::power::power(x, exponent.unsigned_abs()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Second derivatives of 1, x, x³, x² y, x y² z³ by differences of the first; at zero, too.
    #[test]
    fn curvature_is_the_slope_of_the_slopes() {
        let terms = [[0, 0, 0], [1, 0, 0], [3, 0, 0], [2, 1, 0], [1, 2, 3]].map(Term::new).to_vec();
        let regressors = Regressors::of(&Model::new(3, terms).expect("a model"));
        let u = [0.3, -1.2, 0.7, 1.1, -0.4];
        for point in [[0.3, -0.6, 0.8], [0.0, 0.5, -0.2], [0.0, 0.0, 0.0], [-0.9, 0.0, 1.0]] {
            let mut curvature = vec![0.0; 9];
            regressors.add_curvature(&point, &u, 1.5, &mut curvature);
            for axis in 0..3 {
                let slopes = |by: f64| {
                    let (mut moved, mut slopes) = (point, [0.0; 3]);
                    moved[axis] += by;
                    regressors.add_slopes(&moved, &u, 1.5, &mut slopes);
                    slopes
                };
                let (above, below) = (slopes(1e-5), slopes(-1e-5));
                for other in 0..3 {
                    let expected = (above[other] - below[other]) / 2e-5;
                    let found = curvature[3 * axis + other];
                    assert!((found - expected).abs() < 1e-8, "{axis} {other} at {point:?}: {found} is not {expected}");
                }
            }
        }
    }
}
