//! The coordinates and the state of a flight: names, units, and where the equations of motion are defined.

use crate::error::Error;

/// Generalized coordinates `Q = [Phi, Theta, Psi, L_t, theta', phi']`: rad, rad, rad, m, rad, rad.
///
/// Zenith angle, azimuth and twist are free; length, induced pitch and induced roll are driven by the winches.
///
/// Source: (7).
pub type Coordinates<T = f64> = [T; 6];

/// State of a flight: `[Phi, Theta, Psi]` in rad, their rates in rad/s, the line lengths `[l1, l2, l3]` in m
/// and the reel speeds `[u1, u2, u3]` in m/s; lines in the order center, starboard, port.
pub type FlightState<T = f64> = [T; 12];

/// Names of the twelve entries of a [`FlightState`].
pub const STATE_NAMES: [&str; 12] = [
    "zenith",
    "azimuth",
    "twist",
    "zenith_rate",
    "azimuth_rate",
    "twist_rate",
    "line_center",
    "line_starboard",
    "line_port",
    "reel_center",
    "reel_starboard",
    "reel_port",
];

/// Units of the twelve entries of a [`FlightState`].
pub const STATE_UNITS: [&str; 12] =
    ["rad", "rad", "rad", "rad/s", "rad/s", "rad/s", "m", "m", "m", "m/s", "m/s", "m/s"];

/// |sin Phi| below which azimuth and twist count as coincident.
pub const SINGULAR_SIN_ZENITH: f64 = 1e-6;

/// Checks what the equations of motion need, naming the offender.
pub(crate) fn check_coordinates(q: &Coordinates, q_rate: &Coordinates) -> Result<(), Error> {
    const NAMES: [&str; 6] = [
        "zenith angle Phi",
        "azimuth Theta",
        "twist Psi",
        "tether length L_t",
        "induced pitch theta'",
        "induced roll phi'",
    ];
    const UNITS: [&str; 6] = ["rad", "rad", "rad", "m", "rad", "rad"];
    for k in 0..6 {
        for value in [q[k], q_rate[k]] {
            if !value.is_finite() {
                return Err(Error::State { name: NAMES[k], value, unit: UNITS[k], time_s: 0.0, expected: "finite" });
            }
        }
    }
    if q[3] <= 0.0 {
        return Err(Error::State { name: NAMES[3], value: q[3], unit: "m", time_s: 0.0, expected: "more than zero" });
    }
    check_zenith(q[0], 0.0)
}

/// Checks that the azimuth is defined.
pub(crate) fn check_zenith(zenith_rad: f64, time_s: f64) -> Result<(), Error> {
    if zenith_rad.sin().abs() > SINGULAR_SIN_ZENITH {
        return Ok(());
    }
    Err(Error::State {
        name: "zenith angle Phi",
        value: zenith_rad,
        unit: "rad",
        time_s,
        expected: "away from 0 and pi, where azimuth and twist coincide",
    })
}

/// Names what is wrong with a flight state at `time_s`.
///
/// # Errors
/// [`Error::State`] for a non-finite entry, lines whose mean is zero or less, or a singular zenith angle.
pub fn check_state(state: &FlightState, time_s: f64) -> Result<(), Error> {
    for ((value, name), unit) in state.iter().zip(STATE_NAMES).zip(STATE_UNITS) {
        if !value.is_finite() {
            return Err(Error::State { name, value: *value, unit, time_s, expected: "finite" });
        }
    }
    let length = (state[6] + state[7] + state[8]) / 3.0;
    if length <= 0.0 {
        return Err(Error::State {
            name: "tether length L_t",
            value: length,
            unit: "m",
            time_s,
            expected: "more than zero",
        });
    }
    check_zenith(state[0], time_s)
}
