//! What an average by inverse squared distances can't do without, four fractions with one denominator at a time: sums, products and
//! divisions of numbers that stay in registers.

use std::hint::black_box;

use multiversion::multiversion;
use rayon::prelude::*;

/// Points side by side, as on a grid.
const WIDTH: usize = 8;
/// Groups of four for 54 data.
const GROUPS: usize = 14;
/// All points of 24 levels in four factors, in parts.
const BLOCKS: usize = 331_776 / WIDTH;
const PARTS: usize = 64;

/// For as many points and data as the task on the grid has; a sum of all averages.
pub(super) fn fractions() -> f64 {
    let part = |_| fractions_of(black_box(BLOCKS / PARTS), &black_box([0.9, 1.1, 1.3, 1.2])).iter().sum::<f64>();
    (0..PARTS).into_par_iter().map(part).collect::<Vec<f64>>().iter().sum()
}

/// Σ (Σ J/q) / (Σ 1/q); each datum takes one sum to its squared distance.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx+avx2"))]
fn fractions_of(n_blocks: usize, values: &[f64; 4]) -> [f64; WIDTH] {
    let [va, vb, vc, vd] = *values;
    let mut averages = [0.0; WIDTH];
    let mut squares = [[1.0; WIDTH], [1.1; WIDTH], [1.2; WIDTH], [1.3; WIDTH]];
    for _ in 0..n_blocks {
        let (mut totals, mut sums, mut least) = ([0.0; WIDTH], [0.0; WIDTH], [f64::INFINITY; WIDTH]);
        for _ in 0..GROUPS {
            for lane in 0..WIDTH {
                for (square, value) in squares.iter_mut().zip(values) {
                    square[lane] += 1e-9 * value;
                }
            }
            for lane in 0..WIDTH {
                let [a, b, c, d] = [squares[0][lane], squares[1][lane], squares[2][lane], squares[3][lane]];
                let (ab, cd) = (a * b, c * d);
                let denominator = ab * cd;
                let inverse = 1.0 / denominator;
                totals[lane] += inverse * ((b + a) * cd + (d + c) * ab);
                sums[lane] += inverse * ((va * b + vb * a) * cd + (vc * d + vd * c) * ab);
                least[lane] = if denominator < least[lane] { denominator } else { least[lane] };
            }
        }
        for lane in 0..WIDTH {
            averages[lane] += if least[lane] > 0.0 { sums[lane] / totals[lane] } else { 0.0 };
        }
    }
    averages
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Where all squares are nearly equal, each average is the mean of the values.
    #[test]
    fn an_average_of_nearly_equal_distances_is_a_mean() {
        for average in fractions_of(5, &[1.0, 2.0, 3.0, 6.0]) {
            let expected = 5.0 * (1.0 + 2.0 / 1.1 + 3.0 / 1.2 + 6.0 / 1.3) / (1.0 + 1.0 / 1.1 + 1.0 / 1.2 + 1.0 / 1.3);
            assert!((average - expected).abs() < 1e-4, "{average} {expected}");
        }
    }
}
