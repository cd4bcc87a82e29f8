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
    of_minus::<L, N, false>(e)
}

/// The same with a product and a sum rounded once together, to be compiled for machines that have an instruction for that: on others
/// it gives the same bits, slowly.
#[inline(always)]
pub(crate) fn fused_exp_of_minus<const L: usize, const N: usize>(e: &[[f64; L]; N]) -> [[f64; L]; N] {
    of_minus::<L, N, true>(e)
}

#[inline(always)]
fn of_minus<const L: usize, const N: usize, const FUSED: bool>(e: &[[f64; L]; N]) -> [[f64; L]; N] {
    let times_plus = |a: f64, b: f64, c: f64| if FUSED { a.mul_add(b, c) } else { a * b + c };
    let (mut shifted, mut r) = ([[0.0; L]; N], [[0.0; L]; N]);
    for row in 0..N {
        for lane in 0..L {
            shifted[row][lane] = times_plus(e[row][lane], -std::f64::consts::LOG2_E, ROUND);
            let minus_n = ROUND - shifted[row][lane];
            r[row][lane] = times_plus(minus_n, LN_2_LOW, times_plus(minus_n, LN_2_HIGH, -e[row][lane]));
        }
    }
    let mut q = [[COEFFICIENTS[9]; L]; N];
    // A loop that the compiler knows all of is written out by it, lane by lane.
    for &coefficient in std::hint::black_box(&COEFFICIENTS[..9]).iter().rev() {
        for row in 0..N {
            for lane in 0..L {
                q[row][lane] = times_plus(q[row][lane], r[row][lane], coefficient);
            }
        }
    }
    for row in 0..N {
        for lane in 0..L {
            let r = r[row][lane];
            let mantissa = 1.0 + times_plus(r * r, q[row][lane], r);
            // The exponent of the result is the sum of both: n sits in the lowest bits of the shifted number.
            let value = f64::from_bits(mantissa.to_bits().wrapping_add(shifted[row][lane].to_bits() << 52));
            q[row][lane] = if e[row][lane] <= -SMALLEST_ARGUMENT { value } else { 0.0 };
        }
    }
    q
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponential_is_within_one_unit_in_the_last_place_of_the_platform_s() {
        let mut largest = [0; 2];
        for step in 0..=2_000_000_u32 {
            let z = -708.0 * (f64::from(step) / 2e6).powi(3);
            let [[fused]] = fused_exp_of_minus(&[[-z]]);
            let of_both = [exp_of_negative(z), fused].map(|value| value.to_bits().abs_diff(z.exp().to_bits()));
            largest = std::array::from_fn(|form| largest[form].max(of_both[form]));
        }
        assert!(largest <= [1; 2], "{largest:?} units in the last place");
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
