//! A body without inertia on one forward and two aft lines starts with its nose low and its port side low.
#![expect(clippy::print_stdout, reason = "an example talks")]

use tether_control::{
    Controller, ControllerParameters, ControllerState, Error, FilteredPd, Measurement, SetPoints, TetherLayout,
};

const SEPARATION_LONGITUDINAL_M: f64 = 0.07;
const SEPARATION_LATERAL_M: f64 = 0.096;

fn main() -> Result<(), Error> {
    let controller = Controller::new(ControllerParameters {
        altitude: FilteredPd::new(0.2, 0.0, 0.7)?,
        pitch: FilteredPd::new(0.04, 0.016, 0.1)?,
        roll: FilteredPd::new(0.07, 0.032, 0.13)?,
        set_points: SetPoints { altitude_m: 0.6, pitch_rad: 0.3, roll_rad: 0.0 },
        sample_time_s: 0.025,
        layout: TetherLayout::OneForwardTwoAft,
        speed_limit_m_s: 0.0108,
    })?;
    let mut state = ControllerState::default();
    let mut lines_m = [0.600, 0.602, 0.598]; // center, starboard, port

    println!("time   altitude  pitch   roll    lines at their limit");
    println!("s      m         rad     rad     center, starboard, port");
    for sample in 0..=240 {
        let [center, starboard, port] = lines_m;
        let measured = Measurement {
            altitude_m: lines_m.iter().sum::<f64>() / 3.0,
            pitch_rad: ((center - 0.5 * (starboard + port)) / SEPARATION_LONGITUDINAL_M).atan(),
            roll_rad: ((port - starboard) / SEPARATION_LATERAL_M).atan(),
        };
        let command = controller.command(&mut state, &measured);
        if sample % 40 == 0 {
            println!(
                "{:4.1}   {:.4}    {:.4}  {:7.4}  {:?}",
                f64::from(sample) * 0.025,
                measured.altitude_m,
                measured.pitch_rad,
                measured.roll_rad,
                command.saturated_lines(),
            );
        }
        for (line_m, speed_m_s) in lines_m.iter_mut().zip(command.saturated_m_s) {
            *line_m += speed_m_s * 0.025;
        }
    }
    Ok(())
}
