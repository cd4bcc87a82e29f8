//! Several independent numbers that go through the same instructions: SIMD without intrinsics.

use core::ops::{Add, Div, Mul, Neg, Sub};

use crate::real::Real;
use crate::trig;

/// `N` independent `f64` values, one flight each.
///
/// Every operation is a loop of fixed length that the compiler turns into vector instructions; lane `i` of
/// a result depends on lane `i` of the operands alone and has the same bits as the `f64` operation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lanes<const N: usize>(pub [f64; N]);

impl<const N: usize> Lanes<N> {
    #[inline(always)]
    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        let mut out = self.0;
        for value in &mut out {
            *value = f(*value);
        }
        Self(out)
    }

    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        let mut out = self.0;
        for (value, b) in out.iter_mut().zip(other.0) {
            *value = f(*value, b);
        }
        Self(out)
    }
}

macro_rules! lane_operator {
    ($($trait:ident $method:ident $op:tt),*) => {$(
        impl<const N: usize> $trait for Lanes<N> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                self.zip(other, |a, b| a $op b)
            }
        }
    )*};
}
lane_operator!(Add add +, Sub sub -, Mul mul *, Div div /);

impl<const N: usize> Neg for Lanes<N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.map(|a| -a)
    }
}

impl<const N: usize> Real for Lanes<N> {
    #[inline(always)]
    fn constant(value: f64) -> Self {
        Self([value; N])
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        self.map(f64::sqrt)
    }
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        trig::sin_cos(self)
    }
    #[inline(always)]
    fn atan2(self, x: Self) -> Self {
        trig::atan2(self, x)
    }
    #[inline(always)]
    fn asin(self) -> Self {
        trig::asin(self)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        self.map(f64::abs)
    }
    #[inline(always)]
    fn select_below(self, limit: Self, chosen: Self, otherwise: Self) -> Self {
        let mut out = otherwise.0;
        for i in 0..N {
            out[i] = if self.0[i] < limit.0[i] { chosen.0[i] } else { otherwise.0[i] };
        }
        Self(out)
    }
    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        self.zip(sign, f64::copysign)
    }
}
