//! The study file of Chapter 4, checked.

use std::path::Path;

use anyhow::{Context as _, Result, ensure};
use design_space::Region;
use infuse::{CodesignProblem, Role, correction::Form, gradient};
use serde::Deserialize;

use crate::bat::Bat;
use crate::study_file::{self, FilesEntry, NoiseEntry, NumericsEntry, check_positive};
use crate::variable::{Variable, point_words};

/// The file as written.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct StudyFile {
    pub(crate) title: String,
    pub(crate) files: FilesEntry,
    parameter: Vec<LoopParameter>,
    #[serde(rename = "loop")]
    iterations: LoopEntry,
    pub(crate) variant: Vec<Variant>,
    pub(crate) noise: NoiseEntry,
    numerics: NumericsEntry,
    pub(crate) published: Vec<Table3Row>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct LoopParameter {
    name: String,
    unit: String,
    role: Role,
    lower: f64,
    upper: f64,
    pub(crate) experiment_step: f64,
    model_step: f64,
    tolerance: f64,
    pub(crate) table_step: f64,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct LoopEntry {
    iterations: usize,
    bound_policy: gradient::BoundPolicy,
}

/// One set of loop settings; the first is the one that the dissertation prints.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Variant {
    pub(crate) label: String,
    trust: f64,
    move_limits: Option<Vec<f64>>,
    #[serde(default)]
    form: Form,
    /// Whether it is run over the noise seeds too.
    #[serde(default = "yes")]
    pub(crate) with_noise: bool,
}

fn yes() -> bool {
    true
}

/// A row of Table 3 as printed.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Table3Row {
    pub(crate) center_of_mass: f64,
    pub(crate) pitch_set_point: f64,
    pub(crate) corrected_cost: f64,
    pub(crate) experiment_cost: f64,
}

impl Table3Row {
    pub(crate) fn point(&self) -> [f64; 2] {
        [self.center_of_mass, self.pitch_set_point]
    }
}

/// Flights of one landscape: more would take hours and gigabytes.
const MOST_LATTICE_POINTS: f64 = 100_000.0;

/// The study ready to run.
#[derive(Debug)]
pub(crate) struct Setup {
    pub(crate) file: StudyFile,
    pub(crate) bat: Bat,
    pub(crate) problem: CodesignProblem,
}

impl Setup {
    pub(crate) fn read(path: &Path) -> Result<Self> {
        study_file::read(path, Self::of)
    }

    pub(super) fn of(file: StudyFile, directory: &Path) -> Result<Self> {
        ensure!(file.parameter.len() == 2, "parameter: {} entries, Chapter 4 has two", file.parameter.len());
        study_file::check_not_empty([("variant", file.variant.len())])?;
        ensure!(file.published.len() >= 2, "published: {} rows, at least two are needed", file.published.len());
        file.noise.check()?;
        for entry in &file.parameter {
            check_positive(&format!("parameter `{}`: table_step", entry.name), entry.table_step)?;
        }
        let pairs = file.parameter.iter().map(|p| Variable::within(&p.name, &p.unit, p.lower, p.upper));
        let (variables, parameters) = pairs.collect::<Result<(Vec<_>, Vec<_>)>>()?;
        let roles = file.parameter.iter().map(|p| p.role).collect();
        let points = file.parameter.iter().map(|p| (p.upper - p.lower) / p.table_step + 3.0).product::<f64>();
        ensure!(
            points <= MOST_LATTICE_POINTS,
            "table_step: the landscapes would take {points:.0} flights each: at most {MOST_LATTICE_POINTS:.0} are allowed"
        );
        let problem = CodesignProblem::new(Region::new(parameters)?, roles)?;
        let bat = Bat::read(directory, &file.files, variables, &file.numerics)?;
        let setup = Self { file, bat, problem };
        for variant in &setup.file.variant {
            setup
                .loop_settings(variant)
                .validate(&setup.problem)
                .with_context(|| format!("variant `{}`", variant.label))?;
        }
        Ok(setup)
    }

    /// The same study on another plant, `coarser` times fewer simulations along each axis of a lattice.
    #[cfg(feature = "ensemble")]
    pub(crate) fn on(&self, bat: Bat, coarser: f64) -> Self {
        let mut file = self.file.clone();
        file.parameter.iter_mut().for_each(|parameter| parameter.table_step *= coarser);
        Self { file, bat, problem: self.problem.clone() }
    }

