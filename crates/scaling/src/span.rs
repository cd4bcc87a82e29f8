//! Linear dependence among products of powers, by exact elimination.

use num_rational::BigRational;
use num_traits::One;

use crate::exponents::{Exponents, multiply, multiply_symbol};

/// Products that are independent of each other, in echelon form, each remembering what it was made of.
#[derive(Debug, Clone, Default)]
pub(crate) struct Span {
    rows: Vec<Row>,
}

#[derive(Debug, Clone)]
struct Row {
    /// A symbol that no later row has.
    pivot: String,
    product: Exponents,
    /// The same product, in the names of what was inserted.
    made_of: Exponents,
}

impl Span {
    pub(crate) fn rank(&self) -> usize {
        self.rows.len()
    }

    /// Expresses `product` by what was inserted, or else tells what is left over.
    pub(crate) fn express(&self, product: &Exponents) -> Result<Exponents, Exponents> {
        let (rest, made_of) = self.reduce(product);
        if rest.is_empty() { Ok(made_of) } else { Err(rest) }
    }

    /// Inserts `product` under a name unless it depends on what is there; then the dependence comes back.
    pub(crate) fn insert(&mut self, name: &str, product: &Exponents) -> Result<(), Exponents> {
        let (rest, made_of) = self.reduce(product);
        let Some(pivot) = rest.keys().next().cloned() else { return Err(made_of) };
        let mut own = Exponents::new();
        multiply_symbol(&mut own, name, &BigRational::one());
        multiply(&mut own, &made_of, &-BigRational::one());
        self.rows.push(Row { pivot, product: rest, made_of: own });
        Ok(())
    }

    fn reduce(&self, product: &Exponents) -> (Exponents, Exponents) {
        let mut rest = product.clone();
        let mut made_of = Exponents::new();
        for row in &self.rows {
            let (Some(exponent), Some(pivot)) = (rest.get(&row.pivot), row.product.get(&row.pivot)) else { continue };
            let power = exponent / pivot;
            multiply(&mut rest, &row.product, &-power.clone());
            multiply(&mut made_of, &row.made_of, &power);
        }
        (rest, made_of)
    }
}
