//! One loop in the frequency domain: the discrete filter against G(jω) behind a sampler and a hold.

use std::f64::consts::{PI, TAU};

use tether_control::{FilteredPd, PdState};

/// A complex number, just large enough for this file.
#[derive(Clone, Copy, Debug)]
struct Complex {
    re: f64,
    im: f64,
}

impl Complex {
    fn new(re: f64, im: f64) -> Self {
        Self { re, im }
    }

    /// exp(j angle).
    fn turn(angle_rad: f64) -> Self {
        Self::new(angle_rad.cos(), angle_rad.sin())
    }

    fn plus(self, other: Self) -> Self {
        Self::new(self.re + other.re, self.im + other.im)
    }

    fn minus(self, other: Self) -> Self {
        Self::new(self.re - other.re, self.im - other.im)
    }

    fn times(self, other: Self) -> Self {
        Self::new(self.re * other.re - self.im * other.im, self.re * other.im + self.im * other.re)
    }

    fn over(self, other: Self) -> Self {
        let norm = other.re * other.re + other.im * other.im;
        let top = self.times(Self::new(other.re, -other.im));
        Self::new(top.re / norm, top.im / norm)
    }

    fn abs(self) -> f64 {
        self.re.hypot(self.im)
    }
}

const PROPORTIONAL: f64 = 0.04;
const DERIVATIVE: f64 = 0.016;
const TIME_CONSTANT_S: f64 = 0.1;
const INITIAL_GAIN: f64 = DERIVATIVE / TIME_CONSTANT_S;

/// Rounding of the running filter and of the sum.
const ROUNDING: f64 = 1e-12;

/// G(jω) as (10) prints it.
fn continuous(omega_rad_s: f64) -> Complex {
    Complex::new(PROPORTIONAL, DERIVATIVE * omega_rad_s).over(Complex::new(1.0, TIME_CONSTANT_S * omega_rad_s))
}

/// The gain measured on the running filter, at e_k = exp(jωkT) after the start has died out.
fn measured(omega_rad_s: f64, sample_time_s: f64) -> Complex {
    let sampled = FilteredPd::new(PROPORTIONAL, DERIVATIVE, TIME_CONSTANT_S)
        .and_then(|pd| pd.sampled(sample_time_s))
        .expect("valid gains");
    let (mut real, mut imaginary) = (PdState::default(), PdState::default());
    let samples = (50.0 * TIME_CONSTANT_S / sample_time_s).ceil() as usize + 10;
    let mut gain = Complex::new(0.0, 0.0);
    for sample in 0..samples {
        let error = Complex::turn(omega_rad_s * sample as f64 * sample_time_s);
        let output = Complex::new(sampled.output(&mut real, error.re), sampled.output(&mut imaginary, error.im));
        gain = output.over(error);
    }
    gain
}

/// Sampling folds every alias ω + n 2π/T of the held error onto ω:
/// `H = k_d/τ + Σ_n (G − k_d/τ)(jω_n) (1 − exp(−jω_n T)) / (jω_n T)`; the constant k_d/τ passes a hold unchanged.
fn held(omega_rad_s: f64, sample_time_s: f64) -> Complex {
    let constant = Complex::new(INITIAL_GAIN, 0.0);
    (-ALIASES..=ALIASES)
        .map(|alias| omega_rad_s + f64::from(alias) * TAU / sample_time_s)
        .map(|omega| {
            let hold = Complex::new(1.0, 0.0)
                .minus(Complex::turn(-omega * sample_time_s))
                .over(Complex::new(0.0, omega * sample_time_s));
            continuous(omega).minus(constant).times(hold)
        })
        .fold(constant, Complex::plus)
}

/// Aliases taken on either side.
const ALIASES: i32 = 100_000;

/// What the aliases left out can add up to: each term is at most `2 |k_p − k_d/τ| / (τ T ω_n²)` with `ω_n ≈ 2πn/T`.
fn tail(sample_time_s: f64) -> f64 {
    let filtered_gain = (PROPORTIONAL - INITIAL_GAIN).abs();
    filtered_gain * sample_time_s / (PI * PI * TIME_CONSTANT_S * f64::from(ALIASES))
}

#[test]
fn discrete_filter_is_the_continuous_one_behind_a_sampler_and_a_hold() {
    for sample_time_s in [0.005, 0.025, 0.1, 0.4] {
        for share_of_nyquist in [0.01, 0.1, 0.37, 0.73, 0.99] {
            let omega_rad_s = share_of_nyquist * 0.5 * TAU / sample_time_s;
            let difference = measured(omega_rad_s, sample_time_s).minus(held(omega_rad_s, sample_time_s));
            assert!(
                difference.abs() <= tail(sample_time_s) + ROUNDING,
                "at {omega_rad_s} rad/s and {sample_time_s} s: off by {difference:?}"
            );
        }
    }
}

#[test]
fn filtered_part_lags_by_half_a_sample_and_little_more() {
    // The lag that the README states, on the filtered part only: k_d/τ acts at once in both.
    for sample_time_s in [0.005, 0.025, 0.1] {
        for omega_rad_s in [0.1, 1.0, 5.0] {
            let filtered = continuous(omega_rad_s).minus(Complex::new(INITIAL_GAIN, 0.0));
            let error = measured(omega_rad_s, sample_time_s).minus(continuous(omega_rad_s));
            let share_of_new = 1.0 - (-sample_time_s / TIME_CONSTANT_S).exp();
            let lag_s = sample_time_s / share_of_new - TIME_CONSTANT_S;
            let half_and_more = sample_time_s / 2.0 + sample_time_s.powi(2) / 12.0 / TIME_CONSTANT_S;
            assert!((lag_s / half_and_more - 1.0).abs() < 3e-3, "{lag_s} s, not {half_and_more} s");
            let expected = omega_rad_s * lag_s * filtered.abs();
            assert!(
                (error.abs() / expected - 1.0).abs() < 5e-3,
                "at {omega_rad_s} rad/s and {sample_time_s} s: {}, not {expected}",
                error.abs()
            );
        }
    }
}
