//! The file of the study: which loops, which unknowns.

use std::path::Path;

use anyhow::{Context as _, Result, ensure};
use design_space::{Parameter, Region};
use infuse::gradient::{self, Mechanism};
use infuse::identification::{Settings, Unknowns};
use serde::Deserialize;
use water_channel::N_TERMS;

use super::flights::Flights;
use super::which::Which;
use crate::calibration::{Candidate, Free, FreeEntry};
use crate::chapter4::Setup;
use crate::costs::key::Key;
use crate::decisive::decisive;
use crate::study_file;

const FILE: &str = "fixtures/bat/identification.toml";
/// Keys that do not decide what comes of a campaign; the study file that is named counts by its contents.
const BESIDE: [&str; 3] = ["seeds", "study", "held_out"];
/// And those of the study file.
const BESIDE_OF_STUDY: [&str; 2] = ["published", "files"];

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StudyFile {
    title: String,
    study: String,
    seeds: u64,
    #[serde(rename = "loop")]
    loops: Vec<LoopEntry>,
    fit: Settings,
    held_out: HeldOutEntry,
    unknown: Vec<FreeEntry>,
}

/// One loop.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LoopEntry {
    pub(super) label: String,
    pub(super) mechanism: Mechanism,
    pub(super) weights: Weights,
    /// Whether it is run over the noise seeds too.
    #[serde(default = "yes")]
    pub(super) with_noise: bool,
}

fn yes() -> bool {
    true
}

/// What the standard deviation of a reading is a share of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Weights {
    Cost,
    Reading,
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
struct HeldOutEntry {
    positions: [usize; 2],
}

/// The study ready to run.
#[derive(Debug)]
pub(super) struct Study {
    pub(super) title: String,
    pub(super) setup: Setup,
    /// Its file.
    study: String,
    n_seeds: u64,
    pub(super) loops: Vec<LoopEntry>,
    pub(super) fit: Settings,
    /// Along center of mass and pitch set point.
    pub(super) positions: [usize; 2],
    pub(super) free: Vec<Free>,
    pub(super) unknowns: Unknowns,
    /// Of the model with unknowns.
    pub(super) flights: Flights,
}

impl Study {
    pub(super) fn read(root: &Path) -> Result<Self> {
        study_file::read(&root.join(FILE), Self::of)
    }

    pub(super) fn of(file: StudyFile, directory: &Path) -> Result<Self> {
        let setup = Setup::read(&directory.join(&file.study))?;
        study_file::check_not_empty([("loop", file.loops.len()), ("unknown", file.unknown.len())])?;
        for (index, entry) in file.loops.iter().enumerate() {
            let is_new = file.loops[..index].iter().all(|other| other.label != entry.label);
            ensure!(is_new, "loop `{}` stands twice", entry.label);
        }
        ensure!(
            file.loops.iter().any(|entry| entry.mechanism == Mechanism::Identification),
            "no [[loop]] has the mechanism `identification`"
        );
        ensure!(
            file.held_out.positions.iter().all(|count| (2..=50).contains(count)),
            "held_out.positions = {:?}: each must be 2 to 50",
            file.held_out.positions
        );
        study_file::check_seeds("seeds", file.seeds)?;
        file.fit.validate().context("fit")?;
        let free: Vec<Free> = file.unknown.into_iter().map(FreeEntry::check).collect::<Result<_>>()?;
        for one in &free {
            ensure!(one.is_linear(), "`{}`: scale must be linear here", one.key);
            ensure!(
                one.start.is_none(),
                "`{}` has a start: there must be none, fits begin where the rig file has it",
                one.key
            );
            ensure!(!one.is_weight(), "`{}` is a weight: an unknown must be of the plant or its controller", one.key);
        }
        let parameters = free.iter().map(|one| Parameter::continuous(&one.key, &one.unit, one.lower, one.upper));
        let region = Region::new(parameters.collect::<Result<_, _>>()?)?;
        let (rig, weights) = setup.bat.rig_and_weights();
        let base = Candidate { rig: rig.clone(), weights: [*weights; 2] };
        let unknowns = Unknowns::new(region, free.iter().map(|one| one.value(&base)).collect())?;
        Ok(Self {
            title: file.title,
            setup,
            study: file.study,
            n_seeds: file.seeds,
            loops: file.loops,
            fit: file.fit,
            positions: file.held_out.positions,
            free,
            unknowns,
            flights: Flights::default(),
        })
    }

