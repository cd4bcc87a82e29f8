//! The study file of Chapter 7, checked.

use std::path::Path;

use anyhow::{Context as _, Result, ensure};
use infuse::{
    correction::{Gain, Law, Rule},
    global,
};
use serde::Deserialize;
use water_channel::{CostFile, Record};

use crate::bat::Bat;
use crate::gridded::{Regressor, Space};
use crate::study_file::{self, BatchEntry, FilesEntry, NoiseEntry, NumericsEntry, ParameterEntry, check_seeds};
use crate::variable::Variable;

/// The file as written.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct StudyFile {
    pub(crate) title: String,
    files: FilesEntry,
    /// The other weights, to be shown beside these.
    cost_of_chapter4: String,
    parameter: Vec<ParameterEntry>,
    case: Vec<CaseEntry>,
    #[serde(rename = "loop")]
    pub(crate) rule: LoopEntry,
    pub(crate) variant: Vec<Variant>,
    pub(crate) noise: NoiseEntry,
    pub(crate) pooled: PooledEntry,
    published: Vec<Published>,
    numerics: NumericsEntry,
}

/// One of the two studies.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct CaseEntry {
    pub(crate) label: String,
    /// The table of the dissertation that has its rows.
    pub(crate) table: u32,
    parameters: Vec<String>,
    pub(crate) levels: u32,
    /// Levels of the grid that is flown in whole.
    pub(crate) flown_levels: u32,
    pub(crate) batch: BatchEntry,
    pub(crate) iterations: usize,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct LoopEntry {
    pub(crate) confidence: f64,
    law: Law,
    pub(crate) gain: Gain,
    seed: u64,
}

/// A regressor, and with how many seeds of noise it is run.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Variant {
    pub(crate) label: String,
    pub(crate) model: Regressor,
    pub(crate) seeds: u64,
}

/// The pooled loop, and with how many seeds it is run.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PooledEntry {
    pub(crate) seeds: u64,
}

/// What our counterpart of a row owes to fitting.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Standing {
    Calibrated,
    /// Where the stand-in is best was fitted to the row; the way there and the share were not.
    DesignCalibrated,
    Predicted,
}

impl Standing {
    pub(crate) fn words(self) -> &'static str {
        match self {
            Self::Calibrated => "calibrated",
            Self::DesignCalibrated => "partly calibrated",
            Self::Predicted => "predicted",
        }
    }
}

/// A row of Table 5 or 6.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Published {
    table: u32,
    pub(crate) iteration: usize,
    center_of_mass: Option<f64>,
    cm_cb: Option<f64>,
    pitch_set_point: f64,
    horizontal_area: Option<f64>,
    vertical_area: Option<f64>,
    /// Per cent of the original design space left after the iteration.
    pub(crate) share: f64,
    pub(crate) standing: Standing,
}

impl Published {
    /// Its value of a variable in the unit of the study; none where the row has none.
    fn value(&self, variable: Variable, center_of_buoyancy: f64) -> Option<f64> {
        match variable {
            Variable::CenterOfMass => self.center_of_mass.or(self.cm_cb.map(|cm_cb| center_of_buoyancy - cm_cb)),
            Variable::PitchSetPoint => Some(self.pitch_set_point),
            Variable::HorizontalArea => self.horizontal_area,
            Variable::VerticalArea => self.vertical_area,
        }
    }
}

/// The studies ready to run.
#[derive(Debug)]
pub(crate) struct Setup {
    pub(crate) file: StudyFile,
    pub(crate) cases: Vec<Case>,
    /// The weights of the cost as written: of this study, and of Chapter 4.
    pub(crate) weights: [Vec<Record>; 2],
}

/// One study with the flights over its space.
#[derive(Debug)]
pub(crate) struct Case {
    pub(crate) entry: CaseEntry,
    pub(crate) space: Space,
    /// The grid that is flown in whole.
    pub(crate) flown: Space,
    pub(crate) bat: Bat,
    /// In per cent of chord.
    pub(crate) center_of_buoyancy: f64,
    pub(crate) published: Vec<Row>,
}

