//! What the crate promises, one module per behavior.

mod controller;
mod errors;
mod filtered_pd;
mod frequency;
mod mixing;
mod serde;
mod signs;

use tether_control::{Controller, ControllerParameters, Error, FilteredPd, SetPoints, TetherLayout};

/// The sample time of the rig.
const SAMPLE_TIME_S: f64 = 0.025;

const LAYOUTS: [TetherLayout; 2] = [TetherLayout::OneForwardTwoAft, TetherLayout::TwoForwardOneAft];

/// A controller with gains of the rig's size, which the tests then vary.
fn parameters() -> Result<ControllerParameters, Error> {
    Ok(ControllerParameters {
        altitude: FilteredPd::new(0.2, 0.006, 0.7)?,
        pitch: FilteredPd::new(0.04, 0.016, 0.1)?,
        roll: FilteredPd::new(0.07, 0.032, 0.13)?,
        set_points: SetPoints { altitude_m: 0.6, pitch_rad: 0.3, roll_rad: 0.0 },
        sample_time_s: SAMPLE_TIME_S,
        layout: TetherLayout::OneForwardTwoAft,
        speed_limit_m_s: 0.011,
    })
}

fn controller() -> Controller {
    parameters().and_then(Controller::new).expect("the test's own parameters are valid")
}
