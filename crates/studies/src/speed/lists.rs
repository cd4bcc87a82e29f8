//! How long a search over a list of 331,776 points takes to come close to the best.

use std::time::Duration;

use anyhow::Result;
use doe::{Criterion, Model, Problem, Settings, Space, search};

const K: usize = 4;
const LEVELS: u32 = 24;
/// Numbers of runs.
const RUNS: [usize; 2] = [18, 36];
const SEEDS: u64 = 10;
/// Share of the best at which a search ends.
const SHARE: f64 = 0.99;
/// What is the best is looked for on all threads for so long.
const BEST_OF: Duration = Duration::from_secs(60);
/// A search that takes longer is counted with this time.
const LONGEST: Duration = Duration::from_secs(120);
/// For the bar.
pub(super) const COUNT: usize = RUNS.len() * (SEEDS as usize + 1);
/// Nine of ten searches are meant to take no longer (s).
pub(super) const GOAL: f64 = 5.0;

/// Times of searches that are alike but for their seed.
#[derive(Debug)]
pub(super) struct Searched {
    pub(super) n_runs: usize,
    /// Per cent.
    pub(super) best: f64,
    pub(super) seconds: Vec<f64>,
}

/// One thread, ten seeds, the full quadratic; `done` gets each search.
pub(super) fn measured(mut done: impl FnMut()) -> Result<Vec<Searched>> {
    let level = |at: u32| (2.0 * f64::from(at) - f64::from(LEVELS - 1)) / f64::from(LEVELS - 1);
    let point = |cell: u32| (0..K as u32).map(move |j| level(cell / LEVELS.pow(j) % LEVELS));
    let list = Space::list(K, (0..LEVELS.pow(K as u32)).flat_map(point).collect::<Vec<f64>>())?;
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let mut all = Vec::new();
    for n_runs in RUNS {
        let problem = |space: &Space| Problem::new(Model::quadratic(K)?, space.clone(), n_runs, Criterion::G);
        let mut settings = Settings::default();
        settings.starts = u64::MAX;
        settings.time_limit = Some(BEST_OF);
        let best = search(&problem(&Space::grid(&[LEVELS; K])?)?, &settings)?.efficiency.percent;
        done();
        let problem = problem(&list)?;
        settings.time_limit = Some(LONGEST);
        settings.target_percent = Some(SHARE * best);
        let mut seconds = Vec::new();
        for seed in 1..=SEEDS {
            settings.seed = seed;
            let found = alone.install(|| search(&problem, &settings))?;
            seconds.push(found.report.elapsed.as_secs_f64());
            done();
        }
        all.push(Searched { n_runs, best, seconds });
    }
    Ok(all)
}
