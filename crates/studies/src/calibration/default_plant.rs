//! The default plant of all commands: the plant of the ensemble that is nearest to all others, its medoid, and the files that it is in.

use std::path::Path;

use anyhow::{Context as _, Result, bail, ensure};
use toml_edit::{DocumentMut, InlineTable, Value};

use super::candidate::STUDIES;
use super::file::Calibration;
use super::free::Free;
use super::medoid::{Medoid, medoid};
use super::outcome::Member;
use crate::kept;

/// Digits of a number behind the first: seven in all.
const DECIMALS: usize = 6;

/// The plant that the rule chooses.
#[derive(Debug)]
pub(super) struct DefaultPlant<'a> {
    pub(super) member: &'a Member,
    /// To all others, over the free numbers as shares of their ranges.
    pub(super) mean_distance: f64,
}

/// A file with the numbers of the plant in it, and what was another before.
struct Written {
    text: String,
    changed: Vec<String>,
}

impl<'a> DefaultPlant<'a> {
    /// The medoid of plants, each number as a share of its range on its scale.
    pub(super) fn of(calibration: &Calibration, members: &'a [Member]) -> Result<Self> {
        let shares: Vec<Vec<f64>> = members.iter().map(|member| calibration.shares(member)).collect();
        let Medoid { index, mean_distance } =
            medoid(&shares).context("there are no two plants: run `cargo xtask calibrate`")?;
        Ok(Self { member: &members[index], mean_distance })
    }

    /// Writes its numbers into the files of the default plant; all else in them stays as it is.
    pub(super) fn write(&self, calibration: &Calibration) -> Result<()> {
        for (path, written) in self.files(calibration)? {
            kept::replace(path, written.text.as_bytes())?;
            eprintln!("{}: {} numbers changed", path.display(), written.changed.len());
        }
        Ok(())
    }

    /// That the files of the default plant have its numbers.
    pub(super) fn check(&self, calibration: &Calibration) -> Result<()> {
        for (path, written) in self.files(calibration)? {
            if let Some(changed) = written.changed.first() {
                bail!(
                    "{}: {changed}, and there are {} such numbers: the default plant is not plant {} of the ensemble, its medoid; run \
                     `cargo xtask calibrate --default`",
                    path.display(),
                    written.changed.len(),
                    self.member.start
                );
            }
        }
        Ok(())
    }

    fn files<'b>(&self, calibration: &'b Calibration) -> Result<Vec<(&'b Path, Written)>> {
        let all = calibration.files.iter().enumerate();
        let written = all.map(|(file, path)| {
            let words = || path.display().to_string();
            let text = std::fs::read_to_string(path).with_context(words)?;
            Ok((path.as_path(), self.written(&calibration.free, file, &text).with_context(words)?))
        });
        written.collect()
    }

    /// The text of a file, by its number among the files of the default plant, with the numbers that are in it.
    fn written(&self, free: &[Free], file: usize, text: &str) -> Result<Written> {
        let mut document: DocumentMut = text.parse()?;
        let mut changed = Vec::new();
        let source = format!("Tables 3 and 5; member {} of the ensemble, its medoid", self.member.start);
        for (free, value) in free.iter().zip(&self.member.values) {
            for key in free.keys() {
                let (of, path) = place(key);
                if of == file {
                    let entry = entry(&mut document, &path).with_context(|| format!("no number `{key}`"))?;
                    let words = || format!("`{key}`");
                    let found = set(entry, value * in_file(entry, &free.unit).with_context(words)?, &source);
                    changed.extend(found.with_context(words)?.map(|words| format!("`{key}` {words}")));
                }
            }
        }
        Ok(Written { text: document.to_string(), changed })
    }
}

/// The file that a key is in, and its path there.
fn place(key: &str) -> (usize, Vec<&str>) {
    let path: Vec<&str> = key.split('.').collect();
    match STUDIES.iter().position(|study| *study == path[0]) {
        Some(study) => (1 + study, path[1..].to_vec()),
        None => (0, path),
    }
}

fn entry<'a>(document: &'a mut DocumentMut, path: &[&str]) -> Option<&'a mut InlineTable> {
    let (first, others) = path.split_first()?;
    let found = others.iter().try_fold(document.get_mut(first)?, |item, key| item.get_mut(key))?;
    found.as_inline_table_mut()
}

/// By what a number is multiplied for the unit that a file has it in.
fn in_file(entry: &InlineTable, unit: &str) -> Result<f64> {
    let found = entry.get("unit").and_then(Value::as_str).context("no unit")?;
    if (unit, found) == ("chord", "% chord") {
        return Ok(100.0);
    }
    ensure!(found == unit, "unit = `{found}`: it must be `{unit}`");
    Ok(1.0)
}

