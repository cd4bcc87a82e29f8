//! What it changes that ballast moves mass and inertia when the center of mass is shifted: costs of designs with and without.
//!
//! `cargo run --release --package water-channel --example moving_masses`
#![expect(clippy::print_stdout, reason = "an example prints")]

use bat_dynamics::{Ballast, Fidelity, MassModel};
use water_channel::{CostFile, FlightRequest, FlightSettings, Masses, ProfileFile, Rig, RigFile, fly_all};

/// In per cent of chord.
const CENTERS_OF_MASS: [f64; 4] = [45.6, 47.0, 49.0, 51.2];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let fixture = |name: &str| format!("{}/../../fixtures/bat/{name}", env!("CARGO_MANIFEST_DIR"));
    let rig = RigFile::read(fixture("rig.toml"))?.rig;
    let profile = ProfileFile::read(fixture("test-profile.toml"))?.profile;
    let weights = CostFile::read(fixture("cost-chapter4.toml"))?.weights;

    // A third of the mass is ballast, below the body and forward; estimated, the dissertation says nothing of it.
    let ballast = Ballast { mass_kg: 0.06, x: 0.3, y_m: 0.0, height_m: 0.01 };
    let model = MassModel { ballast: Some(ballast), ..MassModel::default() };
    let masses = Some(Masses { model, center_of_mass_x: rig.plant.body.center_of_mass_x });

    let at = |masses: Option<Masses>, percent: f64| {
        let mut rig = Rig { masses, ..rig.clone() };
        rig.plant.body.center_of_mass_x = percent / 100.0;
        FlightRequest { rig, fidelity: Fidelity::STALLED_WITH_ADDED_MASS }
    };
    println!("center of mass   inertia in pitch   cost: as if by itself   with its ballast");
    for percent in CENTERS_OF_MASS {
        let requests = [at(None, percent), at(masses, percent)];
        let inertias = requests.each_ref().map(|request| request.rig.parameters().map(|p| p.body.inertia_yy_kg_m2));
        let [before, after] = inertias;
        let flights = fly_all(&requests, &profile, &FlightSettings::default(), |_| {});
        let mut costs = Vec::new();
        for (request, flight) in requests.iter().zip(flights) {
            costs.push(weights.cost(&flight?.integrals, request.rig.ballast_pct_chord()).total);
        }
        let change = 100.0 * (after? / before? - 1.0);
        println!("{percent:>8.1} % chord {change:>+15.1} % {:>21.3} s {:>16.3} s", costs[0], costs[1]);
    }
    Ok(())
}
