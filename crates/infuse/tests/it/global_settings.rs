//! What the dissertation's loop refuses to begin with.

use design_space::{Cell, Model, Parameter, Region};
use doe::SplitMethod;
use infuse::{
    Error,
    global::{self, SpreadFallback, SurfaceKind},
};

use crate::global_problems::{grid, planar};

#[track_caller]
fn check_refused(change: impl FnOnce(&mut global::Settings), message: &str) {
    let (region, mut settings) = planar();
    change(&mut settings);
    let error = global::Loop::new(&region, settings).unwrap_err();
    assert!(error.to_string().contains(message), "{error}");
}

/// 24^4 cells are a list of all; a full quadratic regressor in six parameters has 28 terms.
#[test]
fn more_terms_mean_fewer_candidates_by_default() {
    let limit = |k: usize| global::Settings::new(Model::quadratic(k).unwrap(), 60, 60).candidate_limit();
    assert!(limit(2) == 400_000 && limit(4) == 400_000, "up to 15 terms");
    assert!((150_000..165_000).contains(&limit(6)), "{}", limit(6));
    let settings = global::Settings::new(Model::quadratic(6).unwrap(), 60, 60);
    let read: global::Settings = serde_json::from_str(&serde_json::to_string(&settings).unwrap()).unwrap();
    assert_eq!(read.candidate_limit(), limit(6), "from a file that does not name it, too");
}

#[test]
fn settings_out_of_range_are_named() {
    check_refused(|settings| settings.n_experiments = 5, "`n_experiments` is 5, expected at least the number of terms");
    check_refused(|settings| settings.n_experiments = 3, "`n_experiments` is 3, expected at least 4");
    check_refused(|settings| settings.n_simulations = 5, "`n_simulations` is 5");
    check_refused(|settings| settings.n_simulations = 10_001, "`n_simulations` is 10001");
    check_refused(|settings| settings.model = Model::linear(3).unwrap(), "the setting `model`");
    check_refused(|settings| settings.experiment_weight = 0.0, "`experiment_weight` is 0.0");
    check_refused(|settings| settings.simulation_weight = f64::NAN, "`simulation_weight` is NaN");
    check_refused(|settings| settings.confidence = 0.5, "`confidence` is 0.5, expected 0.5 < confidence < 1");
    check_refused(|settings| settings.confidence = 1.0, "`confidence` is 1.0");
    check_refused(|settings| settings.max_batches = 0, "`max_batches` is 0");
    check_refused(|settings| settings.design_starts = 0, "`design_starts` is 0");
    check_refused(|settings| settings.candidate_limit = Some(999), "`candidate_limit` is 999");
    check_refused(|settings| settings.fallback = SpreadFallback::Given(-1.0), "`fallback` is -1.0");
    check_refused(
        |settings| settings.surfaces.experiment = SurfaceKind::InverseDistance { power: 0.0 },
        "`power` is 0.0",
    );
    check_refused(
        |settings| settings.surfaces.simulation = SurfaceKind::InverseDistance { power: 101.0 },
        "`power` is 101.0, expected a number above 0, at most 100",
    );
    let scale = Some(1e101);
    check_refused(
        |settings| settings.surfaces.experiment = SurfaceKind::SquaredExponential { scale },
        "`scale` is 1e101, expected a number from 1e-100 to 1e100",
    );
    check_refused(|settings| settings.experiment_weight = 1e101, "`experiment_weight` is 1e101");
    check_refused(|settings| settings.simulation_weight = 1e-101, "`simulation_weight` is 1e-101");
    check_refused(|settings| settings.experiment_weight = 0.31e6, "`experiment_weight` is 310000.0, expected 1e-6 to");
    check_refused(|settings| settings.simulation_weight = 0.71e6, "`experiment_weight` is 0.7, expected 1e-6 to");
    let scale = Some(f64::INFINITY);
    check_refused(|settings| settings.surfaces.combined = SurfaceKind::SquaredExponential { scale }, "`scale` is inf");
    let balanced = |settings: &mut global::Settings| {
        settings.split = SplitMethod::Balanced;
        settings.n_experiments = 10;
    };
    check_refused(balanced, "`n_experiments` is 10, expected twice the number of terms less one");
}

#[test]
fn the_loop_splits_as_the_source_and_doe_in_balance() {
    assert_eq!(planar().1.split, SplitMethod::Alternating);
    assert_eq!(doe::SplitSettings::default().method, SplitMethod::Balanced);
}

#[test]
fn a_continuous_parameter_is_named() {
    let level = Parameter::continuous("pitch", "deg", 10.0, 22.0).unwrap();
    let region = Region::new(vec![level, grid(&[4]).parameters()[0].clone()]).unwrap();
    let error = global::Loop::new(&region, planar().1).unwrap_err();
    assert!(error.to_string().contains("`pitch`"), "{error}");
}

#[test]
fn a_grid_beyond_the_bits_of_a_machine_is_refused() {
    let region = grid(&[24; 8]);
    let settings = global::Settings::new(Model::additive_quadratic(8).unwrap(), 20, 40);
    let error = global::Loop::new(&region, settings).unwrap_err();
    assert_eq!(error, Error::TooManyCells { n_cells: 24_u64.pow(8), most: 1 << 30 });
}

#[test]
fn settings_with_nothing_but_the_necessary_can_be_read() {
    let text =
        r#"{"model": {"n_factors": 2, "terms": "additive quadratic"}, "n_experiments": 10, "n_simulations": 20}"#;
    let read: global::Settings = serde_json::from_str(text).unwrap();
    assert_eq!(read, global::Settings::new(Model::additive_quadratic(2).unwrap(), 10, 20));
}

#[test]
fn cells_and_points_agree() {
    let (region, settings) = planar();
    let campaign = global::Loop::new(&region, settings).unwrap();
    for cell in campaign.grid().cells() {
        let point = campaign.point(cell).unwrap();
        assert_eq!(campaign.cell(&point).unwrap(), cell);
        let coded = campaign.region().coded(&point).unwrap();
        for (a, b) in coded.iter().zip(campaign.coded(cell).unwrap()) {
            assert!((a - b).abs() < 1e-14);
        }
    }
    assert!(
        campaign.point(Cell::new(576)).is_err()
            && campaign.coded(Cell::new(576)).is_err()
            && campaign.cell(&[9.0, 12.0]).is_err()
    );
}
