//! Norms, certificates and possible optima of a campaign, against the same over lists of cells.

use design_space::Cell;
use infuse::{
    Error,
    convergence::{Norm, NormOrder, NormScaling, RegretCertificate, coded_cell_measure, possible_optima},
    global::{self, SurfaceKind, SurfaceKinds},
};
use surface::Surface;

use crate::global_problems::{after, coded, experiment, least, planar, truth};

/// Ĵ − J_true as a surface of its own.
#[derive(Debug)]
struct ModelError<'a> {
    model: &'a dyn Surface,
}

impl Surface for ModelError<'_> {
    fn n_factors(&self) -> usize {
        2
    }

    fn predict(&self, point: &[f64]) -> f64 {
        let natural: Vec<f64> = point.iter().map(|x| 12.0 + 2.0 * x).collect();
        self.model.predict(point) - truth(&natural)
    }
}

/// 1 everywhere but at one cell, where it is what is given.
#[derive(Debug)]
struct Spike(Vec<f64>, f64);

impl Surface for Spike {
    fn n_factors(&self) -> usize {
        2
    }

    fn predict(&self, point: &[f64]) -> f64 {
        if point == self.0 { self.1 } else { 1.0 }
    }
}

fn norms() -> Vec<Norm> {
    let orders = [1.0, 2.0, 3.5].map(|q| NormOrder::finite(q).unwrap()).into_iter().chain([NormOrder::INFINITY]);
    orders.flat_map(|order| [NormScaling::Integral, NormScaling::Mean].map(|scaling| Norm { order, scaling })).collect()
}

fn values(campaign: &global::Loop, batch: usize, surface: &dyn Surface) -> Vec<f64> {
    let region = campaign.retained_at(batch).unwrap();
    region.cells().map(|cell| surface.predict(&campaign.coded(cell).unwrap())).collect()
}

#[test]
fn a_norm_over_what_is_left_is_that_of_the_list_of_its_cells() {
    let campaign = after(3, planar().1);
    let error = ModelError { model: campaign.surfaces()[1].numerical.surface() };
    let measure = coded_cell_measure(2, 576).unwrap();
    for batch in 1..=4 {
        let values = values(&campaign, batch, &error);
        for norm in norms() {
            let expected = norm.over(&values, &vec![measure; values.len()]).unwrap();
            let found = campaign.norm_over(batch, &error, norm).unwrap();
            assert!((found - expected).abs() <= 1e-13 * expected, "{norm:?}, {batch}: {found} {expected}");
        }
    }
    assert!(values(&campaign, 4, &error).len() < 500, "the region has shrunk");
    let zero = infuse::global::TracedSurface::combination(2, []).unwrap();
    norms().iter().for_each(|&norm| assert_eq!(campaign.norm_over(1, zero.surface(), norm), Ok(0.0)));
}

#[test]
fn the_number_of_threads_changes_no_bit_of_a_norm() {
    let campaign = after(1, planar().1);
    let model = campaign.surfaces()[0].combined.surface();
    let with = |n: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
        pool.install(|| norms().iter().map(|&norm| campaign.norm_over(1, model, norm).unwrap()).collect::<Vec<_>>())
    };
    assert_eq!(with(1), with(3));
}

#[test]
fn what_has_no_norm_is_named() {
    let campaign = after(1, planar().1);
    let model = campaign.surfaces()[0].combined.surface();
    let message = |refused: Result<f64, Error>| refused.unwrap_err().to_string();
    for batch in [0, 3] {
        let refused = message(campaign.norm_over(batch, model, Norm::SUP));
        assert!(refused.contains(&format!("`batch` is {batch}, expected 1 to that of")), "{refused}");
    }
    let one = infuse::global::TracedSurface::combination(1, []).unwrap();
    assert!(message(campaign.norm_over(1, one.surface(), Norm::SUP)).contains("`surface` has 1 entries"));
    for bad in [f64::NAN, f64::NEG_INFINITY] {
        let spike = Spike(campaign.coded(Cell::new(345)).unwrap(), bad);
        let refused = message(campaign.norm_over(1, &spike, Norm::SUP));
        assert!(refused.contains(&format!("`surface` has {bad:?} at index 345")), "{refused}");
    }
    // Too large to be squared, but not for the norm.
    let spike = Spike(campaign.coded(Cell::new(345)).unwrap(), -1e200);
    let two = Norm { order: NormOrder::finite(2.0).unwrap(), scaling: NormScaling::Mean };
    assert!((campaign.norm_over(1, &spike, two).unwrap() / 1e200 - 1.0 / 24.0).abs() < 1e-12);
}