/// A published row in the variables of its study.
#[derive(Clone, Debug)]
pub(crate) struct Row {
    pub(crate) point: Vec<f64>,
    pub(crate) share: f64,
    pub(crate) standing: Standing,
}

impl Case {
    /// Whether the grid of the loop is the one that is flown in whole.
    pub(crate) fn is_flown_whole(&self) -> bool {
        self.entry.levels == self.entry.flown_levels
    }

    /// Whether where the loop begins and where it should end were both fitted to published rows.
    pub(crate) fn ends_are_fitted(&self) -> bool {
        let ends = [self.published.first(), self.published.last()];
        ends.iter().all(|row| row.is_some_and(|row| row.standing != Standing::Predicted))
    }
}

impl Setup {
    pub(crate) fn read(path: &Path) -> Result<Self> {
        study_file::read(path, Self::of)
    }

    fn of(file: StudyFile, directory: &Path) -> Result<Self> {
        study_file::check_not_empty([("case", file.case.len()), ("variant", file.variant.len())])?;
        file.noise.check()?;
        for variant in &file.variant {
            check_seeds("variant.seeds", variant.seeds)?;
        }
        check_seeds("pooled.seeds", file.pooled.seeds)?;
        for row in &file.published {
            let known = file.case.iter().any(|case| case.table == row.table);
            ensure!(known, "published.table = {}: no case has this table", row.table);
        }
        let cases = file
            .case
            .iter()
            .map(|entry| Case::of(&file, entry, directory).with_context(|| format!("case `{}`", entry.label)));
        let cases = cases.collect::<Result<Vec<_>>>()?;
        let weights = |name: &str| -> Result<_> { Ok(CostFile::read(directory.join(name))?.records) };
        let weights = [weights(&file.files.cost)?, weights(&file.cost_of_chapter4)?];
        let setup = Self { file, cases, weights };
        for case in &setup.cases {
            for variant in &setup.file.variant {
                let place = || format!("{}, {}", case.entry.label, variant.label);
                setup.settings(case, variant)?.validate(case.space.region()).with_context(place)?;
            }
        }
        Ok(setup)
    }

    /// The loop's settings.
    pub(crate) fn settings(&self, case: &Case, variant: &Variant) -> Result<global::Settings> {
        let entry = &case.entry;
        let model = variant.model.model(case.space.region().n_parameters())?;
        let mut settings = entry.batch.settings(model);
        settings.confidence = self.file.rule.confidence;
        settings.correction = Rule::new(self.file.rule.law, self.file.rule.gain);
        settings.max_batches = entry.iterations;
        settings.seed = self.file.rule.seed;
        Ok(settings)
    }
}

impl Case {
    fn of(file: &StudyFile, entry: &CaseEntry, directory: &Path) -> Result<Self> {
        let space = Space::of(&file.parameter, &entry.parameters, entry.levels)?;
        let flown = Space::of(&file.parameter, &entry.parameters, entry.flown_levels).context("flown_levels")?;
        ensure!(entry.parameters.len() >= 2, "parameters: at least two are needed");
        let bat = Bat::read(directory, &file.files, space.variables.clone(), &file.numerics)?;
        let center_of_buoyancy = bat.center_of_buoyancy();

        let rows = file.published.iter().filter(|row| row.table == entry.table).enumerate();
        let rows = rows.map(|(number, row)| {
            ensure!(
                row.iteration == number,
                "published.iteration = {} of Table {}: the rows must be in their order, from 0",
                row.iteration,
                entry.table
            );
            ensure!(
                row.center_of_mass.is_some() != row.cm_cb.is_some(),
                "published: row {number} of Table {} needs either center_of_mass or cm_cb",
                entry.table
            );
            let values = space.variables.iter().zip(space.region().parameters()).map(|(variable, parameter)| {
                let value = row.value(*variable, center_of_buoyancy);
                value.with_context(|| {
                    format!("published: row {number} of Table {} has no {}", entry.table, parameter.name())
                })
            });
            Ok(Row { point: values.collect::<Result<_>>()?, share: row.share, standing: row.standing })
        });
        let published = rows.collect::<Result<Vec<_>>>()?;
        ensure!(
            published.len() == entry.iterations + 1,
            "published: Table {} has {} rows, not one for each of the iterations 0 to {}",
            entry.table,
            published.len(),
            entry.iterations
        );
        Ok(Self { entry: entry.clone(), space, flown, bat, center_of_buoyancy, published })
    }
}

