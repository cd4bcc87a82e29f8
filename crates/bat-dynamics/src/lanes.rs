//! Several independent numbers that go through the same instructions: SIMD without intrinsics.

use core::ops::{Add, Div, Mul, Neg, Sub};

use crate::real::Real;
use crate::trig;

/// Number of lanes: one 256-bit register of `f64`.
pub const LANES: usize = 4;

/// [`LANES`] independent `f64` values, one flight each.
///
/// Every operation is written out lane by lane, which the compiler turns into vector instructions; lane `i` of a
/// result depends on lane `i` of the operands alone and has the same bits as the `f64` operation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lanes(pub [f64; LANES]);

// Written out rather than looped over: the kernels are inlined as a whole, and thousands of short loops take the
// compiler more than a minute.
macro_rules! each_lane {
    ($i:ident => $value:expr) => {
        Self([
            {
                const $i: usize = 0;
                $value
            },
            {
                const $i: usize = 1;
                $value
            },
            {
                const $i: usize = 2;
                $value
            },
            {
                const $i: usize = 3;
                $value
            },
        ])
    };
}

macro_rules! lane_operator {
    ($($trait:ident $method:ident $op:tt),*) => {$(
        impl $trait for Lanes {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                each_lane!(I => self.0[I] $op other.0[I])
            }
        }
    )*};
}
lane_operator!(Add add +, Sub sub -, Mul mul *, Div div /);

impl Neg for Lanes {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        each_lane!(I => -self.0[I])
    }
}

impl Real for Lanes {
    #[inline(always)]
    fn constant(value: f64) -> Self {
        Self([value; LANES])
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        each_lane!(I => self.0[I].sqrt())
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
    fn abs(self) -> Self {
        each_lane!(I => self.0[I].abs())
    }
    #[inline(always)]
    fn select_below(self, limit: Self, chosen: Self, otherwise: Self) -> Self {
        each_lane!(I => if self.0[I] < limit.0[I] { chosen.0[I] } else { otherwise.0[I] })
    }
    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        each_lane!(I => self.0[I].copysign(sign.0[I]))
    }
}
