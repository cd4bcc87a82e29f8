//! Gaussian processes against scikit-learn and 40 digits, their sampler against its own prior, their intervals against frequency.

use std::collections::BTreeSet;
use std::sync::Arc;

use ::serde::Deserialize;
use faer::{Mat, Side};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use surface::process::{
    AveragedProcess, Contrast, Covariance, GaussianProcess, Hyperparameters, Marginals, Places, Residual,
    SamplerSettings, SimulationUse, Sites, Structure,
};
use surface::{Data, Error};

use crate::{check_close, check_list};

/// Of the largest number: both sides lose the condition of the covariance of the sites, at most 1e5.
const TOLERANCE: f64 = 1e-8;

#[derive(Deserialize)]
struct Fixture {
    cases: Vec<Case>,
}

#[derive(Deserialize)]
struct Case {
    simulation: SimulationUse,
    residual: Residual,
    by: String,
    points: Vec<Vec<f64>>,
    values: Vec<f64>,
    weights: Vec<f64>,
    simulated: Vec<f64>,
    queries: Vec<Vec<f64>>,
    simulated_queries: Vec<f64>,
    hyper: [Hyperparameters; 2],
    expected: [Expected; 2],
}

#[derive(Deserialize)]
struct Expected {
    means: Vec<f64>,
    covariance: Vec<f64>,
    log_likelihood: f64,
    left_out: Vec<f64>,
    factor: Option<[f64; 2]>,
}

fn cases() -> Vec<Case> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/surface/process.json");
    let text = std::fs::read_to_string(path).expect("the fixture is there");
    serde_json::from_str::<Fixture>(&text).expect("the fixture has the expected form").cases
}

impl Case {
    fn name(&self) -> String {
        format!("{:?}, {:?}, {}", self.simulation, self.residual, self.by)
    }

    fn process(&self, hyper: &Hyperparameters) -> GaussianProcess {
        let data = Data::new(self.points[0].len(), self.points.concat(), self.values.clone())
            .and_then(|data| data.with_weights(self.weights.clone()))
            .expect("valid data");
        let sites = Sites::new(&data, Some(&self.simulated)).expect("one simulated response per point");
        let structure = Structure { simulation: self.simulation, residual: self.residual };
        GaussianProcess::new(Arc::new(sites), structure, hyper.clone()).expect("a positive definite covariance")
    }

    fn queries(&self) -> Places {
        Places::new(self.queries[0].len(), &self.queries.concat())
            .and_then(|places| places.with_simulated(self.simulated_queries.clone()))
            .expect("valid places")
    }
}

#[test]
fn posterior_is_that_of_dense_algebra_and_of_scikit_learn() {
    for case in cases() {
        for (hyper, expected) in case.hyper.iter().zip(&case.expected) {
            let (process, places, name) = (case.process(hyper), case.queries(), case.name());
            let n = places.n_places();
            check_list(
                &process.means(&places).expect("places of the process"),
                &expected.means,
                TOLERANCE,
                &format!("{name}: means"),
            );
            let joint = process.joint(&places).expect("places of the process");
            check_list(joint.means(), &expected.means, TOLERANCE, &format!("{name}: joint means"));
            let flat: Vec<f64> = (0..n).flat_map(|place| joint.covariances(place)).copied().collect();
            check_list(&flat, &expected.covariance, TOLERANCE, &format!("{name}: covariance"));
            let diagonal: Vec<f64> = (0..n).map(|i| expected.covariance[i * (n + 1)]).collect();
            let marginals = process.marginals(&places).expect("places of the process");
            check_list(&marginals.variances, &diagonal, TOLERANCE, &format!("{name}: variances"));
            let contrast = process.contrast(&places).expect("places of the process");
            let differences: Vec<f64> = (0..n).map(|i| expected.means[i] - expected.means[0]).collect();
            check_list(&contrast.means, &differences, TOLERANCE, &format!("{name}: differences"));
            let of_difference = |i: usize| diagonal[i] + diagonal[0] - 2.0 * expected.covariance[i * n];
            let of_differences: Vec<f64> = (0..n).map(of_difference).collect();
            check_list(&contrast.variances, &of_differences, TOLERANCE, &format!("{name}: their variances"));
        }
    }
}

