//! Searches: what they find, what they promise, what they refuse.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use doe::{
    Axis, Cell, Criterion, Design, Effort, Error, Forbidden, Found, Grid, Model, Parameter, Problem, Progress, Region,
    Replicates, Report, Settings, Space, StopReason, Term, Watch, polished, search, search_watched,
};
use proptest::prelude::*;

fn settings(starts: u64) -> Settings {
    let mut settings = Settings::default();
    settings.starts = starts;
    settings
}

fn g_optimal(k: usize, n: usize, starts: u64) -> Found {
    let problem = Problem::new(Model::quadratic(k).unwrap(), Space::cube(k).unwrap(), n, Criterion::G).unwrap();
    search(&problem, &settings(starts)).unwrap()
}

#[test]
fn reaches_the_published_record_on_the_cube() {
    // K, N, best published design over the cube, and starts. In one factor the record is the optimum.
    for (k, n, record, starts) in [
        (1, 3, 100.0, 32),
        (1, 4, 82.918, 64),
        (1, 6, 100.0, 64),
        (2, 6, 74.865, 64),
        (2, 8, 87.943, 200),
        (2, 12, 88.114, 64),
    ] {
        let found = g_optimal(k, n, starts);
        assert!(found.efficiency.percent > record - 5e-4, "K {k} N {n}: {}", found.efficiency);
    }
}

#[test]
fn the_same_seed_gives_the_same_bits_on_any_number_of_threads() {
    let levels = |count| Axis::equally_spaced(count).unwrap();
    let mixed = Space::of_axes(vec![Axis::Continuous, levels(3), levels(5)]).unwrap();
    for (space, n, starts) in
        [(Space::cube(2).unwrap(), 7, 40), (Space::grid(&[6, 7, 8]).unwrap(), 12, 20), (mixed, 12, 20)]
    {
        let model = Model::quadratic(space.n_factors()).unwrap();
        let problem = Problem::new(model, space, n, Criterion::G).unwrap();
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| search(&problem, &settings(starts)).unwrap())
        };
        let (one, three) = (on(1), on(3));
        assert_eq!(one.design, three.design);
        assert_eq!(one.report.best_start, three.report.best_start);
        assert_eq!(one.report.times_found, three.report.times_found);
    }
}

#[test]
fn a_search_cut_short_is_repeated_by_its_number_of_starts() {
    let problem = Problem::new(Model::quadratic(2).unwrap(), Space::cube(2).unwrap(), 8, Criterion::G).unwrap();
    let mut limited = settings(u64::MAX);
    limited.time_limit = Some(Duration::from_millis(30));
    let cut = search(&problem, &limited).unwrap();
    assert_eq!(cut.report.stop, StopReason::TimeLimit);
    let starts = cut.report.starts.max(cut.report.best_start + 1);
    let again = search(&problem, &settings(starts)).unwrap();
    assert_eq!((again.report.stop, again.report.unfinished), (StopReason::StartsDone, 0));
    if cut.report.unfinished == 0 {
        assert_eq!(again.design, cut.design);
    } else {
        assert!(again.efficiency.percent >= cut.efficiency.percent - 1e-9, "{} {}", again.efficiency, cut.efficiency);
    }
}

#[test]
fn an_interrupted_search_returns_what_it_has_or_says_that_it_has_nothing() {
    let problem = Problem::new(Model::quadratic(2).unwrap(), Space::cube(2).unwrap(), 8, Criterion::G).unwrap();
    let interrupt = AtomicBool::new(false);
    let mut heard = 0;
    let mut progress = |progress: doe::Progress| {
        heard += 1;
        assert!(progress.starts > 0);
        interrupt.store(true, Ordering::Relaxed);
    };
    let is_interrupted = || interrupt.load(Ordering::Relaxed);
    let watch = Watch { is_interrupted: Some(&is_interrupted), progress: Some(&mut progress) };
    let found = search_watched(&problem, &settings(u64::MAX), watch).unwrap();
    assert_eq!(found.report.stop, StopReason::Interrupted);
    assert!(heard >= 1 && found.efficiency.percent > 60.0, "{}", found.efficiency);
    let watch = Watch { is_interrupted: Some(&is_interrupted), progress: None };
    assert_eq!(search_watched(&problem, &settings(5), watch).unwrap_err(), Error::NoDesign { starts: 0 });
}

/// Rounds go on where the last one ended, and each start is refined or not.
#[test]
fn every_start_is_made_once_and_most_are_given_up() {
    let problem = Problem::new(Model::quadratic(1).unwrap(), Space::cube(1).unwrap(), 4, Criterion::G).unwrap();
    for starts in [16, 40, 70] {
        let report = search(&problem, &settings(starts)).unwrap().report;
        assert_eq!((report.starts, report.stop), (starts, StopReason::StartsDone));
        assert!(report.best_start < starts && report.times_found + report.abandoned + report.failed <= starts);
        assert!(report.abandoned > starts / 2, "{report:?}");
    }
    // Four runs at four corners: every start finds the same, and the first is named.
    let corners = Space::grid(&[2, 2]).unwrap();
    let problem = Problem::new(Model::linear(2).unwrap(), corners, 4, Criterion::G).unwrap();
    let report = search(&problem, &settings(40)).unwrap().report;
    assert!(report.best_start == 0 && report.times_found > 1, "{report:?}");
}

