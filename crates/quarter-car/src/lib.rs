#![doc = include_str!("../README.md")]

use std::f64::consts::TAU;

/// m_s, mass of the body.
pub const BODY_KG: f64 = 300.0;
/// m_u, mass of wheel and axle.
pub const WHEEL_KG: f64 = 40.0;
/// What the tire carries at rest.
pub const WEIGHT_N: f64 = (BODY_KG + WHEEL_KG) * 9.81;
/// That over the deflection of the tire at rest, as one would measure it with a ruler.
pub const TIRE_N_M: f64 = 180e3;
/// Where friction has reached tanh 1 = 76 % of its value.
const FRICTION_SPEED_M_S: f64 = 0.01;
/// Farther than this from rest no strut reaches.
const LARGEST_HEIGHT_M: f64 = 1.0;

/// What is designed: two parameters of the plant, two of the controller.
#[derive(Clone, Copy, Debug)]
pub struct Design {
    /// k_s, N/m.
    pub spring_n_m: f64,
    /// c_s, N s/m.
    pub damper_n_s_m: f64,
    /// c_sky, N s/m: holds against the velocity of the body.
    pub skyhook_n_s_m: f64,
    /// g_t, N/m: relieves a tire that is pressed, and presses one that is relieved.
    pub tire_gain_n_m: f64,
}

impl Design {
    /// Best for [`Car::SIMULATED`]: found by a search from four starts, all of which ended here; digits beyond change the cost by
    /// less than 1e-6.
    pub const BEST_SIMULATED: Self =
        Self { spring_n_m: 13_670.0, damper_n_s_m: 1357.0, skyhook_n_s_m: 1426.0, tire_gain_n_m: 10_890.0 };
    /// The same for [`Car::ON_THE_STAND`].
    pub const BEST_ON_THE_STAND: Self =
        Self { spring_n_m: 17_550.0, damper_n_s_m: 632.0, skyhook_n_s_m: 1439.0, tire_gain_n_m: 35_040.0 };
    /// The least that can be chosen of each.
    pub const LOWEST: Self = Self { spring_n_m: 8e3, damper_n_s_m: 300.0, skyhook_n_s_m: 0.0, tire_gain_n_m: 0.0 };
    /// The most.
    pub const HIGHEST: Self =
        Self { spring_n_m: 30e3, damper_n_s_m: 2500.0, skyhook_n_s_m: 4000.0, tire_gain_n_m: 60e3 };

    /// In the order of the fields.
    #[must_use]
    pub const fn to_array(self) -> [f64; 4] {
        [self.spring_n_m, self.damper_n_s_m, self.skyhook_n_s_m, self.tire_gain_n_m]
    }

    /// The same from four numbers.
    #[must_use]
    pub const fn from_array([spring_n_m, damper_n_s_m, skyhook_n_s_m, tire_gain_n_m]: [f64; 4]) -> Self {
        Self { spring_n_m, damper_n_s_m, skyhook_n_s_m, tire_gain_n_m }
    }
}

/// What is not designed, and where the simulation is wrong.
#[derive(Clone, Copy, Debug)]
pub struct Car {
    /// How it carries.
    pub tire: Tire,
    /// Of the strut, N, zero or more.
    pub friction_n: f64,
    /// Time constant of the actuator, s, zero or more; at zero it follows at once.
    pub actuator_lag_s: f64,
    /// What the actuator can be asked for, N, zero or more, also without limit.
    pub actuator_limit_n: f64,
}

impl Car {
    /// What the simulation knows: a linear tire, no friction, an actuator that follows at once.
    pub const SIMULATED: Self =
        Self { tire: Tire::Linear, friction_n: 0.0, actuator_lag_s: 0.0, actuator_limit_n: f64::INFINITY };
    /// The test stand: the tire stiffens and leaves the ground, the strut sticks, the actuator is late and limited.
    pub const ON_THE_STAND: Self =
        Self { tire: Tire::Stiffening(0.4), friction_n: 200.0, actuator_lag_s: 0.02, actuator_limit_n: 1000.0 };
}