#[test]
fn leaving_a_site_out_and_the_factor_of_the_simulation_are_those_of_dense_algebra() {
    for case in cases().iter().filter(|case| case.by == "mpmath") {
        for (hyper, expected) in case.hyper.iter().zip(&case.expected) {
            let process = case.process(hyper);
            // The sites of the fixture are in lexicographic order.
            let places = process.sites().places();
            let mut order: Vec<usize> = (0..places.n_places()).collect();
            order.sort_by(|&a, &b| places.point(a).partial_cmp(&places.point(b)).expect("finite coordinates"));
            let left_out = process.standardized_leave_one_out();
            let left_out: Vec<f64> = order.into_iter().map(|site| left_out[site]).collect();
            check_list(&left_out, &expected.left_out, 1e-6, &format!("{}: leave one site out", case.name()));
            match (process.simulation_factor(), expected.factor) {
                (Some(found), Some(expected)) => check_list(&found, &expected, TOLERANCE, "factor"),
                (found, expected) => assert!(found.is_none() && expected.is_none(), "{}: a factor", case.name()),
            }
        }
    }
}

/// The likelihood of the measurements, however they are grouped, up to a constant that hyperparameters share.
#[test]
fn likelihood_ratio_is_that_of_all_single_measurements() {
    for case in cases() {
        let [found, expected] = [
            case.process(&case.hyper[0]).log_likelihood() - case.process(&case.hyper[1]).log_likelihood(),
            case.expected[0].log_likelihood - case.expected[1].log_likelihood,
        ];
        check_close(found, expected, 1e-8 * (1.0 + expected.abs()), &case.name());
    }
}

/// One measurement and a constant: z = 0, so the posterior of the constant is N(0, 4 σ²/(4 + σ²)) in closed form.
#[test]
fn posterior_of_one_measurement_is_the_closed_form() {
    let data = Data::new(1, vec![0.3], vec![2.0]).expect("valid data");
    let sites = Sites::new(&data, None).and_then(|sites| sites.in_units(0.0, 1.0)).expect("valid units");
    let structure = Structure { simulation: SimulationUse::Ignored, residual: Residual::None };
    let hyper = Hyperparameters {
        trend: 0.0,
        simulation: 0.0,
        residual: 0.0,
        lengths: vec![1.0],
        noise: 1.0,
        assembly: 0.0,
        additive: None,
    };
    let process = GaussianProcess::new(Arc::new(sites), structure, hyper).expect("a valid process");
    let marginals =
        process.marginals(&Places::new(1, &[-1.0, 0.7]).expect("valid places")).expect("places of the process");
    for place in 0..2 {
        check_close(marginals.means[place], 2.0 * 4.0 / 5.0, 1e-14, "mean");
        check_close(marginals.variances[place], 4.0 / 5.0, 1e-14, "variance");
    }
}

/// A response drawn from a structure and the prior, measured at some places.
struct World {
    truth: Vec<f64>,
    normals: Vec<f64>,
    data: Data,
    simulated: Vec<f64>,
    others: Places,
}

const N_FACTORS: usize = 2;
const N_DATA: usize = 14;
const N_OTHERS: usize = 4;

