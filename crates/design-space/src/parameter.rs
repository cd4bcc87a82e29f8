//! One quantity that is set before an experiment: its name, unit, bounds and levels.

use serde::{Deserialize, Serialize};

use crate::{Error, Levels};

/// A quantity with a name, a unit, two bounds and the levels it can take between them.
///
/// Natural coordinates are in the parameter's own unit; coded coordinates run from −1 at the lower
/// bound to 1 at the upper bound.
///
/// ```
/// use design_space::Parameter;
/// let pitch = Parameter::continuous("pitch", "deg", 8.0, 9.8)?.with_levels(19)?;
/// assert_eq!(pitch.level(3)?, 8.3);
/// assert_eq!(pitch.nearest_level(8.34)?, 3);
/// assert_eq!(pitch.coded(8.9), 0.0);
/// # Ok::<(), design_space::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "UncheckedParameter")]
pub struct Parameter {
    name: String,
    unit: String,
    lower: f64,
    upper: f64,
    levels: Levels,
    /// Names of what can be chosen, in order; level i is choice i. None for a number.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    choices: Option<Vec<String>>,
}

impl Parameter {
    /// The largest magnitude of a bound, 1e290 in the parameter's unit: beyond it the arithmetic
    /// of levels could overflow.
    pub const LARGEST_BOUND: f64 = 1e290;

    /// A parameter that can take any value from `lower` to `upper`, both in `unit`.
    ///
    /// The unit is a label and may be empty; it is carried along, never interpreted.
    ///
    /// # Errors
    ///
    /// [`Error::EmptyName`], [`Error::BoundNotUsable`], [`Error::InvertedBounds`],
    /// [`Error::ZeroWidth`].
    pub fn continuous(name: impl Into<String>, unit: impl Into<String>, lower: f64, upper: f64) -> Result<Self, Error> {
        let (name, unit) = (name.into(), unit.into());
        if name.trim().is_empty() {
            return Err(Error::EmptyName { unit, lower, upper });
        }
        for (bound, value) in [("lower", lower), ("upper", upper)] {
            // The magnitude of NaN is not at most anything.
            if value.is_nan() || value.abs() > Self::LARGEST_BOUND {
                return Err(Error::BoundNotUsable { parameter: name, bound, value });
            }
        }
        if lower > upper {
            return Err(Error::InvertedBounds { parameter: name, lower, upper });
        }
        if lower >= upper {
            return Err(Error::ZeroWidth { parameter: name, value: lower });
        }
        Ok(Self { name, unit, lower, upper, levels: Levels::Continuous, choices: None })
    }

    /// A parameter that is no number but a choice: a material, a supplier, a shape. Its natural coordinate is the place of the
    /// choice in this list, from 0, and its levels are the choices; their order means nothing.
    ///
    /// ```
    /// use design_space::Parameter;
    /// let hull = Parameter::categorical("hull", ["foam", "film", "wood"])?;
    /// assert_eq!(hull.choice(1.0), Some("film"));
    /// assert_eq!(hull.choices().map(<[_]>::len), Some(3));
    /// # Ok::<(), design_space::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::EmptyName`], [`Error::Choices`] unless there are two choices or more, all named and all different.
    pub fn categorical(
        name: impl Into<String>,
        choices: impl IntoIterator<Item = impl Into<String>>,
    ) -> Result<Self, Error> {
        let choices: Vec<String> = choices.into_iter().map(Into::into).collect();
        let name = name.into();
        if name.trim().is_empty() {
            return Err(Error::EmptyName { unit: String::new(), lower: 0.0, upper: choices.len() as f64 });
        }
        let count = u32::try_from(choices.len()).unwrap_or(u32::MAX);
        let fault = |choice: &str, expected| {
            Err(Error::Choices { parameter: name.clone(), choice: choice.to_owned(), expected })
        };
        if !(2..=Self::MOST_CHOICES).contains(&count) {
            return fault("", "2 to 1000 choices");
        }
        for (place, choice) in choices.iter().enumerate() {
            if choice.trim().is_empty() || choice.trim() != choice {
                return fault(choice, "names without blanks around them");
            }
            if choices[..place].contains(choice) {
                return fault(choice, "each choice once");
            }
        }
        Ok(Self {
            choices: Some(choices),
            ..Self::continuous(name, "", 0.0, f64::from(count - 1))?.with_levels(count)?
        })
    }

    /// More choices than these are a slip.
    const MOST_CHOICES: u32 = 1000;

    /// What can be chosen, if it is a choice and no number.
    #[must_use]
    pub fn choices(&self) -> Option<&[String]> {
        self.choices.as_deref()
    }

    /// The name of the choice at this natural coordinate; none for a number, or between two choices.
    #[must_use]
    pub fn choice(&self, natural: f64) -> Option<&str> {
        let mut choices = (0_u32..).zip(self.choices()?);
        choices.find(|(place, _)| (f64::from(*place) - natural).abs() < 0.5e-9).map(|(_, choice)| choice.as_str())
    }

