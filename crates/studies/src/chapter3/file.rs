//! The study file of Chapter 3, checked.

use std::path::Path;

use anyhow::{Context as _, Result, ensure};
use bat_dynamics::{Fidelity, TetherLayout};
use serde::Deserialize;
use water_channel::{FlightRequest, FlightSettings, ProfileFile, Record, Rig, RigFile, TestProfile};

use crate::study_file::{self, check_positive};
use crate::variable::Variable;

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct StudyFile {
    title: String,
    rig: String,
    profile: String,
    steps_per_sample: usize,
    cost: Weights,
    center_of_mass: Range,
    trim_pitch: Range,
    panel: Vec<Configuration>,
}

/// K1 and K2 of (20), per rad² and per m².
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Weights {
    pub(crate) heading: f64,
    pub(crate) lateral: f64,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Range {
    unit: String,
    lower: f64,
    upper: f64,
    step: f64,
    /// The bounds of Table 4, where it has them.
    pub(crate) table4: Option<[f64; 2]>,
}

/// A panel of Figure 14.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Configuration {
    pub(crate) label: String,
    incidence_deg: f64,
    layout: TetherLayout,
}

impl Range {
    fn check(&self, name: &str, unit: &str) -> Result<()> {
        ensure!(self.unit == unit, "{name}.unit = `{}`: it must be `{unit}`", self.unit);
        let number = |key: &str, value: f64| {
            ensure!(value.is_finite(), "{name}.{key} = {value}: it must be finite");
            Ok(())
        };
        number("lower", self.lower)?;
        number("upper", self.upper)?;
        ensure!(self.lower < self.upper, "{name}.upper = {}: it must be above lower = {}", self.upper, self.lower);
        check_positive(&format!("{name}.step"), self.step)?;
        let count = (self.upper - self.lower) / self.step;
        ensure!(
            count <= MOST_PLACES && (count - count.round()).abs() < 1e-6,
            "{name}.step = {}: it must divide the range into a whole number of at most {MOST_PLACES} parts",
            self.step
        );
        if let Some([low, high]) = self.table4 {
            ensure!(
                low.is_finite() && low < high,
                "{name}.table4 = [{low}, {high}]: the first must be below the second"
            );
        }
        Ok(())
    }

    /// The places along the axis.
    pub(crate) fn places(&self) -> Vec<f64> {
        let count = ((self.upper - self.lower) / self.step).round();
        (0..=count as usize).map(|k| self.lower + (self.upper - self.lower) * k as f64 / count).collect()
    }
}

#[cfg(test)]
impl Range {
    /// As few places as a test needs.
    pub(crate) fn coarsen(&mut self, places: usize) {
        self.step = (self.upper - self.lower) / (places - 1) as f64;
    }
}

/// More would take hours.
const MOST_PLACES: f64 = 400.0;

/// The study ready to run.
#[derive(Debug)]
pub(crate) struct Setup {
    pub(crate) title: String,
    /// Of rig and test.
    #[cfg_attr(not(feature = "global"), expect(dead_code, reason = "only what is kept needs a name"))]
    pub(super) files: [String; 2],
    rig: Rig,
    pub(crate) profile: TestProfile,
    pub(crate) records: Vec<Record>,
    pub(crate) settings: FlightSettings,
    pub(crate) weights: Weights,
    pub(crate) center_of_mass: Range,
    pub(crate) trim_pitch: Range,
    pub(crate) configurations: Vec<Configuration>,
}

impl Setup {
    pub(crate) fn read(path: &Path) -> Result<Self> {
        study_file::read(path, Self::of)
    }

