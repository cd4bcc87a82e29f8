//! The experiments around an optimum, and the slopes that follow from them.

use design_space::Region;
use serde::{Deserialize, Serialize};

use crate::gradient::settings::{BoundPolicy, Settings};
use crate::gradient::slope::{Side, slope};
use crate::ledger::{Ledger, Numbered, Record, ids_after};
use crate::made::{NEAR_THE_REGION, is_near};
use crate::{Error, TrialId};

/// Place of a trial in the design around the optimum; parameters by their index in the region.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TrialRole {
    /// The numerical optimum p* itself.
    Center,
    /// p* with this parameter one experiment step higher.
    Plus(usize),
    /// p* with this parameter one experiment step lower.
    Minus(usize),
}

/// An experiment to run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Trial {
    /// Number under which its outcome is reported.
    pub id: TrialId,
    /// Iteration it belongs to, from 1.
    pub iteration: usize,
    /// Place in the design.
    pub role: TrialRole,
    /// Settings, natural coordinates.
    pub point: Vec<f64>,
}

impl Numbered for Trial {
    fn id(&self) -> TrialId {
        self.id
    }
}

/// A trial of the gradient loop with what is known of it. `actual` is the setting really made of the parameter that the
/// trial varies, in its unit.
pub type TrialRecord = Record<Trial, f64>;

/// The trials of an iteration.
pub(crate) type Trials = Ledger<Trial, f64>;

/// The trials of this iteration around its optimum, the optimum first, numbered on from the `n_asked` before.
pub(crate) fn experiments_around(
    optimum: &[f64],
    region: &Region,
    settings: &Settings,
    iteration: usize,
    n_asked: u64,
) -> Trials {
    let center = (TrialRole::Center, optimum.to_vec());
    let around = sides(optimum, &settings.experiment_steps, region, settings.bound_policy);
    let points = std::iter::once(center).chain(around);
    Ledger::of(ids_after(n_asked).zip(points).map(|(id, (role, point))| Trial { id, iteration, role, point }))
}

/// Whether a setting that was made can be that of this trial around this optimum: on its side, and no farther outside of the bounds of
/// its parameter than half their width, as rigs are; what is farther is a slip.
pub(crate) fn check_actual(trial: &Trial, actual: f64, optimum: &[f64], region: &Region) -> Result<(), Error> {
    let refused = |expected| Err(Error::ActualSetting { id: trial.id, actual, expected });
    let (index, is_on_its_side, expected) = match trial.role {
        TrialRole::Center => return refused("none: the center varies no parameter"),
        TrialRole::Plus(index) => (index, actual > optimum[index], "a number above the center's"),
        TrialRole::Minus(index) => (index, actual < optimum[index], "a number below the center's"),
    };
    if !is_on_its_side || !actual.is_finite() {
        return refused(expected);
    }
    match is_near(&region.parameters()[index], actual) {
        true => Ok(()),
        false => refused(NEAR_THE_REGION),
    }
}

/// What the experiments of an iteration say of its optimum.
#[derive(Debug)]
pub(crate) struct Measured {
    /// The response at the optimum itself; unknown if that trial failed.
    pub(crate) cost: Option<f64>,
    /// Its slope there per unit of each parameter; unknown where too many trials failed.
    pub(crate) gradient: Vec<Option<f64>>,
}

impl Measured {
    pub(crate) fn around(optimum: &[f64], trials: &[TrialRecord]) -> Self {
        let cost = with_role(trials, TrialRole::Center).and_then(Record::cost);
        Self { cost, gradient: slopes(cost, optimum, trials) }
    }
}

fn slopes(center: Option<f64>, optimum: &[f64], trials: &[TrialRecord]) -> Vec<Option<f64>> {
    let side = |role| with_role(trials, role).and_then(|record| side(record, optimum));
    (0..optimum.len()).map(|index| slope(center, side(TrialRole::Plus(index)), side(TrialRole::Minus(index)))).collect()
}

fn with_role(trials: &[TrialRecord], role: TrialRole) -> Option<&TrialRecord> {
    trials.iter().find(|record| record.trial.role == role)
}

/// Measured response and distance from the center of a trial beside it.
fn side(record: &TrialRecord, optimum: &[f64]) -> Option<Side> {
    let (TrialRole::Plus(index) | TrialRole::Minus(index)) = record.trial.role else {
        return None;
    };
    let cost = record.cost()?;
    let setting = record.actual.unwrap_or(record.trial.point[index]);
    Some(Side { distance: (setting - optimum[index]).abs(), cost })
}

/// The sides of the design around a point: two per parameter, except where a step would leave the
/// region and must not.
fn sides(point: &[f64], steps: &[f64], region: &Region, policy: BoundPolicy) -> Vec<(TrialRole, Vec<f64>)> {
    let mut sides = Vec::with_capacity(2 * point.len());
    for (index, (parameter, &step)) in region.parameters().iter().zip(steps).enumerate() {
        for (role, setting) in
            [(TrialRole::Plus(index), point[index] + step), (TrialRole::Minus(index), point[index] - step)]
        {
            if policy == BoundPolicy::StepOutside || parameter.contains(setting) {
                let mut side = point.to_vec();
                side[index] = setting;
                sides.push((role, side));
            }
        }
    }
    sides
}
