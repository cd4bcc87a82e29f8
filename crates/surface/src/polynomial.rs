//! A polynomial at one point or in lanes.

use doe::{Model, Term};
use multiversion::multiversion;

use crate::lanes::{check_factors, is_usable, one_lane};
use crate::monomial::Monomial;
use crate::over_grid::Powers;
use crate::{Error, GridPoints, LANES, Lanes, OverGrid, Surface};

/// Σ b_t Π x_j over the terms t, a surface without data: what a [`Regression`](crate::Regression) evaluates.
///
/// Polynomials add up to polynomials, so that a sum of many costs no more to evaluate than one.
///
/// ```
/// use doe::Model;
/// use surface::{Polynomial, Surface};
/// // 1 + 2 x − 3 x², and half of it taken away.
/// let parabola = Polynomial::new(&Model::quadratic(1)?, &[1.0, 2.0, -3.0])?;
/// let rest = parabola.plus(-0.5, &parabola)?;
/// assert_eq!(rest.predict(&[2.0]), 0.5 * (1.0 + 4.0 - 12.0));
/// assert_eq!(rest.gradient(&[2.0]), Some(vec![0.5 * (2.0 - 12.0)]));
/// # Ok::<(), surface::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Polynomial {
    n_factors: usize,
    /// Those of the terms, then one of coefficient zero for each factor in no term.
    monomials: Vec<Monomial>,
    terms: Vec<Term>,
}

impl Polynomial {
    /// With these coefficients of the terms of a model.
    ///
    /// # Errors
    ///
    /// [`Error::Length`] if there is not one per term.
    pub fn new(model: &Model, coefficients: &[f64]) -> Result<Self, Error> {
        let (expected, found) = (model.n_terms(), coefficients.len());
        if expected != found {
            return Err(Error::Length { name: "coefficients", expected, found });
        }
        Ok(Self::of(model.n_factors(), model.terms().to_vec(), coefficients.to_vec()))
    }

    /// 0 everywhere.
    ///
    /// # Errors
    ///
    /// [`Error::Count`] for the number of factors.
    pub fn zero(n_factors: usize) -> Result<Self, Error> {
        check_factors(n_factors)?;
        Ok(Self::of(n_factors, Vec::new(), Vec::new()))
    }

    /// This and so many times another, coefficient by coefficient.
    ///
    /// # Errors
    ///
    /// [`Error::FactorMismatch`].
    pub fn plus(&self, times: f64, other: &Self) -> Result<Self, Error> {
        let (expected, found) = (self.n_factors, other.n_factors);
        if expected != found {
            return Err(Error::FactorMismatch { what: "the second polynomial", expected, found });
        }
        let (mut terms, mut coefficients): (Vec<_>, Vec<_>) =
            self.parts().map(|(term, coefficient)| (term.clone(), coefficient)).unzip();
        for (term, coefficient) in other.parts() {
            match terms.iter().position(|own| own == term) {
                Some(place) => coefficients[place] += times * coefficient,
                None => {
                    terms.push(term.clone());
                    coefficients.push(times * coefficient);
                }
            }
        }
        Ok(Self::of(self.n_factors, terms, coefficients))
    }

    /// Each term with its coefficient.
    pub fn parts(&self) -> impl Iterator<Item = (&Term, f64)> {
        self.terms.iter().zip(&self.monomials).map(|(term, monomial)| (term, monomial.coefficient))
    }

    fn of(n_factors: usize, terms: Vec<Term>, coefficients: Vec<f64>) -> Self {
        let monomial = |(term, coefficient): (&Term, f64)| {
            let powers = term.exponents().iter().enumerate();
            let factors = powers.flat_map(|(factor, &power)| std::iter::repeat_n(factor, usize::from(power)));
            Monomial { coefficient, factors: factors.collect() }
        };
        let mut monomials: Vec<Monomial> = terms.iter().zip(coefficients).map(monomial).collect();
        // A factor in no term still must be finite: zero times what is not is not a number.
        let is_absent = |factor: &usize| terms.iter().all(|term| term.exponents()[*factor] == 0);
        let absent = (0..n_factors).filter(is_absent);
        monomials.extend(absent.map(|factor| Monomial { coefficient: 0.0, factors: vec![factor] }));
        Self { n_factors, monomials, terms }
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

impl Surface for Polynomial {
    fn n_factors(&self) -> usize {
        self.n_factors
    }

    fn predict(&self, point: &[f64]) -> f64 {
        one_lane(point, self.n_factors).map_or(f64::NAN, |block| self.evaluate::<1>(&block[..point.len()])[0])
    }

    fn predict_lanes(&self, block: &[Lanes], estimates: &mut Lanes) {
        evaluate_lanes(self, block, estimates);
    }

    fn over_grid<'a>(&'a self, grid: &'a GridPoints) -> Option<Box<dyn OverGrid + 'a>> {
        Powers::new(&self.monomials, grid, Box::new(|point| self.predict(point)))
            .map(|powers| Box::new(powers) as Box<dyn OverGrid>)
    }

    fn gradient(&self, point: &[f64]) -> Option<Vec<f64>> {
        let slope = |factor: usize| {
            let along = self.parts().filter(|(term, _)| term.exponents()[factor] > 0);
            let slopes = along.map(|(term, coefficient)| {
                let mut exponents = term.exponents().to_vec();
                exponents[factor] -= 1;
                coefficient * f64::from(exponents[factor] + 1) * Term::new(exponents).value(point)
            });
            slopes.sum()
        };
        is_usable(point, self.n_factors).then(|| (0..self.n_factors).map(slope).collect())
    }
}

#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx+avx2"))]
fn evaluate_lanes(polynomial: &Polynomial, block: &[Lanes], values: &mut Lanes) {
    *values = polynomial.evaluate::<LANES>(block);
}
