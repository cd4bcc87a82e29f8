//! The file of a calibration: what is free, over which ranges, and what it is fitted to.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, ensure};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Deserialize;
use water_channel::{CostFile, CostWeights, FlightSettings, ProfileFile, RigFile, TestProfile};

use super::candidate::{Candidate, Flown, Spot, fly};
use super::evidence::{self, Bounds, BoxEntry, Evidence, EvidenceEntry, HeldOutEntry, Tolerance};
use super::free::{Free, FreeEntry};
use super::outcome::Member;
use super::store::{BEYOND, ENSEMBLE, Range, Shape};
use crate::costs::key::Key;
use crate::decisive::decisive;
use crate::seal::drop_entries;
use crate::study_file;

const FILE: &str = "fixtures/bat/calibration.toml";
/// Keys that do not decide what comes of a start; what `files` names counts by its contents.
const BESIDE: [&str; 5] = ["members", "most_starts", "held_out", "files", "beyond"];
/// What stands before the keys of free numbers in the files of the default plant.
const BEFORE: [&str; 3] = ["", "chapter4.", "chapter7."];
/// Starts stay this far inside of their ranges.
const INSIDE: f64 = 0.05;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CalibrationFile {
    title: String,
    members: usize,
    most_starts: u64,
    seed: u64,
    reach: [f64; 2],
    steps_per_sample: usize,
    beyond: BeyondEntry,
    files: FilesEntry,
    #[serde(rename = "box")]
    boxes: Vec<BoxEntry>,
    evidence: Vec<EvidenceEntry>,
    #[serde(default)]
    held_out: Vec<HeldOutEntry>,
    tolerance: Tolerance,
    free: Vec<FreeEntry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct BeyondEntry {
    reach: [f64; 2],
    starts: u64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FilesEntry {
    rig: String,
    profile: String,
    chapter4: String,
    chapter7: String,
}

impl CalibrationFile {
    /// How many plants, starts and how far.
    fn check_extent(&self) -> Result<()> {
        let members = self.members;
        ensure!(
            members >= 2,
            "members = {members}: it must be at least 2, the default plant is the one nearest to all others"
        );
        ensure!(self.most_starts > 0, "most_starts = 0: it must be at least 1");
        for (name, reach) in [("reach", self.reach), ("beyond.reach", self.beyond.reach)] {
            let [least, most] = reach;
            ensure!(
                0.0 < least && least <= most && most <= 1.0,
                "{name} = {reach:?}: it must be two shares, 0 < least <= most <= 1"
            );
        }
        Ok(())
    }
}

/// The plant of the files, with the weights of both studies.
fn default_plant(files: &FilesEntry, directory: &Path) -> Result<Candidate> {
    let rig = RigFile::read(directory.join(&files.rig))?.rig;
    let weights = |name: &String| -> Result<CostWeights> {
        let cost = CostFile::read(directory.join(name))?;
        let weight = cost.net_energy_per_w;
        ensure!(weight == 0.0, "{name}: `k8_net_energy` is {weight}: it must be 0, the studies weigh no energy");
        Ok(cost.weights)
    };
    Ok(Candidate { rig, weights: [weights(&files.chapter4)?, weights(&files.chapter7)?] })
}

/// What is fitted to, each once, and what is held out.
fn evidence_of(
    evidence: Vec<EvidenceEntry>,
    held_out: Vec<HeldOutEntry>,
    boxes: &[Bounds; 2],
) -> Result<(Vec<Evidence>, Vec<Evidence>)> {
    ensure!(!evidence.is_empty(), "no [[evidence]]: there is nothing to fit");
    let evidence: Vec<Evidence> = evidence.into_iter().map(|entry| entry.check(boxes)).collect::<Result<_>>()?;
    ensure!(!held_out.is_empty(), "no [[held_out]]: the page needs a published number that nothing is fitted to");
    let held_out = held_out.into_iter().map(|entry| entry.check(boxes)).collect::<Result<_>>()?;
    for (index, one) in evidence.iter().enumerate() {
        let is_new = evidence[..index].iter().all(|other| other.label != one.label);
        ensure!(is_new, "evidence `{}` stands twice", one.label);
    }
    Ok((evidence, held_out))
}

/// What is free, each once and with a start.
fn free_of(entries: Vec<FreeEntry>) -> Result<Vec<Free>> {
    let free: Vec<Free> = entries.into_iter().map(FreeEntry::check).collect::<Result<_>>()?;
    ensure!(!free.is_empty(), "no [[free]] number: there is nothing to choose");
    for (index, one) in free.iter().enumerate() {
        ensure!(free[..index].iter().all(|other| other.key != one.key), "`{}` is free twice", one.key);
        ensure!(one.start.is_some(), "`{}` has no start: starts begin there", one.key);
    }
    Ok(free)
}

/// What is calibrated, over which ranges, to what.
#[derive(Debug)]
pub(super) struct Calibration {
    pub(super) title: String,
    pub(super) n_members: usize,
    pub(super) most_starts: u64,
    pub(super) seed: u64,
    /// How far starts go from the plant where they begin toward one drawn over the ranges: at least and at most.
    pub(super) reach: [f64; 2],
    /// The same of starts whose plants are no members, and how many of them there are.
    pub(super) beyond: ([f64; 2], u64),
    /// The default plant: what is not free is as in it.
    pub(super) base: Candidate,
    /// The files of the default plant: rig, and the weights of each study.
    pub(super) files: [PathBuf; 3],
    profile_file: PathBuf,
    pub(super) profile: TestProfile,
    pub(super) settings: FlightSettings,
    pub(super) boxes: [Bounds; 2],
    pub(super) evidence: Vec<Evidence>,
    pub(super) held_out: Vec<Evidence>,
    pub(super) tolerance: Tolerance,
    pub(super) free: Vec<Free>,
}

impl Calibration {
    pub(super) fn read(root: &Path) -> Result<Self> {
        study_file::read(&root.join(FILE), Self::of)
    }

    fn of(file: CalibrationFile, directory: &Path) -> Result<Self> {
        let FilesEntry { rig, profile, chapter4, chapter7 } = &file.files;
        let files = [rig, chapter4, chapter7].map(|name| directory.join(name));
        let base = default_plant(&file.files, directory)?;
        let profile_file = directory.join(profile);
        let profile = ProfileFile::read(&profile_file)?.profile;
        file.check_extent()?;
        let settings = FlightSettings::with_steps(file.steps_per_sample);
        settings.validate().context("steps_per_sample")?;
        file.tolerance.check()?;
        let boxes = evidence::bounds(&file.boxes)?;
        let (evidence, held_out) = evidence_of(file.evidence, file.held_out, &boxes)?;
        let free = free_of(file.free)?;
        Ok(Self {
            title: file.title,
            n_members: file.members,
            most_starts: file.most_starts,
            seed: file.seed,
            reach: file.reach,
            beyond: (file.beyond.reach, file.beyond.starts),
            base,
            files,
            profile_file,
            profile,
            settings,
            boxes,
            evidence,
            held_out,
            tolerance: file.tolerance,
            free,
        })
    }

    /// What the tables of what was found hold: the columns, and a name of all that decides what comes of a start.
    pub(super) fn shape(&self, root: &Path) -> Result<Shape> {
        let free: Vec<String> = self.free.iter().flat_map(|free| free.keys().map(str::to_owned)).collect();
        let mut key = Key::default().with(decisive(&root.join(FILE), &BESIDE)?.to_string());
        key = key.with(decisive(&self.profile_file, &[])?.to_string());
        // The plants that are kept differ from the default plant in these numbers, and do not depend on its own.
        for (path, before) in self.files.iter().zip(BEFORE) {
            let mut table = decisive(path, &[])?;
            drop_entries(&mut table, before, &free);
            key = key.with(table.to_string());
        }
        let range = |free: &Free| Range { key: free.key.clone(), lower: free.lower, upper: free.upper };
        Ok(Shape { key: key.name(), ranges: self.free.iter().map(range).collect(), folders: &[ENSEMBLE, BEYOND] })
    }

    /// Of the starts from farther away: what decides of the others, and how far they go.
    pub(super) fn shape_beyond(&self, shape: &Shape) -> Shape {
        let key = Key::default().with(&shape.key).with(format!("{:?}", self.beyond.0));
        Shape { key: key.name(), ranges: shape.ranges.clone(), folders: &[BEYOND] }
    }

    #[cfg(feature = "ensemble")]
    pub(super) fn keys(&self) -> Vec<String> {
        self.free.iter().map(|free| free.key.clone()).collect()
    }

    /// The values of the free numbers at coordinates from minus to plus infinity.
    pub(super) fn values(&self, coordinates: &[f64]) -> Vec<f64> {
        let logistic = |z: f64| 1.0 / (1.0 + (-z).exp());
        self.free.iter().zip(coordinates).map(|(free, z)| free.at(logistic(*z))).collect()
    }

    pub(super) fn candidate(&self, coordinates: &[f64]) -> Candidate {
        self.with(&self.values(coordinates)).unwrap_or_else(|_| self.base.clone())
    }

    pub(super) fn with(&self, values: &[f64]) -> Result<Candidate> {
        let mut candidate = self.base.clone();
        self.free.iter().zip(values).try_for_each(|(free, value)| free.set(&mut candidate, *value))?;
        Ok(candidate)
    }

    /// The free numbers of a plant as shares of their ranges, each on its scale.
    pub(super) fn shares(&self, member: &Member) -> Vec<f64> {
        self.free.iter().zip(&member.values).map(|(free, value)| free.share(*value)).collect()
    }

    pub(super) fn candidates(&self, members: &[Member]) -> Result<Vec<Candidate>> {
        members.iter().map(|member| self.with(&member.values)).collect()
    }

    /// One candidate at every spot; none where a flight fails.
    pub(super) fn fly(&self, candidate: &Candidate, spots: &[Spot]) -> Vec<Option<Flown>> {
        fly(std::slice::from_ref(candidate), spots, &self.profile, &self.settings).pop().unwrap_or_default()
    }

    /// How far a start goes from the plant that all begin with to one that is drawn over the ranges, as a share.
    pub(super) fn reach_of(&self, number: u64) -> f64 {
        self.drawn(number, self.reach).0
    }

    fn drawn(&self, number: u64, [least, most]: [f64; 2]) -> (f64, ChaCha8Rng) {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream(number);
        (least + (most - least) * rng.random::<f64>(), rng)
    }

    /// Where a start begins, by its number alone: between the plant that all begin with and one that is evenly drawn over the ranges.
    pub(super) fn start(&self, number: u64, reach: [f64; 2]) -> Vec<f64> {
        let (reach, mut rng) = self.drawn(number, reach);
        let within = |share: f64| share.clamp(INSIDE, 1.0 - INSIDE);
        let share = |free: &Free| {
            let known = within(free.share(free.start.unwrap_or_else(|| free.value(&self.base))));
            within(known + reach * (rng.random::<f64>() - known))
        };
        let shares: Vec<f64> = self.free.iter().map(share).collect();
        shares.into_iter().map(|share| (share / (1.0 - share)).ln()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seal::Copies;

    fn refuses(from: &str, to: &str, words: &[&str]) {
        study_file::assert_refused("calibration.toml", Calibration::of, [from, to], words);
    }

    #[test]
    fn mistakes_are_named() {
        refuses("lower = 0.000207", "lower = 0.01", &["plant.body.volume", "0.01", "lower must be below upper"]);
        refuses("plant.body.volume", "plant.body.volumes", &["no number `plant.body.volumes`"]);
        refuses("unit = \"m^3\"", "unit = \"cm^3\"", &["plant.body.volume", "cm^3", "m^3"]);
        refuses("cost = 4.35", "cost = -4.35", &["Table 3, row 1", "-4.35", "positive"]);
        refuses("pitch_set_point = 17.3", "pitch_set_point = 37.3", &["Table 3, row 1", "37.3", "box of chapter4"]);
        refuses(
            "study = \"chapter4\"\nfidelity",
            "study = \"chapter5\"\nfidelity",
            &["chapter5", "chapter4, chapter7"],
        );
        refuses("start = 0.0002379", "start = 0.2379", &["plant.body.volume", "0.2379", "0.000207 to 0.0002394"]);
        refuses("start = 0.0002379", "", &["plant.body.volume", "no start"]);
        refuses("members = 30", "member = 30", &["member"]);
        refuses("members = 30", "members = 1", &["members = 1", "at least 2"]);
        refuses("most_starts = 400", "most_starts = 0", &["most_starts = 0", "at least 1"]);
        refuses("most_starts = 400", "most_starts = -1", &["most_starts", "-1"]);
        refuses("reach = [0.1, 0.5]", "reach = [0.5, 0.1]", &["reach = [0.5, 0.1]", "least <= most"]);
        refuses("reach = [0.1, 0.5]", "reach = [0.1, nan]", &["reach = [0.1, NaN]"]);
        refuses("reach = [0.5, 1.0]", "reach = [0.5, 1.5]", &["beyond.reach = [0.5, 1.5]", "most <= 1"]);
        refuses(
            "center_of_mass = [45.65, 51.25]",
            "center_of_mass = [51.25, 45.65]",
            &["box of chapter4", "center_of_mass"],
        );
        refuses("pitch_set_point = [0.0, 22.0]", "pitch_set_point = [0.0, inf]", &["box of chapter4", "finite"]);
        refuses("cost = 4.35", "cost = inf", &["Table 3, row 1", "inf", "positive"]);
        refuses("cost = 0.02", "cost = -0.02", &["tolerance.cost = -0.02", "positive"]);
        refuses(
            "Table 3, row 1: the experiment there",
            "Table 3, row 1: optimum of the model",
            &["evidence", "stands twice"],
        );
        refuses("lower = 0.000207", "lower = nan", &["plant.body.volume", "NaN"]);
        refuses("start = 0.0002379", "start = nan", &["plant.body.volume", "NaN"]);
        refuses("cost = 0.02", "cost = 0.0", &["tolerance.cost = 0", "positive"]);
    }

    /// A file without the tables of this name.
    fn without(name: &str) -> String {
        let read = study_file::read_changed("calibration.toml", Calibration::of, |text| {
            let mut table: toml::Table = text.parse().expect("a file");
            table.remove(name);
            table.to_string()
        });
        format!("{:#}", read.expect_err("an error"))
    }

    #[test]
    fn missing_tables_are_named() {
        for name in ["evidence", "held_out", "free", "box", "tolerance"] {
            assert!(without(name).contains(name), "{}", without(name));
        }
    }

    /// Numbers decide what comes of a start; words, counts and the free numbers of the default plant do not.
    #[test]
    fn key_of_what_is_kept_follows_from_what_decides() {
        let names = ["calibration.toml", "rig.toml", "test-profile.toml", "cost-chapter4.toml", "cost-chapter7.toml"];
        let copies = Copies::of(&names);
        let key = || Calibration::read(copies.root()).and_then(|file| file.shape(copies.root())).expect("a key").key;
        let before = key();
        let after = |name: &str, from: &str, to: &str| copies.with(name, [from, to], key);
        for (from, to) in [
            ("members = 30", "members = 40"),
            ("most_starts = 400", "most_starts = 500"),
            ("reason = \"15 to 33 %", "reason = \"about 15 to 33 %"),
            ("cost = 6.12", "cost = 6.13"),
            ("# Fitted until", "# It is fitted until"),
        ] {
            assert_eq!(before, after("calibration.toml", from, to), "{to}");
        }
        assert_eq!(before, after("rig.toml", "the ensemble, its medoid", "the ensemble"));
        for (name, from, to) in [
            ("calibration.toml", "cost = 5.81", "cost = 5.50"),
            ("calibration.toml", "upper = 0.0002394", "upper = 0.0002395"),
            ("calibration.toml", "seed = 1", "seed = 2"),
            ("calibration.toml", "reach = [0.1, 0.5]", "reach = [0.1, 0.6]"),
            ("calibration.toml", "cost = 0.02", "cost = 0.03"),
            ("test-profile.toml", "0.205", "0.206"),
            ("rig.toml", "value = 1000.0", "value = 1001.0"),
        ] {
            assert_ne!(before, after(name, from, to), "{name}: {to}");
        }
    }

    /// Starts are drawn by number, so that they do not depend on how a run was cut; each stays within its ranges.
    #[test]
    fn starts_are_within_the_ranges() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let calibration = Calibration::read(&root).expect("a file");
        for number in 0..50 {
            let start = calibration.start(number, calibration.reach);
            assert_eq!(start, calibration.start(number, calibration.reach));
            assert!((calibration.reach[0]..=calibration.reach[1]).contains(&calibration.reach_of(number)));
            for (free, value) in calibration.free.iter().zip(calibration.values(&start)) {
                let share = free.share(value);
                assert!((INSIDE - 1e-9..=1.0 - INSIDE + 1e-9).contains(&share), "{}: {value}", free.key);
            }
        }
        assert_ne!(calibration.start(0, calibration.reach), calibration.start(1, calibration.reach));
    }

    /// It is chosen among what came of them.
    #[test]
    fn starts_do_not_depend_on_the_default_plant() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let mut calibration = Calibration::read(&root).expect("a file");
        let before = calibration.start(3, calibration.reach);
        for free in &calibration.free {
            free.set(&mut calibration.base, free.at(0.5)).expect("within its range");
        }
        assert_eq!(calibration.start(3, calibration.reach), before);
    }
}
