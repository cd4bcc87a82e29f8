//! The runs of an experiment.

use serde::{Deserialize, Serialize};

use crate::error::check_points;
use crate::same::{is_within, twins, unite};
use crate::{Error, Region, Space};

/// An ordered list of runs in coded coordinates: n_runs × n_factors, row by row.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "UncheckedDesign", into = "UncheckedDesign")]
pub struct Design {
    n_factors: usize,
    coordinates: Vec<f64>,
}

impl Design {
    /// A design of these coded coordinates, row by row.
    ///
    /// # Errors
    ///
    /// [`Error::Count`] for no factors or no runs, [`Error::RaggedPoints`] if the coordinates do not fill whole
    /// rows, [`Error::NotFinite`].
    pub fn new(n_factors: usize, coordinates: Vec<f64>) -> Result<Self, Error> {
        check_points("runs of a design", n_factors, &coordinates)?;
        Ok(Self { n_factors, coordinates })
    }

    /// A design of these coded runs.
    ///
    /// # Errors
    ///
    /// As [`new`](Self::new); [`PointLength`](design_space::Error::PointLength) for a run of another length than the first.
    pub fn from_runs(runs: &[impl AsRef<[f64]>]) -> Result<Self, Error> {
        let n_factors = runs.first().map_or(0, |run| run.as_ref().len());
        for run in runs {
            if run.as_ref().len() != n_factors {
                return Err(Error::DesignSpace(design_space::Error::PointLength {
                    expected: n_factors,
                    found: run.as_ref().len(),
                }));
            }
        }
        Self::new(n_factors, runs.iter().flat_map(|run| run.as_ref().iter().copied()).collect())
    }

    /// A design of runs in natural coordinates, each of which must lie within the region.
    ///
    /// # Errors
    ///
    /// As [`from_runs`](Self::from_runs) and [`Region::check`].
    pub fn from_natural(region: &Region, runs: &[impl AsRef<[f64]>]) -> Result<Self, Error> {
        let coded = runs.iter().map(|run| region.check(run.as_ref()).and_then(|()| region.coded(run.as_ref())));
        Self::from_runs(&coded.collect::<Result<Vec<_>, _>>()?)
    }

    /// The runs in natural coordinates. Coordinates within rounding of a level come out as that level's value.
    ///
    /// # Errors
    ///
    /// [`DesignSpaceError::WrongDimension`](crate::DesignSpaceError::WrongDimension).
    pub fn natural(&self, region: &Region) -> Result<Vec<Vec<f64>>, Error> {
        let snapped = |run: &[f64]| {
            let natural = region.natural(run)?;
            Ok(match region.snap(&natural) {
                Ok(snapped) => {
                    let parameters = region.parameters().iter().zip(natural.iter().zip(&snapped));
                    let near = |(parameter, (a, b)): (&crate::Parameter, (&f64, &f64))| {
                        if (a - b).abs() <= 1e-9 * parameter.width() { *b } else { *a }
                    };
                    parameters.map(near).collect()
                }
                Err(_) => natural,
            })
        };
        self.runs().map(snapped).collect()
    }

    /// Number of factors, K.
    #[must_use]
    pub fn n_factors(&self) -> usize {
        self.n_factors
    }

    /// Number of runs, N.
    #[must_use]
    pub fn n_runs(&self) -> usize {
        self.coordinates.len() / self.n_factors
    }

    /// The runs, coded, in order.
    pub fn runs(&self) -> std::slice::ChunksExact<'_, f64> {
        self.coordinates.chunks_exact(self.n_factors)
    }

    /// All coded coordinates, row by row.
    #[must_use]
    pub fn coordinates(&self) -> &[f64] {
        &self.coordinates
    }

    /// This design followed by the runs of another.
    ///
    /// # Errors
    ///
    /// [`Error::FactorMismatch`].
    pub fn followed_by(&self, other: &Self) -> Result<Self, Error> {
        if other.n_factors != self.n_factors {
            return Err(Error::FactorMismatch {
                what: "the second design",
                expected: self.n_factors,
                found: other.n_factors,
            });
        }
        Ok(Self { n_factors: self.n_factors, coordinates: [&self.coordinates[..], &other.coordinates].concat() })
    }

    /// The same runs, of which replicates are equal to the last bit: each run after the first `n_fixed` has the coordinates of
    /// the first before it that is the same.
    pub(crate) fn with_equal_replicates(mut self, n_fixed: usize) -> Self {
        unite(self.n_factors, &mut self.coordinates, n_fixed);
        self
    }

    /// Number of distinct points, to within the tolerance of [`Replicates`](crate::Replicates).
    pub(crate) fn n_distinct(&self) -> usize {
        self.twins().iter().filter(|twins| twins.is_none()).count()
    }

    /// The first and the last run before each that are its replicates; none where there is none.
    pub(crate) fn twins(&self) -> Vec<Option<(usize, usize)>> {
        twins(self.n_factors, &self.coordinates)
    }

    /// Pairs of runs that are the same point to within `tolerance` in every coordinate, first before second.
    #[must_use]
    pub fn replicates(&self, tolerance: f64) -> Vec<(usize, usize)> {
        let runs: Vec<&[f64]> = self.runs().collect();
        let pairs = (0..runs.len()).flat_map(|i| (i + 1..runs.len()).map(move |j| (i, j)));
        pairs.filter(|&(i, j)| is_within(tolerance, runs[i], runs[j])).collect()
    }

    /// Nothing if every run belongs to the space.
    ///
    /// # Errors
    ///
    /// [`Error::FactorMismatch`], [`Error::RunOutside`] for the first run at fault.
    pub fn check_within(&self, space: &Space) -> Result<(), Error> {
        if space.n_factors() != self.n_factors {
            return Err(Error::FactorMismatch {
                what: "the design",
                expected: space.n_factors(),
                found: self.n_factors,
            });
        }
        match self.runs().position(|run| !space.contains(run)) {
            Some(run) => Err(Error::RunOutside {
                run,
                point: self.coordinates[run * self.n_factors..][..self.n_factors].to_vec(),
            }),
            None => Ok(()),
        }
    }
}

/// A design as it stands in a file: a list of runs.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename = "Design")]
struct UncheckedDesign {
    runs: Vec<Vec<f64>>,
}

impl TryFrom<UncheckedDesign> for Design {
    type Error = Error;

    fn try_from(unchecked: UncheckedDesign) -> Result<Self, Error> {
        Self::from_runs(&unchecked.runs)
    }
}

impl From<Design> for UncheckedDesign {
    fn from(design: Design) -> Self {
        Self { runs: design.runs().map(<[f64]>::to_vec).collect() }
    }
}
