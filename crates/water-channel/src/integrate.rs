//! The closed loop over a whole test: one source for one flight in `f64` and for many in lanes.
//!
//! Fixed-step RK4 aligned with the samples: between two samples the commands are held, so the right-hand side is
//! smooth and the method keeps its order. Steps also end where the flow has a knot. The integrals of the cost are
//! quadratures of the same method.

use bat_dynamics::{
    Disturbance, Evaluation, FlightState, Flow, LANES, Lanes, Plant, Real, Sight, evaluate_with, sight,
};
use tether_control::{Controller, ControllerState, Measurement};

use crate::cost::{Integrals, N_TERMS};
use crate::energy::{Energy, Meter, Reading};
use crate::error::FlightError;
use crate::profile::TestProfile;
use crate::sensing::{Estimate, Pose, Tracker, Viewer, observe_abreast};
use crate::settings::FlightSettings;
use crate::watch::{Extremes, Seen, SlackEvent, Watcher};
use crate::water::WaterTable;

/// A scalar that carries `N` flights.
pub(crate) trait Carrier<const N: usize>: Real {
    fn split(self) -> [f64; N];
    fn join(values: [f64; N]) -> Self;
}

impl Carrier<1> for f64 {
    #[inline(always)]
    fn split(self) -> [f64; 1] {
        [self]
    }
    #[inline(always)]
    fn join([value]: [f64; 1]) -> Self {
        value
    }
}

impl Carrier<LANES> for Lanes {
    #[inline(always)]
    fn split(self) -> [f64; LANES] {
        self.0
    }
    #[inline(always)]
    fn join(values: [f64; LANES]) -> Self {
        Lanes(values)
    }
}

/// Everything that does not change during the flights of one batch.
pub(crate) struct Setup<'a, T, const N: usize> {
    pub(crate) plant: Plant<T>,
    pub(crate) controllers: [&'a Controller; N],
    /// The cameras of each lane; a controller without them sees the state.
    pub(crate) viewers: [Option<&'a Viewer>; N],
    pub(crate) sample_time_s: f64,
    pub(crate) profile: &'a TestProfile,
    pub(crate) settings: &'a FlightSettings,
    /// Water that moves beside its mean flow, for each lane.
    pub(crate) water: Option<[&'a WaterTable; N]>,
    /// The turbine of each lane, if the test has one.
    pub(crate) meters: [Option<Meter>; N],
    /// Lanes that carry a flight; the others repeat one and are not looked at.
    pub(crate) used: usize,
}

/// What one flight ended with.
#[derive(Clone, Debug)]
pub(crate) struct Ending {
    pub(crate) integrals: Integrals,
    pub(crate) extremes: Extremes,
    pub(crate) slack: Option<SlackEvent>,
    pub(crate) final_state: FlightState,
    pub(crate) failure: Option<FlightError>,
    pub(crate) energy: Option<Energy>,
    pub(crate) sight: Option<Sighted>,
}

/// What the cameras of one flight came to.
#[derive(Clone, Debug)]
pub(crate) struct Sighted {
    pub(crate) held_share: f64,
    pub(crate) blind_cameras: Vec<usize>,
}

/// What can be seen at one sample, before the plant moves on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample<'a, T, const N: usize> {
    pub(crate) time_s: f64,
    pub(crate) water: Water,
    pub(crate) state: &'a FlightState<T>,
    pub(crate) evaluation: &'a Evaluation<T>,
    pub(crate) control: &'a Control<N>,
}

/// What the controllers were given at one sample, and what they asked for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Control<const N: usize> {
    /// What the cameras make of the state, where there are any.
    pub(crate) estimates: [Option<Estimate>; N],
    /// Reel speeds of the three lines.
    pub(crate) commands: [[f64; N]; 3],
}

/// What controllers and cameras remember from one sample to the next.
struct Memory<'a, const N: usize> {
    filters: [ControllerState; N],
    trackers: [Option<Tracker<'a>>; N],
    has_cameras: bool,
}

/// Upper triangle of the Gram matrix of the six terms, then heading² and lateral².
const N_SUMS: usize = N_TERMS * (N_TERMS + 1) / 2 + 2;

