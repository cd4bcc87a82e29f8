//! The file of the ensemble, checked.

use std::path::Path;

use anyhow::{Context as _, Result, ensure};
use bat_dynamics::OPTIONAL_FIELDS;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use serde::Deserialize;
use water_channel::{ProfileFile, Rig, Sensing, SensingFile, TestProfile};

use crate::calibration::Origin;
use crate::costs::key::Key;
use crate::decisive::decisive;
use crate::reproduction::Extent;
use crate::seal::drop_entries;
use crate::study_file::{self, check_seeds};
use crate::{calibration, chapter3, chapter4, chapter6, chapter7, provenance};

const FOLDER: &str = "fixtures/bat";
const FILE: &str = "ensemble.toml";
/// What all rows follow from, beside this program, the plants and what these have in common.
const FILES: [&str; 9] = [
    FILE,
    "test-profile.toml",
    "test-profile-open-loop.toml",
    "chapter3.toml",
    "chapter4.toml",
    "chapter6.toml",
    "chapter7.toml",
    "moving-water.toml",
    "sensing.toml",
];
/// How many plants there are decides nothing about the rows of one.
const COUNTS: &str = "campaigns.plants_of_four";
/// The plants, and those from farther away. They name in their first line what they were calibrated by.
const PLANTS: &str = "ensemble/members.csv";
const PLANTS_BEYOND: &str = "ensemble/beyond/members.csv";
/// The files of the default plant, with what stands before the keys of free numbers in them: rows follow from the others alone.
const COMMON: [(&str, &str); 3] =
    [("rig.toml", ""), ("cost-chapter4.toml", "chapter4."), ("cost-chapter7.toml", "chapter7.")];

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct StudyFile {
    title: String,
    files: FilesEntry,
    campaigns: Campaigns,
    cameras: Regions,
    hull: HullEntry,
}

/// Where cameras look for dots: margins about where these are in still water.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Regions {
    pub(super) camera: String,
    /// Counted from 1.
    pub(super) dots: Vec<usize>,
    pub(super) margins_px: Vec<f64>,
    pub(super) shown_px: f64,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct FilesEntry {
    chapter3: String,
    chapter4: String,
    chapter6: String,
    chapter7: String,
    water: String,
    sensing: String,
}

