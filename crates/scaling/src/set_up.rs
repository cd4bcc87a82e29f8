//! The values of the variables at one rig, model or plant.

use std::collections::BTreeMap;

use crate::dimension::Dimension;
use crate::error::Error;
use crate::number::shortest_decimal;
use crate::units::Units;

/// A name and values in coherent units (SI: m, kg, s, …).
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SetUp {
    name: String,
    values: BTreeMap<String, Value>,
}

#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct Value {
    value: f64,
    /// Half a unit of the last printed digit, 0 for a value taken as exact.
    half_unit: f64,
    /// Unit string and dimension, where given.
    unit: Option<(String, Dimension)>,
}

impl SetUp {
    /// A set-up without values.
    #[must_use]
    pub fn new(name: impl Into<String>) -> Self {
        Self { name: name.into(), values: BTreeMap::new() }
    }

    /// Adds a value in the coherent unit, taken as exact; a second value for the same variable replaces the first.
    #[must_use]
    pub fn with(mut self, variable: impl Into<String>, value: f64) -> Self {
        self.values.insert(variable.into(), Value { value, half_unit: 0.0, unit: None });
        self
    }

    /// Adds a value in a unit, taken as exact; the check of similarity compares the unit with the variable.
    ///
    /// # Errors
    /// [`Error::InSetUp`] with what [`Units::parse`] says of the unit.
    pub fn with_unit(
        mut self,
        units: &Units,
        variable: impl Into<String>,
        value: f64,
        unit: &str,
    ) -> Result<Self, Error> {
        let variable = variable.into();
        let read = units.parse(unit).map_err(|fault| self.fault(&variable, fault))?;
        let value = read.factor.apply(value);
        let unit = Some((unit.to_owned(), read.dimension));
        self.values.insert(variable, Value { value, half_unit: 0.0, unit });
        Ok(self)
    }

    /// Adds a value as printed, known to half a unit of its last digit: `"26"` is anything from 25.5 to 26.5.
    ///
    /// A check then tells a mismatch from what rounding explains.
    ///
    /// # Errors
    /// [`Error::InSetUp`] with [`Error::NotANumber`], or with what [`Units::parse`] says of the unit.
    pub fn printed(
        mut self,
        units: &Units,
        variable: impl Into<String>,
        printed: &str,
        unit: &str,
    ) -> Result<Self, Error> {
        let variable = variable.into();
        let value = read_printed(units, printed, unit).map_err(|fault| self.fault(&variable, fault))?;
        self.values.insert(variable, value);
        Ok(self)
    }

    fn fault(&self, variable: &str, fault: Error) -> Error {
        Error::InSetUp { set_up: self.name.clone(), variable: variable.to_owned(), fault: Box::new(fault) }
    }

    /// The name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The value of a variable in the coherent unit.
    #[must_use]
    pub fn value(&self, variable: &str) -> Option<f64> {
        self.values.get(variable).map(|value| value.value)
    }

    /// The variables that have a value.
    pub fn variables(&self) -> impl Iterator<Item = &str> {
        self.values.keys().map(String::as_str)
    }

    /// By what fraction of itself a value may be off because of its printed digits.
    pub(crate) fn relative_rounding(&self, variable: &str) -> f64 {
        match self.values.get(variable) {
            Some(value) if value.half_unit > 0.0 && value.value != 0.0 => value.half_unit / value.value.abs(),
            _ => 0.0,
        }
    }

    /// Unit string and dimension of a value, where given.
    pub(crate) fn unit(&self, variable: &str) -> Option<&(String, Dimension)> {
        self.values.get(variable)?.unit.as_ref()
    }
}

/// A value with half a unit of its last printed digit.
fn read_printed(units: &Units, printed: &str, unit: &str) -> Result<Value, Error> {
    let not_a_number = || Error::NotANumber { found: format!("\"{printed}\"") };
    let value: f64 = printed.trim().parse().map_err(|_| not_a_number())?;
    if shortest_decimal(value).is_none() {
        return Err(not_a_number());
    }
    let (mantissa, power) = printed.trim().split_once(['e', 'E']).unwrap_or((printed.trim(), "0"));
    let decimals = mantissa.split_once('.').map_or(0, |(_, fraction)| fraction.len());
    let power = power.parse::<i64>().ok().and_then(|power| power.checked_sub(i64::try_from(decimals).ok()?));
    let half: f64 = format!("0.5e{}", power.ok_or_else(not_a_number)?).parse().map_err(|_| not_a_number())?;
    let read = units.parse(unit)?;
    Ok(Value {
        value: read.factor.apply(value),
        half_unit: read.factor.apply(half),
        unit: Some((unit.to_owned(), read.dimension)),
    })
}
