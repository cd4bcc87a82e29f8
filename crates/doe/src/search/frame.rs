//! What stays the same during a search, and the information of its runs.

use std::sync::Arc;

use multiversion::multiversion;

use super::problem::Problem;
use super::runs::Regressors;
use super::table::Table;
use crate::criterion::moment_matrix;
use crate::information::PIVOT_FLOOR;
use crate::lattice::Lattice;
use crate::matrix::{add_outer, cholesky, inverse_of_factor};
use crate::power::power;
use crate::products::Products;
use crate::shape::{BoxShape, Shape};
use crate::{Criterion, Error, Space};

/// What stays the same during a search.
#[derive(Debug)]
pub(crate) struct Frame {
    pub(crate) criterion: Criterion,
    pub(crate) regressors: Regressors,
    pub(crate) products: Arc<Products>,
    /// Information of the fixed runs, p × p.
    pub(crate) fixed: Vec<f64>,
    /// How often each free run is made.
    pub(crate) multiplicities: Vec<f64>,
    /// Mean of r r' over the space, for I; empty otherwise.
    pub(crate) moments: Vec<f64>,
    /// Least log det(M) / p that a search for T accepts; minus infinity for the others.
    pub(crate) least_log_determinant: f64,
    /// Lattice for G.
    pub(crate) table: Option<Table>,
}

impl Frame {
    /// What the search for a problem needs, its points mapped to other coordinates; the lattice of G is that of a
    /// continuous shape, if there is one.
    pub(crate) fn of(
        problem: &Problem,
        shape: Option<&BoxShape>,
        least_log_determinant: f64,
        map: &dyn Fn(&[f64]) -> Vec<f64>,
    ) -> Result<Self, Error> {
        let (model, criterion) = (problem.model(), problem.criterion());
        let products = Arc::new(Products::of(model));
        let p = model.n_terms();
        let mut fixed = vec![0.0; p * p];
        for run in problem.fixed_runs() {
            add_outer(&mut fixed, p, 1.0, &model.regressor(&map(run))?);
        }
        let moments = match (criterion, problem.space().shape()) {
            (Criterion::I, Shape::List(list)) => {
                let mapped = Space::list_unchecked(list.n_factors, list.points().flat_map(map).collect());
                moment_matrix(model, &mapped)?
            }
            (Criterion::I, Shape::Box(_)) => moment_matrix(model, problem.judged())?,
            _ => Vec::new(),
        };
        let table = shape
            .filter(|_| criterion == Criterion::G)
            .map(|shape| Table::of(&products, &judged_lattice(problem, shape, &products)));
        let regressors = Regressors::of(model);
        let multiplicities = problem.multiplicities();
        Ok(Self { criterion, regressors, products, fixed, multiplicities, moments, least_log_determinant, table })
    }

    pub(crate) fn n_terms(&self) -> usize {
        self.regressors.n_terms
    }

    pub(crate) fn n_factors(&self) -> usize {
        self.regressors.n_factors
    }

    /// M and M⁻¹ of all runs; none if singular. Regressors of the free runs are left in `rows`.
    pub(crate) fn invert(&self, x: &[f64], rows: &mut [f64], matrices: &mut Matrices) -> Option<f64> {
        let (p, k) = (self.n_terms(), self.n_factors());
        for (point, row) in x.chunks_exact(k).zip(rows.chunks_exact_mut(p)) {
            self.regressors.fill(point, row);
        }
        assemble(&self.fixed, rows, &self.multiplicities, p, matrices)
    }
}

/// p × p matrices that a search reuses.
#[derive(Debug, Clone)]
pub(crate) struct Matrices {
    pub(crate) information: Vec<f64>,
    pub(crate) inverse: Vec<f64>,
    factor: Vec<f64>,
    scratch: Vec<f64>,
}

impl Matrices {
    pub(crate) fn new(p: usize) -> Self {
        let zeros = vec![0.0; p * p];
        Self { information: zeros.clone(), inverse: zeros.clone(), factor: zeros.clone(), scratch: zeros }
    }
}

#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx+avx2"))]
fn assemble(fixed: &[f64], rows: &[f64], multiplicities: &[f64], p: usize, matrices: &mut Matrices) -> Option<f64> {
    let information = &mut matrices.information;
    information.copy_from_slice(fixed);
    for (row, &multiplicity) in rows.chunks_exact(p).zip(multiplicities) {
        add_outer(information, p, multiplicity, row);
    }
    matrices.factor.copy_from_slice(information);
    let log_determinant = cholesky(&mut matrices.factor, p, PIVOT_FLOOR)?;
    inverse_of_factor(&matrices.factor, p, &mut matrices.inverse, &mut matrices.scratch);
    Some(log_determinant)
}

/// Levels per axis of the lattice on which the prediction variance is smoothed: enough to see its maxima, few enough to
/// be quick. With more factors nearly all maxima are on −1, 0, 1.
fn lattice_levels(n_factors: usize) -> usize {
    match n_factors {
        1 => 33,
        2 => 9,
        3 => 5,
        _ => 3,
    }
}

/// A lattice of more points has only the ends of the axes along which v is convex.
const MOST_WITH_MIDDLES: f64 = 729.0;

/// The points that G looks at first: a grid to judge over as a whole, or the lattice of the box.
pub(crate) fn judged_lattice(problem: &Problem, relaxed: &BoxShape, products: &Products) -> Lattice {
    match problem.judged_grid() {
        Some(grid) => Lattice::whole(grid).without_forbidden(grid),
        None => lattice(relaxed, products),
    }
}

pub(crate) fn lattice(shape: &BoxShape, products: &Products) -> Lattice {
    let k = shape.axes.len();
    let levels = lattice_levels(k);
    if power(levels as f64, k as u32) <= MOST_WITH_MIDDLES {
        return Lattice::with_levels(shape, levels);
    }
    Lattice::with_counts(shape, |axis| if products.is_convex_along(axis) { 2 } else { levels })
}
