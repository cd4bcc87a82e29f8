//! A pinhole camera: from points of the ground frame to pixels.

use bat_dynamics::Real;

use super::pose::Pose;
use super::triple::{Triple, dot, minus, scaled_difference};
use crate::error::Error;

/// A pinhole camera that stands still.
///
/// A point at `d` ahead of it, `r` to its right and `b` below its axis, all in m, falls on the pixel
///
/// ```text
/// u = width/2 + f r/d        v = height/2 + f b/d
/// ```
///
/// counted from the upper left corner of the image, u to the right and v downward. It sees what has `d > 0` and lies in
/// its region of interest. There is no lens distortion, and no refraction at the glass: f is the focal length that the
/// camera has through the water.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// What it is called in messages.
    pub name: String,
    /// The pinhole in G, in m, and how the camera is turned: its axis is a body's nose, its right a body's starboard.
    pub pose: Pose,
    /// f: a point one meter ahead moves by this many pixels when it moves a meter across.
    pub focal_length_px: f64,
    /// Width of the image.
    pub width_px: f64,
    /// Height of the image.
    pub height_px: f64,
    /// Where dots are looked for.
    pub region: Region,
}

/// A part of an image, in pixels from its upper left corner, its edges included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region {
    /// Smallest u.
    pub left_px: f64,
    /// Largest u.
    pub right_px: f64,
    /// Smallest v.
    pub top_px: f64,
    /// Largest v.
    pub bottom_px: f64,
}

impl Region {
    /// The whole of an image.
    #[must_use]
    pub fn whole(width_px: f64, height_px: f64) -> Self {
        Self { left_px: 0.0, right_px: width_px, top_px: 0.0, bottom_px: height_px }
    }

    /// Whether a pixel lies in it; one that is not a number does not.
    #[must_use]
    pub fn contains(&self, [u, v]: [f64; 2]) -> bool {
        u >= self.left_px && u <= self.right_px && v >= self.top_px && v <= self.bottom_px
    }
}

impl Camera {
    /// The camera ready to project, checked; `index` is its place among the cameras.
    pub(crate) fn eye(&self, index: usize) -> Result<Eye, Error> {
        let refuse = |field: &str, value: String, expected| {
            let field = format!("camera[{index}].{field} of `{}`", self.name);
            Err(Error::Sensing { field, value, expected })
        };
        for (name, value) in ["x", "y", "z", "roll", "pitch", "heading"].into_iter().zip(self.pose.numbers()) {
            if !value.is_finite() {
                return refuse(name, value.to_string(), "finite");
            }
        }
        let sizes = [("focal_length", self.focal_length_px), ("width", self.width_px), ("height", self.height_px)];
        for (name, value) in sizes {
            if !(value.is_finite() && value > 0.0) {
                return refuse(name, format!("{value} px"), "finite and more than zero");
            }
        }
        let Region { left_px, right_px, top_px, bottom_px } = self.region;
        for (name, from, to, size) in [
            ("left and right", left_px, right_px, self.width_px),
            ("top and bottom", top_px, bottom_px, self.height_px),
        ] {
            if !(from >= 0.0 && from < to && to <= size) {
                let expected = "a region of interest within the image, the first less than the second";
                return refuse(name, format!("{from} and {to} px"), expected);
            }
        }
        let rows = self.pose.rows_gb();
        let axis = |k: usize| [rows[0][k], rows[1][k], rows[2][k]];
        Ok(Eye {
            position: self.pose.position_m,
            ahead: axis(0),
            right: axis(1),
            below: axis(2),
            focal_px: self.focal_length_px,
            center_px: [0.5 * self.width_px, 0.5 * self.height_px],
        })
    }
}

/// A camera with its axes in G, or several side by side.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Eye<T = f64> {
    pub(crate) position: Triple<T>,
    pub(crate) ahead: Triple<T>,
    pub(crate) right: Triple<T>,
    pub(crate) below: Triple<T>,
    pub(crate) focal_px: T,
    pub(crate) center_px: [T; 2],
}

/// Where a point falls, and how the pixel moves with it.
pub(crate) struct Projection<T> {
    /// How far ahead of the camera the point lies, in m; the rest means something only where this is positive.
    pub(crate) depth: T,
    /// u and v.
    pub(crate) pixel: [T; 2],
    /// Derivatives of u and v by the place of the point in G, in px/m.
    pub(crate) slopes: [Triple<T>; 2],
}

impl<T: Real> Eye<T> {
    /// The point `p` of G, with `∂u/∂p = f/d (right − (r/d) ahead)`, and v with below.
    #[inline(always)]
    pub(crate) fn project(&self, p: Triple<T>) -> Projection<T> {
        let from_here = minus(p, self.position);
        let depth = dot(self.ahead, from_here);
        let inverse = T::constant(1.0) / depth;
        let scale = self.focal_px * inverse;
        let (r, b) = (dot(self.right, from_here), dot(self.below, from_here));
        let [u, v] = self.center_px;
        Projection {
            depth,
            pixel: [u + scale * r, v + scale * b],
            slopes: [
                scaled_difference(self.right, r * inverse, self.ahead, scale),
                scaled_difference(self.below, b * inverse, self.ahead, scale),
            ],
        }
    }
}
