//! Few dear experiments, many cheap simulations, pooled; the three surfaces of Chapter 5 compared on them.
#![expect(clippy::print_stdout, reason = "an example talks")]

use doe::Model;
use surface::{Confounded, Data, GridPoints, InverseDistance, Kind, compare};

/// A valley with a bend, and its simulation, which is too shallow.
fn experiment(x: &[f64]) -> f64 {
    (x[0] - 0.3).powi(2) + 2.0 * (x[1] - 0.4 * x[0] * x[0]).powi(2)
}

fn simulation(x: &[f64]) -> f64 {
    0.9 * experiment(x) + 0.1 * x[0]
}

fn data(levels: [usize; 2], response: fn(&[f64]) -> f64, weight: f64) -> Result<Data, surface::Error> {
    let axis = |n: usize| (0..n).map(|i| 2.0 * i as f64 / (n - 1) as f64 - 1.0).collect::<Vec<f64>>();
    let grid = GridPoints::new(levels.map(axis).to_vec())?;
    let points: Vec<Vec<f64>> = (0..levels[0] * levels[1]).filter_map(|index| grid.point(index as u64)).collect();
    let values = points.iter().map(|x| response(x)).collect();
    Data::new(2, points.concat(), values)?.weighted(weight)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let pooled = data([3, 3], experiment, 0.7)?.followed_by(&data([6, 6], simulation, 0.3)?)?;
    let kinds = [
        Kind::Regression { model: Model::quadratic(2)?, confounded: Confounded::Refuse },
        Kind::InverseDistance { power: InverseDistance::POWER },
        Kind::SquaredExponential { scale: None },
    ];
    let fine = data([41, 41], experiment, 1.0)?;
    println!("leave one out  to the truth  surface");
    for comparison in compare(&pooled, &kinds) {
        let surface = comparison.kind.fit(&pooled)?;
        let mut estimates = vec![0.0; fine.n_points()];
        surface.predict_into(fine.coordinates(), &mut estimates)?;
        let squares = estimates.iter().zip(fine.values()).map(|(a, b)| (a - b) * (a - b));
        let truth = (squares.sum::<f64>() / fine.n_points() as f64).sqrt();
        let name = match comparison.kind {
            Kind::Regression { .. } => "quadratic regression",
            Kind::InverseDistance { .. } => "inverse distance",
            Kind::SquaredExponential { .. } => "squared exponential",
        };
        println!("{:13.4}  {truth:12.4}  {name}", comparison.outcome?.rms());
    }
    Ok(())
}
