//! What can be wrong with a parameter, a region, a model, a space, a design or a search.

use crate::wording::counted;
use crate::{Confounding, FileFault};

/// Every fault of this crate, each naming the field, the value and what was allowed.
///
/// Fields hold indices from 0; messages count runs, points, candidates and factors from 1, as files and terms do.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// A parameter, a region, a grid, a model or a point of one.
    #[error(transparent)]
    DesignSpace(#[from] design_space::Error),
    /// Too few or too many of something.
    #[error("{}", count(name, *found, *least, *most))]
    Count {
        /// Of what.
        name: &'static str,
        /// The number given.
        found: usize,
        /// The smallest number allowed.
        least: usize,
        /// The largest number allowed.
        most: usize,
    },
    /// A parameter name that the region does not have.
    #[error("the region has no parameter `{name}`")]
    NoSuchParameter {
        /// The name given.
        name: String,
    },
    /// Flat coordinates that do not fill whole points.
    #[error("{n_coordinates} coordinates do not fill points of {n_factors} coordinates each")]
    RaggedPoints {
        /// Number of factors.
        n_factors: usize,
        /// Number of coordinates given.
        n_coordinates: usize,
    },
    /// A coordinate that is NaN or infinite.
    #[error("coordinate {} of point {} is {value:?}, expected a finite number", factor + 1, point + 1)]
    NotFinite {
        /// Index of the point.
        point: usize,
        /// Index of the coordinate.
        factor: usize,
        /// The value given.
        value: f64,
    },
    /// A candidate outside of coded coordinates.
    #[error("coordinate {} of candidate {} is {value:?}, expected coded coordinates from -1 to 1", factor + 1, point + 1)]
    OutsideCube {
        /// Index of the candidate.
        point: usize,
        /// Index of the coordinate.
        factor: usize,
        /// The value given.
        value: f64,
    },
    /// The same candidate twice: runs that no coordinate tells apart by more than 1e-6 are replicates.
    #[error("candidates {} and {} are the same run, expected candidates more than 1e-6 apart in some coordinate", first + 1, second + 1)]
    DuplicateCandidate {
        /// Index of the first.
        first: usize,
        /// Index of the second.
        second: usize,
    },
    /// Fewer than two levels along an axis.
    #[error("an axis has {levels}, expected at least 2: leave a factor that cannot vary out of the model", levels = counted(*count as u64, "level", "levels"))]
    TooFewAxisLevels {
        /// Number of levels given.
        count: usize,
    },
    /// Levels that are not distinct values in rising order within −1 to 1: no more than 1e-6 apart they would make the same run.
    #[error("the levels of factor {} are not finite, rising by more than 1e-6 and within -1 to 1", factor + 1)]
    LevelsNotRising {
        /// Index of the factor.
        factor: usize,
    },
    /// A forbidden box without any range.
    #[error("a forbidden box has no range, so it forbids everything, expected at least one range")]
    ForbidsEverything,
    /// A forbidden range that is NaN or inverted.
    #[error("factor {}: the forbidden range {lower:?} to {upper:?} is not a range, expected lower <= upper", factor + 1)]
    ForbiddenRange {
        /// Index of the factor.
        factor: usize,
        /// Lower end given.
        lower: f64,
        /// Upper end given.
        upper: f64,
    },
    /// A forbidden box in which a parameter comes twice: only one of the ranges could hold.
    #[error("parameter `{parameter}` of a forbidden box comes twice, expected one range; two ranges are two boxes")]
    ForbiddenTwice {
        /// Its name.
        parameter: String,
    },
    /// A forbidden range of a parameter that is NaN or inverted, in its unit.
    #[error(
        "parameter `{parameter}`: the forbidden range {lower:?} to {upper:?} is not a range, expected lower <= upper"
    )]
    ForbiddenRangeOf {
        /// Name of the parameter.
        parameter: String,
        /// Lower end given.
        lower: f64,
        /// Upper end given.
        upper: f64,
    },
    /// A forbidden range that does not meet the parameter's bounds: it forbids nothing, so a unit or a digit slipped.
    #[error(
        "parameter `{parameter}`: the forbidden range {lower:?} to {upper:?} lies outside its bounds {:?} to {:?} {unit}, so \
         that it forbids nothing",
        bounds[0],
        bounds[1]
    )]
    ForbidsNothing {
        /// Name of the parameter.
        parameter: String,
        /// Lower end given.
        lower: f64,
        /// Upper end given.
        upper: f64,
        /// Bounds of the parameter.
        bounds: [f64; 2],
        /// Unit of the parameter.
        unit: String,
    },
    /// A forbidden range between two levels of the parameter: it forbids nothing, so a digit slipped.
    #[error(
        "parameter `{parameter}`: the forbidden range {lower:?} to {upper:?} holds none of its levels, so that it forbids \
         nothing; the nearest are {:?} and {:?} {unit}",
        nearest[0],
        nearest[1]
    )]
    ForbidsNoLevel {
        /// Name of the parameter.
        parameter: String,
        /// Lower end given.
        lower: f64,
        /// Upper end given.
        upper: f64,
        /// The levels below and above.
        nearest: [f64; 2],
        /// Unit of the parameter.
        unit: String,
    },
    /// A forbidden box that, along one factor, holds nothing of the space: it forbids nothing.
    #[error(
        "forbidden box {}: the range {lower:?} to {upper:?} of factor {} forbids nothing, expected {expected}",
        number + 1,
        factor + 1
    )]
    ForbidsNoPoint {
        /// Index of the box among those given.
        number: usize,
        /// Index of the factor.
        factor: usize,
        /// Lower end given.
        lower: f64,
        /// Upper end given.
        upper: f64,
        /// What would forbid something.
        expected: String,
    },
    /// More levels than an axis is stored with.
    #[error("{count} levels, expected at most {most}: a finer axis is better taken as continuous")]
    TooManyLevels {
        /// Number given.
        count: u32,
        /// Largest number.
        most: u32,
    },
    /// Forbidden boxes that leave nothing.
    #[error("nothing of the space is left once the forbidden boxes are gone")]
    EmptySpace,
    /// A list, or a box with a continuous axis, where a grid is needed.
    #[error("{what} has no levels in every factor, expected a grid")]
    NotAGrid {
        /// What is no grid.
        what: &'static str,
    },
    /// What only runs anywhere in a box can have.
    #[error("{what} needs runs that are continuous in every factor and may be repeated")]
    NotContinuous {
        /// What was asked for.
        what: &'static str,
    },
    /// Two things that must agree in their number of factors.
    #[error("{what} has {factors}, expected {expected}", factors = counted(*found as u64, "factor", "factors"))]
    FactorMismatch {
        /// What does not fit.
        what: &'static str,
        /// Number of factors of the other.
        expected: usize,
        /// Number of factors of this.
        found: usize,
    },
    /// A run that does not belong to the space.
    #[error("run {} lies outside the space: {point:?}", run + 1)]
    RunOutside {
        /// Index of the run.
        run: usize,
        /// Its coded coordinates.
        point: Vec<f64>,
    },
    /// Fewer runs than the model has terms.
    #[error("{runs} cannot determine {terms}, expected at least {n_terms} {noun}", noun = if *n_terms == 1 { "run" } else { "runs" }, runs = counted(*n_runs as u64, "run", "runs"), terms = counted(*n_terms as u64, "term", "terms"))]
    TooFewRuns {
        /// Number of runs.
        n_runs: usize,
        /// Number of terms.
        n_terms: usize,
    },
    /// Fixed runs that leave more of the model open than the other runs can determine.
    #[error(
        "the {n_fixed} fixed runs determine {determined} of {}, and {} the other {}, expected at least {}",
        counted(*n_terms as u64, "term", "terms"),
        if *n_free == 1 { "1 further run cannot determine".to_owned() } else { format!("{n_free} further distinct runs cannot determine") },
        n_terms - determined,
        counted((n_terms - determined) as u64, "further run", "further distinct runs")
    )]
    TooFewFreeRuns {
        /// Number of fixed runs.
        n_fixed: usize,
        /// Number of terms that they determine: the rank of their regressors.
        determined: usize,
        /// Number of distinct runs that are left to choose.
        n_free: usize,
        /// Number of terms of the model.
        n_terms: usize,
    },
    /// Terms that are linear combinations of others over a design or a space.
    #[error("the {what} cannot tell the terms apart: {list}", list = confounding_list(confounded))]
    Confounded {
        /// `"design"` or `"space"`.
        what: &'static str,
        /// Each term that is a combination of earlier ones.
        confounded: Vec<Confounding>,
    },
    /// A space with fewer points than there are distinct runs.
    #[error("the space has {points}, too few for {n_distinct} distinct runs: plan replicates or allow them", points = counted(*n_points, "point", "points"))]
    TooFewPoints {
        /// Number of distinct runs.
        n_distinct: usize,
        /// Number of points of the space.
        n_points: u64,
    },
    /// A setting of a search outside what is allowed.
    #[error("the setting `{name}` is {value:?}, expected {expected}")]
    Setting {
        /// Name of the setting.
        name: &'static str,
        /// The value given.
        value: f64,
        /// What is expected.
        expected: &'static str,
    },
    /// No start of a search led to a usable design.
    #[error("{}", no_design(*starts))]
    NoDesign {
        /// Number of starts made.
        starts: u64,
    },
    /// An information matrix that double precision cannot invert.
    #[error("the information matrix is singular in double precision")]
    Singular,
    /// A file that is not a design in a region.
    #[error("{list}", list = fault_list(faults))]
    File {
        /// Each fault, from the top of the file down.
        faults: Vec<FileFault>,
    },
    /// A factor index past the last factor.
    #[error("factor index {index}, expected less than {n_factors}")]
    NoSuchFactor {
        /// The index given.
        index: usize,
        /// Number of factors.
        n_factors: usize,
    },
}

