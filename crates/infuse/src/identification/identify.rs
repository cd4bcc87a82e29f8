//! From unknowns and measurements to estimates: search, look what is undetermined, hold that, search again.

use nalgebra::DMatrix;

use super::found::{Estimate, FitStop, Identification, RangeEnd};
use super::jacobian::{Sides, jacobian};
use super::measurements::Measurements;
use super::precision::Directions;
use super::residuals::{Answer, Residuals, sum_of_squares};
use super::search::{Held, search};
use super::settings::{Noise, Settings};
use super::undetermined::directions;
use super::unknowns::Unknowns;
use crate::Error;

/// A direction is held this much harder than what was measured holds the best determined one.
const STIFFNESS: f64 = 1e4;
/// Within this share of the range of a bound, and pushed outwards, an unknown is tried at the bound.
const NEAR_BOUND: f64 = 1e-2;

/// Finds the unknowns by bounded least squares on what was measured.
///
/// `model` answers for every vector of unknowns at every design, `answers[unknowns][design]`, so that it may fly them side by
/// side; where it fails a step is shortened. The same input gives the same bits, in whatever order was measured.
///
/// # Errors
///
/// Those of [`Settings::validate`]; [`Error::NoMeasurement`]; [`Error::TooFewReadings`] where the noise is to be estimated from no
/// more readings than there are unknowns (with known noise fewer are taken, and what they leave open is told);
/// [`Error::FailsAtStart`] where the model has no answer at the start; [`Error::WrongCount`] for an answer of another shape.
///
/// Source: Section 3.5.
pub fn identify(
    unknowns: &Unknowns,
    measurements: &Measurements,
    settings: &Settings,
    model: &mut impl FnMut(&[Vec<f64>], &[Vec<f64>]) -> Vec<Vec<Answer>>,
) -> Result<Identification, Error> {
    settings.validate()?;
    check_enough(unknowns, measurements, settings)?;
    let residuals = Residuals::new(unknowns, measurements, settings.noise, model);
    let start = unknowns.start_shares();
    let at_start = evaluated(&residuals, &start)?.map_err(|reason| Error::FailsAtStart { reason })?;
    let mut held = Held::nothing(unknowns.len());
    let (mut from, mut at_from) = (start.clone(), at_start.clone());
    let mut n_steps = 0;
    let (mut shares, mut stop);
    // Each turn holds one direction more, or is the last.
    let (here, slopes, all) = loop {
        let reached = search(&residuals, settings, &held, &from, at_from)?;
        n_steps += reached.n_steps;
        (shares, stop) = (reached.shares, reached.stop);
        let here = at_bounds(&residuals, &mut shares, settings, &held)?;
        let slopes = jacobian(&residuals, &shares, &here, settings.difference_step, Sides::Both)?;
        let all = Directions::of(&slopes);
        let sigma = sigma(settings.noise, &here, all.rank());
        let open = all.undetermined(sigma, settings.largest_error);
        if open.len() <= held.directions.nrows() {
            break (here, slopes, all);
        }
        held = Held { directions: all.rows(&open), stiffness: STIFFNESS * all.singular_values[0] };
        // What is determined stays where it was found, the rest goes back to the start.
        let moved: Vec<f64> = shares.iter().zip(&start).map(|(now, start)| now - start).collect();
        let moved = all.across(&moved, &open);
        from = start.iter().zip(&moved).map(|(start, moved)| (start + moved).clamp(0.0, 1.0)).collect();
        at_from = match evaluated(&residuals, &from)? {
            Ok(there) => there,
            Err(_) => {
                from.clone_from(&start);
                at_start.clone()
            }
        };
    };
    let fitted = Fitted { shares, here, slopes, all, n_held: held.directions.nrows(), n_steps, stop };
    Ok(fitted.report(unknowns, measurements, settings, &residuals, sum_of_squares(&at_start)))
}

fn check_enough(unknowns: &Unknowns, measurements: &Measurements, settings: &Settings) -> Result<(), Error> {
    if measurements.n_experiments() == 0 {
        return Err(Error::NoMeasurement { n_failed: measurements.n_failed() });
    }
    let (n_readings, n_unknowns) = (measurements.n_readings(), unknowns.len());
    if settings.noise == Noise::Estimated && n_readings <= n_unknowns {
        return Err(Error::TooFewReadings { n_readings, n_unknowns });
    }
    Ok(())
}

fn evaluated(residuals: &Residuals<'_>, shares: &[f64]) -> Result<Result<Vec<f64>, String>, Error> {
    let mut all = residuals.at(&[shares.to_vec()])?;
    Ok(all.pop().unwrap_or_else(|| Err("no answer".to_owned())))
}

fn sigma(noise: Noise, residuals: &[f64], n_fitted: usize) -> f64 {
    match noise {
        Noise::Known => 1.0,
        Noise::Estimated => (sum_of_squares(residuals) / residuals.len().saturating_sub(n_fitted).max(1) as f64).sqrt(),
    }
}