#[test]
fn the_certificate_and_the_possible_optima_are_those_of_the_list_of_cells() {
    for n_batches in 1..=3 {
        let campaign = after(n_batches, planar().1);
        let surfaces = campaign.surfaces().last().unwrap();
        let model = values(&campaign, n_batches + 1, surfaces.numerical.surface());
        let cells: Vec<Cell> = campaign.retained().cells().collect();
        let optimum = campaign.reports().last().unwrap().screening.optimum_cell;
        let place = cells.iter().position(|&cell| cell == optimum).unwrap();
        for eps in [0.0, 0.03, 0.4, 1e3] {
            let found = campaign.certificate(eps).unwrap().unwrap();
            assert_eq!(found, RegretCertificate::of_cell(place, &model, eps).unwrap());
            let possible = campaign.possible_optima(eps).unwrap().unwrap();
            let expected = possible_optima(&model, eps).unwrap();
            assert_eq!(possible.n_retained(), expected.iter().filter(|&&is_possible| is_possible).count() as u64);
            for (&cell, is_possible) in cells.iter().zip(expected) {
                assert_eq!(possible.contains(cell), is_possible, "cell {cell}");
            }
        }
        // With the true eps the promise is kept.
        let error = ModelError { model: surfaces.numerical.surface() };
        let eps = campaign.norm_over(n_batches + 1, &error, Norm::SUP).unwrap();
        let (best_cell, best) = least(&campaign, truth);
        let regret = truth(&campaign.point(optimum).unwrap()) - best;
        assert!(regret <= campaign.certificate(eps).unwrap().unwrap().regret, "{eps}: {regret}");
        assert!(campaign.possible_optima(eps).unwrap().unwrap().contains(best_cell), "{eps}");
    }
}

/// With an honest simulation p̂* is also the least of the corrected model: it is compared with the others only.
#[test]
fn the_certificate_of_the_best_cell_is_against_the_others() {
    let (region, mut settings) = planar();
    settings.max_batches = 1;
    let mut campaign = global::Loop::new(&region, settings).unwrap();
    campaign.run(&mut |_, p| Ok(truth(p)), &mut |trial| Ok(experiment(trial))).unwrap();
    let model = values(&campaign, 2, campaign.surfaces()[0].numerical.surface());
    let cells: Vec<Cell> = campaign.retained().cells().collect();
    let place = cells.iter().position(|&cell| cell == campaign.reports()[0].screening.optimum_cell).unwrap();
    let least = model.iter().copied().fold(f64::INFINITY, f64::min);
    assert!(model[place] <= least && model.len() > 1, "the best of several");
    for eps in [0.0, 1e-4, 0.1] {
        let found = campaign.certificate(eps).unwrap().unwrap();
        assert_eq!(found, RegretCertificate::of_cell(place, &model, eps).unwrap());
        assert!(found.regret < 2.0 * eps || eps <= 0.0, "below that of the least of all");
    }
}

#[test]
fn before_the_first_batch_nothing_is_promised() {
    let (region, settings) = planar();
    let campaign = global::Loop::new(&region, settings).unwrap();
    assert_eq!(campaign.certificate(0.1), Ok(None));
    assert_eq!(campaign.possible_optima(0.1), Ok(None));
    for eps in [-1.0, f64::NAN] {
        assert!(after(1, planar().1).certificate(eps).unwrap_err().to_string().contains("`eps`"));
        assert!(campaign.possible_optima(eps).unwrap_err().to_string().contains("`eps`"));
    }
}

#[test]
fn sums_of_surfaces_have_the_slope_of_their_values() {
    for kind in [SurfaceKind::Regression, SurfaceKind::SquaredExponential { scale: Some(1.5) }] {
        let (_, mut settings) = planar();
        settings.surfaces = SurfaceKinds { experiment: kind, simulation: kind, combined: kind };
        let campaign = after(2, settings);
        let model = campaign.surfaces()[1].numerical.surface();
        let x = coded(&[12.3, 11.1]);
        for (j, slope) in model.gradient(&x).unwrap().into_iter().enumerate() {
            let at = |step: f64| {
                let mut moved = x.clone();
                moved[j] += step;
                model.predict(&moved)
            };
            let difference = (at(1e-5) - at(-1e-5)) / 2e-5;
            assert!((slope - difference).abs() < 1e-8, "{kind:?}: {slope} {difference}");
        }
    }
}
