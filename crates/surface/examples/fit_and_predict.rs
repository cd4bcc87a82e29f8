//! Twelve runs of a design with two factors: the fit, what it says about itself, and the best cell of a grid.
#![expect(clippy::print_stdout, reason = "an example talks")]

use doe::{Design, Model, Space};
use surface::{Data, Error, GridPoints, Regression, Surface};

/// The center three times, so that pure error can be told from lack of fit.
const RUNS: [[f64; 2]; 12] = [
    [-1.0, -1.0],
    [0.0, -1.0],
    [1.0, -1.0],
    [-1.0, 0.0],
    [0.0, 0.0],
    [1.0, 0.0],
    [-1.0, 1.0],
    [0.0, 1.0],
    [1.0, 1.0],
    [0.0, 0.0],
    [0.0, 0.0],
    [0.5, 0.5],
];
const COSTS: [f64; 12] = [4.42, 3.35, 4.31, 1.95, 1.02, 2.11, 1.64, 0.77, 2.01, 0.94, 1.06, 0.71];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let model = Model::quadratic(2)?;
    let data = Data::of_design(&Design::from_runs(&RUNS)?, COSTS.to_vec())?;
    let fit = Regression::fit(&model, &data)?;
    let errors = fit.standard_errors().unwrap_or_default();
    println!("term    coefficient  standard error");
    for ((name, b), error) in model.term_names(&["a", "b"]).iter().zip(fit.coefficients()).zip(&errors) {
        println!("{name:6}  {b:11.3}  {error:14.3}");
    }
    let test = fit.lack_of_fit()?;
    print!("R^2 {:.4}, ", fit.r_squared().unwrap_or(f64::NAN));
    print!("leave-one-out error {:.3}, ", fit.leave_one_out()?.rms());
    print!("lack of fit F({}, {}) = {:.2}, ", test.lack_of_fit_degrees, test.pure_error_degrees, test.f);
    println!("p = {:.2}", test.p_value);

    let cells = GridPoints::of_space(&Space::grid(&[201, 201])?)?;
    let lowest = fit.minimum_over(&cells)?.ok_or(Error::Count { name: "cells", found: 0, least: 1, most: 1 })?;
    let point = cells.point(lowest.index).unwrap_or_default();
    let spread = fit.variance(&point).map_or(f64::NAN, f64::sqrt);
    println!("lowest at a = {:.2}, b = {:.2}: {:.3} +- {spread:.3}", point[0], point[1], lowest.value);
    Ok(())
}
