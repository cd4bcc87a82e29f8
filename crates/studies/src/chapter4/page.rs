//! What a person reads: the page, and the summary in the terminal.

use std::path::Path;

use anyhow::Result;

use super::findings::{Findings, change_words};
use super::rows::ERRORS;
use super::seeds::falls_pct;
use super::tables::{Digits, cost_table, flight_table, seed_table, side_by_side, variant_table};
use crate::bat::{MODEL, STAND_IN};
use crate::claims::{self, Claim};
use crate::first_screen::FirstScreen;
use crate::provenance::provenance_table;
use crate::reproduction::{markdown_list, picture};
use page::{Finding, Page, Summary};

/// The picture that the pages begin with.
const FIRST: &str = "table-3";

const BOX_CAPTION: &str = "Flights over the box of the four parameters of Table 4 (pitch to 22 deg): center of mass and \
    pitch set point at five values each, both stabilizers at their smallest, nominal and largest area; one step per sample. \
    Failed: no trim, a slack line, or a state outside the model.";

const PHYSICS_CAPTION: &str = "What moves the optimum: the best design of each physics, found by optimizing it, and what \
    the model's optimum costs there. In Table 3 the best design lies aft of the model's optimum, at a higher pitch, and the \
    model's optimum costs half as much again in the water channel.";

const VARIANT_CAPTION: &str = "Every loop of this run, without noise. R is the trust in the measured slopes, 0.1 as printed; \
    the correction is a plane, so that trust reaches as far as the box. Limited moves are a remedy of modifier adaptation. \
    The last loop has the correction with its printed sign.";

fn step_caption(findings: &Findings<'_>) -> String {
    let [search, report] = findings.material.setup.steps_per_sample();
    format!(
        "Relative error of the cost of the first design by RK4 steps per controller sample, against 16. Searches and \
         landscapes of this run fly with {search}, the designs that are reported with {report}."
    )
}

/// What the model alone would build, and what the loop builds.
fn headline(findings: &Findings<'_>) -> Finding {
    let rows = findings.printed();
    let (first, last) = (rows.first(), rows.last());
    let (before, after, fall) = (first.cost(), last.cost(), rows.fall_pct());
    Finding::new(format!(
        "The numerical model alone would build {:.2} % chord and {:.2} deg, which costs {before:.2} s in the stand-in. After {} \
         iterations and {} experiments the loop builds {:.2} % chord and {:.2} deg, which costs {after:.2} s: {fall:.1} % less \
         (dissertation: {:.1} % less).",
        first.point[0],
        first.point[1],
        rows.rows.len(),
        rows.n_experiments(),
        last.point[0],
        last.point[1],
        findings.published_fall_pct()
    ))
    .with("cost before", before, "s")
    .with("cost after", after, "s")
    .with("fall of the cost", fall, "%")
}

/// What the pages begin with.
pub(crate) fn first_screen<'a>(findings: &Findings<'a>) -> Result<FirstScreen<'a>> {
    let (room, regret) = (findings.room_pct(), findings.regret_pct());
    let mut found = vec![
        headline(findings),
        Finding::new(format!(
            "Both ends were calibrated, so a fall of at most {room:.1} % was possible, and what counts is the way: the loop ends \
             {regret:.1} % above the best design of the stand-in."
        ))
        .with("largest possible fall", room, "%")
        .with("above the best design", regret, "%"),
    ];
    let first_seeded = findings.material.seeded.first();
    if let Some(s) = first_seeded.and_then(|seeded| Summary::of(&falls_pct(findings.material.setup, seeded))) {
        let sentence = format!(
            "Over {} seeds of noise it falls by {:.1} % in the median, by {:.1} % at worst.",
            s.count, s.median, s.minimum
        );
        found.push(Finding::new(sentence).with("median fall", s.median, "%").with("least fall", s.minimum, "%"));
    }
    let (before, after) = (findings.printed().first(), findings.printed().last());
    let errors = ERRORS.map(|(what, _, error)| (what, before.mean_squared_deg2(error), after.mean_squared_deg2(error)));
    let words: Vec<String> = errors.iter().map(|(what, a, b)| format!("{what} {a:.2} → {b:.2} deg²")).collect();
    let sentence = format!("Mean errors squared before and after: {}.", words.join(", "));
    found.push(errors.iter().fold(Finding::new(sentence), |finding, (what, a, b)| {
        finding.with(&format!("{what} before"), *a, "deg²").with(&format!("{what} after"), *b, "deg²")
    }));
    Ok(FirstScreen { findings: found, picture: picture(findings.pictures, FIRST)? })
}

