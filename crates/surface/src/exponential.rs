//! The exponential function without a branch and without a call.
//!
//! The platform's own differs between machines and has no lane form; this one is compiled into the lanes of the
//! squared-exponential surface and gives the same bits in any number of them.

/// Below this argument the result counts as zero; it is then less than 3.4e-308.
pub(crate) const SMALLEST_ARGUMENT: f64 = -708.0;

/// Adding it rounds to the nearest integer, ties to even, and leaves that integer in the lowest bits.
const ROUND: f64 = 6_755_399_441_055_744.0;
/// ln 2 in two parts: the first has 32 significant bits, so its product with an exponent is exact.
const LN_2_HIGH: f64 = 0.693_147_180_369_123_8;
const LN_2_LOW: f64 = 1.908_214_929_270_587_7e-10;

/// (exp(r) − 1 − r)/r² for |r| ≤ ln 2 / 2, interpolated at Chebyshev nodes with 40 digits; 1.6e-17 of exp(r) off.
const COEFFICIENTS: [f64; 10] = [
    0.500_000_000_000_000_1,
    0.166_666_666_666_666_69,
    0.041_666_666_666_624_13,
    0.008_333_333_333_330_062,
    0.001_388_888_891_721_371_7,
    1.984_126_986_305_361_8e-4,
    2.480_152_129_595_437_6e-5,
    2.755_726_845_999_706_4e-6,
    2.762_008_844_540_974_6e-7,
    2.510_038_549_551_032e-8,
];

/// exp(z) for z ≤ 0, within one unit in the last place; 0 below [`SMALLEST_ARGUMENT`], not meant for NaN.
#[inline(always)]
pub(crate) fn exp_of_negative(z: f64) -> f64 {
    exp_of_minus(&[[-z]])[0][0]
}

/// exp(−e) for several e ≥ 0, the same bits. All go step by step: each step waits for the one before, and those of others fill
/// the time.
#[inline(always)]
pub(crate) fn exp_of_minus<const L: usize, const N: usize>(e: &[[f64; L]; N]) -> [[f64; L]; N] {
    let (mut shifted, mut r) = ([[0.0; L]; N], [[0.0; L]; N]);
    for row in 0..N {
        for lane in 0..L {
            shifted[row][lane] = e[row][lane] * -std::f64::consts::LOG2_E + ROUND;
            let minus_n = ROUND - shifted[row][lane];
            r[row][lane] = minus_n * LN_2_LOW + (minus_n * LN_2_HIGH - e[row][lane]);
        }
    }
    let mut q = polynomial(&COEFFICIENTS, &r, |a, b, c| a * b + c);
    for row in 0..N {
        for lane in 0..L {
            let r = r[row][lane];
            let mantissa = 1.0 + (r * r * q[row][lane] + r);
            let value = times_power_of_two(mantissa, shifted[row][lane]);
            q[row][lane] = if e[row][lane] <= -SMALLEST_ARGUMENT { value } else { 0.0 };
        }
    }
    q
}

/// (2^r − 1)/r for |r| ≤ 1/2, interpolated at Chebyshev nodes with 40 digits; 3.7e-14 of 2^r off.
const SHORTER: [f64; 9] = [
    std::f64::consts::LN_2,
    0.240_226_506_958_129_9,
    0.055_504_108_664_760_424,
    0.009_618_129_159_402_558,
    0.001_333_355_817_904_311_2,
    1.540_345_585_245_383_8e-4,
    1.525_268_684_626_772e-5,
    1.325_522_487_866_881_7e-6,
    1.020_312_106_339_172_9e-7,
];
/// Beyond this power of two the result stays what it is there, 1e-307.
const SMALLEST_POWER: f64 = 1020.0;

