//! Time until a G search has 99 % of the best design known, the one in `fixtures/doe`.
//!
//! The reference is the exact maximum of the prediction variance of one design of the same size: read the searches as so
//! many of those, because seconds mean nothing from one machine to the next.

use divan::{Bencher, black_box};
use doe::{Criterion, Design, Model, PredictionVariance, Problem, Settings, Space, search};

const MANIFEST: &str = include_str!("../../../fixtures/doe/manifest.csv");
const SIZES: [(usize, usize); 4] = [(2, 8), (3, 12), (4, 18), (5, 26)];

fn main() {
    divan::main();
}

fn best_known(k: usize, n: usize) -> f64 {
    let prefix = format!("{k},{n},");
    let line = MANIFEST.lines().find(|line| line.starts_with(&prefix)).expect("a design of this size");
    line.split(',').nth(3).and_then(|text| text.parse().ok()).expect("a number of per cent")
}

fn problem(k: usize, n: usize) -> Problem {
    let (model, cube) = (Model::quadratic(k).expect("a model"), Space::cube(k).expect("a cube"));
    Problem::new(model, cube, n, Criterion::G).expect("a problem")
}

/// The seed changes from one sample to the next, so that luck averages out.
#[divan::bench(args = SIZES, sample_count = 20, sample_size = 1)]
fn to_99_percent_of_the_best_known(bencher: Bencher<'_, '_>, (k, n): (usize, usize)) {
    let problem = problem(k, n);
    let mut settings = Settings::default();
    settings.starts = 100_000;
    settings.target_percent = Some(0.99 * best_known(k, n));
    settings.seed = 0;
    bencher.bench_local(|| {
        settings.seed += 1;
        search(black_box(&problem), &settings).expect("a design")
    });
}

#[divan::bench(args = SIZES)]
fn reference_one_maximum_over_the_cube(bencher: Bencher<'_, '_>, (k, n): (usize, usize)) {
    let mut settings = Settings::default();
    settings.starts = 4;
    let problem = problem(k, n);
    let design: Design = search(&problem, &settings).expect("a design").design;
    let variance = PredictionVariance::of(problem.model(), &design).expect("not singular");
    bencher.bench_local(|| variance.maximum(black_box(problem.space())).expect("a maximum"));
}
