//! How far J is off at each number of RK4 steps per sample, over the plants that the studies fly.

use bat_dynamics::Fidelity;
use toml::Table;
use water_channel::{CostFile, CostWeights, Flight, FlightRequest, FlightSettings, fly_all};

use crate::rigs::{fixture, full_test, request, text};

/// The bounds of a parameter of Chapters 4 and 7 together.
fn bounds(name: &str) -> [f64; 2] {
    let (mut lower, mut upper) = (f64::INFINITY, f64::NEG_INFINITY);
    for file in ["bat/chapter4.toml", "bat/chapter7.toml"] {
        let table: Table = text(file).parse().unwrap();
        let parameters = table["parameter"].as_array().unwrap();
        for parameter in parameters.iter().filter(|parameter| parameter["name"].as_str() == Some(name)) {
            lower = parameter["lower"].as_float().unwrap().min(lower);
            upper = parameter["upper"].as_float().unwrap().max(upper);
        }
    }
    assert!(lower < upper, "{name} is a parameter");
    [lower, upper]
}

/// `n` values from bound to bound.
fn spread(name: &str, n: usize) -> Vec<f64> {
    let [lower, upper] = bounds(name);
    (0..n).map(|k| lower + (upper - lower) * k as f64 / (n - 1) as f64).collect()
}

/// Plants all over the box of the four parameters.
fn plants() -> Vec<FlightRequest> {
    let mut plants = Vec::new();
    for x_cm in spread("center_of_mass", 3) {
        for pitch in spread("pitch_set_point", 4) {
            for horizontal in spread("horizontal_area", 2) {
                for vertical in spread("vertical_area", 2) {
                    for fidelity in [Fidelity::NUMERICAL, Fidelity::STALLED_WITH_ADDED_MASS] {
                        let mut request = request(fidelity, x_cm, pitch);
                        request.rig.plant.horizontal_stabilizer.area_factor = horizontal;
                        request.rig.plant.vertical_stabilizer.area_factor = vertical;
                        plants.push(request);
                    }
                }
            }
        }
    }
    plants
}

/// The flights of all plants at so many steps per sample.
fn flights(plants: &[FlightRequest], steps_per_sample: usize) -> Vec<Option<Flight>> {
    let settings = FlightSettings::with_steps(steps_per_sample);
    fly_all(plants, &full_test(), &settings, |_| {}).into_iter().map(Result::ok).collect()
}

/// J of one flight.
fn cost(plant: &FlightRequest, flight: &Flight, weights: &CostWeights) -> f64 {
    weights.cost(&flight.integrals, plant.rig.ballast_pct_chord()).total
}

#[test]
fn error_of_the_cost_over_the_plants_of_the_studies_is_as_stated() {
    let plants = plants();
    let exact = flights(&plants, 8);
    let n_flown = exact.iter().flatten().count();
    assert!(n_flown > plants.len() / 2, "{n_flown} of {} plants fly", plants.len());
    for (steps_per_sample, stated) in [(1, 2e-5), (2, 6e-6)] {
        let flown = flights(&plants, steps_per_sample);
        for file in ["bat/cost-chapter4.toml", "bat/cost-chapter7.toml"] {
            let weights = CostFile::read(fixture(file)).unwrap().weights;
            for (plant, pair) in plants.iter().zip(flown.iter().zip(&exact)) {
                let (Some(flown), Some(exact)) = pair else { continue };
                let error = (cost(plant, flown, &weights) / cost(plant, exact, &weights) - 1.0).abs();
                let body = (plant.rig.plant.body.center_of_mass_x, plant.rig.set_points.pitch_rad.to_degrees());
                assert!(error < stated, "{file}: off by {error:e} at {steps_per_sample} steps per sample, {body:?}");
            }
        }
    }
}