    fn of(file: StudyFile, directory: &Path) -> Result<Self> {
        for (key, pitch) in [("lower", file.trim_pitch.lower), ("upper", file.trim_pitch.upper)] {
            ensure!(pitch.abs() < 90.0, "trim_pitch.{key} = {pitch}: it must be within 90 to either side");
        }
        file.center_of_mass.check("center_of_mass", Variable::CenterOfMass.unit())?;
        file.trim_pitch.check("trim_pitch", Variable::PitchSetPoint.unit())?;
        for (key, weight) in [("heading", file.cost.heading), ("lateral", file.cost.lateral)] {
            ensure!(weight.is_finite() && weight >= 0.0, "cost.{key} = {weight}: it must be finite and zero or more");
        }
        study_file::check_not_empty([("panel", file.panel.len())])?;
        for panel in &file.panel {
            ensure!(!panel.label.trim().is_empty(), "panel.label is empty");
            ensure!(
                panel.incidence_deg.abs() < 90.0,
                "panel `{}`: incidence_deg = {}: it must be within 90 to either side",
                panel.label,
                panel.incidence_deg
            );
        }
        let settings = FlightSettings::with_steps(file.steps_per_sample);
        settings.validate().context("steps_per_sample")?;
        let rig = RigFile::read(directory.join(&file.rig))?;
        let profile = ProfileFile::read(directory.join(&file.profile))?;
        Ok(Self {
            title: file.title,
            files: [file.rig, file.profile],
            rig: rig.rig,
            profile: profile.profile,
            records: [rig.records, profile.records].concat(),
            settings,
            weights: file.cost,
            center_of_mass: file.center_of_mass,
            trim_pitch: file.trim_pitch,
            configurations: file.panel,
        })
    }

    /// The same study on another plant.
    #[cfg(feature = "ensemble")]
    pub(crate) fn on(&self, rig: Rig) -> Self {
        Self {
            title: self.title.clone(),
            files: self.files.clone(),
            rig,
            profile: self.profile.clone(),
            records: Vec::new(),
            configurations: self.configurations.clone(),
            center_of_mass: self.center_of_mass.clone(),
            trim_pitch: self.trim_pitch.clone(),
            ..*self
        }
    }

    /// A design to be flown: center of mass in per cent of chord, trim pitch in degrees.
    pub(crate) fn request(&self, configuration: &Configuration, design: [f64; 2], fidelity: Fidelity) -> FlightRequest {
        let mut rig = self.rig.clone();
        Variable::CenterOfMass.set(&mut rig, design[0]);
        Variable::PitchSetPoint.set(&mut rig, design[1]);
        rig.plant.horizontal_stabilizer.incidence_rad = configuration.incidence_deg.to_radians();
        rig.plant.layout = configuration.layout;
        FlightRequest { rig, fidelity }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study_file::assert_refused;

    #[track_caller]
    fn refuses(from: &str, to: &str, words: &[&str]) {
        assert_refused("chapter3.toml", Setup::of, [from, to], words);
    }

    #[test]
    fn bad_study_files_name_the_field_and_what_is_allowed() {
        refuses("lateral = 0.0125", "laterl = 0.0125", &["laterl", "unknown field"]);
        refuses("lateral = 0.0125", "lateral = nan", &["cost.lateral", "NaN", "zero or more"]);
        refuses("upper = 54.05", "upper = 39.0", &["center_of_mass.upper", "39", "40.05"]);
        refuses("upper = 22.0", "upper = 400.0", &["trim_pitch.upper", "400", "90"]);
        refuses("table4 = [45.65, 51.25]", "table4 = [51.25, 45.65]", &["center_of_mass.table4", "51.25"]);
        refuses("step = 1.0", "step = 0.3", &["trim_pitch.step", "0.3", "whole number"]);
        refuses("unit = \"deg\"", "unit = \"rad\"", &["trim_pitch.unit", "`rad`", "`deg`"]);
        refuses("incidence_deg = -5.0", "incidence_deg = 500.0", &["fin −5 deg", "500", "90"]);
        refuses("layout = \"two-forward-one-aft\"", "layout = \"two\"", &["two", "two-forward-one-aft"]);
        refuses("profile = \"test-profile-open-loop.toml\"", "profile = \"none.toml\"", &["none.toml"]);
        refuses("steps_per_sample = 1", "steps_per_sample = 0", &["steps_per_sample", "1000"]);
    }
}
