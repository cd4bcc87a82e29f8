//! The same coupled problem by the four strategies of combined plant and controller optimization.

use design_space::{Parameter, Region};
use infuse::codesign::{OptimizerSettings, Strategy, codesign};
use infuse::{CodesignProblem, Error, Role};

/// Two basins along the diagonal: the best is at (0.523, 0.523) with −0.102.
fn cost(p: &[f64]) -> Result<f64, String> {
    let (along, across) = (0.5 * (p[0] + p[1]), p[0] - p[1]);
    Ok(4.0 * (along * along - 0.25).powi(2) - 0.2 * along + 6.0 * across * across)
}

#[expect(clippy::print_stdout, reason = "an example shows what it computes")]
fn main() -> Result<(), Error> {
    let region = Region::new(vec![
        Parameter::continuous("plant", "1", -1.0, 1.0)?,
        Parameter::continuous("controller", "1", -1.0, 1.0)?,
    ])?;
    let problem = CodesignProblem::new(region, vec![Role::Plant, Role::Controller])?;
    for strategy in [Strategy::Nested, Strategy::Simultaneous, Strategy::Sequential, Strategy::Iterative] {
        let mut settings = OptimizerSettings::default();
        settings.strategy = strategy;
        let found = codesign(&problem, &settings, &[-0.5, -0.5], &mut cost)?;
        println!(
            "{:<12} {:>6.3} {:>6.3}  cost {:>6.3}  {:>3} simulations",
            strategy.to_string(),
            found.point[0],
            found.point[1],
            found.cost,
            found.n_simulations
        );
    }
    Ok(())
}