/// exp(−rate s) for several s ≥ 0, to thirteen digits, in as few steps as that takes; what is below 1e-307 counts as that. A product and a
/// sum are rounded once together: to be compiled for machines that have an instruction for that, on others it gives the same bits, slowly.
#[inline(always)]
pub(crate) fn short_exp_of_minus<const L: usize, const N: usize>(rate: f64, s: &[[f64; L]; N]) -> [[f64; L]; N] {
    let per_power = rate * std::f64::consts::LOG2_E;
    let most = SMALLEST_POWER / per_power;
    let (mut shifted, mut r) = ([[0.0; L]; N], [[0.0; L]; N]);
    for row in 0..N {
        for lane in 0..L {
            let s = if s[row][lane] < most { s[row][lane] } else { most };
            shifted[row][lane] = s.mul_add(-per_power, ROUND);
            let minus_n = ROUND - shifted[row][lane];
            r[row][lane] = s.mul_add(-per_power, minus_n);
        }
    }
    let mut q = polynomial(&SHORTER, &r, f64::mul_add);
    for row in 0..N {
        for lane in 0..L {
            let mantissa = q[row][lane].mul_add(r[row][lane], 1.0);
            q[row][lane] = times_power_of_two(mantissa, shifted[row][lane]);
        }
    }
    q
}

/// A polynomial of each number, by its coefficients, the constant first, and by how a product and a sum are rounded.
#[inline(always)]
fn polynomial<const L: usize, const N: usize, const M: usize>(
    coefficients: &[f64; M],
    r: &[[f64; L]; N],
    times_plus: impl Fn(f64, f64, f64) -> f64,
) -> [[f64; L]; N] {
    let mut q = [[coefficients[M - 1]; L]; N];
    // A loop that the compiler knows all of is written out by it, lane by lane.
    for &coefficient in std::hint::black_box(&coefficients[..M - 1]).iter().rev() {
        for row in 0..N {
            for lane in 0..L {
                q[row][lane] = times_plus(q[row][lane], r[row][lane], coefficient);
            }
        }
    }
    q
}

/// A number times two to the power of an integer, which sits in the lowest bits of `shifted`: exponents add.
#[inline(always)]
fn times_power_of_two(mantissa: f64, shifted: f64) -> f64 {
    f64::from_bits(mantissa.to_bits().wrapping_add(shifted.to_bits() << 52))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponential_is_within_one_unit_in_the_last_place_of_the_platform_s() {
        let mut largest = 0;
        for step in 0..=2_000_000_u32 {
            let z = -708.0 * (f64::from(step) / 2e6).powi(3);
            largest = largest.max(exp_of_negative(z).to_bits().abs_diff(z.exp().to_bits()));
        }
        assert!(largest <= 1, "{largest} units in the last place");
    }

    /// The digits of the argument count, too: at 700 its last one is worth 1e-13.
    #[test]
    fn short_exponential_agrees_with_the_platform_s_to_thirteen_digits() {
        for rate in [1.0, 2.3e-7, 1.9e5] {
            let off = |step: u32| {
                let z = 700.0 * (f64::from(step) / 2e5).powi(3);
                let [[found]] = short_exp_of_minus(rate, &[[z / rate]]);
                (found / (-z).exp() - 1.0).abs() / (4e-14 + 4.0 * f64::EPSILON * z)
            };
            let largest = (0..=200_000).map(off).fold(0.0, f64::max);
            assert!(largest < 1.0, "{largest} of what is allowed, rate {rate}");
        }
    }

    #[test]
    fn short_exponential_is_exact_at_zero_and_next_to_nothing_far_below() {
        let of = |rate, s| short_exp_of_minus(rate, &[[s]])[0][0];
        assert_eq!([of(1.0, 0.0), of(1e200, 0.0), of(1e-200, 0.0)].map(f64::to_bits), [1.0_f64.to_bits(); 3]);
        for s in [708.0, 1e10, f64::MAX, f64::INFINITY, f64::NAN] {
            assert!((1e-308..1e-306).contains(&of(1.0, s)), "exp(-{s}) is {:e}", of(1.0, s));
        }
    }

    #[test]
    fn exponential_is_exact_at_zero_and_zero_far_below() {
        assert_eq!(exp_of_negative(0.0).to_bits(), 1.0_f64.to_bits());
        assert_eq!(exp_of_negative(-0.0).to_bits(), 1.0_f64.to_bits());
        for z in [-708.1, -745.0, -1e10, f64::MIN, f64::NEG_INFINITY] {
            assert_eq!(exp_of_negative(z).to_bits(), 0, "exp({z})");
        }
        assert!(exp_of_negative(-708.0) > 3e-308, "the smallest value is a normal number");
    }
}
