//! A weighted sum of surfaces, polynomials added up to one.

use std::sync::Arc;

use doe::Model;
use surface::{LANES, Lanes, Surface};

/// Σ f_s Ĵ_s: one polynomial for all regressions in it, whatever their number, and the other surfaces.
#[derive(Debug, Clone)]
pub(crate) struct Sum {
    n_factors: usize,
    monomials: Vec<Monomial>,
    others: Vec<(f64, Arc<dyn Surface>)>,
}

#[derive(Debug, Clone)]
struct Monomial {
    exponents: Vec<u8>,
    coefficient: f64,
}

impl Sum {
    /// The empty sum, 0 everywhere.
    pub(crate) fn zero(n_factors: usize) -> Self {
        Self { n_factors, monomials: Vec::new(), others: Vec::new() }
    }

    pub(crate) fn add_polynomial(&mut self, factor: f64, model: &Model, coefficients: &[f64]) {
        for (term, coefficient) in model.terms().iter().zip(coefficients) {
            self.add_monomial(factor * coefficient, term.exponents());
        }
    }

    pub(crate) fn add_surface(&mut self, factor: f64, surface: Arc<dyn Surface>) {
        self.others.push((factor, surface));
    }

    pub(crate) fn add_sum(&mut self, factor: f64, sum: &Self) {
        for monomial in &sum.monomials {
            self.add_monomial(factor * monomial.coefficient, &monomial.exponents);
        }
        self.others.extend(sum.others.iter().map(|(own, surface)| (factor * own, Arc::clone(surface))));
    }

    fn add_monomial(&mut self, coefficient: f64, exponents: &[u8]) {
        match self.monomials.iter_mut().find(|monomial| monomial.exponents == exponents) {
            Some(monomial) => monomial.coefficient += coefficient,
            None => self.monomials.push(Monomial { exponents: exponents.to_vec(), coefficient }),
        }
    }

    /// The polynomial part, the same operations for one point and for lanes.
    fn polynomial<const L: usize>(&self, block: &[[f64; L]]) -> [f64; L] {
        let mut sums = [0.0; L];
        for Monomial { exponents, coefficient } in &self.monomials {
            let mut product = [*coefficient; L];
            for (&exponent, coordinate) in exponents.iter().zip(block) {
                for _ in 0..exponent {
                    product.iter_mut().zip(coordinate).for_each(|(product, x)| *product *= x);
                }
            }
            sums.iter_mut().zip(&product).for_each(|(sum, product)| *sum += product);
        }
        sums
    }
}

impl Surface for Sum {
    fn n_factors(&self) -> usize {
        self.n_factors
    }

    fn predict(&self, point: &[f64]) -> f64 {
        if point.len() != self.n_factors {
            return f64::NAN;
        }
        let block: Vec<[f64; 1]> = point.iter().map(|&x| [x]).collect();
        let others = self.others.iter().map(|(factor, surface)| factor * surface.predict(point));
        others.fold(self.polynomial(&block)[0], |sum, value| sum + value)
    }

    fn predict_lanes(&self, block: &[Lanes], estimates: &mut Lanes) {
        let mut sums = self.polynomial(block);
        let mut values = [0.0; LANES];
        for (factor, surface) in &self.others {
            surface.predict_lanes(block, &mut values);
            sums.iter_mut().zip(&values).for_each(|(sum, value)| *sum += factor * value);
        }
        *estimates = sums;
    }
}
