//! Replicates: runs that are the same are so to the last bit, whatever made the design.

use doe::{
    Axis, Criterion, Design, Effort, EvaluationSettings, Model, Parameter, Problem, Region, Replicates, Settings,
    Space, evaluate, polished, search,
};
use proptest::prelude::*;

/// A run as its bits, so that nothing but equality makes two the same.
fn bits(run: &[f64]) -> Vec<u64> {
    run.iter().map(|x| x.to_bits()).collect()
}

/// How often a run is the same as one before, as whoever groups by equality counts.
fn repeats(design: &Design) -> usize {
    let mut distinct: Vec<Vec<u64>> = design.runs().map(bits).collect();
    distinct.sort_unstable();
    distinct.dedup();
    design.n_runs() - distinct.len()
}

/// Any two runs, of which the first `n_fixed` are given, are equal to the last bit or farther apart than 1e-6.
fn assert_equal_or_apart(design: &Design, n_fixed: usize, case: &str) {
    let runs: Vec<&[f64]> = design.runs().collect();
    for later in n_fixed..runs.len() {
        for earlier in 0..later {
            let (a, b) = (runs[earlier], runs[later]);
            let apart = a.iter().zip(b).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
            assert!(bits(a) == bits(b) || apart > 1e-6, "{case}: runs {earlier} and {later} are {a:?} and {b:?}");
        }
    }
}

fn settings(starts: u64) -> Settings {
    let mut settings = Settings::default();
    settings.starts = starts;
    settings
}

/// Four runs of a line for the mean prediction: both ends and the middle twice.
#[test]
fn the_middle_that_a_search_repeats_is_one_repeat_however_it_is_counted() {
    let (model, space) = (Model::quadratic(1).unwrap(), Space::cube(1).unwrap());
    let problem = Problem::new(model.clone(), space.clone(), 4, Criterion::I).unwrap();
    let found = search(&problem, &Settings::default()).unwrap();
    let mut runs = found.design.coordinates().to_vec();
    runs.sort_by(f64::total_cmp);
    assert!((runs[0] + 1.0).abs() < 1e-9 && runs[1].abs() < 1e-5 && (runs[3] - 1.0).abs() < 1e-9, "{runs:?}");
    assert_eq!(repeats(&found.design), 1, "{runs:?}");
    let evaluation = evaluate(&model, &space, &found.design, &EvaluationSettings::default()).unwrap();
    assert_eq!(evaluation.degrees_of_freedom.pure_error, 1);
    let again = Criterion::I.efficiency(&model, &space, &found.design).unwrap();
    assert_eq!(found.efficiency.value.to_bits(), again.value.to_bits(), "the value is that of the design returned");
}

/// The middle of a line is best twice for the mean prediction, and a run of it is settled, a little off where a search ends.
#[test]
fn a_free_replicate_takes_the_place_of_the_fixed_run_that_it_repeats() {
    for given in [2.3e-9, -0.0, 4.1e-8] {
        let fixed = Design::new(1, vec![given]).unwrap();
        let problem = Problem::new(Model::quadratic(1).unwrap(), Space::cube(1).unwrap(), 4, Criterion::I).unwrap();
        let problem = problem.with_fixed_runs(fixed).unwrap();
        let found = search(&problem, &settings(64)).unwrap();
        let at = |x: &&f64| x.to_bits() == given.to_bits();
        let (first, n_there) = (found.design.coordinates()[0], found.design.coordinates().iter().filter(at).count());
        assert_eq!((first.to_bits(), n_there), (given.to_bits(), 2), "{:?}", found.design);
    }
}