/// The page of the study.
pub(crate) fn page(findings: &Findings<'_>, claims: &[Claim], first: &FirstScreen<'_>) -> Page {
    let mut page = Page::new("Chapter 4: experimentally infused optimization of a tethered turbine, two parameters");
    first.show_in(&mut page);
    page.note(
        "No experiment was made. The water channel of the dissertation is replaced by a stand-in: the numerical model \
         plus stall plus added mass. Published figures stand beside ours. What was fitted is called calibrated and is \
         no reproduction; what the loop does with it is called predicted.",
    );
    page.paragraph(
        "A designer has a cheap numerical model of a tethered, buoyant wind turbine and wants the center of mass (plant) \
         and the pitch set point (controller) that fly best. The model is wrong. At each iteration the model is optimized, \
         five experiments are made at and around its optimum, and the model is corrected by the difference between the \
         measured slope of the cost and its own, with a trust R.",
    );
    page.heading(claims::BY_VERDICT);
    claims::by_verdict(claims).iter().for_each(|finding| page.finding(finding));
    iterations(&mut page, findings);
    calibrated(&mut page, findings);
    path(&mut page, findings);
    before_and_after(&mut page, findings);
    with_noise(&mut page, findings);
    page.heading("Margins and step size");
    page.table(&findings.box_table, BOX_CAPTION);
    page.table(&findings.step_table, &step_caption(findings));
    every_number(&mut page, findings);
    page
}

/// Pictures by the beginnings of their names.
fn show(page: &mut Page, findings: &Findings<'_>, names: &str) {
    let others = findings.pictures.iter().filter(|picture| picture.name != FIRST);
    for picture in others.filter(|picture| picture.name.starts_with(names)) {
        picture.show_in(page);
    }
}

fn iterations(page: &mut Page, findings: &Findings<'_>) {
    let setup = findings.material.setup;
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
        "The best design of the stand-in, found by optimizing the stand-in itself, is {} at a \
         cost of {:.3} s; the loop ends {:.1} % above it. Both ends of the valley were calibrated, which leaves room for \
         a fall of at most {:.1} %: that a loop with {} experiments finds its way down there is the prediction.",
        setup.sentence(&findings.best.point),
        findings.best.cost,
        findings.regret_pct(),
        findings.room_pct(),
        findings.printed().n_experiments()
    ));
}

fn calibrated(page: &mut Page, findings: &Findings<'_>) {
    page.heading("What was calibrated");
    page.table(&findings.calibration_table(), "Numbers that were fitted, with how well the fit is met in this run.");
    page.table(&findings.physics_table, PHYSICS_CAPTION);
    page.paragraph(&findings.identifiability());
}

fn path(page: &mut Page, findings: &Findings<'_>) {
    let m = &findings.material;
    page.heading("Where the loop went");
    show(page, findings, "landscape");
    page.paragraph(&findings.wells());
    page.paragraph(&findings.failures());
    page.table(&variant_table(m.setup, m.rows, Digits::Few), VARIANT_CAPTION);
    page.list(&findings.stops());
}

fn before_and_after(page: &mut Page, findings: &Findings<'_>) {
    page.heading("Before and after");
    page.list(&findings.what_changed());
    show(page, findings, "figure");
    page.table(
        &cost_table(findings.printed(), Digits::Few),
        "What each design of the printed loop costs in the stand-in. Terms inside the square of (21) share their products, \
         so that the terms sum to J.",
    );
    page.table(
        &flight_table(findings.printed(), Digits::Few),
        "How each design of the printed loop flies in the stand-in. Footprint: pi L² sin² Phi; full scale is 100 times \
         longer. The yaw mode is the least damped oscillation in which azimuth and twist lead, of the sampled closed loop \
         at trim at the first flow speed.",
    );
}

fn with_noise(page: &mut Page, findings: &Findings<'_>) {
    let (m, setup) = (&findings.material, findings.material.setup);
    page.heading("With noise");
    show(page, findings, "seeds");
    page.table(&seed_table(setup, m.seeded), "Median (smallest … largest) over the noise seeds.");
    page.paragraph(&format!(
        "Noise: within ±{} % of J, uniform, one draw per experiment, seeds {} to {}; the bound and the steps of the \
         experiments ({}) are ours. Simulations carry no noise: the seeds share {} remembered flights of the model and \
         interpolate between them (cubic); against {} flights of their own the largest error is {:.1e} of the cost. \
         Experiments are always flown.",
        100.0 * setup.file.noise.share,
        setup.file.noise.first_seed,
        setup.file.noise.first_seed + setup.file.noise.seeds - 1,
        setup.experiment_steps(),
        m.model.n_flights(),
        super::findings::CHECKED_POINTS,
        findings.interpolation_error
    ));
}

