//! The largest value of a polynomial on an interval.

/// Value at x, coefficients from the constant up.
#[inline]
pub(crate) fn value(coefficients: &[f64], x: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c)
}

/// What [`uphill`] is compared with: where the polynomial is largest within `[a, b]`, and its value there; of equals, the lowest end first.
#[cfg(test)]
pub(crate) fn maximum(coefficients: &[f64], [a, b]: [f64; 2]) -> (f64, f64) {
    let mut best = (a, value(coefficients, a));
    let mut consider = |x: f64| {
        let height = value(coefficients, x);
        if height > best.1 {
            best = (x, height);
        }
    };
    consider(b);
    let slope = derivative(coefficients);
    roots(&slope, [a, b]).into_iter().for_each(consider);
    best
}

/// The local maximum that lies uphill of x within `[a, b]`, and its value there; x itself if it is one.
pub(crate) fn uphill(coefficients: &[f64], [a, b]: [f64; 2], x: f64) -> (f64, f64) {
    let mut nodes = vec![a];
    nodes.extend(roots(&derivative(coefficients), [a, b]));
    nodes.push(b);
    // Between x and the nearest turn on each side the polynomial is monotonic.
    let below = nodes.iter().copied().rfind(|node| *node < x - 1e-13);
    let above = nodes.iter().copied().find(|node| *node > x + 1e-13);
    let mut best = (x, value(coefficients, x));
    for node in below.into_iter().chain(above) {
        let height = value(coefficients, node);
        if height > best.1 {
            best = (node, height);
        }
    }
    best
}

/// Slope at x, coefficients from the constant up.
pub(crate) fn slope(coefficients: &[f64], x: f64) -> f64 {
    coefficients.iter().enumerate().skip(1).rev().fold(0.0, |sum, (power, c)| sum * x + power as f64 * c)
}

fn derivative(coefficients: &[f64]) -> Vec<f64> {
    coefficients.iter().enumerate().skip(1).map(|(power, c)| power as f64 * c).collect()
}

/// The places within `(a, b)` where the polynomial changes its sign: between neighboring extremes it is monotonic,
/// so the roots of the derivative bracket them, degree by degree.
fn roots(coefficients: &[f64], [a, b]: [f64; 2]) -> Vec<f64> {
    let Some(degree) = coefficients.iter().rposition(|&c| c != 0.0) else {
        return Vec::new();
    };
    let coefficients = &coefficients[..=degree];
    match *coefficients {
        [] | [_] => Vec::new(),
        [c, s] => {
            let root = -c / s;
            if a < root && root < b { vec![root] } else { Vec::new() }
        }
        [c, half, s] => {
            let discriminant = half * half - 4.0 * s * c;
            if discriminant <= 0.0 {
                return Vec::new();
            }
            // The sum without cancellation first, the other root from the product of both.
            let sum = -0.5 * (half + half.signum() * discriminant.sqrt());
            let mut both = [sum / s, c / sum];
            both.sort_by(f64::total_cmp);
            both.into_iter().filter(|root| a < *root && *root < b).collect()
        }
        _ => {
            let slope = derivative(coefficients);
            let mut ends = vec![a];
            ends.extend(roots(&slope, [a, b]));
            ends.push(b);
            ends.windows(2).filter_map(|pair| bracketed(coefficients, &slope, pair[0], pair[1])).collect()
        }
    }
}

/// The root between two ends of different signs: Newton's steps, halving where they leave the bracket.
fn bracketed(coefficients: &[f64], slope: &[f64], mut a: f64, mut b: f64) -> Option<f64> {
    let (at_a, at_b) = (value(coefficients, a), value(coefficients, b));
    if !(at_a < 0.0 && at_b > 0.0 || at_a > 0.0 && at_b < 0.0) {
        return None;
    }
    let mut x = 0.5 * (a + b);
    for _ in 0..60 {
        let height = value(coefficients, x);
        if (height < 0.0) == (at_a < 0.0) {
            a = x;
        } else {
            b = x;
        }
        let newton = x - height / value(slope, x);
        let next = if a < newton && newton < b { newton } else { 0.5 * (a + b) };
        if (next - x).abs() <= 1e-15 * (1.0 + x.abs()) {
            return Some(next);
        }
        x = next;
    }
    Some(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The polynomial with these roots and leading coefficient 1.
    fn with_roots(roots: &[f64]) -> Vec<f64> {
        roots.iter().fold(vec![1.0], |polynomial, root| {
            let mut next = vec![0.0; polynomial.len() + 1];
            for (power, c) in polynomial.iter().enumerate() {
                next[power + 1] += c;
                next[power] -= root * c;
            }
            next
        })
    }

    #[test]
    fn planted_roots_are_found() {
        for planted in [&[0.3][..], &[-0.5, 0.25], &[-0.9, 0.1, 0.8], &[-0.7, -0.2, 0.4, 0.6, 0.95]] {
            let found = roots(&with_roots(planted), [-1.0, 1.0]);
            assert_eq!(found.len(), planted.len(), "{found:?}");
            assert!(found.iter().zip(planted).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?} is not {planted:?}");
        }
    }

    #[test]
    fn roots_at_the_very_ends_are_not_within() {
        for sign in [1.0, -1.0] {
            let cubic: Vec<f64> = with_roots(&[-1.0, 0.25, 1.0]).iter().map(|c| sign * c).collect();
            let found = roots(&cubic, [-1.0, 1.0]);
            assert!(found.len() == 1 && (found[0] - 0.25).abs() < 1e-12, "{found:?}");
        }
    }

    #[test]
    fn uphill_does_not_jump_to_a_higher_hump() {
        // −(x² − 1/4)² + x/10 has humps near −1/2 and 1/2, the right one higher.
        let hills = [-0.0625, 0.1, 0.5, 0.0, -1.0];
        let (left, _) = uphill(&hills, [-1.0, 1.0], -0.3);
        let (right, height) = uphill(&hills, [-1.0, 1.0], 0.9);
        assert!((-0.5..-0.3).contains(&left) && (0.5..0.6).contains(&right), "{left} {right}");
        assert_eq!(maximum(&hills, [-1.0, 1.0]), (right, height));
        assert!((uphill(&hills, [-1.0, 1.0], left).0 - left).abs() < 1e-12, "a maximum stays");
    }

    #[test]
    fn the_largest_of_ends_and_middle_is_found() {
        // 1 - x² + x⁴ is largest at both ends and has the middle root as a lower maximum.
        assert_eq!(maximum(&[1.0, 0.0, -1.0, 0.0, 1.0], [-1.0, 1.0]), (-1.0, 1.0));
        assert_eq!(maximum(&[1.0, 0.0, -4.0, 0.0, 1.0], [-1.0, 1.0]), (0.0, 1.0));
        let (at, height) = maximum(&[0.0, 1.0, -1.0, 0.0, 0.0], [-1.0, 1.0]);
        assert!((at - 0.5).abs() < 1e-12 && (height - 0.25).abs() < 1e-12, "x - x² at 1/2");
        assert_eq!(maximum(&[2.0], [-1.0, 1.0]), (-1.0, 2.0));
        assert_eq!(maximum(&[2.0, 0.0, 0.0, 0.0, 0.0], [-0.5, 1.0]), (-0.5, 2.0));
    }
}
