//! The surfaces of an iteration, and the correction as a combination of them.

use crate::Error;
use crate::correction::CorrectionRule;
use crate::global::traced::TracedSurface;

/// What an iteration fitted, (30) to (36); all in coordinates coded to the original box.
#[non_exhaustive]
#[derive(Debug, Clone)]
pub struct IterationSurfaces {
    /// Ĵexp,i, of training and validation experiments; none if too many of them failed.
    pub experiment: Option<TracedSurface>,
    /// Ĵsim,i, of the simulations as they are.
    pub simulation: TracedSurface,
    /// Ĵ_i, of training experiments and the simulations with the correction of iteration i − 1.
    pub combined: TracedSurface,
    /// Ĵcor,i; with no Ĵexp,i that of iteration i − 1.
    pub correction: TracedSurface,
    /// Ĵnum,i = Ĵsim,i + Ĵcor,i of (35).
    pub numerical: TracedSurface,
}

/// Ĵcor,n from the surfaces of rounds 1 to n, by the law of the settings; 0 for n = 0. An iteration whose experiments
/// could not be fitted is no round.
pub(crate) fn correction<'a>(
    rule: CorrectionRule,
    n_factors: usize,
    experiments: &[&'a TracedSurface],
    simulations: &[&'a TracedSurface],
) -> Result<TracedSurface, Error> {
    let coefficients = rule.correction(experiments.len());
    let factors = coefficients.experiment.into_iter().chain(coefficients.simulation);
    TracedSurface::combination(n_factors, factors.zip(experiments.iter().chain(simulations).copied()))
}
