//! Polynomials: along a run they are polynomials of its coordinates.

use multiversion::multiversion;

use crate::GridPoints;
use crate::lanes::MOST_FACTORS;
use crate::monomial::Monomial;
use crate::over_grid::runs::{Alone, OverGrid, Run, Runs, WIDTH};

/// Points of a run: some ten numbers for each stay in the second cache, and what is computed once a run counts for nothing.
const RUN: usize = 1024;

/// Products of powers of the coordinates along a run, and what stands before each.
pub(crate) struct Powers<'a> {
    alone: Alone<'a>,
    runs: Runs<'a>,
    products: Vec<Product<'a>>,
}

/// One product of powers of the coordinates along a run.
#[derive(Debug)]
struct Product<'a> {
    /// The monomials with it.
    monomials: Vec<&'a Monomial>,
    /// It at each point of a run, filled up to a multiple of [`WIDTH`].
    along_run: Vec<f64>,
}

impl<'a> Powers<'a> {
    /// None where the grid is too large for tables.
    pub(crate) fn new(monomials: &'a [Monomial], grid: &'a GridPoints, alone: Alone<'a>) -> Option<Self> {
        let runs = Runs::of(grid, RUN);
        if !runs.are_small(monomials.len()) {
            return None;
        }
        let (n_leading, points) = (runs.leading_levels().len(), runs.points());
        let mut products: Vec<Product<'a>> = Vec::new();
        for monomial in monomials {
            let has_same = |product: &&mut Product<'a>| {
                product.monomials.iter().all(|other| other.factors_from(n_leading).eq(monomial.factors_from(n_leading)))
            };
            if let Some(product) = products.iter_mut().find(has_same) {
                product.monomials.push(monomial);
                continue;
            }
            let at =
                |point: &Vec<f64>| monomial.factors_from(n_leading).map(|factor| point[factor - n_leading]).product();
            let mut along_run: Vec<f64> = points.iter().map(at).collect();
            along_run.resize(points.len().next_multiple_of(WIDTH), 0.0);
            products.push(Product { monomials: vec![monomial], along_run });
        }
        Some(Self { alone, runs, products })
    }
}

impl OverGrid for Powers<'_> {
    fn fill(&self, first: u64, estimates: &mut [f64]) {
        fill(self, first, estimates);
    }
}

#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx+avx2"))]
fn fill(powers: &Powers<'_>, first: u64, estimates: &mut [f64]) {
    let run = PowersRun { powers, factors: vec![0.0; powers.products.len()] };
    powers.runs.fill(run, first, estimates, &powers.alone);
}

struct PowersRun<'a> {
    powers: &'a Powers<'a>,
    /// What stands before each product.
    factors: Vec<f64>,
}

impl Run for PowersRun<'_> {
    #[inline(always)]
    fn start(&mut self, levels: &[u64]) {
        let mut point = [0.0; MOST_FACTORS];
        for ((x, axis), &level) in point.iter_mut().zip(self.powers.runs.leading_levels()).zip(levels) {
            *x = axis[level as usize];
        }
        for (factor, product) in self.factors.iter_mut().zip(&self.powers.products) {
            *factor = product.monomials.iter().map(|monomial| monomial.value_before(levels.len(), &point)).sum();
        }
    }

    #[inline(always)]
    fn block(&self, at: usize) -> [f64; WIDTH] {
        let mut estimates = [0.0; WIDTH];
        for (factor, product) in self.factors.iter().zip(&self.powers.products) {
            let along_run = &product.along_run[at..][..WIDTH];
            for lane in 0..WIDTH {
                estimates[lane] += factor * along_run[lane];
            }
        }
        estimates
    }
}
