//! What commands ask of a campaign, answered by the pooled loop.

use std::collections::BTreeSet;
use std::path::Path;
use std::time::Duration;

use anyhow::Result;
use design_space::Cell;
use infuse::pooled::{Certificate, Settings, StopBy, Trial};
use page::Finding;
use serde_json::{Value, json};

use super::bounds::as_json;
use super::campaign::{Access, Campaign};
use super::dry::dry_pick;
use super::failures::FailedSimulations;
use super::findings::{closed, known, lesson, none_better, promised, recommendation, standing_in_words};
use super::given_noise::contradiction;
use super::reasons::reasons;
use super::warnings::{all_equal, nothing_but_failures, warnings};
use super::{confirm, displaced, drift, hand_out, report, what_if};
use crate::campaign::{self, Budget, Experiments, HandedOut, Imported, Reserve, Stage, Wish};
use crate::findings::all_batches_made;
use crate::journal::{Event, Journal, Measured, Submitted, Writer};
use crate::number::percent;
use crate::problem::Problem;
use crate::simulator::identity;

impl campaign::Campaign for Campaign {
    fn folder(&self) -> &Path {
        &self.folder
    }

    fn problem(&self) -> &Problem {
        &self.problem
    }

    fn experiments(&self) -> &Experiments {
        &self.experiments
    }

    fn take_notices(&mut self) -> Vec<String> {
        std::mem::take(&mut self.notices)
    }

    fn record(&mut self, writer: &mut Writer, events: Vec<Event>) -> Result<()> {
        self.write_down(writer, events)
    }

    fn stage(&self) -> Result<Stage> {
        if self.experiments.n_outstanding() > 0 {
            return Ok(Stage::Pending);
        }
        Ok(match self.not_worth_it()? {
            Some(reason) => Stage::Ended { reason, may_go_on: !self.is_full() },
            None if self.is_full() => {
                let reason = all_batches_made(self.settings.max_batches, self.batches.len() - self.n_confirming());
                Stage::Ended { reason, may_go_on: false }
            }
            None => Stage::Ready,
        })
    }

    fn n_closed(&self) -> usize {
        self.n_complete()
    }

    fn hand_out(&mut self, writer: &mut Writer, wish: Wish) -> Result<HandedOut> {
        hand_out::hand_out(self, writer, wish)
    }

    fn purpose(&self, batch: usize) -> Finding {
        let has_simulation = self.problem.simulator.is_there();
        let is_begun_by_it = self.n_imported_values() < self.problem.region.n_parameters() + 2;
        let planned = self.batches.get(batch - 1);
        if planned.is_some_and(|one| one.purpose.is_some()) {
            return self.to_confirm(batch);
        }
        Finding::new(match planned.map(|_| batch) {
            _ if self.nothing_but_failures().is_some() => {
                "No experiment gave a value yet, so it is spread over what was not tried."
            }
            Some(1) if is_begun_by_it && !has_simulation => "It is the first: spread over all that can be set.",
            Some(1) if is_begun_by_it => {
                "It is the first: two thirds of it are spread over all that can be set, a third over what the simulation likes."
            }
            _ => return reasons(planned.map_or(&[], |planned| &planned.reasons), has_simulation),
        })
    }

    fn refusal(&self, _: &Trial) -> Option<String> {
        // All data count anew at every step, so a result may be put right at any time.
        None
    }

    fn budget(&self) -> Result<Budget> {
        let simulations = match self.access()? {
            Access::Nothing | Access::LookedUp => Some(0),
            Access::All => None,
            Access::Budget => self.settings.simulations.or(Some(0)),
        };
        let Settings { n_experiments: experiments, max_batches: batches, .. } = self.settings;
        let without_reserve = self.empty.designs_without_reserve();
        let (n_left, grid) = (self.n_left(), self.grid.clone());
        Ok(Budget { terms: None, experiments, batches, n_left, simulations, without_reserve, grid })
    }

