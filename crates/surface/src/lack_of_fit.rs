//! Whether a regression misses more than the scatter of repeats explains.

use serde::Serialize;
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use crate::{Error, Regression};

/// Estimates within this of the values, relative, agree with them.
const ROUNDING: f64 = 1e-13;

/// The residual sum of squares, split by repeats into pure error and lack of fit, and the F test of the two.
///
/// With n points of positive weight at m places and p terms:
///
/// ```text
/// pure error     Σ w (J − J̄_place)²           n − m degrees of freedom
/// lack of fit    Σ w (J̄_place − Ĵ)²           m − p
/// F = (lack of fit/(m − p)) / (pure error/(n − m))
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[non_exhaustive]
pub struct LackOfFit {
    /// Weighted sum of squares of the values about the weighted mean of their place.
    pub pure_error: f64,
    /// n − m.
    pub pure_error_degrees: usize,
    /// Weighted sum of squares of those means about the estimates.
    pub lack_of_fit: f64,
    /// m − p.
    pub lack_of_fit_degrees: usize,
    /// Ratio of the mean squares: infinite if repeats agree exactly and the model misses them, 0 if it does not.
    pub f: f64,
    /// Probability of at least this F if the model is right and the errors are normal.
    pub p_value: f64,
}

impl Regression {
    /// The test for lack of fit against pure error. Points with exactly the same coordinates are repeats.
    ///
    /// Pure error is meant to be scatter of repeated observations: an experiment and a simulation of the same point
    /// differ by more than that, and pooling them hides lack of fit.
    ///
    /// # Errors
    ///
    /// [`Error::NoLackOfFitTest`] if no point was observed twice, or if there are no more places than terms.
    pub fn lack_of_fit(&self) -> Result<LackOfFit, Error> {
        let sites = self.data().sites();
        let (n_points, n_sites, n_terms) = (self.data().n_used(), sites.len(), self.model().n_terms());
        let (pure_error_degrees, lack_of_fit_degrees) = (n_points - n_sites, n_sites.saturating_sub(n_terms));
        let nothing = Error::NoLackOfFitTest { n_points, n_sites, n_terms };
        if pure_error_degrees == 0 || lack_of_fit_degrees == 0 {
            return Err(nothing);
        }
        let (residuals, weights) = (self.residuals(), self.data().weights());
        let (mut pure_error, mut lack_of_fit) = (0.0, 0.0);
        for site in &sites {
            // The estimate is the same at all points of a place, so residuals differ as values do.
            let total: f64 = site.iter().map(|&point| weights[point]).sum();
            let mean: f64 = site.iter().map(|&point| weights[point] / total * residuals[point]).sum();
            lack_of_fit += total * mean * mean;
            pure_error += site.iter().map(|&point| weights[point] * (residuals[point] - mean).powi(2)).sum::<f64>();
        }
        // What is rounding of the values is no lack of fit.
        let scale = self.data().values().iter().zip(weights).map(|(value, w)| w * value * value).sum::<f64>();
        if lack_of_fit <= ROUNDING * ROUNDING * scale {
            lack_of_fit = 0.0;
        }
        let mean_square = |sum: f64, degrees: usize| sum / degrees as f64;
        let f = if lack_of_fit > 0.0 {
            mean_square(lack_of_fit, lack_of_fit_degrees) / mean_square(pure_error, pure_error_degrees)
        } else {
            0.0
        };
        let distribution = FisherSnedecor::new(lack_of_fit_degrees as f64, pure_error_degrees as f64);
        let p_value = distribution.map_err(|_| nothing)?.sf(f);
        Ok(LackOfFit { pure_error, pure_error_degrees, lack_of_fit, lack_of_fit_degrees, f, p_value })
    }
}
