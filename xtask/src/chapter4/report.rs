//! What a person reads: the page, and the summary in the terminal.

use std::path::Path;

use infuse::{CodesignReport, StopReason};

use super::file::Published;
use super::pictures::{Material, Picture};
use super::results::{
    Rows, cost_table, fall_pct, falls_pct, flight_table, provenance_table, seed_table, side_by_side, variant_table,
};
use crate::figures::Summary;
use crate::page::Page;
use crate::study::{MODEL, STAND_IN};
use crate::table::{Column, Table};

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
    fn printed(&self) -> &Rows {
        &self.material.rows[0]
    }

    fn published(&self) -> &[Published] {
        &self.material.setup.file.published
    }

    fn published_fall_pct(&self) -> f64 {
        let rows = self.published();
        fall_pct(rows[0].experiment_cost, rows[rows.len() - 1].experiment_cost)
    }

    /// What was fitted, and how well the fit is met in this run.
    fn calibration_table(&self) -> Table {
        let study = &self.material.setup.study;
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
        let rows = [
            (
                "optimum of the numerical model: center of mass, % chord",
                first.center_of_mass,
                format!("{:.2}", start.point[0]),
            ),
            (
                "optimum of the numerical model: pitch set point, deg",
                first.pitch_set_point,
                format!("{:.2}", start.point[1]),
            ),
            (
                "cost of the numerical model at the published optimum, s",
                first.corrected_cost,
                cost(first.point(), MODEL),
            ),
            ("cost in the stand-in at the same point, s", first.experiment_cost, cost(first.point(), STAND_IN)),
            (
                "best design of the stand-in: center of mass, % chord",
                last.center_of_mass,
                format!("{:.2}", self.best.point[0]),
            ),
            (
                "best design of the stand-in: pitch set point, deg",
                last.pitch_set_point,
                format!("{:.2}", self.best.point[1]),
            ),
            (
                "cost in the stand-in at the published best design, s",
                last.experiment_cost,
                cost(last.point(), STAND_IN),
            ),
        ];
        for (what, published, ours) in rows {
            table.push(vec![what.to_owned(), published.to_string(), ours]);
        }
        table
    }

    /// What was not fitted.
    fn prediction_table(&self) -> Table {
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
            format!("{:.2} % chord, {:.2} deg", ours.point[0], ours.point[1]),
        );
        push(
            "corrected cost beside experimental cost, last iteration",
            format!("{} and {}", theirs.corrected_cost, theirs.experiment_cost),
            format!("{:.3} and {:.3}", ours.corrected_cost, ours.experiment.total),
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
    fn regret_pct(&self) -> f64 {
        100.0 * (self.printed().last().experiment.total / self.best.value - 1.0)
    }

    /// The largest fall that the stand-in allows from the first row, in per cent.
    fn room_pct(&self) -> f64 {
        fall_pct(self.printed().first().experiment.total, self.best.value)
    }

    fn failures(&self) -> String {
        let m = &self.material;
        let count = |lattice: &super::lattice::Lattice| lattice.failures.len();
        let (model, stand_in) = (count(m.model), count(m.stand_in));
        let first = m.model.failures.iter().chain(&m.stand_in.failures).next();
        let example = first.map_or(String::new(), |(point, reason)| {
            format!(" The first: at {:.2} % chord and {:.2} deg: {reason}.", point[0], point[1])
        });
        format!(
            "Of the flights of the landscapes, {model} of the model and {stand_in} of the stand-in failed (no trim, a \
             slack line, or a state outside the model).{example}"
        )
    }

    fn stops(&self) -> Vec<String> {
        let describe = |rows: &Rows| {
            let why = match rows.campaign.stop {
                StopReason::Converged => "the optimum came to rest",
                StopReason::IterationLimit => "the iterations of the study were used up",
                StopReason::NoInformation => "the experiments of the last iteration failed",
                _ => "for another reason",
            };
            format!(
                "{}: stopped because {why}; experimental cost {:.3} s, then {:.3} s, a fall of {:.1} %.",
                rows.label,
                rows.first().experiment.total,
                rows.last().experiment.total,
                rows.fall_pct()
            )
        };
        self.material.rows.iter().map(describe).collect()
    }
}

const BOX_CAPTION: &str = "Flights over the box of the four parameters of Table 4 (pitch to 22 deg): center of mass and \
    pitch set point at five values each, both stabilizers at their smallest, nominal and largest area; one step per sample. \
    Failed: no trim, a slack line, or a state outside the model.";

const PHYSICS_CAPTION: &str = "What moves the optimum: the best design of each physics, found by optimizing it. The water \
    channel's best design lay aft of the model's, at a higher pitch and a higher cost. Stall alone lowers the cost and does not move the center \
    of mass aft; added mass alone drives it to its bound.";

const STEP_CAPTION: &str = "Relative error of the cost of the first design by RK4 steps per sample of 0.025 s, against 16. \
    The designs that are reported fly with two; searches, landscapes and the margins above with one.";

