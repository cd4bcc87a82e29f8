//! How the splits compare: error of the fit, and how well the validation runs tell it.
//!
//! Responses that are quadratic, or quadratic with a part that no quadratic has, are measured with noise at the runs of
//! G-optimal designs and of Latin hypercubes, and fitted to the training runs. The error of the fit is taken over
//! 2,000 points of the cube, the estimate over the validation runs. `split_study [repetitions]`.

use std::collections::BTreeMap;
use std::error::Error;
use std::io::{Write as _, stdout};

use doe::{
    Criterion, Design, Effort, Information, Model, Problem, Settings, Space, SplitMethod, SplitSettings, search, split,
};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// Factors, runs, and whether the model has products.
const CASES: [(usize, usize, bool); 5] = [(2, 12, true), (2, 16, false), (3, 20, true), (3, 24, true), (4, 18, false)];
const METHODS: [(&str, Option<SplitMethod>); 4] = [
    ("random halves", None),
    ("alternating (5.1, chain)", Some(SplitMethod::Alternating)),
    ("alternating (from mean)", Some(SplitMethod::AlternatingFromMean)),
    ("balanced", Some(SplitMethod::Balanced)),
];
const ALL_RUNS: &str = "no split, leave one out";

/// Logarithms of the error of the fit, and of the estimate over the error, noise included in both of the latter.
type Record = Vec<[f64; 2]>;

fn main() -> Result<(), Box<dyn Error>> {
    let repetitions: usize = std::env::args().nth(1).map_or(Ok(2), |text| text.parse())?;
    let mut generator = Pcg64::seed_from_u64(5);
    let mut records: BTreeMap<(bool, &str), Record> = BTreeMap::new();
    for (k, n, has_products) in CASES {
        let model = if has_products { Model::quadratic(k)? } else { Model::additive_quadratic(k)? };
        let space = Space::cube(k)?;
        for repetition in 0..repetitions {
            for is_optimal in [true, false] {
                let design = if is_optimal {
                    let mut settings = Settings::default();
                    (settings.seed, settings.starts, settings.effort) = (repetition as u64, 3, Effort::Quick);
                    search(&Problem::new(model.clone(), space.clone(), n, Criterion::G)?, &settings)?.design
                } else {
                    latin_hypercube(k, n, &mut generator)?
                };
                study(&model, &space, &design, &mut generator, |name, record| {
                    records.entry((is_optimal, name)).or_default().push(record);
                })?;
            }
        }
    }
    for (is_optimal, title) in [(true, "G-optimal designs"), (false, "Latin hypercubes")] {
        writeln!(stdout(), "{title}\n{:<26}{:>14}{:>22}{:>10}", "", "error of fit", "log(estimate/error)", "")?;
        writeln!(stdout(), "{:<26}{:>14}{:>22}{:>10}", "", "/ alternating", "mean", "rms")?;
        let mean = |name, at: usize| {
            let record = &records[&(is_optimal, name)];
            record.iter().map(|pair: &[f64; 2]| pair[at]).sum::<f64>() / record.len() as f64
        };
        for name in METHODS.iter().map(|method| method.0).chain([ALL_RUNS]) {
            let record = &records[&(is_optimal, name)];
            let rms = (record.iter().map(|pair| pair[1] * pair[1]).sum::<f64>() / record.len() as f64).sqrt();
            let ratio = (mean(name, 0) - mean(METHODS[1].0, 0)).exp();
            writeln!(stdout(), "{name:<26}{ratio:>14.2}{:>22.2}{rms:>10.2}", mean(name, 1))?;
        }
        writeln!(stdout())?;
    }
    Ok(())
}

