//! One monomial of a model.

use serde::{Deserialize, Serialize};

/// A monomial x₁^e₁ x₂^e₂ …, as the list of its exponents, one per factor; all zero is the constant 1.
///
/// ```
/// use design_space::Term;
/// let term = Term::new([2, 0, 1]);
/// assert_eq!(term.value(&[3.0, 7.0, 5.0]), 45.0);
/// assert_eq!(term.name(&["a", "b", "c"]), "a^2 c");
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Term {
    exponents: Vec<u8>,
}

impl Term {
    /// The monomial with these exponents. A [`Model`](crate::Model) checks them.
    #[must_use]
    pub fn new(exponents: impl Into<Vec<u8>>) -> Self {
        Self { exponents: exponents.into() }
    }

    /// The exponent of each factor.
    #[must_use]
    pub fn exponents(&self) -> &[u8] {
        &self.exponents
    }

    /// Sum of the exponents.
    #[must_use]
    pub fn degree(&self) -> u32 {
        self.exponents.iter().map(|&exponent| u32::from(exponent)).sum()
    }

    /// The monomial at a coded point with as many coordinates as there are exponents.
    ///
    /// Coordinates are multiplied one after the other, so that it has the same bits on every machine.
    #[must_use]
    #[inline]
    pub fn value(&self, point: &[f64]) -> f64 {
        let mut product = 1.0;
        for (&exponent, &x) in self.exponents.iter().zip(point) {
            for _ in 0..exponent {
                product *= x;
            }
        }
        product
    }

    /// Readable form with these names of the factors, `"1"` for the constant.
    #[must_use]
    pub fn name(&self, factors: &[&str]) -> String {
        let powers: Vec<String> = self
            .exponents
            .iter()
            .zip(factors)
            .filter(|&(&exponent, _)| exponent > 0)
            .map(|(&exponent, name)| if exponent == 1 { (*name).to_owned() } else { format!("{name}^{exponent}") })
            .collect();
        if powers.is_empty() { "1".to_owned() } else { powers.join(" ") }
    }
}