/// The page of the study.
pub(crate) fn page(findings: &Findings<'_>) -> Page {
    let m = &findings.material;
    let setup = m.setup;
    let mut page = Page::new("Chapter 4: experimentally infused optimization of a tethered turbine, two parameters");
    page.note(
        "No experiment was made. The water channel of the dissertation is replaced by a surrogate: the numerical model \
         plus stall plus added mass. Published figures stand beside ours. What was fitted is called calibrated and is \
         no reproduction; what the loop does with it is called predicted.",
    );
    page.paragraph(
        "A designer has a cheap numerical model of a tethered, buoyant wind turbine and wants the center of mass (plant) \
         and the pitch set point (controller) that fly best. The model is wrong. At each iteration the model is optimized, \
         five experiments are made at and around its optimum, and the model is corrected by the difference between the \
         measured slope of the cost and its own, with a trust R.",
    );
    page.heading("The iterations");
    page.table(
        &side_by_side(setup, findings.printed()),
        "Table 3 of the dissertation / this run (R = 0.1 as printed, no noise). The experimental cost is that of the \
         water channel / of the stand-in; the change is that of the experimental cost since iteration 1. Costs in the \
         dissertation carry no unit; ours are in seconds (angles in rad, lengths in m).",
    );
    page.table(
        &findings.prediction_table(),
        "What is predicted: nothing in these rows was fitted. The stand-in's own best design was, so the last row of \
         Table 3 is a prediction of the path, not of where the valley lies.",
    );
    page.paragraph(&format!(
        "The best design of the stand-in, found by optimizing the stand-in itself, is {:.2} % chord and {:.2} deg at a \
         cost of {:.3} s; the loop ends {:.1} % above it. Both ends of the valley were calibrated, which leaves room for \
         a fall of at most {:.1} %: that a loop with {} experiments finds its way down there is the prediction.",
        findings.best.point[0],
        findings.best.point[1],
        findings.best.value,
        findings.regret_pct(),
        findings.room_pct(),
        findings.printed().n_experiments()
    ));
    page.heading("What was calibrated");
    page.table(&findings.calibration_table(), "Numbers that were fitted, with how well the fit is met in this run.");
    page.table(&findings.physics_table, PHYSICS_CAPTION);
    page.paragraph(
        "Identifiability is poor: some forty physical numbers and seven weights stand against seven published ones, so \
         these numbers show that the story is consistent, not that the plant is known.",
    );

    let show = |page: &mut Page, names: &[&str]| {
        for picture in findings.pictures.iter().filter(|picture| names.iter().any(|n| picture.name.starts_with(n))) {
            page.figure(&picture.svg, &picture.caption);
        }
    };
    page.heading("Where the loop went");
    show(&mut page, &["landscape"]);
    page.paragraph(&findings.failures());
    page.table(
        &variant_table(m.rows),
        "Every loop of this run, without noise. R = 0.1 is printed; the others show what trust does: a correction that is \
         linear over the whole box drives a trusting loop into a corner, and a limit on the move per iteration holds it \
         back. The last one has the correction with its printed sign, which rewards what the experiments punish.",
    );
    page.list(&findings.stops());
    page.heading("Before and after");
    show(&mut page, &["figure"]);
    page.table(
        &cost_table(findings.printed()),
        "What each design of the printed loop costs in the stand-in. Terms inside the square of (21) share their products, \
         so that the terms sum to J.",
    );
    page.table(
        &flight_table(findings.printed()),
        "How each design of the printed loop flies in the stand-in. Footprint: pi L² sin² Phi; full scale is 100 times \
         longer. The yaw mode is the least damped oscillation in which azimuth and twist lead, of the sampled closed loop \
         at trim at the first flow speed.",
    );
    page.heading("With noise");
    show(&mut page, &["seeds"]);
    page.table(&seed_table(setup, m.seeded), "Median (smallest … largest) over the noise seeds.");
    page.paragraph(&format!(
        "Noise: within ±{} % of J, uniform, one draw per experiment, seeds {} to {}; the bound and the steps of 1 % of \
         chord and 1 deg are ours. Simulations carry no noise: the seeds share {} remembered flights of the model and \
         interpolate between them (cubic); against {} flights of their own the largest error is {:.1e} of the cost. \
         Experiments are always flown.",
        100.0 * setup.file.noise.relative_bound,
        setup.file.noise.first_seed,
        setup.file.noise.first_seed + setup.file.noise.seeds - 1,
        m.model.axes[0].len() * m.model.axes[1].len(),
        super::CHECKED_POINTS,
        findings.interpolation_error
    ));
    page.heading("Margins and step size");
    page.table(&findings.box_table, BOX_CAPTION);
    page.table(&findings.step_table, STEP_CAPTION);
    page.heading("Every number");
    page.table(
        &provenance_table(&setup.study.records),
        "Plant, controller, test and cost: value, unit and where each comes from.",
    );
    page.paragraph(&format!(
        "Made by `cargo xtask reproduce-chapter4` in {:.0} s with {} flights of the model and {} of the stand-in, each \
         300 s long.",
        findings.seconds,
        setup.study.flown(MODEL),
        setup.study.flown(STAND_IN)
    ));
    page
}

