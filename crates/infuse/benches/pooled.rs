//! Asking for a batch of the pooled loop, and assessing all experiments so far: `cargo bench -p infuse-loop --bench pooled`, with
//! `RAYON_NUM_THREADS=1` on one thread.

use design_space::{Cell, Parameter, Region};
use divan::Bencher;
use infuse::{Outcome, pooled};

fn main() {
    divan::main();
}

fn truth(p: &[f64]) -> f64 {
    p.iter().map(|x| (x - 0.3).powi(2)).sum::<f64>() + 0.3 * (4.0 * p[0]).sin()
}

#[expect(clippy::unnecessary_wraps, reason = "the loop takes simulations that can fail")]
fn simulation(_: Cell, p: &[f64]) -> Result<f64, String> {
    Ok(truth(p) + 0.5 * p[0])
}

/// A campaign over 24 levels of k factors after so many experiments, spread over the grid.
fn told(k: usize, n_experiments: u64) -> pooled::Loop {
    let parameter = |j: usize| Parameter::continuous(format!("p{j}"), "", -1.0, 1.0)?.with_levels(24);
    let region = Region::new((0..k).map(parameter).collect::<Result<_, _>>().expect("levels")).expect("a region");
    let mut campaign = pooled::Loop::new(&region, pooled::Settings::new(18)).expect("a campaign");
    let step = campaign.grid().n_cells() / n_experiments;
    let cells: Vec<Cell> = (0..n_experiments).map(|number| Cell::new(number * step + 7919 * number % step)).collect();
    for trial in campaign.hand_out(&cells).expect("cells of the grid") {
        let noise = 0.05 * (12.9898 * trial.id.number() as f64).sin();
        campaign.tell(trial.id, Outcome::Value(truth(&trial.point) + noise)).expect("an outstanding trial");
    }
    campaign
}

fn ask(bencher: Bencher, k: usize, n_experiments: u64) {
    bencher
        .with_inputs(|| told(k, n_experiments))
        .bench_local_values(|mut campaign| campaign.ask(Some(&mut simulation)).expect("a batch"));
}

fn assess(bencher: Bencher, k: usize, n_experiments: u64) {
    bencher
        .with_inputs(|| told(k, n_experiments))
        .bench_local_values(|mut campaign| campaign.assess(Some(&mut simulation)).expect("a fit"));
}

#[divan::bench(sample_count = 3, sample_size = 1)]
fn ask_four_factors_90_experiments(bencher: Bencher) {
    ask(bencher, 4, 90);
}

#[divan::bench(sample_count = 3, sample_size = 1)]
fn assess_four_factors_90_experiments(bencher: Bencher) {
    assess(bencher, 4, 90);
}

#[divan::bench(sample_count = 3, sample_size = 1)]
fn ask_six_factors_90_experiments(bencher: Bencher) {
    ask(bencher, 6, 90);
}

#[divan::bench(sample_count = 3, sample_size = 1)]
fn assess_six_factors_90_experiments(bencher: Bencher) {
    assess(bencher, 6, 90);
}
