//! The prediction variance, its maximum and the criteria, against closed forms and brute force.

use doe::{Criterion, Design, Error, Information, Method, Model, PredictionVariance, Space, Term};
use proptest::prelude::*;

/// Nine runs that determine a quadratic, as nearly all do.
fn random_design() -> impl Strategy<Value = Design> {
    let design = prop::collection::vec(-1.0..=1.0_f64, 2 * 9).prop_map(|x| Design::new(2, x).unwrap());
    let model = Model::quadratic(2).unwrap();
    design.prop_filter("it determines the model", move |design| Information::of(&model, design).is_ok())
}

proptest! {
    #[test]
    fn the_maximum_is_not_below_any_point_of_a_fine_lattice(design in random_design()) {
        let model = Model::quadratic(2).unwrap();
        let information = Information::of(&model, &design).unwrap();
        let variance = PredictionVariance::from_information(&model, &information).unwrap();
        let maximum = variance.maximum(&Space::cube(2).unwrap()).unwrap();
        let axis = |i: i32| f64::from(i) / 40.0;
        for (i, j) in (-40..=40).flat_map(|i| (-40..=40).map(move |j| (i, j))) {
            let v = information.variance(&model.regressor(&[axis(i), axis(j)]).unwrap()).unwrap();
            prop_assert!(v <= maximum.value * (1.0 + 1e-9), "{v} is above {}", maximum.value);
        }
        let there = information.variance(&model.regressor(&maximum.at).unwrap()).unwrap();
        prop_assert!((there / maximum.value - 1.0).abs() < 1e-6);
    }

    #[test]
    fn leverages_sum_to_the_number_of_terms(design in random_design()) {
        let model = Model::quadratic(2).unwrap();
        let information = Information::of(&model, &design).unwrap();
        let sum: f64 = information.leverages(&model, &design).unwrap().iter().sum();
        prop_assert!((sum - 6.0).abs() < 1e-6, "{sum}");
    }

    #[test]
    fn a_grid_and_the_list_of_its_points_have_the_same_maximum(design in random_design(), n in 2..9_u32) {
        let model = Model::quadratic(2).unwrap();
        let variance = PredictionVariance::of(&model, &design).unwrap();
        let level = |i: u32| 2.0 * f64::from(i) / f64::from(n - 1) - 1.0;
        let points = (0..n).flat_map(|i| (0..n).flat_map(move |j| [level(i), level(j)])).collect();
        let list = variance.maximum(&Space::list(2, points).unwrap()).unwrap();
        let grid = variance.maximum(&Space::grid(&[n, n]).unwrap()).unwrap();
        prop_assert!((list.value / grid.value - 1.0).abs() < 1e-9);
        prop_assert_eq!(grid.method, Method::Scan { n_points: u64::from(n * n) });
    }

    #[test]
    fn permuting_and_mirroring_factors_changes_no_efficiency(design in random_design()) {
        let model = Model::quadratic(2).unwrap();
        let space = Space::cube(2).unwrap();
        let turned = design.runs().flat_map(|run| [-run[1], run[0]]).collect();
        let turned = Design::new(2, turned).unwrap();
        for criterion in Criterion::ALL {
            let [a, b] = [&design, &turned].map(|design| criterion.efficiency(&model, &space, design).unwrap());
            prop_assert!((a.percent / b.percent - 1.0).abs() < 1e-6, "{a} and {b}");
        }
    }

    #[test]
    fn no_efficiency_of_the_cube_exceeds_one(design in random_design()) {
        let model = Model::quadratic(2).unwrap();
        let space = Space::cube(2).unwrap();
        for criterion in [Criterion::D, Criterion::A, Criterion::G, Criterion::E, Criterion::T] {
            let efficiency = criterion.efficiency(&model, &space, &design).unwrap();
            prop_assert!(efficiency.percent <= 100.0 + 1e-9, "{efficiency}");
        }
    }

    #[test]
    fn slopes_of_the_variance_agree_with_differences(design in random_design(), x in -1.0..1.0_f64, y in -1.0..1.0_f64) {
        let model = Model::quadratic(2).unwrap();
        let variance = PredictionVariance::of(&model, &design).unwrap();
        let gradient = variance.gradient(&[x, y]).unwrap();
        let h = 1e-5;
        let slope = (variance.at(&[x + h, y]).unwrap() - variance.at(&[x - h, y]).unwrap()) / (2.0 * h);
        let size = variance.maximum(&Space::cube(2).unwrap()).unwrap().value;
        prop_assert!((slope - gradient[0]).abs() < 1e-5 * size, "{slope} is not {}", gradient[0]);
    }
}