fn world(structure: Structure, rng: &mut ChaCha8Rng) -> World {
    let normals: Vec<f64> = (0..N_FACTORS + 4).map(|_| StandardNormal.sample(rng)).collect();
    let hyper = Hyperparameters::of_prior(&normals);
    let n = N_DATA + N_OTHERS;
    let coordinates: Vec<f64> = (0..n * N_FACTORS).map(|_| 2.0 * rng.random::<f64>() - 1.0).collect();
    let slopes: Vec<f64> = (0..2).map(|_| StandardNormal.sample(rng)).collect();
    let raw: Vec<f64> =
        coordinates.chunks(N_FACTORS).map(|x| slopes[0] * (3.0 * x[0]).sin() + slopes[1] * x[1]).collect();
    // The simulation of the sites has the mean zero that a process gives it, so that both mean the same by a constant.
    let center = raw[..N_DATA].iter().sum::<f64>() / N_DATA as f64;
    let simulated: Vec<f64> = raw.iter().map(|s| s - center).collect();
    let all = Places::new(N_FACTORS, &coordinates)
        .and_then(|places| places.with_simulated(simulated.clone()))
        .expect("valid places");
    let covariance = Covariance::of(structure, &hyper).and_then(|covariance| covariance.between(&all, &all));
    let mut covariance = covariance.expect("as many lengths as axes");
    (0..n).for_each(|i| covariance[(i, i)] += 1e-9);
    let factor = covariance.llt(Side::Lower).expect("positive definite").L().to_owned();
    let draw = Mat::<f64>::from_fn(n, 1, |_, _| StandardNormal.sample(rng));
    let drawn = &factor * &draw;
    let expected = |i: usize| if structure.simulation == SimulationUse::Ignored { 0.0 } else { simulated[i] };
    let truth: Vec<f64> = (0..n).map(|i| expected(i) + drawn[(i, 0)]).collect();
    let noise = hyper.noise.sqrt();
    let values = (0..N_DATA).map(|i| truth[i] + noise * Distribution::<f64>::sample(&StandardNormal, rng)).collect();
    let data = Data::new(N_FACTORS, coordinates[..N_DATA * N_FACTORS].to_vec(), values).expect("valid data");
    let others = all.select(&(N_DATA..n).collect::<Vec<_>>());
    World { truth: truth[N_DATA..].to_vec(), normals, data, simulated: simulated[..N_DATA].to_vec(), others }
}

fn averaged(world: &World, structure: Structure, particles: usize, seed: u64) -> AveragedProcess {
    let sites = Sites::new(&world.data, Some(&world.simulated)).and_then(|sites| sites.in_units(0.0, 1.0));
    let settings = SamplerSettings {
        structures: vec![structure],
        particles,
        sweeps: 2,
        last_sweeps: 8,
        seed,
        ..SamplerSettings::default()
    };
    AveragedProcess::new(sites.expect("valid units"), &settings).expect("a valid process")
}

/// Simulation-based calibration (Talts et al. 2018): the rank of a true hyperparameter among those sampled is uniform.
/// χ² over 8 bins of 240 worlds; with 7 degrees 24.3 is exceeded once in a thousand.
#[test]
fn true_hyperparameters_rank_uniformly_among_those_sampled() {
    const WORLDS: usize = 240;
    const BINS: usize = 8;
    let structure = Structure { simulation: SimulationUse::Scaled, residual: Residual::Smooth };
    let mut counts = [[0_usize; BINS]; 4];
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    for seed in 0..WORLDS as u64 {
        let world = world(structure, &mut rng);
        let process = averaged(&world, structure, 31, seed);
        let truth = Hyperparameters::of_prior(&world.normals);
        let read: [fn(&Hyperparameters) -> f64; 4] = [|h| h.residual, |h| h.lengths[0], |h| h.noise, |h| h.trend];
        for (counts, read) in counts.iter_mut().zip(read) {
            let below = process.particles().iter().filter(|particle| read(particle.hyperparameters()) < read(&truth));
            counts[below.count() * BINS / 32] += 1;
        }
    }
    let expected = WORLDS as f64 / BINS as f64;
    for (name, counts) in ["residual", "length", "noise", "trend"].iter().zip(counts) {
        let chi_squared: f64 = counts.iter().map(|&count| (count as f64 - expected).powi(2) / expected).sum();
        assert!(chi_squared < 24.3, "{name}: χ² {chi_squared:.1} of the ranks {counts:?}");
    }
}

