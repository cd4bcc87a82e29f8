//! `cargo xtask calibrate`: plants that meet what the dissertation prints, as different as that allows.

mod candidate;
mod evidence;
mod fit;
mod free;
mod landscape;
mod page;
mod store;

use std::path::Path;

use anyhow::{Context as _, Result, ensure};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use serde::Deserialize;
use water_channel::{CostFile, FlightSettings, ProfileFile, RigFile, TestProfile};

use crate::reproduction::progress;
use crate::study_file;
use candidate::{Candidate, Flown, fly};
use evidence::{Aims, Bounds, BoxEntry, Evidence, EvidenceEntry, HeldOutEntry, Rival, Tolerance};
use fit::{Fit, Fitted, Refusal, worst};
use free::{Free, FreeEntry};
use landscape::Landscape;
use store::{Member, Start, Store};

const FILE: &str = "fixtures/bat/calibration.toml";
const ENSEMBLE: &str = "fixtures/bat/ensemble";
/// Starts at once, so that a killed run loses no more than these.
const AT_ONCE: u64 = 4;
/// How often a plant is fitted anew because its costs are lower elsewhere.
const ROUNDS: usize = 8;
/// Starts stay this far inside of their ranges.
const INSIDE: f64 = 0.05;
/// A plant of which more of the box cannot fly is refused.
const MOST_FAILED: f64 = 0.02;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CalibrationFile {
    title: String,
    members: usize,
    most_starts: u64,
    seed: u64,
    reach: [f64; 2],
    steps_per_sample: usize,
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
struct FilesEntry {
    rig: String,
    profile: String,
    chapter4: String,
    chapter7: String,
}

/// What is calibrated, over which ranges, to what.
#[derive(Debug)]
struct Calibration {
    title: String,
    n_members: usize,
    most_starts: u64,
    seed: u64,
    /// How far starts go from the plant of the rig file toward one drawn over the ranges: at least and at most.
    reach: [f64; 2],
    base: Candidate,
    profile: TestProfile,
    settings: FlightSettings,
    boxes: [Bounds; 2],
    evidence: Vec<Evidence>,
    held_out: Vec<Evidence>,
    tolerance: Tolerance,
    free: Vec<Free>,
}

impl Calibration {
    fn read(root: &Path) -> Result<Self> {
        study_file::read(&root.join(FILE), Self::of)
    }

    fn of(file: CalibrationFile, directory: &Path) -> Result<Self> {
        let FilesEntry { rig, profile, chapter4, chapter7 } = &file.files;
        let rig = RigFile::read(directory.join(rig))?.rig;
        let profile = ProfileFile::read(directory.join(profile))?.profile;
        let weights = [chapter4, chapter7].map(|name| CostFile::read(directory.join(name)));
        let [chapter4, chapter7] = weights;
        let base = Candidate { rig, weights: [chapter4?.weights, chapter7?.weights] };
        ensure!(file.members > 0, "members = 0: it must be at least 1");
        let [least, most] = file.reach;
        ensure!(
            0.0 < least && least <= most && most <= 1.0,
            "reach = {:?}: it must be two shares, 0 < least <= most <= 1",
            file.reach
        );
        let settings = FlightSettings::with_steps(file.steps_per_sample);
        settings.validate().context("steps_per_sample")?;
        file.tolerance.check()?;
        let boxes = evidence::bounds(&file.boxes)?;
        ensure!(!file.evidence.is_empty(), "no [[evidence]]: there is nothing to fit");
        let evidence = file.evidence.into_iter().map(|entry| entry.check(&boxes)).collect::<Result<_>>()?;
        let held_out = file.held_out.into_iter().map(|entry| entry.check(&boxes)).collect::<Result<_>>()?;
        let free: Vec<Free> = file.free.into_iter().map(FreeEntry::check).collect::<Result<_>>()?;
        ensure!(!free.is_empty(), "no [[free]] number: there is nothing to choose");
        for (index, one) in free.iter().enumerate() {
            ensure!(free[..index].iter().all(|other| other.key != one.key), "`{}` is free twice", one.key);
        }
        Ok(Self {
            title: file.title,
            n_members: file.members,
            most_starts: file.most_starts,
            seed: file.seed,
            reach: file.reach,
            base,
            profile,
            settings,
            boxes,
            evidence,
            held_out,
            tolerance: file.tolerance,
            free,
        })
    }

    fn keys(&self) -> Vec<String> {
        self.free.iter().map(|free| free.key.clone()).collect()
    }

    /// The values of the free numbers at coordinates from minus to plus infinity.
    fn values(&self, coordinates: &[f64]) -> Vec<f64> {
        let logistic = |z: f64| 1.0 / (1.0 + (-z).exp());
        self.free.iter().zip(coordinates).map(|(free, z)| free.at(logistic(*z))).collect()
    }

    fn candidate(&self, coordinates: &[f64]) -> Candidate {
        self.with(&self.values(coordinates)).unwrap_or_else(|_| self.base.clone())
    }

    fn with(&self, values: &[f64]) -> Result<Candidate> {
        let mut candidate = self.base.clone();
        self.free.iter().zip(values).try_for_each(|(free, value)| free.set(&mut candidate, *value))?;
        Ok(candidate)
    }

    /// Where a start begins, by its number alone: between the plant of the rig file and one that is evenly drawn over the ranges.
    fn start(&self, number: u64) -> Vec<f64> {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream(number);
        let [least, most] = self.reach;
        let reach = least + (most - least) * rng.random::<f64>();
        let within = |share: f64| share.clamp(INSIDE, 1.0 - INSIDE);
        let share = |free: &Free| {
            let known = within(free.share(free.value(&self.base)));
            within(known + reach * (rng.random::<f64>() - known))
        };
        let shares: Vec<f64> = self.free.iter().map(share).collect();
        shares.into_iter().map(|share| (share / (1.0 - share)).ln()).collect()
    }

    /// From a start to a plant that meets the evidence over the whole box, or why there is none.
    fn try_start(&self, number: u64) -> Result<(Start, Option<Member>)> {
        let mut aims = Aims::new(&self.evidence, self.tolerance);
        let mut coordinates = self.start(number);
        let refused = |refusal, fitted: Option<&Fitted>| {
            let worst = fitted.map(|fitted| worst(&fitted.residuals));
            Ok((Start { number, refusal: Some(refusal), worst }, None))
        };
        for _ in 0..ROUNDS {
            let fitted = match Fit::new(self, &aims).run(&coordinates) {
                Ok(fitted) => fitted,
                Err((refusal, closest)) => return refused(refusal, closest.as_ref()),
            };
            let landscape = Landscape::fly(self, &fitted.candidate);
            if landscape.failed() > MOST_FAILED {
                return refused(Refusal::FailsInBox, Some(&fitted));
            }
            let rivals = self.rivals(&landscape, &fitted.candidate)?;
            if rivals.is_empty() {
                let member = Member { start: number, values: self.values(&fitted.coordinates) };
                let worst = Some(worst(&fitted.residuals));
                return Ok((Start { number, refusal: None, worst }, Some(member)));
            }
            rivals.into_iter().for_each(|rival| aims.add(rival));
            coordinates = fitted.coordinates;
        }
        refused(Refusal::OtherOptimum, None)
    }

    /// Where in the box costs are lowest, if not where the evidence has it.
    fn rivals(&self, landscape: &Landscape, candidate: &Candidate) -> Result<Vec<Rival>> {
        let mut rivals = Vec::new();
        for (index, evidence) in self.evidence.iter().enumerate().filter(|(_, evidence)| evidence.is_optimum) {
            let (design, _) = landscape.lowest(evidence, candidate)?;
            if !self.is_near(evidence, design) {
                rivals.push(Rival { evidence: index, design });
            }
        }
        Ok(rivals)
    }

    fn is_near(&self, evidence: &Evidence, design: [f64; 2]) -> bool {
        let apart = design.iter().zip(evidence.design).zip(self.tolerance.of_design());
        apart.into_iter().all(|((found, wanted), tolerance)| (found - wanted).abs() <= tolerance)
    }
}

/// Tries starts until there are enough plants, and writes the page.
pub(crate) fn run(root: &Path) -> Result<()> {
    let calibration = Calibration::read(root)?;
    let mut store = Store::read(&root.join(ENSEMBLE), calibration.keys())?;
    eprintln!("{}: {} of {} kept so far", calibration.title, store.members.len(), calibration.n_members);
    let bar = progress("plants kept", calibration.n_members);
    bar.inc(store.members.len() as u64);
    let mut next = store.starts.last().map_or(0, |start| start.number + 1);
    while store.members.len() < calibration.n_members && next < calibration.most_starts {
        let some: Vec<u64> = (next..calibration.most_starts.min(next + AT_ONCE)).collect();
        next += some.len() as u64;
        let found = some.par_iter().map(|number| calibration.try_start(*number)).collect::<Result<Vec<_>>>()?;
        let before = store.members.len();
        store.add(found)?;
        bar.inc((store.members.len() - before) as u64);
    }
    bar.finish();
    page::write(root, &calibration, &store)
}

/// Writes the page of the plants that are kept.
pub(crate) fn write_page(root: &Path) -> Result<()> {
    let calibration = Calibration::read(root)?;
    let store = Store::read(&root.join(ENSEMBLE), calibration.keys())?;
    page::write(root, &calibration, &store)
}

/// That each plant that is kept still flies and meets its evidence, and that there are enough.
pub(crate) fn check(root: &Path) -> Result<()> {
    let calibration = Calibration::read(root)?;
    let store = Store::read(&root.join(ENSEMBLE), calibration.keys())?;
    ensure!(
        store.members.len() >= calibration.n_members,
        "{ENSEMBLE} has {} plants of {}: run `cargo xtask calibrate`",
        store.members.len(),
        calibration.n_members
    );
    let aims = Aims::new(&calibration.evidence, calibration.tolerance);
    let candidates = candidates(&calibration, &store)?;
    let all = fly(&candidates, &aims.spots(), &calibration.profile, &calibration.settings);
    for ((member, candidate), flown) in store.members.iter().zip(&candidates).zip(all) {
        let flown: Option<Vec<Flown>> = flown.into_iter().collect();
        let flown = flown.with_context(|| format!("plant {} of {ENSEMBLE} no longer flies", member.start))?;
        let worst = worst(&aims.residuals(candidate, &flown));
        ensure!(worst <= 1.0, "plant {} of {ENSEMBLE} misses its evidence by {worst:.2} tolerances", member.start);
    }
    eprintln!("{} plants fly and meet their evidence", store.members.len());
    page::check(root, &calibration, &store)
}

fn candidates(calibration: &Calibration, store: &Store) -> Result<Vec<Candidate>> {
    store.members.iter().map(|member| calibration.with(&member.values)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

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
        refuses("members = 30", "member = 30", &["member"]);
        refuses("members = 30", "members = 0", &["members = 0", "at least 1"]);
        refuses("cost = 0.02", "cost = 0.0", &["tolerance.cost = 0", "positive"]);
    }

    /// Starts are drawn by number, so that they do not depend on how a run was cut; each stays within its ranges.
    #[test]
    fn starts_are_within_the_ranges() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let calibration = Calibration::read(&root).expect("a file");
        for number in 0..50 {
            let start = calibration.start(number);
            assert_eq!(start, calibration.start(number));
            for (free, value) in calibration.free.iter().zip(calibration.values(&start)) {
                let share = free.share(value);
                assert!((INSIDE - 1e-9..=1.0 - INSIDE + 1e-9).contains(&share), "{}: {value}", free.key);
            }
        }
        assert_ne!(calibration.start(0), calibration.start(1));
    }
}
