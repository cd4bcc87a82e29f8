//! A few runs at the recommended design, the best measured and the simulation's own choice, which measure what was gained.

use std::borrow::Cow;

use anyhow::{Context as _, Result, ensure};
use design_space::Cell;
use infuse::global::PureError;
use page::Finding;
use serde::Serialize;
use statrs::distribution::{ContinuousCDF as _, StudentsT};

use super::bands::NINE_IN_TEN;
use super::best::has_shifts;
use super::campaign::{Batch, Campaign, Origin};
use super::findings::as_it_stands;
use super::hand_out::plan;
use crate::journal::{Measured, Purpose, Writer};
use crate::number::count;
use crate::problem::Response;

/// Probability that the interval of a difference covers it.
const PROBABILITY: f64 = 0.9;

/// The designs that are compared, first the recommended one.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Confirmation {
    batch: usize,
    /// Standard deviation of the error that runs of a batch share, as far as that is known.
    #[serde(skip)]
    shared: Option<f64>,
    designs: Vec<Confirmed>,
}

/// What the runs of one design gave.
#[derive(Debug, Clone, Serialize)]
struct Confirmed {
    #[serde(skip)]
    cell: Cell,
    settings: serde_json::Value,
    /// Costs.
    #[serde(skip)]
    costs: Vec<f64>,
    n_runs: usize,
    mean: Option<f64>,
    /// Half the width of the interval of the mean, what runs of a batch share included; none without repeats.
    mean_give_or_take: Option<f64>,
    /// By how much the first design is better, with half the width of the interval; none for the first, or without repeats.
    gain: Option<f64>,
    give_or_take: Option<f64>,
}

/// Plans the runs: so many of each design.
pub(super) fn confirm(campaign: &mut Campaign, writer: &mut Writer, runs: usize) -> Result<()> {
    ensure!((1..=1000).contains(&runs), "--runs is {runs}, expected 1 to 1000");
    let outstanding = campaign.experiments.n_outstanding();
    ensure!(
        outstanding == 0,
        "{} waited for: tell their results before the recommended design is confirmed",
        if outstanding == 1 { "1 experiment is".to_owned() } else { format!("{outstanding} experiments are") }
    );
    campaign.check_the_recommended(writer)?;
    let found = campaign.assessment()?.context("no experiment gave a result yet, so there is nothing to confirm")?;
    let mut cells = vec![found.recommended.cell];
    if let Some(measured) = campaign.best_measured(&found) {
        cells.push(match measured.origin {
            Origin::Own(id) => campaign.experiments.trial(id)?.cell,
            Origin::Imported(_) => campaign.nearest(&measured.settings)?.1,
        });
    }
    cells.extend(campaign.choice_of_the_simulation()?.filter(|&cell| campaign.failure_at(cell).is_none()));
    let mut seen = std::collections::BTreeSet::new();
    cells.retain(|&cell| seen.insert(cell));
    let checks = campaign.check(&cells)?;
    if !checks.is_empty() {
        campaign.write_down(writer, checks)?;
    }
    cells.retain(|&cell| campaign.why_not(cell).is_none());
    let repeated = cells.iter().flat_map(|&cell| std::iter::repeat_n(cell, runs)).collect();
    plan(campaign, writer, Batch { cells: repeated, purpose: Some(Purpose::Confirm), reasons: Vec::new() }, Vec::new())
}

