//! Fewer points for the same picture.

/// More points than this do not show at the width of a figure.
pub(super) const MAX_POINTS: usize = 600;

/// At most about `max` of the points, the first, the last and every local extreme among them.
///
/// The points are cut into equal runs, and each run keeps its lowest and its highest.
pub(super) fn thin(points: &[(f64, f64)], max: usize) -> Vec<(f64, f64)> {
    if points.len() <= max.max(4) {
        return points.to_vec();
    }
    let inner = &points[1..points.len() - 1];
    let run = inner.len().div_ceil((max.max(4) - 2) / 2);
    let mut thinned = vec![points[0]];
    for run in inner.chunks(run) {
        let lowest = (0..run.len()).min_by(|&i, &j| run[i].1.total_cmp(&run[j].1));
        let highest = (0..run.len()).max_by(|&i, &j| run[i].1.total_cmp(&run[j].1));
        let (Some(lowest), Some(highest)) = (lowest, highest) else {
            continue;
        };
        thinned.push(run[lowest.min(highest)]);
        if lowest != highest {
            thinned.push(run[lowest.max(highest)]);
        }
    }
    thinned.push(points[points.len() - 1]);
    thinned
}

/// Of a series that holds its value, the points where the value changes, the first and the last.
pub(super) fn changes(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let last = points.len().saturating_sub(1);
    (0..points.len())
        .filter(|&i| i == 0 || i == last || points[i].1.to_bits() != points[i - 1].1.to_bits())
        .map(|i| points[i])
        .collect()
}

/// The stretches without a value that is not finite.
pub(super) fn finite_stretches(points: &[(f64, f64)]) -> Vec<&[(f64, f64)]> {
    points.split(|(x, y)| !(x.is_finite() && y.is_finite())).filter(|stretch| !stretch.is_empty()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave(n: usize) -> Vec<(f64, f64)> {
        (0..n).map(|i| (i as f64, (i as f64 * 0.7).sin())).collect()
    }

    #[test]
    fn short_series_are_left_alone() {
        assert_eq!(thin(&wave(100), 100).len(), 100);
    }

    #[test]
    fn thinning_keeps_ends_extremes_and_order() {
        let mut points = wave(12_001);
        points[7_777].1 = 9.0;
        points[3_333].1 = -9.0;
        let thinned = thin(&points, MAX_POINTS);
        assert!(thinned.len() <= MAX_POINTS, "{}", thinned.len());
        for kept in [points[0], points[12_000], points[7_777], points[3_333]] {
            assert!(thinned.contains(&kept), "{kept:?}");
        }
        assert!(thinned.windows(2).all(|pair| pair[0].0 < pair[1].0), "in order");
    }

    #[test]
    fn held_values_need_only_their_changes() {
        let points: Vec<_> = (0..300).map(|i| (f64::from(i), f64::from(i / 100))).collect();
        assert_eq!(changes(&points), [(0.0, 0.0), (100.0, 1.0), (200.0, 2.0), (299.0, 2.0)]);
        assert!(changes(&[]).is_empty(), "nothing from nothing");
    }

    #[test]
    fn gaps_split_a_series() {
        let points = [(0.0, 1.0), (1.0, f64::NAN), (2.0, 3.0), (3.0, 4.0)];
        let stretches = finite_stretches(&points);
        assert_eq!(stretches.iter().map(|stretch| stretch.len()).collect::<Vec<_>>(), [1, 2]);
    }
}
