//! The suspension of the tutorial: what its simulation and its test stand are worth.

use std::f64::consts::TAU;

use proptest::prelude::*;
use quarter_car::{
    BODY_KG, Car, Design, Drive, Error, NOISE, Ride, Sample, TIRE_N_M, Tire, Vehicle, WEIGHT_N, WHEEL_KG, Wave,
    measured, road,
};

const LOWER: [f64; 4] = Design::LOWEST.to_array();
const UPPER: [f64; 4] = Design::HIGHEST.to_array();
const BEST_SIMULATED: [f64; 4] = Design::BEST_SIMULATED.to_array();
const BEST_ON_THE_STAND: [f64; 4] = Design::BEST_ON_THE_STAND.to_array();

fn vehicle(car: Car, design: [f64; 4]) -> Vehicle {
    Vehicle { car, design: Design::from_array(design) }
}

fn cost(car: Car, design: [f64; 4]) -> f64 {
    ride(&vehicle(car, design), &road(), &Drive::STANDARD).cost_m_s2()
}

#[track_caller]
fn ride(vehicle: &Vehicle, road: &[Wave], drive: &Drive) -> Ride {
    vehicle.drive(road, drive, |_| {}).expect("a car that stays on the road")
}

fn samples(vehicle: &Vehicle, road: &[Wave], drive: &Drive) -> Vec<Sample> {
    let mut samples = Vec::new();
    vehicle.drive(road, drive, |sample| samples.push(*sample)).expect("a car that stays on the road");
    samples
}

fn designs() -> impl Strategy<Value = [f64; 4]> {
    [0, 1, 2, 3].map(|k: usize| LOWER[k]..UPPER[k])
}

fn corners() -> impl Iterator<Item = [f64; 4]> {
    (0..16).map(|corner| [0, 1, 2, 3].map(|k| if corner >> k & 1 == 1 { UPPER[k] } else { LOWER[k] }))
}

/// A complex number, as far as a transfer function needs it.
#[derive(Clone, Copy)]
struct Complex(f64, f64);

impl Complex {
    fn over(self, other: Self) -> Self {
        let square = other.0 * other.0 + other.1 * other.1;
        Self((self.0 * other.0 + self.1 * other.1) / square, (self.1 * other.0 - self.0 * other.1) / square)
    }

    fn times(self, other: Self) -> Self {
        Self(self.0 * other.0 - self.1 * other.1, self.0 * other.1 + self.1 * other.0)
    }

    fn plus(self, other: Self) -> Self {
        Self(self.0 + other.0, self.1 + other.1)
    }

    fn minus(self, other: Self) -> Self {
        Self(self.0 - other.0, self.1 - other.1)
    }

    fn size(self) -> f64 {
        self.0.hypot(self.1)
    }
}

/// Amplitudes per amplitude of the road: acceleration, tire load, travel, actuator.
///
/// Newton's law for the car as a whole, m_s s² z_s + m_u s² z_u = k_t (z_r - z_u), eliminates the wheel, and leaves
///
/// ```text
/// z_s / z_r = ((k + c s) k_t - g m_u s²) / ((m_s s² + (c + c_sky) s + k) (m_u s² + k_t) + (k + c s + g) m_s s²)
/// ```
///
/// which for a passive car is the transfer function of the textbooks. A lag divides both gains by 1 + tau s.
fn amplitudes([spring, damper, skyhook, gain]: [f64; 4], lag_s: f64, frequency_hz: f64) -> [f64; 4] {
    let real = |value: f64| Complex(value, 0.0);
    let rate = TAU * frequency_hz;
    let (s, s2) = (Complex(0.0, rate), -rate * rate);
    let late = Complex(1.0, lag_s * rate);
    let (skyhook, gain) = (real(skyhook).over(late), real(gain).over(late));
    let wheel = real(WHEEL_KG * s2 + TIRE_N_M);
    let strut = Complex(spring, damper * rate);
    let own = strut.plus(skyhook.times(s)).plus(real(BODY_KG * s2));
    let body = strut.times(real(TIRE_N_M)).minus(gain.times(real(WHEEL_KG * s2)));
    let body = body.over(own.times(wheel).plus(strut.plus(gain).times(real(BODY_KG * s2))));
    let wheel = real(TIRE_N_M).minus(body.times(real(BODY_KG * s2))).over(wheel);
    let tire = wheel.minus(real(1.0));
    let actuator = tire.times(gain).minus(body.times(skyhook).times(s));
    [-s2 * body.size(), TIRE_N_M * tire.size(), body.minus(wheel).size(), actuator.size()]
}

