//! The corrected model (35), and the correction that goes into it, as surfaces that know what they rest on.

use crate::Error;
use crate::correction::Rule;
use crate::traced::TracedSurface;

/// Ĵnum,i(p) = Ĵsim,i(p) + Ĵcor,i(p): the model that a batch hands on.
///
/// Source: (35).
pub(crate) fn corrected_model(simulation: &TracedSurface, correction: &TracedSurface) -> Result<TracedSurface, Error> {
    TracedSurface::combination(simulation.surface().n_factors(), [(1.0, simulation), (1.0, correction)])
}

/// Ĵcor,n from Ĵexp and Ĵsim of the batches 1 to n, in their order, by a [`Rule`]; 0 for n = 0.
pub(crate) fn correction<'a>(
    rule: Rule,
    n_factors: usize,
    batches: impl IntoIterator<Item = (&'a TracedSurface, &'a TracedSurface)>,
) -> Result<TracedSurface, Error> {
    let (experiments, simulations): (Vec<_>, Vec<_>) = batches.into_iter().unzip();
    let coefficients = rule.correction(experiments.len());
    let factors = coefficients.experiment.into_iter().chain(coefficients.simulation);
    TracedSurface::combination(n_factors, factors.zip(experiments.into_iter().chain(simulations)))
}