#[test]
fn stops_at_the_target() {
    let problem = Problem::new(Model::quadratic(2).unwrap(), Space::cube(2).unwrap(), 8, Criterion::G).unwrap();
    let mut settings = settings(100_000);
    settings.target_percent = Some(86.0);
    let found = search(&problem, &settings).unwrap();
    assert_eq!(found.report.stop, StopReason::TargetReached);
    assert!(found.efficiency.percent >= 86.0, "{}", found.efficiency);
}

#[test]
fn each_criterion_is_best_served_by_its_own_search() {
    let (model, space) = (Model::quadratic(2).unwrap(), Space::cube(2).unwrap());
    let criteria = [Criterion::D, Criterion::A, Criterion::G, Criterion::E, Criterion::I];
    let designs: Vec<Design> = criteria
        .iter()
        .map(|&criterion| {
            let problem = Problem::new(model.clone(), space.clone(), 9, criterion).unwrap();
            search(&problem, &settings(60)).unwrap().design
        })
        .collect();
    for (own, criterion) in criteria.iter().enumerate() {
        let percent: Vec<f64> =
            designs.iter().map(|design| criterion.efficiency(&model, &space, design).unwrap().percent).collect();
        for (other, value) in percent.iter().enumerate() {
            assert!(percent[own] >= value - 1e-3, "{criterion}: {} found {value}, {}", criteria[other], percent[own]);
        }
    }
}

#[test]
fn a_search_for_the_trace_keeps_its_share_of_the_determinant() {
    let (model, space) = (Model::quadratic(2).unwrap(), Space::cube(2).unwrap());
    let best = |criterion| {
        let problem = Problem::new(model.clone(), space.clone(), 9, criterion).unwrap();
        search(&problem, &settings(24)).unwrap().design
    };
    let (trace, determinant) = (best(Criterion::T), best(Criterion::D));
    let percent = |criterion: Criterion, design| criterion.efficiency(&model, &space, design).unwrap().percent;
    assert!(percent(Criterion::T, &trace) > percent(Criterion::T, &determinant));
    let share = percent(Criterion::D, &trace) / percent(Criterion::D, &determinant);
    assert!((Criterion::T_LEAST_D..1.0).contains(&share), "{share}");
}

#[test]
fn d_optimal_designs_are_those_of_the_tables() {
    // Box and Draper 1971: for N = 6 and K = 2 the determinant |R'R|^(1/6)/6 of the optimum is 0.4574 or 5.74e-3 N^6.
    let problem = Problem::new(Model::quadratic(2).unwrap(), Space::cube(2).unwrap(), 6, Criterion::D).unwrap();
    let found = search(&problem, &settings(60)).unwrap();
    let determinant = (found.efficiency.percent / 100.0).powi(6);
    assert!((determinant - 5.74e-3).abs() < 1e-5, "{determinant}");
}

#[test]
fn additive_designs_reach_one_hundred_where_orthogonal_arrays_do() {
    let grid = Space::grid(&[3; 4]).unwrap();
    let problem = Problem::new(Model::additive_quadratic(4).unwrap(), grid, 9, Criterion::G).unwrap();
    let found = search(&problem, &settings(160)).unwrap();
    assert!(found.efficiency.percent > 99.999, "{}", found.efficiency);
}

#[test]
fn lists_and_grids_give_designs_of_their_points_without_replicates() {
    let model = Model::quadratic(2).unwrap();
    let level = |i: u32| 2.0 * f64::from(i) / 6.0 - 1.0;
    let triangle: Vec<f64> = (0..7).flat_map(|i| (0..=i).flat_map(move |j| [level(i), level(j)])).collect();
    let cut = Forbidden::new(vec![Some([0.4, 1.0]), Some([-0.2, 1.0])]).unwrap();
    let spaces = [
        Space::grid(&[7, 5]).unwrap(),
        Space::grid(&[7, 5]).unwrap().forbid(vec![cut]).unwrap(),
        Space::list(2, triangle).unwrap(),
    ];
    for space in spaces {
        for criterion in Criterion::ALL {
            let problem = Problem::new(model.clone(), space.clone(), 9, criterion).unwrap();
            let found = search(&problem, &settings(16)).unwrap();
            found.design.check_within(&space).unwrap();
            assert_eq!(found.design.replicates(1e-9), [], "{criterion} over the {}", space.over());
            assert_eq!(found.design.n_runs(), 9);
        }
    }
}

/// 50^6 points would take minutes to look at once; a part of the levels is searched, and the worst prediction is found by
/// ascent.
#[test]
fn a_grid_too_large_to_be_scanned_is_searched_all_the_same() {
    let mut settings = settings(2);
    settings.effort = Effort::Quick;
    let space = Space::grid(&[50; 6]).unwrap();
    let model = Model::additive_quadratic(6).unwrap();
    let problem = Problem::new(model, space.clone(), 20, Criterion::G).unwrap();
    let found = search(&problem, &settings).unwrap();
    assert!(found.design.runs().all(|run| space.contains(run)), "every run is on the 50 levels");
    // On the cube, where every level may be taken, no design of few starts is much better.
    let cube = Problem::new(problem.model().clone(), Space::cube(6).unwrap(), 20, Criterion::G).unwrap();
    let best = search(&cube, &settings).unwrap().efficiency.percent;
    assert!(found.efficiency.percent > 0.9 * best, "{} % of {best} %", found.efficiency.percent);

    // Ends of forbidden ranges keep their neighbors, so nothing is given away there.
    let corner = Forbidden::new(vec![Some([0.9, 1.0]), Some([0.9, 1.0]), None, None, None, None]).unwrap();
    let cut = Space::grid(&[50; 6]).unwrap().forbid(vec![corner]).unwrap();
    let problem = Problem::new(problem.model().clone(), cut.clone(), 20, Criterion::D).unwrap();
    let found = search(&problem, &settings).unwrap();
    assert!(found.design.runs().all(|run| cut.contains(run)), "no run is forbidden");
}