/// Against the closed form; transients of the least damped design have died out by 60 s.
#[track_caller]
fn check_sine(design: [f64; 4], lag_s: f64, frequency_hz: f64) {
    let amplitude_m = 0.005;
    let road = [Wave { frequency_hz, amplitude_m, phase_rad: 0.3 }];
    let drive = Drive { step_s: 5e-4, warm_up_s: 60.0, measured_s: 10.0 };
    let car = Car { actuator_lag_s: lag_s, ..Car::SIMULATED };
    let ride = ride(&vehicle(car, design), &road, &drive);
    let found = [ride.body_m_s2, ride.tire_n, ride.travel_m, ride.actuator_n];
    for (found, expected) in found.iter().zip(amplitudes(design, lag_s, frequency_hz)) {
        let expected = expected * amplitude_m / 2.0_f64.sqrt();
        // The method's error at 25 Hz is (2 pi 25 / 2000)^4 / 120 of a sine; transients the rest.
        assert!(
            (found - expected).abs() <= 2e-5 * expected.max(1e-6),
            "{design:?}, {frequency_hz} Hz: {found} {expected}"
        );
    }
}

#[test]
fn linear_car_follows_the_transfer_function() {
    for frequency_hz in [0.5, 1.3, 3.0, 11.0, 25.0] {
        for design in [BEST_SIMULATED, BEST_ON_THE_STAND, [20e3, 1500.0, 0.0, 0.0]] {
            check_sine(design, 0.0, frequency_hz);
            check_sine(design, 0.02, frequency_hz);
        }
    }
}

#[test]
fn no_design_moves_the_invariant_point() {
    // Hedrick and Butsuen (1990): at sqrt(k_t / m_u) the acceleration is k_t / m_s times the road, whatever the strut does.
    let frequency_hz = (TIRE_N_M / WHEEL_KG).sqrt() / TAU;
    for design in corners() {
        let [acceleration, ..] = amplitudes(design, 0.01, frequency_hz);
        assert!((acceleration - TIRE_N_M / BODY_KG).abs() < 1e-9 * acceleration, "{design:?}: {acceleration}");
    }
    // The same by driving; a frequency that repeats within the measured time is not needed over 200 s.
    let road = [Wave { frequency_hz, amplitude_m: 1e-3, phase_rad: 0.0 }];
    let drive = Drive { step_s: 1e-3, warm_up_s: 40.0, measured_s: 160.0 };
    for design in [BEST_SIMULATED, BEST_ON_THE_STAND] {
        let found = ride(&vehicle(Car::SIMULATED, design), &road, &drive).body_m_s2;
        let expected = TIRE_N_M / BODY_KG * 1e-3 / 2.0_f64.sqrt();
        assert!((found / expected - 1.0).abs() < 1e-3, "{design:?}: {found} {expected}");
    }
}

/// Work stored in the tire beyond that at rest, J.
fn tire_energy_j(tire: Tire, pressed_m: f64) -> f64 {
    match tire {
        Tire::Linear => 0.5 * TIRE_N_M * pressed_m * pressed_m,
        Tire::Stiffening(share) => {
            let rest_m = WEIGHT_N / TIRE_N_M;
            // The integral of k x (1 + share (x / rest - 1)) over the compression x, less that of the weight.
            let stored = |x: f64| TIRE_N_M * ((1.0 - share) * x * x / 2.0 + share * x.powi(3) / (3.0 * rest_m));
            stored((rest_m + pressed_m).max(0.0)) - stored(rest_m) - WEIGHT_N * pressed_m
        }
    }
}

fn energy_j(vehicle: &Vehicle, sample: &Sample) -> f64 {
    let state = &sample.state;
    let travel_m = state.body_m - state.wheel_m;
    0.5 * BODY_KG * state.body_m_s.powi(2)
        + 0.5 * WHEEL_KG * state.wheel_m_s.powi(2)
        + 0.5 * vehicle.design.spring_n_m * travel_m.powi(2)
        + tire_energy_j(vehicle.car.tire, sample.road_m - state.wheel_m)
}

/// What road, damper, friction and actuator put into the car, W.
fn power_w(sample: &Sample, road_m_s: f64) -> f64 {
    let sliding_m_s = sample.state.body_m_s - sample.state.wheel_m_s;
    let forces = &sample.forces;
    forces.tire_n * road_m_s + (forces.damper_n + forces.friction_n + forces.actuator_n) * sliding_m_s
}

