//! Modes of the body by itself, the lines held: what an open-loop flight does with a small disturbance.

use bat_dynamics::{Flow, Linearization, Modes, Trim, linearize, modes, trim_with_lines};

use crate::error::Error;
use crate::flight::{FlightRequest, trim_at};

/// The body at an equilibrium with held lines, and how a small disturbance dies out there, or grows.
#[derive(Clone, Debug)]
pub struct OpenLoop {
    /// The equilibrium.
    pub trim: Trim,
    /// Modes of zenith angle, azimuth, twist and their rates, in the order of [`Linearization::FREE`].
    pub modes: Modes,
}

impl OpenLoop {
    /// Whether every small disturbance decays.
    #[must_use]
    pub fn is_stable(&self) -> bool {
        self.growth_rate_per_s() < 0.0
    }

    /// The largest real part among the eigenvalues, in 1/s: positive when something grows.
    #[must_use]
    pub fn growth_rate_per_s(&self) -> f64 {
        self.modes.modes.iter().map(|mode| mode.eigenvalue.re).fold(f64::NEG_INFINITY, f64::max)
    }
}

/// The modes of `request` in each of `flows`, the lines held throughout as they are trimmed at the first of them.
///
/// This is what an open-loop test goes through: at another speed the body rests at another zenith angle and pitch.
///
/// # Errors
/// [`Error`] for a rig that is out of range, when there is no equilibrium at one of the flows, or when the eigenvalues
/// do not converge. [`Error::Argument`] for no flow.
pub fn open_loop_modes(request: &FlightRequest, flows: &[Flow]) -> Result<Vec<OpenLoop>, Error> {
    let Some(first) = flows.first() else {
        return Err(Error::Argument { name: "number of flows", value: 0.0, expected: "at least 1" });
    };
    let plant = request.rig.plant(request.fidelity)?;
    let start = trim_at(&plant, &request.rig.set_points, *first)?;
    let lines_m = [start.state[6], start.state[7], start.state[8]];
    flows
        .iter()
        .map(|flow| {
            let trim = trim_with_lines(&plant, lines_m, flow)?;
            let linear = linearize(&plant, &trim.state, [0.0; 3], flow)?;
            Ok(OpenLoop { trim, modes: modes(&linear.among(&Linearization::FREE))? })
        })
        .collect()
}
