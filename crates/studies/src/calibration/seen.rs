//! What was found of each plant over the box, kept beside it: the page takes some two thousand flights of each, and a check flies
//! those of one in fifty.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, ensure};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::candidate::{Candidate, Spot};
use super::evidence::Evidence;
use super::file::Calibration;
use super::landscape::{Diagnostics, Landscape};
use super::outcome::Member;
use super::store::ENSEMBLE;
use crate::bat::STAND_IN;
use crate::costs::key::Key;
use crate::seal::{self, Form};
use crate::{chapter7, kept};

const NAME: &str = "seen.jsonl";
const REMEDY: &str = "run `cargo xtask calibrate --page`";
/// Which of the kept plants a check flies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Look {
    /// One of so many in turn.
    AtSome,
    AtAll,
}

impl Look {
    const fn step(self) -> usize {
        match self {
            Self::AtSome => kept::SAMPLE,
            Self::AtAll => 1,
        }
    }
}

/// Fits differ in their last digits where processors add in another order.
const ROUNDING: f64 = 1e-9;

/// What was found of one plant.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Seen {
    /// Where each optimum of the evidence is, and its cost; where the evidence is a cost, that alone.
    pub(super) evidence: Vec<(Option<[f64; 2]>, f64)>,
    pub(super) held_out: Vec<f64>,
    /// In the stand-in, row by row; none where a flight failed.
    pub(super) table_6: Vec<Option<f64>>,
    /// Of each study.
    pub(super) diagnostics: [Diagnostics; 2],
}

/// Plants, and what decides of what is found of them.
pub(super) struct Plants<'a> {
    calibration: &'a Calibration,
    candidates: Vec<Candidate>,
    /// The designs of Table 6.
    table_6: Vec<[f64; 4]>,
    path: PathBuf,
    key: String,
}

impl<'a> Plants<'a> {
    pub(super) fn new(root: &Path, calibration: &'a Calibration, members: &[Member]) -> Result<Self> {
        let table_6 = chapter7::table_6(root)?;
        let key = Key::default().with(calibration.shape(root)?.key).with(format!("{members:?} {table_6:?}"));
        let candidates = calibration.candidates(members)?;
        Ok(Self { calibration, candidates, table_6, path: root.join(ENSEMBLE).join(NAME), key: key.name() })
    }

    /// Flies them all, and keeps what was found.
    pub(super) fn see_all(&self) -> Result<Vec<Seen>> {
        let seen: Vec<Seen> = self.candidates.par_iter().map(|plant| self.see(plant)).collect::<Result<_>>()?;
        let lines = seen.iter().map(|seen| Ok(serde_json::to_string(seen)? + "\n")).collect::<Result<String>>()?;
        kept::replace(&self.path, seal::sealed(Form::Json, &self.key, &lines).as_bytes())?;
        Ok(seen)
    }

    /// What is kept, if the plants that are looked at still fly as it says.
    pub(super) fn look_up(&self, look: Look) -> Result<Vec<Seen>> {
        let kept = self.read()?;
        let some: Vec<usize> = (0..kept.len()).step_by(look.step()).collect();
        let anew: Vec<Seen> = some.par_iter().map(|index| self.see(&self.candidates[*index])).collect::<Result<_>>()?;
        for (index, anew) in some.iter().zip(&anew) {
            let (line, path) = (index + 2, self.path.display());
            ensure!(
                kept[*index].agrees_with(anew),
                "{path}: line {line}: kept is {:?}, found {anew:?}; {REMEDY}",
                kept[*index]
            );
        }
        Ok(kept)
    }

    fn read(&self) -> Result<Vec<Seen>> {
        let path = &self.path;
        let text = std::fs::read_to_string(path).with_context(|| format!("{}; {REMEDY}", path.display()))?;
        let opened = seal::open(path, Form::Json, &text, &self.key, REMEDY)?;
        opened.check_key(path, &self.key, || format!(": the plants or their files have changed since; {REMEDY}"))?;
        opened.check_sum(path, REMEDY)?;
        let seen: Vec<Seen> = opened
            .rows
            .lines()
            .zip(2..)
            .map(|(line, number)| {
                serde_json::from_str(line).with_context(|| format!("{}: line {number}; {REMEDY}", path.display()))
            })
            .collect::<Result<_>>()?;
        let (n, needed) = (seen.len(), self.candidates.len());
        ensure!(n == needed, "{}: {n} plants of {needed}; {REMEDY}", path.display());
        Ok(seen)
    }