/// Four places in each of 200 worlds for each structure: standard error of the share 1.4 % were they independent, some 2 % as
/// they are.
#[test]
fn intervals_hold_as_often_as_they_say_on_draws_from_the_model() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    for structure in [
        Structure { simulation: SimulationUse::Ignored, residual: Residual::Rough },
        Structure { simulation: SimulationUse::Subtracted, residual: Residual::None },
        Structure { simulation: SimulationUse::Scaled, residual: Residual::Smooth },
    ] {
        let (mut inside, mut total) = (0, 0);
        for seed in 0..200 {
            let world = world(structure, &mut rng);
            let process = averaged(&world, structure, 16, seed);
            let marginals = process.marginals(&world.others).expect("places of the process");
            for (place, truth) in world.truth.iter().enumerate() {
                let half = 1.2816 * marginals.variances[place].sqrt();
                inside += usize::from((truth - marginals.means[place]).abs() <= half);
                total += 1;
            }
        }
        let share = f64::from(inside as u32) / f64::from(total);
        assert!((0.74..=0.87).contains(&share), "{structure:?}: {share:.3} of the 80 % intervals hold");
    }
}

fn settings(seed: u64) -> SamplerSettings {
    SamplerSettings { particles: 8, seed, ..SamplerSettings::default() }
}

fn process_of(points: &[f64], values: &[f64], seed: u64) -> AveragedProcess {
    let data = Data::new(2, points.to_vec(), values.to_vec()).expect("valid data");
    AveragedProcess::new(Sites::new(&data, None).expect("valid sites"), &settings(seed)).expect("a valid process")
}

#[test]
fn settings_of_the_sampler_are_refused_by_name() {
    let refused = |noise: Option<f64>, particles: usize| {
        let data = Data::new(1, vec![-1.0, 0.0, 1.0], vec![1.0, 0.0, 2.0]).expect("valid data");
        let sites = Sites::new(&data, None).expect("valid sites");
        let settings = SamplerSettings { noise, particles, ..SamplerSettings::default() };
        AveragedProcess::new(sites, &settings).map(drop).unwrap_err().to_string()
    };
    for noise in [-1.0, f64::NAN, f64::INFINITY] {
        let said = refused(Some(noise), 8);
        assert_eq!(said, format!("`noise` is {noise:?}, expected a finite number from 0 on"));
    }
    assert!(refused(None, 1).contains("number of particles: 1, expected at least 2"));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    /// Another unit of the response changes nothing but the unit.
    #[test]
    fn unit_and_zero_of_the_response_do_not_matter(
        rows in prop::collection::vec((-1.0..1.0_f64, -1.0..1.0_f64, -2.0..2.0_f64), 4..12),
        exponent in -40..40_i32,
        zero in -3.0..3.0_f64,
    ) {
        let points: Vec<f64> = rows.iter().flat_map(|row| [row.0, row.1]).collect();
        let values: Vec<f64> = rows.iter().map(|row| row.2).collect();
        let unit = 2.0_f64.powi(exponent);
        let others: Vec<f64> = values.iter().map(|value| unit * (value + zero)).collect();
        let places = Places::new(2, &[0.2, 0.1, -0.9, 0.8]).expect("valid places");
        let (a, b) = (process_of(&points, &values, 3), process_of(&points, &others, 3));
        let (a, b) = (a.marginals(&places).expect("places of the process"), b.marginals(&places).expect("places of the process"));
        for place in 0..2 {
            // A slice that hangs on the last digit may go another way: so the sampler is compared by what it estimates.
            check_close(b.means[place] / unit - zero, a.means[place], 1e-2, "mean");
            check_close((b.variances[place]).sqrt() / unit, a.variances[place].sqrt(), 2e-2, "deviation");
        }
    }

    /// The same seed gives the same bits in one thread and in two.
    #[test]
    fn number_of_threads_does_not_matter(
        rows in prop::collection::vec((-1.0..1.0_f64, -1.0..1.0_f64, -2.0..2.0_f64), 2..10),
    ) {
        let points: Vec<f64> = rows.iter().flat_map(|row| [row.0, row.1]).collect();
        let values: Vec<f64> = rows.iter().map(|row| row.2).collect();
        let places = Places::new(2, &[0.2, 0.1, -0.9, 0.8]).expect("valid places");
        let with = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            pool.install(|| process_of(&points, &values, 7).marginals(&places).expect("places of the process"))
        };
        prop_assert_eq!(with(1), with(2));
    }
}

