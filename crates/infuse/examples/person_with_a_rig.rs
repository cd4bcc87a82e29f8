//! A campaign that lives in a file: a program asks, a person answers, days may lie between.

use std::error::Error;
use std::fs;
use std::path::Path;

use design_space::{Parameter, Region};
use infuse::{CodesignProblem, Outcome, Role, gradient};

/// What the model says: best at 46.1 % chord and 17.3 deg.
fn simulation(p: &[f64]) -> Result<f64, String> {
    let (mass, pitch) = (p[0] - 46.1, p[1] - 17.3);
    Ok(4.35 + 0.08 * mass * mass + 0.06 * pitch * pitch - 0.02 * mass * pitch)
}

/// What the water says, with nobody knowing: best at 49.3 % chord and 19.4 deg.
fn rig(trial: &gradient::Trial) -> Outcome {
    if trial.id.number() == 8 {
        let reason = "tether caught on the frame".to_owned();
        return Outcome::Failed { reason };
    }
    let (mass, pitch) = (trial.point[0] - 49.3, trial.point[1] - 19.4);
    Outcome::Value(5.81 + 0.07 * mass * mass + 0.07 * pitch * pitch)
}

/// One visit: load, ask, tell every trial, save. Whether there is more to do.
fn visit(file: &Path) -> Result<bool, Box<dyn Error>> {
    let mut campaign: gradient::Loop = serde_json::from_str(&fs::read_to_string(file)?)?;
    if let gradient::Ask::Trials(trials) = campaign.ask(&mut simulation)? {
        for trial in trials {
            campaign.tell(trial.id, rig(&trial))?;
        }
        fs::write(file, serde_json::to_string_pretty(&campaign)?)?;
    }
    Ok(campaign.stop().is_none())
}

#[expect(clippy::print_stdout, reason = "an example shows what it computes")]
fn main() -> Result<(), Box<dyn Error>> {
    let region = Region::new(vec![
        Parameter::continuous("center of mass", "% chord", 45.65, 51.25)?,
        Parameter::continuous("pitch", "deg", 10.0, 22.0)?,
    ])?;
    let problem = CodesignProblem::new(region, vec![Role::Plant, Role::Controller])?;
    let settings = gradient::Settings::new(problem.per_role(0.6, 0.6), vec![1.0, 1.0]);
    let file = std::env::temp_dir().join(format!("campaign-{}.json", std::process::id()));
    fs::write(&file, serde_json::to_string(&gradient::Loop::new(problem, settings)?)?)?;
    while visit(&file)? {}

    let campaign: gradient::Loop = serde_json::from_str(&fs::read_to_string(&file)?)?;
    fs::remove_file(&file)?;
    for report in campaign.reports() {
        let (best, cost) = (&report.numerical, report.experiment_cost);
        let (mass, pitch, number) = (best.point[0], best.point[1], report.iteration);
        let measured = cost.map_or("not measured".to_owned(), |cost| format!("{cost:.3}"));
        println!("{number}: {mass:.2} % {pitch:.2} deg {:.3} {measured}", best.corrected_cost);
    }
    if let Some(reason) = campaign.stop() {
        println!("{reason}");
    }
    Ok(())
}
