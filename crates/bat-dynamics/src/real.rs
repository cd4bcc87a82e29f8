//! The scalar of the dynamics: one source line serves `f64`, SIMD lanes and dual numbers.

use core::ops::{Add, Div, Mul, Neg, Sub};

/// A real number as the dynamics kernels need it.
///
/// Implemented for `f64`, for [`Lanes`](crate::Lanes) (several flights at once) and for
/// [`num_dual::Dual64`] (a value with its derivative). Code that is generic over it never branches on a
/// value: it selects, so that every lane runs the same instructions and gets, bit for bit, what `f64` gets.
pub trait Real:
    Copy
    + core::fmt::Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// The constant `value` in every lane, with zero derivative.
    fn constant(value: f64) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Sine and cosine of an angle in rad, within 2.3e-16 of the platform's for |x| < 1e5; NaN where `self` is not finite.
    fn sin_cos(self) -> (Self, Self);
    /// The angle of the point (`x`, `self`) in [-pi, pi], in rad, within three units in the last place of the platform's;
    /// 0 with the sign of `self` where both are 0.
    fn atan2(self, x: Self) -> Self;
    /// Absolute value.
    fn abs(self) -> Self;
    /// `chosen` where `self < limit`, `otherwise` elsewhere (also where either is NaN).
    fn select_below(self, limit: Self, chosen: Self, otherwise: Self) -> Self;
    /// The magnitude of `self` with the sign of `sign`.
    fn copysign(self, sign: Self) -> Self;

    /// The smaller of the two; `other` where `self` is NaN.
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.select_below(other, self, other)
    }

    /// The larger of the two; `other` where `self` is NaN.
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        other.select_below(self, self, other)
    }
}
