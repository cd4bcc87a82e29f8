//! Gradients of processes against central differences of what the processes say nearby.

use std::sync::Arc;

use surface::process::{
    Additive, AveragedProcess, GaussianProcess, Gradient, Hyperparameters, Marginals, Places, SamplerSettings,
    SimulationUse, Sites, Structure,
};
use surface::{Data, Error};

use crate::check_close;

const K: usize = 3;

fn simulation(x: &[f64]) -> f64 {
    (2.0 * x[0]).sin() + x[1] * x[2] - 0.3 * x[2]
}

fn its_gradient(x: &[f64]) -> [f64; K] {
    [2.0 * (2.0 * x[0]).cos(), x[2], x[1] - 0.3]
}

fn place(x: &[f64]) -> Places {
    Places::new(K, x).and_then(|place| place.with_simulated(vec![simulation(x)])).expect("a valid place")
}

fn sites() -> Sites {
    // Spread by an irrational lattice.
    let share = |index: usize, root: f64| 2.0 * ((index as f64 + 0.5) * root).fract() - 1.0;
    let points: Vec<[f64; K]> =
        (0..20).map(|index| [2.0_f64, 3.0, 5.0].map(|prime| share(index, prime.sqrt()))).collect();
    let values =
        points.iter().map(|x| 40.0 + 7.0 * (1.3 * simulation(x) + (3.0 * x[1]).cos() + x[0].powi(2))).collect();
    let simulated: Vec<f64> = points.iter().map(|x| simulation(x)).collect();
    let data = Data::new(K, points.concat(), values).expect("valid data");
    Sites::new(&data, Some(&simulated)).expect("one simulated response per point")
}

fn check(marginals: impl Fn(&Places) -> Marginals, gradient: impl Fn(&Places, &[f64]) -> Gradient, name: &str) {
    let step = 1e-5;
    for x in [[0.13, -0.42, 0.77], [-0.9, 0.55, 0.01], [0.0, 0.0, 0.0]] {
        let found = gradient(&place(&x), &its_gradient(&x));
        for axis in 0..K {
            let at = |by: f64| {
                let mut x = x;
                x[axis] += by;
                marginals(&place(&x))
            };
            let (above, below) = (at(step), at(-step));
            let slope = |a: f64, b: f64| (a - b) / (2.0 * step);
            let name = format!("{name}, axis {axis} at {x:?}");
            check_close(found.mean[axis], slope(above.means[0], below.means[0]), 1e-6, &format!("mean, {name}"));
            let variance = slope(above.variances[0], below.variances[0]);
            check_close(found.variance[axis], variance, 1e-5, &format!("variance, {name}"));
        }
    }
}

#[test]
fn gradients_are_those_of_central_differences_in_every_structure() {
    let sites = Arc::new(sites());
    let additive = Additive { axes: vec![2, 1], variance: 1.4, lengths: vec![0.8, 1.9] };
    for (structure, additive) in Structure::ALL.into_iter().flat_map(|one| [(one, None), (one, Some(additive.clone()))])
    {
        let what = format!("{structure:?}, {additive:?}");
        let hyper = Hyperparameters {
            trend: 0.7,
            simulation: 0.4,
            residual: 0.9,
            lengths: vec![0.6, 1.1, 2.3],
            noise: 0.01,
            assembly: 0.0,
            additive,
        };
        let process = GaussianProcess::new(Arc::clone(&sites), structure, hyper).expect("a valid process");
        let gradient =
            |place: &Places, slopes: &[f64]| process.gradient(place, Some(slopes)).expect("one place and its slopes");
        check(|place| process.marginals(place).expect("places of the process"), gradient, &what);
    }
}

#[test]
fn gradient_of_an_average_counts_how_far_its_particles_differ() {
    let process = AveragedProcess::new(sites(), &SamplerSettings::default()).expect("a valid process");
    let gradient = |place: &Places, slopes: &[f64]| process.gradient(place, Some(slopes)).expect("valid");
    check(|place| process.marginals(place).expect("places of the process"), gradient, "average");
}

#[test]
fn gradients_of_what_cannot_be_are_refused_by_name() {
    let sites = Arc::new(sites());
    let hyper = Hyperparameters {
        trend: 1.0,
        simulation: 1.0,
        residual: 1.0,
        lengths: vec![1.0; K],
        noise: 0.1,
        assembly: 0.0,
        additive: None,
    };
    let process = |simulation| {
        let structure = Structure { simulation, ..Structure::ALL[1] };
        GaussianProcess::new(Arc::clone(&sites), structure, hyper.clone()).expect("a valid process")
    };
    let scaled = process(SimulationUse::Scaled);
    let here = place(&[0.0; K]);
    let refused = |found: Result<Gradient, Error>, name: &str| {
        assert!(matches!(&found, Err(Error::Length { name: said, .. }) if *said == name), "{found:?}");
    };
    refused(scaled.gradient(&here, None), "slopes of the simulation");
    refused(scaled.gradient(&here, Some(&[1.0])), "slopes of the simulation");
    let twice = here.followed_by(&here).expect("as many factors");
    refused(scaled.gradient(&twice, Some(&[0.0; K])), "places");
    refused(scaled.gradient(&Places::new(2, &[0.0, 0.0]).expect("a place"), Some(&[0.0; K])), "coordinates");
    assert!(process(SimulationUse::Ignored).gradient(&here, None).is_ok(), "it needs no simulation");
}