impl Campaign {
    /// What the last confirming batch measured, once all of its runs were told.
    pub(super) fn confirmation(&self) -> Result<Option<Confirmation>> {
        let is_meant = |index: &usize| self.batches[*index].purpose == Some(Purpose::Confirm);
        let Some(index) = (0..self.batches.len()).rev().find(is_meant) else {
            return Ok(None);
        };
        let batch = index + 1;
        let own = || self.experiments.trials.values().filter(|trial| trial.batch == batch);
        if own().any(|trial| !self.experiments.has_result(trial.id)) {
            return Ok(None);
        }
        let order = self.compared(batch);
        let response = &self.problem.response;
        let costs_at = |cell: Cell| {
            let at = own().filter(|trial| trial.cell == cell).filter_map(|trial| {
                let reading = self.experiments.readings.get(&trial.id.number())?;
                reading.first.as_ref().and_then(Measured::value)
            });
            at.map(|value| response.cost(value)).collect::<Vec<f64>>()
        };
        let runs: Vec<Vec<f64>> = order.iter().map(|&cell| costs_at(cell)).collect();
        let (noise, shared) = (self.noise_of_repeats()?, self.shared_by_a_batch()?);
        let design = |(place, &cell): (usize, &Cell)| {
            let costs = runs[place].clone();
            let difference = if place == 0 { None } else { difference(&costs, &runs[0], noise) };
            let n_runs = own().filter(|trial| trial.cell == cell).count();
            let mean = mean(&costs).map(|cost| response.of_cost(cost));
            let settings = self.problem.named(&self.grid.point(cell)?);
            let (gain, give_or_take) = (difference.map(|d| d.0), difference.and_then(|d| d.1));
            let half = noise.filter(|_| !costs.is_empty());
            let half = half.and_then(|noise| half_width(noise, 1.0 / costs.len() as f64));
            let mean_give_or_take = half.map(|half| half.hypot(NINE_IN_TEN * shared.unwrap_or(0.0)));
            Ok(Confirmed { cell, settings, costs, n_runs, mean, mean_give_or_take, gain, give_or_take })
        };
        let designs = order.iter().enumerate().map(design).collect::<Result<Vec<_>>>()?;
        Ok(Some(Confirmation { batch, shared, designs }))
    }

    /// The noise of one run, by what all repeats of the campaign differ by, those that confirm among them: as everywhere in the loop it
    /// is the same for all. Runs that are set aside say nothing of it.
    fn noise_of_repeats(&self) -> Result<Option<PureError>> {
        let Some(found) = self.assessment()? else { return Ok(None) };
        let aside = self.set_aside(&found);
        let counted =
            self.origins().into_iter().zip(self.runs_to_compare(&found)).filter(|(origin, _)| !aside.contains(origin));
        Ok(PureError::of_readings(counted.map(|(_, run)| run)))
    }

    /// Standard deviation of the error that all runs of a batch share, taken in or not: the mean of those of one batch has it in it.
    fn shared_by_a_batch(&self) -> Result<Option<f64>> {
        let Some(found) = self.assessment()?.filter(|_| self.settings.plants.is_none()) else { return Ok(None) };
        let drift = found.drift.as_ref().filter(|drift| drift.is_sure());
        Ok(found.assembly.or(drift.map(|drift| drift.deviation)))
    }

    /// The designs of a batch that is to confirm, first the recommended one.
    fn compared(&self, batch: usize) -> Vec<Cell> {
        let mut order: Vec<Cell> = Vec::new();
        for &cell in &self.batches[batch - 1].cells {
            if !order.contains(&cell) {
                order.push(cell);
            }
        }
        order
    }

    /// What a batch is for that is to confirm.
    pub(super) fn to_confirm(&self, batch: usize) -> Finding {
        let order = self.compared(batch);
        let names = Names::of(self);
        let sentence = match order.len() {
            1 if names.are_shifted => {
                "It measures the recommended design, by these runs alone: nothing else measured better (without the shifts of batches)."
            }
            1 => "It measures the recommended design, by these runs alone: nothing else measured better.",
            _ => "It measures what was gained: the designs are compared by these runs alone.",
        };
        let finding = order.iter().enumerate().fold(Finding::new(sentence), |finding, (place, &cell)| {
            let n_runs = self.batches[batch - 1].cells.iter().filter(|&&other| other == cell).count();
            let settings = self.grid.point(cell).map(|point| self.problem.describe(&point)).unwrap_or_default();
            let design = format!("{}: {}, {settings}.", count(n_runs, "run"), names.name(place, cell));
            finding.detail(Finding::new(design).with("runs", n_runs as f64, "1"))
        });
        let failed = names.alone.filter(|alone| !order.contains(alone)).and_then(|alone| self.failure_at(alone));
        failed.into_iter().fold(finding, |finding, reason| {
            finding.detail(Finding::new(format!("The simulation's own choice is left out, as it failed: {reason}.")))
        })
    }
}

