//! The study file of Chapter 6, checked.

use std::path::Path;

use anyhow::{Context as _, Result, ensure};
use bat_dynamics::{Fidelity, FluidInertia, Lift};
use infuse::{
    correction::{Gain, Law, Rule},
    global,
};
use serde::Deserialize;

use crate::bat::{Bat, MODEL};
use crate::gridded::{Regressor, Space};
use crate::reproduction::Extent;
use crate::study_file::{self, BatchEntry, FilesEntry, NumericsEntry, ParameterEntry, check_labels, check_share};

/// The file as written.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct StudyFile {
    pub(crate) title: String,
    files: FilesEntry,
    parameter: Vec<ParameterEntry>,
    space: Vec<SpaceEntry>,
    truth: Vec<TruthEntry>,
    #[serde(rename = "loop")]
    pub(crate) iterations: LoopEntry,
    pub(crate) noise: NoiseLevels,
    variant: Vec<Variant>,
    numerics: NumericsEntry,
}

/// A design space, and how many runs an iteration makes in it.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SpaceEntry {
    pub(crate) label: String,
    parameters: Vec<String>,
    levels: u32,
    full_levels: u32,
    pub(crate) batch: BatchEntry,
}

/// What takes the place of experiments.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct TruthEntry {
    pub(crate) label: String,
    /// For axes and tables.
    pub(crate) short: String,
    stall: bool,
    added_mass: bool,
}

impl TruthEntry {
    /// Its name within a sentence.
    pub(crate) fn with_article(&self) -> String {
        if self.added_mass { format!("the {}", self.label) } else { self.label.clone() }
    }

    /// Whether it is the stand-in for the water channel, and not what the dissertation calls true.
    pub(crate) fn is_ours(&self) -> bool {
        self.added_mass
    }

    pub(crate) fn fidelity(&self) -> Fidelity {
        Fidelity {
            lift: if self.stall { Lift::Stalled } else { Lift::Attached },
            fluid_inertia: if self.added_mass { FluidInertia::Included } else { FluidInertia::Neglected },
        }
    }
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct LoopEntry {
    pub(crate) iterations: usize,
    pub(crate) model: Regressor,
    pub(crate) confidence: f64,
    pub(crate) seed: u64,
}

/// The noise of experiments: its largest shares of the range, each drawn with one seed.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct NoiseLevels {
    pub(crate) shares: Vec<f64>,
    pub(crate) seed: u64,
}

/// One way of correcting; the first is the one that the figures show.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Variant {
    pub(crate) label: String,
    law: Law,
    gain: Gain,
    model: Option<Regressor>,
    only: Option<Only>,
}

impl Variant {
    /// Whether it is run in every space with every noise.
    pub(crate) fn is_general(&self) -> bool {
        self.only.is_none()
    }
}

/// The one space and noise that a variant is run with.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Only {
    space: String,
    noise: f64,
}

/// The study ready to run.
#[derive(Debug)]
pub(crate) struct Setup {
    pub(crate) file: StudyFile,
    pub(crate) spaces: Vec<SpaceSetup>,
}

/// A design space with the flights over it.
#[derive(Debug)]
pub(crate) struct SpaceSetup {
    pub(crate) entry: SpaceEntry,
    pub(crate) space: Space,
    pub(crate) bat: Bat,
}

/// One campaign to run: indices into the spaces, truths and variants, and the noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Case {
    pub(crate) space: usize,
    pub(crate) truth: usize,
    pub(crate) variant: usize,
    pub(crate) noise: f64,
}

impl Setup {
    pub(crate) fn read(path: &Path, extent: Extent) -> Result<Self> {
        study_file::read(path, |file, directory| Self::of(file, directory, extent))
    }

    fn of(file: StudyFile, directory: &Path, extent: Extent) -> Result<Self> {
        study_file::check_not_empty([
            ("space", file.space.len()),
            ("truth", file.truth.len()),
            ("variant", file.variant.len()),
            ("noise.shares", file.noise.shares.len()),
        ])?;
        check_labels("space.label", file.space.iter().map(|space| space.label.clone()))?;
        check_labels("truth.label", file.truth.iter().map(|truth| truth.label.clone()))?;
        check_labels("variant.label", file.variant.iter().map(|variant| variant.label.clone()))?;
        check_labels("noise.shares", file.noise.shares.iter().map(ToString::to_string))?;
        for share in &file.noise.shares {
            check_share("noise.shares", *share)?;
        }
        for only in file.variant.iter().filter_map(|variant| variant.only.as_ref()) {
            let known = file.space.iter().any(|space| space.label == only.space);
            ensure!(known, "variant.only.space = `{}`: no space has this label", only.space);
            let known = file.noise.shares.iter().any(|share| share.to_bits() == only.noise.to_bits());
            ensure!(known, "variant.only.noise = {}: it must be one of noise.shares", only.noise);
        }
        let spaces = file
            .space
            .iter()
            .map(|entry| {
                let of = |levels| {
                    Space::of(&file.parameter, &entry.parameters, levels)
                        .with_context(|| format!("space `{}`", entry.label))
                };
                // Both, so that a slip is not found out after a day.
                let (default, full) = (of(entry.levels)?, of(entry.full_levels).context("full_levels")?);
                let space = if extent == Extent::Full { full } else { default };
                let bat = Bat::read(directory, &file.files, space.variables.clone(), &file.numerics)?;
                Ok(SpaceSetup { entry: entry.clone(), space, bat })
            })
            .collect::<Result<Vec<_>>>()?;
        let setup = Self { file, spaces };
        for case in setup.cases() {
            let region = setup.spaces[case.space].space.region();
            let place = || format!("{}, {}", setup.spaces[case.space].entry.label, setup.variant(case).label);
            setup.settings(case)?.validate(region).with_context(place)?;
        }
        Ok(setup)
    }

