//! The three loops together: from a measured state to the speeds of the three lines.

use serde::{Deserialize, Serialize};

use crate::error::{check_finite, check_positive};
use crate::{Error, FilteredPd, Mixing, PdState, SampledPd, TetherLayout};

/// A sampled controller of altitude, pitch and roll by three winches.
///
/// It holds what does not change during a flight; [`ControllerState`] holds the rest, so that one controller serves any
/// number of flights at a time.
///
/// # The sign trap
/// Through (14) as printed, with one line forward, v_theta > 0 takes the nose *down*, v_phi > 0 the starboard side *up*
/// and v_z > 0 the whole body up. The three errors that positive gains need are therefore not alike:
///
/// ```text
/// z_e     = h_sp − h            too low    → positive → all lines out
/// theta_e = theta − theta_sp    nose low   → negative → the forward end goes up
/// phi_e   = phi − phi_sp        port low   → negative → the port line out, the starboard line in
/// ```
///
/// Pitch is positive nose-up, roll positive starboard-down. A loop closed with the other sign drives the body away from
/// its set point. `tests/it/signs.rs` checks each of them through the geometry of the lines, for both layouts.
///
/// # Saturation
/// Each line's speed is limited on its own, and [`Command`] holds the speed asked for beside the speed given. There is no
/// anti-windup, because there is no integrator: the filters see the errors only, keep them for a few time
/// constants, and are not changed by the limit. Where one line is cut and the others are not, all
/// loops that use it get another speed than they asked for.
/// [`Mixing::loop_speeds_m_s`] of the speeds given says what each loop got.
#[derive(Clone, Debug, PartialEq)]
pub struct Controller {
    parameters: ControllerParameters,
    altitude: SampledPd,
    pitch: SampledPd,
    roll: SampledPd,
    mixing: Mixing,
}

/// Everything that makes a [`Controller`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ControllerParameters {
    /// The loop (10): m/s per m, and m/s per m/s.
    pub altitude: FilteredPd,
    /// The loop (11): m/s per rad, and m/s per rad/s.
    pub pitch: FilteredPd,
    /// The loop (12): m/s per rad, and m/s per rad/s.
    pub roll: FilteredPd,
    /// What the body is held at.
    pub set_points: SetPoints,
    /// The time from one sample to the next; the command is held in between.
    pub sample_time_s: f64,
    /// Where the three lines leave the body.
    pub layout: TetherLayout,
    /// u_max: the greatest speed at which a line is released or reeled in.
    pub speed_limit_m_s: f64,
}

/// What the body is held at.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SetPoints {
    /// Height of the center of mass above the winch exits.
    pub altitude_m: f64,
    /// Nose-up positive.
    pub pitch_rad: f64,
    /// Starboard-down positive.
    pub roll_rad: f64,
}

/// The state of the body at a sample, as far as the controller looks at it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Measurement {
    /// Height of the center of mass above the winch exits.
    pub altitude_m: f64,
    /// Nose-up positive.
    pub pitch_rad: f64,
    /// Starboard-down positive.
    pub roll_rad: f64,
}

/// The errors that the loops act on, with the signs given at [`Controller`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrackingErrors {
    /// z_e: set point minus altitude.
    pub altitude_m: f64,
    /// theta_e: pitch minus set point.
    pub pitch_rad: f64,
    /// phi_e: roll minus set point.
    pub roll_rad: f64,
}

/// What the controller remembers from one sample to the next.
///
/// The default is a controller at rest; assigning it is the reset.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ControllerState {
    /// The altitude loop's filter.
    pub altitude: PdState,
    /// The pitch loop's filter.
    pub pitch: PdState,
    /// The roll loop's filter.
    pub roll: PdState,
}

/// The release speeds of the lines [center, starboard, port], positive when a line gets longer.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Command {
    /// What the loops ask for.
    pub unsaturated_m_s: [f64; 3],
    /// The same within the speed limit: what the winches get.
    pub saturated_m_s: [f64; 3],
}

impl Command {
    /// For each of [center, starboard, port], whether the limit holds its speed back.
    #[must_use]
    pub fn saturated_lines(&self) -> [bool; 3] {
        std::array::from_fn(|line| (self.unsaturated_m_s[line] - self.saturated_m_s[line]).abs() > 0.0)
    }
}

impl Controller {
    /// Makes the controller ready for its sample time.
    ///
    /// # Errors
    /// When a set point is not finite, or the sample time or the speed limit is not finite and positive.
    pub fn new(parameters: ControllerParameters) -> Result<Self, Error> {
        let set_points = &parameters.set_points;
        check_finite("altitude_m", set_points.altitude_m)?;
        check_finite("pitch_rad", set_points.pitch_rad)?;
        check_finite("roll_rad", set_points.roll_rad)?;
        check_positive("speed_limit_m_s", parameters.speed_limit_m_s)?;
        Ok(Self {
            altitude: parameters.altitude.sampled(parameters.sample_time_s)?,
            pitch: parameters.pitch.sampled(parameters.sample_time_s)?,
            roll: parameters.roll.sampled(parameters.sample_time_s)?,
            mixing: Mixing::new(parameters.layout),
            parameters,
        })
    }

    /// What the controller was made of.
    #[must_use]
    pub fn parameters(&self) -> &ControllerParameters {
        &self.parameters
    }

    /// The errors at a measurement.
    #[inline]
    #[must_use]
    pub fn errors(&self, measured: &Measurement) -> TrackingErrors {
        let set_points = &self.parameters.set_points;
        TrackingErrors {
            altitude_m: set_points.altitude_m - measured.altitude_m,
            pitch_rad: measured.pitch_rad - set_points.pitch_rad,
            roll_rad: measured.roll_rad - set_points.roll_rad,
        }
    }

    /// The line speeds for one sample, after which the filters have moved on by one sample time.
    ///
    /// Call it once a sample, also where something else commands the winches, if the filters are to keep running.
    /// A measurement that is not finite makes the command and the state not finite: whoever integrates the plant checks
    /// its state, the controller does not check it again.
    #[inline]
    pub fn command(&self, state: &mut ControllerState, measured: &Measurement) -> Command {
        let errors = self.errors(measured);
        let v_z = self.altitude.output(&mut state.altitude, errors.altitude_m); // (10)
        let v_theta = self.pitch.output(&mut state.pitch, errors.pitch_rad); // (11)
        let v_phi = self.roll.output(&mut state.roll, errors.roll_rad); // (12)
        let unsaturated_m_s = self.mixing.line_speeds_m_s([v_z, v_theta, v_phi]); // (13)
        let limit = self.parameters.speed_limit_m_s;
        // Written out: `array::map` is not always inlined, and then takes as long as all the rest.
        let [center, starboard, port] = unsaturated_m_s;
        let saturated_m_s = [center.clamp(-limit, limit), starboard.clamp(-limit, limit), port.clamp(-limit, limit)];
        Command { unsaturated_m_s, saturated_m_s }
    }
}
