//! What is measured.

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use anyhow::{Context as _, Result};
use bat_dynamics::Fidelity;
use doe::{Model, Space};
use surface::process::{GaussianProcess, Hyperparameters, Places, Residual, SimulationUse, Sites, Structure};
use surface::{Data, GridPoints, InverseDistance, PointSource as _, Regression, SquaredExponential, Surface};
use water_channel::{FlightRequest, FlightSettings, ProfileFile, Rig, RigFile, TestProfile, Turbulence, fly, fly_all};

use super::theirs::Theirs;

const K: usize = 4;
const N_DATA: usize = 54;
/// Of the weight exp(-(1.5 d)²).
const SCALE: f64 = 1.5;
/// Places that a process is asked about at a time.
const AT_ONCE: u64 = 8192;
/// Flights in lanes at a time.
pub(super) const FLIGHTS: usize = 16;

/// Does the task once: its time in seconds, and the sum of what it found, which no longer counts.
type Ours = Box<dyn FnMut() -> Result<(f64, f64)> + Send>;

/// Something that takes time.
pub(super) struct Task {
    pub(super) words: &'static str,
    pub(super) ours: Ours,
    pub(super) reference: Reference,
    /// How many times as fast as the reference it is meant to be.
    pub(super) goal: f64,
    /// A part of it that it can't do without.
    pub(super) part: Option<Part>,
}

/// Part of a task, to see how much of a goal is within reach.
pub(super) struct Part {
    pub(super) words: &'static str,
    pub(super) run: Ours,
}