#[test]
fn energy_changes_by_what_is_put_in() {
    let step_s = 1e-4;
    let drive = Drive { step_s, warm_up_s: 0.0, measured_s: 5.0 };
    // A road four times as rough, so that the tire leaves the ground.
    let road: Vec<Wave> = road().iter().map(|wave| Wave { amplitude_m: 4.0 * wave.amplitude_m, ..*wave }).collect();
    for car in [Car::SIMULATED, Car::ON_THE_STAND] {
        let vehicle = vehicle(car, BEST_ON_THE_STAND);
        let samples = samples(&vehicle, &road, &drive);
        let flies = samples.iter().any(|sample| sample.forces.tire_n <= -WEIGHT_N);
        assert!(flies, "the test is to cover a tire off the ground");
        // The road's rate is that of its formula.
        let rate = |time_s: f64| -> f64 {
            let rates = road.iter().map(|wave| {
                let rate = TAU * wave.frequency_hz;
                wave.amplitude_m * rate * (rate * time_s + wave.phase_rad).cos()
            });
            rates.sum()
        };
        let powers: Vec<f64> = samples.iter().map(|sample| power_w(sample, rate(sample.time_s))).collect();
        let put_in: f64 = powers.windows(2).map(|pair| 0.5 * step_s * (pair[0] + pair[1])).sum();
        let moved: f64 = powers.iter().map(|power| power.abs() * step_s).sum();
        let gained = energy_j(&vehicle, &samples[samples.len() - 1]) - energy_j(&vehicle, &samples[0]);
        // The error of the trapezoidal rule.
        assert!(
            (gained - put_in).abs() < 1e-5 * moved,
            "{car:?}: {gained} J gained, {put_in} J put in, {moved} J moved"
        );
    }
}

#[test]
fn friction_only_takes() {
    let mut taken_j = 0.0;
    for sample in samples(&vehicle(Car::ON_THE_STAND, BEST_ON_THE_STAND), &road(), &Drive::STANDARD) {
        let power_w = sample.forces.friction_n * (sample.state.body_m_s - sample.state.wheel_m_s);
        assert!(power_w <= 0.0, "{power_w} W at {} s", sample.time_s);
        assert!(sample.forces.friction_n.abs() <= Car::ON_THE_STAND.friction_n, "at {} s", sample.time_s);
        taken_j -= power_w * Drive::STANDARD.step_s;
    }
    assert!(taken_j > 100.0, "{taken_j} J");
}

#[test]
fn friction_takes_four_times_force_and_amplitude_a_cycle() {
    // Coulomb friction F against a motion between -X and X takes 4 F X a cycle, whatever its form.
    let friction_n = 100.0;
    let vehicle = vehicle(Car { friction_n, ..Car::SIMULATED }, BEST_SIMULATED);
    let road = [Wave { frequency_hz: 1.5, amplitude_m: 0.05, phase_rad: 0.0 }];
    let drive = Drive { step_s: 1e-3, warm_up_s: 0.0, measured_s: 30.0 };
    let samples = samples(&vehicle, &road, &drive);
    let swinging = &samples[20_000..];
    let travels = || swinging.iter().map(|sample| sample.state.body_m - sample.state.wheel_m);
    let amplitude_m = (travels().fold(f64::MIN, f64::max) - travels().fold(f64::MAX, f64::min)) / 2.0;
    let taken =
        |sample: &Sample| -sample.forces.friction_n * (sample.state.body_m_s - sample.state.wheel_m_s) * drive.step_s;
    let found: f64 = swinging.iter().map(taken).sum();
    let expected = 15.0 * 4.0 * friction_n * amplitude_m;
    // A little less: the modeled friction is smooth where the strut turns.
    assert!((0.99..1.0).contains(&(found / expected)), "{found} J, {expected} J");
}

#[test]
fn tire_stiffens_and_lets_go() {
    let tire = Tire::Stiffening(0.4);
    let rest_m = WEIGHT_N / TIRE_N_M;
    let slope = |pressed_m: f64| (tire.load_n(pressed_m + 1e-6) - tire.load_n(pressed_m - 1e-6)) / 2e-6;
    assert!(tire.load_n(0.0).abs() < 1e-9, "the same weight at rest");
    assert!((slope(0.0) / TIRE_N_M - 1.4).abs() < 1e-6, "stiffer at rest");
    assert!((slope(-rest_m + 1e-5) / TIRE_N_M - 0.6).abs() < 1e-3, "softer at the first touch");
    assert!((tire.load_n(-2.0 * rest_m) + WEIGHT_N).abs() < 1e-9, "nothing pulls a tire down");
}

