//! How far a corrected model can be from the truth.

use serde::{Deserialize, Serialize};

use crate::Error;
use crate::checks::{check_count, check_error_bounds, check_not_negative};
use crate::correction::{Law, ModelStage, Rule};

/// Bounds on the error of a corrected model, in any norm for which those of the surfaces are known.
///
/// Write e1,j = Ĵsim,j − J_sim and e2,j = Ĵexp,j − J_true for the errors of the surfaces (41), and
/// d_0 = ‖J_true − J_sim‖ for the gap. A correction is linear in the surfaces and the weights w_j of
/// [`Rule::correction`] are those of its experiments, so the error is, exactly,
///
/// ```text
/// J_model − J_true = −(1 − Σ_j w_j) (J_true − J_sim) + Σ_j w_j e2,j + Σ_j s_j e1,j
/// ```
///
/// with s_j the factors of the simulation surfaces in [`Rule::model`]: both kinds of factors
/// together sum to 1. The triangle inequality gives the bound
///
/// ```text
/// ‖J_model − J_true‖ ≤ |1 − Σ_j w_j| d_0 + Σ_j |w_j| E2,j + Σ_j |s_j| E1,j
/// ```
///
/// and errors that are all multiples of one function, with the signs of their factors, attain it:
/// without further assumptions it cannot be improved, in any norm and at any n. It needs no
/// monotonic errors; with E1,j → E1 and E2,j → E2 it tends to the limit of constant ones. For a gain k
/// with ρ = |1 − k|, constant errors and n ≥ 2 the sums are geometric series:
///
/// | law, stage | gain | limit | plus, after n batches |
/// |---|---|---|---|
/// | proof, both; current, onset | k ≤ 1 | 2 E1 + E2 | ρⁿ (d_0 − E1 − E2) |
/// | current, corrected | k ≤ 1 | 2 (1 − k) E1 + E2 | ρⁿ (d_0 − E1 − E2) |
/// | proof, both | k > 1 | (2 E1 + k E2)/(2 − k) | ρⁿ (d_0 − k E2/(2 − k)) − ρⁿ⁻¹ k (3 − k) E1/(2 − k) |
/// | current, onset | k > 1 | (2 E1 + k E2)/(2 − k) | ρⁿ (d_0 − k (E1 + E2)/(2 − k)) |
/// | current, corrected | k > 1 | (2 (k − 1) E1 + k E2)/(2 − k) | ρⁿ (d_0 − k (E1 + E2)/(2 − k)) |
/// | proof, both; current, onset | 1/n | 2 E1 + E2 | 0 |
/// | current, corrected | 1/n | 2 E1 + E2 | −2 E1/n |
/// | as printed (36) | any | none | it grows as 2ⁿ |
///
/// The exact error is (49) for any gain, and the first limit is the proposition of Section 6.1, (55), where (52)–(54) bound
/// the sum by early errors and need a second limit; everything else goes beyond the text and is derived as above.
/// With one batch both laws give ρ (d_0 + E1) + k E2, with none d_0 + E1. Up to k = 1 the current law is
/// never bounded worse than the proof's; above, it can be in the first batches.
///
/// The gap is not known but bounded by what is seen: d_0 ≤ ‖Ĵexp,1 − Ĵsim,1‖ + E1,1 + E2,1.
///
/// Over a region that shrinks, take all norms over the last one. Bounds over earlier ones serve too
/// if the norm does not grow when the region shrinks: the largest value and the integral do not, but a
/// mean may.
///
/// ```
/// use infuse::convergence::{Bound, ErrorLevels};
/// use infuse::correction::{Gain, Law, ModelStage, Rule};
///
/// let rule = Rule::new(Law::ProofRecursion, Gain::constant(0.5)?);
/// let bound = Bound::new(rule, ModelStage::Corrected);
/// let levels = ErrorLevels::new(1.0, 0.1, 0.2)?; // d_0, E1, E2
///
/// assert!((bound.after(2).error(&levels) - 0.575).abs() < 1e-12); // 0.4 + 0.7 / 2²
/// assert!(bound.limit().is_some_and(|limit| (limit.error(&levels) - 0.4).abs() < 1e-12)); // 2 E1 + E2
/// assert_eq!(bound.batches_to(&levels, 0.01)?, Some(7)); // 0.7 / 2⁷ = 0.005
/// # Ok::<(), infuse::Error>(())
/// ```
///
/// Source: (55).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bound {
    /// How the model is corrected.
    pub rule: Rule,
    /// Which model is meant.
    pub stage: ModelStage,
}

