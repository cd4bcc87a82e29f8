//! Measurements that come in assemblies share an error: against closed forms of a random-effects model, and drawn ones.

use std::sync::Arc;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use surface::Data;
use surface::process::{
    AveragedProcess, GaussianProcess, Hyperparameters, Places, Residual, SamplerSettings, SimulationUse, Sites,
    Structure,
};

const CONSTANT: Structure = Structure { simulation: SimulationUse::Ignored, residual: Residual::None };

fn of_constant(noise: f64, assembly: f64) -> Hyperparameters {
    Hyperparameters { trend: 0.0, simulation: 0.0, residual: 0.0, lengths: vec![1.0], noise, assembly, additive: None }
}

/// y = c + a_g + ε with c ~ N(0, 4): each mean of m in an assembly is N(c, τ² + σ²/m), so the posterior of c is a weighted mean.
#[test]
fn posterior_of_a_constant_weighs_assemblies_as_the_random_effects_model_does() {
    let (noise, assembly) = (0.3, 0.8);
    let groups: [&[f64]; 3] = [&[1.0, 1.2, 0.9, 1.1], &[3.0], &[2.0, 2.3]];
    let values: Vec<f64> = groups.concat();
    let names: Vec<usize> = vec![7, 7, 7, 7, 2, 5, 5];
    let data = Data::new(1, vec![0.3; values.len()], values).expect("valid data");
    let sites = Sites::in_assemblies(&data, None, &names).and_then(|sites| sites.in_units(0.0, 1.0)).expect("valid");
    let process = GaussianProcess::new(Arc::new(sites), CONSTANT, of_constant(noise, assembly)).expect("a process");
    let marginals = process.marginals(&Places::new(1, &[-0.4]).expect("a place")).expect("places of the process");
    let (mut precision, mut sum) = (1.0 / 4.0, 0.0);
    for group in groups {
        let m = group.len() as f64;
        let weight = 1.0 / (assembly + noise / m);
        precision += weight;
        sum += weight * group.iter().sum::<f64>() / m;
    }
    assert!((marginals.means[0] - sum / precision).abs() < 1e-12, "{}", marginals.means[0]);
    assert!((marginals.variances[0] - 1.0 / precision).abs() < 1e-12, "{}", marginals.variances[0]);
    assert!((process.assembly_deviation() - assembly.sqrt()).abs() < 1e-15);
}

/// The density of two measurements of one assembly, integrated by hand: they are normal with covariance 4 + τ² between them.
#[test]
fn likelihood_is_that_of_measurements_with_the_covariance_of_their_assembly() {
    let density = |y: [f64; 2], noise: f64, assembly: f64| {
        let (diagonal, off) = (4.0 + assembly + noise, 4.0 + assembly);
        let determinant = diagonal * diagonal - off * off;
        let square = (diagonal * (y[0] * y[0] + y[1] * y[1]) - 2.0 * off * y[0] * y[1]) / determinant;
        -0.5 * (determinant.ln() + square)
    };
    let y = [0.7, -0.4];
    let found = |noise: f64, assembly: f64| {
        let data = Data::new(1, vec![0.1, 0.1], y.to_vec()).expect("valid data");
        let sites = Sites::in_assemblies(&data, None, &[1, 1]).and_then(|sites| sites.in_units(0.0, 1.0));
        let sites = Arc::new(sites.expect("valid"));
        GaussianProcess::new(sites, CONSTANT, of_constant(noise, assembly)).expect("a process").log_likelihood()
    };
    let ratio = found(0.2, 0.9) - found(0.7, 0.1);
    let expected = density(y, 0.2, 0.9) - density(y, 0.7, 0.1);
    assert!((ratio - expected).abs() < 1e-12, "{ratio} {expected}");
}

/// Without an assembly that has more than one measurement, or with a variance of zero, nothing changes.
#[test]
fn assemblies_without_an_error_are_no_assemblies() {
    let data = Data::new(1, vec![-0.5, 0.1, 0.1, 0.9], vec![1.0, 2.0, 2.2, 1.5]).expect("valid data");
    let hyper = Hyperparameters { trend: 0.5, residual: 0.4, ..of_constant(0.05, 0.0) };
    let structure = Structure { simulation: SimulationUse::Ignored, residual: Residual::Smooth };
    let marginals = |sites: Sites| {
        let process = GaussianProcess::new(Arc::new(sites), structure, hyper.clone()).expect("a process");
        process.marginals(&Places::new(1, &[-1.0, 0.4]).expect("places")).expect("places of the process")
    };
    let together = marginals(Sites::new(&data, None).expect("valid"));
    let apart = marginals(Sites::in_assemblies(&data, None, &[1, 2, 3, 3]).expect("valid"));
    for place in 0..2 {
        assert!((together.means[place] - apart.means[place]).abs() < 1e-12);
        assert!((together.variances[place] - apart.variances[place]).abs() < 1e-12);
    }
    assert!(Sites::in_assemblies(&data, None, &[1, 2]).is_err(), "one name per point");
}

/// Eight assemblies of four measurements of a plane: the shared error and the noise are told apart, and learnt to a factor of two.
#[test]
fn shared_error_is_told_from_the_noise() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let mut found = Vec::new();
    for (shared, noise) in [(0.5, 0.1), (0.02, 0.3)] {
        let (mut coordinates, mut values, mut names) = (Vec::new(), Vec::new(), Vec::new());
        for assembly in 0..8 {
            let normal: f64 = StandardNormal.sample(&mut rng);
            for _ in 0..4 {
                let (x, e): (f64, f64) = (2.0 * rng.random::<f64>() - 1.0, StandardNormal.sample(&mut rng));
                coordinates.push(x);
                values.push(1.0 + 0.8 * x + shared * normal + noise * e);
                names.push(assembly);
            }
        }
        let data = Data::new(1, coordinates, values).expect("valid data");
        let sites = Sites::in_assemblies(&data, None, &names).expect("valid");
        let process = AveragedProcess::new(sites, &SamplerSettings::default()).expect("a process");
        found.push((process.assembly_deviation(), process.noise()));
    }
    let [(shared, noise), (little, more)] = [found[0], found[1]];
    assert!((0.25..1.0).contains(&shared) && (0.05..0.2).contains(&noise), "{found:?}");
    assert!(little < 0.2 && (0.15..0.6).contains(&more), "{found:?}");
}
