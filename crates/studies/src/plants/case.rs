//! The machines: what a design costs in the simulation and on the rig, and which of its parameters are built.

use anyhow::{Context as _, Result};
use design_space::{Cell, Grid, Parameter, Region};
use rayon::prelude::*;
use std::path::Path;

use super::formula;
use super::suspension::{self, Car};
use crate::bat::{Bat, MODEL, STAND_IN};
use crate::chapter7::Setup;
use crate::costs::Cost;
use crate::known::Known;

/// Machines that campaigns are run on.
pub(super) const N_CASES: usize = 3;
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
    /// On the rig, of the cells that are known.
    pub(super) costs: Known<Cell, Cost>,
    /// The lowest cost that was found, and what 80 % of all designs span.
    pub(super) best: f64,
    pub(super) spread: f64,
    /// The median of all designs.
    pub(super) typical: f64,
}

enum Machine {
    Turbine(Box<Bat>),
    Suspension,
    Formula,
}

impl Case {
    /// All, before anybody has [looked around](Self::look_around).
    pub(super) fn read(root: &Path) -> Result<[Self; N_CASES]> {
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
        let of_suspension = Self::of("suspension", words, region, vec![0, 1], Machine::Suspension)?;
        let words = "formula: what is built makes a ripple";
        let of_formula = Self::of("formula", words, formula::region()?, vec![0, 1], Machine::Formula)?;
        Ok([of_turbine, of_suspension, of_formula])
    }

    fn of(
        name: &'static str,
        words: &'static str,
        region: Region,
        plant: Vec<usize>,
        machine: Machine,
    ) -> Result<Self> {
        let grid = Grid::of(&region)?;
        let (costs, nan) = (Known::default(), f64::NAN);
        Ok(Self { name, words, region, grid, plant, machine, costs, best: nan, spread: nan, typical: nan })
    }

    /// Cells all over the grid.
    pub(super) fn cells(&self, n: u64) -> Vec<Cell> {
        let stride = 1_000_003;
        (0..n).map(|index| Cell::new(index * stride % self.grid.n_cells())).collect()
    }

    /// Finds out what designs cost, and which is the best.
    pub(super) fn look_around(&mut self) -> Result<()> {
        let cells = self.cells(SAMPLE);
        let costs: Vec<Option<f64>> = self.on_the_rig(&cells)?.into_iter().map(Result::ok).collect();
        let known: Vec<f64> = costs.iter().flatten().copied().collect();
        let at = |share: f64| page::quantile(&known, share).unwrap_or(f64::NAN);
        (self.spread, self.typical) = (at(0.9) - at(0.1), at(0.5));
        let mut order: Vec<(f64, Cell)> =
            costs.into_iter().zip(cells).filter_map(|(cost, cell)| Some((cost?, cell))).collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        let lowest = order.into_iter().take(STARTS).map(|start| self.descend(start));
        self.best = lowest.collect::<Result<Vec<f64>>>()?.into_iter().fold(f64::INFINITY, f64::min);
        Ok(())
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
        Ok(self.made(&self.points(cells)?, false))
    }

    /// Without noise.
    pub(super) fn on_the_rig(&self, cells: &[Cell]) -> Result<Vec<Cost>> {
        let points = self.points(cells)?;
        let of = |missing: &[usize]| missing.iter().map(|k| points[*k].clone()).collect::<Vec<_>>();
        Ok(self.costs.of(cells, |missing| self.made(&of(missing), true)))
    }

    /// The same, all flown or driven and none remembered.
    pub(super) fn anew(&self, cells: &[Cell]) -> Result<Vec<Cost>> {
        Ok(self.made(&self.points(cells)?, true))
    }

    fn points(&self, cells: &[Cell]) -> Result<Vec<Vec<f64>>> {
        Ok(cells.iter().map(|&cell| self.grid.point(cell)).collect::<Result<_, _>>()?)
    }

    fn made(&self, points: &[Vec<f64>], is_true: bool) -> Vec<Cost> {
        match &self.machine {
            Machine::Turbine(bat) => {
                let flown = bat.flown_costs(points, if is_true { STAND_IN } else { MODEL }, |_| {});
                flown.into_iter().map(|cost| cost.map_err(String::from)).collect()
            }
            Machine::Formula => {
                let of = if is_true { formula::truth } else { formula::simulation };
                points.iter().map(|point| Ok(of(point))).collect()
            }
            Machine::Suspension => {
                let car = if is_true { Car::ON_THE_STAND } else { Car::SIMULATED };
                points.par_iter().map(|point| suspension::cost(car, point)).collect()
            }
        }
    }
}
