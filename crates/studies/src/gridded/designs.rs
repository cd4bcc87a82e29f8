//! The designs of batches, each searched for once: campaigns share them in memory, and runs share them on disk.
//!
//! Which cells a batch runs depends on the space, the regressor, the numbers of runs, the seed, the number of the batch and
//! the cells that are left; not on any cost, so that campaigns with other noise, another law of correction or another truth
//! often need the same one. A search takes a second, everything else of an iteration a hundredth of it.
//!
//! Nothing that a page proves is taken from disk: surfaces, tests, corrections and the efficiencies of the designs are
//! computed anew in every run. Of the designs that are kept with the sources a sample is searched for anew.

use std::collections::HashMap;
use std::fs::{self, File, OpenOptions};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use anyhow::{Context as _, Result};
use design_space::{Parameter, Region};
use doe::Model;
use infuse::global::{self, Plan};

use crate::costs::key::Key;
use crate::kept;

/// To be raised with every change of a search that [`fingerprint`] may not see: of the designs of large sets, of repeats, of
/// what is done when no search finds a design.
const VERSION: &str = "designs 1";

/// Settings that no design depends on. One that is not listed here counts.
const WITHOUT_INFLUENCE: [&str; 9] = [
    "surfaces",
    "experiment_weight",
    "simulation_weight",
    "confidence",
    "first_screening",
    "correction",
    "fallback",
    "split",
    "max_batches",
];

/// Designs by what they follow from.
#[derive(Debug)]
pub(crate) struct Designs {
    path: PathBuf,
    state: Mutex<State>,
}

#[derive(Debug)]
struct State {
    known: HashMap<String, Plan>,
    /// Of those that are kept with the sources, the ones that are to be searched for anew.
    sample: HashMap<String, Plan>,
    file: File,
    n_searched: usize,
}

impl Designs {
    /// The designs that are kept in a folder, in a file named after what this program's searches find, and those that are
    /// kept with the sources, if they are of the same searches.
    pub(crate) fn keep_in(directory: &Path, kept: Option<&Path>) -> Result<Self> {
        fs::create_dir_all(directory).with_context(|| directory.display().to_string())?;
        let name = format!("{}.tsv", fingerprint()?);
        let path = directory.join(&name);
        let mut known: HashMap<String, Plan> = read_in_order(&path).into_iter().collect();
        let mut sample = HashMap::new();
        for (number, (key, plan)) in
            kept.map(|folder| read_in_order(&folder.join(&name))).unwrap_or_default().into_iter().enumerate()
        {
            if number % kept::SAMPLE == 0 {
                sample.insert(key.clone(), plan.clone());
            }
            known.insert(key, plan);
        }
        let file = OpenOptions::new().append(true).create(true).open(&path);
        let file = file.with_context(|| path.display().to_string())?;
        Ok(Self { path, state: Mutex::new(State { known, sample, file, n_searched: 0 }) })
    }

    /// The designs of the batch that a campaign comes to next; none after its end. The campaign must not have been refused
    /// a batch because of failed simulations: then it avoids cells that nobody else does.
    pub(crate) fn next(&self, campaign: &global::Loop) -> Result<Option<Plan>> {
        if campaign.stop().is_some() {
            return Ok(None);
        }
        // A careful campaign minds what it has run, which no key knows.
        if campaign.settings().careful {
            return Ok(campaign.plan()?);
        }
        let key = key(campaign)?;
        if let Some(first) = self.state().sample.remove(&key) {
            let anew = campaign.plan()?;
            kept::ensure_same(&format!("the design {key}"), &Some(first), &anew)?;
        }
        if let Some(known) = self.state().known.get(&key) {
            return Ok(Some(known.clone()));
        }
        let plan = campaign.plan()?;
        if let Some(plan) = &plan {
            self.note(key, plan)?;
        }
        Ok(plan)
    }

    /// How many designs were searched for in this run.
    #[cfg(test)]
    pub(super) fn n_searched(&self) -> usize {
        self.state().n_searched
    }

    fn note(&self, key: String, plan: &Plan) -> Result<()> {
        // Begun with the end of a line, so that one that was torn spoils no other.
        let line = format!("\n{key}\t{}\n", serde_json::to_string(plan)?);
        let mut state = self.state();
        state.n_searched += 1;
        if state.known.insert(key, plan.clone()).is_none() {
            state.file.write_all(line.as_bytes()).with_context(|| self.path.display().to_string())?;
        }
        Ok(())
    }

    /// Held for look-ups and notes only, never during a search.
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The designs of a file; none where there is none.
fn read_in_order(path: &Path) -> Vec<(String, Plan)> {
    fs::read_to_string(path).unwrap_or_default().lines().filter_map(read_line).collect()
}

fn read_line(line: &str) -> Option<(String, Plan)> {
    let (key, plan) = line.split_once('\t')?;
    Some((key.to_owned(), serde_json::from_str(plan).ok()?))
}

/// A name for everything that the next designs of a campaign follow from.
fn key(campaign: &global::Loop) -> Result<String> {
    let mut settings = serde_json::to_value(campaign.settings())?;
    if let Some(settings) = settings.as_object_mut() {
        WITHOUT_INFLUENCE.iter().for_each(|name| drop(settings.remove(*name)));
        settings.insert("candidate_limit".to_owned(), campaign.settings().candidate_limit().into());
    }
    let mut left = Vec::new();
    campaign.retained().cells().for_each(|cell| left.extend_from_slice(&cell.index().to_le_bytes()));
    let key = Key::default()
        .with(serde_json::to_string(campaign.region())?)
        .with(settings.to_string())
        .with((campaign.reports().len() as u64).to_le_bytes())
        .with(left);
    Ok(key.name())
}

/// A name for the searches of this program, made of what they find in the spaces of the case study.
fn fingerprint() -> Result<String> {
    let mut key = Key::default().with(VERSION);
    for (n_factors, levels, n_experiments, n_simulations) in [(2, 24, 12, 24), (4, 10, 18, 36)] {
        let parameter =
            |factor: usize| Parameter::continuous(format!("x{factor}"), "1", -1.0, 1.0)?.with_levels(levels);
        let region = Region::new((0..n_factors).map(parameter).collect::<Result<_, _>>()?)?;
        for model in [Model::additive_quadratic(n_factors)?, Model::quadratic(n_factors)?] {
            let settings = global::Settings::new(model, n_experiments, n_simulations);
            key = key.with(serde_json::to_string(&global::Loop::new(&region, settings)?.plan()?)?);
        }
    }
    Ok(key.name())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn designs_follow_from_what_is_left_and_not_from_what_is_done_with_them() {
        let parameter = |name: &str| Parameter::continuous(name, "1", -1.0, 1.0)?.with_levels(7);
        let region = Region::new(vec![parameter("a").expect("levels"), parameter("b").expect("levels")]).expect("two");
        let settings = global::Settings::new(Model::additive_quadratic(2).expect("a model"), 12, 24);
        let key_with = |change: &dyn Fn(&mut global::Settings)| {
            let mut changed = settings.clone();
            change(&mut changed);
            key(&global::Loop::new(&region, changed).expect("a campaign")).expect("a name")
        };
        let base = key_with(&|_| {});
        assert_eq!(base, key_with(&|settings| settings.confidence = 0.7));
        assert_eq!(base, key_with(&|settings| settings.max_batches = 3));
        assert_ne!(base, key_with(&|settings| settings.seed = 2));
        assert_ne!(base, key_with(&|settings| settings.n_experiments = 13));
        assert_ne!(base, key_with(&|settings| settings.candidate_limit = Some(1000)));
    }
}
