//! A polynomial at one point or in lanes.

use doe::{Model, Term};
use multiversion::multiversion;

use crate::surface::one_lane;
use crate::{LANES, Lanes};

/// Σ b_t Π x_j over the terms t.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Polynomial {
    n_factors: usize,
    monomials: Vec<Monomial>,
    terms: Vec<Term>,
}

/// A coefficient and the factors it is multiplied by, each as often as its exponent says.
#[derive(Debug, Clone, PartialEq)]
struct Monomial {
    coefficient: f64,
    factors: Vec<usize>,
}

impl Polynomial {
    pub(crate) fn new(model: &Model, coefficients: &[f64]) -> Self {
        let mut monomials: Vec<Monomial> = model
            .terms()
            .iter()
            .zip(coefficients)
            .map(|(term, &coefficient)| {
                let powers = term.exponents().iter().enumerate();
                let factors = powers.flat_map(|(factor, &power)| std::iter::repeat_n(factor, usize::from(power)));
                Monomial { coefficient, factors: factors.collect() }
            })
            .collect();
        // A factor in no term still must be finite: zero times what is not is not a number.
        let absent = (0..model.n_factors()).filter(|&factor| model.largest_exponent(factor) == 0);
        monomials.extend(absent.map(|factor| Monomial { coefficient: 0.0, factors: vec![factor] }));
        Self { n_factors: model.n_factors(), monomials, terms: model.terms().to_vec() }
    }

    /// NaN for a point of another number of coordinates.
    pub(crate) fn value(&self, point: &[f64]) -> f64 {
        one_lane(point, self.n_factors).map_or(f64::NAN, |block| self.evaluate::<1>(&block[..point.len()])[0])
    }

    pub(crate) fn value_lanes(&self, block: &[Lanes], values: &mut Lanes) {
        evaluate_lanes(self, block, values);
    }

    pub(crate) fn gradient(&self, point: &[f64]) -> Vec<f64> {
        let slope = |factor: usize| {
            let along = self.terms.iter().zip(&self.monomials).filter(|(term, _)| term.exponents()[factor] > 0);
            let slopes = along.map(|(term, monomial)| {
                let mut exponents = term.exponents().to_vec();
                exponents[factor] -= 1;
                monomial.coefficient * f64::from(exponents[factor] + 1) * Term::new(exponents).value(point)
            });
            slopes.sum()
        };
        (0..self.n_factors).map(slope).collect()
    }

    #[inline(always)]
    fn evaluate<const L: usize>(&self, block: &[[f64; L]]) -> [f64; L] {
        let mut sums = [0.0; L];
        for Monomial { coefficient, factors } in &self.monomials {
            match factors[..] {
                [] => sums.iter_mut().for_each(|sum| *sum += coefficient),
                [a] => {
                    for lane in 0..L {
                        sums[lane] += coefficient * block[a][lane];
                    }
                }
                [a, b] => {
                    for lane in 0..L {
                        sums[lane] += coefficient * (block[a][lane] * block[b][lane]);
                    }
                }
                _ => {
                    let mut product = [*coefficient; L];
                    for &factor in factors {
                        for lane in 0..L {
                            product[lane] *= block[factor][lane];
                        }
                    }
                    for lane in 0..L {
                        sums[lane] += product[lane];
                    }
                }
            }
        }
        sums
    }
}

#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx+avx2"))]
fn evaluate_lanes(polynomial: &Polynomial, block: &[Lanes], values: &mut Lanes) {
    *values = polynomial.evaluate::<LANES>(block);
}