fn study(
    model: &Model,
    space: &Space,
    design: &Design,
    generator: &mut Pcg64,
    mut record: impl FnMut(&'static str, [f64; 2]),
) -> Result<(), Box<dyn Error>> {
    let (k, n) = (design.n_factors(), design.n_runs());
    let mut sides: Vec<(&str, Vec<usize>, Vec<usize>)> = Vec::new();
    for (name, method) in METHODS {
        let halves = match method {
            Some(method) => {
                let mut settings = SplitSettings::default();
                settings.method = method;
                split(model, space, design, &settings)?
            }
            None => loop {
                // Half of the runs at random, again until they determine the model.
                let order = shuffled(n, generator);
                let (training, validation) = order.split_at(n.div_ceil(2));
                let halves = doe::Split {
                    training: training.to_vec(),
                    validation: validation.to_vec(),
                    repaired: 0,
                    confounded: Vec::new(),
                };
                if Information::of(model, &halves.training_design(design)?).is_ok() {
                    break halves;
                }
            },
        };
        sides.push((name, halves.training, halves.validation));
    }
    sides.push((ALL_RUNS, (0..n).collect(), Vec::new()));

    let points: Vec<Vec<f64>> = (0..2000).map(|_| (0..k).map(|_| uniform(generator)).collect()).collect();
    for _ in 0..8 {
        let response = Response::random(k, generator);
        for noise in [0.02, 0.15] {
            let measured: Vec<f64> = design.runs().map(|run| response.at(run) + noise * normal(generator)).collect();
            for (name, training, validation) in &sides {
                let fit = Fit::of(model, design, training, &measured)?;
                let squares = points.iter().map(|point| Ok((fit.at(point)? - response.at(point)).powi(2)));
                let square = squares.sum::<Result<f64, doe::Error>>()? / points.len() as f64;
                let runs: Vec<&[f64]> = design.runs().collect();
                let estimate = if validation.is_empty() {
                    let residual =
                        |run: usize| Ok((measured[run] - fit.at(runs[run])?) / (1.0 - fit.leverage(runs[run])?));
                    (0..n).map(|run| residual(run).map(|e: f64| e * e)).sum::<Result<f64, doe::Error>>()? / n as f64
                } else {
                    let residual = |&run: &usize| Ok((measured[run] - fit.at(runs[run])?).powi(2));
                    validation.iter().map(residual).sum::<Result<f64, doe::Error>>()? / validation.len() as f64
                };
                record(name, [0.5 * square.ln(), 0.5 * (estimate / (square + noise * noise)).ln()]);
            }
        }
    }
    Ok(())
}

/// Least squares.
struct Fit {
    model: Model,
    information: Information,
    coefficients: Vec<f64>,
}

impl Fit {
    fn of(model: &Model, design: &Design, runs: &[usize], measured: &[f64]) -> Result<Self, doe::Error> {
        let (k, p) = (design.n_factors(), model.n_terms());
        let chosen = runs.iter().flat_map(|run| &design.coordinates()[run * k..][..k]).copied().collect();
        let information = Information::of(model, &Design::new(k, chosen)?)?;
        let mut sums = vec![0.0; p];
        for &run in runs {
            let regressor = model.regressor(&design.coordinates()[run * k..][..k])?;
            sums.iter_mut().zip(regressor).for_each(|(sum, value)| *sum += value * measured[run]);
        }
        let row = |j: usize| information.inverse()[j * p..][..p].iter().zip(&sums).map(|(a, b)| a * b).sum();
        let coefficients = (0..p).map(row).collect();
        Ok(Self { model: model.clone(), information, coefficients })
    }

    fn at(&self, point: &[f64]) -> Result<f64, doe::Error> {
        Ok(self.model.regressor(point)?.iter().zip(&self.coefficients).map(|(a, b)| a * b).sum())
    }

    fn leverage(&self, point: &[f64]) -> Result<f64, doe::Error> {
        self.information.variance(&self.model.regressor(point)?)
    }
}

/// A quadratic with squares, and products that the additive model misses, plus a wave of random height.
struct Response {
    linear: Vec<f64>,
    square: Vec<f64>,
    wave: Vec<f64>,
    phase: f64,
    height: f64,
}

impl Response {
    fn random(k: usize, generator: &mut Pcg64) -> Self {
        let mut numbers = |scale: f64| (0..k).map(|_| scale * normal(generator)).collect();
        let (linear, square, wave) = (numbers(0.4), numbers(0.4), numbers(1.2));
        let height = if generator.random::<bool>() { 0.4 } else { 0.0 };
        Self { linear, square, wave, phase: 3.0 * uniform(generator), height }
    }

    fn at(&self, x: &[f64]) -> f64 {
        let dot = |a: &[f64]| a.iter().zip(x).map(|(a, x)| a * x).sum::<f64>();
        let squares: f64 = self.square.iter().zip(x).map(|(a, x)| a * x * x).sum();
        dot(&self.linear) + squares + self.height * (dot(&self.wave) + self.phase).sin()
    }
}

fn latin_hypercube(k: usize, n: usize, generator: &mut Pcg64) -> Result<Design, doe::Error> {
    let columns: Vec<Vec<usize>> = (0..k).map(|_| shuffled(n, generator)).collect();
    let cells = (0..n).flat_map(|run| columns.iter().map(move |column| column[run] as f64));
    Design::new(k, cells.map(|cell| 2.0 * (cell + generator.random::<f64>()) / n as f64 - 1.0).collect())
}

fn shuffled(n: usize, generator: &mut Pcg64) -> Vec<usize> {
    let mut order: Vec<usize> = (0..n).collect();
    for last in (1..n).rev() {
        order.swap(last, generator.random_range(0..=last));
    }
    order
}

fn uniform(generator: &mut Pcg64) -> f64 {
    2.0 * generator.random::<f64>() - 1.0
}

/// Box and Muller.
fn normal(generator: &mut Pcg64) -> f64 {
    let (radius, angle) = (1.0 - generator.random::<f64>(), generator.random::<f64>());
    (-2.0 * radius.ln()).sqrt() * (std::f64::consts::TAU * angle).cos()
}
