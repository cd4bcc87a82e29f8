//! Every experiment that was handed out, and what was told about it: the same for every method.

use std::collections::BTreeMap;

use anyhow::{Context as _, Result, bail, ensure};
use design_space::Region;
use infuse::TrialId;
use infuse::global::PureError;
use infuse::pooled::Trial;
use rand::seq::SliceRandom as _;
use rand::{RngExt as _, SeedableRng as _};
use rand_pcg::Pcg64;

use super::reading::Reading;
use crate::journal::{Measured, Told};
use crate::problem::Response;

/// The experiments of a campaign.
#[derive(Debug, Clone)]
pub(crate) struct Experiments {
    region: Region,
    /// The parameters that make a plant, the dearest to change first: its runs are made one after the other.
    plant: Vec<usize>,
    /// Every experiment that was ever handed out, by id.
    pub(crate) trials: BTreeMap<u64, Trial>,
    /// What was told about them.
    pub(crate) readings: BTreeMap<u64, Reading>,
    /// The sheets of a batch, as the journal has them, where not only the one with the usual name was written.
    sheets: BTreeMap<usize, Vec<String>>,
}

impl Experiments {
    pub(crate) fn of(region: &Region, plant: &[usize]) -> Self {
        let (trials, readings, sheets) = (BTreeMap::new(), BTreeMap::new(), BTreeMap::new());
        Self { region: region.clone(), plant: plant.to_vec(), trials, readings, sheets }
    }

    /// Notes where the experiments of a batch stand.
    pub(crate) fn note_sheet(&mut self, batch: usize, path: String) {
        self.sheets.entry(batch).or_default().push(path);
    }

    /// The sheets of a batch, the last one last; none where it has the one with the usual name alone.
    pub(crate) fn sheets_of(&self, batch: usize) -> &[String] {
        self.sheets.get(&batch).map_or(&[], Vec::as_slice)
    }

    /// Notes these as handed out.
    pub(crate) fn hand_out(&mut self, trials: impl IntoIterator<Item = Trial>) {
        self.trials.extend(trials.into_iter().map(|trial| (trial.id.number(), trial)));
    }

    /// Writes down what was told; an error says why it cannot be.
    pub(crate) fn tell(&mut self, told: Told) -> Result<()> {
        let Told { id, result, constrained, actual, repeat, corrects, note, .. } = told;
        ensure!(self.trials.contains_key(&id), "experiment {id} was never asked for");
        if let Some(name) = actual.keys().find(|name| self.region.index_of(name).is_none()) {
            bail!("experiment {id}: `actual` has `{name}`, expected names of parameters");
        }
        let reading = self.readings.entry(id).or_default();
        if repeat > 0 {
            ensure!(
                corrects || !reading.again.contains_key(&repeat),
                "repeat {repeat} of experiment {id} has a result"
            );
            reading.again.insert(repeat, result);
            reading.constrained.insert(repeat, constrained);
            return Ok(());
        }
        ensure!(reading.first.is_none() || corrects, "experiment {id} has a result");
        reading.first = Some(result);
        reading.constrained.insert(0, constrained);
        reading.actual = actual;
        reading.note = note;
        Ok(())
    }

    pub(crate) fn trial(&self, id: u64) -> Result<&Trial> {
        self.trials.get(&id).with_context(|| format!("experiment {id} was never asked for"))
    }

    pub(crate) fn has_result(&self, id: TrialId) -> bool {
        self.readings.get(&id.number()).is_some_and(|reading| reading.first.is_some())
    }

    /// How many still wait for their result.
    pub(crate) fn n_outstanding(&self) -> usize {
        self.trials.values().filter(|trial| !self.has_result(trial.id)).count()
    }

    /// How many of a batch have not been told of.
    pub(crate) fn n_outstanding_of(&self, batch: usize) -> usize {
        self.trials.values().filter(|trial| trial.batch == batch && !self.has_result(trial.id)).count()
    }

    /// The batches that wait for experiments, first the one that was handed out first.
    pub(crate) fn open_batches(&self) -> Vec<usize> {
        let mut open: Vec<usize> =
            self.trials.values().filter(|trial| !self.has_result(trial.id)).map(|trial| trial.batch).collect();
        open.dedup();
        open
    }

    /// How many were made, with or without a result.
    pub(crate) fn n_made(&self) -> usize {
        self.readings.values().filter(|reading| reading.first.is_some()).count()
    }

    /// How many were made and gave no value.
    pub(crate) fn n_failed(&self) -> usize {
        self.readings.values().filter(|reading| reading.first.is_some() && reading.values().count() == 0).count()
    }

    /// Further runs of experiments at the same settings.
    pub(crate) fn n_further_runs(&self) -> usize {
        self.readings.values().map(|reading| reading.again.len()).sum()
    }

    /// The number of the batch that was handed out last.
    pub(crate) fn last_batch(&self) -> Option<usize> {
        self.trials.values().next_back().map(|trial| trial.batch)
    }

