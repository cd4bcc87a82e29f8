//! From a start to a plant that meets the evidence, by the shortest way: damped Gauss-Newton steps of least length.

use nalgebra::{DMatrix, DVector};

use super::candidate::{Candidate, Flown, fly};
use super::evidence::Aims;
use super::file::Calibration;
use super::outcome::Refusal;

/// A fit goes on until no residual is above this share of its tolerance.
const AIM: f64 = 0.3;
/// And has met the evidence when none is above this one.
pub(super) const MET: f64 = 0.8;
/// Differences are taken anew where a step leaves more of the sum of squares.
const STALE: f64 = 0.15;
const SLOW: f64 = 0.6;
/// After so many steps in a row that leave more than this the fit is given up.
const MOST_SLOW: usize = 4;
const STUCK: f64 = 0.9;
const MOST_STEPS: usize = 24;
/// In so many turns all coordinates are moved.
const TURNS: usize = 2;
/// How often a step is shortened before the fit is given up.
const MOST_TRIES: usize = 7;
/// Step of the differences, in units of the logistic coordinate.
const STEP: f64 = 0.02;
/// No coordinate moves farther at once.
const LONGEST: f64 = 1.5;

/// Where a fit stands.
#[derive(Debug, Clone)]
pub(super) struct Fitted {
    /// Coordinates from minus to plus infinity: shares of the ranges through a logistic function.
    pub(super) coordinates: Vec<f64>,
    pub(super) candidate: Candidate,
    pub(super) residuals: Vec<f64>,
    /// Of the spots of its aims.
    pub(super) flown: Vec<Flown>,
}

/// Why a fit has no plant, and where it ended, if it could begin.
#[derive(Debug)]
pub(super) struct Unmet {
    pub(super) refusal: Refusal,
    pub(super) at: Option<Box<Fitted>>,
}

/// A fit at work.
pub(super) struct Fit<'a> {
    calibration: &'a Calibration,
    aims: &'a Aims<'a>,
}

impl<'a> Fit<'a> {
    pub(super) const fn new(calibration: &'a Calibration, aims: &'a Aims<'a>) -> Self {
        Self { calibration, aims }
    }

    /// From these coordinates on.
    pub(super) fn run(&self, start: &[f64]) -> Result<Fitted, Unmet> {
        let Some(mut now) = self.at(&[start.to_vec()]).pop().flatten() else {
            return Err(Unmet { refusal: Refusal::CannotFly, at: None });
        };
        let mut damping = 1e-2;
        let mut turns = 0..;
        let mut slopes = |at: &Fitted| self.jacobian(at, turns.next().unwrap_or(0));
        let mut jacobian = slopes(&now);
        let mut is_fresh = true;
        let mut n_slow = 0;
        for _ in 0..MOST_STEPS {
            if worst(&now.residuals) <= AIM {
                break;
            }
            let Some((next, softer)) = self.shorter(&now, &jacobian, damping) else {
                if is_fresh {
                    break;
                }
                (jacobian, is_fresh) = (slopes(&now), true);
                continue;
            };
            let left = sum_of_squares(&next.residuals) / sum_of_squares(&now.residuals);
            // Met already, and hardly closer any more.
            if worst(&next.residuals) <= MET && left > SLOW {
                now = next;
                break;
            }
            n_slow = if left > STUCK { n_slow + 1 } else { 0 };
            if n_slow == MOST_SLOW {
                break;
            }
            is_fresh = left > STALE;
            if is_fresh {
                jacobian = slopes(&next);
            } else {
                corrected(&mut jacobian, &now, &next);
            }
            (now, damping) = (next, softer);
        }
        if worst(&now.residuals) <= MET {
            Ok(now)
        } else {
            Err(Unmet { refusal: Refusal::NotMet, at: Some(Box::new(now)) })
        }
    }

