//! Three-vectors on arrays, of one number or of several side by side.

use bat_dynamics::{Lanes, Real};

/// Components along some frame.
pub(crate) type Triple<T = f64> = [T; 3];

#[inline(always)]
pub(crate) fn dot<T: Real>(a: Triple<T>, b: Triple<T>) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
pub(crate) fn cross<T: Real>(a: Triple<T>, b: Triple<T>) -> Triple<T> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[inline(always)]
pub(crate) fn add<T: Real>(a: Triple<T>, b: Triple<T>) -> Triple<T> {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[inline(always)]
pub(crate) fn minus<T: Real>(a: Triple<T>, b: Triple<T>) -> Triple<T> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// `(a − c b) s`.
#[inline(always)]
pub(crate) fn scaled_difference<T: Real>(a: Triple<T>, c: T, b: Triple<T>, s: T) -> Triple<T> {
    [(a[0] - c * b[0]) * s, (a[1] - c * b[1]) * s, (a[2] - c * b[2]) * s]
}

/// The matrix with these rows times `a`.
#[inline(always)]
pub(crate) fn times<T: Real>(rows: &[Triple<T>; 3], a: Triple<T>) -> Triple<T> {
    [dot(rows[0], a), dot(rows[1], a), dot(rows[2], a)]
}

/// The same constants in every lane.
#[inline(always)]
pub(crate) fn constant<T: Real>(a: Triple) -> Triple<T> {
    [T::constant(a[0]), T::constant(a[1]), T::constant(a[2])]
}

/// Four vectors side by side.
#[inline(always)]
pub(crate) fn abreast(a: &Triple, b: &Triple, c: &Triple, d: &Triple) -> Triple<Lanes> {
    [Lanes([a[0], b[0], c[0], d[0]]), Lanes([a[1], b[1], c[1], d[1]]), Lanes([a[2], b[2], c[2], d[2]])]
}
