//! The box of points that an experiment may visit.

use serde::{Deserialize, Serialize};

use crate::{Error, Parameter};

/// An ordered list of parameters with unique names. A point is a slice with one coordinate per
/// parameter, in this order.
///
/// ```
/// use design_space::{Parameter, Region};
/// let region = Region::new(vec![
///     Parameter::continuous("center of mass", "% chord", 45.0, 51.0)?,
///     Parameter::continuous("pitch", "deg", 10.0, 22.0)?,
/// ])?;
/// assert_eq!(region.coded(&[48.0, 22.0])?, [0.0, 1.0]);
/// assert!(!region.contains(&[48.0, 22.5])?);
/// assert_eq!(region.clamp(&[48.0, 22.5])?, [48.0, 22.0]);
/// # Ok::<(), design_space::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "UncheckedRegion")]
pub struct Region {
    parameters: Vec<Parameter>,
}

impl Region {
    /// A region with these parameters, in this order.
    ///
    /// # Errors
    ///
    /// [`Error::NoParameters`], [`Error::DuplicateName`].
    pub fn new(parameters: Vec<Parameter>) -> Result<Self, Error> {
        if parameters.is_empty() {
            return Err(Error::NoParameters);
        }
        for (second, parameter) in parameters.iter().enumerate() {
            let same_name = |earlier: &Parameter| earlier.name() == parameter.name();
            if let Some(first) = parameters[..second].iter().position(same_name) {
                return Err(Error::DuplicateName { name: parameter.name().to_owned(), first, second });
            }
        }
        Ok(Self { parameters })
    }

    /// The parameters, in order.
    #[must_use]
    pub fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    /// How many parameters there are: at least one.
    #[must_use]
    pub fn n_parameters(&self) -> usize {
        self.parameters.len()
    }

    /// Position of the parameter with this name.
    #[must_use]
    pub fn index_of(&self, name: &str) -> Option<usize> {
        self.parameters.iter().position(|parameter| parameter.name() == name)
    }

    /// The point halfway between all bounds, natural; of a choice that may be no choice, see [`clamp`](Self::clamp).
    #[must_use]
    pub fn center(&self) -> Vec<f64> {
        self.parameters.iter().map(Parameter::center).collect()
    }

    /// Natural to coded, coordinate by coordinate; see [`Parameter::coded`].
    ///
    /// # Errors
    ///
    /// [`Error::WrongDimension`].
    pub fn coded(&self, natural: &[f64]) -> Result<Vec<f64>, Error> {
        self.map(natural, |parameter, value| Ok(parameter.coded(value)))
    }

    /// Coded to natural, coordinate by coordinate; see [`Parameter::natural`].
    ///
    /// # Errors
    ///
    /// [`Error::WrongDimension`].
    pub fn natural(&self, coded: &[f64]) -> Result<Vec<f64>, Error> {
        self.map(coded, |parameter, value| Ok(parameter.natural(value)))
    }

    /// Whether every natural coordinate lies within its bounds, and none between two choices.
    ///
    /// # Errors
    ///
    /// [`Error::WrongDimension`].
    pub fn contains(&self, natural: &[f64]) -> Result<bool, Error> {
        self.check_dimension(natural.len())?;
        let mut pairs = self.parameters.iter().zip(natural);
        Ok(pairs.all(|(parameter, &value)| parameter.contains(value)))
    }

    /// Nothing if the natural point lies within the region.
    ///
    /// # Errors
    ///
    /// [`Error::WrongDimension`]; that of [`Parameter::check`] for the first coordinate at fault.
    pub fn check(&self, natural: &[f64]) -> Result<(), Error> {
        self.map(natural, Parameter::check).map(|_| ())
    }

    /// The nearest natural point within the region, coordinate by coordinate; see [`Parameter::clamp`].
    ///
    /// # Errors
    ///
    /// [`Error::WrongDimension`], [`Error::NotANumber`].
    pub fn clamp(&self, natural: &[f64]) -> Result<Vec<f64>, Error> {
        self.map(natural, Parameter::clamp)
    }

    /// The point with every coordinate on its nearest level; continuous coordinates stay.
    ///
    /// # Errors
    ///
    /// [`Error::WrongDimension`], and those of [`Parameter::check`].
    pub fn snap(&self, natural: &[f64]) -> Result<Vec<f64>, Error> {
        self.map(natural, Parameter::snap)
    }

    fn map(&self, point: &[f64], each: impl Fn(&Parameter, f64) -> Result<f64, Error>) -> Result<Vec<f64>, Error> {
        self.check_dimension(point.len())?;
        let pairs = self.parameters.iter().zip(point);
        pairs.map(|(parameter, &value)| each(parameter, value)).collect()
    }

    /// That something has one entry per parameter.
    pub(crate) fn check_dimension(&self, found: usize) -> Result<(), Error> {
        let expected = self.parameters.len();
        if found == expected {
            return Ok(());
        }
        let names: Vec<&str> = self.parameters.iter().map(Parameter::name).collect();
        Err(Error::WrongDimension { expected, found, names: names.join(", ") })
    }
}

/// A region as it stands in a file, before its names are checked.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename = "Region")]
struct UncheckedRegion {
    parameters: Vec<Parameter>,
}

impl TryFrom<UncheckedRegion> for Region {
    type Error = Error;

    fn try_from(unchecked: UncheckedRegion) -> Result<Self, Error> {
        Self::new(unchecked.parameters)
    }
}
