//! Scaling laws: how everything changes when some quantities change by given ratios.

use std::fmt;

use num_rational::BigRational;
use num_traits::One;

use crate::dimension::Dimension;
use crate::error::{Error, in_words};
use crate::exponents::{Exponents, write_product};
use crate::factor::Factor;
use crate::groups::relation;
use crate::near::near_misses;
use crate::number::significant;
use crate::span::Span;
use crate::system::{System, Variable};

/// What happens to every variable of a system, and to every dimension that its ratios determine.
///
/// In a file it is the system and the given ratios, from which it follows.
#[derive(Debug, Clone, serde::Serialize, serde::Deserialize)]
#[serde(try_from = "Given", into = "Given")]
pub struct ScalingLaw {
    system: System,
    /// Independent ratios, in the order given; ratios that follow from them have been checked and left out.
    given: Vec<(String, Factor)>,
    span: Span,
}

/// How one quantity changes.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rule {
    /// The variable, or the dimension in writing.
    pub quantity: String,
    /// Given ratios with the powers to which they enter, in the order given.
    #[serde(with = "exponent_texts")]
    pub exponents: Vec<(String, BigRational)>,
    /// The ratio of the quantity.
    pub factor: Factor,
}

impl System {
    /// The scaling law that follows from ratios of variables or of plain dimensions: `[("L_t", "100"), ("M", "1e6")]`.
    ///
    /// A name is looked up among the variables first, then read as a product of the system's base dimensions.
    /// The scale X_s is such a ratio, of a length; the stretching a of time goes as the inverse of the ratio of a time.
    ///
    /// Source: (16), (18).
    ///
    /// # Errors
    /// [`Error::UnknownVariable`], [`Error::Duplicate`], what is wrong with a ratio as [`Error::AtKey`],
    /// [`Error::FreeRatio`] if a variable is not determined, [`Error::ContradictoryRatio`].
    pub fn law(&self, ratios: &[(&str, &str)]) -> Result<ScalingLaw, Error> {
        let read = |(name, ratio): &(&str, &str)| match ratio.parse() {
            Ok(factor) => Ok(((*name).to_owned(), factor)),
            Err(source) => Err(Error::AtKey { path: (*name).to_owned(), fault: Box::new(source) }),
        };
        let ratios: Vec<(String, Factor)> = ratios.iter().map(read).collect::<Result<_, _>>()?;
        self.law_from_factors(&ratios)
    }

    /// As [`law`](Self::law), from ratios that are factors already.
    ///
    /// # Errors
    /// Those of [`law`](Self::law).
    pub fn law_from_factors(&self, ratios: &[(String, Factor)]) -> Result<ScalingLaw, Error> {
        let mut law = ScalingLaw { system: self.clone(), given: Vec::new(), span: Span::default() };
        for (position, (name, factor)) in ratios.iter().enumerate() {
            if ratios[..position].iter().any(|(other, _)| other == name) {
                return Err(Error::Duplicate { what: "ratio", name: name.clone() });
            }
            law.give(name, factor)?;
        }
        for variable in &self.variables().to_vec() {
            law.rule_of(&variable.name, &variable.dimension)?;
        }
        Ok(law)
    }

    fn quantity(&self, name: &str) -> Result<Dimension, Error> {
        if let Ok(variable) = self.variable(name) {
            return Ok(variable.dimension.clone());
        }
        let bases: Vec<&str> = self.variables().iter().flat_map(|v| v.dimension.bases()).collect();
        match name.parse::<Dimension>() {
            Ok(dimension) if !dimension.is_one() && dimension.bases().all(|base| bases.contains(&base)) => {
                Ok(dimension)
            }
            _ => {
                let known = self.names().chain(bases.iter().copied()).map(str::to_owned);
                Err(Error::UnknownVariable { name: name.to_owned(), near: near_misses(name, known) })
            }
        }
    }
}

/// A law as it stands in a file.
#[derive(serde::Serialize, serde::Deserialize)]
#[serde(rename = "ScalingLaw", deny_unknown_fields)]
struct Given {
    system: System,
    ratios: Vec<(String, Factor)>,
}

impl TryFrom<Given> for ScalingLaw {
    type Error = Error;

    fn try_from(Given { system, ratios }: Given) -> Result<Self, Error> {
        system.law_from_factors(&ratios)
    }
}

impl From<ScalingLaw> for Given {
    fn from(ScalingLaw { system, given, .. }: ScalingLaw) -> Self {
        Self { system, ratios: given }
    }
}

impl ScalingLaw {
    /// The rule of a variable.
    ///
    /// # Errors
    /// [`Error::UnknownVariable`].
    pub fn rule(&self, variable: &str) -> Result<Rule, Error> {
        let variable = self.system.variable(variable)?;
        self.rule_of(&variable.name, &variable.dimension)
    }

    /// The rules of all variables, in the order of the system.
    pub fn rules(&self) -> impl Iterator<Item = Rule> {
        self.system.variables().iter().filter_map(|v| self.rule_of(&v.name, &v.dimension).ok())
    }

