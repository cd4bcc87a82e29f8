//! What a flight did, sample by sample, as a table with units in its header.

use std::io::Write;

use bat_dynamics::STATE_NAMES;

use crate::footprint::footprint_m2;
use crate::integrate::Sample;
use crate::rig::Rig;

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

    /// All numbers, in the order of [`FlightLog::columns`].
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

    pub(crate) fn of(sample: &Sample<'_, f64, 1>, rig: &Rig) -> Self {
        let (sight, tensions) = (&sample.evaluation.sight, &sample.evaluation.tensions);
        Self {
            time_s: sample.time_s,
            flow_speed_m_s: sample.water.flow.speed_m_s,
            flow_direction_rad: sample.water.flow.direction_rad,
            altitude_m: sight.altitude,
            lateral_m: sample.water.lateral(sight),
            roll_rad: sight.roll,
            pitch_rad: sight.pitch,
            heading_rad: sight.heading,
            pitch_error_rad: sight.pitch - rig.set_points.pitch_rad,
            roll_error_rad: sight.roll - rig.set_points.roll_rad,
            altitude_error_m: rig.set_points.altitude_m - sight.altitude,
            state: *sample.state,
            commands_m_s: sample.commands.map(|line| line[0]),
            tensions_n: [tensions.center, tensions.starboard, tensions.port],
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

    /// The same as a file has them: `time [s]`.
    #[must_use]
    pub fn header() -> Vec<String> {
        Self::columns().into_iter().map(|(name, unit)| format!("{name} [{unit}]")).collect()
    }

    /// Writes the log as CSV. Numbers are written so that they read back bit for bit.
    ///
    /// # Errors
    /// When `out` cannot be written.
    pub fn write_csv(&self, out: impl Write) -> Result<(), csv::Error> {
        let mut writer = csv::Writer::from_writer(out);
        writer.write_record(Self::header())?;
        for row in &self.rows {
            writer.write_record(row.numbers().map(|number| number.to_string()))?;
        }
        writer.flush()?;
        Ok(())
    }
}
