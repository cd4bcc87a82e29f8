//! Sine, cosine and arc tangent without a branch, so that SIMD lanes and `f64` agree bit for bit.
//!
//! The platform's own functions differ between machines and have no lane form. These use the reduction
//! and the polynomials published with the freely distributable mathematics library fdlibm (`k_sin`,
//! `k_cos`, `s_atan`); the tests hold them against the platform's functions.

use crate::real::Real;

/// Adding and subtracting it rounds to the nearest integer (ties to even) for |x| < 2^51.
const ROUND: f64 = 6_755_399_441_055_744.0;

/// Even and odd powers apart: two chains of operations, each half as long as Horner's, run side by side.
#[inline(always)]
fn polynomial<T: Real, const N: usize>(x: T, coefficients: [f64; N]) -> T {
    let squared = x * x;
    let (mut k, mut first, mut second) = (N - 2, T::constant(coefficients[N - 1]), T::constant(coefficients[N - 2]));
    while k >= 2 {
        first = first * squared + T::constant(coefficients[k - 1]);
        second = second * squared + T::constant(coefficients[k - 2]);
        k -= 2;
    }
    if k == 1 {
        // N is odd: `first` then runs over the even powers, and the constant is still to come.
        first = first * squared + T::constant(coefficients[0]);
        first + x * second
    } else {
        second + x * first
    }
}

#[inline(always)]
fn round<T: Real>(x: T) -> T {
    (x + T::constant(ROUND)) - T::constant(ROUND)
}

/// Sine and cosine of `x` in rad.
#[inline(always)]
pub(crate) fn sin_cos<T: Real>(x: T) -> (T, T) {
    let c = T::constant;
    // x = n pi/2 + r, |r| <= pi/4, with pi/2 in three parts of 33 bits.
    let n = round(x * c(core::f64::consts::FRAC_2_PI));
    let r =
        ((x - n * c(1.570_796_326_734_125_6)) - n * c(6.077_100_506_303_966e-11)) - n * c(2.022_266_248_795_950_6e-21);
    let z = r * r;
    let sin_r = r + r
        * z
        * polynomial(
            z,
            [
                -1.666_666_666_666_663_2e-1,
                8.333_333_333_322_49e-3,
                -1.984_126_982_985_795e-4,
                2.755_731_370_707_006_8e-6,
                -2.505_076_025_340_686_4e-8,
                1.589_690_995_211_55e-10,
            ],
        );
    let cos_r = (c(1.0) - c(0.5) * z)
        + z * z
            * polynomial(
                z,
                [
                    4.166_666_666_666_66e-2,
                    -1.388_888_888_887_411e-3,
                    2.480_158_728_947_673e-5,
                    -2.755_731_435_139_066_3e-7,
                    2.087_572_321_298_175e-9,
                    -1.135_964_755_778_819_5e-11,
                ],
            );
    // The quarter turn m in {-2, -1, 0, 1, 2}: odd ones exchange sine and cosine.
    let m = n - c(4.0) * round(n * c(0.25));
    let m_abs = m.abs();
    let even = c(1.0) - m_abs;
    let odd_sin = m * cos_r;
    let odd_cos = -(m * sin_r);
    let near_two = m_abs.select_below(c(1.5), odd_sin, even * sin_r);
    let sin = m_abs.select_below(c(0.5), sin_r, near_two);
    let near_two = m_abs.select_below(c(1.5), odd_cos, even * cos_r);
    let cos = m_abs.select_below(c(0.5), cos_r, near_two);
    (sin, cos)
}

/// The angle of the point (`x`, `y`) in rad.
#[inline(always)]
pub(crate) fn atan2<T: Real>(y: T, x: T) -> T {
    let c = T::constant;
    let (y_abs, x_abs) = (y.abs(), x.abs());
    let small = y_abs.select_below(x_abs, y_abs, x_abs);
    let large = y_abs.select_below(x_abs, x_abs, y_abs);
    // atan(a/b) = pi/4 + atan((a - b)/(a + b)): the argument of the polynomial stays below tan(pi/8).
    let cut = c(0.414_213_562_373_095) * large;
    let numerator = cut.select_below(small, small - large, small);
    let denominator = cut.select_below(small, small + large, large);
    let base = cut.select_below(small, c(core::f64::consts::FRAC_PI_4), c(0.0));
    let t = numerator / denominator.max(c(f64::MIN_POSITIVE));
    let z = t * t;
    let series = z * polynomial(
        z,
        [
            3.333_333_333_333_293e-1,
            -1.999_999_999_987_648_3e-1,
            1.428_571_427_250_346_6e-1,
            -1.111_111_040_546_235_6e-1,
            9.090_887_133_436_507e-2,
            -7.691_876_205_044_83e-2,
            6.661_073_137_387_531e-2,
            -5.833_570_133_790_573_5e-2,
            4.976_877_994_615_932e-2,
            -3.653_157_274_421_691_6e-2,
            1.628_582_011_536_578_2e-2,
        ],
    );
    let octant = base + (t - t * series);
    let quadrant = x_abs.select_below(y_abs, c(core::f64::consts::FRAC_PI_2) - octant, octant);
    let half = x.select_below(c(0.0), c(core::f64::consts::PI) - quadrant, quadrant);
    half.copysign(y)
}
