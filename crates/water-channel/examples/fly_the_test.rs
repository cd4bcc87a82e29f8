//! Flies the 300 s test with the rig of the fixtures; an argument names a CSV file for the log.
#![expect(clippy::print_stdout, reason = "an example talks")]

use std::error::Error;
use std::fs::File;
use std::path::Path;

use bat_dynamics::{Fidelity, Flow};
use water_channel::{
    CostFile, FlightRequest, FlightSettings, ProfileFile, RigFile, TERM_NAMES, closed_loop_modes, fly_logged,
};

fn main() -> Result<(), Box<dyn Error>> {
    let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/bat");
    let file = RigFile::read(fixtures.join("rig.toml"))?;
    let profile = ProfileFile::read(fixtures.join("test-profile.toml"))?.profile;
    let weights = CostFile::read(fixtures.join("cost-chapter4.toml"))?.weights;

    println!("{}", file.title);
    for (name, fidelity) in
        [("numerical model", Fidelity::NUMERICAL), ("stand-in for the channel", Fidelity::STALLED_WITH_ADDED_MASS)]
    {
        let request = FlightRequest { rig: file.rig.clone(), fidelity };
        let (outcome, log) = fly_logged(&request, &profile, &FlightSettings::default(), 1)?;
        let flight = outcome?;
        let cost = weights.cost(&flight.integrals, file.rig.ballast_pct_chord());
        println!("\n{name}: J = {:.4} s", cost.total);
        for (term, share) in TERM_NAMES.iter().zip(cost.terms) {
            println!("  {term:<10} {share:9.5} s  {:5.1} %", 100.0 * share / cost.total);
        }
        let extremes = flight.extremes;
        println!("  largest heading  {:6.2} deg", extremes.peak_heading_rad.to_degrees());
        println!(
            "  zenith angle     {:6.2} to {:.2} deg",
            extremes.smallest_zenith_rad.to_degrees(),
            extremes.largest_zenith_rad.to_degrees()
        );
        println!("  smallest tension {:6.3} N, {} line", extremes.smallest_tension_n, extremes.smallest_tension_line);
        let modes = closed_loop_modes(&request, &Flow::straight(0.245))?;
        if let Some(yaw) = modes.least_damped_oscillation() {
            let (rate, damping) = (yaw.mode.eigenvalue, yaw.mode.damping_ratio());
            println!(
                "  yaw mode         {:6.3} ± {:.3}i 1/s at 0.245 m/s, damping ratio {damping:.2}",
                rate.re, rate.im
            );
        }
        if let (Some(path), Fidelity::NUMERICAL) = (std::env::args().nth(1), fidelity) {
            log.write_csv(File::create(&path)?)?;
            println!("  {} samples written to {path}", log.rows.len());
        }
    }
    Ok(())
}
