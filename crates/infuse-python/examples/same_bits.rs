//! What the Rust libraries say, as JSON: the tests of the Python package compare it bit for bit.
#![expect(clippy::print_stdout, reason = "an example talks")]

use bat_dynamics::Fidelity;
use design_space::{Cell, Model, Parameter, Region};
use infuse::{global, pooled};
use serde_json::{Value, json};
use surface::Surface;
use water_channel::{CostFile, FlightRequest, FlightSettings, ProfileFile, RigFile, fly_all};

type Failure = Box<dyn std::error::Error>;

/// Two parameters of 21 levels, as the test of the package has them.
fn region() -> Result<Region, Failure> {
    Ok(Region::new(vec![
        Parameter::continuous("spring", "N/mm", 10.0, 50.0)?.with_levels(21)?,
        Parameter::continuous("damper", "N s/m", 0.0, 400.0)?.with_levels(21)?,
    ])?)
}

fn simulation(p: &[f64]) -> f64 {
    let (x, y) = ((p[0] - 25.0) / 20.0, (p[1] - 150.0) / 200.0);
    x * x + y * y
}

fn rig(p: &[f64]) -> f64 {
    let (x, y) = ((p[0] - 34.0) / 20.0, (p[1] - 220.0) / 200.0);
    x * x + y * y + 0.25 * x * y
}

/// A pooled campaign whose experiments fail above 380.
fn pooled_campaign() -> Result<Value, Failure> {
    let mut settings = pooled::Settings::new(6);
    (settings.max_batches, settings.seed) = (3, 7);
    let mut campaign = pooled::Loop::new(&region()?, settings)?;
    let mut simulate = |_: Cell, p: &[f64]| Ok(simulation(p));
    let mut experiment =
        |trial: &pooled::Trial| if trial.point[1] > 380.0 { Err("it broke".to_owned()) } else { Ok(rig(&trial.point)) };
    campaign.run(&mut simulate, &mut experiment)?;
    let assessment = campaign.assess(Some(&mut simulate))?;
    let points: Vec<&Vec<f64>> = campaign.records().iter().map(|record| &record.trial.point).collect();
    Ok(json!({ "points": points, "assessment": assessment }))
}

fn global_campaign() -> Result<Value, Failure> {
    let mut settings = global::Settings::new(Model::quadratic(2)?, 9, 12);
    (settings.max_batches, settings.seed) = (2, 7);
    let mut campaign = global::Loop::new(&region()?, settings)?;
    campaign.run(&mut |_, p| Ok(simulation(p)), &mut |trial| Ok(rig(&trial.point)))?;
    Ok(serde_json::to_value(campaign.reports())?)
}

fn design() -> Result<Value, Failure> {
    let problem = doe::Problem::new(Model::quadratic(2)?, doe::Space::cube(2)?, 8, doe::Criterion::I)?;
    let mut settings = doe::Settings::default();
    (settings.starts, settings.seed) = (20, 3);
    let found = doe::search(&problem, &settings)?;
    Ok(json!({ "runs": found.design.coordinates(), "percent": found.efficiency.percent }))
}

fn surfaces() -> Result<Value, Failure> {
    let coordinates: Vec<f64> = (0..24).map(|i| f64::from(i * 7 % 23) / 11.5 - 1.0).collect();
    let values = coordinates.chunks(2).map(|p| p[0] * p[0] - p[1]).collect();
    let data = surface::Data::new(2, coordinates, values)?;
    let point = [0.3, -0.4];
    let settings = surface::process::SamplerSettings {
        structures: surface::process::Structure::ALL[..3].to_vec(),
        seed: 5,
        ..surface::process::SamplerSettings::default()
    };
    let process = surface::process::AveragedProcess::new(surface::process::Sites::new(&data, None)?, &settings)?;
    let marginals = process.marginals(&surface::process::Places::new(2, &point)?)?;
    Ok(json!({
        "inverse distance": surface::InverseDistance::fit(data.clone(), 3.0)?.predict(&point),
        "squared exponential": surface::SquaredExponential::fit_scale(data)?.predict(&point),
        "process": [marginals.means[0], marginals.variances[0]],
    }))
}

fn flights() -> Result<Value, Failure> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/bat");
    let rig = RigFile::read(format!("{folder}/rig.toml"))?.rig;
    let profile = ProfileFile::read(format!("{folder}/test-profile.toml"))?.profile;
    let weights = CostFile::read(format!("{folder}/cost-chapter7.toml"))?.weights;
    let request = |center_of_mass: f64, pitch: f64| {
        let mut rig = rig.clone();
        rig.plant.body.center_of_mass_x = center_of_mass / 100.0;
        rig.set_points.pitch_rad = pitch.to_radians();
        FlightRequest { rig, fidelity: Fidelity::STALLED_WITH_ADDED_MASS }
    };
    let requests = [request(45.7, 8.29), request(47.0, 10.0), request(50.0, 12.5)];
    let flights = fly_all(&requests, &profile, &FlightSettings::with_steps(1), |_| {});
    let cost = |(request, flight): (&FlightRequest, &Result<water_channel::Flight, water_channel::FlightError>)| {
        let flight = flight.as_ref().ok()?;
        Some(weights.cost(&flight.integrals, request.rig.ballast_pct_chord()).total)
    };
    Ok(json!(requests.iter().zip(&flights).map(cost).collect::<Vec<_>>()))
}

fn main() -> Result<(), Failure> {
    let all = json!({
        "pooled": pooled_campaign()?,
        "global": global_campaign()?,
        "design": design()?,
        "surfaces": surfaces()?,
        "flights": flights()?,
    });
    println!("{all}");
    Ok(())
}
