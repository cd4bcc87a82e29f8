//! What a run of Chapter 4 found, in numbers and in sentences made of them.

use infuse::codesign::CodesignReport;
use infuse::{Outcome, gradient};
use water_channel::Provenance;

use super::figures::Material;
use super::file::Table3Row;
use super::rows::{ERRORS, Rows, fall_pct};
use super::seeds::falls_pct;
use crate::bat::{MODEL, STAND_IN};
use crate::reproduction::Picture;
use page::Summary;
use page::{Column, Table};

/// What this run found.
pub(crate) struct Findings<'a> {
    pub(crate) material: Material<'a>,
    /// The optimum of the stand-in itself, which no engineer could compute.
    pub(crate) best: CodesignReport,
    /// Largest relative error of the remembered simulations against flights of their own.
    pub(crate) interpolation_error: f64,
    /// Margins of the flights over the box of Table 4.
    pub(crate) box_table: Table,
    /// Optimum with each piece of physics.
    pub(crate) physics_table: Table,
    /// Error of the cost by step size.
    pub(crate) step_table: Table,
    pub(crate) seconds: f64,
    pub(crate) pictures: &'a [Picture],
}

impl Findings<'_> {
    /// The loop as printed: the first variant.
    pub(crate) fn printed(&self) -> &Rows {
        &self.material.rows[0]
    }

    pub(crate) fn published(&self) -> &[Table3Row] {
        &self.material.setup.file.published
    }

    pub(crate) fn published_fall_pct(&self) -> f64 {
        let rows = self.published();
        fall_pct(rows[0].experiment_cost, rows[rows.len() - 1].experiment_cost)
    }

    /// What was fitted, and how well the fit is met in this run.
    pub(crate) fn calibration_table(&self) -> Table {
        let study = &self.material.setup.bat;
        let (first, last) = (self.published()[0], self.published()[self.published().len() - 1]);
        let start = self.printed().first();
        let cost = |point: [f64; 2], fidelity| match study.cost(&point, fidelity) {
            Ok(cost) => format!("{cost:.3}"),
            Err(reason) => reason,
        };
        let mut table = Table::new(vec![
            Column::new("Calibrated", ""),
            Column::new("Published", "1"),
            Column::new("This run", "1"),
        ]);
        let setup = &self.material.setup;
        let named =
            |what: &str, k: usize| format!("{what}: {}, {}", setup.variable(k).label(), setup.variable(k).unit());
        let at = |point: &[f64], k: usize| format!("{:.2}", point[k]);
        let rows = [
            (named("optimum of the numerical model", 0), first.center_of_mass, at(&start.point, 0)),
            (named("optimum of the numerical model", 1), first.pitch_set_point, at(&start.point, 1)),
            (
                "cost of the numerical model at the published optimum, s".to_owned(),
                first.corrected_cost,
                cost(first.point(), MODEL),
            ),
            (
                "cost in the stand-in at the same point, s".to_owned(),
                first.experiment_cost,
                cost(first.point(), STAND_IN),
            ),
            (named("best design of the stand-in", 0), last.center_of_mass, at(&self.best.point, 0)),
            (named("best design of the stand-in", 1), last.pitch_set_point, at(&self.best.point, 1)),
            (
                "cost in the stand-in at the published best design, s".to_owned(),
                last.experiment_cost,
                cost(last.point(), STAND_IN),
            ),
        ];
        for (what, published, ours) in rows {
            table.push(vec![what, published.to_string(), ours]);
        }
        table
    }

    /// What was not fitted.
    pub(crate) fn prediction_table(&self) -> Table {
        let (rows, published) = (self.printed(), self.published());
        let theirs = &published[published.len() - 1];
        let ours = rows.last();
        let mut table =
            Table::new(vec![Column::new("Predicted", ""), Column::new("Published", ""), Column::new("This run", "")]);
        let mut push = |what: &str, a: String, b: String| table.push(vec![what.to_owned(), a, b]);
        push(
            "fall of the experimental cost, first to last iteration",
            format!("{:.1} %", self.published_fall_pct()),
            format!("{:.1} %", rows.fall_pct()),
        );
        push("experiments that it took", (5 * published.len()).to_string(), rows.n_experiments().to_string());
        push(
            "last design",
            format!("{} % chord, {} deg", theirs.center_of_mass, theirs.pitch_set_point),
            self.material.setup.words(&ours.point),
        );
        push(
            "corrected cost beside experimental cost, last iteration",
            format!("{} and {}", theirs.corrected_cost, theirs.experiment_cost),
            format!("{:.3} and {:.3}", ours.corrected_cost, ours.cost()),
        );
        for seeded in self.material.seeded {
            if let Some(s) = Summary::of(&falls_pct(self.material.setup, seeded)) {
                push(
                    &format!("fall over {} noise seeds, {}", s.count, seeded.label),
                    "–".to_owned(),
                    format!("median {:.1} %, from {:.1} to {:.1} %", s.median, s.minimum, s.maximum),
                );
            }
        }
        table
    }

    /// Cost of the last design above that of the stand-in's best, in per cent: the regret of the loop.
    pub(crate) fn regret_pct(&self) -> f64 {
        100.0 * (self.printed().last().cost() / self.best.cost - 1.0)
    }

    /// The largest fall that the stand-in allows from the first row, in per cent.
    pub(crate) fn room_pct(&self) -> f64 {
        fall_pct(self.printed().first().cost(), self.best.cost)
    }

    pub(crate) fn failures(&self) -> String {
        let m = &self.material;
        let first = m.model.failures.iter().chain(&m.stand_in.failures).next();
        let example = first.map_or(String::new(), |failure| format!(" The first: {}.", failure.words));
        format!(
            "Of the flights of the landscapes, {} of the model and {} of the stand-in failed (no trim, a \
             slack line, or a state outside the model).{example}{}",
            m.model.failures.len(),
            m.stand_in.failures.len(),
            self.failures_of_the_loops()
        )
    }

    /// What failed in the campaigns, with and without noise; nothing if nothing did.
    fn failures_of_the_loops(&self) -> String {
        let printed = self.material.rows.iter().map(|rows| &rows.campaign);
        let seeded = self.material.seeded.iter().flat_map(|seeded| &seeded.campaigns).map(|(_, campaign)| campaign);
        let reports: Vec<&gradient::Report> = printed.chain(seeded).flat_map(|campaign| &campaign.reports).collect();
        let simulations = reports.iter().flat_map(|report| &report.numerical.failures).map(|failed| &failed.reason);
        let experiments = reports.iter().flat_map(|report| &report.trials).filter_map(|trial| match &trial.outcome {
            Some(Outcome::Failed { reason }) => Some(reason),
            _ => None,
        });
        let (n_simulations, n_experiments) = (simulations.clone().count(), experiments.clone().count());
        simulations.chain(experiments).next().map_or_else(String::new, |first| {
            format!(
                " In the loops {n_simulations} simulations and {n_experiments} experiments failed. The first: {first}."
            )
        })
    }

    pub(crate) fn stops(&self) -> Vec<String> {
        let describe = |rows: &Rows| {
            let why = match rows.campaign.stop {
                gradient::StopReason::Converged => "the optimum came to rest",
                gradient::StopReason::IterationLimit => "the iterations of the study were used up",
                gradient::StopReason::NoInformation => "the experiments of the last iteration failed",
                _ => "for another reason",
            };
            format!(
                "{}: stopped because {why}; experimental cost {:.3} s, then {:.3} s, {}.",
                rows.label,
                rows.first().cost(),
                rows.last().cost(),
                change_words(rows.fall_pct())
            )
        };
        self.material.rows.iter().map(describe).collect()
    }

    /// What the loop improved and what it paid for it, before and after, in the stand-in.
    pub(crate) fn what_changed(&self) -> Vec<String> {
        let (before, after) = (self.printed().first(), self.printed().last());
        let mut items = Vec::new();
        let mut note = |what: &str, before: f64, after: f64, unit: &str| {
            let verdict = if after < before { "better" } else { "worse" };
            items.push(format!("{what}: {before:.2} before, {after:.2} {unit} after: {verdict}."));
        };
        for (angle, figure, error) in ERRORS {
            let what = format!("mean squared {angle} error (Figure {figure})");
            note(&what, before.mean_squared_deg2(error), after.mean_squared_deg2(error), "deg²");
        }
        note("ground footprint, mean", before.mean_footprint_m2() * 1e4, after.mean_footprint_m2() * 1e4, "cm²");
        for (k, name) in water_channel::TERM_NAMES.iter().enumerate() {
            note(
                &format!("share of the cost from {name}"),
                before.logged.cost.terms[k],
                after.logged.cost.terms[k],
                "s",
            );
        }
        items
    }

    /// The wells of the stand-in's landscape.
    pub(crate) fn wells(&self) -> String {
        let wells = self.material.stand_in.wells();
        let list: Vec<String> = wells
            .iter()
            .map(|(point, cost)| format!("{} at {cost:.3} s", self.material.setup.sentence(point)))
            .collect();
        format!(
            "On its lattice the cost in the stand-in has {} inside the box: {}. A loop that follows slopes finds one well \
             and does not learn of another.",
            if wells.len() == 1 { "one minimum".to_owned() } else { format!("{} minima", wells.len()) },
            list.join("; ")
        )
    }

    /// How many numbers were fitted, and to how many.
    pub(crate) fn identifiability(&self) -> String {
        let records = &self.material.setup.bat.records;
        let fitted = records.iter().filter(|record| record.provenance == Provenance::Calibrated).count();
        format!(
            "Identifiability is poor: {fitted} calibrated numbers stand against the {} published ones of this table and a \
             few of a later chapter, so they show that the story is consistent, not that the plant is known.",
            self.calibration_table().rows.len()
        )
    }
}

/// A fall in words, a rise where it is negative.
pub(crate) fn change_words(fall_pct: f64) -> String {
    if fall_pct < 0.0 { format!("a rise of {:.1} %", -fall_pct) } else { format!("a fall of {fall_pct:.1} %") }
}

/// Points at which interpolation is held against a flight of its own.
pub(crate) const CHECKED_POINTS: usize = 32;
