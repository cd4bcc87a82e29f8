//! The dissertation's loop in two parameters on a rig, its state in a JSON file between visits.

use std::error::Error;
use std::fs;
use std::path::Path;

use design_space::{Cell, Model, Parameter, Region};
use infuse::{Outcome, global};

/// The model: its optimum is at (46.1, 17.3).
fn simulation(_: Cell, p: &[f64]) -> Result<f64, String> {
    Ok(4.35 + 0.08 * (p[0] - 46.1).powi(2) + 0.06 * (p[1] - 17.3).powi(2))
}

/// The water: its optimum is at (49.3, 19.4), and no reading is better than 0.05.
fn reading(p: &[f64], number: u64) -> f64 {
    let error = 0.05 * (12.9898 * number as f64).sin();
    5.81 + 0.07 * (p[0] - 49.3).powi(2) + 0.07 * (p[1] - 19.4).powi(2) + error
}

/// One visit: read the state, run what is asked, write the state. One trial in 25 fails, and ballast moves in steps of
/// its own, so the setting made is told.
fn visit(file: &Path) -> Result<bool, Box<dyn Error>> {
    let mut campaign: global::Loop = serde_json::from_str(&fs::read_to_string(file)?)?;
    let global::Ask::Trials(trials) = campaign.ask(&mut simulation)? else {
        return Ok(false);
    };
    for trial in trials {
        let number = trial.id.number();
        if number.is_multiple_of(25) {
            campaign.tell(trial.id, Outcome::Failed { reason: "a dot left the camera's view".to_owned() })?;
        } else {
            let made = [(20.0 * trial.point[0]).round() / 20.0, trial.point[1]];
            campaign.tell_at(trial.id, &made, Outcome::Value(reading(&made, number)))?;
        }
        fs::write(file, serde_json::to_string_pretty(&campaign)?)?;
    }
    Ok(true)
}

#[expect(clippy::print_stdout, reason = "an example shows what it computes")]
fn main() -> Result<(), Box<dyn Error>> {
    let region = Region::new(vec![
        Parameter::continuous("center of mass", "% chord", 45.0, 51.9)?.with_levels(24)?,
        Parameter::continuous("pitch", "deg", 10.0, 21.5)?.with_levels(24)?,
    ])?;
    let mut settings = global::Settings::new(Model::additive_quadratic(2)?, 10, 20);
    settings.max_batches = 5;
    let file = std::env::temp_dir().join(format!("global-campaign-{}.json", std::process::id()));
    fs::write(&file, serde_json::to_string(&global::Loop::new(&region, settings)?)?)?;
    while visit(&file)? {}

    let campaign: global::Loop = serde_json::from_str(&fs::read_to_string(&file)?)?;
    fs::remove_file(&file)?;
    for report in campaign.reports() {
        let (number, screening) = (report.number, &report.screening);
        let p = &screening.optimum;
        let s = screening.spread.s().map_or("undefined".to_owned(), |s| format!("{s:.3}"));
        let left = 100.0 * screening.n_after as f64 / campaign.retained().n_cells() as f64;
        println!("{number}: {:.2} % {:.2} deg, J {:.3}, S {s}, {left:.1} % left", p[0], p[1], screening.optimum_value);
    }
    if let Some(reason) = campaign.stop() {
        println!("{reason}");
    }
    if let Some(dropped) = campaign.why_dropped(campaign.cell(&[46.2, 17.5])?) {
        println!("46.20 % 17.50 deg was dropped in batch {}: z = {:.1} > {:.2}", dropped.batch, dropped.z, dropped.z0);
    }
    Ok(())
}
