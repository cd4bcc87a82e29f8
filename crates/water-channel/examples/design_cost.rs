//! What a design of the Buoyant Air Turbine costs, as a command that any tool can call.
#![expect(clippy::print_stdout, reason = "an example talks")]

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use bat_dynamics::Fidelity;
use water_channel::{
    BoundedNoise, CostFile, CostWeights, FileError, FlightRequest, FlightSettings, ProfileFile, Rig, RigFile,
    TestProfile, fly,
};

const USAGE: &str = "\
design_cost --center-of-mass PERCENT --pitch DEGREES [--horizontal-area FACTOR] [--vertical-area FACTOR]
            [--stand-in [--run NUMBER]] [--fixtures FOLDER]

Flies a design of the Buoyant Air Turbine through the test and prints its cost in seconds, the cost of Chapter 7.

  --center-of-mass   % of chord aft of the leading edge
  --pitch            set point, deg
  --horizontal-area  factor on the area of the horizontal stabilizer, 1; as in the rig file when absent
  --vertical-area    factor on the area of the vertical stabilizer, 1; as in the rig file when absent
  --stand-in         flies the stand-in for the water channel, with stall and added mass, not the numerical model
  --run              number of the experiment from 0, which decides its noise, at most 2 % of the cost; without it there
                     is no noise
  --fixtures         folder with rig.toml, test-profile.toml and cost-chapter7.toml
  --help             this text

A design that cannot fly the test ends with exit code 1 and the reason, a wrong argument with exit code 2. With cameras in
rig.toml a test cannot be flown if they give no pose of the body at the start; where later images give none, so that poses
are held, a warning on stderr says how many, and another one names a camera that saw no dot in any image.
";

/// Wrong arguments.
const USAGE_ERROR: u8 = 2;
/// Largest error of a run, as a share of its cost.
const NOISE: f64 = 0.02;

/// What the command line asks for.
struct Request {
    center_of_mass_pct_chord: f64,
    pitch_deg: f64,
    horizontal_area: Option<f64>,
    vertical_area: Option<f64>,
    stand_in: bool,
    run: Option<u64>,
    fixtures: PathBuf,
}

impl Request {
    /// `None` where help is asked for.
    fn parse(arguments: &[String]) -> Result<Option<Self>, String> {
        let (mut center_of_mass, mut pitch, mut horizontal_area, mut vertical_area) = (None, None, None, None);
        let (mut stand_in, mut run, mut fixtures) = (None, None, None);
        let mut words = arguments.iter();
        while let Some(name) = words.next() {
            let mut value = || words.next().ok_or_else(|| format!("{name}: a value must follow"));
            let is_new = match name.as_str() {
                "--center-of-mass" => center_of_mass.replace(number(name, value()?)?).is_none(),
                "--pitch" => pitch.replace(number(name, value()?)?).is_none(),
                "--horizontal-area" => horizontal_area.replace(number(name, value()?)?).is_none(),
                "--vertical-area" => vertical_area.replace(number(name, value()?)?).is_none(),
                "--stand-in" => stand_in.replace(()).is_none(),
                "--run" => run.replace(counter(name, value()?)?).is_none(),
                "--fixtures" => fixtures.replace(PathBuf::from(value()?)).is_none(),
                "--help" | "-h" => return Ok(None),
                other => return Err(format!("no argument `{other}`: see design_cost --help")),
            };
            if !is_new {
                return Err(format!("{name} is given twice"));
            }
        }
        if run.is_some() && stand_in.is_none() {
            return Err("--run: the numerical model has no noise; it goes with --stand-in".to_owned());
        }
        Ok(Some(Self {
            center_of_mass_pct_chord: center_of_mass.ok_or("--center-of-mass is missing")?,
            pitch_deg: pitch.ok_or("--pitch is missing")?,
            horizontal_area,
            vertical_area,
            stand_in: stand_in.is_some(),
            run,
            fixtures: fixtures.unwrap_or_else(shipped_fixtures),
        }))
    }
}

fn number(name: &str, text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| number.is_finite());
    number.ok_or_else(|| format!("{name} {text}: it must be a number"))
}

fn counter(name: &str, text: &str) -> Result<u64, String> {
    text.parse().map_err(|_| format!("{name} {text}: it must be a whole number from 0"))
}