impl Error {
    /// The same error with terms by other names, one per term of the model, as of
    /// [`Model::term_names`](crate::Model::term_names) with the names of the parameters.
    #[must_use]
    pub fn with_term_names(self, names: &[String]) -> Self {
        match self {
            Self::Confounded { what, confounded } => {
                let confounded = confounded.into_iter().map(|one| one.with_names(names)).collect();
                Self::Confounded { what, confounded }
            }
            other => other,
        }
    }
}

/// That there is at least one of something, and not more than `most`.
pub(crate) fn check_count(name: &'static str, found: usize, most: usize) -> Result<(), Error> {
    if (1..=most).contains(&found) { Ok(()) } else { Err(Error::Count { name, found, least: 1, most }) }
}

/// Whether flat coordinates are whole, finite rows of at least one factor, and at least one row.
pub(crate) fn check_points(name: &'static str, n_factors: usize, coordinates: &[f64]) -> Result<(), Error> {
    check_count("factors", n_factors, design_space::Model::MOST_FACTORS)?;
    if !coordinates.len().is_multiple_of(n_factors) {
        return Err(Error::RaggedPoints { n_factors, n_coordinates: coordinates.len() });
    }
    if coordinates.is_empty() {
        return Err(Error::Count { name, found: 0, least: 1, most: usize::MAX });
    }
    match coordinates.iter().position(|x| !x.is_finite()) {
        Some(at) => Err(Error::NotFinite { point: at / n_factors, factor: at % n_factors, value: coordinates[at] }),
        None => Ok(()),
    }
}

fn count(name: &str, found: usize, least: usize, most: usize) -> String {
    match most {
        usize::MAX => format!("{name}: {found}, expected at least {least}"),
        _ => format!("{name}: {found}, expected {least} to {most}"),
    }
}

fn no_design(starts: u64) -> String {
    if starts == 0 {
        return "the search was over before it had a design".to_owned();
    }
    let starts = counted(starts, "start", "starts");
    format!(
        "none of {starts} led to a design that determines the model with the fixed runs and the rule for replicates"
    )
}

fn confounding_list(confounded: &[Confounding]) -> String {
    confounded.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")
}

/// The first faults of a file, and how many more there are.
fn fault_list(faults: &[FileFault]) -> String {
    const SHOWN: usize = 20;
    let shown: Vec<String> = faults.iter().take(SHOWN).map(ToString::to_string).collect();
    let more = faults.len().saturating_sub(SHOWN);
    shown.join("; ") + &if more > 0 { format!("; and {more} more") } else { String::new() }
}