/// What the designs of a batch that is to confirm are called.
struct Names {
    /// The simulation's own choice, and whether it is the best of some only.
    alone: Option<Cell>,
    is_of_some: bool,
    /// What is to be said of that choice.
    stands: Option<&'static str>,
    /// Whether results are compared without what their batches are off by.
    are_shifted: bool,
}

impl Names {
    fn of(campaign: &Campaign) -> Self {
        let alone = campaign.choice_of_the_simulation().ok().flatten();
        let found = campaign.assessment().ok().flatten();
        let stands = found.as_ref().and_then(as_it_stands);
        let are_shifted = found.as_ref().is_some_and(has_shifts);
        Self { alone, is_of_some: campaign.n_simulated_of_many().ok().flatten().is_some(), stands, are_shifted }
    }

    fn name(&self, place: usize, cell: Cell) -> Cow<'static, str> {
        match (place, self.stands) {
            (0, _) => "what was recommended".into(),
            _ if self.alone != Some(cell) && self.are_shifted => {
                "what had measured best (without the shift of its batch)".into()
            }
            _ if self.alone != Some(cell) => "what had measured best".into(),
            _ if self.is_of_some => "the best of the designs simulated".into(),
            (_, Some(stands)) => format!("the simulation's own choice, {stands}").into(),
            _ => "the simulation's own choice".into(),
        }
    }
}

impl Confirmation {
    /// With differences as people have them.
    pub(super) fn shown(mut self, response: &Response) -> Self {
        for design in &mut self.designs {
            for difference in [&mut design.mean_give_or_take, &mut design.gain, &mut design.give_or_take] {
                *difference = difference.map(|difference| response.of_difference(difference));
            }
        }
        self
    }

    pub(super) fn in_words(&self, campaign: &Campaign) -> Finding {
        let (problem, response) = (&campaign.problem, &campaign.problem.response);
        let n_runs: usize = self.designs.iter().map(|design| design.n_runs).sum();
        let what =
            if self.designs.len() == 1 { "Measured, with no other design to compare it with," } else { "Compared" };
        let mut finding = Finding::new(format!("{what} by {} of batch {}:", count(n_runs, "run"), self.batch));
        let names = Names::of(campaign);
        for (place, design) in self.designs.iter().enumerate() {
            let settings = campaign.grid.point(design.cell).map(|point| problem.describe(&point)).unwrap_or_default();
            let who = names.name(place, design.cell);
            let measured = match mean(&design.costs) {
                Some(mean) => response.value(mean),
                None => "no value".to_owned(),
            };
            let measured = match design.mean_give_or_take {
                Some(half) => format!("{measured}, give or take {} (90 %)", response.amount(half)),
                None => measured,
            };
            let gain = design.gain.map_or_else(String::new, |gain| {
                let word = if gain < 0.0 { "worse" } else { "better" };
                let by = response.amount(gain.abs());
                let sure = match design.give_or_take {
                    Some(half) if half > gain.abs() => {
                        format!("give or take {} (90 %): the runs do not tell them apart", response.amount(half))
                    }
                    Some(half) => format!("give or take {} (90 %)", response.amount(half)),
                    None => "with too few runs to say how surely".to_owned(),
                };
                format!("; what was recommended is {word} by {by}, {sure}")
            });
            let sentence = format!("{who}, {settings}: {measured}{gain}.");
            let detail = Finding::new(sentence);
            let detail = match design.gain {
                Some(gain) => {
                    detail.with("measured gain", response.of_difference(gain), response.unit_of_differences())
                }
                None => detail,
            };
            finding = finding.detail(detail);
        }
        self.shared_in_words(response).into_iter().fold(finding, Finding::detail)
    }

