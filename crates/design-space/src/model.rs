//! The regressor: which monomials a response is expected to consist of.

use serde::{Deserialize, Serialize};

use crate::{Error, Term};

/// An ordered list of distinct monomials in coded coordinates; r(x) is the vector of their values.
///
/// Natural coordinates span the same functions, and give the same prediction variance, wherever
/// [`is_affine_closed`](Self::is_affine_closed) holds; all named models do.
///
/// In a file a model is its number of factors and either a name or the exponents of each term:
///
/// ```
/// use design_space::Model;
/// let named: Model = serde_json::from_str(r#"{"n_factors":2,"terms":"additive quadratic"}"#)?;
/// let listed: Model = serde_json::from_str(r#"{"n_factors":2,"terms":[[0,0],[1,0],[0,1],[2,0],[0,2]]}"#)?;
/// assert_eq!(named, listed);
/// assert_eq!(named.regressor(&[0.5, -1.0])?, [1.0, 0.5, -1.0, 0.25, 1.0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "UncheckedModel", into = "UncheckedModel")]
pub struct Model {
    n_factors: usize,
    terms: Vec<Term>,
}

impl Model {
    /// The largest number of factors.
    pub const MOST_FACTORS: usize = 12;
    /// The largest number of terms.
    pub const MOST_TERMS: usize = 256;
    /// What models are called in files and on command lines: those of [`linear`](Self::linear),
    /// [`additive_quadratic`](Self::additive_quadratic) and [`quadratic`](Self::quadratic).
    pub const NAMES: [&'static str; 3] = ["linear", "additive quadratic", "quadratic"];
    /// The largest exponent.
    pub const LARGEST_EXPONENT: u8 = 8;

    /// A model of these terms, in this order.
    ///
    /// # Errors
    ///
    /// [`Error::Count`] for the number of factors or terms, [`Error::WrongTermLength`], [`Error::ExponentTooLarge`],
    /// [`Error::DuplicateTerm`].
    pub fn new(n_factors: usize, terms: Vec<Term>) -> Result<Self, Error> {
        check_count("factors of a model", n_factors, Self::MOST_FACTORS)?;
        check_count("terms of a model", terms.len(), Self::MOST_TERMS)?;
        for (second, term) in terms.iter().enumerate() {
            if term.exponents().len() != n_factors {
                return Err(Error::WrongTermLength {
                    term: second,
                    expected: n_factors,
                    found: term.exponents().len(),
                });
            }
            let name = || term.name(&factor_names(n_factors).iter().map(String::as_str).collect::<Vec<_>>());
            if let Some(&exponent) = term.exponents().iter().find(|&&exponent| exponent > Self::LARGEST_EXPONENT) {
                let largest = Self::LARGEST_EXPONENT;
                return Err(Error::ExponentTooLarge { term: second, name: name(), exponent, largest });
            }
            if let Some(first) = terms[..second].iter().position(|earlier| earlier == term) {
                return Err(Error::DuplicateTerm { name: name(), first, second });
            }
        }
        Ok(Self { n_factors, terms })
    }

    /// 1, xᵢ: K + 1 terms.
    ///
    /// # Errors
    ///
    /// [`Error::Count`].
    pub fn linear(n_factors: usize) -> Result<Self, Error> {
        Family::Linear.model(n_factors)
    }

    /// 1, xᵢ, xᵢ²: 2 K + 1 terms.
    ///
    /// Source: (61), where K = 2.
    ///
    /// # Errors
    ///
    /// [`Error::Count`].
    pub fn additive_quadratic(n_factors: usize) -> Result<Self, Error> {
        Family::AdditiveQuadratic.model(n_factors)
    }

    /// 1, xᵢ, xᵢ xⱼ, xᵢ²: (K + 1)(K + 2)/2 terms, the full second-order model.
    ///
    /// # Errors
    ///
    /// [`Error::Count`].
    pub fn quadratic(n_factors: usize) -> Result<Self, Error> {
        Family::Quadratic.model(n_factors)
    }

    /// The model with one of these [`NAMES`](Self::NAMES).
    ///
    /// ```
    /// use design_space::Model;
    /// assert_eq!(Model::named("quadratic", 2)?, Model::quadratic(2)?);
    /// let error = Model::named("cubic", 2).unwrap_err();
    /// assert!(error.to_string().starts_with("model \"cubic\": expected \"linear\", \"additive quadratic\""));
    /// # Ok::<(), design_space::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::NoSuchModel`], [`Error::Count`].
    pub fn named(name: &str, n_factors: usize) -> Result<Self, Error> {
        Family::named(name)?.model(n_factors)
    }

    /// Number of factors, K.
    #[must_use]
    pub fn n_factors(&self) -> usize {
        self.n_factors
    }

    /// Number of terms, p.
    #[must_use]
    pub fn n_terms(&self) -> usize {
        self.terms.len()
    }

    /// The terms, in order.
    #[must_use]
    pub fn terms(&self) -> &[Term] {
        &self.terms
    }

    /// The regressor r(x) at a coded point, one value per term.
    ///
    /// # Errors
    ///
    /// [`Error::PointLength`].
    pub fn regressor(&self, point: &[f64]) -> Result<Vec<f64>, Error> {
        if point.len() != self.n_factors {
            return Err(Error::PointLength { expected: self.n_factors, found: point.len() });
        }
        Ok(self.terms.iter().map(|term| term.value(point)).collect())
    }

    /// The same model without some of its terms, by index: what to do about
    /// terms that a design cannot tell apart.
    ///
    /// # Errors
    ///
    /// [`Error::NoSuchTerm`]; [`Error::Count`] if nothing is left.
    pub fn without_terms(&self, dropped: &[usize]) -> Result<Self, Error> {
        if let Some(&index) = dropped.iter().find(|&&index| index >= self.n_terms()) {
            return Err(Error::NoSuchTerm { index, n_terms: self.n_terms() });
        }
        let kept = self.terms.iter().enumerate().filter(|(index, _)| !dropped.contains(index));
        Self::new(self.n_factors, kept.map(|(_, term)| term.clone()).collect())
    }

    /// Whether the span of the terms stays the same when every factor is shifted and scaled: with a term, all terms
    /// of smaller or equal exponents are there.
    #[must_use]
    pub fn is_affine_closed(&self) -> bool {
        self.terms.iter().all(|term| {
            (0..self.n_factors).filter(|&factor| term.exponents()[factor] > 0).all(|factor| {
                let mut lower = term.exponents().to_vec();
                lower[factor] -= 1;
                self.terms.contains(&Term::new(lower))
            })
        })
    }

    /// Names of the terms, in order, from names of the factors; missing names are `x1`, `x2`, ….
    #[must_use]
    pub fn term_names(&self, factors: &[&str]) -> Vec<String> {
        let own = factor_names(self.n_factors);
        let names: Vec<&str> =
            own.iter().enumerate().map(|(j, own)| *factors.get(j).unwrap_or(&own.as_str())).collect();
        self.terms.iter().map(|term| term.name(&names)).collect()
    }

    /// r(x) into a slice of [`n_terms`](Self::n_terms) values; lengths are the caller's duty.
    pub fn fill_regressor(&self, point: &[f64], values: &mut [f64]) {
        for (value, term) in values.iter_mut().zip(&self.terms) {
            *value = term.value(point);
        }
    }
}

/// What factors are called where nobody named them: `x1`, `x2`, …
#[must_use]
pub fn factor_names(n_factors: usize) -> Vec<String> {
    (1..=n_factors).map(|number| format!("x{number}")).collect()
}

fn check_count(name: &'static str, found: usize, most: usize) -> Result<(), Error> {
    if (1..=most).contains(&found) { Ok(()) } else { Err(Error::Count { name, found, least: 1, most }) }
}

/// The models that have a name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "&'static str")]
enum Family {
    Linear,
    AdditiveQuadratic,
    Quadratic,
}

impl Family {
    /// In the order of [`Model::NAMES`].
    const ALL: [Self; 3] = [Self::Linear, Self::AdditiveQuadratic, Self::Quadratic];

