//! One term of a polynomial.

/// A coefficient and the factors it is multiplied by, each as often as its exponent says.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Monomial {
    pub(crate) coefficient: f64,
    pub(crate) factors: Vec<usize>,
}

impl Monomial {
    /// Its factors from one on, each as often as its exponent says.
    pub(crate) fn factors_from(&self, first: usize) -> impl Iterator<Item = usize> {
        self.factors.iter().copied().filter(move |&factor| factor >= first)
    }

    /// Its value at a point with only the factors before one.
    pub(crate) fn value_before(&self, end: usize, point: &[f64]) -> f64 {
        let factors = self.factors.iter().filter(|&&factor| factor < end);
        factors.fold(self.coefficient, |product, &factor| product * point[factor])
    }
}
