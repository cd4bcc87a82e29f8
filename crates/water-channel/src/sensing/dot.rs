//! A dot on the hull.

use nalgebra::Vector3;

use super::triple::{Triple, minus};
use crate::error::Error;

/// A dot on the hull: where it is and where it faces, along the body B.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dot {
    /// From the bridle joint: forward, starboard, down, in m.
    pub position_m: [f64; 3],
    /// The outward normal of the hull at the dot, of any length but zero.
    pub normal: [f64; 3],
}

/// Dots closer than this, in m, are one dot.
const CLOSEST_M: f64 = 1e-6;

/// A dot from the point that a pose is about, with a normal of length one; or several side by side.
#[derive(Clone, Debug)]
pub(crate) struct Mark<T = f64> {
    pub(crate) place: Triple<T>,
    pub(crate) normal: Triple<T>,
}

/// The dots ready to be looked at, from the point `reference_m` of B, checked.
pub(crate) fn marks(dots: &[Dot], reference_m: [f64; 3]) -> Result<Vec<Mark>, Error> {
    let mut marks: Vec<Mark> = Vec::with_capacity(dots.len());
    for (index, dot) in dots.iter().enumerate() {
        let refuse = |field: &str, value: String, expected| {
            Err(Error::Sensing { field: format!("dot[{index}].{field}"), value, expected })
        };
        let place = minus(dot.position_m, reference_m);
        if !place.iter().all(|x| x.is_finite()) {
            return refuse("position", format!("{:?} m", dot.position_m), "finite");
        }
        let Some(normal) =
            Vector3::from(dot.normal).try_normalize(0.0).filter(|unit| unit.iter().all(|x| x.is_finite()))
        else {
            return refuse("normal", format!("{:?}", dot.normal), "finite and not zero in all three components");
        };
        if let Some(other) = marks.iter().position(|mark| Vector3::from(minus(mark.place, place)).norm() < CLOSEST_M) {
            return refuse("position", format!("that of dot[{other}]"), "at least 1e-6 m from every other dot");
        }
        marks.push(Mark { place, normal: normal.into() });
    }
    Ok(marks)
}
