//! Turbulence of the water by the Dryden spectra: seeded, exact at the sample times, frozen before the flight.

use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::error::Error;

/// Gusts with the Dryden spectra, carried past the body by the mean flow (Taylor's hypothesis).
///
/// With s the distance that the mean flow has gone, a gust along the flow has the autocorrelation `sigma² exp(−s/L)`, one across
/// it `sigma² (1 − s/(2 L)) exp(−s/L)`: the pair that isotropy asks for. The spectra over the wave number k in rad/m, for k > 0, are
///
/// ```text
/// along    sigma² (2 L/pi) / (1 + (L k)²)
/// across   sigma² (L/pi) (1 + 3 (L k)²) / (1 + (L k)²)²
/// ```
///
/// Source: MIL-F-8785C, 3.7.1.2, with one length for all directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turbulence {
    /// Standard deviation of the gusts along the flow over the mean speed, from 0 to 0.5. Water channels: 0.01 to 0.05.
    pub intensity: f64,
    /// Standard deviation of the gusts to the side over the mean speed, from 0 to 0.5.
    pub lateral_intensity: f64,
    /// Standard deviation of the vertical gusts over the mean speed, from 0 to 0.5.
    pub vertical_intensity: f64,
    /// L, the longitudinal integral length scale, in m; more than zero.
    pub length_m: f64,
}

/// A gust as strong as half of the mean flow is no disturbance of it any more.
pub(crate) const LARGEST_INTENSITY: f64 = 0.5;

impl Turbulence {
    /// # Errors
    /// [`Error::Argument`] for an intensity that is not within 0 and 0.5 or a length that is not positive and finite.
    pub fn validate(&self) -> Result<(), Error> {
        let intensities = [
            ("intensity of the turbulence", self.intensity),
            ("lateral intensity of the turbulence", self.lateral_intensity),
            ("vertical intensity of the turbulence", self.vertical_intensity),
        ];
        for (name, value) in intensities {
            if !(0.0..=LARGEST_INTENSITY).contains(&value) {
                return Err(Error::Argument { name, value, expected: "0 to 0.5" });
            }
        }
        if !(self.length_m.is_finite() && self.length_m > 0.0) {
            return Err(Error::Argument {
                name: "length scale of the turbulence in m",
                value: self.length_m,
                expected: "finite and more than zero",
            });
        }
        Ok(())
    }

    /// Whether there are no gusts at all.
    #[must_use]
    pub fn is_still(&self) -> bool {
        [self.intensity, self.lateral_intensity, self.vertical_intensity].iter().all(|intensity| *intensity <= 0.0)
    }
}

/// One gust component of unit variance, `ACROSS` the flow or along it, carried on by the mean flow.
///
/// The output of a linear filter driven by white noise, stepped exactly: with h(s) the response to an impulse, s in lengths L,
///
/// ```text
/// along    h = sqrt(2) e^−s
/// across   h = (sqrt(3) + (1 − sqrt(3)) s) e^−s
/// ```
///
/// both of unit square integral. The states are the integrals over `e^−s` and `s e^−s`; their noise over a step has the
/// covariances `∫ e^−2s`, `∫ s e^−2s` and `∫ s² e^−2s`, and the start is drawn from its stationary distribution.
/// A gust along the flow has one state, and draws one number a step.
///
/// The generator is not part of it, so that the state can stay in registers.
pub(crate) struct Gust<const ACROSS: bool> {
    state: [f64; 2],
    /// What a gust has of the two states.
    shares: [f64; 2],
}

/// What a distance that the mean flow goes does to a gust.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Passage {
    /// In lengths L.
    step: f64,
    decay: f64,
    noise: [f64; 3],
}

impl Passage {
    /// Over `step` lengths L.
    pub(crate) fn over(step: f64) -> Self {
        Self { step, decay: (-step).exp(), noise: factor(noise_over(step)) }
    }
}

impl<const ACROSS: bool> Gust<ACROSS> {
    /// The gust at the start.
    #[inline(always)]
    pub(crate) fn new(generator: &mut ChaCha8Rng) -> Self {
        let root = 3f64.sqrt();
        let shares = if ACROSS { [root, 1.0 - root] } else { [core::f64::consts::SQRT_2, 0.0] };
        Self { state: Self::kick(factor([0.5, 0.25, 0.25]), generator), shares }
    }

    #[inline(always)]
    pub(crate) fn now(&self) -> f64 {
        let along = self.shares[0] * self.state[0];
        if ACROSS { along + self.shares[1] * self.state[1] } else { along }
    }

    #[inline(always)]
    pub(crate) fn pass(&mut self, Passage { step, decay, noise }: Passage, generator: &mut ChaCha8Rng) {
        let [a, b] = Self::kick(noise, generator);
        let [first, second] = self.state;
        self.state = [decay * first + a, if ACROSS { decay * (second + step * first) + b } else { 0.0 }];
    }

    #[inline(always)]
    fn kick([first, shared, own]: [f64; 3], generator: &mut ChaCha8Rng) -> [f64; 2] {
        let mut normal = || -> f64 { StandardNormal.sample(generator) };
        let a = normal();
        [first * a, if ACROSS { shared * a + own * normal() } else { 0.0 }]
    }
}

/// The Cholesky factor of the covariance `[q11, q12, q22]`, in the order 11, 21, 22.
fn factor([q11, q12, q22]: [f64; 3]) -> [f64; 3] {
    let first = q11.max(0.0).sqrt();
    let shared = if first > 0.0 { q12 / first } else { 0.0 };
    [first, shared, (q22 - shared * shared).max(0.0).sqrt()]
}

/// `∫ e^−2s`, `∫ s e^−2s`, `∫ s² e^−2s` from 0 to `step`, by series where the closed forms cancel.
fn noise_over(step: f64) -> [f64; 3] {
    if step < 1e-2 {
        let power = |n: i32| step.powi(n);
        // e^−2s = Σ (−2s)^k/k!
        let series = |p: i32| {
            let (mut sum, mut term) = (0.0, 1.0);
            for k in 0..6 {
                sum += term * power(p + k + 1) / f64::from(p + k + 1);
                term *= -2.0 / f64::from(k + 1);
            }
            sum
        };
        return [series(0), series(1), series(2)];
    }
    let e = (-2.0 * step).exp();
    [0.5 * (1.0 - e), 0.25 * (1.0 - e * (1.0 + 2.0 * step)), 0.25 * (1.0 - e * (1.0 + 2.0 * step + 2.0 * step * step))]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn series_and_closed_form_of_the_noise_meet() {
        let (below, above) = (noise_over(1e-2 - 1e-12), noise_over(1e-2));
        for (a, b) in below.iter().zip(above) {
            assert!((a - b).abs() < 1e-6 * b, "{a} and {b}");
        }
    }
}