    /// The rule of any quantity of a dimension.
    ///
    /// # Errors
    /// [`Error::FreeRatio`] if the given ratios do not determine it.
    pub fn rule_for(&self, dimension: &Dimension) -> Result<Rule, Error> {
        self.rule_of(&dimension.to_string(), dimension)
    }

    /// The ratio of any quantity of a dimension.
    ///
    /// # Errors
    /// [`Error::FreeRatio`] if the given ratios do not determine it.
    pub fn factor(&self, dimension: &Dimension) -> Result<Factor, Error> {
        self.rule_for(dimension).map(|rule| rule.factor)
    }

    /// The law of the way back.
    #[must_use]
    pub fn inverse(&self) -> Self {
        let given = self.given.iter().map(|(name, factor)| (name.clone(), factor.inverse())).collect();
        Self { given, ..self.clone() }
    }

    /// The given ratios that determine the law; those that follow from earlier ones are left out.
    pub fn given(&self) -> impl Iterator<Item = (&str, &Factor)> {
        self.given.iter().map(|(name, factor)| (name.as_str(), factor))
    }

    /// The system of the law.
    #[must_use]
    pub fn system(&self) -> &System {
        &self.system
    }

    fn give(&mut self, name: &str, factor: &Factor) -> Result<(), Error> {
        let dimension = self.system.quantity(name)?;
        let Err(made_of) = self.span.insert(name, dimension.exponents()) else {
            self.given.push((name.to_owned(), factor.clone()));
            return Ok(());
        };
        let required = self.product(|given| made_of.get(given).cloned());
        if required == *factor {
            return Ok(());
        }
        Err(Error::ContradictoryRatio {
            group: self.relation(name, &made_of),
            name: name.to_owned(),
            given: with_value(factor),
            required: with_value(&required),
        })
    }

    fn rule_of(&self, quantity: &str, dimension: &Dimension) -> Result<Rule, Error> {
        let made_of = self.span.express(dimension.exponents()).map_err(|_| self.free(quantity, dimension))?;
        let power = |name: &str| made_of.get(name).cloned();
        let exponents = self.given.iter().filter_map(|(name, _)| Some((name.clone(), power(name)?))).collect();
        Ok(Rule { quantity: quantity.to_owned(), exponents, factor: self.product(power) })
    }

    fn product(&self, power: impl Fn(&str) -> Option<BigRational>) -> Factor {
        let powers = self.given.iter().filter_map(|(name, factor)| Some(factor.pow(&power(name)?)));
        powers.fold(Factor::one(), |product, factor| &product * &factor)
    }

    fn relation(&self, name: &str, made_of: &Exponents) -> String {
        // Plain dimensions may stand among the ratios: give them a place behind the variables.
        let names = self.given.iter().map(|(given, _)| given.as_str()).chain([name]);
        let missing = names.filter(|name| self.system.variable(name).is_err());
        let behind = missing.map(|name| Variable { name: name.to_owned(), dimension: Dimension::one() });
        let variables: Vec<_> = self.system.variables().iter().cloned().chain(behind).collect();
        relation(&variables, name, made_of).to_string()
    }

    fn free(&self, quantity: &str, dimension: &Dimension) -> Error {
        let given: Vec<_> = self.given.iter().map(|(name, _)| name).collect();
        let text = dimension.to_string();
        let is_free = |base: &&str| self.span.express(&[((*base).to_owned(), BigRational::one())].into()).is_err();
        Error::FreeRatio {
            given: in_words(&given),
            what: if quantity == text { text } else { format!("{quantity} ({text})") },
            free: dimension.bases().filter(is_free).map(str::to_owned).collect(),
            candidates: self.system.beyond(&self.span),
        }
    }
}

/// `10^(1/2) (3.1623)`: the decimal only where it says something new.
fn with_value(factor: &Factor) -> String {
    match factor.rational() {
        Some(rational) if rational.is_integer() => factor.to_string(),
        _ => format!("{factor} ({})", significant(factor.to_f64())),
    }
}

impl fmt::Display for Rule {
    /// Writes `V ~ L_t^(1/2)*g^(1/2)`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ~ ", self.quantity)?;
        write_product(f, self.exponents.iter().map(|(name, exponent)| (name.as_str(), exponent)))
    }
}

impl fmt::Display for ScalingLaw {
    /// One rule a line, with its ratio.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let rules: Vec<_> = self.rules().map(|rule| (rule.to_string(), rule.factor)).collect();
        let width = rules.iter().map(|(text, _)| text.chars().count()).max().unwrap_or(0);
        for (text, factor) in rules {
            writeln!(f, "{text:width$}  {}", with_value(&factor))?;
        }
        Ok(())
    }
}

/// Exponents as text, so that files stay readable.
mod exponent_texts {
    use num_rational::BigRational;
    use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error};

    pub(super) fn serialize<S: Serializer>(exponents: &[(String, BigRational)], to: S) -> Result<S::Ok, S::Error> {
        exponents.iter().map(|(name, e)| (name, e.to_string())).collect::<Vec<_>>().serialize(to)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<(String, BigRational)>, D::Error> {
        let texts = Vec::<(String, String)>::deserialize(from)?;
        texts.into_iter().map(|(name, e)| Ok((name, e.parse().map_err(D::Error::custom)?))).collect()
    }
}