    /// The natural coordinate of the choice of this name.
    #[must_use]
    pub fn of_choice(&self, name: &str) -> Option<f64> {
        self.choices()?.iter().position(|choice| choice == name).map(|place| place as f64)
    }

    /// An error for a choice, where only numbers will do.
    ///
    /// # Errors
    ///
    /// [`Error::Categorical`].
    pub fn check_number(&self) -> Result<(), Error> {
        match self.choices {
            Some(_) => Err(Error::Categorical { parameter: self.name.clone() }),
            None => Ok(()),
        }
    }

    /// The same parameter restricted to `count` equally spaced levels, both bounds included.
    ///
    /// # Errors
    ///
    /// [`Error::Categorical`], [`Error::TooFewLevels`] below two, [`Error::IndistinctLevels`] when neighboring levels would
    /// be within a few roundings of each other.
    pub fn with_levels(mut self, count: u32) -> Result<Self, Error> {
        self.check_number()?;
        if count < 2 {
            return Err(Error::TooFewLevels { parameter: self.name, count });
        }
        let spacing = self.width() / f64::from(count - 1);
        let resolution = 8.0 * f64::EPSILON * self.lower.abs().max(self.upper.abs());
        if spacing <= resolution.max(f64::MIN_POSITIVE) {
            return Err(Error::IndistinctLevels { parameter: self.name, count, lower: self.lower, upper: self.upper });
        }
        self.levels = Levels::Count(count);
        Ok(self)
    }

    /// The name, unique within a [`Region`](crate::Region).
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The unit of the bounds and of every natural coordinate.
    #[must_use]
    pub fn unit(&self) -> &str {
        &self.unit
    }

    /// The lower bound, in the parameter's unit.
    #[must_use]
    pub fn lower(&self) -> f64 {
        self.lower
    }

    /// The upper bound, in the parameter's unit.
    #[must_use]
    pub fn upper(&self) -> f64 {
        self.upper
    }

    /// The levels between the bounds.
    #[must_use]
    pub fn levels(&self) -> Levels {
        self.levels
    }

    /// Upper bound minus lower bound: positive and finite, in the parameter's unit.
    #[must_use]
    pub fn width(&self) -> f64 {
        self.upper - self.lower
    }

    /// The value halfway between the bounds, in the parameter's unit; of a choice that may be no choice.
    #[must_use]
    pub fn center(&self) -> f64 {
        self.natural(0.0)
    }

    /// Natural to coded: the lower bound gives exactly −1, the upper exactly 1. Values outside the
    /// bounds are extrapolated, NaN stays NaN.
    #[must_use]
    pub fn coded(&self, natural: f64) -> f64 {
        ((natural - self.lower) - (self.upper - natural)) / self.width()
    }

    /// Coded to natural: −1 gives exactly the lower bound, 1 exactly the upper, and nothing between
    /// them is rounded past a bound. Values outside −1 to 1 are extrapolated, NaN stays NaN.
    #[must_use]
    pub fn natural(&self, coded: f64) -> f64 {
        let value = self.lower * (0.5 * (1.0 - coded)) + self.upper * (0.5 * (1.0 + coded));
        if coded.abs() <= 1.0 { value.clamp(self.lower, self.upper) } else { value }
    }

    /// Whether a natural coordinate lies within the bounds, bounds included; never for NaN. Of a choice only the places of its
    /// choices do, as [`choice`](Self::choice) reads them: nothing lies between two of them.
    #[must_use]
    pub fn contains(&self, natural: f64) -> bool {
        self.is_within_bounds(natural) && (self.choices.is_none() || self.choice(natural).is_some())
    }

    fn is_within_bounds(&self, natural: f64) -> bool {
        self.lower <= natural && natural <= self.upper
    }

    /// The natural coordinate itself if it lies within the bounds, and is the place of a choice where it has to be.
    ///
    /// # Errors
    ///
    /// [`Error::NotANumber`], [`Error::OutOfBounds`], [`Error::NotAChoice`].
    pub fn check(&self, natural: f64) -> Result<f64, Error> {
        if self.contains(natural) {
            return Ok(natural);
        }
        let (parameter, unit) = (self.name.clone(), self.unit.clone());
        let (lower, upper) = (self.lower, self.upper);
        Err(match self.places() {
            _ if natural.is_nan() => Error::NotANumber { parameter, lower, upper, unit },
            Some(expected) if self.is_within_bounds(natural) => {
                Error::NotAChoice { parameter, value: natural, expected }
            }
            _ => Error::OutOfBounds { parameter, value: natural, lower, upper, unit },
        })
    }