/// Bounds on the errors of the surfaces, the same in every batch, in the unit of the response.
///
/// Source: (41).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "UncheckedLevels")]
pub struct ErrorLevels {
    gap: f64,
    simulation: f64,
    experiment: f64,
}

/// Levels as they stand in a file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename = "ErrorLevels")]
struct UncheckedLevels {
    gap: f64,
    simulation: f64,
    experiment: f64,
}

impl TryFrom<UncheckedLevels> for ErrorLevels {
    type Error = Error;

    fn try_from(UncheckedLevels { gap, simulation, experiment }: UncheckedLevels) -> Result<Self, Error> {
        Self::new(gap, simulation, experiment)
    }
}

impl ErrorLevels {
    /// ‖J_true − J_sim‖ ≤ `gap`, ‖e1,j‖ ≤ `simulation` and ‖e2,j‖ ≤ `experiment` for all j.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] for a negative number, a NaN or an infinity.
    pub fn new(gap: f64, simulation: f64, experiment: f64) -> Result<Self, Error> {
        for (name, value) in [("gap", gap), ("simulation", simulation), ("experiment", experiment)] {
            check_not_negative(name, value)?;
        }
        Ok(Self { gap, simulation, experiment })
    }
}

/// How much of each error can reach the model, dimensionless.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Amplification {
    /// Of the gap d_0.
    pub gap: f64,
    /// Of the simulation surfaces' errors, E1.
    pub simulation: f64,
    /// Of the experiment surfaces' errors, E2.
    pub experiment: f64,
}

impl Amplification {
    /// The bound for these errors, in the unit of the response.
    #[must_use]
    pub fn error(&self, levels: &ErrorLevels) -> f64 {
        self.simulation * levels.simulation + self.experiment * levels.experiment + self.gap * levels.gap
    }

    fn plus(self, other: &Self, factor: f64) -> Self {
        Self {
            gap: self.gap + factor * other.gap,
            simulation: self.simulation + factor * other.simulation,
            experiment: self.experiment + factor * other.experiment,
        }
    }
}

/// From this number of batches on the closed forms hold for every law.
const SETTLED: usize = 2;

/// Beyond it a number of batches is no longer exact as a double.
const MOST_ROUNDS: usize = 1 << 52;

impl Bound {
    /// The bound on this model under this rule.
    #[must_use]
    pub fn new(rule: Rule, stage: ModelStage) -> Self {
        Self { rule, stage }
    }

    /// The bound after n batches of experiments, from bounds on the errors of each batch.
    ///
    /// `experiment` holds E2,1..n and so decides n; `simulation` holds E1,j for the n simulation
    /// surfaces of a corrected model, n + 1 for that at the onset of the next batch (one if n = 0).
    ///
    /// # Errors
    ///
    /// [`Error::WrongCount`]; [`Error::Setting`] and [`Error::Entry`] for a negative number, a NaN or an
    /// infinity.
    pub fn finite(&self, gap: f64, simulation: &[f64], experiment: &[f64]) -> Result<f64, Error> {
        check_not_negative("gap", gap)?;
        let model = self.rule.model(self.stage, experiment.len());
        check_count("simulation", model.simulation.len(), simulation.len(), "simulation surface of the model")?;
        check_error_bounds("simulation", simulation)?;
        check_error_bounds("experiment", experiment)?;
        let sum = |factors: &[f64], bounds: &[f64]| -> f64 {
            factors.iter().zip(bounds).map(|(factor, bound)| factor.abs() * bound).sum()
        };
        let of_gap = self.rule.weights(experiment.len()).of_gap.abs();
        Ok(of_gap * gap + sum(&model.simulation, simulation) + sum(&model.experiment, experiment))
    }

    /// The bound after n batches of experiments when those on the errors stay the same.
    #[must_use]
    pub fn after(&self, n: usize) -> Amplification {
        match (self.limit(), self.transient(n)) {
            (Some(limit), Some(transient)) => limit.plus(&transient, 1.0),
            _ => self.summed(n),
        }
    }

