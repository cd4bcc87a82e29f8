//! Which of the four strategies find the optimum of a coupled problem, and which miss it.

use design_space::Region;
use infuse::codesign::{CodesignReport, CodesignStop, Strategy, codesign};
use infuse::{CodesignProblem, Role};

use crate::problems::{optimizer, pair, region};

const ALL: [Strategy; 4] = [Strategy::Nested, Strategy::Simultaneous, Strategy::Sequential, Strategy::Iterative];

/// A bowl in which the best controller follows the plant; optimum (0.6, 0.6), cost 0.
fn coupled_bowl(p: &[f64]) -> f64 {
    (p[0] - 0.6).powi(2) + (p[1] - 0.6).powi(2) + 8.0 * (p[0] - p[1]).powi(2)
}

/// Two basins along the diagonal with a steep coupling across it: the better basin is at
/// (0.5233, 0.5233), cost −0.1024, the other at (−0.473, −0.473), cost 0.0974.
fn valley(p: &[f64]) -> f64 {
    let (along, across) = (0.5 * (p[0] + p[1]), p[0] - p[1]);
    4.0 * (along * along - 0.25).powi(2) - 0.2 * along + 6.0 * across * across
}

/// A crease along the diagonal; optimum (0.6, 0.6), cost 0.
fn crease(p: &[f64]) -> f64 {
    (p[0] - 0.6).powi(2) + (p[1] - 0.6).powi(2) + 4.0 * (p[0] - p[1]).abs()
}

enum Starts {
    Default,
    WarmOnly,
}

fn optimize(strategy: Strategy, starts: Starts, start: f64, cost: fn(&[f64]) -> f64) -> CodesignReport {
    let mut settings = optimizer(strategy);
    if matches!(starts, Starts::WarmOnly) {
        (settings.n_starts, settings.n_controller_starts) = (0, 0);
    }
    codesign(&pair(-1.0, 1.0), &settings, &[start, start], &mut |p| Ok(cost(p))).unwrap()
}

#[track_caller]
fn check(report: &CodesignReport, expected: f64, tolerance: f64) {
    let near = report.point.iter().all(|p| (p - expected).abs() < tolerance);
    assert!(near, "{report:?}, expected both at {expected}");
}

#[test]
fn sequential_misses_the_optimum_of_a_coupled_bowl() {
    let found = ALL.map(|strategy| optimize(strategy, Starts::Default, 0.0, coupled_bowl));
    let [nested, simultaneous, sequential, iterative] = found;
    check(&nested, 0.6, 1e-6);
    check(&simultaneous, 0.6, 1e-6);
    // The plant that suits the controller 0 is 0.6 / 9, the controller that suits it (0.6 + 8 p) / 9.
    let plant = 0.6 / 9.0;
    let controller = (0.6 + 8.0 * plant) / 9.0;
    assert!((sequential.point[0] - plant).abs() < 1e-6, "{sequential:?}");
    assert!((sequential.point[1] - controller).abs() < 1e-6, "{sequential:?}");
    assert!(sequential.cost > 0.5, "{sequential:?}");
    // Alternation gains (8/9)² per round here, and stops when a round moves less than the radius.
    check(&iterative, 0.6, 5e-3);
    assert!((iterative.point[0] - 0.6).abs() > 1e-3, "short of it: {iterative:?}");
}

#[test]
fn iterative_stays_in_the_basin_it_starts_in() {
    let found = ALL.map(|strategy| optimize(strategy, Starts::Default, -0.5, valley));
    let [nested, simultaneous, sequential, iterative] = found;
    check(&nested, 0.5233, 1e-3);
    check(&simultaneous, 0.5233, 1e-3);
    // For the plant of the worse basin its own controller is the best of the whole axis, and the
    // other way round: looking along the axes cannot get out, though both searches had five starts.
    check(&iterative, -0.473, 2e-3);
    assert_eq!(iterative.stop, CodesignStop::Converged, "and it does not notice");
    assert!(sequential.point[0] < -0.4, "{sequential:?}");
}

#[test]
fn from_a_single_start_nested_and_simultaneous_stay_in_that_basin_too() {
    for strategy in [Strategy::Nested, Strategy::Simultaneous] {
        check(&optimize(strategy, Starts::WarmOnly, -0.5, valley), -0.473, 1e-3);
        check(&optimize(strategy, Starts::WarmOnly, 0.0, valley), 0.5233, 1e-3);
    }
}

