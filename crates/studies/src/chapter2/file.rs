//! The study file of Chapter 2, checked.

use std::path::Path;

use anyhow::{Context as _, Result, ensure};
use scaling::{BigRational, Groups, SetUp, System, Units};
use serde::Deserialize;
use water_channel::RigFile;

use crate::study_file::{self, FilesEntry, NamedText, check_positive};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct StudyFile {
    pub(crate) title: String,
    files: FilesEntry,
    plant: SystemEntry,
    normalized_time: SystemEntry,
    controller: SystemEntry,
    also: Also,
    pub(crate) stated: Vec<Stated>,
    pub(crate) model: Vec<Model>,
    similarity: SimilarityEntry,
    pub(crate) release: Release,
    full_scale: Ratios,
    viscosity: Viscosity,
    pub(crate) printed_full_scale: Vec<PrintedFullScale>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct SystemEntry {
    variables: Vec<(String, String)>,
    repeating: Vec<String>,
    listed: Vec<String>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Also {
    variables: Vec<(String, String)>,
}

/// A law that the dissertation states: a power of length.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Stated {
    pub(crate) variable: String,
    power: String,
    pub(crate) place: String,
}

/// A column of Table 2, as printed.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Model {
    pub(crate) name: String,
    pub(crate) scale_factor: String,
    pub(crate) time_scale: String,
    pub(crate) chord_cm: String,
    pub(crate) tether_cm: String,
    pub(crate) mass_g: String,
    pub(crate) speed_cm_s: String,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct SimilarityEntry {
    tolerance: f64,
    reference: String,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Release {
    pub(crate) twist_deg: f64,
    pub(crate) duration_s: f64,
    pub(crate) steps_per_sample: usize,
}

/// Kinematic viscosity of water and air.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Viscosity {
    unit: String,
    laboratory: String,
    full_scale: String,
}

/// A number of the machine itself, as printed.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PrintedFullScale {
    pub(crate) key: String,
    pub(crate) value: f64,
    pub(crate) unit: String,
    pub(crate) place: String,
}

/// Full scale over laboratory.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Ratios {
    length: String,
    density: String,
    gravity: String,
}

impl Stated {
    pub(crate) fn power(&self) -> Result<BigRational> {
        self.power
            .parse()
            .with_context(|| format!("stated `{}`: power = `{}`: it must be a fraction", self.variable, self.power))
    }
}

impl Model {
    /// A printed number.
    pub(crate) fn number(&self, key: &str, text: &str) -> Result<f64> {
        let value: f64 = text.parse().with_context(|| format!("model `{}`: {key} = `{text}`", self.name))?;
        check_positive(&format!("model `{}`: {key}", self.name), value)?;
        Ok(value)
    }

    /// What Table 2 says of the model, with water and gravity, under the names of Table 1.
    fn set_up(&self, units: &Units, water: [f64; 2]) -> Result<SetUp> {
        let set_up = SetUp::new(&self.name)
            .printed(units, "L_t", &self.tether_cm, "cm")?
            .printed(units, "L_c", &self.chord_cm, "cm")?
            .printed(units, "M_a", &self.mass_g, "g")?
            .printed(units, "V", &self.speed_cm_s, "cm/s")?;
        Ok(set_up.with("rho", water[0]).with("g", water[1]))
    }
}

/// A system of variables with its groups and those that the dissertation lists.
#[derive(Clone, Debug)]
pub(crate) struct Analysis {
    pub(crate) system: System,
    pub(crate) groups: Groups,
    pub(crate) listed: Vec<scaling::Group>,
}

impl SystemEntry {
    fn analysis(&self, units: &Units, name: &str) -> Result<Analysis> {
        let variables: Vec<(&str, &str)> =
            self.variables.iter().map(|(name, unit)| (name.as_str(), unit.as_str())).collect();
        let repeating: Vec<&str> = self.repeating.iter().map(String::as_str).collect();
        let system = System::parse(units, &variables).with_context(|| format!("{name}.variables"))?;
        let groups = system.groups(&repeating).with_context(|| format!("{name}.repeating"))?;
        let listed = self.listed.iter().map(|text| system.group(text)).collect::<Result<Vec<_>, _>>();
        Ok(Analysis { groups, listed: listed.with_context(|| format!("{name}.listed"))?, system })
    }
}