/// The designs of Table 6, row by row, in the order of [`Variable::ALL`].
#[cfg(feature = "calibration")]
pub(crate) fn table_6(root: &Path) -> Result<Vec<[f64; 4]>> {
    let setup = Setup::read(&root.join("fixtures/bat/chapter7.toml"))?;
    let of_table = |case: &&Case| case.entry.table == 6 && case.space.variables == Variable::ALL;
    let case = setup.cases.iter().find(of_table).context("chapter7.toml has no case of Table 6 with all variables")?;
    case.published.iter().map(|row| Ok(row.point.as_slice().try_into()?)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study_file::assert_refused;

    #[track_caller]
    fn refuses(from: &str, to: &str, words: &[&str]) {
        assert_refused("chapter7.toml", Setup::of, [from, to], words);
    }

    #[test]
    fn typos_and_impossible_numbers_are_refused_by_name() {
        refuses("iterations = 3", "iteration = 3", &["unknown field `iteration`"]);
        refuses("iterations = 3", "iterations = 4", &["Table 5 has 4 rows", "0 to 4"]);
        refuses("levels = 24", "levels = 1", &["2 parameters", "levels = 1"]);
        refuses("flown_levels = 10", "flown_levels = 90", &["4 parameters", "flown_levels", "65610000 cells"]);
        refuses("experiments = 12", "experiments = 3", &["2 parameters", "n_experiments", "at least 4"]);
        refuses("simulations = 36", "simulations = 14", &["4 parameters, full quadratic", "n_simulations"]);
        refuses("experiment_weight = 0.7", "experiment_weight = -0.7", &["experiment_weight", "-0.7"]);
        refuses("upper = 15.0", "upper = nan", &["pitch_set_point"]);
        refuses("share = 0.01", "share = 1.5", &["noise.share = 1.5"]);
        refuses("seeds = 20", "seeds = 0", &["variant.seeds = 0"]);
        refuses("[pooled]\nseeds = 8", "[pooled]\nseeds = 0", &["pooled.seeds = 0"]);
        refuses("confidence = 0.9", "confidence = 0.4", &["confidence"]);
        refuses("constant = 0.5 ", "constant = 2.5 ", &["2.5"]);
        refuses("law = \"proof_recursion\"", "law = \"mine\"", &["`mine`"]);
        refuses("\"horizontal_area\", ", "\"horizontal\", ", &["`horizontal` is no [[parameter]]"]);
    }

    #[test]
    fn published_rows_that_do_not_fit_are_refused() {
        refuses("table = 5\niteration = 0", "table = 7\niteration = 0", &["published.table = 7"]);
        refuses("table = 5\niteration = 1", "table = 5\niteration = 2", &["published.iteration = 2 of Table 5"]);
        refuses("center_of_mass = 45.7\n", "", &["row 0 of Table 5", "either center_of_mass or cm_cb"]);
        refuses("horizontal_area = 0.8\n", "", &["row 0 of Table 6 has no horizontal_area"]);
        refuses("standing = \"calibrated\"", "standing = \"reproduced\"", &["`reproduced`"]);
    }

    #[test]
    fn both_forms_of_the_center_of_mass_are_one() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/bat/chapter7.toml");
        let setup = Setup::read(&path).expect("the study file");
        let [two, four] = [0, 1].map(|case| &setup.cases[case]);
        assert_eq!([two.space.n_cells(), four.space.n_cells(), four.flown.n_cells()], [576, 331_776, 10_000]);
        assert!((two.published[3].point[0] - 49.53).abs() < 1e-12, "as printed");
        // Table 6, last row: 5.09 % behind the center of buoyancy at 45.4 %.
        assert!((four.published[5].point[0] - 50.49).abs() < 1e-9, "{:?}", four.published[5]);
        assert_eq!(two.published[3].standing, Standing::DesignCalibrated);
        assert!(four.published.iter().all(|row| row.standing == Standing::Predicted), "all of Table 6");
    }
}