    /// The same study on another plant, in the spaces of so many parameters.
    #[cfg(feature = "ensemble")]
    pub(crate) fn on(&self, n_parameters: usize, bat: impl Fn(&Bat) -> Bat) -> Self {
        let mine = self.spaces.iter().filter(|space| space.space.region().n_parameters() == n_parameters);
        let spaces = mine.map(|setup| SpaceSetup {
            entry: setup.entry.clone(),
            space: setup.space.clone(),
            bat: bat(&setup.bat),
        });
        Self { spaces: spaces.collect(), file: self.file.clone() }
    }

    /// Every campaign of the study: all of a space side by side.
    pub(crate) fn cases(&self) -> Vec<Case> {
        let mut cases = Vec::new();
        for (space, truth) in (0..self.spaces.len()).flat_map(|s| (0..self.file.truth.len()).map(move |t| (s, t))) {
            for (variant, entry) in self.file.variant.iter().enumerate() {
                let is_run = |noise: f64| {
                    entry.only.as_ref().is_none_or(|only| {
                        only.space == self.spaces[space].entry.label && only.noise.to_bits() == noise.to_bits()
                    })
                };
                let shares = self.file.noise.shares.iter().copied().filter(|noise| is_run(*noise));
                cases.extend(shares.map(|noise| Case { space, truth, variant, noise }));
            }
        }
        cases
    }

    pub(crate) fn variant(&self, case: Case) -> &Variant {
        &self.file.variant[case.variant]
    }

    /// The one that figures show.
    pub(crate) fn first_variant(&self) -> &Variant {
        &self.file.variant[0]
    }

    /// A case in words.
    pub(crate) fn words(&self, case: Case) -> String {
        let (space, truth) = (&self.spaces[case.space].entry.label, &self.truth(case.truth).label);
        format!("{space}, {truth}, {}, noise {} %", self.variant(case).label, 100.0 * case.noise)
    }

    pub(crate) fn truth(&self, truth: usize) -> &TruthEntry {
        &self.file.truth[truth]
    }

    /// Those of the model and of every truth.
    pub(crate) fn fidelities(&self) -> Vec<Fidelity> {
        std::iter::once(MODEL).chain(self.file.truth.iter().map(TruthEntry::fidelity)).collect()
    }

    pub(crate) fn n_truths(&self) -> usize {
        self.file.truth.len()
    }

    /// The loop's settings in a case.
    pub(crate) fn settings(&self, case: Case) -> Result<global::Settings> {
        let (file, variant) = (&self.file, self.variant(case));
        let SpaceSetup { entry, space, .. } = &self.spaces[case.space];
        let regressor = variant.model.unwrap_or(file.iterations.model);
        let model = regressor.model(space.region().n_parameters())?;
        let mut settings = entry.batch.settings(model);
        settings.confidence = file.iterations.confidence;
        settings.correction = Rule::new(variant.law, variant.gain);
        settings.max_batches = file.iterations.iterations;
        settings.seed = file.iterations.seed;
        Ok(settings)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study_file::assert_refused;

    #[track_caller]
    fn refuses(from: &str, to: &str, words: &[&str]) {
        let check = |file, directory: &Path| Setup::of(file, directory, Extent::Default);
        assert_refused("chapter6.toml", check, [from, to], words);
    }

    #[test]
    fn typos_and_impossible_numbers_are_refused_by_name() {
        refuses("iterations = 33", "iteration = 33", &["unknown field `iteration`"]);
        refuses("iterations = 33", "iterations = 0", &["max_batches", "at least 1"]);
        refuses("levels = 24", "levels = 1", &["levels = 1"]);
        refuses("levels = 10", "levels = 90", &["4 parameters", "65610000 cells", "1000000"]);
        refuses("experiments = 12", "experiments = 3", &["n_experiments", "at least 4"]);
        refuses("upper = 15.0", "upper = nan", &["pitch_set_point"]);
        refuses("shares = [0.0,", "shares = [-0.1,", &["noise.shares", "-0.1"]);
        refuses("constant = 0.1 ", "constant = 2.5 ", &["2.5"]);
        refuses("noise = 0.03", "noise = 0.04", &["variant.only.noise = 0.04", "noise.shares"]);
        refuses("space = \"2 parameters\"", "space = \"3 parameters\"", &["`3 parameters`: no space"]);
        refuses("full_levels = 24", "full_levels = 1", &["full_levels", "levels = 1"]);
        refuses("label = \"k = 0.1\"", "label = \"k = 0.5\"", &["variant.label: k = 0.5 is there twice"]);
        refuses("shares = [0.0, 0.01,", "shares = [0.0, 0.0,", &["noise.shares: 0 is there twice"]);
        refuses("\"horizontal_area\", ", "\"horizontal\", ", &["`horizontal` is no [[parameter]]"]);
    }

    #[test]
    fn the_full_extent_is_the_grid_of_section_7_2() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/bat/chapter6.toml");
        let cells = |extent| {
            let setup = Setup::read(&path, extent).expect("the study file");
            setup.spaces.iter().map(|space| space.space.n_cells()).collect::<Vec<_>>()
        };
        assert_eq!(cells(Extent::Default), [576, 10_000]);
        assert_eq!(cells(Extent::Full), [576, 331_776]);
    }
}
