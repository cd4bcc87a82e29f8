//! What a flight did, sample by sample, as a table with units in its header.

use std::io::Write;

use bat_dynamics::STATE_NAMES;

use crate::footprint::footprint_m2;
use crate::integrate::{Carrier, Sample};
use crate::rig::Rig;
use crate::sensing::{Estimate, Hold};

/// One sample of a flight, in SI units and radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LogRow {
    /// Time.
    pub time_s: f64,
    /// Flow speed.
    pub flow_speed_m_s: f64,
    /// Flow direction.
    pub flow_direction_rad: f64,
    /// Altitude of the center of mass.
    pub altitude_m: f64,
    /// Lateral position of the center of mass in the ground frame, right looking upwind at psi_flow = 0.
    pub lateral_m: f64,
    /// Roll.
    pub roll_rad: f64,
    /// Pitch.
    pub pitch_rad: f64,
    /// Heading relative to the flow.
    pub heading_rad: f64,
    /// theta − theta_sp.
    pub pitch_error_rad: f64,
    /// phi − phi_sp.
    pub roll_error_rad: f64,
    /// h_sp − h.
    pub altitude_error_m: f64,
    /// The state: see [`bat_dynamics::FlightState`].
    pub state: [f64; 12],
    /// Commanded reel speeds: center, starboard, port.
    pub commands_m_s: [f64; 3],
    /// Line tensions: center, starboard, port.
    pub tensions_n: [f64; 3],
    /// What the cameras gave the controller, where the rig has cameras.
    pub estimate: Option<Estimate>,
}

impl LogRow {
    /// Zenith angle of the tether.
    #[must_use]
    pub fn zenith_rad(&self) -> f64 {
        self.state[0]
    }

    /// Area of land that the tether sweeps, in m², its length the mean of its lines.
    #[must_use]
    pub fn footprint_m2(&self) -> f64 {
        footprint_m2((self.state[6] + self.state[7] + self.state[8]) / 3.0, self.zenith_rad())
    }

    /// All numbers but those of the cameras, in the order of [`FlightLog::columns`].
    pub fn numbers(&self) -> impl Iterator<Item = f64> {
        let measured = [
            self.time_s,
            self.flow_speed_m_s,
            self.flow_direction_rad,
            self.altitude_m,
            self.lateral_m,
            self.roll_rad,
            self.pitch_rad,
            self.heading_rad,
            self.pitch_error_rad,
            self.roll_error_rad,
            self.altitude_error_m,
        ];
        measured.into_iter().chain(self.state).chain(self.commands_m_s).chain(self.tensions_n)
    }

    /// The numbers of the cameras, in the order of [`FlightLog::camera_columns`]; none without cameras.
    pub fn camera_numbers(&self) -> impl Iterator<Item = f64> {
        self.estimate.into_iter().flat_map(|Estimate { pose, dots_seen, cameras_seeing, hold }| {
            let [x, y, _, roll, pitch, heading] = pose.numbers();
            let hold = f64::from(hold.map_or(0, Hold::code));
            [x, y, pose.altitude_m(), roll, pitch, heading, dots_seen as f64, cameras_seeing as f64, hold]
        })
    }

    /// Of the flight in a lane.
    #[inline(always)]
    pub(crate) fn of<T: Carrier<N>, const N: usize>(sample: &Sample<'_, T, N>, lane: usize, rig: &Rig) -> Self {
        let (sight, tensions) = (&sample.evaluation.sight, &sample.evaluation.tensions);
        let own = |value: T| value.split()[lane];
        let (altitude_m, roll_rad, pitch_rad) = (own(sight.altitude_m), own(sight.roll_rad), own(sight.pitch_rad));
        Self {
            time_s: sample.time_s,
            flow_speed_m_s: sample.water.flow.speed_m_s,
            flow_direction_rad: sample.water.flow.direction_rad,
            altitude_m,
            lateral_m: own(sample.water.lateral(sight)),
            roll_rad,
            pitch_rad,
            heading_rad: own(sight.heading_rad),
            pitch_error_rad: pitch_rad - rig.set_points.pitch_rad,
            roll_error_rad: roll_rad - rig.set_points.roll_rad,
            altitude_error_m: rig.set_points.altitude_m - altitude_m,
            state: sample.state.map(own),
            commands_m_s: sample.control.commands.map(|line| line[lane]),
            tensions_n: [tensions.center_n, tensions.starboard_n, tensions.port_n].map(own),
            estimate: sample.control.estimates[lane],
        }
    }
}