impl Car {
    fn validate(&self) -> Result<(), Error> {
        let check = |name, value: f64, is_right: bool, expected| match is_right {
            true => Ok(()),
            false => Err(Error::Car { name, value, expected }),
        };
        let is_finite_and_not_negative = |value: f64| value.is_finite() && value >= 0.0;
        if let Tire::Stiffening(share) = self.tire {
            check("tire", share, (0.0..=1.0).contains(&share), "a share from 0 to 1")?;
        }
        check("friction_n", self.friction_n, is_finite_and_not_negative(self.friction_n), "0 N or more")?;
        check("actuator_lag_s", self.actuator_lag_s, is_finite_and_not_negative(self.actuator_lag_s), "0 s or more")?;
        check("actuator_limit_n", self.actuator_limit_n, self.actuator_limit_n >= 0.0, "0 N or more")
    }
}

/// The load of a tire over how far it is pressed.
#[derive(Clone, Copy, Debug)]
pub enum Tire {
    /// A spring of [`TIRE_N_M`] that also pulls.
    Linear,
    /// By this share, from 0 to 1, stiffer at rest than [`TIRE_N_M`], and softer at the first touch; off the ground without load.
    Stiffening(f64),
}

impl Tire {
    /// N, in newton, where the tire is pressed by so much more than at rest.
    pub fn load_n(self, pressed_m: f64) -> f64 {
        match self {
            Self::Linear => TIRE_N_M * pressed_m,
            Self::Stiffening(share) => {
                let at_rest_m = WEIGHT_N / TIRE_N_M;
                let all_m = (at_rest_m + pressed_m).max(0.0);
                TIRE_N_M * all_m * (1.0 + share * (all_m / at_rest_m - 1.0)) - WEIGHT_N
            }
        }
    }
}

/// One sine of a road as it passes below the wheel.
#[derive(Clone, Copy, Debug)]
pub struct Wave {
    /// As it passes, Hz.
    pub frequency_hz: f64,
    /// Of the height, m.
    pub amplitude_m: f64,
    /// At the beginning, rad.
    pub phase_rad: f64,
}

/// A road of class B of ISO 8608, G_d(n) = 64e-6 m^3 (n / 0.1 m^-1)^-2, at 20 m/s, from 0.3 to 25 Hz.
///
/// All frequencies are multiples of 0.1 Hz: the road repeats after the 10 s that [`Drive::STANDARD`] measures.
pub fn road() -> Vec<Wave> {
    const SPEED_M_S: f64 = 20.0;
    const DENSITY_M3: f64 = 64e-6;
    const AT_PER_M: f64 = 0.1;
    const FIRST: f64 = 3.0;
    const LAST: f64 = 250.0;
    const N_RATIOS: u32 = 39;
    let tenth = |k: u32| FIRST * (LAST / FIRST).powf(f64::from(k) / f64::from(N_RATIOS));
    let mut tenths: Vec<f64> = (0..=N_RATIOS).map(|k| tenth(k).round()).collect();
    tenths.dedup();
    let frequency_hz = |k: usize| tenths[k.min(tenths.len() - 1)] / 10.0;
    // The band of a sine ends half way to its neighbors, on the scale of the logarithm.
    let edge_hz = |k: usize| (frequency_hz(k) * frequency_hz(k + 1)).sqrt();
    let waves = tenths.iter().enumerate().map(|(k, tenths)| {
        let from_hz = if k == 0 { frequency_hz(0) } else { edge_hz(k - 1) };
        let density_m2_s = DENSITY_M3 * AT_PER_M.powi(2) * SPEED_M_S / frequency_hz(k).powi(2);
        Wave {
            frequency_hz: frequency_hz(k),
            amplitude_m: (2.0 * density_m2_s * (edge_hz(k) - from_hz)).sqrt(),
            // The golden ratio spreads the phases without a pattern.
            phase_rad: TAU * (tenths * 0.618_033_988_749_895).fract(),
        }
    });
    waves.collect()
}

