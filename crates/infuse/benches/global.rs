//! One batch of the dissertation's loop, and what of it is the scan over the cells: `cargo bench -p infuse-loop`.

use design_space::{Cell, Model, Parameter, Region};
use divan::Bencher;
use infuse::{Outcome, global};

fn main() {
    divan::main();
}

fn region(k: usize, levels: u32) -> Region {
    let parameter = |j: usize| Parameter::continuous(format!("p{j}"), "", -1.0, 1.0)?.with_levels(levels);
    Region::new((0..k).map(parameter).collect::<Result<_, _>>().expect("levels")).expect("a region")
}

fn truth(p: &[f64]) -> f64 {
    p.iter().map(|x| (x - 0.3).powi(2)).sum()
}

fn experiment(trial: &global::Trial) -> f64 {
    truth(&trial.point) + 0.05 * (12.9898 * trial.id.number() as f64).sin()
}

fn campaign(k: usize, levels: u32, n_experiments: usize, n_simulations: usize) -> global::Loop {
    let settings = global::Settings::new(Model::quadratic(k).expect("a model"), n_experiments, n_simulations);
    global::Loop::new(&region(k, levels), settings).expect("a campaign")
}

/// Designs, simulations, surfaces and screening of the first batch, all cells retained.
fn batch(campaign: &mut global::Loop) {
    let mut simulation = |_: Cell, p: &[f64]| Ok(truth(p) + 0.5 * p[0]);
    if let global::Ask::Trials(trials) = campaign.ask(&mut simulation).expect("a batch") {
        for trial in trials {
            campaign.tell(trial.id, Outcome::Value(experiment(&trial))).expect("an outcome");
        }
    }
}

fn bench(bencher: Bencher, k: usize, levels: u32, n_experiments: usize, n_simulations: usize) {
    bencher.with_inputs(|| campaign(k, levels, n_experiments, n_simulations)).bench_local_values(|mut campaign| {
        batch(&mut campaign);
        campaign
    });
}

#[divan::bench(sample_count = 5)]
fn two_parameters_24_levels(bencher: Bencher) {
    bench(bencher, 2, 24, 12, 24);
}

#[divan::bench(sample_count = 3)]
fn four_parameters_10_levels(bencher: Bencher) {
    bench(bencher, 4, 10, 18, 36);
}

#[divan::bench(sample_count = 1)]
fn four_parameters_24_levels(bencher: Bencher) {
    bench(bencher, 4, 24, 18, 36);
}

#[divan::bench(sample_count = 1)]
fn six_parameters_24_levels(bencher: Bencher) {
    bench(bencher, 6, 24, 30, 60);
}

/// The reference of the others: what reading one cell once takes, by a plain loop over the same grid.
#[divan::bench(sample_count = 1)]
fn reference_sum_of_squares_at_24_to_the_fourth(bencher: Bencher) {
    let region = region(4, 24);
    let grid = design_space::Grid::of(&region).expect("levels");
    bencher.bench_local(|| {
        grid.cells().map(|cell| truth(&grid.point(cell).expect("a cell"))).fold(f64::INFINITY, f64::min)
    });
}
