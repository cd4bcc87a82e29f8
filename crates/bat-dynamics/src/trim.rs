//! Equilibrium of the flight: no motion, nose into the flow, a set pitch, a set altitude or tether length.

use crate::balance::{Target, TrimHeight, balance};
use crate::bridle::{driven_of_lines, lines_of_driven};
use crate::coordinates::{Coordinates, FlightState};
use crate::error::{Error, NoTrim};
use crate::flow::Flow;
use crate::inertia::{generalized_forces, gravity_vector};
use crate::motion::accelerations;
use crate::plant::Plant;
use crate::tensions::Tensions;

/// What is asked of a trim.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrimRequest {
    /// The steady flow.
    pub flow: Flow,
    /// Pitch angle of the body, nose up, in rad.
    pub pitch_rad: f64,
    /// Altitude or tether length.
    pub height: TrimHeight,
}

/// An equilibrium.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trim {
    /// Coordinates `[Phi, Theta, Psi, L_t, theta', phi']`.
    pub coordinates: Coordinates,
    /// The same as a state of flight at rest.
    pub state: FlightState,
    /// What is left of each row of (4), `g − tau − f`, in the order of the coordinates (N·m; N for L_t). The
    /// first three say how well the equilibrium is met; the other three compare two ways to the line forces.
    pub residual: [f64; 6],
    /// Line tensions; one that is negative says that the bridle cannot hold this pitch.
    pub tensions: Tensions,
}

/// Scan of the zenith angle: first, last and step, in rad.
const FIRST_RAD: f64 = 1e-4;
const LAST_RAD: f64 = 1.553;
const SCAN_POINTS: usize = 180;

/// Finds the equilibrium with the smallest zenith angle.
///
/// All rates are zero, `Theta = psi_flow`, `Psi = phi' = 0`, `theta' = pitch − Phi`; the lateral rows of (4) then
/// vanish by symmetry and the row of Phi, force less bias, falls through zero at the equilibrium.
///
/// A plant whose sides differ ([`Asymmetry`](crate::Asymmetry)) rests rolled and turned. Its winches of starboard and port say
/// the same length; azimuth and twist are then those at which their rows balance too, on the branch that begins at the
/// equilibrium without the asymmetry.
///
/// # Errors
/// [`Error::Argument`] for values that are not finite, [`Error::NoTrim`] with the reason when there is none.
pub fn trim(plant: &Plant, request: &TrimRequest) -> Result<Trim, Error> {
    request.flow.validate()?;
    if !(request.pitch_rad.is_finite() && request.pitch_rad.abs() < core::f64::consts::FRAC_PI_2) {
        return Err(Error::Argument {
            name: "pitch set point in rad",
            value: request.pitch_rad,
            expected: "finite and within pi/2",
        });
    }
    let (name, value) = match request.height {
        TrimHeight::Altitude(value) => ("altitude set point in m", value),
        TrimHeight::TetherLength(value) => ("tether length in m", value),
    };
    if !(value.is_finite() && value > 0.0) {
        return Err(Error::Argument { name, value, expected: "finite and more than zero" });
    }
    if let TrimHeight::Altitude(altitude_m) = request.height {
        let joint_m = joint_altitude(plant, request.pitch_rad, altitude_m);
        if joint_m <= 0.0 {
            return Err(NoTrim::AltitudeOutOfReach { altitude_m, joint_m }.into());
        }
    }

    let even = if plant.lopsided { plant.with_asymmetry(0.0) } else { *plant };
    let place = |zenith| coordinates(&even, request, zenith);
    let start = place(smallest_root(&even, &request.flow, place)?);
    if !plant.lopsided {
        return at_equilibrium(plant, &request.flow, start);
    }
    let target = Target::Set { pitch_rad: request.pitch_rad, height: request.height };
    at_equilibrium(plant, &request.flow, balance(plant, &request.flow, &target, start)?)
}

/// Finds the equilibrium with the smallest zenith angle that lines of these lengths leave.
///
/// `lines_m` are the lengths of center, starboard and port, in m, as the winches say them. As in [`trim`] all rates are zero,
/// `Theta = psi_flow` and `Psi = 0`, unless the sides of the plant differ; where the pitch comes out follows from the lines.
///
/// # Errors
/// [`Error::Argument`] for lengths that are not finite and positive, or, where the plant is symmetric, for a starboard line that
/// is not as long as the port line: the body would rest rolled and turned. [`Error::NoTrim`] with the reason when there is no
/// equilibrium.
pub fn trim_with_lines(plant: &Plant, lines_m: [f64; 3], flow: &Flow) -> Result<Trim, Error> {
    flow.validate()?;
    if let Some(&value) = lines_m.iter().find(|line| !(line.is_finite() && **line > 0.0)) {
        return Err(Error::Argument { name: "length of a line in m", value, expected: "finite and more than zero" });
    }
    if plant.lopsided {
        return trim_lopsided_with_lines(plant, lines_m, flow);
    }
    let [length, induced_pitch, induced_roll] = driven_of_lines(plant, lines_m);
    if induced_roll.abs() > LEVEL_RAD {
        return Err(Error::Argument {
            name: "starboard line less port line in m",
            value: lines_m[1] - lines_m[2],
            expected: "zero: an equilibrium without roll",
        });
    }
    let place = |zenith| [zenith, flow.direction_rad, 0.0, length, induced_pitch, 0.0];
    let zenith = smallest_root(plant, flow, place)?;
    at_equilibrium(plant, flow, place(zenith))
}