    /// A step that lowers the residuals, shortened until it does, and the damping for the next one.
    fn shorter(&self, now: &Fitted, jacobian: &DMatrix<f64>, mut damping: f64) -> Option<(Fitted, f64)> {
        let residuals = DVector::from_column_slice(&now.residuals);
        let gram = jacobian * jacobian.transpose();
        for _ in 0..MOST_TRIES {
            let n = gram.nrows();
            let damped = &gram + DMatrix::identity(n, n) * (damping * gram.trace() / n as f64);
            // Of all steps that do the same to the residuals the shortest.
            let step = jacobian.transpose() * damped.cholesky()?.solve(&residuals);
            let scale = (LONGEST / step.amax()).min(1.0);
            let moved: Vec<f64> = now.coordinates.iter().zip(step.iter()).map(|(z, step)| z - scale * step).collect();
            let next = self.at(&[moved]).pop().flatten();
            if let Some(next) = next.filter(|next| sum_of_squares(&next.residuals) < sum_of_squares(&now.residuals)) {
                return Some((next, (damping / 4.0).max(1e-6)));
            }
            damping *= 6.0;
        }
        None
    }

    /// Candidates at these coordinates; none where one of their flights fails.
    fn at(&self, coordinates: &[Vec<f64>]) -> Vec<Option<Fitted>> {
        let candidates: Vec<Candidate> = coordinates.iter().map(|z| self.calibration.candidate(z)).collect();
        let Calibration { profile, settings, .. } = self.calibration;
        let flown = fly(&candidates, &self.aims.spots(), profile, settings);
        let all = coordinates.iter().zip(candidates).zip(flown);
        all.map(|((z, candidate), flown)| {
            let flown: Vec<Flown> = flown.into_iter().collect::<Option<_>>()?;
            let residuals = self.aims.residuals(&candidate, &flown);
            let is_finite = residuals.iter().all(|residual| residual.is_finite());
            is_finite.then_some(Fitted { coordinates: z.clone(), candidate, residuals, flown })
        })
        .collect()
    }

    /// How the residuals go with the coordinates, by differences: with the weights, and with every other of the rest, which take
    /// turns, because there are far more of them than residuals. One that cannot be moved counts as without effect.
    fn jacobian(&self, now: &Fitted, turn: usize) -> DMatrix<f64> {
        let free = &self.calibration.free;
        let moved = |k: usize| {
            let mut z = now.coordinates.clone();
            z[k] += STEP;
            z
        };
        let mut jacobian = DMatrix::zeros(now.residuals.len(), free.len());
        let mut fill = |k: usize, residuals: &[f64]| {
            for (row, (then, now)) in residuals.iter().zip(&now.residuals).enumerate() {
                jacobian[(row, k)] = (then - now) / STEP;
            }
        };
        let (weights, flown): (Vec<usize>, Vec<usize>) = (0..free.len()).partition(|k| free[*k].is_weight());
        let flown: Vec<usize> = flown.into_iter().skip(turn % TURNS).step_by(TURNS).collect();
        let all: Vec<Vec<f64>> = flown.iter().map(|k| moved(*k)).collect();
        for (k, fitted) in flown.iter().zip(self.at(&all)) {
            if let Some(fitted) = fitted {
                fill(*k, &fitted.residuals);
            }
        }
        // Weights change no flight.
        for k in weights {
            fill(k, &self.aims.residuals(&self.calibration.candidate(&moved(k)), &now.flown));
        }
        jacobian
    }
}

/// What a step taught about the slopes along it (Broyden 1965).
fn corrected(jacobian: &mut DMatrix<f64>, before: &Fitted, after: &Fitted) {
    let difference = |a: &[f64], b: &[f64]| DVector::from_iterator(a.len(), a.iter().zip(b).map(|(a, b)| a - b));
    let step = difference(&after.coordinates, &before.coordinates);
    let surprise = difference(&after.residuals, &before.residuals) - &*jacobian * &step;
    let length = step.norm_squared();
    if length > 0.0 {
        *jacobian += surprise * step.transpose() / length;
    }
}

fn sum_of_squares(residuals: &[f64]) -> f64 {
    residuals.iter().map(|residual| residual * residual).sum()
}

pub(super) fn worst(residuals: &[f64]) -> f64 {
    residuals.iter().fold(0.0, |worst, residual| worst.max(residual.abs()))
}
