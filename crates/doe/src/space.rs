//! The design space: where runs are chosen from and predictions are asked for.

use std::fmt;

use serde::{Serialize, Serializer};

use crate::error::{check_count, check_points};
use crate::measure::Measure;
use crate::same::{SAME, SAME_RUN};
use crate::shape::{Axis, BoxShape, List, Shape, missing_of_all, within_closed};
use crate::wording::counted;
use crate::{Error, Forbidden, Levels, Model, Region};

/// A design space in coded coordinates: runs are chosen from it, and the worst prediction is looked for in it.
///
/// ```
/// use doe::{Forbidden, Space};
/// let cube = Space::cube(2)?;
/// let grid = Space::grid(&[24; 4])?;
/// assert_eq!(grid.n_points(), Some(331_776));
/// let cut = Space::grid(&[3, 3])?.forbid(vec![Forbidden::new(vec![Some([0.5, 1.0]), Some([0.5, 1.0])])?])?;
/// assert_eq!(cut.n_points(), Some(8));
/// let list = Space::list(2, vec![-1.0, -1.0, 0.0, 0.5, 1.0, 1.0])?;
/// assert!(list.contains(&[0.0, 0.5]) && !list.contains(&[0.0, 0.0]));
/// # Ok::<(), doe::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Space {
    shape: Shape,
}

impl Space {
    /// The largest number of forbidden boxes.
    pub const MOST_FORBIDDEN: usize = 64;

    /// The continuous cube from −1 to 1 in every factor.
    ///
    /// # Errors
    ///
    /// [`Error::Count`] for no factor or more than [`Model::MOST_FACTORS`].
    pub fn cube(n_factors: usize) -> Result<Self, Error> {
        check_count("factors", n_factors, Model::MOST_FACTORS)?;
        Self::of_axes(vec![Axis::Continuous; n_factors])
    }

    /// Every combination of equally spaced levels from −1 to 1, this many per factor; nothing is stored.
    ///
    /// # Errors
    ///
    /// [`Error::Count`]; [`Error::TooFewAxisLevels`] below two levels.
    pub fn grid(counts: &[u32]) -> Result<Self, Error> {
        Self::of_axes(counts.iter().map(|&count| Axis::equally_spaced(count)).collect::<Result<_, _>>()?)
    }

    /// A box with these axes.
    ///
    /// # Errors
    ///
    /// [`Error::Count`]; [`Error::TooFewAxisLevels`]; [`Error::LevelsNotRising`] for levels that are NaN, outside
    /// −1 to 1 or not in rising order, each more than 1e-6 above the one before.
    pub fn of_axes(axes: Vec<Axis>) -> Result<Self, Error> {
        check_count("factors", axes.len(), Model::MOST_FACTORS)?;
        for (factor, axis) in axes.iter().enumerate() {
            if let Axis::Levels(levels) = axis {
                if levels.len() < 2 {
                    return Err(Error::TooFewAxisLevels { count: levels.len() });
                }
                let rises = levels.windows(2).all(|pair| pair[1] - pair[0] > SAME_RUN);
                if !rises || levels.iter().any(|level| !(-1.0..=1.0).contains(level)) {
                    return Err(Error::LevelsNotRising { factor });
                }
            }
        }
        Ok(Self { shape: Shape::Box(BoxShape { axes, forbidden: Vec::new() }) })
    }

    /// The box of a region: its continuous parameters and its levels, coded.
    ///
    /// # Errors
    ///
    /// [`Error::Count`] for more parameters than [`Model::MOST_FACTORS`], [`Error::DesignSpace`] for a choice: its order means
    /// nothing.
    pub fn of_region(region: &Region) -> Result<Self, Error> {
        region.parameters().iter().try_for_each(crate::Parameter::check_number)?;
        let axis = |parameter: &crate::Parameter| match parameter.levels() {
            Levels::Continuous => Ok(Axis::Continuous),
            Levels::Count(count) => Axis::equally_spaced(count),
        };
        Self::of_axes(region.parameters().iter().map(axis).collect::<Result<_, _>>()?)
    }

