//! The rig: plant, controller loops and set points, from a file or built by hand.

use std::path::Path;

use bat_dynamics::{Fidelity, Parameters, Plant, TetherLayout};
use serde::Deserialize;
use tether_control::{Controller, ControllerParameters, FilteredPd, SetPoints};

use crate::error::{Error, FileError};
use crate::file;
use crate::masses::{Masses, MassesTable};
use crate::plant_table::PlantTable;
use crate::quantity::{Altitude, Attitude, LengthPerAngle, PerSecond, Period, Plain, Record, SpeedPerAngle};
use crate::sensing::{Sensing, SensingTable, Viewer};

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
    /// Cameras and dots through which the controller sees the body; without them it sees the state.
    pub sensing: Option<Sensing>,
    /// What moves along with a design; without it a design moves the center of mass and the areas alone, as if other ballast saw to
    /// the rest.
    pub masses: Option<Masses>,
}

/// A rig with the title and the provenance of every number of its file.
///
/// # The file
/// `title`, then in `[plant.*]` the sections and keys of [`FIELDS`](bat_dynamics::FIELDS), with their units and ranges: positions in
/// fractions of the chord aft of the leading edge, heights above the bridle joint; in `[plant.tether]` also `layout`,
/// `one-forward-two-aft` or `two-forward-one-aft`. `[plant.asymmetry]` with the keys of
/// [`OPTIONAL_FIELDS`](bat_dynamics::OPTIONAL_FIELDS) may be left out, and so may each of its keys: they are then zero.
///
/// | key of `[controller]` | unit (range) |
/// |---|---|
/// | `sample_time`, `altitude_set_point` | s, m (> 0) |
/// | `pitch_set_point`, `roll_set_point` | rad |
/// | `[controller.altitude]`: `proportional`, `derivative`, `time_constant` | 1/s, 1, s (> 0) |
/// | `[controller.pitch]`, `[controller.roll]`: the same | m/(s*rad), m/rad, s (> 0) |
///
/// An optional section `[sensing]` is that of [`SensingFile`](crate::SensingFile). So is `[masses]`, for a body whose mass follows
/// the design; the body of the file, ballast and fins included, is then the one with the center of mass of the file, and its area
/// factors have to be 1. See [`MassModel`](bat_dynamics::MassModel).
///
/// | key of `[masses]` | unit (range) |
/// |---|---|
/// | `[masses.ballast]`: `mass` | kg (> 0) |
/// | `x`: along the chord; `y`: to starboard, zero where left out; `height`: above the joint | chord, m, m |
/// | `[masses.horizontal_stabilizer]`, `[masses.vertical_stabilizer]`: `mass`, `volume` | kg (> 0), m^3 (>= 0) |
/// | `offset_x`: aft of the root; `offset_height`, `offset_lateral`: from it, the latter zero where left out | chord, m, m |
/// | `inertia_xx`, `inertia_yy`, `inertia_zz`; `inertia_xz`, zero where left out | kg*m^2 (>= 0); kg*m^2 |
///
/// # Numbers in files
/// Every number is a table `{ value, unit, provenance, source }`; `provenance` is one of [`Provenance`](crate::Provenance).
/// In place of the units above a file may use `g`, `g/m`, `cm`, `mm`, `cm^2`, `cm^3`, `cm/s`, `mm/s`, `ms`, `min`, `deg`, `1/deg`,
/// `% chord` for a fraction of the chord, and `%` for a plain number.
#[derive(Clone, Debug, PartialEq)]
pub struct RigFile {
    /// The title of the file.
    pub title: String,
    /// The rig.
    pub rig: Rig,
    /// Every number as written, sorted by key.
    pub records: Vec<Record>,
}

impl Rig {
    /// The parameters of the plant, with what moves along with the design where it should be.
    ///
    /// # Errors
    /// [`Error::Plant`] for masses or a design out of range.
    pub fn parameters(&self) -> Result<Parameters, Error> {
        self.masses.as_ref().map_or(Ok(self.plant), |masses| masses.parameters(&self.plant))
    }

    /// The plant at a fidelity, checked.
    ///
    /// # Errors
    /// [`Error::Plant`] for a parameter out of range.
    pub fn plant(&self, fidelity: Fidelity) -> Result<Plant, Error> {
        Ok(Plant::new(&self.parameters()?, fidelity)?)
    }