    /// The trials of a batch in the order in which they are to be run, each with the one that it repeats.
    pub(crate) fn in_run_order(&self, batch: usize, seed: u64) -> Vec<(Trial, Option<u64>)> {
        let own = self.trials.values().filter(|trial| trial.batch == batch);
        let mut trials: Vec<_> = own.map(|trial| (trial.clone(), self.repeated(trial))).collect();
        let mut generator = Pcg64::seed_from_u64(seed);
        for _ in 0..batch {
            generator = Pcg64::seed_from_u64(generator.random());
        }
        trials.shuffle(&mut generator);
        // In random order what is dearest to change, for each setting of it in random order what is next dearest, and so on
        // down to what is run on each plant: nothing dear is changed twice.
        let plant = |trial: &Trial| self.plant.iter().map(|&place| trial.point[place].to_bits()).collect::<Vec<u64>>();
        let mut begun: Vec<Vec<u64>> = Vec::new();
        for (trial, _) in &trials {
            let whole = plant(trial);
            for part in (1..=whole.len()).map(|n| &whole[..n]) {
                if !begun.iter().any(|other| other == part) {
                    begun.push(part.to_vec());
                }
            }
        }
        trials.sort_by_cached_key(|(trial, _)| {
            let whole = plant(trial);
            let place = |n: usize| begun.iter().position(|other| *other == whole[..n]);
            (1..=whole.len()).map(place).collect::<Vec<_>>()
        });
        for of_plant in trials.chunk_by_mut(|(a, _), (b, _)| plant(a) == plant(b)) {
            part_repeats(of_plant);
        }
        trials
    }

    /// The first trial at the same settings, of this batch or an earlier one, if this is another.
    fn repeated(&self, trial: &Trial) -> Option<u64> {
        let same = |other: &&Trial| other.cell == trial.cell;
        let first = self.trials.values().find(same)?.id;
        (first < trial.id).then(|| first.number())
    }

    /// The settings that an experiment was made at.
    pub(crate) fn settings_of(&self, id: u64) -> Vec<f64> {
        let Some(trial) = self.trials.get(&id) else { return Vec::new() };
        let actual = self.readings.get(&id).map(|reading| &reading.actual);
        let settings = self.region.parameters().iter().zip(&trial.point);
        let made = |name: &str| actual.and_then(|actual| actual.get(name).copied());
        settings.map(|(parameter, &asked)| made(parameter.name()).unwrap_or(asked)).collect()
    }

    /// The noise of the experiments of the batches up to this one, from all runs at equal settings.
    pub(crate) fn noise_until(&self, batch: usize) -> Option<PureError> {
        let is_meant = |id: &u64| self.trials.get(id).is_some_and(|trial| trial.batch <= batch);
        let meant = self.readings.iter().filter(|(id, _)| is_meant(id));
        PureError::of_readings(meant.flat_map(|(&id, reading)| {
            let settings = self.settings_of(id);
            reading.values().map(move |value| (settings.clone(), value))
        }))
    }

    /// The experiment with the best mean, and that.
    pub(crate) fn best_measured(&self, response: &Response) -> Option<(u64, f64)> {
        let means = self.readings.iter().filter_map(|(&id, reading)| Some((id, reading.outcome(response)?.cost()?)));
        let (id, cost) = means.min_by(|a, b| a.1.total_cmp(&b.1))?;
        Some((id, response.of_cost(cost)))
    }
}

/// Moves runs of equal settings apart where others can stand between them: one directly after the other they would measure the
/// sensor and not the rig.
fn part_repeats(trials: &mut [(Trial, Option<u64>)]) {
    let clashes =
        |trials: &[(Trial, Option<u64>)]| trials.windows(2).filter(|pair| pair[0].0.cell == pair[1].0.cell).count();
    for index in 1..trials.len() {
        if trials[index - 1].0.cell != trials[index].0.cell {
            continue;
        }
        let before = clashes(trials);
        for other in (0..trials.len()).filter(|&other| other != index) {
            trials.swap(index, other);
            if clashes(trials) < before {
                break;
            }
            trials.swap(index, other);
        }
    }
    if clashes(trials) > 0 {
        arrange(trials);
    }
}

/// The same where exchanging two is not enough: run by run the first that may follow, and the settings with most runs as soon as
/// they need every second place that is left.
fn arrange(trials: &mut [(Trial, Option<u64>)]) {
    let mut left = trials.to_vec();
    let mut before = None;
    for place in trials {
        let n_left = |cell| left.iter().filter(|(trial, _)| trial.cell == cell).count();
        let may_follow = |cell| before != Some(cell);
        let presses = left.iter().position(|(trial, _)| may_follow(trial.cell) && 2 * n_left(trial.cell) > left.len());
        let first = presses.or_else(|| left.iter().position(|(trial, _)| may_follow(trial.cell)));
        *place = left.remove(first.unwrap_or(0));
        before = Some(place.0.cell);
    }
}

impl Measured {
    /// The value, if it gave one.
    pub(crate) fn value(&self) -> Option<f64> {
        match self {
            Self::Value(value) => Some(*value),
            Self::Failed(_) => None,
        }
    }
}