    /// Names all that decides what comes of a campaign.
    pub(super) fn key(&self, root: &Path) -> Result<String> {
        let path = root.join(FILE);
        let folder = path.parent().unwrap_or(Path::new("."));
        let of = |path: &Path, beside: &[&str]| Ok::<_, anyhow::Error>(decisive(path, beside)?.to_string());
        let key = Key::default().with(of(&path, &BESIDE)?);
        let mut key = key.with(of(&folder.join(&self.study), &BESIDE_OF_STUDY)?);
        let files = &self.setup.file.files;
        for name in [&files.rig, &files.profile, &files.cost] {
            key = key.with(of(&folder.join(name), &[])?);
        }
        Ok(key.name())
    }

    /// As the first variant of the study file, the one that the dissertation prints.
    pub(super) fn loop_settings(&self) -> gradient::Settings {
        self.setup.loop_settings(&self.setup.file.variant[0])
    }

    /// Every loop without noise, and with it where it is to be.
    pub(super) fn campaigns(&self) -> Vec<Which> {
        let seeds = self.setup.file.noise.numbers(self.n_seeds);
        let of_loop = |(index, entry): (usize, &LoopEntry)| {
            let noisy = seeds.iter().filter(|_| entry.with_noise).map(|seed| Some(*seed));
            std::iter::once(None).chain(noisy).map(move |seed| Which { index, seed }).collect::<Vec<_>>()
        };
        self.loops.iter().enumerate().flat_map(of_loop).collect()
    }

    /// The campaign that a check runs anew: identification alone, without noise.
    pub(super) fn quick(&self) -> Which {
        let is_it = |entry: &LoopEntry| entry.mechanism == Mechanism::Identification;
        Which { index: self.loops.iter().position(is_it).unwrap_or(0), seed: None }
    }

    /// Names of what is measured.
    pub(super) fn responses() -> Vec<String> {
        water_channel::TERM_NAMES[..N_TERMS].iter().map(|name| (*name).to_owned()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refuses(from: &str, to: &str, words: &[&str]) {
        study_file::assert_refused("identification.toml", Study::of, [from, to], words);
    }

    #[test]
    fn mistakes_are_named() {
        refuses("plant.hull.lift_slope", "plant.hull.lift_slop", &["no number `plant.hull.lift_slop`"]);
        refuses("unit = \"1/rad\"", "unit = \"rad\"", &["plant.hull.lift_slope", "`rad`", "`1/rad`"]);
        refuses("lower = 1.6", "lower = 2.9", &["plant.hull.lift_slope", "2.472415"]);
        refuses("key = \"plant.hull.lift_slope\"", "key = \"plant.hull.side_force_slope\"", &["side_force_slope"]);
        refuses("scale = \"linear\"", "scale = \"log\"", &["plant.hull.drag_zero_lift", "linear"]);
        refuses("lower = 1.6", "start = 2.0\nlower = 1.6", &["plant.hull.lift_slope", "rig file"]);
        refuses("tolerance = 1e-4", "tolerence = 1e-4", &["tolerence"]);
        refuses("tolerance = 1e-4", "tolerance = 0.0", &["tolerance", "0.0"]);
        refuses("seeds = 20", "seeds = 0", &["seeds", "0"]);
        refuses("positions = [5, 5]", "positions = [5, 1]", &["held_out.positions", "2 to 50"]);
        refuses("mechanism = \"both\"", "mechanism = \"all\"", &["both", "identification"]);
        refuses("label = \"both together\"", "label = \"identification alone\"", &["identification alone", "twice"]);
    }
}
