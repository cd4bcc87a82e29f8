//! The bounded search for the least sum of squares, in shares of the ranges.

use std::cell::RefCell;
use std::convert::Infallible;

use basin::{
    BoxBounds, ConstraintDescription, ConstraintSet, ConstraintSolveError, Constraints, CostFunction, DenseMatrix,
    Executor, Jacobian, Residual, TerminationCode, TrustRegionReflective,
};
use nalgebra::{DMatrix, DVector};

use super::found::FitStop;
use super::jacobian::{Sides, jacobian};
use super::residuals::{Residuals, sum_of_squares};
use super::settings::Settings;
use crate::Error;

/// A component of the gradient counts as zero at this share of ‖J‖ ‖r‖ at the start.
const GRADIENT: f64 = 1e-12;

/// Directions along which the unknowns are held: rows of length 1, by springs to the start.
#[derive(Debug, Clone)]
pub(super) struct Held {
    pub(super) directions: DMatrix<f64>,
    pub(super) stiffness: f64,
}

impl Held {
    pub(super) fn nothing(n_unknowns: usize) -> Self {
        Self { directions: DMatrix::zeros(0, n_unknowns), stiffness: 0.0 }
    }

    /// The residuals of the springs.
    pub(super) fn springs(&self, shares: &[f64], start: &[f64]) -> DVector<f64> {
        let moved = shares.iter().zip(start).map(|(now, start)| now - start);
        &self.directions * DVector::from_iterator(shares.len(), moved) * self.stiffness
    }
}

/// Where a search ended.
pub(super) struct Reached {
    pub(super) shares: Vec<f64>,
    pub(super) stop: FitStop,
    pub(super) n_steps: usize,
}

/// The search from `start` on, where the residuals are `at_start`; `believed` is where springs hold.
pub(super) fn search(
    residuals: &Residuals<'_>,
    settings: &Settings,
    held: &Held,
    start: &[f64],
    at_start: Vec<f64>,
) -> Result<Reached, Error> {
    let n = start.len();
    let fit = Fit {
        residuals,
        held,
        believed: residuals.unknowns.start_shares(),
        step: settings.difference_step,
        lower: vec![0.0; n],
        upper: vec![1.0; n],
        last: RefCell::new((start.to_vec(), at_start)),
    };
    let gradient = GRADIENT * fit.slope_at_start(start)?;
    let solver = TrustRegionReflective::new()
        .with_absolute_scaled_gradient_tolerance(gradient)
        .with_relative_cost_change_tolerance(settings.tolerance);
    let run = Executor::from_start(fit, solver, start.to_vec()).max_iter(settings.max_steps as u64).run();
    let result = run.map_err(|error| match error {
        ConstraintSolveError::Evaluation(error) => error,
        _ => Error::OptimizerRefused { n_parameters: n },
    })?;
    let stop = match result.report.code() {
        TerminationCode::MaxIter => FitStop::StepLimit,
        TerminationCode::SolverFailed => FitStop::NoBetterStep,
        _ => FitStop::Converged,
    };
    let n_steps = usize::try_from(result.iter()).unwrap_or(usize::MAX);
    Ok(Reached { shares: result.param().clone(), stop, n_steps })
}

/// The least-squares problem as the solver takes it: the residuals, and those of the springs below them.
struct Fit<'a, 'b> {
    residuals: &'b Residuals<'a>,
    held: &'b Held,
    believed: Vec<f64>,
    step: f64,
    lower: Vec<f64>,
    upper: Vec<f64>,
    /// The shares that were simulated last, with their residuals: the Jacobian is asked for where a step was accepted.
    last: RefCell<(Vec<f64>, Vec<f64>)>,
}

impl Fit<'_, '_> {
    /// The residuals without springs; NaN where the model fails, which the solver answers with a shorter step.
    fn measured(&self, shares: &[f64]) -> Result<Vec<f64>, Error> {
        if self.last.borrow().0 == shares {
            return Ok(self.last.borrow().1.clone());
        }
        let there = self.residuals.at(&[shares.to_vec()])?.pop();
        let there = there.and_then(Result::ok).unwrap_or_else(|| vec![f64::NAN; self.residuals.len()]);
        *self.last.borrow_mut() = (shares.to_vec(), there.clone());
        Ok(there)
    }

