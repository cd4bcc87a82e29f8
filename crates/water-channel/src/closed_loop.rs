//! Modes of the sampled closed loop at trim: how a small disturbance dies out, or grows, from sample to sample.

use bat_dynamics::{Flow, Linearization, Mode, STATE_NAMES, STATE_UNITS, Trim, Variable, linearize, modes};
use nalgebra::{Complex, DMatrix, Matrix3, SMatrix, Vector3};
use tether_control::{Controller, Mixing};

use crate::error::Error;
use crate::flight::{FlightRequest, trim_at};

/// States of the plant.
const PLANT: usize = 12;
/// Lines, loops and their filters.
const LOOPS: usize = 3;
/// States of the loop.
const STATES: usize = PLANT + LOOPS;

/// The closed loop about its trim: `x_{k+1} = F x_k` from one sample to the next, for small departures.
#[derive(Clone, Debug)]
pub struct ClosedLoop {
    /// The equilibrium about which it holds.
    pub trim: Trim,
    /// F, with rows and columns in the order of [`ClosedLoop::STATES`].
    pub map: SMatrix<f64, STATES, STATES>,
    /// T, the time from one sample to the next, in s.
    pub sample_time_s: f64,
    /// The modes of F, slowest decay first; a conjugate pair counts once.
    pub modes: Vec<SampledMode>,
}

/// One mode of a sampled loop.
#[derive(Clone, Debug, PartialEq)]
pub struct SampledMode {
    /// mu, by which the mode is multiplied from sample to sample; of a conjugate pair the one above the real axis.
    pub multiplier: Complex<f64>,
    /// The same in continuous time: `ln(mu) / T` in 1/s, and the share of each state.
    ///
    /// A negative real mu changes sign at every sample: its rate has the imaginary part pi/T, half the sample rate,
    /// and no conjugate. A mu of zero is gone after one sample: its rate is that of the smallest positive number,
    /// −708/T, instead of minus infinity.
    pub mode: Mode,
}

impl ClosedLoop {
    /// The states of the loop: the twelve of the plant, then the filters of the altitude, pitch and roll loops.
    pub const STATES: [Variable; STATES] = {
        let mut states = [Variable { name: "", unit: "" }; STATES];
        let mut k = 0;
        while k < PLANT {
            states[k] = Variable { name: STATE_NAMES[k], unit: STATE_UNITS[k] };
            k += 1;
        }
        states[PLANT] = Variable { name: "filter_altitude", unit: "m" };
        states[PLANT + 1] = Variable { name: "filter_pitch", unit: "rad" };
        states[PLANT + 2] = Variable { name: "filter_roll", unit: "rad" };
        states
    };

    /// Whether every small disturbance decays.
    #[must_use]
    pub fn is_stable(&self) -> bool {
        self.modes.iter().all(|mode| mode.multiplier.norm() < 1.0)
    }

    /// The oscillation that dies out in the most of its own periods, if any mode oscillates.
    #[must_use]
    pub fn least_damped_oscillation(&self) -> Option<&SampledMode> {
        let oscillating = self.modes.iter().filter(|mode| mode.mode.eigenvalue.im > 0.0);
        oscillating.min_by(|a, b| a.mode.damping_ratio().total_cmp(&b.mode.damping_ratio()))
    }
}

impl SampledMode {
    /// The share of each state in the mode by the state's name, largest first; they sum to 1.
    ///
    /// `None` where the eigenvectors do not span the space.
    #[must_use]
    pub fn shares(&self) -> Option<Vec<(&'static str, f64)>> {
        let participation = self.mode.participation.as_ref()?;
        let names = ClosedLoop::STATES.iter().map(|state| state.name);
        let mut shares: Vec<_> = names.zip(participation.iter().copied()).collect();
        shares.sort_by(|a, b| b.1.total_cmp(&a.1));
        Some(shares)
    }

    /// The sum of the shares of the named states; a name that is not in [`ClosedLoop::STATES`] adds nothing.
    #[must_use]
    pub fn share_of(&self, names: &[&str]) -> Option<f64> {
        let shares = self.shares()?;
        Some(shares.iter().filter(|(name, _)| names.contains(name)).map(|(_, share)| share).sum())
    }
}

/// The modes of `request` in a steady `flow`: plant, winches and sampled controller together.
///
/// Exact for small departures, sampling included: the plant's linearization goes through the matrix exponential with
/// its commands held, the controller is (10)–(14) as it runs. The speed limit of the winches and the windows of a
/// test do not act on small departures. Noise and delay of cameras are left out: the controller sees the state.
/// About the trim, which takes no set point of roll: where roll at trim is not its set point, the
/// loop rests elsewhere.
///
/// # Errors
/// [`Error`] for a rig that is out of range, when there is no trim, or when the eigenvalues do not converge.
pub fn closed_loop_modes(request: &FlightRequest, flow: &Flow) -> Result<ClosedLoop, Error> {
    let plant = request.rig.plant(request.fidelity)?;
    let controller = request.rig.controller()?;
    let trim = trim_at(&plant, &request.rig.set_points, *flow)?;
    let linear = linearize(&plant, &trim.state, [0.0; 3], flow)?;
    let map = map_over_one_sample(&linear, &controller);
    let sample_time_s = controller.parameters().sample_time_s;
    let of_the_map = modes(&DMatrix::from_column_slice(STATES, STATES, map.as_slice()))?;
    let mut modes: Vec<SampledMode> = of_the_map
        .modes
        .into_iter()
        .map(|Mode { eigenvalue, participation }| SampledMode {
            multiplier: eigenvalue,
            mode: Mode { eigenvalue: rate_of(eigenvalue, sample_time_s), participation },
        })
        .collect();
    modes.sort_by(|a, b| b.mode.eigenvalue.re.total_cmp(&a.mode.eigenvalue.re));
    Ok(ClosedLoop { trim, map, sample_time_s, modes })
}