/// What an update of rank one makes of means and covariances is what the process makes of one more measurement.
#[test]
fn a_measurement_counted_in_is_the_process_with_it() {
    let points = [-0.8, -0.5, 0.1, 0.9, 0.6, -0.7, -0.2, 0.3];
    let values = [0.4, -0.3, 1.1, 0.2];
    let asked = [0.5, 0.5, -0.6, 0.7, 0.0, -0.9];
    let hyper = Hyperparameters {
        trend: 0.6,
        simulation: 0.0,
        residual: 0.8,
        lengths: vec![0.7, 1.2],
        noise: 0.04,
        assembly: 0.0,
        additive: None,
    };
    let structure = Structure { simulation: SimulationUse::Ignored, residual: Residual::Smooth };
    let process = |points: &[f64], values: &[f64]| {
        let data = Data::new(2, points.to_vec(), values.to_vec()).expect("valid data");
        let sites = Sites::new(&data, None).and_then(|sites| sites.in_units(0.3, 2.0)).expect("valid units");
        GaussianProcess::new(Arc::new(sites), structure, hyper.clone()).expect("well conditioned")
    };
    let places = Places::new(2, &asked).expect("valid places");
    let before = process(&points, &values);
    let mut joint = before.joint(&places).expect("places of the process");
    let (measured, noise) = (1, before.noise().powi(2));
    let deviation = (joint.variance(measured) + noise).sqrt();
    let value = joint.means()[measured] + deviation;
    let effect = joint.effect(measured, noise);
    let after = process(&[&points[..], &asked[2..4]].concat(), &[&values[..], &[value]].concat())
        .joint(&places)
        .expect("places of the process");
    joint.measure(&effect);
    for (place, moved) in effect.iter().enumerate() {
        check_close(joint.means()[place] + moved, after.means()[place], 1e-12, "mean");
        for (own, other) in joint.covariances(place).iter().zip(after.covariances(place)) {
            check_close(*own, *other, 1e-12, "covariance");
        }
    }
}

/// Places are computed in blocks and sites in pairs: 300 places and 41 sites leave some of both over.
#[test]
fn a_place_among_many_has_the_marginals_of_a_place_alone() {
    let coordinate = |at: usize| ((at as f64 + 0.5) * 0.618_033_988_749).fract() * 2.0 - 1.0;
    let points: Vec<f64> = (0..82).map(coordinate).collect();
    let values = points.chunks_exact(2).map(|x| x[0] * x[1] + (2.0 * x[0]).sin()).collect();
    let data = Data::new(2, points, values).expect("valid data");
    let coordinates: Vec<f64> = (82..682).map(coordinate).collect();
    let places = Places::new(2, &coordinates).expect("valid places");
    for residual in [Residual::None, Residual::Smooth, Residual::Rough] {
        let structure = Structure { simulation: SimulationUse::Ignored, residual };
        let [trend, variance, noise] = [1.0, 0.7, 1e-2];
        let lengths = vec![0.6, 1.1];
        let hyper = Hyperparameters {
            trend,
            simulation: 0.0,
            residual: variance,
            lengths,
            noise,
            assembly: 0.0,
            additive: None,
        };
        let sites = Arc::new(Sites::new(&data, None).expect("valid sites"));
        let process = GaussianProcess::new(sites, structure, hyper).expect("well conditioned");
        let (all, joint) = (
            process.marginals(&places).expect("places of the process"),
            process.joint(&places).expect("places of the process"),
        );
        for (place, point) in coordinates.chunks_exact(2).enumerate() {
            let alone = process.marginals(&Places::new(2, point).expect("a place")).expect("places of the process");
            check_close(all.means[place], alone.means[0], 1e-12, "mean");
            check_close(all.variances[place], alone.variances[0], 1e-12, "variance");
            check_close(all.variances[place], joint.variance(place), 1e-12, "variance beside covariances");
        }
    }
}

