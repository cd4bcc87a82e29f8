//! What every response surface can do.

use std::fmt;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::lanes::{LANES, Lanes, MOST_FACTORS, check_factors};
use crate::{Error, GridPoints, OverGrid, PointSource, Rows};

/// Points that one thread takes at a time: for some fifty data 50 to 200 microseconds of work, far above what handing
/// it over costs.
const CHUNK: usize = 64 * LANES;

/// A response surface: an estimate of the response at every point, fitted once.
///
/// To implement it, [`n_factors`](Self::n_factors) and [`predict`](Self::predict) are enough; everything here can be
/// called on a `dyn Surface`. Coordinates are those of the data.
pub trait Surface: fmt::Debug + Send + Sync {
    /// Number of factors, K, at most [`MOST_FACTORS`].
    fn n_factors(&self) -> usize;

    /// The estimate at a point; NaN if the point has another number of coordinates than K.
    ///
    /// A coordinate that is not finite gives an estimate that is not finite.
    fn predict(&self, point: &[f64]) -> f64;

    /// The estimate at [`LANES`] points at once: `block[j][l]` is coordinate j of point l.
    ///
    /// Each must be what [`predict`](Self::predict) returns for the point, bit for bit.
    fn predict_lanes(&self, block: &[Lanes], estimates: &mut Lanes) {
        let mut point = [0.0; MOST_FACTORS];
        for (lane, estimate) in estimates.iter_mut().enumerate() {
            for (x, coordinate) in point.iter_mut().zip(block) {
                *x = coordinate[lane];
            }
            *estimate = point.get(..block.len()).map_or(f64::NAN, |point| self.predict(point));
        }
    }

    /// Slope of the estimate along each factor; none where the surface has a kink, or no closed form for it, or if
    /// the point does not have K finite coordinates.
    fn gradient(&self, _point: &[f64]) -> Option<Vec<f64>> {
        None
    }

    /// Variance of the estimate at a point, where the surface rests on a model of the errors; none otherwise, or if
    /// the point does not have K finite coordinates.
    fn variance(&self, _point: &[f64]) -> Option<f64> {
        None
    }

    /// The estimate at a point that is checked first.
    ///
    /// # Errors
    ///
    /// [`Error::Length`], [`Error::Coordinate`].
    fn try_predict(&self, point: &[f64]) -> Result<f64, Error> {
        let (expected, found) = (self.n_factors(), point.len());
        if expected != found {
            return Err(Error::Length { name: "coordinates of a point", expected, found });
        }
        match point.iter().position(|x| !x.is_finite()) {
            Some(factor) => Err(Error::Coordinate { point: 0, factor, value: point[factor], most: f64::MAX }),
            None => Ok(self.predict(point)),
        }
    }

    /// A way to estimate at the points of a grid by tables of its axes, faster than one by one; none where there is none.
    ///
    /// Its estimates are those of [`predict`](Self::predict) but for rounding: the order of sums and products is another.
    fn over_grid<'a>(&'a self, _grid: &'a GridPoints) -> Option<Box<dyn OverGrid + 'a>> {
        None
    }

    /// Estimates at points given row by row, in parallel.
    ///
    /// Every estimate is what [`predict`](Self::predict) returns, bit for bit, whatever the number of threads.
    ///
    /// # Errors
    ///
    /// [`Error::RaggedPoints`], [`Error::Length`] if there is not room for one estimate per point.
    fn predict_into(&self, points: &[f64], estimates: &mut [f64]) -> Result<(), Error> {
        let rows = Rows::new(self.n_factors(), points)?;
        let n_points = points.len() / self.n_factors();
        if estimates.len() != n_points {
            return Err(Error::Length { name: "places for estimates", expected: n_points, found: estimates.len() });
        }
        self.predict_range(&rows, 0, estimates)
    }

