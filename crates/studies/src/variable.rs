//! The design variables of the case study: their names in study files, their words on pages, their places in a rig.

use anyhow::{Result, bail};
use design_space::Parameter;
use water_channel::Rig;

use crate::words::capitalized;
use page::{Axis, Column};

/// A design variable of the case study.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Variable {
    /// Longitudinal position of the center of mass, in per cent of chord.
    CenterOfMass,
    /// Pitch set point, in degrees.
    PitchSetPoint,
    /// `A^H`, the factor on the area of the horizontal stabilizer.
    HorizontalArea,
    /// `A^V`, the factor on the area of the vertical stabilizer.
    VerticalArea,
}

impl Variable {
    pub(crate) const ALL: [Self; 4] =
        [Self::CenterOfMass, Self::PitchSetPoint, Self::HorizontalArea, Self::VerticalArea];

    /// A variable of a study file, its unit checked.
    pub(crate) fn named(name: &str, unit: &str) -> Result<Self> {
        let Some(variable) = Self::ALL.into_iter().find(|variable| variable.name() == name) else {
            bail!(
                "parameter.name = `{name}`: it must be center_of_mass, pitch_set_point, horizontal_area or vertical_area"
            );
        };
        if unit != variable.unit() {
            bail!("parameter `{name}` has the unit `{unit}`: it must be `{}`", variable.unit());
        }
        Ok(variable)
    }

    /// A variable of a study file with its bounds.
    pub(crate) fn within(name: &str, unit: &str, lower: f64, upper: f64) -> Result<(Self, Parameter)> {
        Ok((Self::named(name, unit)?, Parameter::continuous(name, unit, lower, upper)?))
    }

    /// In study files.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::CenterOfMass => "center_of_mass",
            Self::PitchSetPoint => "pitch_set_point",
            Self::HorizontalArea => "horizontal_area",
            Self::VerticalArea => "vertical_area",
        }
    }

    pub(crate) fn unit(self) -> &'static str {
        match self {
            Self::CenterOfMass => "% chord",
            Self::PitchSetPoint => "deg",
            Self::HorizontalArea | Self::VerticalArea => "1",
        }
    }

    /// Within a sentence and on an axis.
    pub(crate) fn label(self) -> &'static str {
        match self {
            Self::CenterOfMass => "center of mass",
            Self::PitchSetPoint => "pitch set point",
            Self::HorizontalArea => "A^H",
            Self::VerticalArea => "A^V",
        }
    }

    /// At the head of a column.
    pub(crate) fn title(self) -> String {
        capitalized(self.label())
    }

    pub(crate) fn column(self) -> Column {
        Column::new(&self.title(), self.unit())
    }

    pub(crate) fn axis(self) -> Axis {
        Axis::new(self.label(), self.unit())
    }

    /// A value with its unit, or with the label where it has none.
    pub(crate) fn words(self, value: f64) -> String {
        match self {
            Self::CenterOfMass | Self::PitchSetPoint => format!("{value:.2} {}", self.unit()),
            Self::HorizontalArea | Self::VerticalArea => format!("{} {value:.2}", self.label()),
        }
    }

    /// Writes a value into a rig.
    pub(crate) fn set(self, rig: &mut Rig, value: f64) {
        match self {
            Self::CenterOfMass => rig.plant.body.center_of_mass_x = value / 100.0,
            Self::PitchSetPoint => rig.set_points.pitch_rad = value.to_radians(),
            Self::HorizontalArea => rig.plant.horizontal_stabilizer.area_factor = value,
            Self::VerticalArea => rig.plant.vertical_stabilizer.area_factor = value,
        }
    }
}

/// A point with its units, variable by variable.
pub(crate) fn point_words(variables: &[Variable], point: &[f64]) -> Vec<String> {
    variables.iter().zip(point).map(|(variable, value)| variable.words(*value)).collect()
}
