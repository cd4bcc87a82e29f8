//! How the surfaces moved from one batch to the next.

use serde::{Deserialize, Serialize};

use crate::Error;
use crate::global::cells::Cells;
use crate::global::retained::RetainedSet;
use crate::global::surfaces::BatchSurfaces;
use crate::traced::TracedSurface;

/// Largest magnitudes over M_i, in the unit of the response: what can be said of Figure 21 without knowing the truth.
///
/// With the errors e1 of Ĵsim and e2 of Ĵexp as in (41), the change of Ĵsim is at most E1_i + E1_i−1, that of Ĵexp at
/// most E2_i + E2_i−1, and the gap at most d_0 + E1_i + E2_i; so each bounds its errors from below.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SurfaceChanges {
    /// ‖Ĵexp,i − Ĵsim,i‖; none without Ĵexp.
    pub gap: Option<f64>,
    /// ‖Ĵexp,i − Ĵnum,i−1‖, what was new in the experiments, with Ĵnum,0 = Ĵsim,1; none without Ĵexp.
    pub innovation: Option<f64>,
    /// ‖Ĵnum,i − Ĵnum,i−1‖, with Ĵnum,0 = Ĵsim,1.
    pub model: f64,
    /// ‖Ĵsim,i − Ĵsim,i−1‖; none in batch 1.
    pub simulation: Option<f64>,
    /// ‖Ĵexp,i − Ĵexp,i−1‖; none in batch 1 and without Ĵexp.
    pub experiment: Option<f64>,
}

impl SurfaceChanges {
    pub(crate) fn between(
        before: Option<&BatchSurfaces>,
        now: &BatchSurfaces,
        retained: &RetainedSet,
        cells: &Cells,
    ) -> Result<Self, Error> {
        let distance = |a: &TracedSurface, b: &TracedSurface| {
            let difference = TracedSurface::combination(cells.n_factors(), [(1.0, a), (-1.0, b)])?;
            Ok::<_, Error>(retained.largest_magnitude(cells.points(), difference.surface()))
        };
        let numerical_before = before.map_or(&now.simulation, |before| &before.numerical);
        let experiment = now.experiment.as_ref();
        let experiment_before = before.and_then(|before| before.experiment.as_ref());
        Ok(Self {
            gap: experiment.map(|experiment| distance(experiment, &now.simulation)).transpose()?,
            innovation: experiment.map(|experiment| distance(experiment, numerical_before)).transpose()?,
            model: distance(&now.numerical, numerical_before)?,
            simulation: before.map(|before| distance(&now.simulation, &before.simulation)).transpose()?,
            experiment: experiment.zip(experiment_before).map(|(now, before)| distance(now, before)).transpose()?,
        })
    }
}