/// What it is compared with.
pub(super) enum Reference {
    /// A task of theirs, which has to give the same sum or is another model with as much to compute.
    Theirs { task: &'static str, is_same: bool },
    /// Of ours, the time of one counted so many times.
    Own { words: &'static str, run: Ours, times: f64 },
}

impl Reference {
    pub(super) fn words(&self) -> &'static str {
        match self {
            Self::Theirs { task: "process", .. } => "scikit-learn",
            Self::Theirs { .. } => "numpy and scipy",
            Self::Own { words, .. } => words,
        }
    }

    /// Its time in seconds, and the sum that ours has to give.
    pub(super) fn run(&mut self, theirs: &mut Theirs) -> Result<(f64, Option<f64>)> {
        match self {
            Self::Theirs { task, is_same } => {
                let (seconds, sum) = theirs.run(task)?;
                Ok((seconds, is_same.then_some(sum)))
            }
            Self::Own { run, times, .. } => Ok((*times * run()?.0, None)),
        }
    }
}

/// What comes out, and how many seconds it took.
fn timed<T>(task: impl FnOnce() -> T) -> (f64, T) {
    let start = Instant::now();
    let found = task();
    (start.elapsed().as_secs_f64(), found)
}

/// Points that fill the box evenly, with a smooth response.
fn data(n: usize) -> Result<Data> {
    data_of(K, n)
}

/// Their first coordinates, with that response.
fn data_of(n_factors: usize, n: usize) -> Result<Data> {
    let step = [0.856_674_883_854_502_9, 0.733_891_856_627_126, 0.628_706_721_041_338_8, 0.538_597_250_065_5];
    let coordinate = |point: usize, factor: usize| 2.0 * ((point as f64 + 0.5) * step[factor]).fract() - 1.0;
    let points: Vec<f64> = (0..n).flat_map(|i| (0..K).map(move |j| coordinate(i, j))).collect();
    let value = |x: &[f64]| 1.0 + x[0] * x[1] + x[2].sin() + x[3] * x[3];
    let values = points.chunks_exact(K).map(value).collect();
    let first = points.chunks_exact(K).flat_map(|point| &point[..n_factors]).copied().collect();
    Ok(Data::new(n_factors, first, values)?)
}

fn grid() -> Result<GridPoints> {
    Ok(GridPoints::of_space(&Space::grid(&[24; K])?)?)
}

/// All tasks.
pub(super) fn tasks(root: &Path) -> Result<Vec<Task>> {
    let theirs = |task, is_same| Reference::Theirs { task, is_same };
    let mut all = Vec::new();
    for Fitted { words, surface, reference, parts } in surfaces()? {
        let ([on_grid, scattered], [part_on_grid, part_scattered]) = (words, parts);
        all.push(Task {
            words: on_grid,
            ours: over_the_grid(Arc::clone(&surface))?,
            reference: theirs(reference, true),
            goal: 30.0,
            part: part_on_grid,
        });
        all.push(Task {
            words: scattered,
            ours: over_points(surface)?,
            reference: theirs(reference, true),
            goal: 10.0,
            part: part_scattered,
        });
    }
    all.extend([
        Task {
            words: "Gaussian process, 90 data: mean and variance",
            ours: process()?,
            reference: theirs("process", false),
            goal: 10.0,
            part: None,
        },
        flights(root)?,
    ]);
    Ok(all)
}

/// A surface, asked on a grid and at as many points in memory.
struct Fitted {
    words: [&'static str; 2],
    surface: Arc<dyn Surface>,
    reference: &'static str,
    parts: [Option<Part>; 2],
}

fn surfaces() -> Result<[Fitted; 3]> {
    let model = Model::quadratic(K)?;
    let along_one_axis = |surface: Arc<dyn Surface>| -> Result<Option<Part>> {
        let run = over_points_of(1, surface)?;
        Ok(Some(Part { words: "the same with distances along one axis alone", run }))
    };
    let of_one = |data: Data| -> Result<[Arc<dyn Surface>; 2]> {
        Ok([Arc::new(InverseDistance::fit(data.clone(), 2.0)?), Arc::new(SquaredExponential::fit(data, SCALE)?)])
    };
    let [inverse_distance_of_one, squared_exponential_of_one] = of_one(data_of(1, N_DATA)?)?;
    Ok([
        Fitted {
            words: ["regression, 15 terms, on the grid", "regression, 15 terms, at points in memory"],
            surface: Arc::new(Regression::fit(&model, &data(N_DATA)?)?),
            reference: "regression",
            parts: [None, None],
        },
        Fitted {
            words: ["inverse distance, 54 data, on the grid", "inverse distance, 54 data, at points in memory"],
            surface: Arc::new(InverseDistance::fit(data(N_DATA)?, 2.0)?),
            reference: "inverse distance",
            parts: [None, along_one_axis(inverse_distance_of_one)?],
        },
        Fitted {
            words: ["squared exponential, 54 data, on the grid", "squared exponential, 54 data, at points in memory"],
            surface: Arc::new(SquaredExponential::fit(data(N_DATA)?, SCALE)?),
            reference: "squared exponential",
            parts: [None, along_one_axis(squared_exponential_of_one)?],
        },
    ])
}

fn over_points(surface: Arc<dyn Surface>) -> Result<Ours> {
    over_points_of(K, surface)
}

/// At the points of the grid by their first coordinates.
fn over_points_of(n_factors: usize, surface: Arc<dyn Surface>) -> Result<Ours> {
    let grid = grid()?;
    let point = |index: u64| Ok(grid.point(index).context("a point of the grid")?[..n_factors].to_vec());
    let points = (0..grid.n_points()).map(point).collect::<Result<Vec<_>>>()?.concat();
    let mut estimates = vec![0.0; points.len() / n_factors];
    Ok(Box::new(move || {
        let (seconds, found) = timed(|| surface.predict_into(&points, &mut estimates));
        found?;
        Ok((seconds, estimates.iter().sum()))
    }))
}

fn over_the_grid(surface: Arc<dyn Surface>) -> Result<Ours> {
    let grid = grid()?;
    let mut estimates = vec![0.0; usize::try_from(grid.n_points())?];
    Ok(Box::new(move || {
        let (seconds, found) = timed(|| surface.predict_range(&grid, 0, &mut estimates));
        found?;
        Ok((seconds, estimates.iter().sum()))
    }))
}

/// With a quadratic trend, which the reference has not.
fn process() -> Result<Ours> {
    let sites = Arc::new(Sites::new(&data(90)?, None)?);
    let structure = Structure { simulation: SimulationUse::Ignored, residual: Residual::Smooth };
    let hyper = Hyperparameters {
        trend: 1.0,
        simulation: 0.0,
        residual: 1.0,
        lengths: vec![1.0; K],
        noise: 1e-2,
        assembly: 0.0,
        additive: None,
    };
    let process = GaussianProcess::new(sites, structure, hyper)?;
    let grid = grid()?;
    let point = |index: u64| grid.point(index).context("a point of the grid");
    let mut parts = Vec::new();
    for first in (0..grid.n_points()).step_by(AT_ONCE as usize) {
        let part = (first..grid.n_points().min(first + AT_ONCE)).map(point).collect::<Result<Vec<_>>>()?;
        parts.push(Places::new(K, &part.concat())?);
    }
    Ok(Box::new(move || {
        use rayon::prelude::*;
        let marginals = |places: &Places| process.marginals(places);
        let (seconds, found) = timed(|| parts.par_iter().map(marginals).collect::<Result<Vec<_>, _>>());
        let found = found?;
        Ok((seconds, found.iter().flat_map(|part| part.means.iter().chain(&part.variances)).sum()))
    }))
}

/// Turbulence as the flights that are timed meet it, alike in three directions.
pub(super) const TURBULENCE: Turbulence =
    Turbulence { intensity: 0.03, lateral_intensity: 0.03, vertical_intensity: 0.03, length_m: 0.1 };

/// Flights of the stand-in over the box of Chapter 4, four by four.
pub(super) fn over_the_box(rig: &Rig) -> Vec<FlightRequest> {
    let at = |low: f64, high: f64, k: usize| low + (high - low) * k as f64 / 3.0;
    let request = |k: usize| {
        let mut rig = rig.clone();
        rig.plant.body.center_of_mass_x = at(0.4565, 0.5125, k / 4);
        rig.set_points.pitch_rad = at(0.0, 22.0, k % 4).to_radians();
        FlightRequest { rig, fidelity: Fidelity::STALLED_WITH_ADDED_MASS }
    };
    (0..FLIGHTS).map(request).collect()
}

/// Flights of 300 s in lanes beside flights alone, on all threads against one flight after the other on one.
fn flights(root: &Path) -> Result<Task> {
    let folder = root.join("fixtures/bat");
    let profile = ProfileFile::read(folder.join("test-profile.toml"))?.profile;
    let requests = over_the_box(&RigFile::read(folder.join("rig.toml"))?.rig);
    let alone = (requests[0].clone(), profile.clone());
    let settings = FlightSettings::with_steps(1);
    let (first_half, same_profile) = (requests[..FLIGHTS / 2].to_vec(), profile.clone());
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let half: Ours = Box::new(move || {
        let fly_half = || one_thread.install(|| fly_all(&first_half, &same_profile, &settings, |_| {}));
        let (seconds, found) = timed(fly_half);
        Ok((seconds, found.iter().filter(|flight| flight.is_ok()).count() as f64))
    });
    let in_lanes: Ours = Box::new(move || {
        let (seconds, found) = timed(|| fly_all(&requests, &profile, &settings, |_| {}));
        Ok((seconds, found.iter().filter(|flight| flight.is_ok()).count() as f64))
    });
    Ok(Task {
        words: "16 flights of 300 s, in lanes on two threads",
        ours: in_lanes,
        reference: Reference::Own {
            words: "one alone on one thread, 16 times",
            run: one_alone(alone),
            times: FLIGHTS as f64,
        },
        goal: 7.0,
        part: Some(Part { words: "half as many, in lanes on one thread", run: half }),
    })
}

fn one_alone((request, profile): (FlightRequest, TestProfile)) -> Ours {
    let settings = FlightSettings::with_steps(1);
    Box::new(move || {
        let (seconds, found) = timed(|| fly(&request, &profile, &settings));
        Ok((seconds, f64::from(u8::from(found.is_ok()))))
    })
}
