//! How long flights take: one alone, many in lanes on one thread, many in lanes on all threads.
//!
//! `cargo bench --package water-channel` on 2026-11-21, on two cores of an AMD EPYC, a portable build without `target-cpu`, Rust 1.95; medians of one run:
//!
//! | 300 s flight | 1 step per sample | 2 steps | times real time at 1 step | time against one alone |
//! |---|---|---|---|---|
//! | alone, `f64` | 11.0 ms | 20.9 ms | 27,000 | 1 |
//! | in lanes, one thread, per flight | 2.9 ms | 5.7 ms | 103,000 | 0.26 |
//! | in a batch of 576, two threads, per flight | 1.50 ms |  | 200,000 | 0.14 |
//!
//! The batch takes 0.87 s.
//! One pose, images and noise included, takes 0.7 us (the difference that three cameras make, by `cargo xtask speed --flights`): mostly a Gauss-Newton step over two dozen sightings and one or two more by the same matrix, half of it in sums and solution, a third in dots, pixels and noise.
//! One right-hand side with its share of the loop takes 230 ns in `f64` and 61 ns in lanes.
//! Lanes exist only as far as the compiler packs straight-line code into vectors: the bench shows at once if a change loses that, since lanes then take longer than flights alone.
//! Where the time goes, by sampling, in per cent (the `f64` column from a build in which the trigonometry is not inlined, so that it can be told apart):
//!
//! | part | `f64` | lanes |
//! |---|---|---|
//! | arc tangents | 46 | 35 |
//! | sines and cosines | 14 | 17 |
//! | aerodynamics without trigonometry | 10 | 8 |
//! | mass matrix and solution | 9 | 7 |
//! | bias accelerations, inertial loads, rows of the equation of motion | 9 | 12 |
//! | pose and sight without trigonometry | 2 | 3 |
//! | tether drag | 1 | 3 |
//! | quadratures and sums of RK4 | 3 | 4 |
//! | flow, controller, watching | 2 | 5 |
//! | not attributable | 4 | 6 |
//!
//! What cameras, water that moves and sides that differ cost is measured by `cargo xtask speed --flights`, all in turn in one run, and kept in
//! `docs/results-flights.md`; the benches below are for whoever works on one of them. Making the table of a flight's water takes a tenth of a flight at one step a sample.
//!
//! With all of it off a flight is no slower than before there was any: 0.94 times at one step and 0.96 at two, against commit `b3d192f` (lanes on one thread,
//! six runs of each in turn, on 2026-11-24); that page says so, too.

use bat_dynamics::Fidelity;
use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use rayon::{ThreadPool, ThreadPoolBuilder};
use water_channel::{
    FlightRequest, FlightSettings, MovingWater, Pose, ProfileFile, RigFile, SensingFile, Shedding, TestProfile,
    Tracker, Turbulence, closed_loop_modes, fly, fly_all, fly_seeded,
};

fn main() {
    divan::main();
}

fn fixture(name: &str) -> String {
    format!("{}/../../fixtures/bat/{name}", env!("CARGO_MANIFEST_DIR"))
}

/// The 300 s test.
fn profile() -> TestProfile {
    ProfileFile::read(fixture("test-profile.toml")).expect("the fixture reads").profile
}

/// Flights over the box of the study, `n` by `n`.
fn requests(n: usize, fidelity: Fidelity) -> Vec<FlightRequest> {
    let rig = RigFile::read(fixture("rig.toml")).expect("the fixture reads").rig;
    let at = |low: f64, high: f64, k: usize| low + (high - low) * k as f64 / (n.max(2) - 1) as f64;
    let one = |k: usize| {
        let mut rig = rig.clone();
        rig.plant.body.center_of_mass_x = at(0.4565, 0.5125, k / n);
        rig.set_points.pitch_rad = at(0.0, 22.0, k % n).to_radians();
        FlightRequest { rig, fidelity }
    };
    (0..n * n).map(one).collect()
}

fn pool(n_threads: usize) -> ThreadPool {
    ThreadPoolBuilder::new().num_threads(n_threads).build().expect("a pool of a few threads")
}

#[divan::bench(args = [1, 2], sample_count = 20)]
fn one_flight_alone(bencher: Bencher<'_, '_>, steps_per_sample: usize) {
    let (profile, settings) = (profile(), FlightSettings::with_steps(steps_per_sample));
    let request = &requests(1, Fidelity::STALLED_WITH_ADDED_MASS)[0];
    bencher.bench(|| fly(black_box(request), &profile, &settings));
}

#[divan::bench(args = [1, 2], sample_count = 10)]
fn lanes_on_one_thread(bencher: Bencher<'_, '_>, steps_per_sample: usize) {
    let (profile, settings) = (profile(), FlightSettings::with_steps(steps_per_sample));
    let (requests, pool) = (requests(4, Fidelity::STALLED_WITH_ADDED_MASS), pool(1));
    bencher
        .counter(ItemsCount::new(requests.len()))
        .bench(|| pool.install(|| fly_all(black_box(&requests), &profile, &settings, |_| {})));
}

