//! From a start to a plant that meets the evidence, by the shortest way: damped Gauss-Newton steps of least length.

use nalgebra::{DMatrix, DVector};

use super::Calibration;
use super::candidate::{Candidate, Flown, fly};
use super::evidence::Aims;

/// A fit goes on until no residual is above this share of its tolerance.
const AIM: f64 = 0.3;
/// And has met the evidence when none is above this one.
const MET: f64 = 0.8;
/// Differences are taken anew where a step leaves more of the sum of squares.
const STALE: f64 = 0.15;
const SLOW: f64 = 0.6;
const MOST_STEPS: usize = 20;
/// How often a step is shortened before the fit is given up.
const MOST_TRIES: usize = 7;
/// Step of the differences, in units of the logistic coordinate.
const STEP: f64 = 0.02;
/// No coordinate moves farther at once.
const LONGEST: f64 = 1.5;

/// Why a start was not kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Refusal {
    /// It cannot fly what the evidence asks for.
    CannotFly,
    /// No plant nearby meets it.
    NotMet,
    /// The costs are lower elsewhere, whatever was tried.
    OtherOptimum,
    /// Too many designs of the box cannot fly.
    FailsInBox,
}

impl Refusal {
    pub(super) const ALL: [Self; 4] = [Self::CannotFly, Self::NotMet, Self::OtherOptimum, Self::FailsInBox];

    pub(super) const fn words(self) -> &'static str {
        match self {
            Self::CannotFly => "start cannot fly what the evidence asks for",
            Self::NotMet => "evidence not met",
            Self::OtherOptimum => "costs lower elsewhere in the box",
            Self::FailsInBox => "too many designs of the box fail",
        }
    }
}

/// Where a fit stands.
#[derive(Debug, Clone)]
pub(super) struct Fitted {
    /// Coordinates from minus to plus infinity: shares of the ranges through a logistic function.
    pub(super) coordinates: Vec<f64>,
    pub(super) candidate: Candidate,
    pub(super) residuals: Vec<f64>,
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

    /// From these coordinates on; with the fit that came closest where the evidence is not met.
    pub(super) fn run(&self, start: &[f64]) -> Result<Fitted, (Refusal, Option<Fitted>)> {
        let Some(mut now) = self.at(&[start.to_vec()]).pop().flatten() else {
            return Err((Refusal::CannotFly, None));
        };
        let mut damping = 1e-2;
        let mut jacobian = self.jacobian(&now);
        let mut is_fresh = true;
        for _ in 0..MOST_STEPS {
            if worst(&now.residuals) <= AIM {
                break;
            }
            let Some((next, softer)) = self.shorter(&now, &jacobian, damping) else {
                if is_fresh {
                    break;
                }
                (jacobian, is_fresh) = (self.jacobian(&now), true);
                continue;
            };
            let left = sum_of_squares(&next.residuals) / sum_of_squares(&now.residuals);
            // Met already, and hardly closer any more.
            if worst(&next.residuals) <= MET && left > SLOW {
                now = next;
                break;
            }
            is_fresh = left > STALE;
            if is_fresh {
                jacobian = self.jacobian(&next);
            } else {
                corrected(&mut jacobian, &now, &next);
            }
            (now, damping) = (next, softer);
        }
        if worst(&now.residuals) <= MET { Ok(now) } else { Err((Refusal::NotMet, Some(now))) }
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
            is_finite.then_some(Fitted { coordinates: z.clone(), candidate, residuals })
        })
        .collect()
    }

    /// How the residuals go with the coordinates, by differences; a coordinate that cannot be moved counts as without effect.
    fn jacobian(&self, now: &Fitted) -> DMatrix<f64> {
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
        let all: Vec<Vec<f64>> = flown.iter().map(|k| moved(*k)).collect();
        for (k, fitted) in flown.iter().zip(self.at(&all)) {
            if let Some(fitted) = fitted {
                fill(*k, &fitted.residuals);
            }
        }
        // Weights change no flight.
        let Calibration { profile, settings, .. } = self.calibration;
        let same = fly(std::slice::from_ref(&now.candidate), &self.aims.spots(), profile, settings).pop();
        if let Some(same) = same.and_then(|flown| flown.into_iter().collect::<Option<Vec<Flown>>>()) {
            for k in weights {
                fill(k, &self.aims.residuals(&self.calibration.candidate(&moved(k)), &same));
            }
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
