//! Where the points of a batch come from.

use std::fmt;

use doe::Space;

use crate::surface::check_factors;
use crate::{Error, Lanes};

/// Points by index, written straight into the lanes in which a surface evaluates them.
pub trait PointSource: fmt::Debug + Sync {
    /// Number of factors, K.
    fn n_factors(&self) -> usize;

    /// Number of points.
    fn n_points(&self) -> u64;

    /// Writes `n_filled` points from index `first` on: coordinate j of the l-th of them into `block[j][l]`.
    ///
    /// The callers keep `first + n_filled` within [`n_points`](Self::n_points), `n_filled` within the number of lanes,
    /// and hand in K coordinates; what other lanes hold does not matter.
    fn fill(&self, first: u64, n_filled: usize, block: &mut [Lanes]);
}

/// Points that are in memory, row by row.
#[derive(Debug, Clone, Copy)]
pub struct Rows<'a> {
    n_factors: usize,
    coordinates: &'a [f64],
}

impl<'a> Rows<'a> {
    /// Points of `n_factors` coordinates each.
    ///
    /// # Errors
    ///
    /// [`Error::Count`] for the number of factors, [`Error::RaggedPoints`].
    pub fn new(n_factors: usize, coordinates: &'a [f64]) -> Result<Self, Error> {
        check_factors(n_factors)?;
        if !coordinates.len().is_multiple_of(n_factors) {
            return Err(Error::RaggedPoints { n_factors, n_coordinates: coordinates.len() });
        }
        Ok(Self { n_factors, coordinates })
    }
}

impl PointSource for Rows<'_> {
    fn n_factors(&self) -> usize {
        self.n_factors
    }

    fn n_points(&self) -> u64 {
        (self.coordinates.len() / self.n_factors) as u64
    }

    fn fill(&self, first: u64, n_filled: usize, block: &mut [Lanes]) {
        let rows = &self.coordinates[first as usize * self.n_factors..][..n_filled * self.n_factors];
        for (lane, row) in rows.chunks_exact(self.n_factors).enumerate() {
            for (lanes, &x) in block.iter_mut().zip(row) {
                lanes[lane] = x;
            }
        }
    }
}

/// Every combination of levels, the last factor varying fastest as in [`design_space::Grid`]; only the levels are stored.
///
/// ```
/// use surface::{Data, GridPoints, InverseDistance, Surface};
/// let surface = InverseDistance::fit(Data::new(6, vec![0.5; 6], vec![2.0])?, 2.0)?;
/// let cells = GridPoints::of_space(&doe::Space::grid(&[24; 6])?)?;
/// assert_eq!(cells.n_points(), 191_102_976);
/// let mut estimates = [0.0; 1000];
/// surface.predict_range(&cells, 100_000_000, &mut estimates)?;
/// assert_eq!(estimates, [2.0; 1000]);
/// # use surface::PointSource;
/// # Ok::<(), surface::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct GridPoints {
    levels: Vec<Vec<f64>>,
    n_points: u64,
}

impl GridPoints {
    /// All combinations of these levels, one list per factor.
    ///
    /// # Errors
    ///
    /// [`Error::Count`] for the number of factors or an axis without levels, [`Error::GridTooLarge`].
    pub fn new(levels: Vec<Vec<f64>>) -> Result<Self, Error> {
        check_factors(levels.len())?;
        let mut n_points = 1_u64;
        for axis in &levels {
            if axis.is_empty() {
                return Err(Error::Count { name: "levels of an axis", found: 0, least: 1, most: usize::MAX });
            }
            n_points =
                n_points.checked_mul(axis.len() as u64).ok_or(Error::GridTooLarge { n_factors: levels.len() })?;
        }
        Ok(Self { levels, n_points })
    }

    /// The grid of a space.
    ///
    /// Forbidden boxes leave no gap in the indices: a cell inside one is predicted as any other, and
    /// [`Space::contains`] tells it from the rest.
    ///
    /// # Errors
    ///
    /// [`Error::NotAGrid`] for a list of candidates (use [`Rows`]) or a continuous axis, [`Error::GridTooLarge`].
    pub fn of_space(space: &Space) -> Result<Self, Error> {
        let axes = space.axes().ok_or(Error::NotAGrid { what: "a list of candidates" })?;
        let levels = axes.iter().map(|axis| match axis {
            doe::Axis::Levels(levels) => Ok(levels.clone()),
            doe::Axis::Continuous => Err(Error::NotAGrid { what: "a continuous axis" }),
        });
        Self::new(levels.collect::<Result<_, _>>()?)
    }

    /// The point with this index; none behind the last.
    #[must_use]
    pub fn point(&self, index: u64) -> Option<Vec<f64>> {
        (index < self.n_points).then(|| {
            let digits = self.digits(index);
            self.levels.iter().zip(digits).map(|(axis, digit)| axis[digit]).collect()
        })
    }

    /// Level index of every factor, zeros behind.
    fn digits(&self, mut index: u64) -> [usize; crate::MOST_FACTORS] {
        let mut digits = [0; crate::MOST_FACTORS];
        for (digit, axis) in digits[..self.levels.len()].iter_mut().zip(&self.levels).rev() {
            *digit = (index % axis.len() as u64) as usize;
            index /= axis.len() as u64;
        }
        digits
    }
}

impl PointSource for GridPoints {
    fn n_factors(&self) -> usize {
        self.levels.len()
    }

    fn n_points(&self) -> u64 {
        self.n_points
    }

    fn fill(&self, first: u64, n_filled: usize, block: &mut [Lanes]) {
        let mut digits = self.digits(first);
        // Run by run along the last axis: the other coordinates stay the same within a run.
        let (last, others) = (self.levels.len() - 1, &self.levels[..self.levels.len() - 1]);
        let mut lane = 0;
        while lane < n_filled {
            let run = &self.levels[last][digits[last]..];
            let run = &run[..run.len().min(n_filled - lane)];
            for ((lanes, axis), &digit) in block.iter_mut().zip(others).zip(&digits) {
                lanes[lane..lane + run.len()].fill(axis[digit]);
            }
            block[last][lane..lane + run.len()].copy_from_slice(run);
            lane += run.len();
            digits[last] = 0;
            for (digit, axis) in digits[..last].iter_mut().zip(others).rev() {
                *digit += 1;
                if *digit < axis.len() {
                    break;
                }
                *digit = 0;
            }
        }
    }
}
