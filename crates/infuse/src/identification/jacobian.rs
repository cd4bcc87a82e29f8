//! How residuals go with shares of the ranges, by differences.

use nalgebra::DMatrix;

use super::residuals::Residuals;
use crate::Error;

/// Which differences are taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Sides {
    /// One step inwards: enough for a search.
    One,
    /// A step to each side where the bounds leave room, all in one batch.
    Both,
}

/// ∂r/∂u at shares with the residuals `here`. An unknown that can be moved to neither side counts as without effect.
pub(super) fn jacobian(
    residuals: &Residuals<'_>,
    shares: &[f64],
    here: &[f64],
    step: f64,
    sides: Sides,
) -> Result<DMatrix<f64>, Error> {
    let moves: Vec<(usize, f64)> = (0..shares.len())
        .flat_map(|j| {
            let inwards = if shares[j] > 0.5 { -step } else { step };
            let has_room = shares[j] >= step && shares[j] <= 1.0 - step;
            let outwards = (sides == Sides::Both && has_room).then_some(-inwards);
            std::iter::once(inwards).chain(outwards).map(move |by| (j, by))
        })
        .collect();
    let mut jacobian = DMatrix::zeros(here.len(), shares.len());
    for (j, sides) in sides_of(residuals, shares, moves)?.into_iter().enumerate() {
        let (near, far) = match &sides[..] {
            [] => continue,
            [(by, there)] => ((0.0, here), (*by, &there[..])),
            [(by, there), (back, behind), ..] => ((*back, &behind[..]), (*by, &there[..])),
        };
        for (row, (then, now)) in far.1.iter().zip(near.1).enumerate() {
            jacobian[(row, j)] = (then - now) / (far.0 - near.0);
        }
    }
    Ok(jacobian)
}

/// A move of one unknown with the residuals there.
type Side = (f64, Vec<f64>);

/// The moves that could be simulated, unknown by unknown; where none could, the other way once more.
fn sides_of(residuals: &Residuals<'_>, shares: &[f64], moves: Vec<(usize, f64)>) -> Result<Vec<Vec<Side>>, Error> {
    let mut sides: Vec<Vec<Side>> = vec![Vec::new(); shares.len()];
    let take = |moves: &[(usize, f64)], sides: &mut Vec<Vec<Side>>| -> Result<(), Error> {
        let moved = |&(j, by): &(usize, f64)| {
            let mut moved = shares.to_vec();
            moved[j] += by;
            moved
        };
        let there = residuals.at(&moves.iter().map(moved).collect::<Vec<_>>())?;
        for ((j, by), there) in moves.iter().zip(there) {
            if let Ok(there) = there {
                sides[*j].push((*by, there));
            }
        }
        Ok(())
    };
    take(&moves, &mut sides)?;
    let tried_once = |j: usize| moves.iter().filter(|(k, _)| *k == j).count() == 1;
    let others: Vec<(usize, f64)> = moves
        .iter()
        .filter(|(j, by)| sides[*j].is_empty() && tried_once(*j) && (0.0..=1.0).contains(&(shares[*j] - by)))
        .map(|(j, by)| (*j, -by))
        .collect();
    if !others.is_empty() {
        take(&others, &mut sides)?;
    }
    Ok(sides)
}
