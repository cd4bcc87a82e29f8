//! A weighted sum of surfaces, polynomials added up to one.

use std::sync::Arc;

use surface::{LANES, Lanes, Polynomial, Surface};

use crate::Error;

/// Σ f_s Ĵ_s: one polynomial for all regressions in it, whatever their number, and the other surfaces.
#[derive(Debug, Clone)]
pub(crate) struct Sum {
    polynomial: Polynomial,
    others: Vec<(f64, Arc<dyn Surface>)>,
}

impl Sum {
    /// The empty sum, 0 everywhere.
    pub(crate) fn zero(n_factors: usize) -> Result<Self, Error> {
        Ok(Self { polynomial: Polynomial::zero(n_factors)?, others: Vec::new() })
    }

    pub(crate) fn add_polynomial(&mut self, factor: f64, polynomial: &Polynomial) -> Result<(), Error> {
        self.polynomial = self.polynomial.plus(factor, polynomial)?;
        Ok(())
    }

    pub(crate) fn add_surface(&mut self, factor: f64, surface: Arc<dyn Surface>) {
        self.others.push((factor, surface));
    }

    pub(crate) fn add_sum(&mut self, factor: f64, sum: &Self) -> Result<(), Error> {
        self.others.extend(sum.others.iter().map(|(own, surface)| (factor * own, Arc::clone(surface))));
        self.add_polynomial(factor, &sum.polynomial)
    }
}

impl Surface for Sum {
    fn n_factors(&self) -> usize {
        self.polynomial.n_factors()
    }

    fn predict(&self, point: &[f64]) -> f64 {
        let others = self.others.iter().map(|(factor, surface)| factor * surface.predict(point));
        others.fold(self.polynomial.predict(point), |sum, value| sum + value)
    }

    fn predict_lanes(&self, block: &[Lanes], estimates: &mut Lanes) {
        self.polynomial.predict_lanes(block, estimates);
        let mut values = [0.0; LANES];
        for (factor, surface) in &self.others {
            surface.predict_lanes(block, &mut values);
            estimates.iter_mut().zip(&values).for_each(|(sum, value)| *sum += factor * value);
        }
    }

    /// None where one of the surfaces has none.
    fn gradient(&self, point: &[f64]) -> Option<Vec<f64>> {
        let mut slopes = self.polynomial.gradient(point)?;
        for (factor, surface) in &self.others {
            let others = surface.gradient(point)?;
            slopes.iter_mut().zip(others).for_each(|(slope, other)| *slope += factor * other);
        }
        Some(slopes)
    }
}
