//! What is left becomes small, and the loop does not die of it.

use design_space::{Cell, Model};
use doe::{Criterion, Design, Space};
use infuse::global::{self, SpreadFallback};

use crate::global_problems::{coded, grid, settings};

/// A campaign over this grid with the additive quadratic, a bowl and a biased simulation.
fn bowl(levels: &[u32], fallback: SpreadFallback) -> global::Loop {
    let model = Model::additive_quadratic(levels.len()).unwrap();
    let n_terms = model.n_terms();
    let mut settings = settings(model, n_terms.max(6), n_terms.max(8));
    settings.fallback = fallback;
    settings.max_batches = 5;
    global::Loop::new(&grid(levels), settings).unwrap()
}

fn cost(point: &[f64]) -> f64 {
    coded(point).iter().map(|x| (x - 0.4).powi(2)).sum()
}

fn run(campaign: &mut global::Loop) -> global::StopReason {
    let mut simulated = |_: Cell, p: &[f64]| Ok(cost(p) + 0.3 * coded(p)[0]);
    let noise = |number: u64| 0.01 * (78.233 * number as f64).sin();
    campaign.run(&mut simulated, &mut |trial| Ok(cost(&trial.point) + noise(trial.id.number()))).unwrap()
}

#[test]
fn two_levels_confound_the_square_with_the_constant_and_say_so() {
    let mut campaign = bowl(&[2, 2], SpreadFallback::KeepAll);
    run(&mut campaign);
    let batch = &campaign.reports()[0].batch;
    let names: Vec<_> = batch.dropped_terms.iter().map(|term| (term.term, term.name.as_str())).collect();
    assert_eq!(names, [(3, "p0^2"), (4, "p1^2")]);
    assert_eq!(batch.dropped_terms[0].equals.len(), 1);
    assert_eq!(batch.dropped_terms[0].equals[0].0, "1");
    assert!((batch.dropped_terms[0].equals[0].1 - 1.0).abs() < 1e-12);
    // Four cells, six experiments: every cell, and two of them again.
    let mut cells: Vec<Cell> = campaign.reports()[0].trials.iter().map(|record| record.trial.cell).collect();
    cells.sort_unstable();
    cells.dedup();
    assert_eq!(cells, [0, 1, 2, 3].map(Cell::new));
}

#[test]
fn one_parameter_with_two_levels_is_decided() {
    let mut campaign = bowl(&[2], SpreadFallback::KeepAll);
    assert_eq!(run(&mut campaign), global::StopReason::FewerThanTwoCells);
    assert_eq!(campaign.retained().cells().collect::<Vec<_>>(), [Cell::new(1)]);
}

#[test]
fn a_single_cell_ends_the_campaign_with_that_reason() {
    let mut campaign = bowl(&[24, 24], SpreadFallback::Given(1e-9));
    // Exact data, so that the given S is used.
    let stop = campaign.run(&mut |_, p| Ok(cost(p)), &mut |trial| Ok(cost(&trial.point))).unwrap();
    assert_eq!(stop, global::StopReason::FewerThanTwoCells);
    assert_eq!(campaign.retained().n_retained(), 1);
    assert_eq!(campaign.reports().len(), 1);
}

#[test]
fn an_axis_that_is_left_with_one_level_loses_its_terms() {
    // Along p0 the cost is so steep that one level is left, along p1 nothing happens at all.
    let steep = |p: &[f64]| 1.0 + 1e3 * (coded(p)[0] - 0.2).powi(2);
    let mut campaign = bowl(&[11, 7], SpreadFallback::Given(0.1));
    let stop = campaign.run(&mut |_, p| Ok(steep(p)), &mut |trial| Ok(steep(&trial.point))).unwrap();
    assert_eq!(stop, global::StopReason::BatchLimit);
    let second = &campaign.reports()[1];
    assert_eq!(second.screening.n_before, 7);
    let names: Vec<_> = second.batch.dropped_terms.iter().map(|term| term.name.as_str()).collect();
    assert_eq!(names, ["p0", "p0^2"]);
    assert!((campaign.reports()[4].screening.optimum[0] - 12.4).abs() < 1e-12);
}

#[test]
fn grids_of_a_few_cells_run_to_an_end() {
    for levels in [&[2][..], &[3], &[4], &[2, 2], &[3, 2], &[2, 2, 2], &[5, 2], &[3, 3], &[2, 2, 2, 2]] {
        for fallback in [SpreadFallback::KeepAll, SpreadFallback::Given(0.05)] {
            let mut campaign = bowl(levels, fallback);
            run(&mut campaign);
            assert!(campaign.retained().n_retained() >= 1, "{levels:?}");
            let last = campaign.reports().last().unwrap();
            assert!(last.batch.experiment_efficiency > 0.0, "{levels:?}");
        }
    }
}

