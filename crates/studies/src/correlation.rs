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

/// Values less their mean, for correlations with many others.
#[derive(Clone, Debug)]
pub(crate) struct Centered {
    values: Vec<f64>,
    sum_of_squares: f64,
}

impl Centered {
    pub(crate) fn of(values: &[f64]) -> Self {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let values: Vec<f64> = values.iter().map(|value| value - mean).collect();
        let sum_of_squares = values.iter().map(|value| value * value).sum();
        Self { values, sum_of_squares }
    }

    /// Pearson's; 0 where one does not vary.
    pub(crate) fn correlation(&self, other: &Self) -> f64 {
        let (own, others) = (self.sum_of_squares, other.sum_of_squares);
        if own > 0.0 && others > 0.0 { self.product(other) / (own * others).sqrt() } else { 0.0 }
    }

    /// Without iterators: this is compiled without optimization, and called millions of times.
    fn product(&self, other: &Self) -> f64 {
        let (own, others) = (self.values.as_slice(), other.values.as_slice());
        let (mut sum, mut k, n) = (-0.0, 0, own.len().min(others.len()));
        while k < n {
            sum += own[k] * others[k];
            k += 1;
        }
        sum
    }
}

/// Pearson's; 0 where one does not vary.
pub(crate) fn correlation(a: &[f64], b: &[f64]) -> f64 {
    Centered::of(a).correlation(&Centered::of(b))
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