/// `ln(mu) / T` with the answers given at [`SampledMode::mode`].
fn rate_of(multiplier: Complex<f64>, sample_time_s: f64) -> Complex<f64> {
    let size = multiplier.norm().max(f64::MIN_POSITIVE);
    // +0 so that a negative zero cannot turn pi into −pi.
    Complex::new(size.ln(), (multiplier.im + 0.0).atan2(multiplier.re)) / sample_time_s
}

/// F of [`ClosedLoop`]: the state at a sample, before the filters move on, to the state at the next sample.
fn map_over_one_sample(linear: &Linearization, controller: &Controller) -> SMatrix<f64, STATES, STATES> {
    let parameters = controller.parameters();
    let sample_time_s = parameters.sample_time_s;

    // Zero-order hold: exp([[A, B], [0, 0]] T) = [[A_d, B_d], [0, 1]].
    let mut generator = SMatrix::<f64, STATES, STATES>::zeros();
    generator.fixed_view_mut::<PLANT, PLANT>(0, 0).copy_from(&linear.a);
    generator.fixed_view_mut::<PLANT, LOOPS>(0, PLANT).copy_from(&linear.b.fixed_view::<PLANT, LOOPS>(0, 0));
    let held = (generator * sample_time_s).exp();
    let a_d = held.fixed_view::<PLANT, PLANT>(0, 0);
    let b_d = held.fixed_view::<PLANT, LOOPS>(0, PLANT);

    // Outputs 0 to 2 are altitude, pitch and roll; z_e = h_sp − h has the other sign.
    let errors = Matrix3::from_diagonal(&Vector3::new(-1.0, 1.0, 1.0)) * linear.c.fixed_view::<LOOPS, PLANT>(0, 0);
    let loops = [parameters.altitude, parameters.pitch, parameters.roll];
    let diagonal = |f: fn(f64, f64, f64, f64) -> f64| {
        let entries = loops.map(|pd| f(pd.proportional(), pd.derivative(), pd.time_constant_s(), sample_time_s));
        Matrix3::from_diagonal(&Vector3::from(entries))
    };
    let through = diagonal(|_, k_d, tau, _| k_d / tau); // (10)–(12), the part that acts at once
    let from_filter = diagonal(|k_p, k_d, tau, _| k_p - k_d / tau);
    let kept = diagonal(|_, _, tau, period| (-period / tau).exp());
    let renewed = diagonal(|_, _, tau, period| -(-period / tau).exp_m1());
    let mixing = Matrix3::from(Mixing::new(parameters.layout).matrix()).transpose(); // (13), (14)

    let mut map = SMatrix::<f64, STATES, STATES>::zeros();
    map.fixed_view_mut::<PLANT, PLANT>(0, 0).copy_from(&(a_d + b_d * mixing * through * errors));
    map.fixed_view_mut::<PLANT, LOOPS>(0, PLANT).copy_from(&(b_d * mixing * from_filter));
    map.fixed_view_mut::<LOOPS, PLANT>(PLANT, 0).copy_from(&(renewed * errors));
    map.fixed_view_mut::<LOOPS, LOOPS>(PLANT, PLANT).copy_from(&kept);
    map
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(multiplier: (f64, f64), expected: (f64, f64)) {
        let rate = rate_of(Complex::new(multiplier.0, multiplier.1), 0.5);
        let expected = Complex::new(expected.0, expected.1);
        assert!((rate - expected).norm() <= 1e-15 * expected.norm().max(1.0), "{multiplier:?}: {rate}");
    }

    #[test]
    fn rate_of_a_multiplier_is_its_logarithm_over_the_sample_time() {
        check((1.0, 0.0), (0.0, 0.0));
        check(((-1.5_f64).exp(), 0.0), (-3.0, 0.0));
        check(((-1.0_f64).exp() * 0.3_f64.cos(), (-1.0_f64).exp() * 0.3_f64.sin()), (-2.0, 0.6));
    }

    #[test]
    fn rate_of_a_negative_multiplier_is_at_half_the_sample_rate() {
        let half = 2.0 * core::f64::consts::PI;
        check((-1.0, 0.0), (0.0, half));
        check((-(-1.0_f64).exp(), -0.0), (-2.0, half));
    }

    #[test]
    fn rate_of_a_multiplier_of_zero_is_finite() {
        check((0.0, 0.0), (2.0 * f64::MIN_POSITIVE.ln(), 0.0));
        let mode = Mode { eigenvalue: rate_of(Complex::new(0.0, 0.0), 0.5), participation: None };
        assert!((mode.damping_ratio() - 1.0).abs() < 1e-15, "{mode:?}");
        assert!(!mode.is_unstable(), "{mode:?}");
    }
}
