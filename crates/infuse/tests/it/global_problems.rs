//! Gridded problems with known answers.

use design_space::{Cell, Model, Parameter, Region};
use infuse::global;

/// Parameters named p0, p1, ... from 10 to 14, so that natural and coded coordinates differ.
pub(crate) fn grid(levels: &[u32]) -> Region {
    let parameter = |(index, &count): (usize, &u32)| {
        Parameter::continuous(format!("p{index}"), "m", 10.0, 14.0).unwrap().with_levels(count).unwrap()
    };
    Region::new(levels.iter().enumerate().map(parameter).collect()).unwrap()
}

/// Coded coordinates of a natural point of [`grid`].
pub(crate) fn coded(point: &[f64]) -> Vec<f64> {
    point.iter().map(|x| (x - 12.0) / 2.0).collect()
}

/// Settings for few searches: the tests are about the loop.
pub(crate) fn settings(model: Model, n_experiments: usize, n_simulations: usize) -> global::Settings {
    let mut settings = global::Settings::new(model, n_experiments, n_simulations);
    settings.design_starts = 1;
    settings
}

/// Two parameters, 24 levels each, the full quadratic, 12 experiments and 18 simulations.
pub(crate) fn planar() -> (Region, global::Settings) {
    (grid(&[24, 24]), settings(Model::quadratic(2).unwrap(), 12, 18))
}

/// The truth of the planted pair: coupled, smallest at (0.5, -0.3) in coded coordinates.
pub(crate) fn truth(point: &[f64]) -> f64 {
    let x = coded(point);
    let (a, b) = (x[0] - 0.5, x[1] + 0.3);
    3.0 + 1.2 * a * a + 0.8 * a * b + 1.5 * b * b
}

/// Its simulation: an affine bias moves the optimum to the other side.
#[expect(clippy::unnecessary_wraps, reason = "the loop takes simulations that can fail")]
pub(crate) fn simulation(_: Cell, point: &[f64]) -> Result<f64, String> {
    let x = coded(point);
    Ok(truth(point) + 1.0 + 2.2 * x[0] - 1.6 * x[1])
}

/// The experiment: the truth with an error of at most 0.02 that depends on the trial only.
pub(crate) fn experiment(trial: &global::Trial) -> f64 {
    truth(&trial.point) + 0.02 * (12.9898 * trial.id.number() as f64).sin()
}

pub(crate) fn asked(ask: global::Ask) -> Vec<global::Trial> {
    match ask {
        global::Ask::Trials(trials) => trials,
        global::Ask::Stopped(reason) => panic!("the campaign has ended: {reason:?}"),
    }
}

/// The planted campaign after this many batches.
pub(crate) fn after(n_batches: usize, mut settings: global::Settings) -> global::Loop {
    settings.max_batches = n_batches;
    let mut campaign = global::Loop::new(&grid(&[24, 24]), settings).unwrap();
    campaign.run(&mut simulation, &mut |trial| Ok(experiment(trial))).unwrap();
    campaign
}

/// The smallest value of a function over all cells, and where.
pub(crate) fn least(campaign: &global::Loop, cost: impl Fn(&[f64]) -> f64) -> (Cell, f64) {
    let values = campaign.grid().cells().map(|cell| (cell, cost(&campaign.point(cell).unwrap())));
    values.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap()
}

pub(crate) fn save(campaign: &global::Loop) -> String {
    serde_json::to_string(campaign).unwrap()
}