/// How many of everything.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Campaigns {
    pub(super) seeds: u64,
    pub(super) seeds_of_four: u64,
    pub(super) plants_of_four: usize,
    pub(super) truth_seeds: u64,
    pub(super) random_designs: u64,
    pub(super) coarser: f64,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct HullEntry {
    seed: u64,
    asymmetry: Vec<AsymmetryEntry>,
    given: Vec<GivenEntry>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct AsymmetryEntry {
    key: String,
    largest: f64,
    unit: String,
    source: String,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct GivenEntry {
    key: String,
    value: f64,
    unit: String,
    source: String,
}

/// The test with the tables of moving water beside its own.
fn in_water(profile: &str, water: &str) -> Result<ProfileFile> {
    let (mut joined, mut tables): (toml::Table, toml::Table) = (toml::from_str(profile)?, toml::from_str(water)?);
    ensure!(tables.contains_key("water"), "it has no [water]");
    tables.remove("title");
    for (key, table) in tables {
        ensure!(!joined.contains_key(&key), "`{key}` is in the test as well");
        joined.insert(key, table);
    }
    Ok(ProfileFile::parse(&toml::to_string(&joined)?)?)
}

/// The study ready to run.
#[derive(Debug)]
pub(super) struct Setup {
    pub(super) title: String,
    pub(super) campaigns: Campaigns,
    /// Names of the numbers that were free in the plants.
    pub(super) keys: Vec<String>,
    pub(super) origin: Origin,
    pub(super) plants: Vec<calibration::Plant>,
    pub(super) chapter3: chapter3::Setup,
    pub(super) chapter4: chapter4::Setup,
    pub(super) chapter6: chapter6::Setup,
    pub(super) chapter7: chapter7::Setup,
    pub(super) still: TestProfile,
    /// The same test in water that moves, for its first seed.
    moving: ProfileFile,
    pub(super) sensing: Sensing,
    pub(super) regions: Regions,
    hull: HullEntry,
    /// Names all that rows follow from.
    pub(super) key: String,
}

impl Setup {
    /// That on the plants of the ensemble.
    #[cfg(test)]
    pub(super) fn read(root: &Path) -> Result<Self> {
        Self::read_of(root, Origin::Near)
    }

    /// The study on plants of one origin.
    pub(super) fn read_of(root: &Path, origin: Origin) -> Result<Self> {
        let folder = root.join(FOLDER);
        let (keys, plants) = calibration::plants(root, origin)?;
        let key = made_from(&folder, origin, &calibration::free_keys(root)?)?;
        let of = |file: StudyFile, folder: &Path| Self::of(file, folder, keys, (origin, plants), key.name());
        study_file::read(&folder.join(FILE), of)
    }

    fn of(
        file: StudyFile,
        folder: &Path,
        keys: Vec<String>,
        (origin, plants): (Origin, Vec<calibration::Plant>),
        key: String,
    ) -> Result<Self> {
        file.campaigns.check()?;
        file.hull.check()?;
        file.cameras.check()?;
        let profile_text = std::fs::read_to_string(folder.join("test-profile.toml")).context("test-profile.toml")?;
        let water = &file.files.water;
        let sensing = SensingFile::read(folder.join(&file.files.sensing))?.sensing;
        let names: Vec<&str> = sensing.cameras.iter().map(|camera| camera.name.as_str()).collect();
        ensure!(
            names.contains(&file.cameras.camera.as_str()),
            "cameras.camera = `{}`: it must be one of {}",
            file.cameras.camera,
            names.join(", ")
        );
        let water_text = std::fs::read_to_string(folder.join(water)).with_context(|| water.clone())?;
        let n_dots = sensing.dots.len();
        for number in &file.cameras.dots {
            ensure!((1..=n_dots).contains(number), "cameras.dots: {number}: each must be from 1 to {n_dots}");
        }
        Ok(Self {
            title: file.title,
            campaigns: file.campaigns,
            keys,
            origin,
            plants,
            chapter3: chapter3::Setup::read(&folder.join(&file.files.chapter3))?,
            chapter4: chapter4::Setup::read(&folder.join(&file.files.chapter4))?,
            chapter6: chapter6::Setup::read(&folder.join(&file.files.chapter6), Extent::Default)?,
            chapter7: chapter7::Setup::read(&folder.join(&file.files.chapter7))?,
            still: ProfileFile::parse(&profile_text).context("test-profile.toml")?.profile,
            moving: in_water(&profile_text, &water_text).with_context(|| water.clone())?,
            sensing,
            regions: file.cameras,
            hull: file.hull,
            key,
        })
    }

    /// The test in moving water.
    pub(super) fn moving(&self) -> &TestProfile {
        &self.moving.profile
    }

    /// By what the sides of a plant differ, drawn by its number: key and value.
    pub(super) fn sides(&self, plant: u64) -> Vec<(&str, f64)> {
        let mut rng = ChaCha8Rng::seed_from_u64(self.hull.seed);
        rng.set_stream(plant);
        let value = |largest: f64, rng: &mut ChaCha8Rng| (2.0 * rng.random::<f64>() - 1.0) * largest;
        self.hull.asymmetry.iter().map(|entry| (&*entry.key, value(entry.largest, &mut rng))).collect()
    }

    /// The rig of a plant with sides that differ.
    pub(super) fn lopsided(&self, plant: &calibration::Plant) -> Rig {
        let mut rig = plant.rig.clone();
        for (key, value) in self.sides(plant.number) {
            set(&mut rig, key, value);
        }
        for entry in &self.hull.given {
            set(&mut rig, &entry.key, entry.value);
        }
        rig
    }

    /// One of the cameras without the others, and some of the dots.
    pub(super) fn one_camera(&self) -> Sensing {
        let mut sensing = self.sensing.clone();
        sensing.cameras.retain(|camera| camera.name == self.regions.camera);
        let mut number = 0;
        sensing.dots.retain(|_| {
            number += 1;
            self.regions.dots.contains(&number)
        });
        sensing
    }

    /// What was estimated of the moving world, number by number: key, value with unit, source.
    pub(super) fn estimates(&self) -> Vec<[String; 3]> {
        let water = self.moving.records.iter().filter(|record| record.key.starts_with("water"));
        let water = water.map(|record| {
            let value = format!("{} {}", record.value, record.unit);
            [record.key.clone(), value, format!("{}: {}", provenance::word(record.provenance), record.source)]
        });
        let drawn = self.hull.asymmetry.iter().map(|entry| {
            let value = format!("up to ±{} {}", entry.largest, entry.unit);
            [entry.key.clone(), value, entry.source.clone()]
        });
        let given = self.hull.given.iter();
        let given =
            given.map(|entry| [entry.key.clone(), format!("{} {}", entry.value, entry.unit), entry.source.clone()]);
        water.chain(drawn).chain(given).collect()
    }
}

/// Names all that rows follow from: what of the files decides, and the plants. Of the files of the default plant the free numbers
/// are left out, for these are the plants' own.
fn made_from(folder: &Path, origin: Origin, free: &[String]) -> Result<Key> {
    let plants = folder.join(if origin == Origin::Beyond { PLANTS_BEYOND } else { PLANTS });
    let text = std::fs::read_to_string(&plants).with_context(|| plants.display().to_string())?;
    let (_, rows) = text.split_once('\n').with_context(|| format!("{}: no rows", plants.display()))?;
    let counts = [COUNTS.to_owned()];
    let own = FILES.map(|name| (name, "", counts.as_slice()));
    let common = COMMON.map(|(name, before)| (name, before, free));
    own.into_iter().chain(common).try_fold(Key::default().with(rows), |key, (name, before, others)| {
        let mut table = decisive(&folder.join(name), &[])?;
        drop_entries(&mut table, before, others);
        Ok(key.with(table.to_string()))
    })
}

fn set(rig: &mut Rig, key: &str, value: f64) {
    for field in OPTIONAL_FIELDS.iter().filter(|field| field.section == "asymmetry" && field.name == key) {
        (field.set)(&mut rig.plant, value);
    }
}

impl Campaigns {
    fn check(&self) -> Result<()> {
        check_seeds("campaigns.seeds", self.seeds)?;
        check_seeds("campaigns.seeds_of_four", self.seeds_of_four)?;
        check_seeds("campaigns.truth_seeds", self.truth_seeds)?;
        ensure!(
            (2..=1024).contains(&self.random_designs),
            "campaigns.random_designs = {}: it must be from 2 to 1024",
            self.random_designs
        );
        ensure!(
            self.coarser.is_finite() && self.coarser >= 1.0,
            "campaigns.coarser = {}: it must be 1 or more",
            self.coarser
        );
        Ok(())
    }
}

impl Regions {
    fn check(&self) -> Result<()> {
        study_file::check_not_empty([("cameras.margins_px", self.margins_px.len())])?;
        for margin in &self.margins_px {
            ensure!(
                margin.is_finite() && *margin >= 0.0,
                "cameras.margins_px: {margin}: each must be finite and not negative"
            );
        }
        ensure!(
            self.margins_px.windows(2).all(|pair| pair[0] < pair[1]),
            "cameras.margins_px: each must be more than the one before"
        );
        ensure!(
            self.margins_px.iter().any(|margin| margin.to_bits() == self.shown_px.to_bits()),
            "cameras.shown_px = {}: it must be one of cameras.margins_px",
            self.shown_px
        );
        Ok(())
    }
}

impl HullEntry {
    fn check(&self) -> Result<()> {
        let drawn = self.asymmetry.iter().map(|entry| (&entry.key, entry.largest, &entry.unit, &entry.source));
        let given = self.given.iter().map(|entry| (&entry.key, entry.value, &entry.unit, &entry.source));
        for (key, value, unit, source) in drawn.chain(given) {
            let field = OPTIONAL_FIELDS.iter().find(|field| field.section == "asymmetry" && field.name == key);
            let field = field.with_context(|| {
                let known: Vec<&str> = OPTIONAL_FIELDS.iter().map(|field| field.name).collect();
                format!("hull: no asymmetry `{key}`: it must be one of {}", known.join(", "))
            })?;
            ensure!(unit == field.unit, "hull: `{key}` has the unit `{unit}`: it must be `{}`", field.unit);
            ensure!(value.is_finite() && value >= 0.0, "hull: `{key}` is {value}: it must be finite and not negative");
            ensure!(!source.trim().is_empty(), "hull: `{key}` has no source: every number must have one");
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seal::Copies;

    /// Words decide nothing, and the default plant is one of many; the plants and what they have in common do.
    #[test]
    fn rows_follow_from_numbers_that_are_not_free() {
        let names = [&FILES[..], &COMMON.map(|(name, _)| name), &[PLANTS, PLANTS_BEYOND]].concat();
        let copies = Copies::of(&names);
        let free = ["plant.hull.center_x", "chapter4.k1_heading"].map(str::to_owned);
        let key = || made_from(&copies.root().join(FOLDER), Origin::Near, &free).expect("a key").name();
        let before = key();
        for (name, from, to) in [
            (FILE, "# Seeds of the noise", "# The seeds of noise"),
            (FILE, "title = \"Claims", "title = \"All claims"),
            (FILE, "plants_of_four = 30", "plants_of_four = 20"),
            (PLANTS, "# made from", "# from"),
            ("rig.toml", "center_x = { value = 28", "center_x = { value = 29"),
            ("cost-chapter4.toml", "k1_heading = { value = ", "k1_heading = { value = 1"),
        ] {
            assert_eq!(before, copies.with(name, [from, to], key), "{name}: {to}");
        }
        for (name, from, to) in [
            (FILE, "seeds = 5", "seeds = 6"),
            ("chapter7.toml", "confidence = 0.9", "confidence = 0.8"),
            ("cost-chapter4.toml", "k2_pitch = { value = ", "k2_pitch = { value = 1"),
            ("rig.toml", "value = 1000.0", "value = 1001.0"),
            (PLANTS, "\n0,0.", "\n0,1."),
        ] {
            assert_ne!(before, copies.with(name, [from, to], key), "{name}: {to}");
        }
        assert_ne!(before, made_from(&copies.root().join(FOLDER), Origin::Beyond, &free).expect("a key").name());
    }

    /// Each store holds rows of its own plants alone.
    #[test]
    fn rows_of_plants_from_farther_away_are_refused_for_the_ensemble() -> Result<()> {
        use crate::ensemble::store::Store;
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let [near, beyond] = [Origin::Near, Origin::Beyond].map(|origin| Setup::read_of(&root, origin));
        let (near, beyond) = (near?, beyond?);
        assert_ne!(near.key, beyond.key);
        assert_eq!(near.keys, beyond.keys);
        for (own, other) in [(&near, &beyond), (&beyond, &near)] {
            let folder = root.join(own.origin.folder());
            let store = Store::read(&folder, &own.key)?;
            assert!(own.plants.iter().all(|plant| store.done.iter().any(|done| done.unit.1 == plant.number)));
            let error = format!("{:#}", Store::read(&folder, &other.key).expect_err("rows of other plants"));
            assert!(error.contains("designs.csv") && error.contains("first line"), "{error}");
        }
        Ok(())
    }

    /// As its first line says: below the title it may be appended to the test.
    #[test]
    fn a_test_in_moving_water_is_the_one_with_the_tables_below_it() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/bat");
        let read = |name: &str| std::fs::read_to_string(folder.join(name)).expect("a file");
        let (profile, water) = (read("test-profile.toml"), read("moving-water.toml"));
        let joined = in_water(&profile, &water).expect("a test in moving water");
        let (_, tables) = water.split_once("[water]").expect("its table");
        let appended = ProfileFile::parse(&format!("{profile}\n[water]{tables}")).expect("the same");
        assert_eq!(joined.profile, appended.profile);
        assert_ne!(joined.profile, ProfileFile::parse(&profile).expect("a test").profile);
        let twice = format!("{water}\n[duration]\n");
        assert!(in_water(&profile, &twice).expect_err("twice").to_string().contains("duration"));
        assert!(in_water(&profile, "title = \"dry\"").expect_err("dry").to_string().contains("[water]"));
    }

    fn of(file: StudyFile, folder: &Path) -> Result<Setup> {
        Setup::of(file, folder, Vec::new(), (Origin::Near, Vec::new()), String::new())
    }

    fn refuses(from: &str, to: &str, words: &[&str]) {
        study_file::assert_refused(FILE, of, [from, to], words);
    }

    #[test]
    fn mistakes_are_named() {
        refuses("margins_px = [0.0,", "margins_px = [-1.0,", &["cameras.margins_px", "-1", "not negative"]);
        refuses("camera = \"below\"", "camera = \"above\"", &["cameras.camera = `above`", "side, downstream, below"]);
        refuses("dots = [5,", "dots = [11,", &["cameras.dots: 11", "1 to 10"]);
        refuses("shown_px = 40.0", "shown_px = 41.0", &["cameras.shown_px = 41", "one of"]);
        refuses("seeds = 5", "seed = 5", &["unknown field `seed`"]);
        refuses("seeds = 5", "seeds = 0", &["campaigns.seeds = 0", "1 to 1000"]);
        refuses("random_designs = 64", "random_designs = 1", &["random_designs = 1", "from 2"]);
        refuses("coarser = 2.0", "coarser = 0.5", &["coarser = 0.5", "1 or more"]);
        refuses("key = \"line_port\"", "key = \"line_left\"", &["no asymmetry `line_left`", "line_port"]);
        refuses("unit = \"1/rad\"", "unit = \"1/deg\"", &["lift_slope_difference", "1/deg", "1/rad"]);
        refuses("largest = 0.3", "largest = -0.3", &["lift_slope_difference", "-0.3", "not negative"]);
        refuses("water = \"moving-water.toml\"", "water = \"rig.toml\"", &["rig.toml", "no [water]"]);
    }

    /// Sides differ by what the number of a plant draws, within the ranges; the plant itself stays as it is.
    #[test]
    fn hulls_are_drawn_by_the_number_of_the_plant() -> Result<()> {
        let setup = Setup::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../.."))?;
        let hulls: Vec<_> = setup.plants.iter().map(|plant| setup.lopsided(plant).plant.asymmetry).collect();
        assert!(
            hulls
                .iter()
                .all(|hull| hull.center_of_mass_y_m.abs() <= 0.0005 && (hull.offset_lateral_m - 0.05).abs() < 1e-12)
        );
        assert!(hulls.windows(2).all(|pair| pair[0].line_port_m.to_bits() != pair[1].line_port_m.to_bits()));
        assert!(hulls.iter().any(|hull| hull.line_port_m < 0.0) && hulls.iter().any(|hull| hull.line_port_m > 0.0));
        assert_eq!(hulls[3], setup.lopsided(&setup.plants[3]).plant.asymmetry);
        assert_eq!(setup.lopsided(&setup.plants[3]).plant.body, setup.plants[3].rig.plant.body);
        Ok(())
    }
}
