//! Independent dimensionless groups of a system: Buckingham's theorem.

use num_rational::BigRational;
use num_traits::{One, Signed};

use crate::dimension::Dimension;
use crate::error::{Error, in_words};
use crate::exponents::{Exponents, clear_denominators, multiply_symbol};
use crate::group::Group;
use crate::near::near_misses;
use crate::parse::{Atom, matches_whole, parse};
use crate::span::Span;
use crate::system::{System, Variable};

/// On which side of the line a group has the variable that does not repeat.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Orientation {
    /// `g*L_t/V^2`: above.
    #[default]
    Above,
    /// `V^2/(L_t*g)`: below.
    Below,
}

/// Independent groups of a system, from which all others are products of powers.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(try_from = "UncheckedGroups")]
pub struct Groups {
    system: System,
    repeating: Vec<String>,
    groups: Vec<Group>,
}

impl System {
    /// The dimensionless groups, one for each variable that does not repeat.
    ///
    /// ```
    /// use scaling::{System, Units};
    ///
    /// // Groups in scaled time t_bar = a t: the variables of a tethered body with times in units of t_bar, and a itself.
    /// let scaled = System::parse(&Units::si(), &[
    ///     ("L_t", "m"), ("M_a", "kg"), ("V_bar", "m/s"), ("g_bar", "m/s^2"), ("dTheta_dt_bar", "1/s"), ("a", "1"),
    /// ])?;
    /// let groups = scaled.groups(&["L_t", "M_a", "V_bar"])?;
    /// let written: Vec<String> = groups.iter().map(ToString::to_string).collect();
    /// assert_eq!(written, ["L_t*g_bar/V_bar^2", "L_t*dTheta_dt_bar/V_bar", "a"]);
    /// # Ok::<(), scaling::Error>(())
    /// ```
    ///
    /// Source: (15), (17), (19).
    ///
    /// # Errors
    /// [`Error::UnknownVariable`], [`Error::Duplicate`], [`Error::DimensionlessRepeating`],
    /// [`Error::DependentRepeating`] (also where there are too many), [`Error::InsufficientRepeating`].
    pub fn groups(&self, repeating: &[&str]) -> Result<Groups, Error> {
        let span = self.repeating_span(repeating)?;
        let mut groups = Vec::new();
        for variable in self.variables().iter().filter(|v| !repeating.contains(&v.name.as_str())) {
            let made_of = span
                .express(variable.dimension.exponents())
                .map_err(|_| self.insufficient(repeating, variable, &span))?;
            groups.push(relation(self.variables(), &variable.name, &made_of));
        }
        let repeating = repeating.iter().map(|name| (*name).to_owned()).collect();
        Ok(Groups { system: self.clone(), repeating, groups })
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
                        self.variables().iter().find(|v| v.name == symbol).ok_or_else(|| Error::UnknownSymbol {
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
        Ok(Group::in_order(self.variables(), exponents))
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
                    relation: relation(self.variables(), name, &made_of).to_string(),
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
}

impl Groups {
    /// The groups in the order of their variables that do not repeat.
    pub fn iter(&self) -> std::slice::Iter<'_, Group> {
        self.groups.iter()
    }

    /// How many groups there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.groups.len()
    }

    /// Whether there are no groups.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.groups.is_empty()
    }

    /// The system whose groups these are.
    #[must_use]
    pub fn system(&self) -> &System {
        &self.system
    }

    /// The repeating variables.
    #[must_use]
    pub fn repeating(&self) -> &[String] {
        &self.repeating
    }

    /// The same groups with the variables that do not repeat above or below the line.
    #[must_use]
    pub fn oriented(mut self, orientation: Orientation) -> Self {
        for group in &mut self.groups {
            let own = group.factors().find(|(name, _)| !self.repeating.iter().any(|other| other == name));
            let above = own.is_some_and(|(_, exponent)| exponent.is_positive());
            if above != (orientation == Orientation::Above) {
                *group = group.inverse();
            }
        }
        self
    }

    /// Whether other groups say the same: each is a product of powers of the other set's, in both directions.
    ///
    /// Groups that are written twice or depend on each other add nothing, so the counts may differ.
    #[must_use]
    pub fn span_same_space<'a>(&self, others: impl IntoIterator<Item = &'a Group>) -> bool {
        let mut span = Span::default();
        for group in &self.groups {
            let _ = span.insert(&group.to_string(), &group.exponents());
        }
        let mut theirs = Span::default();
        for group in others {
            if span.express(&group.exponents()).is_err() {
                return false;
            }
            // What depends on the former ones adds nothing to the rank.
            let _ = theirs.insert(&group.to_string(), &group.exponents());
        }
        theirs.rank() == span.rank()
    }
}

/// Groups as they stand in a file.
#[derive(serde::Deserialize)]
#[serde(rename = "Groups", deny_unknown_fields)]
struct UncheckedGroups {
    system: System,
    repeating: Vec<String>,
    groups: Vec<Group>,
}

impl TryFrom<UncheckedGroups> for Groups {
    type Error = Error;

    /// The groups of the system, if they are those that were read, above or below the line.
    fn try_from(read: UncheckedGroups) -> Result<Self, Error> {
        let repeating: Vec<&str> = read.repeating.iter().map(String::as_str).collect();
        let above = read.system.groups(&repeating)?;
        let below = above.clone().oriented(Orientation::Below);
        if let Some(own) = [&above, &below].into_iter().find(|own| own.groups == read.groups) {
            return Ok(own.clone());
        }
        let written = |groups: &[Group]| groups.iter().map(ToString::to_string).collect();
        let (found, expected) = (written(&read.groups), written(&above.groups));
        Err(Error::OtherGroups { repeating: in_words(&repeating), found, expected })
    }
}

impl<'a> IntoIterator for &'a Groups {
    type Item = &'a Group;
    type IntoIter = std::slice::Iter<'a, Group>;
    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

/// The group that says that `name` is `made_of` others.
pub(crate) fn relation(variables: &[Variable], name: &str, made_of: &Exponents) -> Group {
    let mut exponents: Exponents = made_of.iter().map(|(symbol, e)| (symbol.clone(), -e.clone())).collect();
    multiply_symbol(&mut exponents, name, &BigRational::one());
    clear_denominators(&mut exponents);
    Group::in_order(variables, exponents)
}