/// The third level of the second factor is in two candidates of 222, and the model cannot do without it.
#[test]
fn a_level_that_few_candidates_have_is_found_by_every_start() {
    let level = |index: u32, count: u32| -1.0 + 2.0 * f64::from(index) / f64::from(count - 1);
    let mut coordinates = Vec::new();
    for (a, c) in (0..10).flat_map(|a| (0..11).map(move |c| (a, c))) {
        for b in [8, 9] {
            coordinates.extend([level(a, 10), level(b, 10), level(c, 11)]);
        }
    }
    coordinates.extend([level(0, 10), level(4, 10), level(8, 11)]);
    coordinates.extend([level(0, 10), level(4, 10), level(9, 11)]);
    let space = Space::list(3, coordinates).expect("a list");
    let model = Model::additive_quadratic(3).expect("a model");
    for criterion in [Criterion::G, Criterion::D] {
        let problem = Problem::new(model.clone(), space.clone(), 9, criterion).expect("a problem");
        for seed in 1..=20 {
            let mut settings = Settings::default();
            settings.seed = seed;
            settings.starts = 1;
            let report =
                search(&problem, &settings).unwrap_or_else(|error| panic!("{criterion:?}, seed {seed}: {error}"));
            let rare = report.design.runs().filter(|run| (run[1] - level(4, 10)).abs() < 1e-9).count();
            assert!((1..=2).contains(&rare), "{criterion:?}, seed {seed}: {rare} runs at the rare level");
        }
    }
}

#[test]
fn runs_on_a_grid_are_named_by_its_cells_and_no_others() {
    let parameter =
        |name, levels| Parameter::continuous(name, "1", 3.0, 5.0).and_then(|p| p.with_levels(levels)).unwrap();
    let region = Region::new(vec![parameter("a", 7), parameter("b", 5)]).unwrap();
    let grid = Grid::of(&region).unwrap();
    let corner = Forbidden::new(vec![Some([0.4, 1.0]), Some([-0.2, 1.0])]).unwrap();
    let space = Space::of_region(&region).unwrap();
    let fixed = Design::from_runs(&[[1.0 / 3.0, -0.5]]).unwrap();
    let found = |space: Space| {
        let problem = Problem::new(Model::quadratic(2).unwrap(), space, 9, Criterion::G).unwrap();
        let problem = problem.with_fixed_runs(fixed.clone()).and_then(|p| p.with_replicates(Replicates::Planned(1)));
        search(&problem.unwrap(), &settings(8)).unwrap()
    };
    for space in [space.clone(), space.forbid(vec![corner]).unwrap()] {
        let Found { design, cells, candidates, .. } = found(space);
        assert!(candidates.is_empty() && cells.len() == 9, "{cells:?} {candidates:?}");
        for (run, cell) in design.runs().zip(&cells) {
            let level = grid.coded(*cell).unwrap();
            assert!(run.iter().zip(&level).all(|(x, level)| (x - level).abs() <= 1e-9), "{cell}: {run:?} {level:?}");
        }
        assert_eq!(cells[0], Cell::new(21), "the fixed run is the first");
        assert_eq!(cells[8], cells[1], "the replicate is the last");
    }
    let list = Space::list(2, (0..35).flat_map(|k| grid.coded(Cell::new(k)).unwrap()).collect()).unwrap();
    let mixed = Space::of_axes(vec![Axis::Continuous, Axis::equally_spaced(5).unwrap()]).unwrap();
    for space in [Space::cube(2).unwrap(), mixed, list] {
        assert_eq!(found(space.clone()).cells, [], "no grid: {}", space.over());
    }
}

#[test]
fn a_shrunken_list_far_from_the_center_is_searched_as_well_as_a_large_one() {
    // The same list at a thousandth of its size: the design is the same, G does not notice.
    let points = |scale: f64, shift: f64| -> Vec<f64> {
        (0..9)
            .flat_map(|i| (0..9).flat_map(move |j| [i, j].map(|t| shift + scale * (f64::from(t) / 4.0 - 1.0))))
            .collect()
    };
    let percent = |scale: f64, shift: f64| {
        let space = Space::list(2, points(scale, shift)).unwrap();
        let problem = Problem::new(Model::quadratic(2).unwrap(), space, 8, Criterion::G).unwrap();
        search(&problem, &settings(24)).unwrap().efficiency.percent
    };
    assert!((percent(1.0, 0.0) - percent(0.01, 0.9)).abs() < 1e-2, "{} and {}", percent(1.0, 0.0), percent(0.01, 0.9));
}