    fn reserve(&self) -> Result<Option<Reserve>> {
        let (Some(until), n_left) = (self.empty.designs_without_reserve(), self.n_left()) else { return Ok(None) };
        let Some(found) = self.assessment()? else { return Ok(Some(Reserve { until, so_far: 0.0, n_left })) };
        let until = found.forecast.reserves_until().map_or(until, |now| now.max(until));
        Ok(Some(Reserve { until, so_far: found.forecast.n_counted(), n_left }))
    }

    fn dry_pick(&self) -> Result<Option<Duration>> {
        dry_pick(&self.problem, &self.settings).map(Some)
    }

    fn submitted(&self) -> &[Submitted] {
        &self.submitted
    }

    fn simulations_made(&self) -> Vec<Measured> {
        let by = identity(&self.problem.simulator);
        self.memory.values().filter(|known| known.by == by).map(|known| known.result.clone()).collect()
    }

    fn waits_for_simulations(&self) -> Result<BTreeSet<Cell>> {
        Ok(self.missing_simulations()?.into_iter().map(|(cell, _)| cell).collect())
    }

    fn imported(&self) -> Vec<Imported> {
        self.imported.clone()
    }

    fn use_of_imports(&self, n: usize) -> String {
        let they_count = if n == 1 { "It counts" } else { "They count" };
        format!("{they_count} as much as the experiments of the campaign.")
    }

    fn lesson(&self) -> Result<Vec<Finding>> {
        lesson(self)
    }

    fn recommendation(&self) -> Result<Option<(Finding, Vec<f64>)>> {
        let found = self.assessment()?;
        Ok(found.map(|found| (recommendation(self, &found), found.recommended.point)))
    }

    fn closed(&self) -> Result<Option<Finding>> {
        let found = self.assessment()?;
        Ok(found.map(|found| closed(self, &found)))
    }

    fn status(&self) -> Result<(Vec<Vec<Finding>>, Value)> {
        let Some(found) = self.assessment()? else {
            let failed = FailedSimulations::of(self)?;
            let blocks = vec![nothing_but_failures(self), failed.in_words(self).into_iter().collect()];
            return Ok((blocks, json!({ "simulations": failed.as_json(self) })));
        };
        let mut blocks = known(self, &found)?;
        blocks.push(warnings(self, &found)?);
        let (problem, response) = (&self.problem, &self.problem.response);
        let simulation_alone = self.choice_of_the_simulation()?.map(|cell| self.grid.point(cell)).transpose()?;
        let batches = self.history.values().map(|assessed| {
            json!({
                "batch": assessed.batch, "best": problem.named(&assessed.recommended), "expected": assessed.expected,
                "deviation": response.of_difference(assessed.deviation),
                "bound": assessed.bound.map(|bound| response.of_difference(bound)),
                "bound_by_the_surface_alone": assessed.alone.map(|bound| response.of_difference(bound)),
                "left_share": assessed.left,
                "noise": response.of_difference(assessed.noise),
            })
        });
        let best_measured = self.best_measured(&found).map(|best| best.as_json(self));
        let (of_batches, of_plants) = match self.settings.plants {
            Some(_) => (None, found.assembly),
            None => (found.assembly, None),
        };
        let bound = promised(self, &found).map(|bound| response.of_difference(bound));
        let mut json = json!({
            "batches": batches.collect::<Vec<_>>(),
            "best": problem.named(&found.recommended.point),
            "predicted": response.of_cost(found.recommended.mean),
            "deviation": found.needed.is_none().then(|| response.of_difference(found.recommended.deviation)),
            "runs_there": found.recommended.n_readings,
            "bound": bound,
            "needed": found.needed,
            "bound_by_the_surface_alone": bound.map(|_| response.of_difference(found.certificate.quantile)),
            "stops_by": self.settings.stop_by,
            "probability": found.certificate.probability,
            "further_batches": found.further_batches.filter(|_| bound.is_some()),
            "designs_without_reserve": found.forecast.reserves_until(),
            "designs_counted": found.forecast.n_counted(),
            "held_for_a_find": found.forecast.is_for_a_find(),
            "bound_is_what_the_response_allows": found.forecast.is_for_the_least(),
            "find": found.find.as_ref().map(|point| problem.named(point)),
            "left_share": found.left,
            "unseen_share": found.unseen,
            "noise": json!({
                "standard_deviation": response.of_difference(found.noise), "degrees_of_freedom": found.n_repeats, "is_exact": found.is_exact,
                "of_repeats": self.repeats(&found).map(|repeats| response.of_difference(repeats.standard_deviation())),
                "is_contradicted": contradiction(self, &found).is_some(),
            }),
            "constraints": as_json(self, &found.recommended.constrained),
            "spent": self.spent_until(self.batches.len()).map(|(cost, plants)| json!({ "cost": cost, "plants": plants })),
            "shared_error_of_a_batch": of_batches.map(|shared| response.of_difference(shared)),
            "shared_error_of_a_plant": of_plants.map(|shared| response.of_difference(shared)),
            "own_of_a_plant": found.own.map(|own| response.of_difference(own)),
            "keeps_to_the_constraints": found.recommended.suffices,
            "simulation": found.simulation,
            "displacement": displaced::as_json(problem, &found),
            "registration": displaced::registration_as_json(problem, &found),
            "simulations": FailedSimulations::of(self)?.as_json(self),
            "simulation_alone": simulation_alone.map(|point| problem.named(&point)),
            "best_measured": best_measured,
            "confirmed": self.confirmation()?.map(|confirmation| confirmation.shown(response)),
        });
        if let (Some(json), Value::Object(of_drifts)) = (json.as_object_mut(), drift::as_json(self, &found)?) {
            json.extend(of_drifts);
        }
        Ok((blocks, json))
    }