/// From the equilibrium without the asymmetry, with starboard and port at their mean.
fn trim_lopsided_with_lines(plant: &Plant, lines_m: [f64; 3], flow: &Flow) -> Result<Trim, Error> {
    let even = plant.with_asymmetry(0.0);
    let aft = 0.5 * (lines_m[1] + lines_m[2]);
    let [length, induced_pitch, _] = driven_of_lines(&even, [lines_m[0], aft, aft]);
    let place = |zenith| [zenith, flow.direction_rad, 0.0, length, induced_pitch, 0.0];
    let start = place(smallest_root(&even, flow, place)?);
    let skew_m = lines_m[1] - aft;
    at_equilibrium(plant, flow, balance(plant, flow, &Target::Lines { lines_m, skew_m }, start)?)
}

/// An induced roll below this is rounding.
const LEVEL_RAD: f64 = 1e-12;

/// The smallest zenith angle at which the row of Phi, force less bias, falls through zero along `place`.
fn smallest_root(plant: &Plant, flow: &Flow, place: impl Fn(f64) -> Coordinates) -> Result<f64, Error> {
    let moment = |zenith: f64| {
        let q = place(zenith);
        generalized_forces(plant, &q, &[0.0; 6], flow)[0] - gravity_vector(plant, &q)[0]
    };
    let flow_speed_m_s = flow.speed_m_s;
    let first = moment(FIRST_RAD);
    if first.is_nan() || first <= 0.0 {
        return Err(NoTrim::AtZenith { flow_speed_m_s, zenith_rad: FIRST_RAD, moment_n_m: first }.into());
    }
    let step = (LAST_RAD - FIRST_RAD) / SCAN_POINTS as f64;
    let (mut low, mut high) = (1..=SCAN_POINTS)
        .map(|k| FIRST_RAD + step * k as f64)
        .find(|zenith| moment(*zenith) <= 0.0)
        .map(|zenith| (zenith - step, zenith))
        .ok_or(NoTrim::BlownDown { flow_speed_m_s, zenith_rad: LAST_RAD })?;
    loop {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            return Ok(middle);
        }
        if moment(middle) > 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
}

/// Altitude of the joint with the center of mass at `altitude`, without roll.
fn joint_altitude(plant: &Plant, pitch: f64, altitude: f64) -> f64 {
    let (sin, cos) = pitch.sin_cos();
    altitude + cos * plant.cm_z - sin * plant.cm_x
}

fn coordinates(plant: &Plant, request: &TrimRequest, zenith: f64) -> Coordinates {
    let length = match request.height {
        TrimHeight::TetherLength(length) => length,
        TrimHeight::Altitude(altitude) => joint_altitude(plant, request.pitch_rad, altitude) / zenith.cos(),
    };
    [zenith, request.flow.direction_rad, 0.0, length, request.pitch_rad - zenith, 0.0]
}

fn at_equilibrium(plant: &Plant, flow: &Flow, q: Coordinates) -> Result<Trim, Error> {
    let lines = lines_of_driven(plant, [q[3], q[4], q[5]]);
    let shortest_line_m = lines[0].min(lines[1]).min(lines[2]);
    if q[4].abs() >= core::f64::consts::FRAC_PI_2 || shortest_line_m <= 0.0 {
        let pitch_rad = q[0] + q[4];
        return Err(NoTrim::PitchOutOfReach { pitch_rad, induced_rad: q[4], shortest_line_m }.into());
    }
    let rest = [0.0; 6];
    let motion = accelerations(plant, &q, &rest, [0.0; 3], flow)?;
    let bias = gravity_vector(plant, &q) - generalized_forces(plant, &q, &rest, flow);
    let mut residual: [f64; 6] = bias.into();
    for (left, supplied) in residual[3..].iter_mut().zip(motion.supplied) {
        *left -= supplied;
    }
    let mut state = [0.0; 12];
    state[..3].copy_from_slice(&q[..3]);
    state[6..9].copy_from_slice(&lines);
    Ok(Trim { coordinates: q, state, residual, tensions: motion.tensions })
}