    /// Estimates at as many points as there is room for, from index `first` on, in parallel.
    ///
    /// The points of a source need not exist in memory: a [`GridPoints`] of any size can be gone through in pieces. An
    /// estimate is the same in any piece and on any number of threads, and that of [`predict`](Self::predict) bit for bit, or
    /// but for rounding where the surface has tables [over a grid](Self::over_grid).
    ///
    /// # Errors
    ///
    /// [`Error::Count`] for the number of factors, [`Error::FactorMismatch`], [`Error::NoSuchPoints`].
    fn predict_range(&self, source: &dyn PointSource, first: u64, estimates: &mut [f64]) -> Result<(), Error> {
        let n_factors = self.n_factors();
        check_source(n_factors, source)?;
        let n_wanted = estimates.len();
        let n_points = source.n_points();
        if first.checked_add(n_wanted as u64).is_none_or(|end| end > n_points) {
            return Err(Error::NoSuchPoints { first, n_wanted, n_points });
        }
        let tables = source.as_grid().and_then(|grid| self.over_grid(grid));
        let predict_chunk =
            |first: u64, estimates: &mut [f64]| estimate_chunk(self, source, tables.as_deref(), first, estimates);
        if n_wanted <= CHUNK {
            predict_chunk(first, estimates);
        } else {
            let chunks = estimates.par_chunks_mut(CHUNK).enumerate();
            chunks.for_each(|(number, chunk)| predict_chunk(first + (number * CHUNK) as u64, chunk));
        }
        Ok(())
    }

    /// The smallest estimate over all points of a source, in parallel and without storing any; the first of equals.
    ///
    /// None if the source has no points, or if no estimate is a number.
    ///
    /// # Errors
    ///
    /// [`Error::Count`] for the number of factors, [`Error::FactorMismatch`].
    fn minimum_over(&self, source: &dyn PointSource) -> Result<Option<Minimum>, Error> {
        let n_factors = self.n_factors();
        check_source(n_factors, source)?;
        let n_points = source.n_points();
        let tables = source.as_grid().and_then(|grid| self.over_grid(grid));
        let of_chunk = |chunk: u64| {
            let start = chunk * CHUNK as u64;
            let mut estimates = [0.0; CHUNK];
            let estimates = &mut estimates[..(n_points - start).min(CHUNK as u64) as usize];
            estimate_chunk(self, source, tables.as_deref(), start, estimates);
            let mut best: Option<Minimum> = None;
            for (index, &value) in (start..).zip(&*estimates) {
                if best.map_or(!value.is_nan(), |best| value < best.value) {
                    best = Some(Minimum { index, value });
                }
            }
            best
        };
        let lower = |a: Minimum, b: Minimum| {
            if (b.value, b.index) < (a.value, a.index) { b } else { a }
        };
        let chunks = (0..n_points.div_ceil(CHUNK as u64)).into_par_iter();
        Ok(chunks.filter_map(of_chunk).reduce_with(lower))
    }
}

/// The lowest of many estimates.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Minimum {
    /// Index of its point in the source.
    pub index: u64,
    /// The estimate there.
    pub value: f64,
}

/// Estimates at the points of a source from index `first` on, by tables where there are any.
fn estimate_chunk<S: Surface + ?Sized>(
    surface: &S,
    source: &dyn PointSource,
    tables: Option<&dyn OverGrid>,
    first: u64,
    estimates: &mut [f64],
) {
    if let Some(tables) = tables {
        return tables.fill(first, estimates);
    }
    let (mut block, mut lanes) = ([[0.0; LANES]; MOST_FACTORS], [0.0; LANES]);
    let block = &mut block[..source.n_factors()];
    for (number, estimates) in estimates.chunks_mut(LANES).enumerate() {
        source.fill(first + (number * LANES) as u64, estimates.len(), block);
        surface.predict_lanes(block, &mut lanes);
        estimates.copy_from_slice(&lanes[..estimates.len()]);
    }
}

fn check_source(expected: usize, source: &dyn PointSource) -> Result<(), Error> {
    check_factors(expected)?;
    let found = source.n_factors();
    if expected == found {
        Ok(())
    } else {
        Err(Error::FactorMismatch { what: "the source of points", expected, found })
    }
}

/// What a surface gives in lanes, and at the point alone, bit by bit.
#[cfg(test)]
pub(crate) fn bits_at(surface: &impl Surface, point: &[f64]) -> [u64; 2] {
    let block: Vec<Lanes> = point.iter().map(|&x| [x; LANES]).collect();
    let mut estimates = [0.0; LANES];
    surface.predict_lanes(&block, &mut estimates);
    [estimates[0].to_bits(), surface.predict(point).to_bits()]
}
