//! Converts a parameter file by ratios: `convert_parameter_file FILE L[m]=100 rho[kg/m^3]=1.225/1000 g[m/s^2]=1`.
//!
//! A ratio is a quantity with its unit in brackets and how many times larger it gets.
//! The brackets may be left out for `L`, `M`, `T`, `rho`, `g` and `V`.
//! Further labels that a file uses as units are given as `--label "% chord"`.
//! The document goes to the standard output, the report to the standard error.

use std::error::Error;
use std::process::ExitCode;

use scaling::{Converted, DocumentOptions, System, Units};

/// Quantities that need no unit on the command line.
const USUAL: [(&str, &str); 6] = [("L", "m"), ("M", "kg"), ("T", "s"), ("rho", "kg/m^3"), ("g", "m/s^2"), ("V", "m/s")];

/// Without arguments the example converts this.
const SAMPLE: &str = r#"# A small rig.
chord = { value = 7.5, unit = "cm", provenance = "given", source = "ruler" }
mass = { value = 0.18, unit = "kg", provenance = "given", source = "scales" }  # ballasted
time_constant = { value = 0.1, unit = "s", provenance = "given", source = "step response" }
incidence = { value = 5.0, unit = "deg", provenance = "given", source = "protractor" }
"#;

#[expect(clippy::print_stderr, reason = "an example shows what it computes")]
fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

#[expect(clippy::print_stdout, clippy::print_stderr, reason = "an example shows what it computes")]
fn run() -> Result<(), Box<dyn Error>> {
    let mut units = Units::si();
    units.define("% chord", "0.01")?.define("u_max", "1")?;

    let mut arguments = std::env::args().skip(1);
    let text = match arguments.next() {
        Some(path) => std::fs::read_to_string(&path).map_err(|error| format!("{path}: {error}"))?,
        None => SAMPLE.to_owned(),
    };
    let mut ratios = Vec::new();
    while let Some(argument) = arguments.next() {
        if argument == "--label" {
            units.define(&arguments.next().ok_or("`--label` needs a label")?, "1")?;
        } else {
            ratios.push(ratio(&argument)?);
        }
    }
    if ratios.is_empty() {
        ratios = ["L=100", "rho=1.225/1000", "g=1"].map(ratio).into_iter().collect::<Result<_, _>>()?;
    }

    let variables: Vec<_> = ratios.iter().map(|(name, unit, _)| (name.as_str(), unit.as_str())).collect();
    let given: Vec<_> = ratios.iter().map(|(name, _, ratio)| (name.as_str(), ratio.as_str())).collect();
    let law = System::parse(&units, &variables)?.law(&given)?;
    let by: Vec<_> = law.given().map(|(name, factor)| format!("{name} {factor}")).collect();

    let rewrite = |converted: &Converted| {
        let source = converted.others.iter().find(|(key, _)| key == "source");
        match source {
            Some((_, source)) if !converted.factor.is_one() => vec![
                ("provenance".to_owned(), "derived".to_owned()),
                ("source".to_owned(), format!("scaled by {} from {} ({source})", by.join(", "), converted.old)),
            ],
            _ => vec![],
        }
    };
    let options = DocumentOptions { rewrite: Some(Box::new(rewrite)), ..DocumentOptions::default() };
    let conversion = law.convert_document(&units, &text, &options)?;

    print!("{}", conversion.text);
    for Converted { path, unit, dimension, factor, old, new, .. } in &conversion.converted {
        eprintln!("{path}: {old} {unit} [{dimension}] times {factor} is {new}");
    }
    for path in &conversion.without_value {
        eprintln!("{path}: a unit without a value, left as it is");
    }
    Ok(())
}

/// Name, unit and ratio of `rho[kg/m^3]=1.225/1000`.
fn ratio(argument: &str) -> Result<(String, String, String), String> {
    let (quantity, ratio) = argument.split_once('=').ok_or_else(|| format!("`{argument}` is not `quantity=ratio`"))?;
    let (name, unit) = match quantity.strip_suffix(']').and_then(|quantity| quantity.split_once('[')) {
        Some(name_and_unit) => name_and_unit,
        None => {
            let usual = USUAL.iter().find(|(name, _)| *name == quantity);
            *usual.ok_or_else(|| format!("`{quantity}` needs its unit, as in `{quantity}[m]={ratio}`"))?
        }
    };
    Ok((name.to_owned(), unit.to_owned(), ratio.to_owned()))
}
