//! Batch prediction over 24⁴ = 331,776 points from 54 data in four factors, against plain scalar loops.
//!
//! `cargo xtask speed` measures the same tasks beside numpy and scipy.

use std::hint::black_box;

use divan::Bencher;
use divan::counter::ItemsCount;
use doe::{Model, Space};
use surface::{Data, GridPoints, InverseDistance, PointSource, Regression, SquaredExponential, Surface};

const N_FACTORS: usize = 4;
const N_DATA: usize = 54;
const N_POINTS: usize = 331_776;
const SCALE: f64 = 1.5;

fn main() {
    divan::main();
}

/// Points that fill the box evenly, with a smooth response.
fn data() -> Data {
    let coordinate = |point: usize, factor: usize| {
        let step = [0.856_674_883_854_502_9, 0.733_891_856_627_126, 0.628_706_721_041_338_8, 0.538_597_250_065_5];
        2.0 * ((point as f64 + 0.5) * step[factor]).fract() - 1.0
    };
    let points: Vec<f64> = (0..N_DATA).flat_map(|i| (0..N_FACTORS).map(move |j| coordinate(i, j))).collect();
    let value = |x: &[f64]| 1.0 + x[0] * x[1] + x[2].sin() + x[3] * x[3];
    let values = points.chunks_exact(N_FACTORS).map(value).collect();
    Data::new(N_FACTORS, points, values).expect("valid data")
}

fn grid() -> GridPoints {
    let space = Space::grid(&[24; N_FACTORS]).expect("a valid grid");
    GridPoints::of_space(&space).expect("a grid")
}

fn points() -> Vec<f64> {
    let grid = grid();
    (0..grid.n_points()).flat_map(|index| grid.point(index).unwrap_or_default()).collect()
}

fn bench_surface(bencher: Bencher<'_, '_>, n_threads: usize, surface: &dyn Surface) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().expect("a pool of threads");
    let (points, mut estimates) = (points(), vec![0.0; N_POINTS]);
    bencher.counter(ItemsCount::new(N_POINTS)).bench_local(|| {
        pool.install(|| surface.predict_into(black_box(&points), &mut estimates)).expect("as many places as points");
        black_box(&estimates);
    });
}

/// No points in memory: tables of the axes serve them all.
fn bench_grid(bencher: Bencher<'_, '_>, n_threads: usize, surface: &dyn Surface) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().expect("a pool of threads");
    let (grid, mut estimates) = (grid(), vec![0.0; N_POINTS]);
    bencher.counter(ItemsCount::new(N_POINTS)).bench_local(|| {
        pool.install(|| surface.predict_range(black_box(&grid), 0, &mut estimates)).expect("as many as points");
        black_box(&estimates);
    });
}

fn bench_loop(bencher: Bencher<'_, '_>, estimate: impl Fn(&[f64]) -> f64) {
    let (points, mut estimates) = (points(), vec![0.0; N_POINTS]);
    bencher.counter(ItemsCount::new(N_POINTS)).bench_local(|| {
        for (point, place) in black_box(&points).chunks_exact(N_FACTORS).zip(&mut estimates) {
            *place = estimate(point);
        }
        black_box(&estimates);
    });
}

/// Σ ω J / Σ ω as it is written down.
fn plain_average(data: &Data, point: &[f64], omega: impl Fn(f64) -> f64) -> f64 {
    let (mut total, mut sum) = (0.0, 0.0);
    for (datum, value) in data.points().zip(data.values()) {
        let square: f64 = datum.iter().zip(point).map(|(a, b)| (a - b) * (a - b)).sum();
        let omega = omega(square);
        total += omega;
        sum += omega * value;
    }
    sum / total
}

#[divan::bench_group(sample_count = 20, sample_size = 1)]
mod inverse_distance {
    use super::*;

    #[divan::bench(args = [1, 2])]
    fn threads(bencher: Bencher<'_, '_>, n_threads: usize) {
        bench_surface(bencher, n_threads, &InverseDistance::fit(data(), 2.0).expect("a valid power"));
    }

    #[divan::bench(args = [1, 2])]
    fn grid_threads(bencher: Bencher<'_, '_>, n_threads: usize) {
        bench_grid(bencher, n_threads, &InverseDistance::fit(data(), 2.0).expect("a valid power"));
    }

    #[divan::bench]
    fn scalar_loop(bencher: Bencher<'_, '_>) {
        let data = data();
        bench_loop(bencher, |point| plain_average(&data, point, |square| 1.0 / square));
    }
}

#[divan::bench_group(sample_count = 20, sample_size = 1)]
mod squared_exponential {
    use super::*;

    #[divan::bench(args = [1, 2])]
    fn threads(bencher: Bencher<'_, '_>, n_threads: usize) {
        bench_surface(bencher, n_threads, &SquaredExponential::fit(data(), SCALE).expect("a valid scale"));
    }

