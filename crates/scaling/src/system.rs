//! The variables on which something depends.

use std::collections::BTreeSet;

use num_rational::BigRational;
use num_traits::One;

use crate::dimension::Dimension;
use crate::error::{Error, in_words};
use crate::exponents::{Exponents, clear_denominators, multiply_symbol};
use crate::group::{Group, Groups};
use crate::near::near_misses;
use crate::parse::{Atom, begins_symbol, matches_whole, parse};
use crate::repeating::RepeatingSets;
use crate::span::Span;
use crate::units::Units;

/// A named quantity and what it measures.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Variable {
    /// The name, such as `L_t` or `k_p^z`.
    pub name: String,
    /// The dimension.
    pub dimension: Dimension,
}

/// Variables with their dimensions, in the order given.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(try_from = "Vec<Variable>", into = "Vec<Variable>")]
pub struct System {
    variables: Vec<Variable>,
}

const VARIABLE_NAME: &str = "a variable begins with a letter or `_`, has no space and none of * / ( ) · ×, and a `^` in it \
                             is followed by a letter";

impl System {
    /// A system of variables.
    ///
    /// # Errors
    /// [`Error::NoVariables`], [`Error::BadName`], [`Error::Duplicate`].
    pub fn new(variables: Vec<Variable>) -> Result<Self, Error> {
        let mut seen = BTreeSet::new();
        for Variable { name, .. } in &variables {
            check_name(name)?;
            if !seen.insert(name) {
                return Err(Error::Duplicate { what: "variable", name: name.clone() });
            }
        }
        if variables.is_empty() { Err(Error::NoVariables) } else { Ok(Self { variables }) }
    }

    /// A system of names with unit strings: `[("L_t", "m"), ("rho", "kg*m^-3")]`.
    ///
    /// # Errors
    /// Those of [`new`](Self::new), and [`Error::AtKey`] with the name of the variable whose unit cannot be read.
    pub fn parse(units: &Units, variables: &[(&str, &str)]) -> Result<Self, Error> {
        let variable = |(name, unit): &(&str, &str)| match units.parse(unit) {
            Ok(unit) => Ok(Variable { name: (*name).to_owned(), dimension: unit.dimension }),
            Err(source) => Err(Error::AtKey { path: (*name).to_owned(), fault: Box::new(source) }),
        };
        Self::new(variables.iter().map(variable).collect::<Result<_, _>>()?)
    }

    /// The variables in the order given.
    #[must_use]
    pub fn variables(&self) -> &[Variable] {
        &self.variables
    }

    /// The variable of this name.
    ///
    /// # Errors
    /// [`Error::UnknownVariable`] with near misses.
    pub fn variable(&self, name: &str) -> Result<&Variable, Error> {
        self.variables.iter().find(|variable| variable.name == name).ok_or_else(|| Error::UnknownVariable {
            name: name.to_owned(),
            near: near_misses(name, self.names().map(str::to_owned)),
        })
    }

    /// The rank of the dimensional matrix: how many repeating variables a set has.
    #[must_use]
    pub fn rank(&self) -> usize {
        self.span(&self.variables.iter().collect::<Vec<_>>()).rank()
    }

    /// How many independent dimensionless groups there are: variables minus rank.
    #[must_use]
    pub fn n_groups(&self) -> usize {
        self.variables.len() - self.rank()
    }

    /// The variables that can be in no group, because their dimension is independent of that of all others.
    #[must_use]
    pub fn in_no_group(&self) -> Vec<&str> {
        let rank = self.rank();
        let needed = |name: &str| {
            let others: Vec<_> = self.variables.iter().filter(|other| other.name != name).collect();
            self.span(&others).rank() < rank
        };
        self.names().filter(|name| needed(name)).collect()
    }

    /// The first variables, in the order given, that are a repeating set: put the characteristic ones first.
    #[must_use]
    pub fn propose_repeating(&self) -> Vec<&str> {
        let mut span = Span::default();
        let mut insert = |variable: &&Variable| span.insert(&variable.name, variable.dimension.exponents()).is_ok();
        self.variables.iter().filter(|v| insert(v)).map(|v| v.name.as_str()).collect()
    }