    /// ‖J‖ ‖r‖.
    fn slope_at_start(&self, start: &[f64]) -> Result<f64, Error> {
        let here = self.measured(start)?;
        let slopes = jacobian(self.residuals, start, &here, self.step, Sides::One)?;
        Ok(slopes.norm() * sum_of_squares(&here).sqrt())
    }
}

impl Constraints for Fit<'_, '_> {
    type Set = ConstraintSet<BoxBounds<Vec<f64>>>;

    fn constraints(&self) -> <Self::Set as ConstraintDescription>::Borrowed<'_> {
        ConstraintSet::new().with_bounds(BoxBounds::new(Some(&self.lower), Some(&self.upper)))
    }
}

impl CostFunction for Fit<'_, '_> {
    type Param = Vec<f64>;
    type Output = f64;
    type Error = Infallible;

    fn cost(&self, _: &Vec<f64>) -> Result<f64, Infallible> {
        // The solver takes the cost from the residuals and never asks.
        Ok(f64::NAN)
    }
}

impl Residual for Fit<'_, '_> {
    type Param = Vec<f64>;
    type Output = Vec<f64>;
    type Error = Error;

    fn residual(&self, shares: &Vec<f64>) -> Result<Vec<f64>, Error> {
        let mut all = self.measured(shares)?;
        all.extend(self.held.springs(shares, &self.believed).iter());
        Ok(all)
    }
}

impl Jacobian for Fit<'_, '_> {
    type Jacobian = DenseMatrix<f64>;

    fn jacobian(&self, shares: &Vec<f64>) -> Result<DenseMatrix<f64>, Error> {
        let here = self.measured(shares)?;
        let measured = jacobian(self.residuals, shares, &here, self.step, Sides::One)?;
        let springs = &self.held.directions * self.held.stiffness;
        let rows = measured.row_iter().chain(springs.row_iter());
        let entries: Vec<f64> = rows.flat_map(|row| row.iter().copied().collect::<Vec<_>>()).collect();
        Ok(DenseMatrix::from_row_slice(here.len() + springs.nrows(), shares.len(), &entries))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identification::measurements::Measurements;
    use crate::identification::residuals::Answer;
    use crate::identification::settings::Noise;
    use crate::identification::unknowns::Unknowns;
    use design_space::{Parameter, Region};

    /// Residuals and springs, moved by hand.
    #[test]
    fn jacobian_is_the_slope_of_the_residuals_and_of_the_springs() {
        let parameter = |name: &str| Parameter::continuous(name, "", 0.0, 1.0).unwrap();
        let unknowns = Unknowns::new(Region::new(["a", "b"].map(parameter).to_vec()).unwrap(), vec![0.5; 2]).unwrap();
        let mut measurements = Measurements::new(vec!["y".to_owned()]).unwrap();
        measurements.push(&[1.0], &[0.3], &[0.1]).unwrap();
        let mut model = |all: &[Vec<f64>], _: &[Vec<f64>]| -> Vec<Vec<Answer>> {
            all.iter().map(|theta| vec![Ok(vec![theta[0] + 3.0 * theta[1]])]).collect()
        };
        let residuals = Residuals::new(&unknowns, &measurements, Noise::Known, &mut model);
        let held = Held { directions: DMatrix::from_row_slice(1, 2, &[0.6, 0.8]), stiffness: 7.0 };
        let fit = Fit {
            residuals: &residuals,
            held: &held,
            believed: vec![0.5; 2],
            step: 1e-5,
            lower: vec![0.0; 2],
            upper: vec![1.0; 2],
            last: RefCell::default(),
        };
        let here = fit.residual(&vec![0.4, 0.2]).unwrap();
        let slopes = Jacobian::jacobian(&fit, &vec![0.4, 0.2]).unwrap();
        for (j, there) in [vec![0.5, 0.2], vec![0.4, 0.3]].iter().enumerate() {
            for (row, (there, here)) in fit.residual(there).unwrap().iter().zip(&here).enumerate() {
                assert!((slopes.get(row, j) - (there - here) / 0.1).abs() < 1e-6, "row {row}, unknown {j}");
            }
        }
    }
}
