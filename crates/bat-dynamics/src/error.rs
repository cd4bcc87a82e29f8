//! What can be wrong with what a caller gives.

use thiserror::Error;

/// An error of this crate: what is wrong, where, and what was allowed.
#[non_exhaustive]
#[derive(Clone, Debug, Error, PartialEq)]
pub enum Error {
    /// A parameter outside what is physically possible.
    #[error("{section}.{name} = {value} {unit}: it must be {expected}")]
    Parameter {
        /// Section of the parameter, as in a parameter file.
        section: &'static str,
        /// Name of the parameter, as in a parameter file.
        name: &'static str,
        /// The value that was given.
        value: f64,
        /// Its unit.
        unit: &'static str,
        /// What was allowed.
        expected: &'static str,
    },
    /// A state in which the equations of motion are not defined.
    #[error("{name} = {value} {unit} at t = {time_s} s: it must be {expected}")]
    State {
        /// Name of the coordinate or quantity.
        name: &'static str,
        /// The value that was given or reached.
        value: f64,
        /// Its unit.
        unit: &'static str,
        /// The time at which it was found.
        time_s: f64,
        /// What was allowed.
        expected: &'static str,
    },
    /// An argument that is not a state or a parameter.
    #[error("{name} = {value}: it must be {expected}")]
    Argument {
        /// Name of the argument.
        name: &'static str,
        /// The value that was given.
        value: f64,
        /// What was allowed.
        expected: &'static str,
    },
    /// There is no equilibrium; the reason says why.
    #[error("no trim: {0}")]
    NoTrim(#[from] NoTrim),
    /// An eigenvalue computation that did not finish.
    #[error("the eigenvalues of the {size} x {size} matrix did not converge, or the matrix is not finite")]
    Eigenvalues {
        /// Rows of the matrix.
        size: usize,
    },
}

/// Why there is no trim.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum NoTrim {
    /// The restoring moment already exceeds the drag near the vertical: equilibrium is at Phi = 0 or upwind of it.
    #[error(
        "at {flow_speed_m_s} m/s the flow does not push the tether away from the vertical \
         (moment {moment_n_m:.3e} N·m at Phi = {zenith_rad} rad); azimuth and twist coincide at Phi = 0"
    )]
    AtZenith {
        /// Flow speed.
        flow_speed_m_s: f64,
        /// Smallest zenith angle that was tried.
        zenith_rad: f64,
        /// Moment on the zenith angle there; downstream is positive.
        moment_n_m: f64,
    },
    /// The flow pushes the tether down at every zenith angle.
    #[error(
        "at {flow_speed_m_s} m/s the flow pushes the tether down at every zenith angle up to {zenith_rad:.3} rad: \
         too little lift and buoyancy for the drag"
    )]
    BlownDown {
        /// Flow speed.
        flow_speed_m_s: f64,
        /// Largest zenith angle that was tried.
        zenith_rad: f64,
    },
    /// The bridle cannot reach the pitch angle.
    #[error(
        "pitch {pitch_rad} rad is out of the bridle's reach: it takes an induced pitch of {induced_rad:.4} rad \
         (allowed: within pi/2) and a shortest line of {shortest_line_m:.4} m (allowed: more than zero)"
    )]
    PitchOutOfReach {
        /// The pitch that was asked for.
        pitch_rad: f64,
        /// The induced pitch theta' that it takes.
        induced_rad: f64,
        /// The shortest line that it takes.
        shortest_line_m: f64,
    },
    /// The asymmetry of the plant leaves no balance of zenith, azimuth and twist near the equilibrium without it.
    #[error(
        "at {flow_speed_m_s} m/s no equilibrium near that of the plant without its asymmetry: its rows keep {left:.3e} of the \
         buoyancy times the length of the tether"
    )]
    NoBalance {
        /// Flow speed.
        flow_speed_m_s: f64,
        /// The largest residual that was left.
        left: f64,
    },
    /// The altitude is below what a tether of positive length reaches.
    #[error("altitude {altitude_m} m puts the bridle joint at {joint_m:.4} m: it must be above the winches")]
    AltitudeOutOfReach {
        /// The altitude of the center of mass that was asked for.
        altitude_m: f64,
        /// The altitude of the joint that it takes at the pitch that was asked for.
        joint_m: f64,
    },
}