/// Heights of a road, m, from zero on at equal times: each sine is turned on by the same small angle.
fn heights_m(road: &[Wave], interval_s: f64, n: usize) -> Vec<f64> {
    let turns: Vec<(f64, f64)> = road.iter().map(|wave| (TAU * wave.frequency_hz * interval_s).sin_cos()).collect();
    let mut now: Vec<(f64, f64)> = road.iter().map(|wave| wave.phase_rad.sin_cos()).collect();
    let mut heights = Vec::with_capacity(n);
    for _ in 0..n {
        heights.push(road.iter().zip(&now).map(|(wave, (sine, _))| wave.amplitude_m * sine).sum());
        for ((sine, cosine), (turn_sine, turn_cosine)) in now.iter_mut().zip(&turns) {
            (*sine, *cosine) = (*sine * turn_cosine + *cosine * turn_sine, *cosine * turn_cosine - *sine * turn_sine);
        }
    }
    heights
}

/// Body, wheel and actuator at one time.
#[derive(Clone, Copy, Debug)]
pub struct State {
    /// z_s, height of the body above rest, m.
    pub body_m: f64,
    /// Its rate, m/s.
    pub body_m_s: f64,
    /// z_u, height of the wheel above rest, m.
    pub wheel_m: f64,
    /// Its rate, m/s.
    pub wheel_m_s: f64,
    /// Force of the actuator, N; stays zero where there is no lag.
    pub actuator_n: f64,
}

impl State {
    fn plus(self, time_s: f64, rates: &Self) -> Self {
        Self {
            body_m: self.body_m + time_s * rates.body_m,
            body_m_s: self.body_m_s + time_s * rates.body_m_s,
            wheel_m: self.wheel_m + time_s * rates.wheel_m,
            wheel_m_s: self.wheel_m_s + time_s * rates.wheel_m_s,
            actuator_n: self.actuator_n + time_s * rates.actuator_n,
        }
    }
}

/// All in N; those of strut and actuator push the body up and the wheel down, that of the tire pushes the wheel up.
#[derive(Clone, Copy, Debug)]
pub struct Forces {
    /// Of the spring.
    pub spring_n: f64,
    /// Of the damper.
    pub damper_n: f64,
    /// Of the strut's friction.
    pub friction_n: f64,
    /// u.
    pub actuator_n: f64,
    /// N.
    pub tire_n: f64,
}

impl Forces {
    fn on_the_body_n(&self) -> f64 {
        self.spring_n + self.damper_n + self.friction_n + self.actuator_n
    }
}

/// A car with its design.
#[derive(Clone, Copy, Debug)]
pub struct Vehicle {
    /// What is given.
    pub car: Car,
    /// What is chosen.
    pub design: Design,
}

impl Vehicle {
    fn command_n(&self, state: &State, road_m: f64) -> f64 {
        let Design { skyhook_n_s_m, tire_gain_n_m, .. } = self.design;
        let limit_n = self.car.actuator_limit_n;
        (tire_gain_n_m * (state.wheel_m - road_m) - skyhook_n_s_m * state.body_m_s).clamp(-limit_n, limit_n)
    }

    fn lags(&self) -> bool {
        self.car.actuator_lag_s > 0.0
    }

    fn forces(&self, state: &State, road_m: f64) -> Forces {
        let sliding_m_s = state.body_m_s - state.wheel_m_s;
        Forces {
            spring_n: -self.design.spring_n_m * (state.body_m - state.wheel_m),
            damper_n: -self.design.damper_n_s_m * sliding_m_s,
            friction_n: self.friction_n(sliding_m_s),
            actuator_n: if self.lags() { state.actuator_n } else { self.command_n(state, road_m) },
            tire_n: self.car.tire.load_n(road_m - state.wheel_m),
        }
    }

    fn friction_n(&self, sliding_m_s: f64) -> f64 {
        let largest_n = self.car.friction_n;
        if largest_n > 0.0 { -largest_n * (sliding_m_s / FRICTION_SPEED_M_S).tanh() } else { 0.0 }
    }

    /// The rate of each entry of the state.
    fn rates(&self, state: &State, road_m: f64) -> State {
        let forces = self.forces(state, road_m);
        let behind_n = if self.lags() { self.command_n(state, road_m) - state.actuator_n } else { 0.0 };
        State {
            body_m: state.body_m_s,
            body_m_s: forces.on_the_body_n() / BODY_KG,
            wheel_m: state.wheel_m_s,
            wheel_m_s: (forces.tire_n - forces.on_the_body_n()) / WHEEL_KG,
            actuator_n: if self.lags() { behind_n / self.car.actuator_lag_s } else { 0.0 },
        }
    }

