//! What a suspension costs, simulated or on a test stand, as a command that any tool can call.
#![expect(clippy::print_stdout, reason = "an example talks")]

use std::fmt::Display;
use std::process::ExitCode;

use quarter_car::{Car, Design, Drive, Error, Ride, Vehicle, measured, road};

const USAGE: &str = "\
quarter_car simulate   --spring N/m --damper N*s/m --skyhook N*s/m --tire-gain N/m
quarter_car experiment --spring N/m --damper N*s/m --skyhook N*s/m --tire-gain N/m [--run NUMBER]

Drives a quarter of a car over a rough road and prints what its suspension costs in m/s^2; less is better. The cost is
the root mean square of body acceleration, tire load, travel and force of the actuator, each with its weight.

  --spring     of the strut, N/m: 8000 to 30000
  --damper     of the strut, N*s/m: 300 to 2500
  --skyhook    gain on the velocity of the body, N*s/m: 0 to 4000
  --tire-gain  gain on the deflection of the tire, N/m: 0 to 60000
  --run        number of the experiment from 0, which decides its noise, at most 1 % of the cost; without it there is no
               noise

`simulate` knows a linear tire, no friction and an actuator that follows at once. `experiment` is the test stand: its
tire stiffens and leaves the ground, its strut sticks, its actuator is late.

A drive that fails ends with exit code 1 and the reason, a wrong argument with exit code 2.
";

/// Wrong arguments.
const USAGE_ERROR: u8 = 2;

/// Shown to whoever gives no arguments: the middle of the ranges, and the best of either kind.
const SHOWN: [(&str, Design); 3] = [
    ("in the middle", Design { spring_n_m: 19e3, damper_n_s_m: 1400.0, skyhook_n_s_m: 2000.0, tire_gain_n_m: 30e3 }),
    ("best simulated", Design::BEST_SIMULATED),
    ("best on the stand", Design::BEST_ON_THE_STAND),
];

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let outcome = match words.as_slice() {
        [] => introduce(),
        ["help" | "--help" | "-h"] => {
            print!("{USAGE}");
            Ok(())
        }
        ["simulate", rest @ ..] => simulate(rest),
        ["experiment", rest @ ..] => experiment(rest),
        [other, ..] => Err(Stop::usage(format!("no command `{other}`: it must be simulate, experiment or help"))),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(Stop { code, reason }) => {
            eprintln!("error: {reason}");
            code
        }
    }
}

/// Why the program ends early.
struct Stop {
    code: ExitCode,
    reason: String,
}

impl Stop {
    fn usage(reason: impl Display) -> Self {
        Self { code: ExitCode::from(USAGE_ERROR), reason: reason.to_string() }
    }

    fn broken(error: Error) -> Self {
        Self { code: ExitCode::FAILURE, reason: error.to_string() }
    }
}

fn simulate(words: &[&str]) -> Result<(), Stop> {
    let Request { design, run } = Request::parse(words)?;
    if run.is_some() {
        return Err(Stop::usage("--run: a simulation has no noise; it goes with `experiment`"));
    }
    say(ride(Car::SIMULATED, design)?.cost_m_s2());
    Ok(())
}

fn experiment(words: &[&str]) -> Result<(), Stop> {
    let Request { design, run } = Request::parse(words)?;
    let cost = ride(Car::ON_THE_STAND, design)?.cost_m_s2();
    say(run.map_or(cost, |run| measured(cost, run)));
    Ok(())
}

/// Nine decimals are more than a drive is accurate to, and the same on every machine.
fn say(cost: f64) {
    println!("{cost:.9}");
}

fn ride(car: Car, design: Design) -> Result<Ride, Stop> {
    Vehicle { car, design }.drive(&road(), &Drive::STANDARD, |_| {}).map_err(Stop::broken)
}

/// The usage, and what there is to gain.
fn introduce() -> Result<(), Stop> {
    println!("{USAGE}");
    println!(
        "{:18} {:>7} {:>7} {:>8} {:>9} {:>9} {:>13}",
        "", "spring", "damper", "skyhook", "tire-gain", "simulated", "on the stand"
    );
    for (name, design) in SHOWN {
        let Design { spring_n_m, damper_n_s_m, skyhook_n_s_m, tire_gain_n_m } = design;
        let [simulated, true_cost] = [ride(Car::SIMULATED, design)?, ride(Car::ON_THE_STAND, design)?];
        println!(
            "{name:18} {spring_n_m:7} {damper_n_s_m:7} {skyhook_n_s_m:8} {tire_gain_n_m:9} {:9.4} {:13.4}",
            simulated.cost_m_s2(),
            true_cost.cost_m_s2()
        );
    }
    Ok(())
}

/// What the words after the command ask for.
struct Request {
    design: Design,
    run: Option<u64>,
}

impl Request {
    fn parse(words: &[&str]) -> Result<Self, Stop> {
        let (mut spring, mut damper, mut skyhook, mut tire_gain, mut run) = (None, None, None, None, None);
        let mut words = words.iter();
        while let Some(name) = words.next() {
            let mut value = || words.next().ok_or_else(|| Stop::usage(format!("{name}: a value must follow")));
            let is_new = match *name {
                "--spring" => spring.replace(number(name, value()?)?).is_none(),
                "--damper" => damper.replace(number(name, value()?)?).is_none(),
                "--skyhook" => skyhook.replace(number(name, value()?)?).is_none(),
                "--tire-gain" => tire_gain.replace(number(name, value()?)?).is_none(),
                "--run" => run.replace(counter(name, value()?)?).is_none(),
                other => return Err(Stop::usage(format!("no argument `{other}`: see quarter_car help"))),
            };
            if !is_new {
                return Err(Stop::usage(format!("{name} is given twice")));
            }
        }
        let given = |value: Option<f64>, name| value.ok_or_else(|| Stop::usage(format!("{name} is missing")));
        let design = Design {
            spring_n_m: given(spring, "--spring")?,
            damper_n_s_m: given(damper, "--damper")?,
            skyhook_n_s_m: given(skyhook, "--skyhook")?,
            tire_gain_n_m: given(tire_gain, "--tire-gain")?,
        };
        Ok(Self { design, run })
    }
}

/// Springs that push the wrong way and negative gains are no designs.
fn number(name: &str, text: &str) -> Result<f64, Stop> {
    let number = text.parse().ok().filter(|number: &f64| number.is_finite() && *number >= 0.0);
    number.ok_or_else(|| Stop::usage(format!("{name} {text}: it must be a number, zero or more")))
}

fn counter(name: &str, text: &str) -> Result<u64, Stop> {
    text.parse().map_err(|_| Stop::usage(format!("{name} {text}: it must be a whole number from 0")))
}
