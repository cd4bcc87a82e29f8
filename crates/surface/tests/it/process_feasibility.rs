//! Where experiments fail.

use surface::process::{Feasibility, Places};

/// Two numbers and a choice of three, as places have it: each way as far from each other.
const WAYS: [[f64; 2]; 3] = [[1.0, 0.0], [-0.5, 0.866], [-0.5, -0.866]];

fn probabilities(
    tested: &[([f64; 2], usize)],
    fails: impl Fn([f64; 2], usize) -> bool,
    at: &[([f64; 2], usize)],
) -> Vec<f64> {
    let flat = |places: &[([f64; 2], usize)]| {
        let of_each = places.iter().flat_map(|&([x, y], way)| [x, y, WAYS[way][0], WAYS[way][1]]);
        Places::new(4, &of_each.collect::<Vec<f64>>()).expect("valid places")
    };
    let succeeded: Vec<bool> = tested.iter().map(|&(point, way)| !fails(point, way)).collect();
    let feasibility = Feasibility::of(flat(tested), &succeeded).expect("one outcome per place").expect("one failed");
    feasibility.probabilities(&flat(at)).expect("places of the process")
}

fn spread(n: usize) -> Vec<([f64; 2], usize)> {
    let unit = |k: usize, by: f64| 2.0 * (k as f64 * by).fract() - 1.0;
    (0..n).map(|k| ([unit(k, 0.618_033_988_75), unit(k, 0.754_877_666_25)], k % 3)).collect()
}

/// Of a choice that never works the corners that nobody tried are not thought of; the others stay as good as they are.
#[test]
fn a_choice_with_which_nothing_works_is_told_from_places_where_runs_fail() {
    let corners: Vec<([f64; 2], usize)> = [[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]]
        .into_iter()
        .flat_map(|at| [(at, 0), (at, 1), (at, 2)])
        .collect();
    for found in corners.iter().zip(probabilities(&spread(45), |_, way| way == 1, &corners)) {
        let ((_, way), probability) = found;
        assert!(if *way == 1 { probability < 0.1 } else { probability > 0.9 }, "{probability} with way {way}");
    }
}

/// Beyond an edge in one number runs fail: what lies far beyond it is not thought of, whatever the others are.
#[test]
fn an_edge_is_learnt_over_all_that_does_not_matter() {
    let edge = |[x, _]: [f64; 2], _: usize| x > 0.3;
    let at: Vec<([f64; 2], usize)> = (0..3).flat_map(|way| [([0.95, 0.9], way), ([-0.9, -0.9], way)]).collect();
    for (index, probability) in probabilities(&spread(45), edge, &at).into_iter().enumerate() {
        assert!(if index % 2 == 0 { probability < 0.15 } else { probability > 0.85 }, "{probability} at {index}");
    }
}

/// One failure among few runs says little of places far from it.
#[test]
fn one_failure_condemns_nothing_that_is_far_away() {
    let tested = spread(9);
    let failed = tested[4];
    let far = ([-failed.0[0].signum(), -failed.0[1].signum()], (failed.1 + 1) % 3);
    let found = probabilities(&tested, |[x, _], _| x.to_bits() == failed.0[0].to_bits(), &[failed, far]);
    assert!(found[0] < 0.6 && found[1] > 0.6, "{found:?}");
}

#[test]
fn where_nothing_failed_nothing_is_known_of_failures() {
    let places = Places::new(1, &[0.0, 0.5]).expect("valid places");
    assert!(Feasibility::of(places.clone(), &[true, true]).expect("one outcome per place").is_none(), "none failed");
    assert!(Feasibility::of(places, &[true]).is_err(), "an outcome is missing");
}