#[inline(always)]
fn integrands<T: Real>(state: &FlightState<T>, sight: &Sight<T>, targets: &Targets<T>, water: &Water) -> [T; N_SUMS] {
    let (pitch, roll, altitude) =
        (sight.pitch_rad - targets.pitch, sight.roll_rad - targets.roll, targets.altitude - sight.altitude_m);
    let heading_squared = sight.heading_rad * sight.heading_rad;
    let terms = [
        heading_squared,
        pitch * pitch,
        roll * roll,
        altitude * altitude,
        state[9] * state[9] + state[10] * state[10] + state[11] * state[11],
        state[0],
    ];
    let lateral = water.lateral(sight);
    let mut sums = [lateral * lateral; N_SUMS];
    let mut k = 0;
    for i in 0..N_TERMS {
        for j in i..N_TERMS {
            sums[k] = terms[i] * terms[j];
            k += 1;
        }
    }
    sums[k] = heading_squared;
    sums
}

#[inline(always)]
fn to_integrals(sums: [f64; N_SUMS], duration_s: f64) -> Integrals {
    // Where row i of the upper triangle begins, less i.
    let offset = |i: usize| i * (2 * N_TERMS - i - 1) / 2;
    let gram =
        core::array::from_fn(|i| core::array::from_fn(|j| sums[if i <= j { offset(i) + j } else { offset(j) + i }]));
    let [.., heading_squared, lateral_squared] = sums;
    Integrals { gram, heading_squared, lateral_squared, duration_s }
}

/// The flow with sine and cosine of its direction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Water {
    pub(crate) flow: Flow,
    sin: f64,
    cos: f64,
}

impl Water {
    #[inline(always)]
    fn new(flow: Flow) -> Self {
        // The plant's own functions: the same bits on every machine.
        let (sin, cos) = Real::sin_cos(flow.direction_rad);
        Self { flow, sin, cos }
    }

    /// The same with another flow: sine and cosine are kept where the direction is.
    #[inline(always)]
    fn with(self, flow: Flow) -> Self {
        if flow.direction_rad.to_bits() == self.flow.direction_rad.to_bits() {
            Self { flow, ..self }
        } else {
            Self::new(flow)
        }
    }

    /// Lateral position y of the center of mass in the ground frame, in m.
    #[inline(always)]
    pub(crate) fn lateral<T: Real>(&self, sight: &Sight<T>) -> T {
        T::constant(self.sin) * sight.forward_m + T::constant(self.cos) * sight.right_m
    }

    /// Position x of the center of mass in the ground frame, in m.
    #[inline(always)]
    fn upstream<T: Real>(&self, sight: &Sight<T>) -> T {
        T::constant(self.cos) * sight.forward_m - T::constant(self.sin) * sight.right_m
    }
}

/// What the water does within one sample, in every lane: linear from one row of the table to the next.
struct Gusts<T> {
    from: [T; 5],
    change: [T; 5],
}

// Loops over arrays in place: closures that make arrays are not always inlined here, and copy.
impl<T> Gusts<T> {
    #[inline(always)]
    fn within<const N: usize>(tables: &Option<[&WaterTable; N]>, index: usize) -> Self
    where
        T: Carrier<N>,
    {
        let mut gusts = Self { from: [T::constant(0.0); 5], change: [T::constant(0.0); 5] };
        let Some(tables) = tables else { return gusts };
        let (mut from, mut change) = ([[0.0; N]; 5], [[0.0; N]; 5]);
        for lane in 0..N {
            let [before, after] = tables[lane].around(index);
            for k in 0..5 {
                from[k][lane] = before[k];
                change[k][lane] = after[k] - before[k];
            }
        }
        for k in 0..5 {
            gusts.from[k] = T::join(from[k]);
            gusts.change[k] = T::join(change[k]);
        }
        gusts
    }

    /// At a `share` of the sample, in a mean flow of `speed_m_s`.
    #[inline(always)]
    fn at<const N: usize>(&self, share: f64, speed_m_s: f64, disturbance: &mut Disturbance<T>)
    where
        T: Carrier<N>,
    {
        let (share, speed) = (T::constant(share), T::constant(speed_m_s));
        let mut now = self.from;
        for (now, change) in now.iter_mut().zip(self.change) {
            *now = *now + share * change;
        }
        let [along, lateral, upward, right, up] = now;
        let fast = speed + speed * along;
        let squared = fast * fast;
        disturbance.velocity_m_s = [-(speed * along), speed * lateral, -(speed * upward)];
        disturbance.wake_m2_s2 = [T::constant(0.0), squared * right, -(squared * up)];
    }
}

/// The set points of each lane.
struct Targets<T> {
    altitude: T,
    pitch: T,
    roll: T,
}

impl<T> Targets<T> {
    #[inline(always)]
    fn of<const N: usize>(controllers: &[&Controller; N]) -> Self
    where
        T: Carrier<N>,
    {
        let of_each = |f: fn(&Controller) -> f64| T::join(core::array::from_fn(|lane| f(controllers[lane])));
        Self {
            altitude: of_each(|c| c.parameters().set_points.altitude_m),
            pitch: of_each(|c| c.parameters().set_points.pitch_rad),
            roll: of_each(|c| c.parameters().set_points.roll_rad),
        }
    }
}