    /// Only these candidates, coded, row by row, as a shrinking design space leaves them behind. No two may be the same run, as
    /// [`Replicates`](crate::Replicates) says.
    ///
    /// # Errors
    ///
    /// [`Error::Count`], [`Error::RaggedPoints`], [`Error::NotFinite`], [`Error::OutsideCube`],
    /// [`Error::DuplicateCandidate`].
    pub fn list(n_factors: usize, coordinates: Vec<f64>) -> Result<Self, Error> {
        check_points("candidates", n_factors, &coordinates)?;
        if let Some(at) = coordinates.iter().position(|x| x.abs() > 1.0 + SAME) {
            return Err(Error::OutsideCube { point: at / n_factors, factor: at % n_factors, value: coordinates[at] });
        }
        let list = List { n_factors, coordinates };
        list.check_distinct()?;
        Ok(Self { shape: Shape::List(list) })
    }

    /// A list whose points are known to be good.
    pub(crate) fn list_unchecked(n_factors: usize, coordinates: Vec<f64>) -> Self {
        Self { shape: Shape::List(List { n_factors, coordinates }) }
    }

    /// This space without some boxes.
    ///
    /// A box that could not forbid anything is a slip of a digit or a unit and refused: one outside of −1 to 1, one between two
    /// levels of an axis, and one whose ends along a continuous axis leave nothing between them. From a list the points of a
    /// box may be gone already, so a box within −1 to 1 may hold none of its candidates.
    ///
    /// ```
    /// use doe::{Forbidden, Space};
    /// let hot = Forbidden::new(vec![Some([0.6, 0.9]), None])?;
    /// let error = Space::grid(&[5, 3])?.forbid(vec![hot]).unwrap_err();
    /// assert_eq!(
    ///     error.to_string(),
    ///     "forbidden box 1: the range 0.6 to 0.9 of factor 1 forbids nothing, expected one of its levels, as 0.5 or 1.0"
    /// );
    /// # Ok::<(), doe::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::FactorMismatch`], [`Error::ForbidsNoPoint`], [`Error::Count`] beyond
    /// [`MOST_FORBIDDEN`](Self::MOST_FORBIDDEN) boxes, [`Error::EmptySpace`] if nothing is left.
    pub fn forbid(mut self, forbidden: Vec<Forbidden>) -> Result<Self, Error> {
        let expected = self.n_factors();
        for forbidden in &forbidden {
            let found = forbidden.ranges().len();
            if found != expected {
                return Err(Error::FactorMismatch { what: "a forbidden box", expected, found });
            }
        }
        self.check_forbids(&forbidden)?;
        match &mut self.shape {
            Shape::Box(shape) => {
                shape.forbidden.extend(forbidden);
                let (found, most) = (shape.forbidden.len(), Self::MOST_FORBIDDEN);
                if found > most {
                    return Err(Error::Count { name: "forbidden boxes", found, least: 0, most });
                }
                if Measure::of(shape).total() <= 0.0 {
                    return Err(Error::EmptySpace);
                }
            }
            Shape::List(list) => {
                list.retain(|point| !forbidden.iter().any(|forbidden| within_closed(forbidden, point)));
                if list.coordinates.is_empty() {
                    return Err(Error::EmptySpace);
                }
            }
        }
        Ok(self)
    }

    /// That each of some boxes could forbid something along every axis.
    fn check_forbids(&self, forbidden: &[Forbidden]) -> Result<(), Error> {
        let missing = |forbidden: &Forbidden, factor: usize| match &self.shape {
            Shape::Box(shape) => shape.missing(forbidden, factor),
            Shape::List(_) => missing_of_all(forbidden, factor),
        };
        for (number, forbidden) in forbidden.iter().enumerate() {
            for (factor, range) in forbidden.ranges().iter().enumerate() {
                if let (Some(expected), &Some([lower, upper])) = (missing(forbidden, factor), range) {
                    return Err(Error::ForbidsNoPoint { number, factor, lower, upper, expected });
                }
            }
        }
        Ok(())
    }