    fn named(name: &str) -> Result<Self, Error> {
        let named = Model::NAMES.into_iter().zip(Self::ALL).find(|(known, _)| *known == name);
        named
            .map(|(_, family)| family)
            .ok_or_else(|| Error::NoSuchModel { name: name.to_owned(), expected: &Model::NAMES })
    }

    fn model(self, n_factors: usize) -> Result<Model, Error> {
        check_count("factors of a model", n_factors, Model::MOST_FACTORS)?;
        let term = |powers: &[(usize, u8)]| {
            let mut exponents = vec![0; n_factors];
            for &(factor, power) in powers {
                exponents[factor] += power;
            }
            Term::new(exponents)
        };
        let mut terms = vec![term(&[])];
        terms.extend((0..n_factors).map(|i| term(&[(i, 1)])));
        if self == Self::Quadratic {
            terms.extend(
                (0..n_factors)
                    .flat_map(|i| (i + 1..n_factors).map(move |j| (i, j)))
                    .map(|(i, j)| term(&[(i, 1), (j, 1)])),
            );
        }
        if self != Self::Linear {
            terms.extend((0..n_factors).map(|i| term(&[(i, 2)])));
        }
        Model::new(n_factors, terms)
    }
}

impl TryFrom<String> for Family {
    type Error = Error;

    fn try_from(name: String) -> Result<Self, Error> {
        Self::named(&name)
    }
}

impl From<Family> for &'static str {
    fn from(family: Family) -> Self {
        Model::NAMES[family as usize]
    }
}

/// A model as it stands in a file.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename = "Model")]
struct UncheckedModel {
    n_factors: usize,
    terms: Terms,
}

#[derive(Serialize, Deserialize)]
#[serde(
    untagged,
    expecting = "expected \"linear\", \"additive quadratic\", \"quadratic\" or a list of exponents per term"
)]
enum Terms {
    Named(Family),
    Listed(Vec<Term>),
}

impl TryFrom<UncheckedModel> for Model {
    type Error = Error;

    fn try_from(unchecked: UncheckedModel) -> Result<Self, Error> {
        match unchecked.terms {
            Terms::Named(family) => family.model(unchecked.n_factors),
            Terms::Listed(terms) => Self::new(unchecked.n_factors, terms),
        }
    }
}

impl From<Model> for UncheckedModel {
    fn from(model: Model) -> Self {
        let same = |family: &Family| family.model(model.n_factors).is_ok_and(|named| named == model);
        let terms = match Family::ALL.into_iter().find(same) {
            Some(family) => Terms::Named(family),
            None => Terms::Listed(model.terms),
        };
        Self { n_factors: model.n_factors, terms }
    }
}