/// Classical Runge-Kutta: an error that falls by sixteen when the step is halved.
#[test]
fn simulation_converges_with_the_fourth_order() {
    // The state at one time: mean squares also change with the times that are summed.
    let last = |step_s: f64| {
        let drive = Drive { step_s, warm_up_s: 0.0, measured_s: 2.0 + step_s };
        let samples = samples(&vehicle(Car::SIMULATED, BEST_SIMULATED), &road(), &drive);
        samples[samples.len() - 1].state.wheel_m
    };
    let [coarse, middle, fine] = [4e-3, 2e-3, 1e-3].map(last);
    let ratio = (coarse - middle) / (middle - fine);
    assert!((12.0..20.0).contains(&ratio), "{ratio}");
}

#[test]
fn step_is_short_enough_for_the_test_stand() {
    for design in corners().chain([BEST_ON_THE_STAND]) {
        let at = |step_s| {
            let drive = Drive { step_s, ..Drive::STANDARD };
            ride(&vehicle(Car::ON_THE_STAND, design), &road(), &drive).cost_m_s2()
        };
        let (standard, fine) = (at(1e-3), at(2.5e-4));
        // A twentieth of the noise.
        assert!((standard / fine - 1.0).abs() < 5e-4, "{design:?}: {standard} {fine}");
    }
}

#[test]
fn road_is_of_class_b_and_repeats() {
    let road = road();
    // The integral of 64e-6 * 0.01 * 20 / f² from 0.3 to 25 Hz, against sums over bands.
    let expected = 64e-6 * 0.01 * 20.0 * (1.0 / 0.3 - 1.0 / 25.0);
    let found: f64 = road.iter().map(|wave| wave.amplitude_m.powi(2) / 2.0).sum();
    assert!((found / expected - 1.0).abs() < 0.08, "{found} {expected}");
    for wave in road {
        let turns = wave.frequency_hz * Drive::STANDARD.measured_s;
        assert!((turns - turns.round()).abs() < 1e-9, "{wave:?}");
    }
}

#[test]
fn height_of_the_road_is_the_sum_of_its_sines() {
    let road = road();
    for sample in samples(&vehicle(Car::SIMULATED, BEST_SIMULATED), &road, &Drive::STANDARD).iter().step_by(997) {
        let expected: f64 = road
            .iter()
            .map(|wave| wave.amplitude_m * (TAU * wave.frequency_hz * sample.time_s + wave.phase_rad).sin())
            .sum();
        assert!((sample.road_m - expected).abs() < 1e-12, "at {} s: {} {expected}", sample.time_s, sample.road_m);
    }
}

/// Whether no parameter can be moved by a part of its range to a lower cost.
#[track_caller]
fn check_best(car: Car, best: [f64; 4]) {
    let lowest = cost(car, best);
    for k in 0..4 {
        for part in [-0.1, -0.03, 0.03, 0.1] {
            let mut other = best;
            other[k] += part * (UPPER[k] - LOWER[k]);
            assert!((LOWER[k]..UPPER[k]).contains(&other[k]), "{best:?} is inside");
            assert!(cost(car, other) > lowest, "{other:?} is better than {best:?}");
        }
    }
}

#[test]
fn both_optima_lie_within_the_ranges() {
    check_best(Car::SIMULATED, BEST_SIMULATED);
    check_best(Car::ON_THE_STAND, BEST_ON_THE_STAND);
}

#[test]
fn wrong_simulation_costs_nine_per_cent() {
    let loss = cost(Car::ON_THE_STAND, BEST_SIMULATED) / cost(Car::ON_THE_STAND, BEST_ON_THE_STAND) - 1.0;
    assert!((0.089..0.093).contains(&loss), "{loss}");
}

#[test]
fn late_or_limited_actuator_comes_close_to_a_perfect_one() {
    let perfect = cost(Car::SIMULATED, BEST_SIMULATED);
    let car = Car { actuator_lag_s: 1e-3, actuator_limit_n: 1e6, ..Car::SIMULATED };
    let quick = cost(car, BEST_SIMULATED);
    assert!((quick / perfect - 1.0).abs() < 2e-3, "{quick} {perfect}");
    let weak = cost(Car { actuator_limit_n: 0.0, ..Car::SIMULATED }, BEST_SIMULATED);
    let passive = cost(Car::SIMULATED, [BEST_SIMULATED[0], BEST_SIMULATED[1], 0.0, 0.0]);
    assert!((weak - passive).abs() < 1e-12, "no force is no actuator: {weak} {passive}");
}

#[test]
fn drive_that_leaves_the_model_says_when() {
    for damper in [1e9, f64::NAN] {
        let ride = vehicle(Car::SIMULATED, [20e3, damper, 0.0, 0.0]).drive(&road(), &Drive::STANDARD, |_| {});
        match ride.expect_err("too stiff for the step, or no number") {
            Error::LeavesTheModel { time_s } => assert!((0.0..0.1).contains(&time_s), "{time_s}"),
            other => panic!("{other}"),
        }
    }
}

