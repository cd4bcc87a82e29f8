//! What is searched for, and how hard.

use anyhow::Result;
use design_space::{Combinations, coded_level};
use doe::{Criterion, Effort, Found, Model, Problem, Settings, Space, search};

use super::file::{Record, Size};
use super::findings::{GOAL, GRID, GRID_STARTS, LARGE_STARTS, LIST_RUNS, LIST_STARTS, MOST_STARTS};

/// Models and runs of the searches over the grid of the case study.
pub(super) const ON_GRID: [(&str, usize); 4] =
    [("quadratic", 18), ("quadratic", 36), ("additive quadratic", 18), ("additive quadratic", 36)];
/// Levels per factor of candidate lists in four factors, to see how the time grows with their length.
pub(super) const LIST_LEVELS: [u32; 4] = [6, 12, 18, 24];
/// Sizes beyond the record, to see how the time grows: searched with a few starts.
pub(super) const LARGE: [Size; 3] = [(5, 30), (6, 40), (7, 50)];

/// One search.
#[derive(Debug, Clone, Copy)]
pub(super) enum Search {
    /// For the like of a kept design, of this efficiency in per cent.
    Again(Size, f64),
    /// With this model and so many runs over the grid of the case study.
    OverGrid(&'static str, usize),
    /// Over a list of the points of a grid in four factors with so many levels, as candidates and not as a grid.
    OverList(u32),
    /// For a size beyond the record.
    Large(Size),
}

impl Search {
    /// For the like of every kept design.
    pub(super) fn again(record: &Record) -> Vec<Self> {
        record.kept.iter().map(|(size, kept)| Self::Again(*size, kept.efficiency.percent)).collect()
    }

    pub(super) fn over_grid() -> Vec<Self> {
        ON_GRID.map(|(model, runs)| Self::OverGrid(model, runs)).to_vec()
    }

    pub(super) fn over_lists() -> Vec<Self> {
        LIST_LEVELS.map(Self::OverList).to_vec()
    }

    pub(super) fn large() -> Vec<Self> {
        LARGE.map(Self::Large).to_vec()
    }

    /// A name for people and files, different from all others.
    pub(super) fn name(self) -> String {
        match self {
            Self::Again((factors, runs), _) => format!("K = {factors}, N = {runs}"),
            Self::OverGrid(model, runs) => format!("{model} on the grid, N = {runs}"),
            Self::OverList(levels) => format!("list of {levels} levels, N = {LIST_RUNS}"),
            Self::Large((factors, runs)) => format!("K = {factors}, N = {runs}, a few starts"),
        }
    }

    /// How hard it searches.
    pub(super) fn settings(self) -> Settings {
        let mut settings = Settings::default();
        match self {
            Self::Again(_, percent) => {
                (settings.starts, settings.effort) = (MOST_STARTS, Effort::Quick);
                settings.target_percent = Some(GOAL * percent);
            }
            Self::OverGrid(..) => settings.starts = GRID_STARTS,
            Self::OverList(_) => settings.starts = LIST_STARTS,
            Self::Large(_) => (settings.starts, settings.effort) = (LARGE_STARTS, Effort::Quick),
        }
        settings
    }

    fn problem(self) -> Result<Problem> {
        let (model, space, runs) = match self {
            Self::Again((factors, runs), _) | Self::Large((factors, runs)) => {
                (Model::quadratic(factors)?, Space::cube(factors)?, runs)
            }
            Self::OverGrid(model, runs) => (Model::named(model, GRID.len())?, Space::grid(&GRID)?, runs),
            Self::OverList(levels) => (Model::quadratic(4)?, Space::list(4, candidates(levels)?)?, LIST_RUNS),
        };
        Ok(Problem::new(model, space, runs, Criterion::G)?)
    }

    pub(super) fn run(self) -> Result<Found> {
        Ok(search(&self.problem()?, &self.settings())?)
    }
}

/// The points of a grid in four factors, of which the first varies fastest.
fn candidates(levels: u32) -> Result<Vec<f64>> {
    let levels = u64::from(levels);
    let level = |index: u64| coded_level(index, levels);
    let grid = Combinations::new(vec![levels; 4])?;
    Ok((0..grid.len()).flat_map(|index| grid.digits(index).into_iter().rev().map(level)).collect())
}
