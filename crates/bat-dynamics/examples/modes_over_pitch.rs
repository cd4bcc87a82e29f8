//! Trim, line tensions and lateral modes of the turbine at several pitch angles.

use bat_dynamics::{Fidelity, Flow, Linearization, Parameters, Plant, TrimHeight, TrimRequest, linearize, modes, trim};

#[expect(clippy::print_stdout, reason = "an example shows what it computes")]
fn main() -> Result<(), bat_dynamics::Error> {
    let parameters = Parameters::water_channel_bat();
    let plant = Plant::new(&parameters, Fidelity::STALLED_WITH_ADDED_MASS)?;
    let flow = Flow::straight(0.245);

    println!("pitch  zenith  tension  margin  slowest lateral mode");
    println!("deg    deg     N        N       1/s, frequency in rad/s, damping ratio");
    for pitch_deg in [5.0, 10.0, 15.0, 20.0, 25.0_f64] {
        let request = TrimRequest { flow, pitch_rad: pitch_deg.to_radians(), height: TrimHeight::Altitude(0.61) };
        let trimmed = match trim(&plant, &request) {
            Ok(trimmed) => trimmed,
            Err(reason) => {
                println!("{pitch_deg:4.1}   {reason}");
                continue;
            }
        };
        let total_n: f64 = trimmed.tensions.named().iter().map(|line| line.1).sum();

        let linear = linearize(&plant, &trimmed.state, [0.0; 3], &flow)?;
        let slowest = &modes(&linear.among(&Linearization::LATERAL))?.modes[0];
        println!(
            "{pitch_deg:4.1}   {:6.2}  {total_n:.4}   {:.4}  {:+.3}{:+.3}i, {:.3}, {:+.3}",
            trimmed.coordinates[0].to_degrees(),
            trimmed.tensions.margin_n(),
            slowest.eigenvalue.re,
            slowest.eigenvalue.im,
            slowest.natural_frequency_rad_s(),
            slowest.damping_ratio(),
        );
    }
    Ok(())
}