    /// What is in the bands of the means, and not in those of the differences.
    fn shared_in_words(&self, response: &Response) -> Option<Finding> {
        let has_band = self.designs.iter().any(|design| design.mean_give_or_take.is_some());
        let shared = self.shared.filter(|_| has_band)?;
        let (whose, besides) = match self.designs.len() {
            1 => ("In the band of the mean", ""),
            _ => ("In the bands of the means", ", and not in those of the differences,"),
        };
        let amount = response.amount(shared);
        let sentence = format!("{whose}{besides} is what all runs of a batch share: {amount} (standard deviation).");
        Some(Finding::new(sentence).with(
            "shared error",
            response.of_difference(shared),
            response.unit_of_differences(),
        ))
    }
}

fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().map(|value| value / values.len() as f64).sum())
}

/// Half the interval of what has so many times the variance of one run.
fn half_width(noise: PureError, times: f64) -> Option<f64> {
    let student = StudentsT::new(0.0, 1.0, noise.degrees_of_freedom as f64).ok()?;
    Some(student.inverse_cdf(0.5 + PROBABILITY / 2.0) * (noise.variance * times).sqrt())
}

/// Mean of `a` less mean of `b`, with half the width of its interval by Student's test with the noise of all.
fn difference(a: &[f64], b: &[f64], noise: Option<PureError>) -> Option<(f64, Option<f64>)> {
    let (mean_a, mean_b) = (mean(a)?, mean(b)?);
    let half = noise.and_then(|noise| half_width(noise, 1.0 / a.len() as f64 + 1.0 / b.len() as f64));
    Some((mean_a - mean_b, half))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise_of(runs: &[Vec<f64>]) -> Option<PureError> {
        let runs = runs.iter().enumerate();
        PureError::of_readings(runs.flat_map(|(place, runs)| runs.iter().map(move |&cost| (vec![place as f64], cost))))
    }

    #[test]
    fn intervals_are_those_of_scipy() {
        // scipy.stats.ttest_ind(a, b, equal_var=True).confidence_interval(0.9) is 1.3 ± this.
        let (a, b) = (vec![8.1, 8.4, 8.3, 8.5], vec![7.1, 7.0, 6.975]);
        let noise = noise_of(&[a.clone(), b.clone()]);
        let (gain, half) = difference(&a, &b, noise).expect("both have runs");
        let half = half.expect("both have repeats");
        assert!((gain - 1.3).abs() < 1e-12, "{gain}");
        assert!((half - SCIPY_HALF_WIDTH).abs() < 1e-9, "{half}");
        // A third design adds what it knows of the noise: stats.t.ppf(0.95, 7) and the pooled variance, by numpy.
        let noise = noise_of(&[a.clone(), b.clone(), vec![9.0, 9.2, 9.1]]);
        let (_, half) = difference(&a, &b, noise).expect("both have runs");
        assert!((half.expect("a noise") - HALF_WIDTH_OF_THREE).abs() < 1e-9, "{half:?}");
    }

    const SCIPY_HALF_WIDTH: f64 = 0.213_530_167_236_585_8;
    const HALF_WIDTH_OF_THREE: f64 = 0.186_474_085_680_162_77;

    #[test]
    fn one_run_each_tells_a_difference_and_no_interval() {
        let none = noise_of(&[vec![2.0], vec![1.5]]);
        assert_eq!(difference(&[2.0], &[1.5], none), Some((0.5, None)));
        assert_eq!(difference(&[], &[1.5], none), None);
    }
}