/// The results as a page of `docs/`, without anything that differs from run to run.
pub(crate) fn markdown(findings: &Findings<'_>) -> String {
    let m = &findings.material;
    let falls: String = m
        .seeded
        .iter()
        .filter_map(|seeded| {
            let s = Summary::of(&falls_pct(m.setup, seeded))?;
            Some(format!(
                "- {}: median {:.1} %, from {:.1} to {:.1} %, {} seeds.\n",
                seeded.label, s.median, s.minimum, s.maximum, s.count
            ))
        })
        .collect();
    format!(
        "# Chapter 4: results\n\n\
         Written by `cargo xtask reproduce-chapter4`; `cargo xtask ci` fails when this page is not what the command finds.\n\
         The water channel is replaced by a surrogate: the numerical model plus stall plus added mass.\n\
         Rows marked calibrated were fitted and reproduce nothing; see [departures](departures.md) for what is ours.\n\n\
         ## Table 3: dissertation / this run\n\n{}\n\
         The calibrated costs leave room for a fall of at most {:.1} % (from the first row to the stand-in's best design, \
         {:.2} % chord and {:.2} deg at {:.3} s); the loop takes {:.1} %, the dissertation's {:.1} %.\n\n\
         ## What was calibrated\n\n{}\n## What moves the optimum\n\n{PHYSICS_CAPTION}\n\n{}\n## What is predicted\n\n{}\n## Every loop, without noise\n\n{}\n\
         ## Costs of the printed loop's designs in the stand-in\n\n{}\n## How they fly\n\n{}\n\
         ## Over noise seeds\n\nFall of the experimental cost, noise taken off:\n\n{}\n{}\n\
         ## Margins over the box of Table 4\n\n{BOX_CAPTION}\n\n{}\n## Step size\n\n{STEP_CAPTION}\n\n{}",
        side_by_side(m.setup, findings.printed()).markdown(),
        findings.room_pct(),
        findings.best.point[0],
        findings.best.point[1],
        findings.best.value,
        findings.printed().fall_pct(),
        findings.published_fall_pct(),
        findings.calibration_table().markdown(),
        findings.physics_table.markdown(),
        findings.prediction_table().markdown(),
        variant_table(m.rows).markdown(),
        cost_table(findings.printed()).markdown(),
        flight_table(findings.printed()).markdown(),
        falls,
        seed_table(m.setup, m.seeded).markdown(),
        findings.box_table.markdown(),
        findings.step_table.markdown(),
    )
}

/// The closing summary, for a person who has not read the dissertation.
#[expect(clippy::print_stdout, reason = "the result of the command")]
pub(crate) fn print(findings: &Findings<'_>, out: &Path) {
    let rows = findings.printed();
    let (first, last) = (rows.first(), rows.last());
    println!("\nChapter 4: a wrong model, {} experiments, and what they taught it", rows.n_experiments());
    println!("(dissertation / this run; the water channel is replaced by a surrogate model; lower costs are better)\n");
    println!("{}\n", side_by_side(findings.material.setup, rows).text());
    println!(
        "The numerical model alone would build {:.2} % chord and {:.2} deg and promise a cost of {:.2} s.",
        first.point[0], first.point[1], first.corrected_cost
    );
    println!("In the stand-in for the water channel that design costs {:.2} s.", first.experiment.total);
    println!(
        "After {} iterations the loop builds {:.2} % chord and {:.2} deg, which costs {:.2} s: {:.1} % less \
         (dissertation: {:.1} % less).",
        rows.rows.len(),
        last.point[0],
        last.point[1],
        last.experiment.total,
        rows.fall_pct(),
        findings.published_fall_pct()
    );
    println!(
        "The best design of the stand-in is {:.2} % chord and {:.2} deg at {:.2} s; the loop ends {:.1} % above it.",
        findings.best.point[0],
        findings.best.point[1],
        findings.best.value,
        findings.regret_pct()
    );
    let pitch_bound = findings.material.setup.bounds(1).1;
    if (last.point[1] - pitch_bound).abs() < 1e-6 {
        println!(
            "The pitch set point ends at its bound of {pitch_bound} deg; in the dissertation it ends at 19.4 deg."
        );
    }
    for seeded in findings.material.seeded {
        if let Some(s) = Summary::of(&falls_pct(findings.material.setup, seeded)) {
            println!(
                "With noise, {}: over {} seeds the cost falls by {:.1} % (median; from {:.1} to {:.1} %).",
                seeded.label, s.count, s.median, s.minimum, s.maximum
            );
        }
    }
    println!(
        "\nRow 1 was calibrated to the dissertation's first row and the stand-in to its best design; rows 2 and on are \
         predicted by the loop.\nPage, figures and data: {} (open index.html), after {:.0} s.",
        out.display(),
        findings.seconds
    );
}
