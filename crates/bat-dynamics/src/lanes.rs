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

// Plain loops rather than closures: the kernels are inlined as a whole, and closures would multiply what the
// compiler has to read.
macro_rules! each_lane {
    ($i:ident => $value:expr) => {{
        let mut out = [0.0; N];
        let mut $i = 0;
        while $i < N {
            out[$i] = $value;
            $i += 1;
        }
        Self(out)
    }};
}

macro_rules! lane_operator {
    ($($trait:ident $method:ident $op:tt),*) => {$(
        impl<const N: usize> $trait for Lanes<N> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                each_lane!(i => self.0[i] $op other.0[i])
            }
        }
    )*};
}
lane_operator!(Add add +, Sub sub -, Mul mul *, Div div /);

impl<const N: usize> Neg for Lanes<N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        each_lane!(i => -self.0[i])
    }
}

impl<const N: usize> Real for Lanes<N> {
    #[inline(always)]
    fn constant(value: f64) -> Self {
        Self([value; N])
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        each_lane!(i => self.0[i].sqrt())
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
        each_lane!(i => self.0[i].abs())
    }
    #[inline(always)]
    fn select_below(self, limit: Self, chosen: Self, otherwise: Self) -> Self {
        each_lane!(i => if self.0[i] < limit.0[i] { chosen.0[i] } else { otherwise.0[i] })
    }
    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        each_lane!(i => self.0[i].copysign(sign.0[i]))
    }
}