#[inline(always)]
fn advance<T: Real, const M: usize>(x: &[T; M], h: T, slope: &[T; M]) -> [T; M] {
    let mut out = *x;
    for k in 0..M {
        out[k] = x[k] + h * slope[k];
    }
    out
}

/// One stage of RK4: where in the step it looks, its weight, and how far from the start the next one looks.
struct Stage {
    at: f64,
    /// Which of start, middle and end that is.
    instant: usize,
    weight: f64,
    next: f64,
}

const STAGES: [Stage; 4] = [
    Stage { at: 0.0, instant: 0, weight: 1.0, next: 0.5 },
    Stage { at: 0.5, instant: 1, weight: 2.0, next: 0.5 },
    Stage { at: 0.5, instant: 1, weight: 2.0, next: 1.0 },
    Stage { at: 1.0, instant: 2, weight: 1.0, next: 0.0 },
];

/// Runs the test of `setup` from the states `start` and shows every sample to `watch`.
///
/// Without `LOPSIDED` all plants are symmetric, without `MOVING` the water has its mean flow alone and no turbine is read: the loop
/// then carries no code for anything else, and keeps its speed.
#[inline(always)]
pub(crate) fn integrate<T: Carrier<N>, const N: usize, const LOPSIDED: bool, const MOVING: bool>(
    setup: &Setup<'_, T, N>,
    start: [&FlightState; N],
    mut watch: impl FnMut(&Sample<'_, T, N>),
) -> [Ending; N] {
    let Setup { plant, controllers, viewers, sample_time_s, profile, settings, used, .. } = setup;
    let targets = Targets::of(controllers);
    let mut state: FlightState<T> = core::array::from_fn(|k| T::join(core::array::from_fn(|lane| start[lane][k])));
    let mut sums = [T::constant(0.0); N_SUMS];
    let mut memory = Memory::new(viewers);
    let mut watchers = setup.meters.map(Watcher::with);
    let duration_s = profile.duration_s();
    let n_samples = ((duration_s / sample_time_s) - 1e-6).ceil() as usize;
    for index in 0..n_samples {
        let time_s = index as f64 * sample_time_s;
        let end_s = ((index + 1) as f64 * sample_time_s).min(duration_s);
        let mut piece = profile.piece_after(time_s, *sample_time_s);
        let water = Water::new(profile.flow().within(piece, time_s));
        let by_hand = profile.override_at(time_s, *sample_time_s);
        let control = memory.control(controllers, plant, &state, &water, by_hand);
        let [center, starboard, port] = control.commands;
        let held = [T::join(center), T::join(starboard), T::join(port)];
        let gusts = MOVING.then(|| Gusts::within(&setup.water, index));
        let mut from_s = time_s;
        while from_s < end_s {
            let to_s = profile.next_cut(from_s, end_s);
            let n_steps = steps_within(to_s - from_s, *sample_time_s, settings.steps_per_sample);
            let h_s = (to_s - from_s) / n_steps as f64;
            for step in 0..n_steps {
                let at_s = from_s + step as f64 * h_s;
                let (mut slope, mut growth) = ([T::constant(0.0); 12], [T::constant(0.0); N_SUMS]);
                let mut x = state;
                let disturbances = disturbances_over(gusts.as_ref(), setup, piece, time_s, [at_s, h_s]);
                // One copy of the right-hand side for the four stages keeps the code small enough to compile well.
                for stage in &STAGES {
                    let water = water.with(profile.flow().within(piece, at_s + stage.at * h_s));
                    let flow = water.flow.cast();
                    let e = evaluate_with::<T, LOPSIDED, MOVING>(plant, &x, held, &flow, &disturbances[stage.instant]);
                    if stage.at <= 0.0 && step == 0 && from_s <= time_s {
                        watch(&Sample { time_s, water, state: &x, evaluation: &e, control: &control });
                        look(&mut watchers, time_s, &x, &e, settings);
                        read_meters(&mut watchers, &x, &e, gusts.as_ref(), [water.flow.speed_m_s, end_s - time_s]);
                    }
                    let weight = T::constant(stage.weight);
                    growth = advance(&growth, weight, &integrands(&x, &e.sight, &targets, &water));
                    slope = advance(&slope, weight, &e.derivative);
                    x = advance(&state, T::constant(stage.next * h_s), &e.derivative);
                }
                state = advance(&state, T::constant(h_s / 6.0), &slope);
                sums = advance(&sums, T::constant(h_s / 6.0), &growth);
            }
            piece = profile.piece_after(to_s, *sample_time_s);
            from_s = to_s;
        }
        if watchers[..*used].iter().all(|watcher| watcher.failure.is_some()) {
            break;
        }
    }
    let sighted = memory.trackers.map(|tracker| {
        let of = |tracker: Tracker<'_>| Sighted {
            held_share: tracker.held_share(),
            blind_cameras: tracker.blind_cameras().to_vec(),
        };
        tracker.map(of)
    });
    endings(&state, &sums, watchers, sighted, duration_s)
}

