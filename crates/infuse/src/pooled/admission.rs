//! Whether designs keep to their bounds, as it may turn out after a batch.

use std::sync::LazyLock;

use statrs::distribution::{ContinuousCDF, Normal};
use surface::process::Joint;

use crate::pooled::constraint::Constraint;
use crate::pooled::outcomes::{OUTCOMES, outcomes};

/// One constrained response over a pool: what is known of it, and how that may turn out after the picks so far.
pub(crate) struct Admission {
    lower: f64,
    upper: f64,
    joint: Joint,
    /// Variance of one reading.
    noise: f64,
    /// Its means, as each outcome would have them.
    futures: Vec<Vec<f64>>,
    scramble: u32,
}

/// How one more run moves it.
pub(crate) struct Step {
    effect: Vec<f64>,
    /// 1 over the standard deviation that each row then has.
    precision: Vec<f64>,
    normals: Vec<f64>,
}

impl Admission {
    /// Of the constraint with this number.
    pub(crate) fn of(constraint: &Constraint, joint: Joint, noise: f64, number: u32, scramble: u32) -> Self {
        let futures = vec![joint.means().to_vec(); OUTCOMES as usize];
        let scramble = scramble.wrapping_add(0x9E37_79B9_u32.wrapping_mul(number + 1));
        let lower = constraint.lower.unwrap_or(f64::NEG_INFINITY);
        let upper = constraint.upper.unwrap_or(f64::INFINITY);
        Self { lower, upper, joint, noise: noise * noise, futures, scramble }
    }

    /// No run at all.
    pub(crate) fn stay(&self) -> Step {
        let n = self.joint.n_places();
        Step { effect: vec![0.0; n], precision: self.precisions(&vec![0.0; n]), normals: vec![0.0; OUTCOMES as usize] }
    }

    /// A run at this row, the so-many-th of the batch.
    pub(crate) fn step(&self, row: usize, number: u32) -> Step {
        let effect = self.joint.effect(row, self.noise);
        Step { precision: self.precisions(&effect), effect, normals: outcomes(number, self.scramble) }
    }

    fn precisions(&self, effect: &[f64]) -> Vec<f64> {
        let left = |(row, effect): (usize, &f64)| (self.joint.variance(row) - effect * effect).max(0.0).sqrt();
        effect.iter().enumerate().map(left).map(|deviation| 1.0 / deviation.max(f64::MIN_POSITIVE)).collect()
    }

    /// Probability of a row to keep to the bounds, in one outcome.
    pub(crate) fn chance(&self, row: usize, step: &Step, outcome: usize) -> f64 {
        let mean = self.futures[outcome][row] + step.normals[outcome] * step.effect[row];
        let up_to = |bound: f64| below((bound - mean) * step.precision[row]);
        let lower = if self.lower > f64::NEG_INFINITY { up_to(self.lower) } else { 0.0 };
        let upper = if self.upper < f64::INFINITY { up_to(self.upper) } else { 1.0 };
        upper - lower
    }

    /// The run is part of the batch.
    pub(crate) fn measure(&mut self, step: &Step) {
        for (future, z) in self.futures.iter_mut().zip(&step.normals) {
            future.iter_mut().zip(&step.effect).for_each(|(mean, effect)| *mean += z * effect);
        }
        self.joint.measure(&step.effect);
    }
}

const MOST: f64 = 5.0;
const PER_UNIT: usize = 64;

/// The standard normal distribution at so many steps from −5 to 5.
static BELOW: LazyLock<Vec<f64>> = LazyLock::new(|| {
    let normal = Normal::standard();
    (0..=2 * MOST as usize * PER_UNIT + 1).map(|step| normal.cdf(step as f64 / PER_UNIT as f64 - MOST)).collect()
});

/// Probability of a standard normal number below this, to 1e-4: the table is read millions of times.
fn below(x: f64) -> f64 {
    let at = (x.clamp(-MOST, MOST) + MOST) * PER_UNIT as f64;
    let step = at as usize;
    let share = at - step as f64;
    BELOW[step] * (1.0 - share) + BELOW[step + 1] * share
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn table_is_the_normal_distribution() {
        let normal = Normal::standard();
        for step in -800..=800 {
            let x = f64::from(step) / 97.0;
            assert!((below(x) - normal.cdf(x)).abs() < 1e-4, "{x}");
        }
        assert!(below(f64::INFINITY) > 0.999_999 && below(f64::NEG_INFINITY) < 1e-6);
    }

    /// What is known of a response after four readings, at three places.
    fn joint() -> Joint {
        let data = surface::Data::new(1, vec![-1.0, -0.2, 0.4, 1.0], vec![1.0, 1.4, 0.7, 2.0]).expect("valid data");
        let sites = surface::process::Sites::new(&data, None).expect("valid data");
        let settings = surface::process::SamplerSettings { particles: 4, ..Default::default() };
        let process = surface::process::AveragedProcess::new(sites, &settings).expect("a process");
        process
            .joint(&surface::process::Places::new(1, &[-0.6, 0.1, 0.8]).expect("places"))
            .expect("places of the process")
    }

    #[test]
    fn what_has_no_bounds_is_kept_to_for_certain() {
        let mut limits = Constraint::at_most("travel", 1.5);
        limits.upper = None;
        let admission = Admission::of(&limits, joint(), 0.1, 0, 7);
        for row in 0..3 {
            assert_eq!(admission.chance(row, &admission.stay(), 0).to_bits(), 1.0_f64.to_bits(), "row {row}");
        }
    }

    /// Φ((u − m)/s) − Φ((l − m)/s), now and after a run that comes out z standard deviations above what is expected.
    #[test]
    fn chance_is_that_of_a_normal_quantity_between_its_bounds() {
        let normal = Normal::standard();
        let mut limits = Constraint::at_most("travel", 1.5);
        for lower in [None, Some(0.9)] {
            limits.lower = lower;
            let (known, noise) = (joint(), 0.1);
            let admission = Admission::of(&limits, joint(), noise, 0, 7);
            let between = |mean: f64, variance: f64| {
                let up_to = |bound: f64| normal.cdf((bound - mean) / variance.sqrt());
                up_to(1.5) - lower.map_or(0.0, up_to)
            };
            let (stay, step) = (admission.stay(), admission.step(1, 0));
            let effect = known.effect(1, noise * noise);
            for (row, &effect) in effect.iter().enumerate() {
                let (mean, variance) = (known.means()[row], known.variance(row));
                assert!((admission.chance(row, &stay, 0) - between(mean, variance)).abs() < 3e-4, "row {row}");
                for (outcome, z) in outcomes(0, admission.scramble).into_iter().enumerate() {
                    let expected = between(mean + z * effect, variance - effect * effect);
                    assert!((admission.chance(row, &step, outcome) - expected).abs() < 3e-4, "row {row}, z {z}");
                }
            }
        }
    }
}