#[test]
fn means_alone_and_differences_are_those_of_the_marginals() {
    let points: Vec<f64> = (0..16).map(|i| (f64::from(i) * 0.61).sin()).collect();
    let values: Vec<f64> = points.chunks_exact(2).map(|p| p[0] - 2.0 * p[1] * p[1]).collect();
    let process = process_of(&points, &values, 4);
    let places = Places::new(2, &[0.2, 0.1, -0.9, 0.8, 0.5, -0.3]).expect("valid places");
    let marginals = process.marginals(&places).expect("places of the process");
    check_list(&process.means(&places).expect("places of the process"), &marginals.means, TOLERANCE, "means");
    let contrasts = process.contrasts(&places).expect("places of the process");
    assert_eq!(contrasts.len(), settings(4).particles, "one of each particle");
    for place in 0..3 {
        let mean = contrasts.iter().map(|each| each.means[place]).sum::<f64>() / contrasts.len() as f64;
        check_close(mean, marginals.means[place] - marginals.means[0], 1e-7, "difference to the first place");
    }
    let both = Places::new(2, &[0.2, 0.1]).and_then(|place| place.followed_by(&places)).expect("two axes each");
    assert_eq!(both.n_places(), 4, "one and three");
    check_list(
        &process.means(&both).expect("places of the process")[1..],
        &marginals.means,
        TOLERANCE,
        "means of those that follow",
    );
}

#[test]
fn what_is_known_exactly_is_below_or_not() {
    let contrast = Contrast { means: vec![0.0, -1.0, 1.0, -1.0], variances: vec![0.0, 0.0, 0.0, 4.0] };
    let found: Vec<f64> = (0..4).map(|place| contrast.probability_below(place)).collect();
    // The last by a table of the normal distribution: half a standard deviation.
    check_list(&found, &[0.0, 1.0, 0.0, 0.691_462_461_274_013], 1e-12, "probabilities");
}

#[test]
fn responses_without_any_spread_and_single_ones_are_fitted() {
    for values in [vec![5.0], vec![5.0; 6], vec![0.0; 6], vec![1e-12; 3], vec![-1e12, 1e12, 3.0]] {
        let points: Vec<f64> = (0..2 * values.len()).map(|i| (i as f64 * 0.37).sin()).collect();
        let process = process_of(&points, &values, 1);
        let marginals =
            process.marginals(&Places::new(2, &[0.0, 0.0]).expect("valid places")).expect("places of the process");
        let largest = values.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
        assert!(marginals.means[0].abs() <= 3.0 * largest + 1e-300, "{values:?}: mean {:e}", marginals.means[0]);
        assert!(marginals.variances[0].is_finite() && marginals.variances[0] >= 0.0, "{values:?}: {marginals:?}");
    }
}

#[test]
fn what_cannot_be_right_is_refused_by_name() {
    let data = Data::new(2, vec![0.0; 4], vec![1.0, 2.0]).expect("valid data");
    let refused = |error: Result<Sites, Error>| error.expect_err("it is refused").to_string();
    assert!(refused(Sites::new(&data, Some(&[1.0]))).contains("simulated responses: 1, expected 2"));
    let sites = Sites::new(&data, None).expect("valid sites");
    assert!(refused(sites.clone().in_units(0.0, 0.0)).contains("scale"));
    assert!(refused(sites.clone().in_units(f64::NAN, 1.0)).contains("center"));
    let only_simulated = vec![Structure { simulation: SimulationUse::Scaled, residual: Residual::Smooth }];
    let settings = SamplerSettings { structures: only_simulated, ..settings(1) };
    let error = AveragedProcess::new(sites, &settings).expect_err("there is no simulation");
    assert!(error.to_string().contains("structures: 0"), "{error}");
    assert!(Places::new(2, &[0.0, f64::NAN]).is_err());
    assert!(Places::new(2, &[0.0, 1.0]).expect("valid").with_simulated(vec![f64::INFINITY]).is_err());
}