/// The study ready to run.
#[derive(Debug)]
pub(crate) struct Setup {
    pub(crate) file: StudyFile,
    pub(crate) units: Units,
    pub(crate) plant: Analysis,
    /// The plant again, with time stretched.
    pub(crate) normalized_time: Analysis,
    pub(crate) controller: Analysis,
    /// All variables of both.
    pub(crate) both: System,
    /// The models of Table 2.
    pub(crate) set_ups: Vec<SetUp>,
    pub(crate) tolerance: f64,
    /// Position of the reference model.
    pub(crate) reference: usize,
    /// The system of chord, speed and viscosity, whose only group is the Reynolds number.
    reynolds: Groups,
    /// The rig file, read.
    pub(crate) rig: RigFile,
    /// Rig, profile and cost.
    pub(crate) texts: [NamedText; 3],
}

/// Units that our parameter files use beyond the SI.
fn units_of_the_files() -> Result<Units> {
    let mut units = Units::si();
    units.define("% chord", "0.01")?;
    units.define("chord", "1")?;
    units.define("u_max", "1")?;
    Ok(units)
}

/// The rig that flies must be the model that the others are compared with.
fn check_reference(model: &Model, rig: &water_channel::Rig) -> Result<()> {
    let body = rig.plant.body;
    for (key, text, unit, flown) in
        [("chord_cm", &model.chord_cm, 0.01, body.chord_m), ("mass_g", &model.mass_g, 0.001, body.mass_kg)]
    {
        let printed = unit * model.number(key, text)?;
        ensure!(
            (printed / flown - 1.0).abs() < 1e-9,
            "model `{}`: {key} = `{text}`, but the rig file, which is this model, has {} in that unit",
            model.name,
            flown / unit
        );
    }
    Ok(())
}

impl Setup {
    pub(crate) fn read(path: &Path) -> Result<Self> {
        study_file::read(path, Self::of)
    }

    fn of(file: StudyFile, directory: &Path) -> Result<Self> {
        let units = units_of_the_files()?;
        let plant = file.plant.analysis(&units, "plant")?;
        let normalized_time = file.normalized_time.analysis(&units, "normalized_time")?;
        let controller = file.controller.analysis(&units, "controller")?;
        let mut variables = plant.system.variables().to_vec();
        variables.extend(
            controller.system.variables().iter().filter(|new| plant.system.variable(&new.name).is_err()).cloned(),
        );
        let also: Vec<(&str, &str)> =
            file.also.variables.iter().map(|(name, unit)| (name.as_str(), unit.as_str())).collect();
        variables.extend(System::parse(&units, &also).context("also.variables")?.variables().iter().cloned());
        let both = System::new(variables)?;
        for stated in &file.stated {
            both.variable(&stated.variable).context("stated.variable")?;
            stated.power()?;
        }
        let texts = file.files.read(directory)?;
        let rig = RigFile::parse(&texts[0].text).with_context(|| texts[0].name.clone())?;
        let fluid = rig.rig.plant.fluid;
        let water = [fluid.density_kg_m3, fluid.gravity_m_s2];
        ensure!(file.model.len() >= 2, "model: {} entries, at least two are needed", file.model.len());
        let set_up = |model: &Model| model.set_up(&units, water).with_context(|| format!("model `{}`", model.name));
        let set_ups = file.model.iter().map(set_up).collect::<Result<Vec<_>>>()?;
        for model in &file.model {
            model.number("scale_factor", &model.scale_factor)?;
            model.number("time_scale", &model.time_scale)?;
            model.number("chord_cm", &model.chord_cm)?;
            model.number("tether_cm", &model.tether_cm)?;
            model.number("mass_g", &model.mass_g)?;
            model.number("speed_cm_s", &model.speed_cm_s)?;
        }
        let wanted = &file.similarity.reference;
        let reference = file.model.iter().position(|model| model.name == *wanted);
        let reference =
            reference.with_context(|| format!("similarity.reference = `{wanted}`: no model has this name"))?;
        check_reference(&file.model[reference], &rig.rig)?;
        let Release { twist_deg, duration_s, .. } = file.release;
        ensure!(
            twist_deg.is_finite() && twist_deg.abs() < 180.0,
            "release.twist_deg = {twist_deg}: it must be within 180 to either side"
        );
        ensure!((1.0..=3600.0).contains(&duration_s), "release.duration_s = {duration_s}: it must be from 1 to 3600");
        water_channel::FlightSettings::with_steps(file.release.steps_per_sample)
            .validate()
            .context("release.steps_per_sample")?;
        let tolerance = file.similarity.tolerance;
        scaling::Similarity::check(&plant.groups, &set_ups, tolerance).context("similarity and model")?;
        let reynolds = System::parse(&units, &[("L_c", "m"), ("V", "m/s"), ("nu", &file.viscosity.unit)])
            .and_then(|system| system.groups(&["L_c", "nu"]))
            .context("viscosity")?;
        let setup = Self {
            file,
            units,
            plant,
            normalized_time,
            controller,
            both,
            set_ups,
            tolerance,
            reference,
            reynolds,
            rig,
            texts,
        };
        setup.full_scale_law()?;
        setup.reynolds()?;
        Ok(setup)
    }

