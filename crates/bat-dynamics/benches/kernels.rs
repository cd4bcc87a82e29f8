//! The kernels: one right-hand side, a trim, a linearization with its modes.

use bat_dynamics::{
    Fidelity, FlightState, Flow, LANES, Lanes, Linearization, Parameters, Plant, TrimHeight, TrimRequest, evaluate,
    linearize, modes, trim,
};
use divan::{Bencher, black_box};
use num_dual::Dual64;

const STATE: FlightState = [0.3, 0.1, -0.05, 0.1, -0.2, 0.15, 0.62, 0.6, 0.61, 0.004, -0.003, 0.002];
const FLOW: Flow = Flow { speed_m_s: 0.245, direction_rad: 0.1 };

fn main() {
    divan::main();
}

fn plant() -> Plant {
    Plant::new(&Parameters::water_channel_bat(), Fidelity::STALLED_WITH_ADDED_MASS).expect("a valid plant")
}

// Many calls per sample: one call is shorter than the clock's resolution.
const CALLS: usize = 1000;

#[divan::bench(counters = [divan::counter::ItemsCount::new(CALLS)])]
fn right_hand_side_f64(bencher: Bencher<'_, '_>) {
    let plant = plant();
    bencher.bench_local(|| {
        let mut state = STATE;
        for _ in 0..CALLS {
            // Each call waits for the one before, as in an integrator.
            let at = evaluate(black_box(&plant), &state, [0.001; 3], black_box(&FLOW));
            state[0] = STATE[0] + 1e-9 * black_box(at).derivative[3];
        }
        state
    });
}

/// Counts flights: a call evaluates one in each lane.
#[divan::bench(counters = [divan::counter::ItemsCount::new(CALLS * LANES)])]
fn right_hand_side_lanes(bencher: Bencher<'_, '_>) {
    let plant = plant().cast::<Lanes>();
    let (start, flow) = (STATE.map(|x| Lanes([x; LANES])), FLOW.cast::<Lanes>());
    let (small, command) = (Lanes([1e-9; LANES]), [Lanes([0.001; LANES]); 3]);
    bencher.bench_local(|| {
        let mut state = start;
        for _ in 0..CALLS {
            let at = evaluate(black_box(&plant), &state, command, black_box(&flow));
            state[0] = start[0] + small * black_box(at).derivative[3];
        }
        state
    });
}

#[divan::bench(counters = [divan::counter::ItemsCount::new(CALLS)])]
fn right_hand_side_dual(bencher: Bencher<'_, '_>) {
    let plant = plant().cast::<Dual64>();
    let (start, flow) = (STATE.map(|x| Dual64::new(x, 1.0)), FLOW.cast::<Dual64>());
    let command = [Dual64::from_re(0.001); 3];
    bencher.bench_local(|| {
        let mut state = start;
        for _ in 0..CALLS {
            let at = evaluate(black_box(&plant), &state, command, black_box(&flow));
            state[0] = start[0] + black_box(at).derivative[3] * 1e-9;
        }
        state
    });
}

#[divan::bench]
fn trim_at_an_altitude(bencher: Bencher<'_, '_>) {
    let plant = plant();
    let request = TrimRequest { flow: FLOW, pitch_rad: 0.3, height: TrimHeight::Altitude(0.61) };
    bencher.bench_local(|| trim(black_box(&plant), black_box(&request)));
}

#[divan::bench]
fn linearize_and_modes(bencher: Bencher<'_, '_>) {
    let plant = plant();
    bencher.bench_local(|| {
        let linear = linearize(black_box(&plant), &STATE, [0.0; 3], &FLOW).expect("a linearization");
        modes(&linear.among(&Linearization::FREE))
    });
}
