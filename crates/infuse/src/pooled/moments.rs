//! Moments of a few numbers.

/// Mean and standard deviation, over all of them.
pub(crate) fn mean_and_deviation(values: &[f64]) -> [f64; 2] {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    [mean, (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / n).sqrt()]
}

/// 0 where either is constant.
pub(crate) fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let mean = |values: &[f64]| values.iter().map(|value| value / values.len() as f64).sum::<f64>();
    let (mean_a, mean_b) = (mean(a), mean(b));
    let [mut aa, mut ab, mut bb] = [0.0; 3];
    for (x, y) in a.iter().zip(b) {
        let (x, y) = (x - mean_a, y - mean_b);
        aa += x * x;
        ab += x * y;
        bb += y * y;
    }
    let product = aa * bb;
    if product > 0.0 { (ab / product.sqrt()).clamp(-1.0, 1.0) } else { 0.0 }
}