#[test]
fn numbers_that_make_no_car_are_refused_by_name() {
    let refused = |change: fn(&mut Car)| {
        let mut car = Car::ON_THE_STAND;
        change(&mut car);
        let ride = vehicle(car, BEST_ON_THE_STAND).drive(&road(), &Drive::STANDARD, |_| {});
        ride.expect_err("no car").to_string()
    };
    assert_eq!(refused(|car| car.friction_n = -1.0), "friction_n = -1: it must be 0 N or more");
    assert_eq!(refused(|car| car.friction_n = f64::NAN), "friction_n = NaN: it must be 0 N or more");
    assert_eq!(refused(|car| car.actuator_lag_s = f64::NAN), "actuator_lag_s = NaN: it must be 0 s or more");
    assert_eq!(refused(|car| car.actuator_limit_n = -5.0), "actuator_limit_n = -5: it must be 0 N or more");
    assert_eq!(refused(|car| car.actuator_limit_n = f64::NAN), "actuator_limit_n = NaN: it must be 0 N or more");
    assert_eq!(refused(|car| car.tire = Tire::Stiffening(1.5)), "tire = 1.5: it must be a share from 0 to 1");
}

#[test]
fn times_that_make_no_drive_are_refused_by_name() {
    let refused = |step_s, warm_up_s, measured_s| {
        let drive = Drive { step_s, warm_up_s, measured_s };
        vehicle(Car::SIMULATED, BEST_SIMULATED).drive(&road(), &drive, |_| {}).expect_err("no drive").to_string()
    };
    assert_eq!(refused(0.0, 5.0, 10.0), "step_s = 0: it must be above 0 s");
    assert_eq!(refused(f64::NAN, 5.0, 10.0), "step_s = NaN: it must be above 0 s");
    assert_eq!(refused(1e-3, -1.0, 10.0), "warm_up_s = -1: it must be 0 s or more");
    assert_eq!(refused(1e-3, 0.0, 0.0), "measured_s = 0: it must be a step or more");
    assert_eq!(refused(1e-3, 0.0, f64::INFINITY), "measured_s = inf: it must be a step or more");
    assert_eq!(
        refused(1e-30, 0.0, 1.0),
        "step_s = 0.000000000000000000000000000001: it must be at least the hundred millionth part of the drive"
    );
}

#[test]
fn noise_is_bounded_repeatable_and_fair() {
    let errors: Vec<f64> = (0..4000).map(|run| measured(2.0, run) / 2.0 - 1.0).collect();
    assert!(errors.iter().all(|error| error.abs() <= NOISE), "bounded");
    let mean = errors.iter().sum::<f64>() / errors.len() as f64;
    // Five standard errors of the mean of a uniform distribution.
    assert!(mean.abs() < 5.0 * NOISE / (3.0 * 4000.0_f64).sqrt(), "{mean}");
    let square = errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64;
    assert!((square / (NOISE * NOISE / 3.0) - 1.0).abs() < 0.1, "uniform: {square}");
    let together: f64 = errors.windows(2).map(|pair| pair[0] * pair[1]).sum::<f64>() / errors.len() as f64;
    assert!(together.abs() < 0.1 * square, "neighbors have nothing in common: {together}");
    assert_eq!(measured(2.0, 3).to_bits(), measured(2.0, 3).to_bits());
    assert_ne!(measured(2.0, 3).to_bits(), measured(2.0, 4).to_bits());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn every_design_of_the_ranges_has_a_moderate_cost(design in designs()) {
        for car in [Car::SIMULATED, Car::ON_THE_STAND] {
            let cost = cost(car, design);
            prop_assert!((0.9..3.0).contains(&cost), "{:?}: {}", design, cost);
        }
    }

    #[test]
    fn linear_car_scales_with_the_road(design in designs(), factor in 0.1..3.0_f64) {
        let drive = Drive { step_s: 1e-3, warm_up_s: 0.0, measured_s: 2.0 };
        let scaled: Vec<Wave> =
            road().iter().map(|wave| Wave { amplitude_m: factor * wave.amplitude_m, ..*wave }).collect();
        let vehicle = vehicle(Car::SIMULATED, design);
        let [one, other] = [road(), scaled].map(|road| ride(&vehicle, &road, &drive).cost_m_s2());
        prop_assert!((other / one / factor - 1.0).abs() < 1e-9, "{} {}", one, other);
    }
}