fn shipped_fixtures() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/bat")
}

/// Rig, test and weights of Chapter 7.
struct Channel {
    rig: Rig,
    profile: TestProfile,
    weights: CostWeights,
}

impl Channel {
    fn read(folder: &Path) -> Result<Self, FileError> {
        Ok(Self {
            rig: RigFile::read(folder.join("rig.toml"))?.rig,
            profile: ProfileFile::read(folder.join("test-profile.toml"))?.profile,
            weights: CostFile::read(folder.join("cost-chapter7.toml"))?.weights,
        })
    }

    /// Seconds.
    fn cost(&self, design: &Request) -> Result<f64, Box<dyn Error>> {
        let mut rig = self.rig.clone();
        rig.plant.body.center_of_mass_x = design.center_of_mass_pct_chord / 100.0;
        rig.set_points.pitch_rad = design.pitch_deg.to_radians();
        if let Some(factor) = design.horizontal_area {
            rig.plant.horizontal_stabilizer.area_factor = factor;
        }
        if let Some(factor) = design.vertical_area {
            rig.plant.vertical_stabilizer.area_factor = factor;
        }
        let ballast_pct_chord = rig.ballast_pct_chord();
        let cameras = rig.sensing.as_ref().map_or_else(Vec::new, |sensing| sensing.cameras.clone());
        let fidelity = if design.stand_in { Fidelity::STALLED_WITH_ADDED_MASS } else { Fidelity::NUMERICAL };
        // One step per sample: the numerics of the study of Chapter 7.
        let flight = fly(&FlightRequest { rig, fidelity }, &self.profile, &FlightSettings::with_steps(1))?;
        if let Some(held) = flight.held_share.filter(|held| *held > 0.0) {
            eprintln!(
                "warning: {:.1} % of the images gave no pose: the controller was given the last one again",
                100.0 * held
            );
        }
        for name in flight.blind_cameras.iter().filter_map(|place| Some(&cameras.get(*place)?.name)) {
            eprintln!("warning: camera `{name}` saw no dot in any image: see where it stands and how it is turned");
        }
        let cost = self.weights.cost(&flight.integrals, ballast_pct_chord).total;
        Ok(match design.run {
            Some(run) => BoundedNoise::new(NOISE, 1)?.measured(cost, run),
            None => cost,
        })
    }
}

/// The usage, and what the command says for row 0 of Table 5, the published optimum of the numerical model.
fn introduce() -> Result<(), Box<dyn Error>> {
    println!("{USAGE}");
    println!("Row 0 of Table 5:");
    let channel = Channel::read(&shipped_fixtures())?;
    for (arguments, meaning) in
        [("", "the numerical model"), (" --stand-in", "the stand-in for the channel, without noise")]
    {
        let line = format!("--center-of-mass 45.7 --pitch 8.29{arguments}");
        let words: Vec<String> = line.split(' ').map(str::to_owned).collect();
        if let Some(request) = Request::parse(&words)? {
            println!("  design_cost {line:46} {:.9}   {meaning}", channel.cost(&request)?);
        }
    }
    Ok(())
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if arguments.is_empty() {
        return match introduce() {
            Ok(()) => ExitCode::SUCCESS,
            Err(error) => failure(ExitCode::FAILURE, &error),
        };
    }
    let request = match Request::parse(&arguments) {
        Ok(Some(request)) => request,
        Ok(None) => {
            print!("{USAGE}");
            return ExitCode::SUCCESS;
        }
        Err(error) => return failure(ExitCode::from(USAGE_ERROR), &error),
    };
    // Whoever cannot read the files has not tried the design.
    let channel = match Channel::read(&request.fixtures) {
        Ok(channel) => channel,
        Err(error) => return failure(ExitCode::from(USAGE_ERROR), &format!("--fixtures: {error}")),
    };
    match channel.cost(&request) {
        // Nine decimals are more than a flight is accurate to, and the same on every machine.
        Ok(cost) => {
            println!("{cost:.9}");
            ExitCode::SUCCESS
        }
        Err(error) => failure(ExitCode::FAILURE, &error),
    }
}

fn failure(code: ExitCode, reason: &dyn std::fmt::Display) -> ExitCode {
    eprintln!("error: {reason}");
    code
}