    /// The loop's settings in a variant.
    pub(crate) fn loop_settings(&self, variant: &Variant) -> gradient::Settings {
        let each = |f: fn(&LoopParameter) -> f64| self.file.parameter.iter().map(f).collect::<Vec<_>>();
        let mut settings =
            gradient::Settings::new(vec![variant.trust; self.file.parameter.len()], each(|p| p.experiment_step));
        settings.model_steps = Some(each(|p| p.model_step));
        settings.tolerances = Some(each(|p| p.tolerance));
        settings.move_limits.clone_from(&variant.move_limits);
        settings.correction_form = variant.form;
        settings.bound_policy = self.file.iterations.bound_policy;
        settings.max_iterations = self.file.iterations.iterations;
        settings
    }

    pub(crate) fn parameters(&self) -> &[LoopParameter] {
        &self.file.parameter
    }

    /// RK4 steps per sample: in searches and landscapes, and for reported designs.
    pub(crate) fn steps_per_sample(&self) -> [usize; 2] {
        self.file.numerics.steps()
    }

    /// The experiment steps in words.
    pub(crate) fn experiment_steps(&self) -> String {
        let step = |p: &LoopParameter| format!("{} {} in {}", p.experiment_step, p.unit, p.name.replace('_', " "));
        self.file.parameter.iter().map(step).collect::<Vec<_>>().join(", ")
    }

    /// Parameter `k`.
    pub(crate) fn variable(&self, k: usize) -> Variable {
        self.bat.variables()[k]
    }

    /// A design with its units, in a list.
    pub(crate) fn words(&self, point: &[f64]) -> String {
        point_words(self.bat.variables(), point).join(", ")
    }

    /// The same in a sentence.
    pub(crate) fn sentence(&self, point: &[f64]) -> String {
        point_words(self.bat.variables(), point).join(" and ")
    }

    /// Bounds of parameter `k`.
    pub(crate) fn bounds(&self, k: usize) -> (f64, f64) {
        (self.file.parameter[k].lower, self.file.parameter[k].upper)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study_file::assert_refused;

    #[track_caller]
    fn refuses(from: &str, to: &str, words: &[&str]) {
        assert_refused("chapter4.toml", Setup::of, [from, to], words);
    }

    #[test]
    fn bad_study_files_name_the_field_and_what_is_allowed() {
        refuses("iterations = 3", "iteration = 3", &["iteration", "unknown field"]);
        refuses("lower = 45.65", "lower = 55.0", &["center_of_mass", "55"]);
        refuses("unit = \"deg\"", "unit = \"rad\"", &["pitch_set_point", "`rad`", "`deg`"]);
        refuses("share = 0.02", "share = nan", &["noise", "NaN"]);
        refuses("trust = 0.3", "trust = -0.3", &["R = 0.3", "-0.3"]);
        refuses("table_step = 0.5", "table_step = 0.0", &["pitch_set_point", "table_step"]);
        refuses("table_step = 0.5", "table_step = 1e-9", &["table_step", "100000"]);
        refuses("rig = \"rig.toml\"", "rig = \"no-such.toml\"", &["no-such.toml"]);
        refuses("name = \"pitch_set_point\"", "name = \"pitch\"", &["`pitch`", "pitch_set_point"]);
    }

    /// What a study would not weigh is refused, not left out in silence.
    #[test]
    fn weight_of_net_energy_is_refused() {
        let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/bat");
        let folder = tempfile::tempdir().unwrap();
        for name in ["chapter4.toml", "rig.toml", "test-profile.toml", "cost-chapter4.toml"] {
            std::fs::copy(fixtures.join(name), folder.path().join(name)).unwrap();
        }
        assert!(Setup::read(&folder.path().join("chapter4.toml")).is_ok());
        let cost = folder.path().join("cost-chapter4.toml");
        let energy =
            "k8_net_energy = { value = 0.5, unit = \"1/W\", provenance = \"estimated\", source = \"a test\" }\n";
        std::fs::write(&cost, std::fs::read_to_string(&cost).unwrap() + energy).unwrap();
        let error = format!("{:#}", Setup::read(&folder.path().join("chapter4.toml")).unwrap_err());
        assert!(error.contains("cost-chapter4.toml") && error.contains("`k8_net_energy` is 0.5"), "{error}");
    }
}