    /// The state one step of the classical Runge-Kutta method later; the road before, half way and after.
    fn stepped(&self, state: &State, road_m: [f64; 3], step_s: f64) -> State {
        let k1 = self.rates(state, road_m[0]);
        let k2 = self.rates(&state.plus(step_s / 2.0, &k1), road_m[1]);
        let k3 = self.rates(&state.plus(step_s / 2.0, &k2), road_m[1]);
        let k4 = self.rates(&state.plus(step_s, &k3), road_m[2]);
        state.plus(step_s / 6.0, &k1).plus(step_s / 3.0, &k2).plus(step_s / 3.0, &k3).plus(step_s / 6.0, &k4)
    }

    /// Drives, starting at rest on the road's first height, and shows every step to `see`.
    ///
    /// # Errors
    /// [`Error::Car`] and [`Error::Drive`] for numbers that make no car or no drive; [`Error::LeavesTheModel`] once body or wheel are where no car can be, which is
    /// also what becomes of designs and roads that are not finite.
    pub fn drive(&self, road: &[Wave], drive: &Drive, see: impl FnMut(&Sample)) -> Result<Ride, Error> {
        self.car.validate()?;
        self.drive_over(&Track::new(road, drive)?, see)
    }

    /// The same over a track, which many drives may share.
    ///
    /// # Errors
    /// [`Error::Car`] and [`Error::LeavesTheModel`], as of [`Vehicle::drive`].
    pub fn drive_over(&self, track: &Track, mut see: impl FnMut(&Sample)) -> Result<Ride, Error> {
        self.car.validate()?;
        let Track { step_s, warm_up, measured, ref road_m } = *track;
        let (body_m, wheel_m) = (road_m[0], road_m[0]);
        let mut state = State { body_m, body_m_s: 0.0, wheel_m, wheel_m_s: 0.0, actuator_n: 0.0 };
        let mut squares = [0.0; 4];
        for step in 0..warm_up + measured {
            let time_s = step as f64 * step_s;
            let [now_m, half_m, next_m] = [0, 1, 2].map(|k| road_m[2 * step + k]);
            let is_within = |height_m: f64| height_m.abs() <= LARGEST_HEIGHT_M;
            if !(is_within(state.body_m) && is_within(state.wheel_m)) {
                return Err(Error::LeavesTheModel { time_s });
            }
            let forces = self.forces(&state, now_m);
            see(&Sample { time_s, road_m: now_m, state, forces });
            if step >= warm_up {
                let travel_m = state.body_m - state.wheel_m;
                let seen = [forces.on_the_body_n() / BODY_KG, forces.tire_n, travel_m, forces.actuator_n];
                squares.iter_mut().zip(seen).for_each(|(sum, value)| *sum += value * value);
            }
            state = self.stepped(&state, [now_m, half_m, next_m], step_s);
        }
        let [body_m_s2, tire_n, travel_m, actuator_n] = squares.map(|sum| (sum / measured as f64).sqrt());
        Ok(Ride { body_m_s2, tire_n, travel_m, actuator_n })
    }
}

/// The heights of a road at the steps of a drive, and half way between them.
#[derive(Clone, Debug)]
pub struct Track {
    step_s: f64,
    /// Steps.
    warm_up: usize,
    measured: usize,
    road_m: Vec<f64>,
}

impl Track {
    /// Of a road, for a drive.
    ///
    /// # Errors
    /// [`Error::Drive`] for times that make no drive.
    pub fn new(road: &[Wave], drive: &Drive) -> Result<Self, Error> {
        drive.validate()?;
        let step_s = drive.step_s;
        let [warm_up, measured] = [drive.warm_up_s, drive.measured_s].map(|time_s| (time_s / step_s).round() as usize);
        let road_m = heights_m(road, step_s / 2.0, 2 * (warm_up + measured) + 1);
        Ok(Self { step_s, warm_up, measured, road_m })
    }
}