#[test]
fn on_a_crease_only_nested_arrives() {
    let found = ALL.map(|strategy| optimize(strategy, Starts::Default, -0.5, crease));
    let [nested, simultaneous, sequential, iterative] = found;
    check(&nested, 0.6, 2e-3);
    // A smooth model of a crease: the descent along it stalls, with converged radii.
    assert!(simultaneous.cost > 1e-2, "{simultaneous:?}");
    // Every point of the crease near enough to the start is best along either axis.
    check(&sequential, -0.5, 1e-6);
    check(&iterative, -0.5, 1e-6);
}

/// Without coupling; optimum (0.3, −0.2).
fn bowl(p: &[f64]) -> f64 {
    (p[0] - 0.3).powi(2) + (p[1] + 0.2).powi(2)
}

#[test]
fn the_numbers_of_simulations_are_those_of_the_readme() {
    let count = |start, cost| ALL.map(|strategy| optimize(strategy, Starts::Default, start, cost).n_simulations);
    assert_eq!(count(0.0, bowl), [102, 15, 21, 43]);
    assert_eq!(count(0.0, coupled_bowl), [139, 48, 20, 535]);
    assert_eq!(count(-0.5, valley), [236, 38, 23, 140]);
    assert_eq!(count(-0.5, crease), [186, 23, 30, 30]);
    for strategy in ALL {
        let point = optimize(strategy, Starts::Default, 0.0, bowl).point;
        assert!((point[0] - 0.3).abs() < 1e-6 && (point[1] + 0.2).abs() < 1e-6, "{strategy}");
    }
}

/// Two basins on the controller axis, the better one changing sides with the plant.
fn two_controllers(p: &[f64]) -> f64 {
    (p[0] - 0.4).powi(2) + 4.0 * (p[1] * p[1] - 0.36).powi(2) + 0.4 * p[1] * (0.1 - p[0])
}

#[test]
fn the_inner_search_sees_both_basins_of_the_controller_axis() {
    // The warm start lies in the wrong basin for the best plant.
    let report = optimize(Strategy::Nested, Starts::Default, -0.6, two_controllers);
    let grid = (0..=400).flat_map(|i| (0..=400).map(move |j| [i, j]));
    let coordinate = |k: i32| f64::from(k - 200) / 200.0;
    let least = grid.map(|[i, j]| two_controllers(&[coordinate(i), coordinate(j)])).fold(f64::INFINITY, f64::min);
    assert!(report.cost <= least + 1e-9, "{report:?}, least of the grid {least}");
    assert!(report.point[1] > 0.5, "{report:?}");
}

#[test]
fn any_numbers_of_plant_and_controller_parameters() {
    let roles = vec![Role::Controller, Role::Plant, Role::Controller, Role::Plant];
    let region: Region = region(&[(-1.0, 3.0), (10.0, 20.0), (0.0, 0.1), (-5.0, -1.0)]);
    let best = [0.5, 14.0, 0.04, -2.0];
    let scale = [2.0, 5.0, 0.05, 2.0];
    let problem = CodesignProblem::new(region, roles).unwrap();
    let mut cost = |p: &[f64]| {
        let x: Vec<f64> = (0..4).map(|j| (p[j] - best[j]) / scale[j]).collect();
        Ok(x.iter().map(|x| x * x).sum::<f64>() + 0.5 * x[0] * x[1] + 0.5 * x[2] * x[3])
    };
    for strategy in [Strategy::Nested, Strategy::Simultaneous, Strategy::Iterative] {
        let start = problem.region().center();
        let report = codesign(&problem, &optimizer(strategy), &start, &mut cost).unwrap();
        for j in 0..4 {
            let error = (report.point[j] - best[j]).abs() / scale[j];
            assert!(error < 5e-3, "{strategy}, parameter {j}: {report:?}");
        }
    }
}

#[test]
fn one_kind_of_parameter_is_enough_for_the_simultaneous_strategy() {
    let problem = CodesignProblem::new(region(&[(0.0, 4.0)]), vec![Role::Controller]).unwrap();
    let mut cost = |p: &[f64]| Ok((p[0] - 4.5).powi(2));
    let settings = optimizer(Strategy::Simultaneous);
    let report = codesign(&problem, &settings, &[1.0], &mut cost).unwrap();
    assert_eq!(report.point, [4.0], "exactly on the bound");
    assert!(report.is_converged(), "{report:?}");
}
