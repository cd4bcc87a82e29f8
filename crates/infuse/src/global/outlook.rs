//! What more experiments could still bring.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde::{Deserialize, Serialize};
use surface::{Polynomial, Regression, Surface};

use crate::Error;
use crate::global::campaign::Loop;
use crate::global::candidates::Candidates;
use crate::global::report::Report;
use crate::global::spread::Spread;
use crate::global::surfaces::BatchSurfaces;
use crate::pure_error::PureError;

/// Cells among which the best is looked for in every draw; of more that are left, a part.
const MOST_CELLS: u64 = 20_000;

/// How much better than p̂* the best of what is left may be, in the unit of the response.
///
/// Ĵnum of the last batch knows all experiments. Only they bring noise into it, through the correction
/// Σ c_j Ĵexp,j + …, so surfaces that may as well be true are
///
/// ```text
/// Ĵnum(p) + Σ_j c_j δ_j(p)        δ_j(p) = r(p)' σ_j (R_j'R_j)^−½ z_j
/// ```
///
/// with the sampling error δ_j of Ĵexp of batch j, and independent standard normal z. The gain of such a draw is what its best cell
/// undercuts p̂* by, so the mean is what it would be worth on average to know the surface exactly: no number of
/// further experiments can bring more on average, if the regressor is right and the errors about it are independent.
/// What it may be worth that the regressor is not right stands beside it.
/// Source: beyond the text; the expected value of perfect information.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct Outlook {
    /// Mean of the gains.
    pub mean_gain: f64,
    /// The part of it that no noise makes: what the best cell of Ĵnum itself undercuts p̂* by, which is the best of Ĵ.
    pub moved_gain: f64,
    /// Nine of ten gains are at most this.
    pub upper_gain: f64,
    /// What the wrong shape of the surface may hide besides. With the pure error s², and s² h the variance that it gives Ĵ in
    /// the mean over the n validation experiments, (40) would be s² (1 + h) n/(n − 1) on average if the shape were right. What
    /// S² is more, taken as the variance of independent misfits, makes the better of two designs that are level in the
    /// model better by √((S² − s² (1 + h) n/(n − 1))/π) on average. All of S counts as misfit while the noise is not known. None without
    /// an S, and in a [careful](crate::global::Settings::careful) campaign without a degree of freedom that shows misfit; 0
    /// with a single cell left.
    pub misfit_gain: Option<f64>,
    /// How many surfaces were drawn.
    pub n_draws: usize,
    /// Among how many of the cells left the best was looked for.
    pub n_cells: usize,
}

/// The gain of every draw, and among how many cells it was looked for.
#[derive(Debug)]
struct Gains {
    values: Vec<f64>,
    /// That of Ĵnum itself.
    moved: f64,
    n_cells: usize,
}

impl Outlook {
    /// Both gains; none without an S.
    #[must_use]
    pub fn total_gain(&self) -> Option<f64> {
        self.misfit_gain.map(|misfit| self.mean_gain + misfit)
    }

    /// What of the mean gain the noise makes.
    #[must_use]
    pub fn noise_gain(&self) -> f64 {
        self.mean_gain - self.moved_gain
    }

    /// What the noise makes nine times in ten is at most this.
    #[must_use]
    pub fn upper_noise_gain(&self) -> f64 {
        (self.upper_gain - self.moved_gain).max(0.0)
    }
}

impl Loop {
    /// What more experiments could still bring, from this many draws. `noise` is that of the experiments,
    /// [`pure_error`](Self::pure_error) or better knowledge. None before the first batch is closed, and if
    /// some Ĵexp in the correction is no regression or has no degrees of freedom. The same settings and outcomes give
    /// the same draws.
    ///
    /// # Errors
    ///
    /// [`Error::SettingCount`] for no draws.
    pub fn outlook(&self, n_draws: usize, noise: Option<PureError>) -> Result<Option<Outlook>, Error> {
        if n_draws == 0 {
            return Err(Error::SettingCount { name: "n_draws", value: n_draws, expected: "at least 1" });
        }
        let Some((report, surfaces)) = self.history.last().zip(self.surfaces.last()) else {
            return Ok(None);
        };
        let experiments: Vec<_> = self.surfaces.iter().filter_map(|past| past.experiment.as_ref()).collect();
        let regressions: Option<Vec<&Regression>> = experiments.iter().map(|surface| surface.regression()).collect();
        let Some(regressions) = regressions.filter(|regressions| !regressions.is_empty()) else {
            return Ok(None);
        };
        let Some(mut gains) = self.drawn_gains(n_draws, &regressions, report, surfaces)? else {
            return Ok(None);
        };
        gains.values.sort_by(f64::total_cmp);
        let mean_gain = gains.values.iter().sum::<f64>() / n_draws as f64;
        let upper_gain = gains.values[(9 * n_draws).div_ceil(10) - 1];
        let misfit_gain = self.misfit_gain(noise, report, surfaces);
        // On average noise can only add to it; so many draws are off by some of it.
        let (moved_gain, n_cells) = (gains.moved.min(mean_gain), gains.n_cells);
        Ok(Some(Outlook { mean_gain, moved_gain, upper_gain, misfit_gain, n_draws, n_cells }))
    }