    /// x_cm − x_cb in per cent of chord: how far the center of mass lies aft of the center of buoyancy, which (21) weighs. Of a rig
    /// that cannot be, which no flight is made of, as its numbers stand.
    #[must_use]
    pub fn ballast_pct_chord(&self) -> f64 {
        let body = self.parameters().unwrap_or(self.plant).body;
        100.0 * (body.center_of_mass_x - body.center_of_buoyancy_x)
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

    /// The cameras, if there are any, for poses of the center of mass, checked.
    ///
    /// # Errors
    /// [`Error::Sensing`] for what [`Viewer::new`] refuses; [`Error::Plant`] for masses or a design out of range.
    pub fn viewer(&self) -> Result<Option<Viewer>, Error> {
        let body = self.parameters()?.body;
        let center_of_mass_m =
            [-(body.center_of_mass_x - body.joint_x) * body.chord_m, 0.0, -body.center_of_mass_height_m];
        self.sensing.as_ref().map(|sensing| Viewer::new(sensing, center_of_mass_m)).transpose()
    }
}

impl RigFile {
    /// Reads a rig from a TOML file.
    ///
    /// # Errors
    /// [`FileError`], with the file, the key, what was found and what is allowed. Unknown keys are errors.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, FileError> {
        file::read(path.as_ref(), Self::parse)
    }

    /// Reads a rig from the text of a TOML file; see [`RigFile::read`].
    ///
    /// # Errors
    /// [`FileError`], without the name of a file.
    pub fn parse(text: &str) -> Result<Self, FileError> {
        let (table, records) = file::parse::<RigTable>(text)?;
        let title = table.title.clone();
        table.check_factors()?;
        let rig = table.rig().map_err(FileError::Inconsistent)?;
        rig.plant(Fidelity::STALLED_WITH_ADDED_MASS).map_err(FileError::Inconsistent)?;
        rig.controller().map_err(FileError::Inconsistent)?;
        rig.viewer().map_err(FileError::Inconsistent)?;
        Ok(Self { title, rig, records })
    }
}

/// A rig as it stands in a file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
struct RigTable {
    title: String,
    plant: PlantTable,
    controller: ControllerTable,
    sensing: Option<SensingTable>,
    masses: Option<MassesTable>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
struct ControllerTable {
    sample_time: Period,
    altitude_set_point: Altitude,
    pitch_set_point: Attitude,
    roll_set_point: Attitude,
    altitude: AltitudeLoop,
    pitch: AngleLoop,
    roll: AngleLoop,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
struct AltitudeLoop {
    proportional: PerSecond,
    derivative: Plain,
    time_constant: Period,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
struct AngleLoop {
    proportional: SpeedPerAngle,
    derivative: LengthPerAngle,
    time_constant: Period,
}

impl RigTable {
    /// Masses are those of the body at area factors of 1.
    fn check_factors(&self) -> Result<(), FileError> {
        let plant = &self.plant.0;
        let factors = [
            ("horizontal_stabilizer", plant.horizontal_stabilizer.area_factor),
            ("vertical_stabilizer", plant.vertical_stabilizer.area_factor),
        ];
        let other = factors.into_iter().find(|(_, factor)| self.masses.is_some() && (factor - 1.0).abs() > 0.0);
        other.map_or(Ok(()), |(section, factor)| {
            Err(FileError::Value {
                key: format!("plant.{section}.area_factor"),
                found: factor.to_string(),
                expected: "1, as there is a section `masses`".to_owned(),
            })
        })
    }

    fn rig(self) -> Result<Rig, Error> {
        let ControllerTable { sample_time, altitude, pitch, roll, .. } = &self.controller;
        let angle = |pd: &AngleLoop| FilteredPd::new(pd.proportional.0, pd.derivative.0, pd.time_constant.0);
        let plant = self.plant.0;
        Ok(Rig {
            plant,
            altitude: FilteredPd::new(altitude.proportional.0, altitude.derivative.0, altitude.time_constant.0)?,
            pitch: angle(pitch)?,
            roll: angle(roll)?,
            set_points: SetPoints {
                altitude_m: self.controller.altitude_set_point.0,
                pitch_rad: self.controller.pitch_set_point.0,
                roll_rad: self.controller.roll_set_point.0,
            },
            sample_time_s: sample_time.0,
            sensing: self.sensing.map(SensingTable::sensing),
            masses: self.masses.map(|masses| masses.at(plant.body.center_of_mass_x)),
        })
    }
}
