//! Where the points of a batch come from.

use std::fmt;

use design_space::Combinations;
use doe::Space;

use crate::Error;
use crate::lanes::{Lanes, MOST_FACTORS, check_factors};

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

    /// The grid of which these are all points in its order, if they are: surfaces then work by tables of its axes.
    fn as_grid(&self) -> Option<&GridPoints> {
        None
    }
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
    combinations: Combinations,
}

impl GridPoints {
    /// All combinations of these levels, one list per factor.
    ///
    /// # Errors
    ///
    /// [`Error::Count`] for the number of factors or an axis without levels, [`Error::GridTooLarge`].
    pub fn new(levels: Vec<Vec<f64>>) -> Result<Self, Error> {
        check_factors(levels.len())?;
        if levels.iter().any(Vec::is_empty) {
            return Err(Error::Count { name: "levels of an axis", found: 0, least: 1, most: usize::MAX });
        }
        let counts: Vec<u64> = levels.iter().map(|axis| axis.len() as u64).collect();
        let combinations = Combinations::new(counts).map_err(|_| Error::GridTooLarge { n_factors: levels.len() })?;
        Ok(Self { levels, combinations })
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

    /// The levels of each axis.
    #[must_use]
    pub fn levels(&self) -> &[Vec<f64>] {
        &self.levels
    }

    /// The order of its points.
    pub(crate) fn combinations(&self) -> &Combinations {
        &self.combinations
    }

    /// The point with this index; none behind the last.
    #[must_use]
    pub fn point(&self, index: u64) -> Option<Vec<f64>> {
        (index < self.n_points()).then(|| {
            let digits = self.combinations.digits(index);
            self.levels.iter().zip(digits).map(|(axis, digit)| axis[digit as usize]).collect()
        })
    }
}

impl PointSource for GridPoints {
    fn as_grid(&self) -> Option<&GridPoints> {
        Some(self)
    }

    fn n_factors(&self) -> usize {
        self.levels.len()
    }

    fn n_points(&self) -> u64 {
        self.combinations.len()
    }

    fn fill(&self, first: u64, n_filled: usize, block: &mut [Lanes]) {
        let Some((last, others)) = self.levels.split_last() else {
            return;
        };
        let mut digits = [0; MOST_FACTORS];
        let digits = &mut digits[..self.levels.len()];
        self.combinations.fill_digits(first, digits);
        // Run by run along the last axis: the other coordinates stay the same within a run.
        let mut lane = 0;
        while lane < n_filled {
            let run = &last[digits[others.len()] as usize..];
            let run = &run[..run.len().min(n_filled - lane)];
            for ((lanes, axis), &digit) in block.iter_mut().zip(others).zip(&*digits) {
                lanes[lane..lane + run.len()].fill(axis[digit as usize]);
            }
            block[others.len()][lane..lane + run.len()].copy_from_slice(run);
            lane += run.len();
            // From the last point of the run to the next.
            digits[others.len()] += run.len() as u64 - 1;
            self.combinations.advance(digits);
        }
    }
}