impl<'a, const N: usize> Memory<'a, N> {
    #[inline(always)]
    fn new(viewers: &[Option<&'a Viewer>; N]) -> Self {
        Self {
            filters: [ControllerState::default(); N],
            trackers: viewers.map(|viewer| viewer.map(Tracker::new)),
            has_cameras: viewers.iter().any(Option::is_some),
        }
    }

    /// The commands of the three lines in every lane, after which the filters have moved on by a sample.
    ///
    /// The controller of a lane reads its estimate, or without cameras what is there to be seen; neither depends on the
    /// commands that it makes of it.
    #[inline(always)]
    fn control<T: Carrier<N>>(
        &mut self,
        controllers: &[&Controller; N],
        plant: &Plant<T>,
        state: &FlightState<T>,
        water: &Water,
        by_hand: Option<[f64; 3]>,
    ) -> Control<N> {
        let estimates =
            if self.has_cameras { observe(&mut self.trackers, &poses(plant, state, water)) } else { [None; N] };
        let seen = sight(plant, state, &water.flow.cast());
        let (altitude, pitch, roll) = (seen.altitude_m.split(), seen.pitch_rad.split(), seen.roll_rad.split());
        let mut commands = [[0.0; N]; 3];
        for lane in 0..N {
            let measured = match &estimates[lane] {
                None => Measurement { altitude_m: altitude[lane], pitch_rad: pitch[lane], roll_rad: roll[lane] },
                Some(estimate) => estimate.measurement(),
            };
            let command = controllers[lane].command(&mut self.filters[lane], &measured).saturated_m_s;
            for line in 0..3 {
                commands[line][lane] = match by_hand {
                    None => command[line],
                    Some(fractions) => fractions[line] * controllers[lane].parameters().speed_limit_m_s,
                };
            }
        }
        Control { estimates, commands }
    }
}

/// What the cameras of each lane make of where it is.
///
/// Not inlined: a loop without cameras keeps its code as it is.
#[inline(never)]
fn observe<const N: usize>(trackers: &mut [Option<Tracker<'_>>; N], poses: &[Pose; N]) -> [Option<Estimate>; N] {
    let mut estimates = [None; N];
    for (places, (four, truths)) in estimates.chunks_mut(LANES).zip(trackers.chunks_mut(LANES).zip(poses.chunks(LANES)))
    {
        places.copy_from_slice(&observe_abreast(four, truths)[..places.len()]);
    }
    estimates
}

/// Where each lane is in the ground frame, as cameras see it.
#[inline(always)]
fn poses<T: Carrier<N>, const N: usize>(plant: &Plant<T>, state: &FlightState<T>, water: &Water) -> [Pose; N] {
    let seen = sight(plant, state, &water.flow.cast());
    let (right, up) = (water.lateral(&seen).split(), seen.altitude_m.split());
    let upstream = water.upstream(&seen).split();
    let (roll, pitch, heading) = (seen.roll_rad.split(), seen.pitch_rad.split(), seen.heading_rad.split());
    core::array::from_fn(|lane| Pose {
        position_m: [upstream[lane], right[lane], -up[lane]],
        roll_rad: roll[lane],
        pitch_rad: pitch[lane],
        heading_rad: heading[lane] + water.flow.direction_rad,
    })
}

/// Where a plant is in the ground frame, in a flow.
pub(crate) fn pose_of(plant: &Plant, state: &FlightState, flow: Flow) -> Pose {
    let [pose] = poses::<f64, 1>(plant, state, &Water::new(flow));
    pose
}

/// What each lane ends with, after a last look at its state.
///
/// State and sums come by reference: as values they are copied whole, stay in memory during the loop, and a flight takes
/// a tenth more instructions.
#[inline(always)]
fn endings<T: Carrier<N>, const N: usize>(
    state: &FlightState<T>,
    sums: &[T; N_SUMS],
    mut watchers: [Watcher; N],
    mut sighted: [Option<Sighted>; N],
    duration_s: f64,
) -> [Ending; N] {
    let end = core::array::from_fn::<_, N, _>(|lane| state.map(|x| x.split()[lane]));
    for lane in 0..N {
        if watchers[lane].failure.is_none() {
            watchers[lane].check(&end[lane], duration_s);
        }
    }
    let mut lane = 0;
    watchers.map(|watcher| {
        let ending = Ending {
            integrals: to_integrals(sums.map(|sum| sum.split()[lane]), duration_s),
            extremes: watcher.extremes,
            slack: watcher.slack,
            final_state: end[lane],
            failure: watcher.failure,
            energy: watcher.meter.map(|meter| meter.energy),
            sight: sighted[lane].take(),
        };
        lane += 1;
        ending
    })
}

/// Steps in a piece of a sample: as dense as in a whole one, and at least one.
#[inline(always)]
fn steps_within(length_s: f64, sample_time_s: f64, steps_per_sample: usize) -> usize {
    ((length_s / sample_time_s * steps_per_sample as f64 - 1e-6).ceil() as usize).max(1)
}

/// The disturbances at start, middle and end of the step that begins at `at_s` and lasts `h_s`.
///
/// Made before the stages: code that is not in the block of the right-hand side leaves that small enough to be vectorized.
#[inline(always)]
fn disturbances_over<T: Carrier<N>, const N: usize>(
    gusts: Option<&Gusts<T>>,
    setup: &Setup<'_, T, N>,
    piece: usize,
    time_s: f64,
    [at_s, h_s]: [f64; 2],
) -> [Disturbance<T>; 3] {
    let mut disturbances = [Disturbance::none(); 3];
    if let Some(gusts) = gusts {
        for (disturbance, at) in disturbances.iter_mut().zip([0.0, 0.5, 1.0]) {
            let speed_m_s = setup.profile.flow().within(piece, at_s + at * h_s).speed_m_s;
            gusts.at((at_s - time_s + at * h_s) / setup.sample_time_s, speed_m_s, disturbance);
        }
    }
    disturbances
}

/// Adds to the energies of every lane what flows in the `until_next_s` after this sample, where the loop knows gusts and the test
/// has a turbine.
///
/// State and evaluation are read here and handed on as numbers: a call that took their address would keep them in memory, and
/// flights without a turbine would take a tenth longer.
#[inline(always)]
fn read_meters<T: Carrier<N>, const N: usize>(
    watchers: &mut [Watcher; N],
    state: &FlightState<T>,
    at: &Evaluation<T>,
    gusts: Option<&Gusts<T>>,
    [mean_m_s, until_next_s]: [f64; 2],
) {
    let (Some(gusts), true) = (gusts, watchers[0].meter.is_some()) else { return };
    let along = gusts.from[0].split();
    let tensions = [at.tensions.center_n.split(), at.tensions.starboard_n.split(), at.tensions.port_n.split()];
    let reel = [state[9].split(), state[10].split(), state[11].split()];
    let (pitch, heading) = (at.sight.pitch_rad.split(), at.sight.heading_rad.split());
    for (lane, watcher) in watchers.iter_mut().enumerate() {
        watcher.meter(&Reading {
            speed_m_s: mean_m_s * (1.0 + along[lane]),
            pitch_rad: pitch[lane],
            heading_rad: heading[lane],
            tensions_n: tensions.map(|line| line[lane]),
            reel_m_s: reel.map(|line| line[lane]),
            until_next_s,
        });
    }
}

/// Shows every lane its own sample.
#[inline(always)]
fn look<T: Carrier<N>, const N: usize>(
    watchers: &mut [Watcher; N],
    time_s: f64,
    state: &FlightState<T>,
    at: &Evaluation<T>,
    settings: &FlightSettings,
) {
    let (center, starboard, port) =
        (at.tensions.center_n.split(), at.tensions.starboard_n.split(), at.tensions.port_n.split());
    let (zenith, heading) = (state[0].split(), at.sight.heading_rad.split());
    let shortest = state[6].min(state[7]).min(state[8]).split();
    let sum = state.iter().skip(1).fold(state[0], |sum, x| sum + *x).split();
    for (lane, watcher) in watchers.iter_mut().enumerate() {
        let seen = Seen {
            time_s,
            zenith_rad: zenith[lane],
            heading_rad: heading[lane],
            shortest_line_m: shortest[lane],
            sum_of_state: sum[lane],
            // Written out: `array::map` is not always inlined.
            tensions_n: [center[lane], starboard[lane], port[lane]],
        };
        if !watcher.look(&seen, settings) {
            watcher.check(&state.map(|x| x.split()[lane]), time_s);
        }
    }
}