    /// The places of the choices with their names, for a message; none for a number.
    fn places(&self) -> Option<String> {
        let choices = self.choices()?;
        let named = |place: usize| format!("{place} ({})", choices[place]);
        let last = choices.len() - 1;
        let shown: Vec<String> = (0..last.min(Self::MOST_NAMED)).map(named).collect();
        let more = if last > Self::MOST_NAMED { ", and so on," } else { "" };
        Some(format!("{}{more} or {}", shown.join(", "), named(last)))
    }

    /// How many choices a message names before the last one.
    const MOST_NAMED: usize = 8;

    /// The nearest value that [`check`](Self::check) takes: within the bounds, and of a choice the nearest place, of two
    /// equally near the lower. Nothing else in this crate moves a value: who wants that asks for it here.
    ///
    /// # Errors
    ///
    /// [`Error::NotANumber`].
    pub fn clamp(&self, natural: f64) -> Result<f64, Error> {
        if natural.is_nan() {
            return self.check(natural);
        }
        let within = natural.clamp(self.lower, self.upper);
        // Half of one is taken away exactly from what is at most 999, and 0 is added so that none is left of its sign.
        Ok(if self.contains(within) { within } else { (within - 0.5).ceil() + 0.0 })
    }

    /// Value of the level with this index, in the parameter's unit: index 0 is the lower bound.
    ///
    /// With bounds l and u and n levels, level i is (l (n − 1 − i) + u i) / (n − 1): weights that are
    /// whole numbers, so that 8 to 9.8 in 19 levels has the level 8.3 and both bounds are exact.
    ///
    /// # Errors
    ///
    /// [`Error::Continuous`], [`Error::NoSuchLevel`].
    pub fn level(&self, index: u32) -> Result<f64, Error> {
        let last = self.last_level()?;
        if index > last {
            return Err(Error::NoSuchLevel { parameter: self.name.clone(), index: index.into(), last: last.into() });
        }
        Ok(self.level_value(index, last))
    }

    /// Index of the level nearest to a natural coordinate; of two equally near, the lower.
    ///
    /// # Errors
    ///
    /// [`Error::Continuous`], and those of [`check`](Self::check): a value outside the bounds, or between two choices, is not
    /// moved silently, see [`clamp`](Self::clamp).
    pub fn nearest_level(&self, natural: f64) -> Result<u32, Error> {
        let last = self.last_level()?;
        self.check(natural)?;
        let estimate = (natural - self.lower) / self.width() * f64::from(last);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a value within the bounds estimates an index from 0 to last"
        )]
        let middle = (estimate.round() as u32).min(last);
        // The estimate is rounded: its neighbors decide which level is nearest in fact.
        let mut nearest = middle.saturating_sub(1);
        for index in nearest + 1..=(middle + 1).min(last) {
            let distance = |index| (self.level_value(index, last) - natural).abs();
            if distance(index) < distance(nearest) {
                nearest = index;
            }
        }
        Ok(nearest)
    }

    /// The value of the nearest level, or the value itself if the parameter is continuous.
    ///
    /// # Errors
    ///
    /// Those of [`check`](Self::check).
    pub fn snap(&self, natural: f64) -> Result<f64, Error> {
        match self.levels {
            Levels::Continuous => self.check(natural),
            Levels::Count(_) => self.level(self.nearest_level(natural)?),
        }
    }

    fn last_level(&self) -> Result<u32, Error> {
        match self.levels {
            Levels::Count(count) => Ok(count - 1),
            Levels::Continuous => Err(Error::Continuous { parameter: self.name.clone() }),
        }
    }

    fn level_value(&self, index: u32, last: u32) -> f64 {
        if index == 0 {
            return self.lower;
        }
        if index == last {
            return self.upper;
        }
        let weighted = self.lower * f64::from(last - index) + self.upper * f64::from(index);
        // Rounding can carry a level next to a bound past it when the bounds almost agree.
        (weighted / f64::from(last)).clamp(self.lower, self.upper)
    }
}

/// A parameter as it stands in a file, before its numbers are checked.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename = "Parameter")]
struct UncheckedParameter {
    name: String,
    unit: String,
    lower: f64,
    upper: f64,
    #[serde(default)]
    levels: Levels,
    #[serde(default)]
    choices: Option<Vec<String>>,
}

impl TryFrom<UncheckedParameter> for Parameter {
    type Error = Error;

    fn try_from(unchecked: UncheckedParameter) -> Result<Self, Error> {
        let UncheckedParameter { name, unit, lower, upper, levels, choices } = unchecked;
        if let Some(choices) = choices {
            let parameter = Self::categorical(name, choices)?;
            if (unit.as_str(), lower, upper, levels) == ("", 0.0, parameter.upper, parameter.levels) {
                return Ok(parameter);
            }
            let expected = "no unit, and the places of the choices as levels, from 0";
            return Err(Error::Choices { parameter: parameter.name, choice: String::new(), expected });
        }
        let parameter = Self::continuous(name, unit, lower, upper)?;
        match levels {
            Levels::Continuous => Ok(parameter),
            Levels::Count(count) => parameter.with_levels(count),
        }
    }
}