    /// Every set of repeating variables that works, one at a time, in lexical order of positions.
    #[must_use]
    pub fn repeating_sets(&self) -> RepeatingSets<'_> {
        RepeatingSets::new(&self.variables, self.rank())
    }

    /// The dimensionless groups, one for each variable that does not repeat.
    ///
    /// # Errors
    /// [`Error::UnknownVariable`], [`Error::Duplicate`], [`Error::DimensionlessRepeating`],
    /// [`Error::DependentRepeating`] (also where there are too many), [`Error::InsufficientRepeating`].
    pub fn groups(&self, repeating: &[&str]) -> Result<Groups, Error> {
        let span = self.repeating_span(repeating)?;
        let mut groups = Vec::new();
        for variable in self.variables.iter().filter(|v| !repeating.contains(&v.name.as_str())) {
            let made_of = span
                .express(variable.dimension.exponents())
                .map_err(|_| self.insufficient(repeating, variable, &span))?;
            groups.push(relation(&self.variables, &variable.name, &made_of));
        }
        let repeating = repeating.iter().map(|name| (*name).to_owned()).collect();
        Ok(Groups::new(self.clone(), repeating, groups))
    }

    /// Reads a group such as `L_t^3*rho/M_a`, as written, and verifies that it is dimensionless.
    ///
    /// # Errors
    /// [`Error::Syntax`], [`Error::UnknownSymbol`], [`Error::NumberInText`], [`Error::NotDimensionless`].
    pub fn group(&self, text: &str) -> Result<Group, Error> {
        let known = |rest: &str| self.names().filter_map(|name| matches_whole(name, rest)).max();
        let mut exponents = Exponents::new();
        let mut dimension = Dimension::one();
        for term in parse(text, &known)? {
            match term.atom {
                Atom::Number(number) if number.is_one() => {}
                Atom::Number(number) => {
                    return Err(Error::NumberInText { number: number.to_string(), text: text.into() });
                }
                Atom::Symbol { symbol, position } => {
                    let variable =
                        self.variables.iter().find(|v| v.name == symbol).ok_or_else(|| Error::UnknownSymbol {
                            what: "variable",
                            near: near_misses(&symbol, self.names().map(str::to_owned)),
                            symbol,
                            position,
                            text: text.into(),
                        })?;
                    dimension.multiply(&variable.dimension, &term.exponent);
                    multiply_symbol(&mut exponents, &variable.name, &term.exponent);
                }
            }
        }
        if !dimension.is_one() {
            return Err(Error::NotDimensionless { group: text.into(), dimension: dimension.to_string() });
        }
        Ok(Group::in_order(&self.variables, exponents))
    }

    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        self.variables.iter().map(|variable| variable.name.as_str())
    }

    /// The variables that a span does not reach.
    pub(crate) fn beyond(&self, span: &Span) -> Vec<String> {
        let beyond = self.variables.iter().filter(|v| span.express(v.dimension.exponents()).is_err());
        beyond.map(|v| v.name.clone()).collect()
    }

    fn repeating_span(&self, repeating: &[&str]) -> Result<Span, Error> {
        let mut span = Span::default();
        for (position, name) in repeating.iter().enumerate() {
            let variable = self.variable(name)?;
            if repeating[..position].contains(name) {
                return Err(Error::Duplicate { what: "repeating variable", name: variable.name.clone() });
            }
            if variable.dimension.is_one() {
                return Err(Error::DimensionlessRepeating { name: variable.name.clone() });
            }
            if let Err(made_of) = span.insert(name, variable.dimension.exponents()) {
                let on: Vec<_> = repeating.iter().filter(|other| made_of.contains_key(**other)).collect();
                return Err(Error::DependentRepeating {
                    dependent: variable.name.clone(),
                    on: in_words(&on),
                    relation: relation(&self.variables, name, &made_of).to_string(),
                });
            }
        }
        Ok(span)
    }

    fn insufficient(&self, repeating: &[&str], variable: &Variable, span: &Span) -> Error {
        Error::InsufficientRepeating {
            repeating: in_words(repeating),
            variable: variable.name.clone(),
            dimension: variable.dimension.to_string(),
            candidates: self.beyond(span),
        }
    }

    fn span(&self, variables: &[&Variable]) -> Span {
        let mut span = Span::default();
        for variable in variables {
            // A dependent variable adds nothing to the rank.
            let _ = span.insert(&variable.name, variable.dimension.exponents());
        }
        span
    }
}

/// The group that says that `name` is `made_of` others.
pub(crate) fn relation(variables: &[Variable], name: &str, made_of: &Exponents) -> Group {
    let mut exponents: Exponents = made_of.iter().map(|(symbol, e)| (symbol.clone(), -e.clone())).collect();
    multiply_symbol(&mut exponents, name, &BigRational::one());
    clear_denominators(&mut exponents);
    Group::in_order(variables, exponents)
}

fn check_name(name: &str) -> Result<(), Error> {
    let begins = name.chars().next().is_some_and(begins_symbol);
    let forbidden = |c: char| c.is_whitespace() || matches!(c, '*' | '/' | '(' | ')' | '·' | '×' | '⋅');
    let powers = name.split('^').skip(1).all(|after| after.chars().next().is_some_and(begins_symbol));
    if begins && powers && !name.contains(forbidden) {
        return Ok(());
    }
    Err(Error::BadName { name: name.into(), allowed: VARIABLE_NAME })
}

impl TryFrom<Vec<Variable>> for System {
    type Error = Error;
    fn try_from(variables: Vec<Variable>) -> Result<Self, Error> {
        Self::new(variables)
    }
}

impl From<System> for Vec<Variable> {
    fn from(system: System) -> Self {
        system.variables
    }
}
