//! Ranks, and how far two rows of numbers go together.

/// Ranks from 0, equal values with their mean rank.
pub(crate) fn ranks(values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
    let mut ranks = vec![0.0; values.len()];
    let mut first = 0;
    for same in order.chunk_by(|a, b| values[*a].total_cmp(&values[*b]).is_eq()) {
        let mean = first as f64 + (same.len() - 1) as f64 / 2.0;
        same.iter().for_each(|index| ranks[*index] = mean);
        first += same.len();
    }
    ranks
}

/// Spearman's.
pub(crate) fn rank_correlation(a: &[f64], b: &[f64]) -> f64 {
    correlation(&ranks(a), &ranks(b))
}

/// Pearson's; 0 where one does not vary.
pub(crate) fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let (ma, mb) = (mean(a), mean(b));
    let sum = |of: &dyn Fn(f64, f64) -> f64| a.iter().zip(b).map(|(x, y)| of(x - ma, y - mb)).sum::<f64>();
    let (aa, bb) = (sum(&|x, _| x * x), sum(&|_, y| y * y));
    if aa > 0.0 && bb > 0.0 { sum(&|x, y| x * y) / (aa * bb).sqrt() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rank_correlation_is_that_of_scipy() {
        for (a, b, expected) in [
            // scipy.stats.spearmanr(a, b).statistic
            ([1.0, 2.0, 2.0, 4.0, 7.0], [3.0, 1.0, 4.0, 4.0, 9.0], 0.763_157_894_736_842),
            ([1.0, 2.0, 3.0, 4.0, 5.0], [5.0, 6.0, 7.0, 8.0, 7.5], 0.9),
            ([1.0, 2.0, 3.0, 4.0, 5.0], [0.9, 0.7, 0.2, 0.1, 0.0], -1.0),
        ] {
            let found = rank_correlation(&a, &b);
            assert!((found - expected).abs() < 1e-12, "{found}");
        }
        assert!(correlation(&[1.0, 1.0], &[2.0, 3.0]) == 0.0);
    }
}