    /// By how much the best cell undercuts p̂* in each of so many drawn surfaces.
    fn drawn_gains(
        &self,
        n_draws: usize,
        regressions: &[&Regression],
        report: &Report,
        surfaces: &BatchSurfaces,
    ) -> Result<Option<Gains>, Error> {
        let factors = self.settings.correction.correction(regressions.len()).experiment;
        let candidates = Candidates::of(&self.retained, &self.cells, MOST_CELLS, self.settings.seed)?;
        let points = candidates.cells.iter().map(|&cell| self.cells.coded(cell));
        let points = points.collect::<Result<Vec<_>, _>>()?;
        let model = surfaces.numerical.surface();
        let means: Vec<f64> = points.iter().map(|point| model.predict(point)).collect();
        let optimum = self.cells.coded(report.screening.optimum_cell)?;
        let mean_at_optimum = model.predict(&optimum);
        // A stream for each batch: no two campaigns share their draws because seed and batch come to the same.
        let mut generator = ChaCha8Rng::seed_from_u64(self.settings.seed);
        generator.set_stream(report.number as u64);
        let mut values = Vec::with_capacity(n_draws);
        for _ in 0..n_draws {
            let Some(error) = drawn_error(regressions, &factors, self.cells.n_factors(), &mut generator)? else {
                return Ok(None);
            };
            let at_optimum = mean_at_optimum + error.predict(&optimum);
            let drawn = points.iter().zip(&means).map(|(point, mean)| mean + error.predict(point));
            values.push(drawn.map(|drawn| at_optimum - drawn).fold(0.0, f64::max));
        }
        let moved = means.iter().map(|mean| mean_at_optimum - mean).fold(0.0, f64::max);
        Ok(Some(Gains { values, moved, n_cells: points.len() }))
    }

    /// What the wrong shape of the surface may hide besides the noise.
    fn misfit_gain(&self, noise: Option<PureError>, report: &Report, surfaces: &BatchSurfaces) -> Option<f64> {
        match (self.retained.n_retained(), report.screening.spread) {
            (0 | 1, _) => Some(0.0),
            _ if !self.shows_misfit(surfaces) => None,
            (_, Spread::Estimated { s, n_validation }) => {
                let explained = noise.map_or(0.0, |noise| noise.variance * (1.0 + self.fit_variance(report, surfaces)));
                let n = n_validation as f64;
                Some(((s * s - explained * n / (n - 1.0)).max(0.0) / std::f64::consts::PI).sqrt())
            }
            _ => None,
        }
    }

    /// The mean variance of the combined surface at the validation experiments, if its training experiments and
    /// simulations scatter like one experiment of variance 1. Not by its own residuals: misfit is in them, too.
    fn fit_variance(&self, report: &Report, surfaces: &BatchSurfaces) -> f64 {
        let Some(fit) = surfaces.combined.regression() else { return 0.0 };
        let Some(sigma_squared) = fit.sigma_squared().filter(|&sigma_squared| sigma_squared > 0.0) else { return 0.0 };
        let before = &self.history[..report.number - 1];
        let unseen = self.unseen(before, &report.trials).unwrap_or_default();
        let validation = report.trials.iter().filter(|record| unseen.contains(&record.trial.id));
        let points = validation.filter_map(|record| self.region().coded(record.settings()).ok());
        let variances: Vec<f64> = points.filter_map(|point| fit.variance(&point)).collect();
        if variances.is_empty() {
            return 0.0;
        }
        let mean = variances.iter().sum::<f64>() / variances.len() as f64;
        self.settings.experiment_weight * mean / sigma_squared
    }
}

/// Σ c_j δ_j, drawn; none if a regression has no degrees of freedom.
fn drawn_error(
    regressions: &[&Regression],
    factors: &[f64],
    n_factors: usize,
    generator: &mut ChaCha8Rng,
) -> Result<Option<Polynomial>, Error> {
    let mut error = Polynomial::zero(n_factors)?;
    for (regression, &factor) in regressions.iter().zip(factors) {
        let normals: Vec<f64> = regression.coefficients().iter().map(|_| StandardNormal.sample(generator)).collect();
        let Some(drawn) = regression.drawn(&normals)? else {
            return Ok(None);
        };
        error = error.plus(factor, &drawn)?.plus(-factor, regression.polynomial())?;
    }
    Ok(Some(error))
}
