//! A cost over the whole box, flown once on a lattice and shared by the landscapes and the noise seeds.

use anyhow::{Result, anyhow};
use bat_dynamics::Fidelity;
use interpn::MulticubicRegular;

use super::file::Setup;

/// Costs on a lattice that reaches one step beyond the box, so that no interpolation inside the box is one-sided.
#[derive(Clone, Debug)]
pub(crate) struct Lattice {
    /// Positions along each parameter.
    pub(crate) axes: [Vec<f64>; 2],
    /// Costs, the second parameter running fastest; NaN where the flight failed.
    costs: Vec<f64>,
    /// Why flights failed, with their points.
    pub(crate) failures: Vec<(Vec<f64>, String)>,
}

impl Lattice {
    /// The points of the lattice.
    fn axes(setup: &Setup) -> [Vec<f64>; 2] {
        core::array::from_fn(|k| {
            let (lower, upper) = setup.bounds(k);
            let count = ((upper - lower) / setup.parameters()[k].table_step).round().max(1.0);
            let step = (upper - lower) / count;
            (-1..=count as i64 + 1).map(|i| lower + step * i as f64).collect()
        })
    }

    /// How many flights [`Lattice::fly`] takes.
    pub(crate) fn size(setup: &Setup) -> usize {
        Self::axes(setup).iter().map(Vec::len).product()
    }

    pub(crate) fn fly(setup: &Setup, fidelity: Fidelity, done: impl Fn(usize) + Sync) -> Self {
        let axes = Self::axes(setup);
        let points: Vec<Vec<f64>> = axes[0].iter().flat_map(|x| axes[1].iter().map(move |y| vec![*x, *y])).collect();
        let flown = setup.bat.costs(&points, fidelity, done);
        let failures =
            points.iter().zip(&flown).filter_map(|(p, cost)| Some((p.clone(), cost.as_ref().err()?.clone()))).collect();
        let costs = flown.into_iter().map(|cost| cost.unwrap_or(f64::NAN)).collect();
        Self { axes, costs, failures }
    }

    /// Rows of costs for a figure: `rows[j][i]` belongs to the second parameter's j and the first one's i; the box only.
    pub(crate) fn box_rows(&self) -> ([Vec<f64>; 2], Vec<Vec<f64>>) {
        let inner: [Vec<f64>; 2] = core::array::from_fn(|k| self.axes[k][1..self.axes[k].len() - 1].to_vec());
        let stride = self.axes[1].len();
        let rows = (1..stride - 1)
            .map(|j| (1..self.axes[0].len() - 1).map(|i| self.costs[i * stride + j]).collect())
            .collect();
        (inner, rows)
    }

    /// The lattice point with the lowest cost inside the box, and that cost.
    pub(crate) fn lowest(&self) -> ([f64; 2], f64) {
        let (axes, rows) = self.box_rows();
        let mut lowest = ([f64::NAN; 2], f64::INFINITY);
        for (y, row) in axes[1].iter().zip(&rows) {
            for (x, cost) in axes[0].iter().zip(row) {
                if *cost < lowest.1 {
                    lowest = ([*x, *y], *cost);
                }
            }
        }
        lowest
    }

    /// Local minima of the lattice inside the box, lowest first.
    pub(crate) fn wells(&self) -> Vec<([f64; 2], f64)> {
        let (axes, rows) = self.box_rows();
        let mut wells = Vec::new();
        for (j, row) in rows.iter().enumerate() {
            for (i, cost) in row.iter().enumerate() {
                let around = |j: usize| (i.saturating_sub(1)..=i + 1).map(move |i| (i, j));
                let neighbours = (j.saturating_sub(1)..=j + 1).flat_map(around).filter(|at| *at != (i, j));
                let lowest = neighbours
                    .filter_map(|(i, j)| rows.get(j)?.get(i))
                    .all(|neighbour| neighbour.is_nan() || cost < neighbour);
                if lowest && cost.is_finite() {
                    wells.push(([axes[0][i], axes[1][j]], *cost));
                }
            }
        }
        wells.sort_by(|a, b| a.1.total_cmp(&b.1));
        wells
    }

    /// A function that interpolates the costs (cubic Hermite).
    ///
    /// # Errors
    /// When the lattice is too small.
    pub(crate) fn interpolant(&self) -> Result<impl Fn(&[f64]) -> Result<f64, String> + '_> {
        let dims = [self.axes[0].len(), self.axes[1].len()];
        let starts = [self.axes[0][0], self.axes[1][0]];
        let steps = core::array::from_fn(|k| {
            let axis = &self.axes[k];
            (axis[axis.len() - 1] - axis[0]) / (axis.len() - 1) as f64
        });
        let cubic = MulticubicRegular::new(dims, starts, steps, &self.costs, false)
            .map_err(|reason| anyhow!("the lattice of remembered flights: {reason}"))?;
        Ok(move |point: &[f64]| {
            let cost = cubic.interp_one([point[0], point[1]]).map_err(str::to_owned)?;
            if cost.is_finite() { Ok(cost) } else { Err("a flight near this point failed".to_owned()) }
        })
    }
}