    /// The Reynolds number of the chord: of each model as printed, then of the reference model at full scale.
    pub(crate) fn reynolds(&self) -> Result<Vec<(String, f64)>> {
        let number = |name: &str, length: f64, speed: f64, viscosity: &str| -> Result<f64> {
            let set_up = SetUp::new(name).with("L_c", length).with("V", speed);
            let set_up =
                set_up.printed(&self.units, "nu", viscosity, &self.file.viscosity.unit).context("viscosity")?;
            let group = self.reynolds.iter().next().context("viscosity: no Reynolds number")?;
            Ok(group.value(&set_up)?)
        };
        let mut numbers = Vec::new();
        let printed = |model: &Model| -> Result<[f64; 2]> {
            Ok([
                0.01 * model.number("chord_cm", &model.chord_cm)?,
                0.01 * model.number("speed_cm_s", &model.speed_cm_s)?,
            ])
        };
        for model in &self.file.model {
            let [length, speed] = printed(model)?;
            numbers.push((model.name.clone(), number(&model.name, length, speed, &self.file.viscosity.laboratory)?));
        }
        let law = self.full_scale_law()?;
        let [length, speed] = printed(&self.file.model[self.reference])?;
        let (length, speed) = (law.rule("L_c")?.factor.apply(length), law.rule("V")?.factor.apply(speed));
        let name = "full scale, in air";
        numbers.push((name.to_owned(), number(name, length, speed, &self.file.viscosity.full_scale)?));
        Ok(numbers)
    }

    /// Laboratory to full scale.
    pub(crate) fn full_scale_law(&self) -> Result<scaling::ScalingLaw> {
        let Ratios { length, density, gravity } = &self.file.full_scale;
        self.both.law(&[("L_t", length), ("rho", density), ("g", gravity)]).context("full_scale")
    }

    /// The reference model to another, by its scale factor and in the same fluid.
    pub(crate) fn law_to(&self, model: &Model) -> Result<scaling::ScalingLaw> {
        let ratio = format!("{}/{}", model.scale_factor, self.file.model[self.reference].scale_factor);
        self.both.law(&[("L_t", &ratio), ("rho", "1"), ("g", "1")]).with_context(|| format!("model `{}`", model.name))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study_file::assert_refused;

    #[track_caller]
    fn refuses(from: &str, to: &str, words: &[&str]) {
        assert_refused("chapter2.toml", Setup::of, [from, to], words);
    }

    #[test]
    fn bad_study_files_name_the_field_and_what_is_allowed() {
        refuses("[\"V\", \"m/s\"]", "[\"V\", \"m/sec\"]", &["plant.variables", "sec"]);
        refuses(
            "repeating = [\"L_t\", \"M_a\", \"V\"]",
            "repeating = [\"L_t\", \"V\", \"g\"]",
            &["plant.repeating", "V", "g"],
        );
        refuses("\"L_t^3*rho/M_a\"", "\"L_t^2*rho/M_a\"", &["plant.listed", "L_t^2*rho/M_a"]);
        refuses("mass_g = \"180\"", "mass_g = \"150\"", &["Model 2", "mass_g", "150", "180"]);
        refuses("tolerance = 0.01", "tolerance = -0.01", &["similarity", "-0.01", "at least 0"]);
        refuses("name = \"Model 3\"", "name = \"Model 1\"", &["Model 1", "twice"]);
        refuses("laboratory = \"1.0e-6\"", "laboratory = \"zero\"", &["viscosity", "zero"]);
        refuses("mass_g = \"135\"", "mass_g = \"heavy\"", &["Model 1", "heavy"]);
        refuses("reference = \"Model 2\"", "reference = \"Model 4\"", &["similarity.reference", "Model 4"]);
        refuses("twist_deg = 10.0", "twist_deg = 200.0", &["release.twist_deg", "200", "180"]);
        refuses("density = \"1.225/1000\"", "density = \"-1\"", &["full_scale", "rho"]);
        refuses("power = \"1/2\"", "power = \"half\"", &["stated", "V", "half"]);
        refuses("rig = \"rig.toml\"", "rig = \"none.toml\"", &["none.toml"]);
        refuses("steps_per_sample = 2", "steps_per_sample = 0", &["release.steps_per_sample"]);
    }
}
