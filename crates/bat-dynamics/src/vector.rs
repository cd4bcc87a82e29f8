//! The few operations on three-vectors and wrenches that the kernels need, on plain arrays of a [`Real`].

use crate::real::Real;

pub(crate) type Vector<T> = [T; 3];

#[inline(always)]
pub(crate) fn add<T: Real>(a: Vector<T>, b: Vector<T>) -> Vector<T> {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[inline(always)]
pub(crate) fn sub<T: Real>(a: Vector<T>, b: Vector<T>) -> Vector<T> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
pub(crate) fn scale<T: Real>(s: T, a: Vector<T>) -> Vector<T> {
    [s * a[0], s * a[1], s * a[2]]
}

#[inline(always)]
pub(crate) fn dot<T: Real>(a: Vector<T>, b: Vector<T>) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
pub(crate) fn cross<T: Real>(a: Vector<T>, b: Vector<T>) -> Vector<T> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// a x (x, 0, z): for a point in the plane of symmetry of the body.
#[inline(always)]
pub(crate) fn cross_point<T: Real>(a: Vector<T>, x: T, z: T) -> Vector<T> {
    [a[1] * z, a[2] * x - a[0] * z, -(a[1] * x)]
}

/// a x r for a point of the body, which lies in the plane of symmetry unless `LOPSIDED`.
#[inline(always)]
pub(crate) fn cross_place<T: Real, const LOPSIDED: bool>(a: Vector<T>, r: Vector<T>) -> Vector<T> {
    if LOPSIDED { cross(a, r) } else { cross_point(a, r[0], r[2]) }
}

/// r x b for a point of the body, which lies in the plane of symmetry unless `LOPSIDED`.
#[inline(always)]
pub(crate) fn place_cross<T: Real, const LOPSIDED: bool>(r: Vector<T>, b: Vector<T>) -> Vector<T> {
    if LOPSIDED { cross(r, b) } else { point_cross(r[0], r[2], b) }
}

/// (x, 0, z) x b.
#[inline(always)]
pub(crate) fn point_cross<T: Real>(x: T, z: T, b: Vector<T>) -> Vector<T> {
    [-(z * b[1]), z * b[0] - x * b[2], x * b[1]]
}

/// x a0 + y a1 + z a2: the vector whose components along the rows of `axes` are `v`.
#[inline(always)]
pub(crate) fn combine<T: Real>(axes: &[Vector<T>; 3], v: Vector<T>) -> Vector<T> {
    let [a, b, c] = axes;
    [
        v[0] * a[0] + v[1] * b[0] + v[2] * c[0],
        v[0] * a[1] + v[1] * b[1] + v[2] * c[1],
        v[0] * a[2] + v[1] * b[2] + v[2] * c[2],
    ]
}

/// The components of `v` along the rows of `axes`.
#[inline(always)]
pub(crate) fn project<T: Real>(axes: &[Vector<T>; 3], v: Vector<T>) -> Vector<T> {
    [dot(axes[0], v), dot(axes[1], v), dot(axes[2], v)]
}

/// A force and its moment about the bridle joint, along one frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wrench<T> {
    pub(crate) force: Vector<T>,
    pub(crate) moment: Vector<T>,
}

impl<T: Real> Wrench<T> {
    /// Of a force that acts at (x, 0, z).
    #[inline(always)]
    pub(crate) fn at(x: T, z: T, force: Vector<T>) -> Self {
        Self { force, moment: point_cross(x, z, force) }
    }

    #[inline(always)]
    pub(crate) fn plus(self, other: Self) -> Self {
        Self { force: add(self.force, other.force), moment: add(self.moment, other.moment) }
    }
}