/// Times of a drive, s.
#[derive(Clone, Copy, Debug)]
pub struct Drive {
    /// Of the integration; above zero.
    pub step_s: f64,
    /// Before anything is measured; zero or more.
    pub warm_up_s: f64,
    /// While it is measured; a step or more.
    pub measured_s: f64,
}

impl Drive {
    /// 5 s for transients to die out, then one period of [`road`].
    pub const STANDARD: Self = Self { step_s: 1e-3, warm_up_s: 5.0, measured_s: 10.0 };
}

/// More steps than any road is worth.
const MOST_STEPS: f64 = 1e8;

impl Drive {
    fn validate(&self) -> Result<(), Error> {
        let Self { step_s, warm_up_s, measured_s } = *self;
        let check = |name, value: f64, is_right: bool, expected| match is_right && value.is_finite() {
            true => Ok(()),
            false => Err(Error::Drive { name, value, expected }),
        };
        check("step_s", step_s, step_s > 0.0, "above 0 s")?;
        check("warm_up_s", warm_up_s, warm_up_s >= 0.0, "0 s or more")?;
        check("measured_s", measured_s, measured_s >= step_s, "a step or more")?;
        let n_steps = (warm_up_s + measured_s) / step_s;
        check("step_s", step_s, n_steps <= MOST_STEPS, "at least the hundred millionth part of the drive")
    }
}

/// Why there is no ride.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Body or wheel is farther than 1 m from rest, or nowhere.
    #[error("the drive ends at {time_s:.3} s: body or wheel is more than 1 m from rest")]
    LeavesTheModel {
        /// When, s.
        time_s: f64,
    },
    /// A number that makes no car.
    #[error("{name} = {value}: it must be {expected}")]
    Car {
        /// The field of [`Car`].
        name: &'static str,
        /// What it was.
        value: f64,
        /// What it may be.
        expected: &'static str,
    },
    /// A time that makes no drive.
    #[error("{name} = {value}: it must be {expected}")]
    Drive {
        /// The field of [`Drive`].
        name: &'static str,
        /// What it was.
        value: f64,
        /// What it may be.
        expected: &'static str,
    },
}

/// One step of a drive.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// Since the beginning, s.
    pub time_s: f64,
    /// z_r, height of the road, m.
    pub road_m: f64,
    /// Before the step.
    pub state: State,
    /// In that state.
    pub forces: Forces,
}

/// Root mean squares of a drive.
#[derive(Clone, Copy, Debug)]
pub struct Ride {
    /// Acceleration of the body, m/s^2.
    pub body_m_s2: f64,
    /// Load of the tire beyond that at rest, N.
    pub tire_n: f64,
    /// Deflection of the strut, m.
    pub travel_m: f64,
    /// Force of the actuator, N.
    pub actuator_n: f64,
}

impl Ride {
    /// Comfort, road holding, room and effort in one number, m/s^2; less is better.
    ///
    /// The quadratic cost of optimal suspensions (Hrovat 1997), as a root mean square: 1 m/s^2 of the body weighs as much
    /// as 667 N at the tire, 10 mm of travel or 333 N of the actuator.
    pub fn cost_m_s2(&self) -> f64 {
        let terms = [self.body_m_s2, 1.5e-3 * self.tire_n, 100.0 * self.travel_m, 3e-3 * self.actuator_n];
        terms.iter().map(|term| term * term).sum::<f64>().sqrt()
    }
}

/// Largest error of a measured cost, as a share of it.
pub const NOISE: f64 = 0.01;

/// What the test stand reads in run `run`: off by at most [`NOISE`], in the same way whenever the run is repeated.
pub fn measured(cost: f64, run: u64) -> f64 {
    // SplitMix64 (Steele, Lea, Flood 2014); its 53 upper bits are uniform on [0, 1).
    let mut bits = run.wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    bits = (bits ^ (bits >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    bits = (bits ^ (bits >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    bits ^= bits >> 31;
    let share = (bits >> 11) as f64 / (1_u64 << 53) as f64;
    cost * (1.0 + NOISE * (2.0 * share - 1.0))
}