#[test]
fn fixed_runs_stay_first_and_the_others_make_the_best_of_them() {
    let fixed = Design::from_runs(&[[0.3, 0.3], [0.3, 0.3], [-0.5, 0.1]]).unwrap();
    let (model, space) = (Model::quadratic(2).unwrap(), Space::cube(2).unwrap());
    let problem = Problem::new(model, space, 9, Criterion::G).unwrap().with_fixed_runs(fixed.clone()).unwrap();
    let found = search(&problem, &settings(60)).unwrap();
    assert_eq!(&found.design.coordinates()[..6], fixed.coordinates());
    let free = g_optimal(2, 6, 60);
    assert!(found.efficiency.value < free.efficiency.value, "nine runs predict better than six");
}

#[test]
fn planned_replicates_are_made_and_no_others() {
    let (model, space) = (Model::quadratic(2).unwrap(), Space::grid(&[5, 5]).unwrap());
    let problem =
        Problem::new(model, space, 10, Criterion::G).unwrap().with_replicates(Replicates::Planned(2)).unwrap();
    let found = search(&problem, &settings(24)).unwrap();
    assert_eq!(found.design.n_runs(), 10);
    assert_eq!(found.design.replicates(1e-9).len(), 2);
}

#[test]
fn a_forbidden_corner_is_avoided_on_the_cube() {
    let corner = Forbidden::new(vec![Some([0.2, 1.0]), Some([0.4, 1.0])]).unwrap();
    let space = Space::cube(2).unwrap().forbid(vec![corner]).unwrap();
    let problem = Problem::new(Model::quadratic(2).unwrap(), space.clone(), 8, Criterion::G).unwrap();
    let found = search(&problem, &settings(60)).unwrap();
    found.design.check_within(&space).unwrap();
    assert!(found.efficiency.percent > 70.0, "{}", found.efficiency);
    assert_eq!(found.efficiency.over, Some(space.over()));
}

#[test]
fn a_gridded_axis_beside_a_continuous_one_keeps_its_levels() {
    let space = Space::of_axes(vec![Axis::equally_spaced(4).unwrap(), Axis::Continuous]).unwrap();
    let problem = Problem::new(Model::quadratic(2).unwrap(), space.clone(), 8, Criterion::G).unwrap();
    let found = search(&problem, &settings(60)).unwrap();
    found.design.check_within(&space).unwrap();
    assert!(found.efficiency.percent > 75.0, "{}", found.efficiency);
}

/// 2,000 starts of an earlier version led to 73.29 %, its default of 200 to 70.03 to 72.41 % with most seeds.
#[test]
fn a_continuous_axis_beside_two_with_levels_ends_at_the_best_design_known() {
    let levels = |count| Axis::equally_spaced(count).unwrap();
    let space = Space::of_axes(vec![Axis::Continuous, levels(3), levels(5)]).unwrap();
    let problem = Problem::new(Model::quadratic(3).unwrap(), space.clone(), 12, Criterion::G).unwrap();
    let found = search(&problem, &settings(48)).unwrap();
    found.design.check_within(&space).unwrap();
    assert!(found.efficiency.percent > 73.2, "{}", found.efficiency);
}

/// The best known there has 77.87 %.
#[test]
fn a_few_starts_come_within_a_hundredth_of_the_best_on_the_list_of_the_case_study() {
    let level = |i: usize| (2.0 * i as f64 - 23.0) / 23.0;
    let points = (0..24_usize.pow(4)).flat_map(|cell| [1, 24, 576, 13_824].map(|stride| level(cell / stride % 24)));
    let list = Space::list(4, points.collect()).unwrap();
    let problem = Problem::new(Model::quadratic(4).unwrap(), list, 18, Criterion::G).unwrap();
    let mut few = settings(32);
    few.seed = 3;
    let found = search(&problem, &few).unwrap();
    assert!(found.efficiency.percent > 0.99 * 77.87, "{}", found.efficiency);
}

#[test]
fn any_list_of_monomials_is_searched() {
    let terms = [[0, 0], [1, 0], [0, 1], [2, 0], [3, 0], [1, 1]].map(Term::new).to_vec();
    let model = Model::new(2, terms).unwrap();
    let problem = Problem::new(model, Space::cube(2).unwrap(), 8, Criterion::G).unwrap();
    let mut settings = settings(40);
    settings.effort = Effort::Quick;
    let found = search(&problem, &settings).unwrap();
    assert!(found.efficiency.percent > 80.0, "{}", found.efficiency);
}