/// Puts a number, rounded, into an entry; says what was another before.
fn set(entry: &mut InlineTable, value: f64, source: &str) -> Result<Option<String>> {
    let rounded: f64 = format!("{value:.DECIMALS$e}").parse()?;
    let before = entry.get("value").and_then(|before| before.as_float().or(before.as_integer().map(|n| n as f64)));
    // With as many digits as it takes, and a power of ten where it is very small.
    let mut words = (before != Some(rounded)).then(|| {
        format!("is {} and should be {rounded:?}", before.map_or("none".to_owned(), |before| format!("{before:?}")))
    });
    if words.is_some() {
        replace(entry, "value", format!("{rounded:?}").parse()?)?;
    }
    for (name, should) in [("provenance", "calibrated"), ("source", source)] {
        let found = entry.get(name).and_then(Value::as_str).unwrap_or_default().to_owned();
        if found != should {
            words.get_or_insert_with(|| format!("has {name} = \"{found}\" and should have \"{should}\""));
            replace(entry, name, should.into())?;
        }
    }
    Ok(words)
}

/// Another value with the blanks around the one before.
fn replace(entry: &mut InlineTable, name: &str, mut value: Value) -> Result<()> {
    let old = entry.get_mut(name).with_context(|| format!("no {name}"))?;
    *value.decor_mut() = old.decor().clone();
    *old = value;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibration::store::Store;

    fn ensemble() -> (Calibration, Store) {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        crate::calibration::read(&root).expect("an ensemble")
    }

    /// By numpy: rows of members.csv as shares, linear or of the logarithm, `linalg.norm` of all differences.
    #[test]
    fn default_plant_is_the_one_that_numpy_finds() {
        let (calibration, store) = ensemble();
        let found = DefaultPlant::of(&calibration, &store.members).expect("plants");
        assert_eq!(found.member.start, 45);
        assert!((found.mean_distance - MEAN_BY_NUMPY).abs() < 1e-12, "{}", found.mean_distance);
    }

    const MEAN_BY_NUMPY: f64 = 0.7989704527361872;

    const TEXT: &str = "# head\n[plant.body]\njoint_x = { value = 45.18, unit = \"% chord\", provenance = \"estimated\", \
                        source = \"old\" } # tail\n\n[plant.added_mass]\ny = { value = 1, unit = \"kg\", provenance = \"calibrated\", source = \"old\" }\n\
                        z = { value = 1.0, unit = \"kg\", provenance = \"calibrated\", source = \"old\" }\n";

    fn free(words: &str) -> Vec<Free> {
        #[derive(serde::Deserialize)]
        struct File {
            free: Vec<super::super::free::FreeEntry>,
        }
        let file: File = toml::from_str(words).expect("entries");
        file.free.into_iter().map(|entry| entry.check().expect("an entry")).collect()
    }

    fn two() -> Vec<Free> {
        free(
            "free = [{ key = \"plant.body.joint_x\", unit = \"chord\", lower = 0.3, upper = 0.6, scale = \"linear\", reason = \"any\" },\n\
             { key = \"plant.added_mass.y\", unit = \"kg\", lower = 0.1, upper = 0.4, scale = \"log\", reason = \"any\", \
             also = [\"plant.added_mass.z\"] }]",
        )
    }

    /// Numbers, provenance and source change, in seven digits and the unit of the file; what is around them does not.
    #[test]
    fn numbers_are_written_and_all_else_stays() {
        let member = Member { start: 7, values: vec![0.464_284_849, 0.000_002_550_780_4] };
        let plant = DefaultPlant { member: &member, mean_distance: 1.0 };
        let written = plant.written(&two(), 0, TEXT).expect("written");
        let source = "provenance = \"calibrated\", source = \"Tables 3 and 5; member 7 of the ensemble, its medoid\" }";
        let lines: Vec<&str> = written.text.lines().collect();
        assert_eq!(lines[0], "# head");
        assert_eq!(lines[2], format!("joint_x = {{ value = 46.42848, unit = \"% chord\", {source} # tail"));
        assert_eq!(lines[5], format!("y = {{ value = 2.55078e-6, unit = \"kg\", {source}"));
        assert_eq!(lines[6], format!("z = {{ value = 2.55078e-6, unit = \"kg\", {source}"));
        assert_eq!(written.changed[0], "`plant.body.joint_x` is 45.18 and should be 46.42848");
        assert_eq!(written.changed.len(), 3);
        let again = plant.written(&two(), 0, &written.text).expect("written");
        assert!(again.changed.is_empty() && again.text == written.text, "{:?}", again.changed);
    }

    #[test]
    fn a_file_that_does_not_fit_is_refused() {
        let member = Member { start: 7, values: vec![0.45, 0.2] };
        let plant = DefaultPlant { member: &member, mean_distance: 1.0 };
        let refused = |from: &str, to: &str, words: [&str; 2]| {
            let error = plant.written(&two(), 0, &TEXT.replace(from, to)).err().expect("an error");
            let error = format!("{error:#}");
            assert!(words.iter().all(|word| error.contains(word)), "{error}");
        };
        refused("joint_x", "joint", ["no number", "plant.body.joint_x"]);
        refused("unit = \"kg\"", "unit = \"g\"", ["plant.added_mass.y", "it must be `kg`"]);
        refused(", source = \"old\"", "", ["plant.body.joint_x", "no source"]);
    }

    #[test]
    fn keys_are_found_in_their_files() {
        assert_eq!(place("plant.body.volume"), (0, vec!["plant", "body", "volume"]));
        assert_eq!(place("chapter4.k1_heading"), (1, vec!["k1_heading"]));
        assert_eq!(place("chapter7.k1_heading"), (2, vec!["k1_heading"]));
    }
}