#[test]
fn a_saddle_between_the_axes_does_not_end_the_ascent() {
    // v rises along the diagonals of the square from a point where neither coordinate alone can improve it.
    let terms = vec![Term::new([0, 0]), Term::new([1, 1])];
    let model = Model::new(2, terms).unwrap();
    let design = Design::from_runs(&[[0.0, 0.0], [0.0, 0.0], [0.5, 0.5]]).unwrap();
    let maximum = PredictionVariance::of(&model, &design).unwrap().maximum(&Space::cube(2).unwrap()).unwrap();
    // By hand: variance of a + b xy with a known to 1/2 and b = 4 (y₃ − a) at xy = −1.
    assert!((maximum.value - (0.5 * 25.0 + 16.0)).abs() < 1e-9, "{maximum:?}");
}

#[test]
fn full_factorials_have_the_efficiencies_of_the_textbooks() {
    // 2² for the linear model: all are 1. 3 points for the quadratic in one factor: |R'R| = 4, max v = 1.
    let square = Design::from_runs(&[[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]]).unwrap();
    let (model, space) = (Model::linear(2).unwrap(), Space::cube(2).unwrap());
    for criterion in [Criterion::D, Criterion::A, Criterion::G, Criterion::E, Criterion::T] {
        let efficiency = criterion.efficiency(&model, &space, &square).unwrap();
        assert!((efficiency.percent - 100.0).abs() < 1e-9, "{efficiency}");
    }
    // Mean v = (1 + 1/3 + 1/3) / 4.
    let mean = Criterion::I.efficiency(&model, &space, &square).unwrap();
    assert!((mean.value - 5.0 / 12.0).abs() < 1e-12, "{mean}");
    let three = Design::new(1, vec![-1.0, 0.0, 1.0]).unwrap();
    let (model, space) = (Model::quadratic(1).unwrap(), Space::cube(1).unwrap());
    let percent = |criterion: Criterion| criterion.efficiency(&model, &space, &three).unwrap().percent;
    assert!((percent(Criterion::D) - 100.0 * 4.0_f64.cbrt() / 3.0).abs() < 1e-9);
    assert!((percent(Criterion::G) - 100.0).abs() < 1e-9);
    // (R'R)⁻¹ = [[1, 0, −1], [0, 1/2, 0], [−1, 0, 3/2]].
    assert!((percent(Criterion::A) - 100.0 * 3.0 / (3.0 * 3.0)).abs() < 1e-9);
    assert!((percent(Criterion::T) - 100.0 * 7.0 / 9.0).abs() < 1e-9);
    // λ of [[3, 2], [2, 2]]: (5 − √17)/2.
    assert!((percent(Criterion::E) - 100.0 * (5.0 - 17.0_f64.sqrt()) / 6.0).abs() < 1e-9);
}

#[test]
fn a_design_that_cannot_tell_terms_apart_says_which() {
    let design = Design::from_runs(&[[-1.0, -1.0], [0.0, 0.0], [1.0, 1.0]]).unwrap();
    let error = Information::of(&Model::linear(2).unwrap(), &design).unwrap_err();
    assert_eq!(error.to_string(), "the design cannot tell the terms apart: `x2` = `x1`");
    let error = Information::of(&Model::quadratic(2).unwrap(), &design).unwrap_err();
    assert_eq!(error, Error::TooFewRuns { n_runs: 3, n_terms: 6 });
}

#[test]
fn a_maximum_may_be_written_with_how_it_was_found() {
    let design = Design::new(1, vec![-1.0, 0.0, 1.0]).unwrap();
    let variance = PredictionVariance::of(&Model::linear(1).unwrap(), &design).unwrap();
    for space in [Space::cube(1).unwrap(), Space::grid(&[3]).unwrap()] {
        let maximum = variance.maximum(&space).unwrap();
        let written = serde_json::to_value(&maximum).unwrap();
        assert_eq!((&written["value"], &written["over"]), (&maximum.value.into(), &maximum.over.to_string().into()));
        let text = written["method"].to_string();
        assert_eq!(serde_json::from_str::<Method>(&text).unwrap(), maximum.method, "{text}");
    }
}
