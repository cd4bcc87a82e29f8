//! The rig: plant, controller loops and set points, from a file or built by hand.

use std::path::Path;

use bat_dynamics::{FIELDS, Fidelity, Parameters, Plant, TetherLayout};
use tether_control::{Controller, ControllerParameters, FilteredPd, SetPoints};

use crate::error::{Error, FileError};
use crate::quantity::{Range, Reader, Record, Section, read_file};

/// A tethered aerostat with its controller.
///
/// Values are public: they are checked where a flight begins.
#[derive(Clone, Debug, PartialEq)]
pub struct Rig {
    /// The plant's parameters; the lines' layout and the winches' speed limit serve the controller too.
    pub plant: Parameters,
    /// The altitude loop (10).
    pub altitude: FilteredPd,
    /// The pitch loop (11).
    pub pitch: FilteredPd,
    /// The roll loop (12).
    pub roll: FilteredPd,
    /// Set points of the three loops.
    pub set_points: SetPoints,
    /// Sample time of the controller, in s.
    pub sample_time_s: f64,
}

/// A rig with the title and the provenance of every number of its file.
#[derive(Clone, Debug, PartialEq)]
pub struct RigFile {
    /// The title of the file.
    pub title: String,
    /// The rig.
    pub rig: Rig,
    /// Every number as written, in the order of reading.
    pub records: Vec<Record>,
}

impl Rig {
    /// The plant at a fidelity, checked.
    ///
    /// # Errors
    /// [`Error::Plant`] for a parameter out of range.
    pub fn plant(&self, fidelity: Fidelity) -> Result<Plant, Error> {
        Ok(Plant::new(&self.plant, fidelity)?)
    }

    /// The controller, checked.
    ///
    /// # Errors
    /// [`Error::Controller`] for a parameter out of range.
    pub fn controller(&self) -> Result<Controller, Error> {
        Ok(Controller::new(ControllerParameters {
            altitude: self.altitude,
            pitch: self.pitch,
            roll: self.roll,
            set_points: self.set_points,
            sample_time_s: self.sample_time_s,
            layout: match self.plant.layout {
                TetherLayout::OneForwardTwoAft => tether_control::TetherLayout::OneForwardTwoAft,
                TetherLayout::TwoForwardOneAft => tether_control::TetherLayout::TwoForwardOneAft,
            },
            speed_limit_m_s: self.plant.winch.speed_limit_m_s,
        })?)
    }
}

impl RigFile {
    /// Reads a rig from a TOML file.
    ///
    /// # Errors
    /// [`FileError`], with the file, the key, what was found and what is allowed. Unknown keys are errors.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, FileError> {
        read_file(path.as_ref(), Self::parse)
    }

    /// Reads a rig from the text of a TOML file; see [`RigFile::read`].
    ///
    /// # Errors
    /// [`FileError`], without the name of a file.
    pub fn parse(text: &str) -> Result<Self, FileError> {
        let ((title, rig), records) = Reader::parse(text, |top| {
            let title = top.text("title")?;
            let plant = top.section("plant", plant)?;
            let rig = top.section("controller", |controller| {
                Ok(Rig {
                    plant,
                    altitude: controller.section("altitude", |s| filtered_pd(s, "1/s", "1"))?,
                    pitch: controller.section("pitch", |s| filtered_pd(s, "m/(s*rad)", "m/rad"))?,
                    roll: controller.section("roll", |s| filtered_pd(s, "m/(s*rad)", "m/rad"))?,
                    set_points: SetPoints {
                        altitude_m: controller.quantity("altitude_set_point", "m", Range::Positive)?,
                        pitch_rad: controller.quantity("pitch_set_point", "rad", Range::WithinQuarterTurn)?,
                        roll_rad: controller.quantity("roll_set_point", "rad", Range::WithinQuarterTurn)?,
                    },
                    sample_time_s: controller.quantity("sample_time", "s", Range::Positive)?,
                })
            })?;
            Ok((title, rig))
        })?;
        rig.plant(Fidelity::STALLED_WITH_ADDED_MASS).map_err(FileError::Inconsistent)?;
        rig.controller().map_err(FileError::Inconsistent)?;
        Ok(Self { title, rig, records })
    }
}

fn filtered_pd(section: &Section<'_>, proportional: &str, derivative: &str) -> Result<FilteredPd, FileError> {
    let proportional = section.quantity("proportional", proportional, Range::Finite)?;
    let derivative = section.quantity("derivative", derivative, Range::Finite)?;
    let time_constant_s = section.quantity("time_constant", "s", Range::Positive)?;
    FilteredPd::new(proportional, derivative, time_constant_s).map_err(|error| FileError::Inconsistent(error.into()))
}

/// Walks the plant's own table of fields, so that a field is declared in one place only.
fn plant(top: &Section<'_>) -> Result<Parameters, FileError> {
    let mut values = vec![f64::NAN; FIELDS.len()];
    let mut layout = TetherLayout::default();
    let mut start = 0;
    while start < FIELDS.len() {
        let name = FIELDS[start].section;
        let end = start + FIELDS[start..].iter().take_while(|field| field.section == name).count();
        top.section(name, |section| {
            for (value, field) in values[start..end].iter_mut().zip(&FIELDS[start..end]) {
                *value = section.quantity(field.name, field.unit, Range::Finite)?;
                if !field.allowed.admits(*value) {
                    return Err(section.refuse(field.name, *value, field.unit, field.allowed.words()));
                }
            }
            if name == "tether" {
                layout = section.choice("layout", "one-forward-two-aft or two-forward-one-aft", None)?;
            }
            Ok(())
        })?;
        start = end;
    }
    let mut next = values.into_iter();
    Parameters::from_fields(layout, |_| Ok(next.next().unwrap_or(f64::NAN)))
}