    #[divan::bench(args = [1, 2])]
    fn grid_threads(bencher: Bencher<'_, '_>, n_threads: usize) {
        bench_grid(bencher, n_threads, &SquaredExponential::fit(data(), SCALE).expect("a valid scale"));
    }

    #[divan::bench]
    fn scalar_loop(bencher: Bencher<'_, '_>) {
        let data = data();
        bench_loop(bencher, |point| plain_average(&data, point, |square| (-SCALE * SCALE * square).exp()));
    }
}

#[divan::bench_group(sample_count = 20, sample_size = 1)]
mod regression {
    use super::*;

    fn fitted() -> Regression {
        let model = Model::quadratic(N_FACTORS).expect("a valid model");
        Regression::fit(&model, &data()).expect("enough data")
    }

    #[divan::bench(args = [1, 2])]
    fn threads(bencher: Bencher<'_, '_>, n_threads: usize) {
        bench_surface(bencher, n_threads, &fitted());
    }

    #[divan::bench(args = [1, 2])]
    fn grid_threads(bencher: Bencher<'_, '_>, n_threads: usize) {
        bench_grid(bencher, n_threads, &fitted());
    }

    #[divan::bench]
    fn scalar_loop(bencher: Bencher<'_, '_>) {
        let surface = fitted();
        bench_loop(bencher, |point| {
            let terms = surface.model().terms().iter().zip(surface.coefficients());
            terms.map(|(term, coefficient)| coefficient * term.value(point)).sum()
        });
    }
}

/// A slice of 2048 points in one thread: short enough to be measured on a machine that does other things too.
#[divan::bench_group]
mod slice {
    use super::*;

    const N_SLICE: usize = 2048;

    fn bench_slice(bencher: Bencher<'_, '_>, mut estimate: impl FnMut(&[f64], &mut [f64])) {
        let (points, mut estimates) = (points(), [0.0; N_SLICE]);
        bencher.counter(ItemsCount::new(N_SLICE)).bench_local(|| {
            estimate(black_box(&points[..N_SLICE * N_FACTORS]), &mut estimates);
            black_box(&estimates);
        });
    }

    fn bench_surface(bencher: Bencher<'_, '_>, surface: &dyn Surface) {
        bench_slice(bencher, |points, estimates| surface.predict_into(points, estimates).expect("lengths agree"));
    }

    fn bench_loop(bencher: Bencher<'_, '_>, omega: impl Fn(f64) -> f64) {
        let data = data();
        bench_slice(bencher, |points, estimates| {
            for (point, place) in points.chunks_exact(N_FACTORS).zip(estimates) {
                *place = plain_average(&data, point, &omega);
            }
        });
    }

    #[divan::bench]
    fn inverse_distance(bencher: Bencher<'_, '_>) {
        bench_surface(bencher, &InverseDistance::fit(data(), 2.0).expect("a valid power"));
    }

    #[divan::bench]
    fn inverse_distance_scalar_loop(bencher: Bencher<'_, '_>) {
        bench_loop(bencher, |square| 1.0 / square);
    }

    #[divan::bench]
    fn squared_exponential(bencher: Bencher<'_, '_>) {
        bench_surface(bencher, &SquaredExponential::fit(data(), SCALE).expect("a valid scale"));
    }

    #[divan::bench]
    fn squared_exponential_scalar_loop(bencher: Bencher<'_, '_>) {
        bench_loop(bencher, |square| (-SCALE * SCALE * square).exp());
    }

    #[divan::bench]
    fn regression(bencher: Bencher<'_, '_>) {
        let model = Model::quadratic(N_FACTORS).expect("a valid model");
        bench_surface(bencher, &Regression::fit(&model, &data()).expect("enough data"));
    }
}

/// One point at a time, as an optimizer asks.
#[divan::bench_group]
mod single {
    use super::*;

    const POINT: [f64; N_FACTORS] = [0.1, -0.3, 0.7, 0.2];

    #[divan::bench]
    fn inverse_distance(bencher: Bencher<'_, '_>) {
        let surface = InverseDistance::fit(data(), 2.0).expect("a valid power");
        bencher.bench_local(|| surface.predict(black_box(&POINT)));
    }

    #[divan::bench]
    fn squared_exponential(bencher: Bencher<'_, '_>) {
        let surface = SquaredExponential::fit(data(), SCALE).expect("a valid scale");
        bencher.bench_local(|| surface.predict(black_box(&POINT)));
    }
}

#[divan::bench]
fn regression_fit_54_data_15_terms(bencher: Bencher<'_, '_>) {
    let (model, data) = (Model::quadratic(N_FACTORS).expect("a valid model"), data());
    bencher.bench_local(|| Regression::fit(black_box(&model), black_box(&data)));
}
