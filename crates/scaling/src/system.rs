//! The variables on which something depends.

use std::collections::BTreeSet;

use crate::dimension::Dimension;
use crate::error::Error;
use crate::near::near_misses;
use crate::parse::begins_symbol;
use crate::span::Span;
use crate::units::Units;

/// A named quantity and what it measures.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
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

    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        self.variables.iter().map(|variable| variable.name.as_str())
    }

    /// The variables that a span does not reach.
    pub(crate) fn beyond(&self, span: &Span) -> Vec<String> {
        let beyond = self.variables.iter().filter(|v| span.express(v.dimension.exponents()).is_err());
        beyond.map(|v| v.name.clone()).collect()
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

pub(crate) fn check_name(name: &str) -> Result<(), Error> {
    let begins = name.chars().next().is_some_and(begins_symbol);
    let forbidden = |c: char| c.is_whitespace() || matches!(c, '*' | '/' | '(' | ')' | '·' | '×' | '⋅');
    let powers = name.split('^').skip(1).all(|after| after.chars().next().is_some_and(begins_symbol));
    if begins && powers && !name.contains(forbidden) {
        return Ok(());
    }
    Err(Error::BadName { name: name.into(), expected: VARIABLE_NAME })
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
