//! Where a search begins: a small lattice, and which of its points are worth a descent.

/// A point in coded coordinates with its cost, or nothing where the simulation failed.
#[derive(Debug, Clone)]
pub(crate) struct Evaluated {
    pub(crate) coded: Vec<f64>,
    pub(crate) value: Option<f64>,
}

/// `n_points` points spread evenly over −1 to 1 in each of `n_axes` coordinates.
///
/// On the first axis the points are cell centers, so one axis has equal gaps; on axis j ≥ 1 they
/// follow the fractional parts of 1/2 + i α_j with α_j = φ^−j, where φ > 1 solves φ^n_axes = φ + 1
/// (the golden ratio for two axes). Deterministic, and any number of points serves any number of
/// axes.
pub(crate) fn lattice(n_axes: usize, n_points: usize) -> Vec<Vec<f64>> {
    let ratio = generalized_golden_ratio(n_axes);
    let count = n_points as f64;
    (0..n_points)
        .map(|point_idx| {
            let index = point_idx as f64;
            let mut step = 1.0;
            (0..n_axes)
                .map(|axis| {
                    let unit = if axis == 0 {
                        (index + 0.5) / count
                    } else {
                        step /= ratio;
                        (0.5 + index * step).fract()
                    };
                    2.0 * unit - 1.0
                })
                .collect()
        })
        .collect()
}

/// The root above 1 of x^n = x + 1, by a fixed number of bisections; 2 for one axis, where it is
/// not needed.
fn generalized_golden_ratio(n_axes: usize) -> f64 {
    let (mut low, mut high) = (1.0_f64, 2.0_f64);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        let power = (0..n_axes).fold(1.0, |product: f64, _| product * middle);
        if power > middle + 1.0 {
            high = middle;
        } else {
            low = middle;
        }
    }
    high
}

/// Which starts are worth a descent, best first: those with no better start within the linkage
/// radius, 1.3 times the mean gap of the lattice (after the multi-level single linkage of Rinnooy Kan
/// and Timmer, 1987). The first start is the warm one and counts like the others; a failed start is
/// worth nothing.
pub(crate) fn worth_a_descent(starts: &[Evaluated]) -> Vec<usize> {
    let Some(first) = starts.first() else {
        return Vec::new();
    };
    let n_lattice = (starts.len() - 1).max(1) as f64;
    let radius = 1.3 * 2.0 / n_lattice.powf(1.0 / first.coded.len() as f64);
    let mut finite: Vec<(usize, f64)> =
        starts.iter().enumerate().filter_map(|(index, start)| Some((index, start.value?))).collect();
    // Stable, so equal costs keep the order of the lattice.
    finite.sort_by(|a, b| a.1.total_cmp(&b.1));
    let mut chosen = Vec::new();
    for (rank, &(index, _)) in finite.iter().enumerate() {
        let linked =
            finite[..rank].iter().any(|&(better, _)| distance(&starts[better].coded, &starts[index].coded) < radius);
        if !linked {
            chosen.push(index);
        }
    }
    chosen
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b));
    squares.sum::<f64>().sqrt()
}