fn every_number(page: &mut Page, findings: &Findings<'_>) {
    let setup = findings.material.setup;
    page.heading("Every number");
    page.table(
        &provenance_table(&setup.bat.records),
        "Plant, controller, test and cost: value, unit and where each comes from.",
    );
    page.paragraph(&format!(
        "Made by `cargo xtask reproduce-chapter4` in {:.0} s with {} flights of the model and {} of the stand-in, each \
         300 s long.",
        findings.seconds,
        setup.bat.n_known(MODEL),
        setup.bat.n_known(STAND_IN)
    ));
}

/// The results as a page of `docs/`, without anything that differs from run to run.
pub(crate) fn markdown(findings: &Findings<'_>, claims: &[Claim], first: &str) -> String {
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
        "# Chapter 4: results\n\n{first}\n\
         Written by `cargo xtask reproduce-chapter4`; `cargo xtask ci` fails when this page is not what the command finds.\n\
         The water channel is replaced by a stand-in: the numerical model plus stall plus added mass.\n\
         Rows marked calibrated were fitted and reproduce nothing; see [departures](departures.md) for what is ours.\n\n{}\n\
         ## Table 3: dissertation / this run\n\n\
         The same with numbers of the plant identified from the experiments, alone and with the correction, is on the [page of identification](results-identification.md).\n\n{}\n\
         The calibrated costs leave room for a fall of at most {:.1} % (from the first row to the stand-in's best design, \
         {} at {:.3} s); the loop takes {:.1} %, the dissertation's {:.1} %.\n\n\
         ## What was calibrated\n\n{}\n## What moves the optimum\n\n{PHYSICS_CAPTION}\n\n{}\n## What is predicted\n\n{}\n## Where the wells of the stand-in are\n\n{}\n\n## Every loop, without noise\n\n{VARIANT_CAPTION}\n\n{}\n\
         ## What got better and what did not\n\nBefore (iteration 1) and after (last iteration), in the stand-in.\n\n{}\n## Costs of the printed loop's designs in the stand-in\n\n{}\n## How they fly\n\n{}\n\
         ## Over noise seeds\n\nFall of the experimental cost, noise taken off:\n\n{}\n{}\n\
         ## Margins over the box of Table 4\n\n{BOX_CAPTION}\n\n{}\n## Step size\n\n{}\n\n{}",
        claims::by_verdict_markdown(claims),
        side_by_side(m.setup, findings.printed()).markdown(),
        findings.room_pct(),
        m.setup.sentence(&findings.best.point),
        findings.best.cost,
        findings.printed().fall_pct(),
        findings.published_fall_pct(),
        findings.calibration_table().markdown(),
        findings.physics_table.markdown(),
        findings.prediction_table().markdown(),
        findings.wells(),
        variant_table(m.setup, m.rows, Digits::Few).markdown(),
        markdown_list(&findings.what_changed()),
        cost_table(findings.printed(), Digits::Few).markdown(),
        flight_table(findings.printed(), Digits::Few).markdown(),
        falls,
        seed_table(m.setup, m.seeded).markdown(),
        findings.box_table.markdown(),
        step_caption(findings),
        findings.step_table.markdown(),
    )
}

/// The closing summary, for a person who has not read the dissertation.
#[expect(clippy::print_stdout, reason = "the result of the command")]
pub(crate) fn print(findings: &Findings<'_>, out: &Path) {
    let rows = findings.printed();
    let (last, setup) = (rows.last(), findings.material.setup);
    println!("\nChapter 4: a wrong model, {} experiments, and what they taught it", rows.n_experiments());
    println!("(dissertation / this run; the water channel is replaced by a stand-in; lower costs are better)\n");
    println!("{}\n", side_by_side(setup, rows).text());
    println!("{}", headline(findings).sentence());
    println!(
        "The best design of the stand-in is {} at {:.2} s; the loop ends {:.1} % above it.",
        setup.sentence(&findings.best.point),
        findings.best.cost,
        findings.regret_pct()
    );
    let pitch_bound = setup.bounds(1).1;
    if (last.point[1] - pitch_bound).abs() < 1e-6 {
        let published = findings.published().last().map_or(f64::NAN, |row| row.pitch_set_point);
        println!(
            "The pitch set point ends at its bound of {pitch_bound} deg; in the dissertation it ends at {published} deg."
        );
    }
    println!(
        "\nWith noise of up to ±{} % on every measured cost, drawn {} times anew; R is how much of the measured slope the \
         loop takes over:",
        100.0 * setup.file.noise.share,
        setup.file.noise.seeds
    );
    for seeded in findings.material.seeded {
        if let Some(s) = Summary::of(&falls_pct(setup, seeded)) {
            println!(
                "  {:22} {} (median); best {}, worst {}",
                seeded.label,
                change_words(s.median),
                change_words(s.maximum),
                change_words(s.minimum)
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
