//! Searches cut at any moment, by counting how often they ask whether they are over.

use std::sync::atomic::{AtomicU64, Ordering};

use doe::{
    Axis, Criterion, Error, Forbidden, Found, Model, Problem, Replicates, Settings, Space, StopReason, Watch, search,
    search_watched,
};

/// A search that is over at the call of this number, on one thread; and how often it asked.
fn cut_at(problem: &Problem, settings: &Settings, call: u64) -> (Result<Found, Error>, u64) {
    let calls = AtomicU64::new(0);
    let is_interrupted = || calls.fetch_add(1, Ordering::Relaxed) >= call;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    let found = pool
        .install(|| search_watched(problem, settings, Watch { is_interrupted: Some(&is_interrupted), progress: None }));
    (found, calls.into_inner())
}

fn settings() -> Settings {
    with_starts(17)
}

fn with_starts(starts: u64) -> Settings {
    let mut settings = Settings::default();
    settings.starts = starts;
    settings
}

fn spaces() -> Vec<Space> {
    let cube = || Space::cube(2).expect("a cube");
    let corner = Forbidden::new(vec![Some([0.2, 1.0]), Some([0.4, 1.0])]).expect("a box");
    let level = |i: u32| 2.0 * f64::from(i) / 6.0 - 1.0;
    let triangle: Vec<f64> = (0..7).flat_map(|i| (0..=i).flat_map(move |j| [level(i), level(j)])).collect();
    let mixed = vec![Axis::equally_spaced(5).expect("levels"), Axis::Continuous];
    vec![
        cube(),
        cube().forbid(vec![corner]).expect("a part"),
        Space::grid(&[7, 5]).expect("a grid"),
        Space::list(2, triangle).expect("a list"),
        Space::of_axes(mixed).expect("a box"),
    ]
}

#[test]
fn a_search_cut_anywhere_returns_the_best_it_has() {
    // What still asks after the end: each level on the way back, not a loop that goes on.
    const MOST_CALLS_AFTER: u64 = 60;
    let mut refinements_cut = 0;
    for (number, space) in spaces().into_iter().enumerate() {
        let criteria = if number < 3 { &Criterion::ALL[..] } else { &[Criterion::G, Criterion::A] };
        for &criterion in criteria {
            let problem = Problem::new(Model::quadratic(2).expect("a model"), space.clone(), 9, criterion);
            let problem = problem.expect("a problem");
            let (whole, calls) = cut_at(&problem, &settings(), u64::MAX);
            let whole = whole.expect("a design");
            assert_eq!((whole.report.stop, whole.report.unfinished), (StopReason::StartsDone, 0));
            let moments = (1..=2).chain((1..8).map(|eighth| calls * eighth / 8)).chain([calls - 1]);
            for call in moments {
                let case = format!("{criterion} over the {}, cut at call {call} of {calls}", space.over());
                let (found, asked) = cut_at(&problem, &settings(), call);
                let found = found.unwrap_or_else(|error| panic!("{case}: {error}"));
                assert_eq!(found.report.stop, StopReason::Interrupted, "{case}");
                assert!(asked - call <= MOST_CALLS_AFTER, "{case}: asked {} times more", asked - call);
                assert_eq!(found.design.n_runs(), 9, "{case}");
                found.design.check_within(&space).unwrap_or_else(|error| panic!("{case}: {error}"));
                assert!(found.efficiency.percent > 0.0, "{case}: {}", found.efficiency);
                refinements_cut += u64::from(found.report.starts == 16 && found.report.unfinished > 0);
                // The promise of the report; T's is of the D design that it is held against, which is cut too.
                if criterion != Criterion::T && call % 2 == 0 {
                    let starts = found.report.starts.max(found.report.best_start + 1);
                    let again = search(&problem, &with_starts(starts)).expect("a design");
                    let (again, found) = (again.efficiency.percent, found.efficiency.percent);
                    assert!(again >= found - 1e-6, "{case}: {found} %, and {again} % by {starts} whole starts");
                }
            }
        }
    }
    assert!(refinements_cut > 0, "no moment fell into a refinement");
}

#[test]
fn the_rule_for_replicates_holds_wherever_a_search_is_cut() {
    let problem =
        Problem::new(Model::quadratic(2).expect("a model"), Space::cube(2).expect("a cube"), 10, Criterion::G);
    let problem = problem.and_then(|problem| problem.with_replicates(Replicates::Planned(2))).expect("a problem");
    let (_, calls) = cut_at(&problem, &settings(), u64::MAX);
    for call in (1..20).map(|part| calls * part / 20) {
        let found = cut_at(&problem, &settings(), call).0.expect("a design");
        assert_eq!(found.design.replicates(0.04).len(), 2, "cut at call {call} of {calls}: {:?}", found.design);
    }
}

/// A quadratic of 91 terms in twelve factors: before its first design such a search took minutes and all of the memory, and
/// after the limit as long again.
#[test]
fn a_time_limit_that_has_passed_gives_a_design_in_twelve_factors_too() {
    let grid = Space::of_axes((0..12).map(|i| Axis::equally_spaced(2 + i % 3).expect("levels")).collect());
    let model = Model::quadratic(12).expect("a model");
    for (space, model) in [(Space::cube(12), model), (grid, Model::linear(12).expect("a model"))] {
        let space = space.expect("a space");
        let n = model.n_terms() + 9;
        let problem = Problem::new(model, space.clone(), n, Criterion::G).expect("a problem");
        let mut settings = Settings::default();
        settings.time_limit = Some(std::time::Duration::from_nanos(1));
        let found = search(&problem, &settings).expect("a design");
        assert_eq!((found.report.stop, found.report.starts), (StopReason::TimeLimit, 0), "over the {}", space.over());
        found.design.check_within(&space).expect("runs of the space");
        assert!(found.efficiency.percent > 0.0, "{}", found.efficiency);
    }
}

#[test]
fn a_time_limit_that_has_passed_still_gives_a_design() {
    for space in spaces() {
        for criterion in Criterion::ALL {
            let problem = Problem::new(Model::quadratic(2).expect("a model"), space.clone(), 9, criterion);
            let mut settings = settings();
            settings.time_limit = Some(std::time::Duration::from_nanos(1));
            let found = search(&problem.expect("a problem"), &settings);
            let found = found.unwrap_or_else(|error| panic!("{criterion} over the {}: {error}", space.over()));
            assert_eq!(found.report.stop, StopReason::TimeLimit);
            found.design.check_within(&space).expect("runs of the space");
        }
    }
}
