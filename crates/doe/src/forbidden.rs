//! Combinations of settings that must not be run.

use serde::{Deserialize, Serialize};

use crate::same::SAME;
use crate::{Error, Levels, Parameter, Region};

/// A box of coded coordinates that no run may lie in: all its ranges at once, any value of the factors without range.
///
/// Along an axis with levels and in a list the ends of a range are forbidden too; along a continuous axis the ends
/// are allowed, so that the allowed points are a closed set. A range that reaches −1 or 1 goes on beyond it: the
/// ranges −1 to 0.5 and 0.5 to 1 take the face of the cube with them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "UncheckedForbidden")]
pub struct Forbidden {
    ranges: Vec<Option<[f64; 2]>>,
}

impl Forbidden {
    /// The box with these coded ranges, one entry per factor, `None` for any value.
    ///
    /// # Errors
    ///
    /// [`Error::ForbidsEverything`] if no factor has a range, [`Error::ForbiddenRange`] for a NaN or inverted range.
    pub fn new(ranges: Vec<Option<[f64; 2]>>) -> Result<Self, Error> {
        if ranges.iter().all(Option::is_none) {
            return Err(Error::ForbidsEverything);
        }
        for (factor, range) in ranges.iter().enumerate() {
            if let &Some([lower, upper]) = range {
                // NaN is not at most anything.
                if lower.is_nan() || upper.is_nan() || lower > upper {
                    return Err(Error::ForbiddenRange { factor, lower, upper });
                }
            }
        }
        Ok(Self { ranges })
    }

    /// The box with these natural ranges of named parameters.
    ///
    /// # Errors
    ///
    /// [`Error::NoSuchParameter`], [`Error::ForbiddenRangeOf`], [`Error::ForbiddenTwice`], [`Error::ForbidsNothing`] for a
    /// range outside the parameter's bounds, [`Error::ForbidsNoLevel`] for one between two of its levels,
    /// [`Error::ForbidsEverything`].
    pub fn in_region(region: &Region, ranges: &[(&str, f64, f64)]) -> Result<Self, Error> {
        let mut coded = vec![None; region.n_parameters()];
        for &(name, lower, upper) in ranges {
            let index = region.index_of(name).ok_or_else(|| Error::NoSuchParameter { name: name.to_owned() })?;
            if coded[index].is_some() {
                return Err(Error::ForbiddenTwice { parameter: name.to_owned() });
            }
            let parameter = &region.parameters()[index];
            // NaN is not at most anything.
            if lower.is_nan() || upper.is_nan() || lower > upper {
                return Err(Error::ForbiddenRangeOf { parameter: name.to_owned(), lower, upper });
            }
            if upper < parameter.lower() || lower > parameter.upper() {
                return Err(Error::ForbidsNothing {
                    parameter: name.to_owned(),
                    lower,
                    upper,
                    bounds: [parameter.lower(), parameter.upper()],
                    unit: parameter.unit().to_owned(),
                });
            }
            check_levels(parameter, lower, upper)?;
            coded[index] = Some([parameter.coded(lower), parameter.coded(upper)]);
        }
        Self::new(coded)
    }

    /// The coded ranges, one entry per factor.
    #[must_use]
    pub fn ranges(&self) -> &[Option<[f64; 2]>] {
        &self.ranges
    }

    /// Lower and upper end along one axis, infinite where the box goes on.
    pub(crate) fn range(&self, factor: usize) -> [f64; 2] {
        let [lower, upper] = self.ranges[factor].unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
        [if lower <= -1.0 { f64::NEG_INFINITY } else { lower }, if upper >= 1.0 { f64::INFINITY } else { upper }]
    }
}

/// That a range which meets the bounds of a parameter holds one of its levels, if it has levels.
fn check_levels(parameter: &Parameter, lower: f64, upper: f64) -> Result<(), Error> {
    // Both bounds are levels.
    if parameter.levels() == Levels::Continuous || !parameter.contains(lower) || !parameter.contains(upper) {
        return Ok(());
    }
    let nearest = parameter.nearest_level(lower)?;
    let around = [nearest.checked_sub(1), Some(nearest), nearest.checked_add(1)];
    let levels: Vec<f64> = around.into_iter().flatten().filter_map(|index| parameter.level(index).ok()).collect();
    let [from, to] = [parameter.coded(lower) - SAME, parameter.coded(upper) + SAME];
    let is_below = |level: &f64| parameter.coded(*level) < from;
    let above = levels.iter().copied().find(|level| !is_below(level));
    match (levels.iter().copied().rfind(is_below), above) {
        (Some(below), Some(above)) if parameter.coded(above) > to => Err(Error::ForbidsNoLevel {
            parameter: parameter.name().to_owned(),
            lower,
            upper,
            nearest: [below, above],
            unit: parameter.unit().to_owned(),
        }),
        _ => Ok(()),
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename = "Forbidden")]
struct UncheckedForbidden {
    ranges: Vec<Option<[f64; 2]>>,
}

impl TryFrom<UncheckedForbidden> for Forbidden {
    type Error = Error;

    fn try_from(unchecked: UncheckedForbidden) -> Result<Self, Error> {
        Self::new(unchecked.ranges)
    }
}