    /// Where the bound goes as n grows; nothing for (36) as printed, which leaves every bound.
    #[must_use]
    pub fn limit(&self) -> Option<Amplification> {
        let doubled = match self.rule.law {
            Law::AsPrinted36 => return None,
            Law::ProofRecursion => true,
            Law::CurrentSimulation => self.stage == ModelStage::Onset,
        };
        let Some(k) = self.rule.gain.as_constant() else {
            return Some(Amplification { gap: 0.0, simulation: 2.0, experiment: 1.0 });
        };
        // Σ_r |1 − k|^r k, the weights' sum: 1 unless they alternate.
        let weights = if k > 1.0 { k / (2.0 - k) } else { 1.0 };
        // The latest simulation error comes on top, or is part of what is compared.
        let simulation = match (doubled, k > 1.0) {
            (true, false) => 2.0,
            (true, true) => 2.0 / (2.0 - k),
            (false, false) => 2.0 * (1.0 - k),
            (false, true) => 2.0 * (k - 1.0) / (2.0 - k),
        };
        Some(Amplification { gap: 0.0, simulation, experiment: weights })
    }

    /// The least number of batches from which on the bound stays within `tolerance`, in the unit of the
    /// response, of its limit; nothing if it has none, or needs more batches than a double can count.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] for a tolerance that is not a positive number.
    pub fn batches_to(&self, levels: &ErrorLevels, tolerance: f64) -> Result<Option<usize>, Error> {
        if !(tolerance > 0.0 && tolerance.is_finite()) {
            let expected = "a finite positive number";
            return Err(Error::Setting { name: "tolerance", value: tolerance, expected });
        }
        let Some(limit) = self.limit() else {
            return Ok(None);
        };
        let is_within = |n: usize| {
            let excess = self.transient(n).unwrap_or_else(|| self.summed(n).plus(&limit, -1.0));
            excess.error(levels) <= tolerance
        };
        // From here on the excess is one number times a power, so it falls, or was never positive.
        let (mut outside, mut within) = (SETTLED, SETTLED);
        while !is_within(within) {
            if within >= MOST_ROUNDS {
                return Ok(None);
            }
            (outside, within) = (within, 2 * within);
        }
        while within - outside > 1 {
            let middle = outside + (within - outside) / 2;
            if is_within(middle) { within = middle } else { outside = middle }
        }
        while within > 0 && within <= SETTLED && is_within(within - 1) {
            within -= 1;
        }
        Ok(Some(within))
    }

    /// What the bound is above its limit; nothing where the closed forms do not hold.
    fn transient(&self, n: usize) -> Option<Amplification> {
        if n < SETTLED || self.rule.law == Law::AsPrinted36 {
            return None;
        }
        let is_current = self.rule.law == Law::CurrentSimulation;
        let Some(k) = self.rule.gain.as_constant() else {
            let is_corrected = is_current && self.stage == ModelStage::Corrected;
            let simulation = if is_corrected { -2.0 / n as f64 } else { 0.0 };
            return Some(Amplification { gap: 0.0, simulation, experiment: 0.0 });
        };
        let rho = (1.0 - k).abs();
        let gap = power(rho, n);
        if k <= 1.0 {
            return Some(Amplification { gap, simulation: -gap, experiment: -gap });
        }
        let experiment = -gap * k / (2.0 - k);
        // Two of the alternating weights meet in Ĵsim,1 and partly cancel.
        let simulation = if is_current { experiment } else { -power(rho, n - 1) * k * (3.0 - k) / (2.0 - k) };
        Some(Amplification { gap, simulation, experiment })
    }

    fn summed(&self, n: usize) -> Amplification {
        let model = self.rule.model(self.stage, n);
        let sum = |factors: &[f64]| factors.iter().map(|factor| factor.abs()).sum();
        Amplification {
            gap: self.rule.weights(n).of_gap.abs(),
            simulation: sum(&model.simulation),
            experiment: sum(&model.experiment),
        }
    }
}

/// By repeated squaring, so that the bits do not depend on the platform's exponential.
fn power(base: f64, exponent: usize) -> f64 {
    let (mut result, mut square, mut rest) = (1.0, base, exponent);
    while rest > 0 {
        if rest % 2 == 1 {
            result *= square;
        }
        square *= square;
        rest /= 2;
    }
    result
}
