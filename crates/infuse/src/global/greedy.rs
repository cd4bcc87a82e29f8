//! A design built run by run, for when the search finds none.

use design_space::Model;

/// Which of these points to run, as indices: all different, `n_runs` of them, at least as many as the model has terms.
///
/// The first runs pivot: each adds most to the determinant of the information, terms scaled to their largest values. After
/// them the regressors are, in another basis, the Lagrange polynomials of the runs, so their information is the identity
/// and nothing is lost by rounding. Each further run goes where the prediction variance is largest.
/// Of equals the first is taken. None if the points do not support the model.
pub(crate) fn greedy(model: &Model, coordinates: &[f64], n_runs: usize) -> Option<Vec<usize>> {
    let p = model.n_terms();
    let mut rows = regressors(model, coordinates);
    let mut runs = Vec::with_capacity(n_runs);
    let mut is_open = vec![true; p];
    for _ in 0..p {
        let (run, term, pivot) = pivot(&rows, &is_open)?;
        eliminate(&mut rows, run, term, pivot, p);
        is_open[term] = false;
        runs.push(run);
    }

    let mut variances: Vec<f64> = rows.chunks_exact(p).map(|row| dot(row, row)).collect();
    let mut inverse: Vec<f64> = (0..p * p).map(|at| if at % (p + 1) == 0 { 1.0 } else { 0.0 }).collect();
    let mut is_free = vec![true; variances.len()];
    runs.iter().for_each(|&run| is_free[run] = false);
    while runs.len() < n_runs {
        let run = first_largest((0..variances.len()).filter(|&at| is_free[at]), |at| variances[at])?;
        is_free[run] = false;
        runs.push(run);
        // (M + r r')⁻¹ = M⁻¹ − u u'/(1 + r'u), u = M⁻¹ r.
        let chosen = &rows[run * p..][..p];
        let u: Vec<f64> = inverse.chunks_exact(p).map(|row| dot(row, chosen)).collect();
        let rest = 1.0 + dot(chosen, &u);
        for (variance, row) in variances.iter_mut().zip(rows.chunks_exact(p)) {
            *variance -= dot(row, &u).powi(2) / rest;
        }
        for (row, &factor) in inverse.chunks_exact_mut(p).zip(&u) {
            row.iter_mut().zip(&u).for_each(|(value, other)| *value -= factor * other / rest);
        }
    }
    Some(runs)
}

/// One row per point, terms scaled to a largest magnitude of 1.
fn regressors(model: &Model, coordinates: &[f64]) -> Vec<f64> {
    let points = || coordinates.chunks_exact(model.n_factors());
    let scale =
        |term: &design_space::Term| points().map(|point| term.value(point).abs()).fold(f64::MIN_POSITIVE, f64::max);
    let scales: Vec<f64> = model.terms().iter().map(scale).collect();
    let row = |point| model.terms().iter().zip(&scales).map(move |(term, scale)| term.value(point) / scale);
    points().flat_map(row).collect()
}

/// The largest magnitude among the terms that have no run yet: its point, its term, and its value.
fn pivot(rows: &[f64], is_open: &[bool]) -> Option<(usize, usize, f64)> {
    let p = is_open.len();
    let open = (0..rows.len()).filter(|at| is_open[at % p]);
    let at = first_largest(open, |at| rows[at].abs())?;
    (rows[at].abs() > 0.0).then(|| (at / p, at % p, rows[at]))
}

/// Changes the basis so that at this point one term is 1 and the others are 0.
fn eliminate(rows: &mut [f64], run: usize, term: usize, pivot: f64, p: usize) {
    let chosen: Vec<f64> = rows[run * p..][..p].iter().map(|value| value / pivot).collect();
    for row in rows.chunks_exact_mut(p) {
        let factor = row[term];
        row.iter_mut().zip(&chosen).for_each(|(value, other)| *value -= factor * other);
        row[term] = factor / pivot;
    }
}

fn first_largest(places: impl Iterator<Item = usize>, value: impl Fn(usize) -> f64) -> Option<usize> {
    let larger = |best: (usize, f64), next: (usize, f64)| if next.1 > best.1 { next } else { best };
    places.map(|at| (at, value(at))).reduce(larger).map(|(at, _)| at)
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use design_space::Model;
    use doe::{Criterion, Design, Space};

    use super::greedy;

    /// Levels 8 and 9 of ten of the second factor in full, level 4 in two cells.
    fn rare_level() -> Vec<f64> {
        let level = |digit: u32, count: u32| 2.0 * f64::from(digit) / f64::from(count - 1) - 1.0;
        let full = (0..12).flat_map(|a| [8, 9].into_iter().flat_map(move |b| (0..12).map(move |c| [a, b, c])));
        let cells = full.chain([[3, 4, 2], [9, 4, 7]]);
        cells.flat_map(|[a, b, c]| [level(a, 12), level(b, 10), level(c, 12)]).collect()
    }

    #[test]
    fn a_level_in_two_of_290_cells_is_found() {
        let (model, cells) = (Model::quadratic(3).unwrap(), rare_level());
        assert_eq!(cells.len(), 3 * 290);
        let runs = greedy(&model, &cells, 14).unwrap();
        let mut sorted = runs.clone();
        sorted.sort_unstable();
        sorted.dedup();
        assert_eq!(sorted.len(), 14, "all different");
        assert!(runs.contains(&288) && runs.contains(&289), "one alone cannot tell the level from the rest: {runs:?}");
        let points: Vec<Vec<f64>> = runs.iter().map(|&run| cells[3 * run..][..3].to_vec()).collect();
        let space = Space::list(3, cells).unwrap();
        let efficiency = Criterion::G.efficiency(&model, &space, &Design::from_runs(&points).unwrap()).unwrap();
        assert!(efficiency.percent > 20.0, "{efficiency:?}");
    }

    #[test]
    fn on_a_square_the_corners_come_first() {
        let axis = [-1.0, -0.5, 0.0, 0.5, 1.0];
        let cells: Vec<f64> = axis.iter().flat_map(|&a| axis.iter().flat_map(move |&b| [a, b])).collect();
        let terms = [[0, 0], [1, 0], [0, 1], [1, 1]].map(design_space::Term::new).to_vec();
        let mut runs = greedy(&Model::new(2, terms).unwrap(), &cells, 4).unwrap();
        runs.sort_unstable();
        assert_eq!(runs, [0, 4, 20, 24]);
    }

    /// After the ends the variance of a straight line is largest beside them, and a run on one side lowers it there.
    #[test]
    fn each_run_after_the_first_goes_where_the_variance_is_largest() {
        let line: Vec<f64> = (-10..=10_i32).map(|i| f64::from(i) / 10.0).collect();
        let mut runs = greedy(&Model::linear(1).unwrap(), &line, 6).unwrap();
        runs.sort_unstable();
        assert_eq!(runs, [0, 1, 2, 18, 19, 20]);
    }

    /// Beside one end are two more points, beside the other is one that lies farther off: a run at the first of the two lowers
    /// the variance of the second below that of the other side.
    #[test]
    fn a_run_lowers_the_variance_of_its_neighbors() {
        assert_eq!(greedy(&Model::linear(1).unwrap(), &[-1.0, -0.99, -0.98, 0.9, 1.0], 4), Some(vec![0, 4, 1, 3]));
    }

    #[test]
    fn points_that_do_not_support_the_model_give_none() {
        assert_eq!(greedy(&Model::quadratic(1).unwrap(), &[-1.0, 1.0, -1.0, 1.0], 3), None);
    }
}
