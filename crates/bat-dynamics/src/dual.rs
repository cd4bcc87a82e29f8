//! A value with its derivative: dual numbers as a scalar of the dynamics.

use num_dual::Dual64;

use crate::real::Real;
use crate::trig;

/// Derivatives: those of the functions above; a selection carries the derivative of the chosen branch.
impl Real for Dual64 {
    fn constant(value: f64) -> Self {
        Dual64::from_re(value)
    }
    fn sqrt(self) -> Self {
        let root = self.re.sqrt();
        Dual64::new(root, self.eps * 0.5 / root)
    }
    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = trig::sin_cos(self.re);
        (Dual64::new(sin, cos * self.eps), Dual64::new(cos, -sin * self.eps))
    }
    fn atan2(self, x: Self) -> Self {
        let squared = self.re * self.re + x.re * x.re;
        Dual64::new(trig::atan2(self.re, x.re), (x.re * self.eps - self.re * x.eps) / squared)
    }
    fn abs(self) -> Self {
        if self.re < 0.0 { -self } else { self }
    }
    fn select_below(self, limit: Self, chosen: Self, otherwise: Self) -> Self {
        if self.re < limit.re { chosen } else { otherwise }
    }
    fn copysign(self, sign: Self) -> Self {
        if self.re.is_sign_negative() == sign.re.is_sign_negative() { self } else { -self }
    }
}
