//! The one of many points that is nearest to all others.

/// A point by its place among all.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Medoid {
    pub(super) index: usize,
    /// To all other points.
    pub(super) mean_distance: f64,
}

/// Mean Euclidean distance of each point to all others; NaN of a point that is alone.
pub(super) fn mean_distances(points: &[Vec<f64>]) -> Vec<f64> {
    let distance = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
    let others = points.len() as f64 - 1.0;
    points.iter().map(|a| points.iter().map(|b| distance(a, b)).sum::<f64>() / others).collect()
}

/// The point with the least mean Euclidean distance to all others, of several the first; none where there are no two points.
pub(super) fn medoid(points: &[Vec<f64>]) -> Option<Medoid> {
    let found = mean_distances(points).into_iter().enumerate().filter(|(_, mean)| mean.is_finite());
    let (index, mean_distance) = found.min_by(|a, b| a.1.total_cmp(&b.1))?;
    Some(Medoid { index, mean_distance })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points<const N: usize>(points: &[[f64; N]]) -> Vec<Vec<f64>> {
        points.iter().map(|point| point.to_vec()).collect()
    }

    /// On a line the sum of distances is least at the median, wherever the others are.
    #[test]
    fn on_a_line_it_is_the_median() {
        let found = medoid(&points(&[[10.0], [0.0], [2.0], [3.0], [1.0]]));
        assert_eq!(found, Some(Medoid { index: 2, mean_distance: (8.0 + 2.0 + 1.0 + 1.0) / 4.0 }));
    }

    /// Sides of 3, 4 and 5: the sums are 7, 8 and 9.
    #[test]
    fn in_a_right_triangle_it_is_the_right_angle() {
        let triangle = points(&[[3.0, 0.0], [0.0, 4.0], [0.0, 0.0]]);
        assert_eq!(mean_distances(&triangle), [4.0, 4.5, 3.5]);
        assert_eq!(medoid(&triangle), Some(Medoid { index: 2, mean_distance: 3.5 }));
    }

    #[test]
    fn of_equals_it_is_the_first() {
        let square = points(&[[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]]);
        assert_eq!(medoid(&square).map(|found| found.index), Some(0));
    }

    #[test]
    fn there_is_none_of_fewer_than_two() {
        assert_eq!(medoid(&[]), None);
        assert_eq!(medoid(&points(&[[1.0, 2.0]])), None);
    }
}