#[test]
fn a_large_grid_is_represented_by_a_part_of_it() {
    let mut settings = settings(Model::quadratic(3).unwrap(), 12, 14);
    settings.candidate_limit = Some(1000);
    settings.max_batches = 2;
    let region = grid(&[24, 24, 24]);
    let mut campaign = global::Loop::new(&region, settings).unwrap();
    run(&mut campaign);
    let batch = &campaign.reports()[0].batch;
    assert!((950..1100).contains(&batch.n_candidates), "{batch:?}");
    // The corners, where predictions are worst, are among the candidates: over the whole grid the design is as good.
    let points = campaign.reports()[0].trials.iter().map(|record| coded(&record.trial.point));
    let design = Design::from_runs(&points.collect::<Vec<_>>()).unwrap();
    let grid = Space::grid(&[24, 24, 24]).unwrap();
    let everywhere = Criterion::G.efficiency(&Model::quadratic(3).unwrap(), &grid, &design).unwrap().percent;
    assert!(everywhere <= batch.experiment_efficiency + 1e-9);
    assert!(everywhere > 0.97 * batch.experiment_efficiency, "{everywhere} {batch:?}");
}

#[test]
fn a_model_of_which_nothing_is_left_becomes_a_constant() {
    let model = Model::new(2, vec![design_space::Term::new(vec![2, 0])]).unwrap();
    let mut settings = settings(model, 6, 8);
    settings.fallback = SpreadFallback::Given(0.1);
    settings.max_batches = 3;
    let mut campaign = global::Loop::new(&grid(&[11, 7]), settings).unwrap();
    // Steep in p0 only, so that the middle level of p0 is left, where its square vanishes.
    let steep = |p: &[f64]| 1e3 * coded(p)[0].powi(2);
    let mut rig = |trial: &infuse::global::Trial| Ok(steep(&trial.point));
    assert_eq!(campaign.run(&mut |_, p| Ok(steep(p)), &mut rig).unwrap(), global::StopReason::BatchLimit);
    let batches: Vec<_> = campaign.reports().iter().map(|report| &report.batch).collect();
    assert_eq!(batches[1].n_candidates, 7);
    assert_eq!(batches.iter().map(|batch| batch.constant_instead).collect::<Vec<_>>(), [false, true, true]);
    assert!(batches[1].dropped_terms[0].name == "p0^2" && batches[1].dropped_terms[0].equals.is_empty());
    // 6 runs determine a constant to 1/6 of the variance, as do all designs of 6 runs.
    assert!((batches[1].experiment_efficiency - 100.0).abs() < 1e-9, "{:?}", batches[1]);
    let regression = campaign.surfaces()[2].experiment.as_ref().unwrap().regression().unwrap().coefficients().to_vec();
    assert!(regression.len() == 1 && regression[0].abs() < 1e-12, "{regression:?}");
    let read: global::Loop = serde_json::from_str(&crate::global_problems::save(&campaign)).unwrap();
    assert_eq!(read, campaign);
}

/// Every cell is simulated, and inverse distance gives each its own cost back: what is left is what is cheap.
#[test]
fn a_level_that_is_left_in_two_cells_only_is_designed_for() {
    let model = Model::quadratic(3).unwrap();
    let mut settings = settings(model.clone(), 14, 12 * 10 * 12);
    let exact = infuse::global::SurfaceKind::InverseDistance { power: 2.0 };
    settings.surfaces = infuse::global::SurfaceKinds { experiment: exact, simulation: exact, combined: exact };
    settings.fallback = SpreadFallback::Given(0.1);
    settings.max_batches = 2;
    let region = grid(&[12, 10, 12]);
    let digits = |p: &[f64]| -> Vec<u32> {
        let pairs = region.parameters().iter().zip(p);
        pairs.map(|(parameter, &x)| parameter.nearest_level(x).unwrap()).collect()
    };
    let cost = |p: &[f64]| match digits(p)[..] {
        [_, 8 | 9, _] | [3, 4, 2] | [9, 4, 7] => 0.0,
        _ => 1e3,
    };
    let mut campaign = global::Loop::new(&region, settings).unwrap();
    campaign.run(&mut |_, p| Ok(cost(p)), &mut |trial| Ok(cost(&trial.point))).unwrap();
    let second = &campaign.reports()[1];
    assert_eq!(second.screening.n_before, 2 * 144 + 2);
    assert!(second.batch.dropped_terms.is_empty(), "{:?}", second.batch);
    let mut cells: Vec<Cell> = second.trials.iter().map(|record| record.trial.cell).collect();
    let rare = second.trials.iter().filter(|record| digits(&record.trial.point)[1] == 4).count();
    assert_eq!(rare, 2, "the square of p1 needs them");
    cells.sort_unstable();
    cells.dedup();
    assert_eq!(cells.len(), 14);
    assert!(second.batch.experiment_efficiency > 20.0, "{:?}", second.batch);
}
