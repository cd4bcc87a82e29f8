//! The rig of the laboratory at full scale in air: files converted there and back, and one flight at both scales.

use std::path::Path;

use anyhow::{Context as _, Result, ensure};
use bat_dynamics::Fidelity;
use scaling::{Conversion, Converted, DocumentOptions, ScalingLaw, Units};
use water_channel::{CostFile, FlightLog, FlightRequest, FlightSettings, ProfileFile, RigFile, fly_logged};

use super::file::Setup;
use crate::bat::{MODEL, STAND_IN};
use crate::reproduction;

/// The files of the rig at full scale.
#[derive(Debug)]
pub(crate) struct FullScale {
    pub(crate) rig: Conversion,
    profile: Conversion,
    cost: Conversion,
    /// How many numbers came back with other bits after the way there and back.
    pub(crate) changed_on_return: usize,
    pub(crate) n_numbers: usize,
    /// The flights of the test at both scales, one for each physics.
    pub(crate) flights: Vec<BothScales>,
}

/// One flight in the laboratory and at full scale.
#[derive(Clone, Debug)]
pub(crate) struct BothScales {
    pub(crate) physics: &'static str,
    pub(crate) samples: usize,
    pub(crate) duration_s: [f64; 2],
    pub(crate) cost_s: [f64; 2],
    /// Of all columns of the log: the largest difference of any sample, in dimensionless form, as a share of the peak.
    pub(crate) largest_difference: f64,
    pub(crate) largest_difference_in: String,
    /// Of the cost.
    pub(crate) cost_difference: f64,
}

impl FullScale {
    pub(crate) fn of(setup: &Setup) -> Result<Self> {
        let law = setup.full_scale_law()?;
        let convert = |(name, text): &(String, String)| {
            let options = DocumentOptions { rewrite: Some(Box::new(derived)), ..DocumentOptions::default() };
            law.convert_document(&setup.units, text, &options).with_context(|| name.clone())
        };
        let (rig, profile, cost) =
            (convert(&setup.texts.rig)?, convert(&setup.texts.profile)?, convert(&setup.texts.cost)?);
        let (mut changed_on_return, mut n_numbers) = (0, 0);
        for converted in [&rig, &profile, &cost] {
            let back = law.inverse().convert_document(&setup.units, &converted.text, &DocumentOptions::default())?;
            ensure!(back.converted.len() == converted.converted.len(), "a number was lost on the way to full scale");
            n_numbers += converted.converted.len();
            let pairs = converted.converted.iter().zip(&back.converted);
            changed_on_return += pairs.filter(|(there, back)| there.old.to_bits() != back.new.to_bits()).count();
        }
        let mut full = Self { rig, profile, cost, changed_on_return, n_numbers, flights: Vec::new() };
        for (physics, fidelity) in [("numerical model", MODEL), ("stand-in", STAND_IN)] {
            full.flights.push(full.fly(setup, &law, physics, fidelity)?);
        }
        Ok(full)
    }

    fn fly(&self, setup: &Setup, law: &ScalingLaw, physics: &'static str, fidelity: Fidelity) -> Result<BothScales> {
        let settings = FlightSettings::with_steps(setup.file.release.steps_per_sample);
        let fly = |rig: &str, profile: &str, cost: &str| -> Result<(FlightLog, f64, f64)> {
            let (rig, profile) = (RigFile::parse(rig)?.rig, ProfileFile::parse(profile)?.profile);
            let weights = CostFile::parse(cost)?.weights;
            let body = rig.plant.body;
            let (flight, log) = fly_logged(&FlightRequest { rig, fidelity }, &profile, &settings, 1)?;
            let ballast = 100.0 * (body.center_of_mass_x - body.center_of_buoyancy_x);
            Ok((log, weights.cost(&flight?.integrals, ballast).total, profile.duration_s()))
        };
        let texts = &setup.texts;
        let (lab, lab_cost, lab_duration) = fly(&texts.rig.1, &texts.profile.1, &texts.cost.1)?;
        let (full, full_cost, full_duration) =
            fly(&self.rig.text, &self.profile.text, &self.cost.text).context("the flight at full scale")?;
        ensure!(
            lab.rows.len() == full.rows.len(),
            "the flights have {} and {} samples",
            lab.rows.len(),
            full.rows.len()
        );
        let (largest_difference, largest_difference_in) = largest_difference(&setup.units, law, &lab, &full)?;
        let time = law.rule("t")?.factor.to_f64();
        Ok(BothScales {
            physics,
            samples: lab.rows.len(),
            duration_s: [lab_duration, full_duration],
            cost_s: [lab_cost, full_cost],
            largest_difference,
            largest_difference_in,
            cost_difference: (full_cost / (lab_cost * time) - 1.0).abs(),
        })
    }

    /// Writes the converted files; each reads as a rig, a profile or weights like any other.
    pub(crate) fn save(&self, setup: &Setup, out: &Path) -> Result<()> {
        let files = [
            (&setup.texts.rig.0, &self.rig),
            (&setup.texts.profile.0, &self.profile),
            (&setup.texts.cost.0, &self.cost),
        ];
        for (name, converted) in files {
            let head = "# At full scale in air: converted by `cargo xtask reproduce-chapter2` from the file of the same name;\n\
                        # titles and comments are those of the laboratory.\n\n";
            reproduction::save(out, &format!("full-scale/{name}"), &format!("{head}{}", converted.text))?;
        }
        Ok(())
    }
}

/// A number that scaling has changed is derived, and says from what.
fn derived(number: &Converted) -> Vec<(String, String)> {
    if number.factor.is_one() {
        return Vec::new();
    }
    let other =
        |wanted: &str| number.others.iter().find(|(key, _)| key == wanted).map_or("", |(_, text)| text.as_str());
    let (provenance, source) = (other("provenance"), other("source"));
    vec![
        ("provenance".to_owned(), "derived".to_owned()),
        ("source".to_owned(), format!("laboratory value times {}; there {provenance}: {source}", number.factor)),
    ]
}

/// The largest difference between two logs, each column in its own unit brought from one scale to the other.
fn largest_difference(units: &Units, law: &ScalingLaw, lab: &FlightLog, full: &FlightLog) -> Result<(f64, String)> {
    let mut largest = (0.0, String::new());
    let (lab, full) = (columns(lab), columns(full));
    for ((heading, unit), (lab, full)) in FlightLog::columns().iter().zip(lab.iter().zip(&full)) {
        let factor = law.factor(&units.parse(unit)?.dimension)?.to_f64();
        let peak = full.iter().fold(0.0_f64, |peak, value| peak.max(value.abs()));
        let difference = lab.iter().zip(full).fold(0.0_f64, |most, (lab, full)| most.max((lab * factor - full).abs()));
        let share = if peak > 0.0 { difference / peak } else { difference };
        if share > largest.0 {
            largest = (share, heading.clone());
        }
    }
    Ok(largest)
}

/// The log column by column.
fn columns(log: &FlightLog) -> Vec<Vec<f64>> {
    let mut columns = vec![Vec::with_capacity(log.rows.len()); FlightLog::columns().len()];
    for row in &log.rows {
        for (column, number) in columns.iter_mut().zip(row.numbers()) {
            column.push(number);
        }
    }
    columns
}