/// The samples of a flight.
///
/// # Columns
/// | columns | unit |
/// |---|---|
/// | `time`; `flow_speed`, `flow_direction` | s; m/s, rad |
/// | `altitude`, `lateral` (in the ground frame) of the center of mass | m |
/// | `roll`, `pitch`, `heading_from_flow` | rad |
/// | `pitch_error`, `roll_error`, `altitude_error`: theta − theta_sp, phi − phi_sp, h_sp − h | rad, rad, m |
/// | the twelve states: `zenith`, `azimuth`, `twist`, their `_rate`, `line_` and `reel_` of the three lines | rad, rad/s, m, m/s |
/// | `command_` and `tension_` of `center`, `starboard`, `port` | m/s, N |
///
/// A flight with cameras has nine more, which say what the controller was given at the sample:
///
/// | columns | unit |
/// |---|---|
/// | `estimated_x`, `estimated_y` (in the ground frame), `estimated_altitude` of the center of mass | m |
/// | `estimated_roll`, `estimated_pitch`, `estimated_heading` (in the ground frame) | rad |
/// | `dots_seen`, `cameras_seeing`: dots seen by any camera, cameras that saw any | 1 |
/// | `hold`: 0 for a new pose, or why the last one was held, [`Hold::code`] | 1 |
///
/// A row is a sample before the plant moves on: its commands and tensions are those that hold after it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FlightLog {
    /// One row per kept sample, in the order of time.
    pub rows: Vec<LogRow>,
}

/// Header of the measured columns; the state's columns follow with their own names and units.
const COLUMNS: [(&str, &str); 11] = [
    ("time", "s"),
    ("flow_speed", "m/s"),
    ("flow_direction", "rad"),
    ("altitude", "m"),
    ("lateral", "m"),
    ("roll", "rad"),
    ("pitch", "rad"),
    ("heading_from_flow", "rad"),
    ("pitch_error", "rad"),
    ("roll_error", "rad"),
    ("altitude_error", "m"),
];
/// Columns of a flight with cameras.
const CAMERA_COLUMNS: [(&str, &str); 9] = [
    ("estimated_x", "m"),
    ("estimated_y", "m"),
    ("estimated_altitude", "m"),
    ("estimated_roll", "rad"),
    ("estimated_pitch", "rad"),
    ("estimated_heading", "rad"),
    ("dots_seen", "1"),
    ("cameras_seeing", "1"),
    ("hold", "1"),
];
const LINES: [&str; 3] = ["center", "starboard", "port"];

impl FlightLog {
    /// Name and unit of every column, in the order in which they are written.
    #[must_use]
    pub fn columns() -> Vec<(String, &'static str)> {
        let measured = COLUMNS.iter().map(|(name, unit)| ((*name).to_owned(), *unit));
        let states = STATE_NAMES.iter().zip(bat_dynamics::STATE_UNITS).map(|(name, unit)| ((*name).to_owned(), unit));
        let commands = LINES.iter().map(|line| (format!("command_{line}"), "m/s"));
        let tensions = LINES.iter().map(|line| (format!("tension_{line}"), "N"));
        measured.chain(states).chain(commands).chain(tensions).collect()
    }

    /// Name and unit of every further column that a flight with cameras has.
    #[must_use]
    pub fn camera_columns() -> Vec<(String, &'static str)> {
        CAMERA_COLUMNS.iter().map(|(name, unit)| ((*name).to_owned(), *unit)).collect()
    }

    /// The columns without those of the cameras as a file has them: `time [s]`.
    #[must_use]
    pub fn header() -> Vec<String> {
        headed(Self::columns())
    }

    /// Writes the log as CSV, with the columns of the cameras where the flight had any. Numbers are written so that they read back bit for bit.
    ///
    /// # Errors
    /// When `out` cannot be written.
    pub fn write_csv(&self, out: impl Write) -> Result<(), csv::Error> {
        let mut writer = csv::Writer::from_writer(out);
        let mut header = Self::header();
        if self.rows.first().is_some_and(|row| row.estimate.is_some()) {
            header.extend(headed(Self::camera_columns()));
        }
        writer.write_record(header)?;
        for row in &self.rows {
            writer.write_record(row.numbers().chain(row.camera_numbers()).map(|number| number.to_string()))?;
        }
        writer.flush()?;
        Ok(())
    }
}

fn headed(columns: Vec<(String, &'static str)>) -> Vec<String> {
    columns.into_iter().map(|(name, unit)| format!("{name} [{unit}]")).collect()
}