/// The cube, a grid, a list, mixed axes, and forbidden boxes in each, in two factors.
fn regions() -> Vec<Space> {
    let level = |i: u32| 2.0 * f64::from(i) / 6.0 - 1.0;
    let triangle: Vec<f64> = (0..7).flat_map(|i| (0..=i).flat_map(move |j| [level(i), level(j)])).collect();
    let corner = Forbidden::new(vec![Some([0.4, 1.0]), Some([-0.2, 1.0])]).unwrap();
    let mixed = || Space::of_axes(vec![Axis::equally_spaced(5).unwrap(), Axis::Continuous]).unwrap();
    vec![
        Space::cube(2).unwrap(),
        Space::grid(&[7, 5]).unwrap(),
        Space::list(2, triangle).unwrap(),
        mixed(),
        Space::cube(2).unwrap().forbid(vec![corner.clone()]).unwrap(),
        Space::grid(&[7, 5]).unwrap().forbid(vec![corner.clone()]).unwrap(),
        mixed().forbid(vec![corner]).unwrap(),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn a_g_search_is_hardly_ever_worse_than_a_d_search_over_any_region(
        region in 0..7_usize,
        n in 8..12_usize,
        planned in 0..2_usize,
        is_fixed: bool,
        seed in 0..1000_u64,
    ) {
        let (model, space) = (Model::quadratic(2).unwrap(), regions()[region].clone());
        let percent = |criterion| {
            let mut problem = Problem::new(model.clone(), space.clone(), n, criterion).unwrap();
            if is_fixed {
                let fixed = space.candidates().map_or([0.0, -1.0], |points| [points[2], points[3]]);
                problem = problem.with_fixed_runs(Design::from_runs(&[fixed]).unwrap()).unwrap();
            }
            if planned > 0 {
                problem = problem.with_replicates(Replicates::Planned(planned)).unwrap();
            }
            let mut settings = settings(48);
            settings.seed = seed;
            let found = search(&problem, &settings).unwrap();
            found.design.check_within(&space).unwrap();
            Criterion::G.efficiency(&model, &space, &found.design).unwrap().percent
        };
        let (g, d) = (percent(Criterion::G), percent(Criterion::D));
        prop_assert!(g.is_finite() && d > 0.0 && g >= d - 0.1, "{} < {} over the {}", g, d, space.over());
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn a_g_search_is_never_worse_than_a_d_search_and_never_singular(n in 6..12_usize, seed in 0..1000_u64) {
        let (model, space) = (Model::quadratic(2).unwrap(), Space::cube(2).unwrap());
        let percent = |criterion| {
            let problem = Problem::new(model.clone(), space.clone(), n, criterion).unwrap();
            let mut settings = settings(48);
            settings.seed = seed;
            let found = search(&problem, &settings).unwrap();
            Criterion::G.efficiency(&model, &space, &found.design).unwrap().percent
        };
        prop_assert!(percent(Criterion::G) >= percent(Criterion::D) - 1e-6);
    }
}

#[test]
fn refuses_problems_without_a_solution() {
    let error = Problem::new(Model::quadratic(2).unwrap(), Space::cube(2).unwrap(), usize::MAX, Criterion::G);
    let error = error.unwrap_err().to_string();
    assert_eq!(error, format!("runs: {}, expected 6 to 1000000", usize::MAX));
    let (model, cube) = (Model::quadratic(2).unwrap(), Space::cube(2).unwrap());
    let new = |space: Space, n: usize| Problem::new(model.clone(), space, n, Criterion::G);
    let check = |problem: Result<Problem, Error>, message: &str| assert_eq!(problem.unwrap_err().to_string(), message);
    check(new(cube.clone(), 5), "5 runs cannot determine 6 terms, expected at least 6 runs");
    check(new(Space::cube(3).unwrap(), 9), "the space has 3 factors, expected 2");
    check(new(Space::grid(&[2, 3]).unwrap(), 6), "the space cannot tell the terms apart: `x1^2` = 1");
    let many = new(Space::grid(&[3, 3]).unwrap(), 10).unwrap();
    let message = "the space has 9 points, too few for 10 distinct runs: plan replicates or allow them";
    assert_eq!(many.validate().unwrap_err().to_string(), message);
    assert_eq!(search(&many, &settings(2)).unwrap_err().to_string(), message);
    let two = Design::from_runs(&[[0.0, 1.0], [1.0, 1.0]]).unwrap();
    assert_eq!(many.clone().with_fixed_runs(two).unwrap().validate().unwrap_err().to_string(), message);
    let fixed = Design::new(2, vec![0.0, 2.0]).unwrap();
    check(new(cube.clone(), 8).unwrap().with_fixed_runs(fixed), "run 1 lies outside the space: [0.0, 2.0]");
    check(
        new(cube.clone(), 8).unwrap().with_replicates(Replicates::Planned(5)),
        "planned replicates: 5, expected 0 to 4",
    );
    check(
        new(cube.clone(), 8).unwrap().with_replicates(Replicates::Planned(3)),
        "5 runs cannot determine 6 terms, expected at least 6 runs",
    );
    let refused = |change: fn(&mut Settings), message: &str| {
        let mut settings = Settings::default();
        change(&mut settings);
        let error = search(&new(cube.clone(), 8).unwrap(), &settings).unwrap_err();
        assert_eq!(error.to_string(), message);
    };
    refused(|settings| settings.starts = 0, "the setting `starts` is 0.0, expected at least 1");
    refused(
        |settings| settings.target_percent = Some(f64::NAN),
        "the setting `target_percent` is NaN, expected above 0",
    );
    refused(|settings| settings.time_limit = Some(Duration::ZERO), "the setting `time_limit` is 0.0, expected above 0");
}

#[test]
fn fixed_runs_and_replicates_may_be_said_in_any_order() {
    let (model, grid) = (Model::quadratic(2).unwrap(), Space::grid(&[3, 3]).unwrap());
    let fixed = Design::from_runs(&[[0.0, 0.0], [0.0, 0.0], [1.0, 1.0]]).unwrap();
    let new = |n| Problem::new(model.clone(), grid.clone(), n, Criterion::G).unwrap();
    for replicates in [Replicates::Allowed, Replicates::Planned(1)] {
        let one = new(10).with_replicates(replicates).unwrap().with_fixed_runs(fixed.clone()).unwrap();
        let other = new(10).with_fixed_runs(fixed.clone()).unwrap().with_replicates(replicates).unwrap();
        let (one, other) = (search(&one, &settings(8)).unwrap(), search(&other, &settings(8)).unwrap());
        assert_eq!(one.design, other.design);
    }
    // Of ten runs two are one fixed point: nine points are enough for the rest, each run once.
    let whole = search(&new(10).with_fixed_runs(fixed.clone()).unwrap(), &settings(8)).unwrap();
    assert_eq!(whole.design.replicates(1e-9), [(0, 1)]);
    // Five planned replicates are half of ten runs, but more than half of the seven that are free.
    let linear = Problem::new(Model::linear(2).unwrap(), grid.clone(), 10, Criterion::G).unwrap();
    let planned = linear.with_replicates(Replicates::Planned(5)).unwrap();
    planned.validate().unwrap();
    let error = planned.with_fixed_runs(fixed).unwrap().validate().unwrap_err();
    assert_eq!(error.to_string(), "planned replicates: 5, expected 0 to 3");
}

/// Solvable problems are solved, and what must differ does so by more than a rig could miss.
#[test]
fn runs_that_must_differ_do_so_on_any_box_and_by_any_criterion() {
    let eight = Axis::equally_spaced(8).unwrap();
    let spaces = [Space::cube(2).unwrap(), Space::of_axes(vec![eight.clone(), Axis::Continuous]).unwrap()];
    for space in spaces {
        for criterion in [Criterion::G, Criterion::D, Criterion::A, Criterion::E, Criterion::I, Criterion::T] {
            for planned in 0..=2 {
                for fixed in [None, Some(Design::from_runs(&[[1.0, 0.3]]).unwrap())] {
                    let mut problem = Problem::new(Model::quadratic(2).unwrap(), space.clone(), 11, criterion).unwrap();
                    let n_fixed = usize::from(fixed.is_some());
                    if let Some(fixed) = fixed {
                        problem = problem.with_fixed_runs(fixed).unwrap();
                    }
                    let problem = problem.with_replicates(Replicates::Planned(planned)).unwrap();
                    let mut settings = Settings::default();
                    settings.starts = 6;
                    settings.effort = Effort::Quick;
                    let case = format!("{criterion} over the {}, {planned} planned, {n_fixed} fixed", space.over());
                    let found = search(&problem, &settings).unwrap_or_else(|error| panic!("{case}: {error}"));
                    assert_eq!(found.design.n_runs(), 11, "{case}");
                    assert_eq!(found.design.replicates(0.04).len(), planned, "{case}: {:?}", found.design);
                }
            }
            let problem = Problem::new(Model::quadratic(2).unwrap(), space.clone(), 8, criterion).unwrap();
            let allowed = search(&problem.with_replicates(Replicates::Allowed).unwrap(), &settings(6));
            assert!(allowed.is_ok(), "{criterion} over the {} with replicates allowed: {allowed:?}", space.over());
        }
    }
}

#[test]
fn a_variance_far_below_one_is_polished_like_any_other() {
    // With 3 terms and 30 runs the largest prediction variance is about 0.1.
    for (n, least_percent) in [(7, 91.16), (9, 99.99), (30, 99.99)] {
        let problem = Problem::new(Model::quadratic(1).unwrap(), Space::cube(1).unwrap(), n, Criterion::G).unwrap();
        let mut settings = Settings::default();
        settings.starts = 400;
        let found = search(&problem, &settings).unwrap();
        assert!(found.efficiency.percent > least_percent, "N = {n}: {}", found.efficiency);
    }
}

/// Runs that must differ take most points of a small grid, or all of them.
#[test]
fn a_grid_crowded_with_runs_is_searched_by_every_start() {
    let level = |i: u32| 2.0 * f64::from(i) / 23.0 - 1.0;
    let list: Vec<f64> = (0..24).flat_map(|i| (0..24).flat_map(move |j| [level(i), level(j)])).collect();
    let grid = Space::grid(&[24, 24]).unwrap();
    for (space, n) in [(grid.clone(), 200), (grid, 576), (Space::list(2, list).unwrap(), 500)] {
        let problem = Problem::new(Model::quadratic(2).unwrap(), space.clone(), n, Criterion::G).unwrap();
        let found = search(&problem, &settings(3)).unwrap_or_else(|error| panic!("{n} runs: {error}"));
        assert_eq!((found.report.failed, found.design.replicates(1e-9).len()), (0, 0), "{n} of the {}", space.over());
        found.design.check_within(&space).unwrap();
    }
}

/// Steps of the polish with thousands of coordinates take seconds: the limit is asked for within them.
#[test]
fn a_time_limit_holds_with_thousands_of_coordinates() {
    let problem = Problem::new(Model::quadratic(2).unwrap(), Space::cube(2).unwrap(), 2000, Criterion::G).unwrap();
    let mut limited = settings(u64::MAX);
    limited.time_limit = Some(Duration::from_millis(300));
    let found = search(&problem, &limited).unwrap();
    assert!(found.report.elapsed < Duration::from_secs(4), "{:?}", found.report.elapsed);
}

/// Without its determinant a polish for T would put every run at a corner, where no square can be told from 1.
#[test]
fn a_polish_for_t_keeps_the_determinant_of_the_design() {
    let (model, space) = (Model::quadratic(2).unwrap(), Space::cube(2).unwrap());
    let problem = Problem::new(model.clone(), space.clone(), 9, Criterion::T).unwrap();
    for size in [0.6, 0.8, 0.95] {
        let levels = [-size, 0.1, size];
        let runs: Vec<[f64; 2]> = levels.iter().flat_map(|&x| levels.map(|y| [x, y])).collect();
        let given = Design::from_runs(&runs).unwrap();
        let percent =
            |criterion: Criterion, design: &Design| criterion.efficiency(&model, &space, design).unwrap().percent;
        let polished = polished(&problem, &given).unwrap();
        let [t, d] =
            [Criterion::T, Criterion::D].map(|criterion| percent(criterion, &polished) / percent(criterion, &given));
        assert!(t > 1.01 && d > 0.99, "{t} of the trace and {d} of the determinant at {size}");
    }
}

/// Orthogonal arrays: their prediction variance at the corners is the least there is, p / N.
#[test]
fn orthogonal_designs_in_many_factors_are_found_by_a_few_starts() {
    for (space, k, n) in [(Space::cube(11), 11, 12), (Space::grid(&[2; 12]), 12, 16)] {
        let problem = Problem::new(Model::linear(k).unwrap(), space.unwrap(), n, Criterion::G).unwrap();
        let found = search(&problem, &settings(4)).unwrap();
        assert!(found.efficiency.percent > 99.999, "K {k}: {}", found.efficiency);
    }
}

#[test]
fn fixed_runs_that_leave_too_much_open_are_named_and_not_the_rule_for_replicates() {
    let (model, space) = (Model::quadratic(2).unwrap(), Space::cube(2).unwrap());
    let equal = Design::from_runs(&[[0.5, 0.5]; 7]).unwrap();
    let new = |n, fixed: &Design| {
        Problem::new(model.clone(), space.clone(), n, Criterion::G).unwrap().with_fixed_runs(fixed.clone()).unwrap()
    };
    let error = search(&new(8, &equal), &settings(2)).unwrap_err();
    assert_eq!(error, Error::TooFewFreeRuns { n_fixed: 7, determined: 1, n_free: 1, n_terms: 6 });
    let message = "the 7 fixed runs determine 1 of 6 terms, and 1 further run cannot determine the other 5, \
                   expected at least 5 further distinct runs";
    assert_eq!(error.to_string(), message);
    // Five further runs are enough, but not if one of them is the replicate of another.
    assert!(search(&new(12, &equal), &settings(2)).is_ok());
    let planned = new(12, &equal).with_replicates(Replicates::Planned(1)).unwrap();
    assert!(matches!(planned.validate().unwrap_err(), Error::TooFewFreeRuns { n_free: 4, .. }));
}

/// The promise of `Thorough`: what it ends at is a local optimum to the last digits. `doe_polish.py` of the fixtures says the
/// same of the kept designs from outside.
#[test]
fn no_kept_design_is_bettered_by_a_polish() {
    let directory = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/doe");
    let manifest = csv::Reader::from_path(directory.join("manifest.csv")).unwrap().into_records();
    for line in manifest.map(Result::unwrap) {
        let (k, n): (usize, usize) = (line[0].parse().unwrap(), line[1].parse().unwrap());
        let mut reader = csv::Reader::from_path(directory.join(format!("k{k}_n{n}.csv"))).unwrap();
        let kept = Design::from_runs(&reader.deserialize().collect::<Result<Vec<Vec<f64>>, _>>().unwrap()).unwrap();
        let problem = Problem::new(Model::quadratic(k).unwrap(), Space::cube(k).unwrap(), n, Criterion::G).unwrap();
        let percent =
            |design: &Design| Criterion::G.efficiency(problem.model(), problem.space(), design).unwrap().percent;
        let gain = percent(&polished(&problem, &kept).unwrap()) - percent(&kept);
        assert!((0.0..1e-4).contains(&gain), "K {k} N {n}: {gain} points");
    }
}

/// With six factors a lattice that is fine enough for each step overlooks maxima, and what they hold back was called optimal: a polish
/// gained 0.05 points, and more from outside.
#[test]
fn no_search_of_six_factors_is_bettered_by_a_polish() {
    let found = g_optimal(6, 28, 12);
    let problem = Problem::new(Model::quadratic(6).unwrap(), Space::cube(6).unwrap(), 28, Criterion::G).unwrap();
    let better = polished(&problem, &found.design).unwrap();
    let percent = Criterion::G.efficiency(problem.model(), problem.space(), &better).unwrap().percent;
    let gain = percent - found.efficiency.percent;
    assert!((0.0..1e-3).contains(&gain), "{gain} points");
}

/// Runs off their optimum by a hundredth find back to it, or to a better one beside it.
#[test]
fn a_polish_finds_back_to_the_optimum() {
    for (k, n, starts) in [(2, 8, 48), (3, 12, 48)] {
        let found = g_optimal(k, n, starts);
        let moved: Vec<f64> = found
            .design
            .coordinates()
            .iter()
            .enumerate()
            .map(|(i, x)| {
                let step = 0.01 * ((i * i * 7919 + 31 * i) % 2003) as f64 / 1001.0 - 0.01;
                (x + step).clamp(-1.0, 1.0)
            })
            .collect();
        let problem = Problem::new(Model::quadratic(k).unwrap(), Space::cube(k).unwrap(), n, Criterion::G).unwrap();
        let percent =
            |design: &Design| Criterion::G.efficiency(problem.model(), problem.space(), design).unwrap().percent;
        let moved = Design::new(k, moved).unwrap();
        let back = percent(&polished(&problem, &moved).unwrap());
        let best = found.efficiency.percent;
        assert!(percent(&moved) < best - 0.5 && back > best - 0.05, "K {k}: {} to {back} of {best}", percent(&moved));
    }
    let grid = Problem::new(Model::quadratic(2).unwrap(), Space::grid(&[5, 5]).unwrap(), 8, Criterion::G).unwrap();
    let error = polished(&grid, &g_optimal(2, 8, 1).design).unwrap_err().to_string();
    assert_eq!(error, "a polish needs runs that are continuous in every factor and may be repeated");
}

/// K, N and what the best published designs have over five levels of each factor, which is how their figures are printed.
#[test]
fn continuous_runs_judged_on_five_levels_reach_the_figures_in_print() {
    for (k, n, record, starts) in [(2, 6, 75.030, 100), (2, 7, 80.239, 200), (2, 9, 86.634, 100), (3, 11, 80.509, 64)] {
        let grid = Space::grid(&vec![5; k]).unwrap();
        let problem = Problem::new(Model::quadratic(k).unwrap(), Space::cube(k).unwrap(), n, Criterion::G).unwrap();
        let found = search(&problem.judged_over(grid.clone()).unwrap(), &settings(starts)).unwrap();
        assert!(found.efficiency.percent > record - 5e-4, "K {k} N {n}: {}", found.efficiency);
        assert_eq!(found.efficiency.over, Some(grid.over()));
        assert!(found.design.runs().flatten().any(|x| (2.0 * x - (2.0 * x).round()).abs() > 1e-3), "off the levels");
        // Over the whole cube the same design can only be worse.
        let cube = Criterion::G.efficiency(&Model::quadratic(k).unwrap(), &Space::cube(k).unwrap(), &found.design);
        assert!(cube.unwrap().percent <= found.efficiency.percent);
    }
    let cube = |n| Problem::new(Model::quadratic(2).unwrap(), Space::cube(2).unwrap(), n, Criterion::G).unwrap();
    let refused = |judged: Space| cube(8).judged_over(judged).unwrap_err().to_string();
    assert_eq!(refused(Space::grid(&[5; 3]).unwrap()), "the grid to judge over has 3 factors, expected 2");
    assert_eq!(
        refused(Space::cube(2).unwrap()),
        "the space to judge over has no levels in every factor, expected a grid"
    );
    assert_eq!(refused(Space::grid(&[400; 2]).unwrap()), "points to judge over: 160000, expected 1 to 100000");
    let planned = cube(8).judged_over(Space::grid(&[5; 2]).unwrap()).unwrap().with_replicates(Replicates::Planned(0));
    let error = search(&planned.unwrap(), &settings(1)).unwrap_err().to_string();
    assert_eq!(error, "a grid to judge over needs runs that are continuous in every factor and may be repeated");
}

/// Beside forbidden boxes coordinates of a continuous axis are refined, too: none can be moved to a better design.
#[test]
fn continuous_coordinates_beside_a_forbidden_box_over_levels_are_refined() {
    let corner = Forbidden::new(vec![Some([0.3, 1.0]), Some([0.4, 1.0])]).unwrap();
    let space = Space::of_axes(vec![Axis::equally_spaced(5).unwrap(), Axis::Continuous]).unwrap();
    let space = space.forbid(vec![corner]).unwrap();
    for criterion in [Criterion::D, Criterion::G] {
        let problem = Problem::new(Model::quadratic(2).unwrap(), space.clone(), 9, criterion).unwrap();
        let found = search(&problem, &settings(40)).unwrap();
        found.design.check_within(&space).unwrap();
        let efficiency = |x: &[f64]| {
            let design = Design::new(2, x.to_vec()).unwrap();
            design.check_within(&space).ok()?;
            Some(criterion.efficiency(problem.model(), &space, &design).unwrap().percent)
        };
        let x = found.design.coordinates().to_vec();
        let (best, mut better) = (efficiency(&x).unwrap(), Vec::new());
        for run in 0..9 {
            for by in [-0.02, -0.005, 0.005, 0.02] {
                let mut moved = x.clone();
                moved[2 * run + 1] = (moved[2 * run + 1] + by).clamp(-1.0, 1.0);
                better.extend(efficiency(&moved).filter(|percent| *percent > best + 1e-4));
            }
        }
        assert!(better.is_empty(), "{criterion}: {best} % of {x:?}, {better:?} moved");
    }
}

/// What a search found may be written down, and what it says of itself comes back as it was.
#[test]
fn what_a_search_found_serializes() {
    let found = g_optimal(1, 4, 8);
    let text = serde_json::to_string(&found.report).unwrap();
    assert_eq!(serde_json::from_str::<Report>(&text).unwrap(), found.report, "{text}");
    let written = serde_json::to_value(&found).unwrap();
    assert_eq!(written["report"]["stop"], "starts_done", "{written}");
    assert_eq!(written["efficiency"]["percent"], found.efficiency.percent, "{written}");
    assert_eq!(written["design"], serde_json::to_value(&found.design).unwrap(), "{written}");
    let progress = Progress { starts: 3, best_value: 1.5, best_percent: 90.0, elapsed: Duration::from_millis(1250) };
    let text = serde_json::to_string(&progress).unwrap();
    assert_eq!(serde_json::from_str::<Progress>(&text).unwrap(), progress, "{text}");
}