/// scipy.stats.norm.interval(0.9, 3, 2) is 3 ± 3.2897072539029444; with a noise of 1.5 it is 3 ± 0.5 √(16 + 9) 1.6448536269514722.
#[test]
fn intervals_are_those_of_a_normal_distribution() {
    let marginals = Marginals { means: vec![0.0, 3.0], variances: vec![1.0, 4.0] };
    for (noise, half) in [(0.0, 3.289_707_253_902_944_4), (1.5, 2.5 * 1.644_853_626_951_472_2)] {
        let [low, high] = marginals.interval(1, 0.9, noise).expect("an interval");
        check_close(3.0 - low, half, 1e-12, "below");
        check_close(high - 3.0, half, 1e-12, "above");
    }
    for (place, probability, noise, part) in [
        (1, 1.0, 0.0, "`probability` is 1.0"),
        (1, f64::NAN, 0.0, "NaN"),
        (1, 0.9, -1.0, "`noise` is -1.0"),
        (2, 0.9, 0.0, "2"),
    ] {
        let error = marginals.interval(place, probability, noise).expect_err("it is refused").to_string();
        assert!(error.contains(part), "{error}");
    }
}

/// A process that uses a simulation says nothing of places where it does not know what that says, nor of places in another space.
#[test]
fn places_of_another_process_are_refused_by_name() {
    let data = Data::new(2, vec![-0.5, 0.1, 0.2, 0.7, 0.9, -0.3], vec![1.0, 2.0, 1.5]).expect("valid data");
    let sites = Arc::new(Sites::new(&data, Some(&[0.9, 2.2, 1.4])).expect("valid sites"));
    let hyper = Hyperparameters {
        trend: 0.1,
        simulation: 0.1,
        residual: 0.5,
        lengths: vec![1.0, 1.0],
        noise: 0.01,
        assembly: 0.0,
        additive: None,
    };
    let used = Structure { simulation: SimulationUse::Scaled, residual: Residual::Smooth };
    let of = |structure: Structure, hyper: Hyperparameters| GaussianProcess::new(Arc::clone(&sites), structure, hyper);
    let process = of(used, hyper.clone()).expect("a process");
    let bare = Places::new(2, &[0.3, 0.3, 0.1, 0.1]).expect("places");
    let other = Places::new(3, &[0.3; 3]).expect("a place");
    let refused = |places: &Places, part: &str| {
        let said = [
            process.means(places).map(|_| ()),
            process.marginals(places).map(|_| ()),
            process.joint(places).map(|_| ()),
            process.contrast(places).map(|_| ()),
        ];
        for one in said {
            let error = one.expect_err("it is refused").to_string();
            assert!(error.contains(part), "{error}");
        }
    };
    refused(&bare, "simulated responses: 0, expected 2");
    refused(&other, "factors of the places: 3, expected 2");
    let error = process.gradient(&bare.select(&[0]), Some(&[0.0, 0.0])).expect_err("it is refused").to_string();
    assert!(error.contains("simulated responses: 0, expected 1"), "{error}");
    let ignored = Structure { simulation: SimulationUse::Ignored, ..used };
    assert!(of(ignored, hyper.clone()).expect("a process").means(&bare).is_ok(), "it does not use the simulation");
    assert!(process.contrast(&bare.select(&[])).is_err(), "there is no first place");
    for (bad, part) in [
        (Hyperparameters { noise: -1.0, ..hyper.clone() }, "`noise` is -1.0"),
        (Hyperparameters { residual: f64::NAN, ..hyper.clone() }, "`residual` is NaN"),
        (Hyperparameters { lengths: vec![1.0, 0.0], ..hyper.clone() }, "`length` is 0.0"),
    ] {
        let error = of(used, bad).expect_err("it is refused").to_string();
        assert!(error.contains(part), "{error}");
    }
}

/// A known deviation of a measurement is that of every particle, in the unit of the response.
#[test]
fn known_noise_is_that_of_every_particle() {
    let points: Vec<f64> = (0..16).map(|i| (f64::from(i) * 0.61).sin()).collect();
    let values: Vec<f64> = points.chunks_exact(2).map(|p| 30.0 * p[0] - 50.0 * p[1]).collect();
    let data = Data::new(2, points, values).expect("valid data");
    let known = SamplerSettings { noise: Some(1.7), ..settings(2) };
    let process = AveragedProcess::new(Sites::new(&data, None).expect("valid sites"), &known).expect("a process");
    for particle in process.particles() {
        check_close(particle.noise(), 1.7, 1e-12, "noise");
    }
}

