//! The two machines: what a design costs in the simulation and on the rig, and which of its parameters are built.

use anyhow::{Context as _, Result};
use design_space::{Cell, Grid, Parameter, Region};
use rayon::prelude::*;
use std::path::Path;

use super::suspension::{self, Car};
use crate::bat::{Bat, MODEL, STAND_IN};
use crate::chapter7::Setup;
use crate::costs::Cost;

/// Levels of each parameter.
const LEVELS: u32 = 24;
/// Designs that tell how far costs spread, and those from which the best is looked for.
const SAMPLE: u64 = 1500;
const STARTS: usize = 12;

/// A machine with plant and controller parameters.
pub(super) struct Case {
    pub(super) name: &'static str,
    pub(super) words: &'static str,
    pub(super) region: Region,
    pub(super) grid: Grid,
    /// The parameters that are built, by their places.
    pub(super) plant: Vec<usize>,
    machine: Machine,
    /// The lowest cost that was found, and what 80 % of all designs span.
    pub(super) best: f64,
    pub(super) spread: f64,
    /// The median of all designs.
    pub(super) typical: f64,
}

enum Machine {
    Turbine(Box<Bat>),
    Suspension,
}

impl Case {
    pub(super) fn all(root: &Path) -> Result<[Self; 2]> {
        let setup = Setup::read(&root.join("fixtures/bat/chapter7.toml"))?;
        let turbine = setup.cases.into_iter().last().context("a study of four parameters")?;
        let region = turbine.space.region().clone();
        // Fins are printed; ballast is shifted, and a set point typed.
        let plant = (2..region.n_parameters()).collect();
        let of_turbine = Self::of(
            "turbine",
            "turbine: two fin areas are built",
            region,
            plant,
            Machine::Turbine(Box::new(turbine.bat)),
        )?;
        let parameters = suspension::RANGES
            .map(|(name, unit, lower, upper)| Parameter::continuous(name, unit, lower, upper)?.with_levels(LEVELS));
        let region = Region::new(parameters.into_iter().collect::<Result<_, _>>()?)?;
        let words = "suspension: spring and damper are built";
        Ok([of_turbine, Self::of("suspension", words, region, vec![0, 1], Machine::Suspension)?])
    }

    fn of(
        name: &'static str,
        words: &'static str,
        region: Region,
        plant: Vec<usize>,
        machine: Machine,
    ) -> Result<Self> {
        let grid = Grid::of(&region)?;
        let nan = f64::NAN;
        let mut case = Self { name, words, region, grid, plant, machine, best: nan, spread: nan, typical: nan };
        let stride = 1_000_003;
        let cells: Vec<Cell> = (0..SAMPLE).map(|index| Cell::new(index * stride % case.grid.n_cells())).collect();
        let costs: Vec<Option<f64>> = case.on_the_rig(&cells)?.into_iter().map(Result::ok).collect();
        let known: Vec<f64> = costs.iter().flatten().copied().collect();
        let at = |share: f64| page::quantile(&known, share).unwrap_or(f64::NAN);
        (case.spread, case.typical) = (at(0.9) - at(0.1), at(0.5));
        let mut order: Vec<(f64, Cell)> =
            costs.into_iter().zip(cells).filter_map(|(cost, cell)| Some((cost?, cell))).collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        let lowest = order.into_iter().take(STARTS).map(|start| case.descend(start));
        case.best = lowest.collect::<Result<Vec<f64>>>()?.into_iter().fold(f64::INFINITY, f64::min);
        Ok(case)
    }

    /// From a design to its best neighbor, and on from there.
    fn descend(&self, (mut cost, mut cell): (f64, Cell)) -> Result<f64> {
        loop {
            let around = self.grid.neighbors(cell)?;
            let costs = self.on_the_rig(&around)?.into_iter().map(|cost| cost.unwrap_or(f64::INFINITY));
            let lower = costs.zip(around).min_by(|a, b| a.0.total_cmp(&b.0));
            match lower {
                Some((lower, next)) if lower < cost => (cost, cell) = (lower, next),
                _ => return Ok(cost),
            }
        }
    }

    pub(super) fn simulated(&self, cells: &[Cell]) -> Result<Vec<Cost>> {
        self.costs(cells, false)
    }

    /// Without noise.
    pub(super) fn on_the_rig(&self, cells: &[Cell]) -> Result<Vec<Cost>> {
        self.costs(cells, true)
    }

    fn costs(&self, cells: &[Cell], is_true: bool) -> Result<Vec<Cost>> {
        let points = cells.iter().map(|&cell| self.grid.point(cell)).collect::<Result<Vec<_>, _>>()?;
        Ok(match &self.machine {
            Machine::Turbine(bat) => bat.costs(&points, if is_true { STAND_IN } else { MODEL }, |_| {}),
            Machine::Suspension => {
                let car = if is_true { Car::ON_THE_STAND } else { Car::SIMULATED };
                points.par_iter().map(|point| suspension::cost(car, point)).collect()
            }
        })
    }
}
