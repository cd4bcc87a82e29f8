//! Points, values and weights.

use doe::Design;
use surface::Data;

#[test]
fn weights_are_per_point() {
    // 9 experiments at 0.7 and 36 simulations at 0.3: the simulations hold 63 % of the total.
    let coordinates = |n: usize| (0..n).map(|i| i as f64).collect();
    let experiments = Data::new(1, coordinates(9), vec![1.0; 9]).and_then(|data| data.weighted(0.7));
    let simulations = Data::new(1, coordinates(36), vec![0.0; 36]).and_then(|data| data.weighted(0.3));
    let both = experiments.expect("valid").followed_by(&simulations.expect("valid")).expect("one factor each");
    let total: f64 = both.weights().iter().sum();
    let simulated: f64 = both.weights()[9..].iter().sum();
    assert!((simulated / total - 10.8 / 17.1).abs() < 1e-15, "{simulated} of {total}");
}

#[test]
fn sites_group_replicates_and_leave_out_what_has_no_weight() {
    let points = vec![0.0, 1.0, 1.0, 0.0, -0.0, 1.0, 5.0, 5.0];
    let data =
        Data::new(2, points, vec![1.0, 2.0, 3.0, 4.0]).and_then(|data| data.with_weights(vec![1.0, 2.0, 1.0, 0.0]));
    assert_eq!(data.expect("valid").sites(), [vec![0, 2], vec![1]]);
}

#[test]
fn data_of_a_design_are_its_runs() {
    let design = Design::from_runs(&[[-1.0, 0.5], [1.0, 0.25]]).expect("a valid design");
    let data = Data::of_design(&design, vec![3.0, 4.0]).expect("one value per run");
    assert_eq!(data.points().collect::<Vec<_>>(), [[-1.0, 0.5], [1.0, 0.25]]);
    assert_eq!((data.values(), data.weights()), (&[3.0, 4.0][..], &[1.0, 1.0][..]));
}
