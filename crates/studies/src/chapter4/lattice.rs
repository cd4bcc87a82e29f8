//! A cost over the whole box, flown once on a lattice and shared by the landscapes and the noise seeds.

use anyhow::{Result, anyhow};
use bat_dynamics::Fidelity;
use design_space::Combinations;
use interpn::MulticubicRegular;

use super::file::Setup;
use crate::costs::Cost;

/// A flight without a cost.
#[derive(Clone, Debug)]
pub(crate) struct Failure {
    point: [f64; 2],
    /// Where and why, in words.
    pub(crate) words: String,
}

/// Costs on a lattice that reaches one step beyond the box, so that no interpolation inside the box is one-sided.
#[derive(Clone, Debug)]
pub(crate) struct Lattice {
    /// Positions along each parameter.
    pub(crate) axes: [Vec<f64>; 2],
    /// Positions by number; the second parameter runs fastest.
    positions: Combinations,
    /// Costs by number; NaN where the flight failed.
    costs: Vec<f64>,
    pub(crate) failures: Vec<Failure>,
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
        let positions = Combinations::saturating(axes.each_ref().map(|axis| axis.len() as u64));
        let point = |number: u64| -> Vec<f64> {
            axes.iter().zip(positions.digits(number)).map(|(axis, position)| axis[position as usize]).collect()
        };
        let points: Vec<Vec<f64>> = (0..positions.len()).map(point).collect();
        let flown = setup.bat.costs(&points, fidelity, done);
        let failure = |(point, cost): (&Vec<f64>, &Cost)| {
            let words = format!("at {}: {}", setup.sentence(point), cost.as_ref().err()?);
            Some(Failure { point: [point[0], point[1]], words })
        };
        let failures = points.iter().zip(&flown).filter_map(failure).collect();
        let costs = flown.into_iter().map(|cost| cost.unwrap_or(f64::NAN)).collect();
        Self { axes, positions, costs, failures }
    }

    /// How many flights it took.
    pub(crate) fn n_flights(&self) -> usize {
        self.costs.len()
    }

    fn cost(&self, position: [usize; 2]) -> f64 {
        self.costs[self.positions.index(&position.map(|place| place as u64)) as usize]
    }

    /// Rows of costs for a figure: `rows[j][i]` belongs to the second parameter's j and the first one's i; the box only.
    pub(crate) fn box_rows(&self) -> ([Vec<f64>; 2], Vec<Vec<f64>>) {
        let inside = |k: usize| 1..self.axes[k].len() - 1;
        let axes = core::array::from_fn(|k| self.axes[k][inside(k)].to_vec());
        let row = |j: usize| inside(0).map(|i| self.cost([i, j])).collect();
        (axes, inside(1).map(row).collect())
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
                let neighbors = (j.saturating_sub(1)..=j + 1).flat_map(around).filter(|at| *at != (i, j));
                let lowest = neighbors
                    .filter_map(|(i, j)| rows.get(j)?.get(i))
                    .all(|neighbor| neighbor.is_nan() || cost < neighbor);
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
        let steps: [f64; 2] = core::array::from_fn(|k| {
            let axis = &self.axes[k];
            (axis[axis.len() - 1] - axis[0]) / (axis.len() - 1) as f64
        });
        let cubic = MulticubicRegular::new(dims, starts, steps, &self.costs, false)
            .map_err(|reason| anyhow!("the lattice of remembered flights: {reason}"))?;
        Ok(move |point: &[f64]| {
            let cost = cubic.interp_one([point[0], point[1]]).map_err(str::to_owned)?;
            if cost.is_finite() { Ok(cost) } else { Err(self.failed_near(point, steps)) }
        })
    }

    /// Why there is no cost at a point: the failed flight nearest to it.
    fn failed_near(&self, point: &[f64], steps: [f64; 2]) -> String {
        let distance = |failure: &Failure| -> f64 {
            let apart = failure.point.iter().zip(point).zip(steps);
            apart.map(|((a, b), step)| ((a - b) / step).powi(2)).sum()
        };
        let nearest = self.failures.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
        nearest.map_or_else(|| "no cost".to_owned(), |failure| format!("a flight nearby failed, {}", failure.words))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bat::MODEL;

    #[test]
    fn near_a_flight_that_failed_the_interpolant_says_where_and_why() {
        let change = |text: String| {
            let text = text.replace("upper = 51.25", "upper = 90.0").replace("table_step = 0.1", "table_step = 15.0");
            text.replace("table_step = 0.5", "table_step = 11.0").replace("tolerance = 0.01", "tolerance = 0.1")
        };
        let setup = crate::study_file::read_changed("chapter4.toml", Setup::of, change).expect("a study");
        let lattice = Lattice::fly(&setup, MODEL, |_| {});
        assert_eq!(lattice.n_flights(), Lattice::size(&setup));
        let interpolant = lattice.interpolant().expect("large enough");
        assert!(!lattice.failures.is_empty(), "with a center of mass at 90 % of the chord every design flies");
        for Failure { point, words } in &lattice.failures {
            let reason = interpolant(point).expect_err("there was no cost");
            assert_eq!(reason, format!("a flight nearby failed, {words}"));
            assert!(words.starts_with(&format!("at {:.2} % chord and {:.2} deg: ", point[0], point[1])), "{words}");
            assert!(["slack", "trim", "left"].iter().any(|why| words.contains(why)), "{words}");
        }
    }
}