/// Fixed runs may be as close to each other as they please: nobody moves what has been made.
#[test]
fn fixed_runs_are_returned_as_they_were_given() {
    let given = [0.0, 3e-7, -1.0, -1.0 + 4e-7];
    let problem = Problem::new(Model::quadratic(1).unwrap(), Space::cube(1).unwrap(), 7, Criterion::D).unwrap();
    let problem = problem.with_fixed_runs(Design::new(1, given.to_vec()).unwrap()).unwrap();
    let found = search(&problem, &settings(16)).unwrap();
    assert_eq!(bits(&found.design.coordinates()[..4]), bits(&given));
    for free in &found.design.coordinates()[4..] {
        assert!(given.contains(free) || given.iter().all(|x| (x - free).abs() > 1e-6), "{free}");
    }
}

/// Nine digits of a fixed run are not the fixed run.
#[test]
fn rounding_keeps_a_replicate_of_a_fixed_run_with_it() {
    let region = Region::new(vec![Parameter::continuous("pitch", "deg", 10.0, 22.0).unwrap()]).unwrap();
    let space = Space::of_region(&region).unwrap();
    let (third, other) = (1.0 / 3.0, 2.0_f64.sqrt() - 1.0);
    let design = Design::new(1, vec![third, third + 5e-7, other, other + 9.99e-7, third]).unwrap();
    let rounded = design.rounded(&region, &space, 1).unwrap();
    assert_eq!(repeats(&rounded), 3, "{rounded:?}");
    assert_eq!(rounded.coordinates()[0].to_bits(), third.to_bits());
    assert_equal_or_apart(&rounded, 1, "rounded");
}

/// A box, a box with levels on one of its axes, a grid, and a grid whose levels are close together.
fn spaces() -> Vec<Space> {
    let close = Axis::Levels(vec![-1.0, -1.1e-6, 0.0, 1.1e-6, 1.0]);
    vec![
        Space::cube(1).unwrap(),
        Space::cube(2).unwrap(),
        Space::of_axes(vec![Axis::equally_spaced(3).unwrap(), Axis::Continuous]).unwrap(),
        Space::grid(&[5, 5]).unwrap(),
        Space::of_axes(vec![close.clone(), close]).unwrap(),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn runs_of_a_design_that_is_found_are_equal_to_the_last_bit_or_apart(
        space in 0..5_usize,
        criterion in 0..6_usize,
        more in 1..6_usize,
        n_fixed in 0..3_usize,
        is_thorough: bool,
        seed in 0..1000_u64,
    ) {
        let (space, criterion) = (spaces()[space].clone(), Criterion::ALL[criterion]);
        let k = space.n_factors();
        let model = Model::quadratic(k).unwrap();
        let n = model.n_terms() + more + n_fixed;
        let mut problem = Problem::new(model, space.clone(), n, criterion).unwrap();
        if n_fixed > 0 {
            let ends = [vec![1.0; k], vec![0.0; k]];
            problem = problem.with_fixed_runs(Design::from_runs(&ends[..n_fixed]).unwrap()).unwrap();
        }
        problem = problem.with_replicates(Replicates::Allowed).unwrap();
        let mut settings = settings(8);
        settings.seed = seed;
        settings.effort = if is_thorough { Effort::Thorough } else { Effort::Quick };
        let case = format!("{criterion} over the {}, {n} runs", space.over());
        let found = search(&problem, &settings).unwrap();
        assert_equal_or_apart(&found.design, n_fixed, &case);
        prop_assert!(found.design.check_within(&space).is_ok(), "{}: {:?}", case, found.design);
        let again = criterion.efficiency(problem.model(), problem.judged(), &found.design).unwrap();
        prop_assert_eq!(found.efficiency, again);
        if space.axes().is_some_and(|axes| axes.iter().all(|axis| *axis == Axis::Continuous)) {
            let before = criterion.efficiency(problem.model(), &space, &found.design).unwrap();
            let polished = polished(&problem, &found.design).unwrap();
            assert_equal_or_apart(&polished, n_fixed, &case);
            let after = criterion.efficiency(problem.model(), &space, &polished).unwrap();
            prop_assert!(after.value <= before.value, "{}: {} after {}", case, after.value, before.value);
        }
    }
}