    fn why(&self, asked: &[f64]) -> Result<Finding> {
        standing_in_words(self, asked)
    }

    fn page(&self, journal: &Journal) -> Result<String> {
        report::page(self, journal)
    }

    fn pictures(&self) -> Result<String> {
        report::pictures(self)
    }

    fn what_if(&self, asked: &[f64]) -> Result<(Vec<Finding>, Value)> {
        what_if::of_design(self, asked)
    }

    fn what_if_over_the_grid(&self, path: &Path) -> Result<(Vec<Finding>, Value)> {
        what_if::over_the_grid(self, path)
    }

    fn may_confirm(&self) -> bool {
        self.experiments.n_outstanding() == 0 && !self.costs().is_empty() && !self.is_confirmed()
    }

    fn is_confirmed(&self) -> bool {
        self.batches.last().is_some_and(|batch| batch.purpose.is_some())
    }

    fn confirm(&mut self, writer: &mut Writer, runs: usize) -> Result<()> {
        confirm::confirm(self, writer, runs)
    }
}

impl Campaign {
    /// Why another batch is not worth it, if so: the certificate says so, and no measurement speaks against it.
    fn not_worth_it(&self) -> Result<Option<String>> {
        let (Some(worth), Some(found)) = (self.settings.worth, self.assessment()?) else {
            return Ok(None);
        };
        // A worth of another scale ends nothing.
        let is_unsure = all_equal(self).is_some() || !self.left_from_another_scale().is_empty();
        let speaks_against = found.contradiction.is_some() || is_unsure;
        let stop_by = self.settings.stop_by;
        let left = found.bound_to_stop_by(stop_by).filter(|left| *left <= worth && !speaks_against);
        Ok(left.map(|left| {
            let response = &self.problem.response;
            let by = if stop_by == StopBy::Bound { "" } else { "by the surface alone, " };
            let unless = match (stop_by, found.unseen) {
                (StopBy::Surface, Some(share)) if self.problem.smooth != Some(true) => format!(
                    ", unless a {} of less than {} of all designs may be there; the bound is {}",
                    response.well(),
                    percent(share),
                    response.amount(found.certificate.bound)
                ),
                _ => String::new(),
            };
            let than_enough = match left > 0.0 {
                true => format!("less than {} that would be worth another batch", response.the_amount(worth)),
                false => {
                    format!("where {} would have to be gained for another batch to be worth it", response.amount(worth))
                }
            };
            let promised = Certificate { bound: left, ..found.certificate };
            format!("{by}with {}, {than_enough}{unless}", none_better(&self.problem, &promised))
        }))
    }
}