/// In lanes on one thread at two steps per sample, without cameras and with them: what the controller's eyes cost.
#[divan::bench(args = ["state", "cameras"], sample_count = 10)]
fn lanes_with_a_controller_that_sees(bencher: Bencher<'_, '_>, what: &str) {
    let (profile, settings) = (profile(), FlightSettings::with_steps(2));
    let (mut requests, pool) = (requests(4, Fidelity::STALLED_WITH_ADDED_MASS), pool(1));
    if what == "cameras" {
        let sensing = SensingFile::read(fixture("sensing.toml")).expect("the fixture reads").sensing;
        requests.iter_mut().for_each(|request| request.rig.sensing = Some(sensing.clone()));
    }
    bencher
        .counter(ItemsCount::new(requests.len()))
        .bench(|| pool.install(|| fly_all(black_box(&requests), &profile, &settings, |_| {})));
}

/// One sample of three cameras and ten dots, 24 sightings: images, noise and pose.
#[divan::bench]
fn one_pose_from_images(bencher: Bencher<'_, '_>) {
    let sensing = SensingFile::read(fixture("sensing.toml")).expect("the fixture reads").sensing;
    let viewer = water_channel::Viewer::new(&sensing, [0.0; 3]).expect("the fixture is in range");
    let pose = Pose { position_m: [-0.08, 0.0, -0.56], roll_rad: 0.0, pitch_rad: 0.3, heading_rad: 0.0 };
    let mut tracker = Tracker::new(&viewer);
    bencher.bench_local(|| tracker.observe(black_box(&pose)));
}

/// What each thing that is off by default costs, in lanes at one step per sample, the making of the water's table included.
#[divan::bench(args = ["off", "turbulence", "shedding", "asymmetry", "all three", "a seed each", "cameras", "all and cameras"], sample_count = 10)]
fn lanes_with_what_is_off_by_default(bencher: Bencher<'_, '_>, what: &str) {
    lanes_with(bencher, what, 1);
}

/// The same at two steps per sample, as flights are flown unless somebody says otherwise.
#[divan::bench(args = ["off", "all three", "cameras", "all and cameras"], sample_count = 10)]
fn lanes_at_two_steps_with_what_is_off_by_default(bencher: Bencher<'_, '_>, what: &str) {
    lanes_with(bencher, what, 2);
}

fn lanes_with(bencher: Bencher<'_, '_>, what: &str, steps_per_sample: usize) {
    let on = |name: &str| what == name || ["all three", "a seed each", "all and cameras"].contains(&what);
    let turbulence = Turbulence { intensity: 0.03, lateral_intensity: 0.03, vertical_intensity: 0.03, length_m: 0.1 };
    let shedding = Shedding { strouhal: 0.2, width_m: 0.092, lift_coefficient: 0.05, plane_rad: 0.5 };
    let water = MovingWater {
        turbulence: on("turbulence").then_some(turbulence),
        shedding: on("shedding").then_some(shedding),
        seed: 1,
    };
    let profile = profile().with_water(water).expect("water");
    let mut requests = requests(4, Fidelity::STALLED_WITH_ADDED_MASS);
    if on("asymmetry") {
        for request in &mut requests {
            let asymmetry = &mut request.rig.plant.asymmetry;
            (asymmetry.center_of_mass_y_m, asymmetry.offset_lateral_m, asymmetry.line_port_m) = (2e-4, 0.04, 5e-4);
        }
    }
    if what.contains("cameras") {
        let sensing = SensingFile::read(fixture("sensing.toml")).expect("the fixture reads").sensing;
        requests.iter_mut().for_each(|request| request.rig.sensing = Some(sensing.clone()));
    }
    let seeds: Vec<u64> = (0..requests.len() as u64).collect();
    let (settings, pool) = (FlightSettings::with_steps(steps_per_sample), pool(1));
    bencher.counter(ItemsCount::new(requests.len())).bench(|| {
        pool.install(|| match what {
            "a seed each" => fly_seeded(black_box(&requests), &seeds, &profile, &settings, |_| {}),
            _ => fly_all(black_box(&requests), &profile, &settings, |_| {}),
        })
    });
}

#[divan::bench(sample_count = 3)]
fn batch_of_576_flights_on_all_threads(bencher: Bencher<'_, '_>) {
    let (profile, settings) = (profile(), FlightSettings::with_steps(1));
    let requests = requests(24, Fidelity::STALLED_WITH_ADDED_MASS);
    bencher
        .counter(ItemsCount::new(requests.len()))
        .bench(|| fly_all(black_box(&requests), &profile, &settings, |_| {}));
}

#[divan::bench]
fn modes_of_the_sampled_loop(bencher: Bencher<'_, '_>) {
    let request = &requests(1, Fidelity::NUMERICAL)[0];
    let flow = bat_dynamics::Flow::straight(0.245);
    bencher.bench(|| closed_loop_modes(black_box(request), &flow));
}