/// Resampling copies particles, slice steps part them again: the last ones are those of `last_sweeps`, the others of `sweeps`.
#[test]
fn last_sweeps_are_those_after_the_last_resampling() {
    let points: Vec<f64> = (0..16).map(|i| (f64::from(i) * 0.61).sin()).collect();
    let values: Vec<f64> = points.chunks_exact(2).map(|p| p[0] - 2.0 * p[1] * p[1]).collect();
    let data = Data::new(2, points, values).expect("valid data");
    let different = |sweeps: usize, last_sweeps: usize| -> BTreeSet<u64> {
        let settings = SamplerSettings { particles: 16, sweeps, last_sweeps, ..SamplerSettings::default() };
        let process = AveragedProcess::new(Sites::new(&data, None).expect("valid sites"), &settings);
        process.expect("a process").particles().iter().map(|particle| particle.noise().to_bits()).collect()
    };
    assert!(different(1, 0).len() < 16, "the last copies stay copies");
    assert_eq!(different(0, 1).len(), 16, "one step parts all copies");
    assert_ne!(different(1, 0), different(0, 0), "steps before the last move particles, too");
}

/// Without a residual and with known noise the variance of the trend is all that is not known: a quadrature over its prior is the evidence.
#[test]
fn evidence_is_the_likelihood_averaged_over_what_was_possible() {
    let points: Vec<f64> = (0..9).map(|i| (f64::from(i) * 0.61).sin()).collect();
    let values: Vec<f64> = points.iter().map(|x| 3.0 * x - 5.0 * x * x + 0.2 * (40.0 * x).sin()).collect();
    let sites = Sites::new(&Data::new(1, points, values).expect("valid data"), None).expect("valid sites");
    let structure = Structure { simulation: SimulationUse::Ignored, residual: Residual::None };
    let noise = 0.3;
    let shared = Arc::new(sites.clone());
    let likelihood = |normal: f64| {
        let scale = GaussianProcess::new(Arc::clone(&shared), structure, Hyperparameters::of_prior(&[0.0; 5]));
        let scale = scale.expect("a process").scale();
        let hyper = Hyperparameters {
            noise: (noise / scale).powi(2),
            ..Hyperparameters::of_prior(&[0.0, normal, 0.0, 0.0, 0.0])
        };
        GaussianProcess::new(Arc::clone(&shared), structure, hyper).expect("a process").log_likelihood()
    };
    let step = 0.01;
    let nodes = (-600..=600).map(|i| f64::from(i) * step);
    let expected =
        nodes.map(|z| (likelihood(z) - 0.5 * z * z).exp()).sum::<f64>() * step / std::f64::consts::TAU.sqrt();
    let settings = SamplerSettings { structures: vec![structure], noise: Some(noise), particles: 2000, ..settings(1) };
    let found = AveragedProcess::new(sites, &settings).expect("a process").log_evidence();
    check_close(found, expected.ln(), 0.05, "evidence");
}

/// Of the same measurements in two assemblies, of which one reads one more, those speak for a shared error; where both read alike, not.
#[test]
fn evidence_tells_whether_assemblies_share_an_error() {
    for (above, is_shared) in [(1.0, true), (0.0, false)] {
        let points: Vec<f64> = (0..20).map(|i| (f64::from(i) * 0.61).sin()).collect();
        let assemblies: Vec<usize> = (0..20).map(|i| i % 2).collect();
        let read = |(at, x): (usize, &f64)| x * x + 0.05 * (at as f64 * 1.7).cos() + above * (at % 2) as f64;
        let values = points.iter().enumerate().map(read).collect();
        let sites = Sites::in_assemblies(&Data::new(1, points, values).expect("valid data"), None, &assemblies);
        let sites = sites.expect("valid sites");
        let [with, without] = [true, false].map(|shared_error| {
            let settings = SamplerSettings { shared_error, particles: 100, ..settings(1) };
            AveragedProcess::new(sites.clone(), &settings).expect("a process")
        });
        assert!(without.assembly_deviation() == 0.0, "none is learnt where there is none");
        let gain = with.log_evidence() - without.log_evidence();
        assert!(if is_shared { gain > 5.0 } else { gain < 1.0 }, "{above} above: {gain}");
    }
}