    fn see(&self, candidate: &Candidate) -> Result<Seen> {
        let calibration = self.calibration;
        let landscape = Landscape::fly(calibration, candidate);
        let cost_of = |evidence: &Evidence| -> Result<f64> {
            let flown = calibration.fly(candidate, &evidence.spots()[..1]).pop().flatten();
            let flown = flown.with_context(|| format!("{}: it cannot be flown", evidence.label))?;
            Ok(flown.cost(&candidate.weights[evidence.study]))
        };
        let evidence = calibration.evidence.iter().enumerate().map(|(index, evidence)| {
            if evidence.is_optimum {
                let (design, cost) = landscape.lowest(calibration, index, candidate)?;
                Ok((Some(design), cost))
            } else {
                Ok((None, cost_of(evidence)?))
            }
        });
        let path: Vec<Spot> = self.table_6.iter().map(|design| Spot { fidelity: STAND_IN, design: *design }).collect();
        let table_6 =
            calibration.fly(candidate, &path).into_iter().map(|flown| flown.map(|one| one.cost(&candidate.weights[1])));
        let diagnostics = |study: usize| landscape.diagnostics(study, calibration.boxes[study], candidate);
        Ok(Seen {
            evidence: evidence.collect::<Result<_>>()?,
            held_out: calibration.held_out.iter().map(cost_of).collect::<Result<_>>()?,
            table_6: table_6.collect(),
            diagnostics: [diagnostics(0)?, diagnostics(1)?],
        })
    }
}

impl Seen {
    fn agrees_with(&self, other: &Self) -> bool {
        let [here, there] = [self.numbers(), other.numbers()];
        let is_near = |a: f64, b: f64| (a - b).abs() <= ROUNDING * a.abs().max(b.abs());
        here.len() == there.len()
            && here.iter().zip(&there).all(|pair| match pair {
                (Some(a), Some(b)) => is_near(*a, *b),
                (a, b) => a.is_none() && b.is_none(),
            })
    }

    /// All of them in one order; none where there is none.
    fn numbers(&self) -> Vec<Option<f64>> {
        let evidence = self.evidence.iter().flat_map(|(design, cost)| {
            let [x, y] = [0, 1].map(|k| design.map(|design| design[k]));
            [x, y, Some(*cost)]
        });
        let diagnostics = self.diagnostics.iter().flat_map(|found| {
            let Diagnostics { rank_correlation, better_than_model, additive_fit, quadratic_fit } = *found;
            [rank_correlation, better_than_model, additive_fit, quadratic_fit].map(Some)
        });
        let costs = self.held_out.iter().map(|cost| Some(*cost)).chain(self.table_6.iter().copied());
        evidence.chain(costs).chain(diagnostics).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seen(cost: f64, failed: bool) -> Seen {
        let found =
            Diagnostics { rank_correlation: 0.5, better_than_model: 0.9, additive_fit: 0.7, quadratic_fit: 0.8 };
        Seen {
            evidence: vec![(Some([48.0, 7.0]), cost), (None, 5.0)],
            held_out: vec![6.0],
            table_6: vec![(!failed).then_some(4.0)],
            diagnostics: [found; 2],
        }
    }

    #[test]
    fn a_plant_agrees_with_itself_as_it_is_written_and_with_no_other() {
        let before = seen(0.1 + 0.2, true);
        let line = serde_json::to_string(&before).expect("a line");
        let after: Seen = serde_json::from_str(&line).expect("what was written");
        assert!(before.agrees_with(&after) && before.numbers() == after.numbers());
        assert!(!before.agrees_with(&seen(0.1 + 0.2, false)), "a flight that failed");
        assert!(!before.agrees_with(&seen(0.3001, true)), "another cost");
        assert!(before.agrees_with(&seen((0.1 + 0.2) * (1.0 + 1e-12), true)), "another order of a sum");
    }
}
