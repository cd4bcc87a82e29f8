//! Every combination of levels, by index.

use crate::{Error, Levels, Parameter};

/// The full grid of a region: every combination of levels, the last parameter varying fastest.
///
/// Points are computed from their index in whole numbers, so a grid of any size costs no memory and
/// `nth` skips without counting. [`Region::grid`](crate::Region::grid) makes one.
#[derive(Debug, Clone)]
pub struct Grid<'a> {
    parameters: &'a [Parameter],
    counts: Vec<u32>,
    n_points: u64,
    next: u64,
}

impl<'a> Grid<'a> {
    pub(crate) fn new(parameters: &'a [Parameter]) -> Result<Self, Error> {
        let mut counts = Vec::with_capacity(parameters.len());
        let mut n_points = 1_u64;
        for parameter in parameters {
            let Levels::Count(count) = parameter.levels() else {
                return Err(Error::Continuous { parameter: parameter.name().to_owned() });
            };
            counts.push(count);
            n_points =
                n_points.checked_mul(u64::from(count)).ok_or(Error::GridTooLarge { n_parameters: parameters.len() })?;
        }
        Ok(Self { parameters, counts, n_points, next: 0 })
    }

    /// Number of points of the whole grid, whatever has been iterated already.
    #[must_use]
    pub fn n_points(&self) -> u64 {
        self.n_points
    }

    /// Level index of each parameter at the grid point with this index.
    ///
    /// # Errors
    ///
    /// [`Error::NoSuchGridPoint`].
    pub fn level_indices(&self, index: u64) -> Result<Vec<u32>, Error> {
        if index >= self.n_points {
            return Err(Error::NoSuchGridPoint { index, n_points: self.n_points });
        }
        let mut rest = index;
        let mut indices = vec![0; self.counts.len()];
        for (level, &count) in indices.iter_mut().zip(&self.counts).rev() {
            let count = u64::from(count);
            *level = u32::try_from(rest % count).unwrap_or(u32::MAX);
            rest /= count;
        }
        Ok(indices)
    }

    /// The natural point with this index.
    ///
    /// # Errors
    ///
    /// [`Error::NoSuchGridPoint`].
    pub fn point(&self, index: u64) -> Result<Vec<f64>, Error> {
        let indices = self.level_indices(index)?;
        let levels = self.parameters.iter().zip(&self.counts).zip(indices);
        Ok(levels.map(|((parameter, &count), index)| parameter.level_value(index, count - 1)).collect())
    }
}

impl Iterator for Grid<'_> {
    type Item = Vec<f64>;

    fn next(&mut self) -> Option<Vec<f64>> {
        self.nth(0)
    }

    fn nth(&mut self, n_skipped: usize) -> Option<Vec<f64>> {
        let skipped = u64::try_from(n_skipped).unwrap_or(u64::MAX);
        let index = self.next.saturating_add(skipped).min(self.n_points);
        let point = self.point(index).ok()?;
        self.next = index + 1;
        Some(point)
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        let left = usize::try_from(self.n_points - self.next);
        (left.unwrap_or(usize::MAX), left.ok())
    }
}
