//! A second flight from the public parts: the controller sample by sample, the plant by DOP853 in between, the cost
//! as one integral of its own. It shares the right-hand side with the crate and nothing else.

use bat_dynamics::{Flow, evaluate};
use differential_equations::prelude::{ExplicitRungeKutta, IVP, ODE};
use tether_control::{ControllerState, Measurement};
use water_channel::{CostWeights, FlightRequest, Window};

/// Tolerance of the integration: far below what is compared.
const TIGHT: f64 = 1e-12;

/// A test told by its flow as a function of time, smooth between the `knots`.
pub(crate) struct Telling<'a> {
    pub(crate) duration_s: f64,
    pub(crate) knots_s: &'a [f64],
    /// The flow at a time, by the formula of the piece that holds at the second argument.
    pub(crate) flow: fn(f64, f64) -> Flow,
    pub(crate) windows: &'a [Window],
}

/// J without its ballast term, and the last state.
pub(crate) struct Reference {
    pub(crate) cost: f64,
    pub(crate) final_state: [f64; 12],
}

struct Held<'a> {
    plant: &'a bat_dynamics::Plant,
    request: &'a FlightRequest,
    weights: &'a CostWeights,
    commands: [f64; 3],
    flow: Box<dyn Fn(f64) -> Flow + 'a>,
}

impl ODE<f64, [f64; 13]> for Held<'_> {
    fn diff(&self, time_s: f64, y: &[f64; 13], slope: &mut [f64; 13]) {
        let mut state = [0.0; 12];
        state.copy_from_slice(&y[..12]);
        let at = evaluate(self.plant, &state, self.commands, &(self.flow)(time_s));
        slope[..12].copy_from_slice(&at.derivative);
        let [k1, k2, k3, k4, k5, k6] = self.weights.terms;
        let set = &self.request.rig.set_points;
        let sum = k1 * at.sight.heading_rad.powi(2)
            + k2 * (at.sight.pitch_rad - set.pitch_rad).powi(2)
            + k3 * (at.sight.roll_rad - set.roll_rad).powi(2)
            + k4 * (at.sight.altitude_m - set.altitude_m).powi(2)
            + k5 * (y[9].powi(2) + y[10].powi(2) + y[11].powi(2))
            + k6 * y[0];
        slope[12] = sum * sum;
    }
}

/// Flies `request` through `test` from the state `start`.
pub(crate) fn reference(
    request: &FlightRequest,
    test: &Telling<'_>,
    start: &[f64; 12],
    weights: &CostWeights,
) -> Reference {
    let plant = request.rig.plant(request.fidelity).unwrap();
    let controller = request.rig.controller().unwrap();
    let limit = request.rig.plant.winch.speed_limit_m_s;
    let mut memory = ControllerState::default();
    let mut y = [0.0; 13];
    y[..12].copy_from_slice(start);
    let n_samples = (test.duration_s / request.rig.sample_time_s).ceil() as usize;
    for sample in 0..n_samples {
        let from_s = sample as f64 * request.rig.sample_time_s;
        let to_s = ((sample + 1) as f64 * request.rig.sample_time_s).min(test.duration_s);
        let mut state = [0.0; 12];
        state.copy_from_slice(&y[..12]);
        let seen = evaluate(&plant, &state, [0.0; 3], &(test.flow)(from_s, from_s + 1e-9)).sight;
        let measured = Measurement { altitude_m: seen.altitude_m, pitch_rad: seen.pitch_rad, roll_rad: seen.roll_rad };
        let mut commands = controller.command(&mut memory, &measured).saturated_m_s;
        if let Some(window) = test.windows.iter().find(|w| from_s > w.from_s - 1e-9 && from_s < w.to_s + 1e-9) {
            commands = window.commands.map(|fraction| fraction * limit);
        }
        let mut cuts = vec![from_s];
        cuts.extend(test.knots_s.iter().copied().filter(|knot| *knot > from_s + 1e-9 && *knot < to_s - 1e-9));
        cuts.push(to_s);
        for piece in cuts.windows(2) {
            let middle_s = 0.5 * (piece[0] + piece[1]);
            let flow: Box<dyn Fn(f64) -> Flow> = Box::new(move |time_s| (test.flow)(time_s, middle_s));
            let held = Held { plant: &plant, request, weights, commands, flow };
            let solution = IVP::ode(&held, piece[0], piece[1], y)
                .method(ExplicitRungeKutta::dop853().rtol(TIGHT).atol(1e-14))
                .solve()
                .unwrap();
            y = *solution.y.last().unwrap();
        }
    }
    let mut final_state = [0.0; 12];
    final_state.copy_from_slice(&y[..12]);
    Reference { cost: y[12], final_state }
}
