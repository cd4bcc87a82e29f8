//! The lowest cost of a physics over the design space, without any loop.

use anyhow::Result;
use bat_dynamics::Fidelity;
use infuse::codesign::{OptimizerSettings, Strategy, codesign};
use infuse::{CodesignProblem, Role};

use super::file::Case;
use crate::gridded::FlownGrid;
use crate::variable::Variable;

/// The best design of a physics.
#[derive(Clone, Debug)]
pub(crate) struct Optimum {
    pub(crate) point: Vec<f64>,
    pub(crate) cost: f64,
}

impl Optimum {
    /// The lowest cell where all of the loop's cells are flown; otherwise the end of a search of its own, which starts at
    /// the lowest of the cells that are.
    pub(crate) fn of(case: &Case, grid: &FlownGrid, fidelity: Fidelity) -> Result<Self> {
        let (cell, cost) = grid.lowest()?;
        let start = case.flown.point(cell)?;
        if case.is_flown_whole() {
            return Ok(Self { point: start, cost });
        }
        let role = |variable: &Variable| match variable {
            Variable::PitchSetPoint => Role::Controller,
            Variable::CenterOfMass | Variable::HorizontalArea | Variable::VerticalArea => Role::Plant,
        };
        let roles = case.space.variables.iter().map(role).collect();
        let problem = CodesignProblem::new(case.space.region().clone(), roles)?;
        let mut settings = OptimizerSettings::default();
        settings.strategy = Strategy::Simultaneous;
        let found = codesign(&problem, &settings, &start, &mut |point| case.bat.cost(point, fidelity))?;
        Ok(if found.cost < cost { Self { point: found.point, cost: found.cost } } else { Self { point: start, cost } })
    }
}
