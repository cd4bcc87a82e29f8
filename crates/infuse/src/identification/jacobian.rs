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

#[cfg(test)]
mod tests {
    use design_space::{Parameter, Region};

    use super::super::measurements::Measurements;
    use super::super::residuals::Answer;
    use super::super::settings::Noise;
    use super::super::unknowns::Unknowns;
    use super::*;

    /// ∂r/∂u of r = u₀² + 3 u₁ and how often the model was asked, where it fails above `most` of the first unknown.
    fn of(shares: [f64; 2], most: f64, step: f64, sides: Sides) -> ([f64; 2], usize) {
        let unknown = |name: &str| Parameter::continuous(name, "1", 0.0, 1.0).expect("a number");
        let region = Region::new(vec![unknown("a"), unknown("b")]).expect("a region");
        let unknowns = Unknowns::new(region, vec![0.5; 2]).expect("unknowns");
        let mut measurements = Measurements::new(vec!["r".to_owned()]).expect("a response");
        measurements.push(&[0.0], &[0.0], &[1.0]).expect("a reading");
        let mut model = |unknowns: &[Vec<f64>], _: &[Vec<f64>]| -> Vec<Vec<Answer>> {
            let one = |u: &Vec<f64>| {
                let failed = || Err("it fails there".to_owned());
                vec![if u[0] > most { failed() } else { Ok(vec![u[0] * u[0] + 3.0 * u[1]]) }]
            };
            unknowns.iter().map(one).collect()
        };
        let residuals = Residuals::new(&unknowns, &measurements, Noise::Known, &mut model);
        let here = [shares[0] * shares[0] + 3.0 * shares[1]];
        let found = jacobian(&residuals, &shares, &here, step, sides).expect("the model answers");
        ([found[(0, 0)], found[(0, 1)]], residuals.n_simulations())
    }

    /// Of u² one difference is 2 u ± h, both together 2 u.
    #[test]
    fn a_search_asks_once_for_each_unknown_and_the_other_way_only_where_that_fails() {
        let check = |found: ([f64; 2], usize), first: f64, asked: usize| {
            assert!((found.0[0] - first).abs() < 1e-9 && (found.0[1] - 3.0).abs() < 1e-9, "{found:?} for {first}");
            assert_eq!(found.1, asked, "{found:?}");
        };
        check(of([0.25, 0.25], 1.0, 0.125, Sides::One), 0.625, 2);
        check(of([0.75, 0.75], 1.0, 0.125, Sides::One), 1.375, 2);
        check(of([0.25, 0.25], 1.0, 0.125, Sides::Both), 0.5, 4);
        check(of([0.25, 0.25], 0.3, 0.125, Sides::One), 0.375, 3);
        // Beyond the bound there is nothing to ask for.
        check(of([0.0, 0.25], 0.1, 0.125, Sides::One), 0.0, 2);
    }
}