    /// Number of factors, K.
    #[must_use]
    pub fn n_factors(&self) -> usize {
        match &self.shape {
            Shape::Box(shape) => shape.axes.len(),
            Shape::List(list) => list.n_factors,
        }
    }

    /// Number of allowed points; none if an axis is continuous or the count exceeds 2⁵³.
    #[must_use]
    pub fn n_points(&self) -> Option<u64> {
        match &self.shape {
            Shape::Box(shape) => Measure::of(shape).n_points(),
            Shape::List(list) => Some(list.n_points() as u64),
        }
    }

    /// The axes of a box; none for a list.
    #[must_use]
    pub fn axes(&self) -> Option<&[Axis]> {
        match &self.shape {
            Shape::Box(shape) => Some(&shape.axes),
            Shape::List(_) => None,
        }
    }

    /// The forbidden boxes of a box; from a list they are gone together with their points.
    #[must_use]
    pub fn forbidden(&self) -> &[Forbidden] {
        match &self.shape {
            Shape::Box(shape) => &shape.forbidden,
            Shape::List(_) => &[],
        }
    }

    /// The candidates of a list, coded, row by row; none for a box.
    #[must_use]
    pub fn candidates(&self) -> Option<&[f64]> {
        match &self.shape {
            Shape::Box(_) => None,
            Shape::List(list) => Some(&list.coordinates),
        }
    }

    /// Whether a coded point belongs to the space, to within 1e-9 of a bound, a level or a candidate.
    #[must_use]
    pub fn contains(&self, point: &[f64]) -> bool {
        point.len() == self.n_factors()
            && match &self.shape {
                Shape::Box(shape) => shape.contains(point),
                Shape::List(list) => list.nearest(point).1 <= SAME,
            }
    }

    /// What a maximum or an average over this space is over.
    #[must_use]
    pub fn over(&self) -> Over {
        match &self.shape {
            Shape::Box(shape) => {
                let forbidden = shape.forbidden.len();
                let level_count = |axis: &Axis| match axis {
                    Axis::Continuous => None,
                    Axis::Levels(levels) => Some(levels.len()),
                };
                let counts: Vec<Option<usize>> = shape.axes.iter().map(level_count).collect();
                if counts.iter().all(Option::is_none) {
                    Over::Cube { n_factors: counts.len(), forbidden }
                } else {
                    Over::Grid { levels: counts, forbidden }
                }
            }
            Shape::List(list) => Over::List { n_points: list.n_points() },
        }
    }

    pub(crate) fn shape(&self) -> &Shape {
        &self.shape
    }
}

/// The set over which the largest or the mean prediction variance was taken. No efficiency goes without it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Over {
    /// All of [−1, 1]^K, not a lattice, less a number of forbidden boxes.
    Cube {
        /// Number of factors, K.
        n_factors: usize,
        /// Number of forbidden boxes.
        forbidden: usize,
    },
    /// All combinations of levels, `None` for a continuous axis, less a number of forbidden boxes.
    Grid {
        /// Number of levels of each axis.
        levels: Vec<Option<usize>>,
        /// Number of forbidden boxes.
        forbidden: usize,
    },
    /// A list of candidates.
    List {
        /// Number of candidates.
        n_points: usize,
    },
}

/// As [`Display`](fmt::Display) writes it.
impl Serialize for Over {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl fmt::Display for Over {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let forbidden = match self {
            Self::Cube { n_factors, forbidden } => {
                write!(formatter, "cube [-1, 1]^{n_factors}")?;
                *forbidden
            }
            Self::Grid { levels, forbidden } => {
                let count = |count: &Option<usize>| count.map_or_else(|| "continuous".to_owned(), |n| n.to_string());
                let counts: Vec<String> = levels.iter().map(count).collect();
                write!(formatter, "grid of {} levels", counts.join(" x "))?;
                *forbidden
            }
            Self::List { n_points } => {
                return write!(formatter, "list of {}", counted(*n_points as u64, "point", "points"));
            }
        };
        match forbidden {
            0 => Ok(()),
            1 => write!(formatter, " less a forbidden box"),
            _ => write!(formatter, " less {forbidden} forbidden boxes"),
        }
    }
}