/// Puts unknowns that the search was driving into a bound onto it, one after the other, where that does not raise the sum of
/// squares with springs: the search itself never reaches one. The residuals there.
fn at_bounds(
    residuals: &Residuals<'_>,
    shares: &mut Vec<f64>,
    settings: &Settings,
    held: &Held,
) -> Result<Vec<f64>, Error> {
    let mut here = evaluated(residuals, shares)?.map_err(|reason| Error::FailsAtStart { reason })?;
    let slopes = jacobian(residuals, shares, &here, settings.difference_step, Sides::One)?;
    let start = residuals.unknowns.start_shares();
    let sum = |residuals: &[f64], shares: &[f64]| {
        sum_of_squares(residuals) + sum_of_squares(held.springs(shares, &start).as_slice())
    };
    for j in 0..shares.len() {
        let measured: f64 = slopes.column(j).iter().zip(&here).map(|(slope, residual)| slope * residual).sum();
        let springs = held.springs(shares, &start);
        let slope = measured + held.stiffness * held.directions.column(j).dot(&springs);
        let bound = if shares[j] < NEAR_BOUND && slope > 0.0 {
            0.0
        } else if shares[j] > 1.0 - NEAR_BOUND && slope < 0.0 {
            1.0
        } else {
            continue;
        };
        let mut moved = shares.clone();
        moved[j] = bound;
        if let Ok(there) = evaluated(residuals, &moved)?
            && sum(&there, &moved) <= sum(&here, shares)
        {
            (*shares, here) = (moved, there);
        }
    }
    Ok(here)
}

/// A fit that is done.
struct Fitted {
    shares: Vec<f64>,
    here: Vec<f64>,
    slopes: DMatrix<f64>,
    all: Directions,
    n_held: usize,
    n_steps: usize,
    stop: FitStop,
}

impl Fitted {
    fn bound(&self, j: usize) -> Option<RangeEnd> {
        if self.shares[j] <= 0.0 {
            Some(RangeEnd::Lower)
        } else if self.shares[j] >= 1.0 {
            Some(RangeEnd::Upper)
        } else {
            None
        }
    }

    fn report(
        self,
        unknowns: &Unknowns,
        measurements: &Measurements,
        settings: &Settings,
        residuals: &Residuals<'_>,
        at_start: f64,
    ) -> Identification {
        let n = self.shares.len();
        // Unknowns at a bound are as if they were known.
        let free: Vec<usize> = (0..n).filter(|j| self.bound(*j).is_none()).collect();
        let n_fitted = free.len().saturating_sub(self.n_held);
        let sigma = sigma(settings.noise, &self.here, n_fitted);
        let degrees_of_freedom = self.here.len().saturating_sub(n_fitted);
        let open = self.all.undetermined(sigma, settings.largest_error);
        let errors: Vec<f64> = open.iter().map(|k| self.all.error(*k, sigma)).collect();
        let covariance = covariance(&self.slopes, &free, sigma, settings.largest_error);
        let values = unknowns.values(&self.shares);
        let estimates = unknowns.region().parameters().iter().enumerate().map(|(j, parameter)| {
            let variance = covariance[j][j];
            Estimate {
                name: parameter.name().to_owned(),
                unit: parameter.unit().to_owned(),
                start: unknowns.start()[j],
                range: [parameter.lower(), parameter.upper()],
                value: values[j],
                standard_error: variance.is_finite().then(|| variance.sqrt() * parameter.width()),
                bound: self.bound(j),
                degrees_of_freedom: (settings.noise == Noise::Estimated).then_some(degrees_of_freedom),
            }
        });
        let correlation = |i: usize, j: usize| {
            let entry = covariance[i][j] / (covariance[i][i] * covariance[j][j]).sqrt();
            entry.is_finite().then_some(entry)
        };
        Identification {
            estimates: estimates.collect(),
            undetermined: directions(unknowns, &self.all.rows(&open), &errors),
            correlations: (0..n).map(|i| (0..n).map(|j| correlation(i, j)).collect()).collect(),
            singular_values: self.all.singular_values.iter().map(|value| value / residuals.factor).collect(),
            sum_of_squares: sum_of_squares(&self.here) / residuals.factor.powi(2),
            sum_of_squares_at_start: at_start / residuals.factor.powi(2),
            degrees_of_freedom,
            noise: settings.noise,
            sigma: if settings.noise == Noise::Known { sigma } else { sigma / residuals.factor },
            n_experiments: measurements.n_experiments(),
            n_failed_experiments: measurements.n_failed(),
            n_simulations: residuals.n_simulations(),
            n_failed_simulations: residuals.n_failures(),
            n_steps: self.n_steps,
            stop: self.stop,
        }
    }
}

/// Covariances in shares of the ranges; NaN for unknowns that are at a bound or not determined.
fn covariance(slopes: &DMatrix<f64>, free: &[usize], sigma: f64, largest_error: f64) -> Vec<Vec<f64>> {
    let n = slopes.ncols();
    let mut covariance = vec![vec![f64::NAN; n]; n];
    if free.is_empty() {
        return covariance;
    }
    let directions = Directions::of(&slopes.select_columns(free));
    let is_known = |a: usize| directions.covariance(a, a, sigma).sqrt() <= largest_error;
    let known: Vec<usize> = (0..free.len()).filter(|a| is_known(*a)).collect();
    for a in &known {
        for b in &known {
            covariance[free[*a]][free[*b]] = directions.covariance(*a, *b, sigma);
        }
    }
    covariance
}
