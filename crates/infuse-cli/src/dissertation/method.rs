//! What commands ask of a campaign, answered by the dissertation's loop.

use std::collections::BTreeSet;
use std::path::Path;

use anyhow::Result;
use design_space::Cell;
use infuse::global::StopReason;
use infuse::pooled::Trial;
use page::Finding;
use serde_json::{Value, json};

use super::campaign::{Campaign, Stage};
use super::findings::{best, best_design, closed, left, lesson, prospects, reason_to_stop, why_dropped};
use super::{hand_out, report};
use crate::campaign::{self, Budget, Experiments, HandedOut, Imported, Wish};
use crate::journal::{Constrained, Event, Journal, Measured, Submitted, Writer};
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

    fn stage(&self) -> Result<campaign::Stage> {
        let stage = self.its_stage()?;
        Ok(match (&stage, reason_to_stop(self, &stage)) {
            (Stage::Pending, _) => campaign::Stage::Pending,
            (_, None) => campaign::Stage::Ready,
            (_, Some(reason)) => campaign::Stage::Ended { reason, may_go_on: matches!(stage, Stage::NotWorth { .. }) },
        })
    }

    fn n_closed(&self) -> usize {
        self.now.reports().len()
    }

    fn hand_out(&mut self, writer: &mut Writer, wish: Wish) -> Result<HandedOut> {
        anyhow::ensure!(
            !wish.more,
            "--more needs `method` = \"pooled\": this loop closes a batch before it begins another"
        );
        hand_out::hand_out(self, writer, wish.anyway)
    }

    fn purpose(&self, batch: usize) -> Finding {
        Finding::new(if batch == 1 {
            "It is the first: spread over all that can be set, it shows where the simulation is wrong."
        } else {
            "It is spread over the designs that are left, so that the surface is known best where the optimum may be."
        })
    }

    fn refusal(&self, trial: &Trial) -> Option<String> {
        let last = self.experiments.last_batch().unwrap_or(0);
        let stands = trial.batch < last || self.is_settled(trial.batch);
        stands.then(|| format!("one of batch {last}: later batches rest on the results of the others"))
    }

    fn budget(&self) -> Result<Budget> {
        let settings = self.now.settings();
        Ok(Budget {
            terms: Some(settings.model.n_terms()),
            experiments: settings.n_experiments,
            batches: settings.max_batches,
            n_left: settings.max_batches.saturating_sub(self.experiments.last_batch().unwrap_or(0)),
            simulations: Some(settings.n_simulations),
            without_reserve: None,
            grid: self.now.grid().clone(),
        })
    }

    fn submitted(&self) -> &[Submitted] {
        &self.submitted
    }

    fn simulations_made(&self) -> Vec<Measured> {
        let by = identity(&self.problem.simulator);
        self.memory.values().filter(|known| known.by == by).map(|known| known.result.clone()).collect()
    }

    fn waits_for_simulations(&self) -> Result<BTreeSet<Cell>> {
        let missing = self.missing_simulations(&identity(&self.problem.simulator))?;
        Ok(missing.into_iter().map(|(cell, _)| cell).collect())
    }

    fn imported(&self) -> Vec<Imported> {
        let in_use = self.now.earlier().iter().filter(|earlier| earlier.until.is_none());
        in_use
            .map(|earlier| Imported {
                point: earlier.point.clone(),
                result: Measured::Value(self.problem.response.of_cost(earlier.cost)),
                constrained: Constrained::new(),
                source: earlier.source.clone(),
                note: String::new(),
            })
            .collect()
    }

    fn use_of_imports(&self, n: usize) -> String {
        let [they_train, their, they_validate] = match n {
            1 => ["it trains", "its", "it never validates"],
            _ => ["they train", "their", "they never validate"],
        };
        format!(
            "From batch {} on {they_train} the surfaces, as long as {their} settings are among the designs left; {they_validate}.",
            self.batch()
        )
    }

    fn lesson(&self) -> Result<Vec<Finding>> {
        Ok(lesson(self).into_iter().collect())
    }

    fn recommendation(&self) -> Result<Option<(Finding, Vec<f64>)>> {
        let has_learned = self.now.stop() != Some(StopReason::NoInformation);
        let last = self.now.reports().last().filter(|_| has_learned);
        Ok(last.and_then(|report| Some((best_design(self)?, report.screening.optimum.clone()))))
    }

    fn closed(&self) -> Result<Option<Finding>> {
        Ok(self.now.reports().last().map(|report| closed(self, report)))
    }

    fn status(&self) -> Result<(Vec<Vec<Finding>>, Value)> {
        let mut blocks = Vec::new();
        if !self.now.reports().is_empty() {
            blocks.push(best(self).into_iter().collect());
            blocks.push(lesson(self).into_iter().collect());
            blocks.push(vec![left(self)?]);
            blocks.push(prospects(self)?);
        }
        Ok((blocks, self.status_for_machines()?))
    }

    fn why(&self, asked: &[f64]) -> Result<Finding> {
        why_dropped(self, asked)
    }

    fn page(&self, journal: &Journal) -> Result<String> {
        report::page(self, journal)
    }

    fn pictures(&self) -> Result<String> {
        report::pictures(self)
    }
}

impl Campaign {
    fn status_for_machines(&self) -> Result<Value> {
        let (problem, response) = (&self.problem, &self.problem.response);
        let named = |point: &[f64]| problem.named(point);
        let batches = self.now.reports().iter().map(|report| {
            let screening = &report.screening;
            json!({
                "batch": report.number, "best": named(&screening.optimum),
                "predicted": response.of_cost(screening.optimum_value), "spread": screening.spread.s(),
                "left": screening.n_after, "left_before": screening.n_before, "threshold": screening.threshold,
                "off_by_up_to": report.changes.innovation, "failed_experiments": report.failed_trials().count(),
                "failed_simulations": report.failed_simulations().count(),
                "g_efficiency_percent": report.batch.experiment_efficiency,
                "simulation_alone": named(&screening.simulation_optimum),
            })
        });
        let outlook = self.outlook()?;
        let observed = self.now.observed_certificate()?;
        let last = self.now.reports().last();
        Ok(json!({
            "batches": batches.collect::<Vec<_>>(),
            "best": last.map(|report| named(&report.screening.optimum)),
            "simulation_alone": self.now.reports().first().map(|first| named(&first.screening.simulation_optimum)),
            "predicted": last.map(|report| response.of_cost(report.screening.optimum_value)),
            "left": self.now.retained().n_retained(), "of": self.now.retained().n_cells(),
            "noise": self.noise().map(|error| json!({
                "standard_deviation": error.standard_deviation(), "degrees_of_freedom": error.degrees_of_freedom,
            })),
            "gain": outlook.map(|outlook| json!({
                "total": outlook.total_gain(), "noise": outlook.noise_gain(), "elsewhere": outlook.moved_gain,
                "misfit": outlook.misfit_gain, "nine_in_ten_below": outlook.upper_noise_gain(),
            })),
            "guarantee": observed.map(|observed| json!({ "eps": observed.eps, "regret": observed.certificate.regret })),
        }))
    }
}
