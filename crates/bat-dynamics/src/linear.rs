//! Linearization of a flight about a state, exact to rounding by forward-mode dual numbers.

use nalgebra::{DMatrix, SMatrix, SVector};
use num_dual::Dual64;
use serde::Serialize;

use crate::coordinates::{FlightState, STATE_NAMES, STATE_UNITS, check_state};
use crate::error::Error;
use crate::evaluation::{Evaluation, evaluate};
use crate::flow::Flow;
use crate::plant::Plant;

/// Number of states.
const STATES: usize = 12;
/// Number of inputs.
const INPUTS: usize = 5;
/// Number of outputs.
const OUTPUTS: usize = 9;

/// Name and unit of a state, an input or an output.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Variable {
    /// Name, in snake case.
    pub name: &'static str,
    /// Unit.
    pub unit: &'static str,
}

/// `dx/dt = A x + B u`, `y = C x + D u` for small departures.
#[derive(Clone, Debug)]
pub struct Linearization {
    /// A, 12 x 12.
    pub a: SMatrix<f64, STATES, STATES>,
    /// B, 12 x 5.
    pub b: SMatrix<f64, STATES, INPUTS>,
    /// C, 9 x 12.
    pub c: SMatrix<f64, OUTPUTS, STATES>,
    /// D, 9 x 5.
    pub d: SMatrix<f64, OUTPUTS, INPUTS>,
    /// What the state entries are.
    pub states: [Variable; STATES],
    /// What the input entries are.
    pub inputs: [Variable; INPUTS],
    /// What the output entries are.
    pub outputs: [Variable; OUTPUTS],
}

const INPUT_VARIABLES: [Variable; INPUTS] = [
    Variable { name: "command_center", unit: "m/s" },
    Variable { name: "command_starboard", unit: "m/s" },
    Variable { name: "command_port", unit: "m/s" },
    Variable { name: "flow_speed", unit: "m/s" },
    Variable { name: "flow_direction", unit: "rad" },
];

const OUTPUT_VARIABLES: [Variable; OUTPUTS] = [
    Variable { name: "altitude", unit: "m" },
    Variable { name: "pitch", unit: "rad" },
    Variable { name: "roll", unit: "rad" },
    Variable { name: "heading_from_flow", unit: "rad" },
    Variable { name: "offset_right_of_flow", unit: "m" },
    Variable { name: "offset_against_flow", unit: "m" },
    Variable { name: "tension_center", unit: "N" },
    Variable { name: "tension_starboard", unit: "N" },
    Variable { name: "tension_port", unit: "N" },
];

/// Linearizes the right-hand side [`evaluate`] about `state` with held `commands_m_s`.
///
/// Where a command is at its limit, its column of B is that of the side on which the command acts.
///
/// # Errors
/// [`Error::Argument`] for a flow or a command that is not finite; [`Error::State`] when the state is outside the
/// model or a derivative does not exist there (fluid at rest relative to the body).
pub fn linearize(
    plant: &Plant,
    state: &FlightState,
    commands_m_s: [f64; 3],
    flow: &Flow,
) -> Result<Linearization, Error> {
    flow.validate()?;
    check_state(state, 0.0)?;
    if let Some(&value) = commands_m_s.iter().find(|command| !command.is_finite()) {
        return Err(Error::Argument { name: "line speed command in m/s", value, expected: "finite" });
    }
    let dual_plant = plant.cast::<Dual64>();
    let mut linear = Linearization {
        a: SMatrix::zeros(),
        b: SMatrix::zeros(),
        c: SMatrix::zeros(),
        d: SMatrix::zeros(),
        states: core::array::from_fn(|k| Variable { name: STATE_NAMES[k], unit: STATE_UNITS[k] }),
        inputs: INPUT_VARIABLES,
        outputs: OUTPUT_VARIABLES,
    };
    for direction in 0..STATES + INPUTS {
        let seed = |k: usize, value: f64| Dual64::new(value, if k == direction { 1.0 } else { 0.0 });
        let x = core::array::from_fn(|k| seed(k, state[k]));
        let commands = core::array::from_fn(|k| seed(STATES + k, commands_m_s[k]));
        let flow =
            Flow { speed_m_s: seed(STATES + 3, flow.speed_m_s), direction_rad: seed(STATES + 4, flow.direction_rad) };
        let at = evaluate(&dual_plant, &x, commands, &flow);
        check_derivative(&at.derivative)?;
        linear.set_column(direction, at.derivative.map(|entry| entry.eps), outputs(&at).map(|entry| entry.eps));
    }
    Ok(linear)
}

/// In the order of [`OUTPUT_VARIABLES`].
fn outputs(at: &Evaluation<Dual64>) -> [Dual64; OUTPUTS] {
    let Evaluation { sight, tensions, .. } = at;
    [
        sight.altitude_m,
        sight.pitch_rad,
        sight.roll_rad,
        sight.heading_rad,
        sight.right_m,
        sight.forward_m,
        tensions.center_n,
        tensions.starboard_n,
        tensions.port_n,
    ]
}

/// Where the body does not move relative to the fluid, the fluid forces have no derivative.
fn check_derivative(derivative: &FlightState<Dual64>) -> Result<(), Error> {
    match derivative.iter().find(|entry| !entry.eps.is_finite()) {
        None => Ok(()),
        Some(entry) => Err(Error::State {
            name: "derivative of the equations of motion",
            value: entry.eps,
            unit: "(in the units of its states)",
            time_s: 0.0,
            expected: "finite: the body must move relative to the fluid",
        }),
    }
}

impl Linearization {
    /// Writes what the derivatives of the states and the outputs are along state or input `direction`.
    fn set_column(&mut self, direction: usize, derivative: [f64; STATES], outputs: [f64; OUTPUTS]) {
        let (derivative, outputs) = (SVector::from(derivative), SVector::from(outputs));
        if direction < STATES {
            self.a.set_column(direction, &derivative);
            self.c.set_column(direction, &outputs);
        } else {
            self.b.set_column(direction - STATES, &derivative);
            self.d.set_column(direction - STATES, &outputs);
        }
    }

    /// The free coordinates and their rates: with the lines locked, what the body does by itself.
    pub const FREE: [usize; 6] = [0, 1, 2, 3, 4, 5];
    /// Of these the longitudinal ones: zenith angle and its rate.
    pub const LONGITUDINAL: [usize; 2] = [0, 3];
    /// Of these the lateral ones: azimuth, twist and their rates.
    pub const LATERAL: [usize; 4] = [1, 2, 4, 5];

    /// A of some states with all others held, as [`modes`](crate::modes) takes it.
    ///
    /// # Panics
    /// When an index is not one of the twelve states.
    #[must_use]
    pub fn among(&self, states: &[usize]) -> DMatrix<f64> {
        DMatrix::from_fn(states.len(), states.len(), |i, j| self.a[(states[i], states[j])])
    }
}
