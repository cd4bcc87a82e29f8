//! What a person reads of Chapter 3: figures, tables, sentences made of numbers.

use std::path::Path;

use water_channel::LogRow;

use super::Findings;
use super::file::Setup;
use super::panels::{Design, PanelFlights};
use crate::claims::{self, Claim, Place, Verdict};
use crate::provenance::provenance_table;
use crate::reproduction::{Picture, markdown_list};
use page::Page;
use page::{Axis, Landscape, LineFigure, Panel, Points, Series, landscape_panels_figure, line_figure};
use page::{Column, Table};

const SURROGATE: &str = "No experiment was made. The water channel of the dissertation is replaced by a surrogate, the numerical \
    model plus stall plus added mass. The plant was calibrated to rows 1 of Tables 3 and 5 and to the best design of Table 3; \
    nothing in this chapter was fitted to Figure 14, which shows no numbers that could be read.";

const BEST_CAPTION: &str = "The stable design with the lowest cost (20) in each panel, among the centers of mass that Table 4 \
    allows and over the whole lattice; with the shares of heading and lateral position in the cost, and the rate at which the \
    slowest disturbance grows (negative: dies out) at the worst speed of the test.";

const COUNT_CAPTION: &str = "What the designs of the lattice do. Unstable: a small disturbance grows at one of the three speeds, \
    with the lines held as they are trimmed at the first; such a design may still get through the test, slowly growing. \
    A slack line or a state outside the model ends a flight without a cost.";

/// Whether Table 4 allows a center of mass.
fn is_allowed(setup: &Setup, center_of_mass: f64) -> bool {
    setup.center_of_mass.table4.is_none_or(|[lower, upper]| (lower..=upper).contains(&center_of_mass))
}

/// Whether the center of mass is one that Table 4 allows.
pub(crate) fn in_table4(setup: &Setup, design: &Design) -> bool {
    is_allowed(setup, design.at[0])
}

/// Four landscapes with one scale of colors.
pub(crate) fn figure14(findings: &Findings<'_>, panels: &[PanelFlights<'_>], name: &str, physics: &str) -> Picture {
    let setup = findings.setup;
    let z_axis = cost_axis(findings);
    let landscapes: Vec<Landscape> = panels
        .iter()
        .zip('a'..)
        .map(|(panel, letter)| Landscape {
            title: format!("({letter}) {}", panel.configuration.label),
            x_axis: Axis::new("center of mass", "% chord"),
            y_axis: Axis::new("trim pitch", "deg"),
            z_axis: z_axis.clone(),
            x: setup.center_of_mass.places(),
            y: setup.trim_pitch.places(),
            z: panel
                .rows
                .iter()
                .map(|row| row.iter().map(|design| design.cost().map_or(f64::NAN, f64::log10)).collect())
                .collect(),
            missing_label: "a line goes slack, or the state leaves the model".to_owned(),
            points: vec![Points::small(
                "unstable",
                panel
                    .unstable()
                    .filter(|design| design.cost().is_some())
                    .map(|design| (design.at[0], design.at[1]))
                    .collect(),
            )],
            verticals: setup.center_of_mass.table4.map_or(Vec::new(), |bounds| bounds.to_vec()),
            verticals_label: "bounds of Table 4".to_owned(),
            paths: Vec::new(),
            minimum: panel.best(|design| in_table4(setup, design)).map(|(best, _)| (best.at[0], best.at[1])),
            minimum_label: "best stable design within Table 4".to_owned(),
        })
        .collect();
    Picture {
        name: name.to_owned(),
        svg: landscape_panels_figure(&format!("Open-loop cost in {physics}"), &landscapes),
        caption: format!(
            "The counterpart of Figure 14 in {physics}: cost (20) over trim pitch and center of mass, for four settings of fin \
             incidence and lines. Colors go by the logarithm, the same in both physics; above the highest, all values have its color."
        ),
    }
}

/// One scale of colors for both physics, up to what nine tenths of the designs stay below.
fn cost_axis(findings: &Findings<'_>) -> Axis {
    let panels = findings.stand_in.iter().chain(&findings.model);
    let mut costs: Vec<f64> = panels.flat_map(PanelFlights::designs).filter_map(Design::cost).map(f64::log10).collect();
    costs.sort_by(f64::total_cmp);
    let axis = Axis::new("log10 of the cost (20) in s", "1");
    match (costs.first(), costs.get(costs.len() * 9 / 10)) {
        (Some(lowest), Some(high)) if lowest < high => {
            axis.with_range((5.0 * lowest).floor() / 5.0, (5.0 * high).ceil() / 5.0)
        }
        _ => axis,
    }
}

/// What one open-loop flight looks like.
pub(crate) fn one_flight(findings: &Findings<'_>) -> Picture {
    let rows = &findings.shown.rows;
    let column = |f: fn(&LogRow) -> f64| -> Vec<f64> { rows.iter().map(f).collect() };
    let t = column(|row| row.time_s);
    let panel = |y_axis: Axis, series: Vec<Series>| Panel { x_axis: None, y_axis, series };
    let line = |k: usize| -> Vec<f64> { rows.iter().map(|row| 1000.0 * row.commands_m_s[k]).collect() };
    let figure = LineFigure {
        title: "The open-loop test: the best design of the first panel".to_owned(),
        x_axis: Axis::new("time", "s").with_range(0.0, findings.setup.profile.duration_s()),
        panels: vec![
            panel(Axis::new("flow speed", "m/s"), vec![Series::step("flow", &t, &column(|row| row.flow_speed_m_s))]),
            panel(
                Axis::new("command", "mm/s"),
                vec![
                    Series::step("line 1, center", &t, &line(0)),
                    Series::step("line 2, starboard", &t, &line(1)),
                    Series::step("line 3, port", &t, &line(2)),
                ],
            ),
            panel(
                Axis::new("heading", "deg"),
                vec![Series::line("heading", &t, &column(|row| row.heading_rad.to_degrees()))],
            ),
            panel(
                Axis::new("lateral position", "mm"),
                vec![Series::line("lateral position", &t, &column(|row| 1000.0 * row.lateral_m))],
            ),
        ],
        shaded: None,
    };
    Picture {
        name: "one-flight".to_owned(),
        svg: line_figure(&figure),
        caption: "One flight of the test in the stand-in: at each speed the three lines are reeled in, held and let out one after \
                  the other; between and after that the lines keep their lengths. The times of the sequence are ours."
            .to_owned(),
    }
}

fn best_table(findings: &Findings<'_>, panels: &[PanelFlights<'_>]) -> Table {
    let mut table = Table::new(vec![
        Column::new("configuration", ""),
        Column::new("center of mass", "% chord"),
        Column::new("trim pitch", "deg"),
        Column::new("cost", "s"),
        Column::new("heading", "%"),
        Column::new("lateral", "%"),
        Column::new("growth", "1/s"),
        Column::new("whole lattice", ""),
    ]);
    for panel in panels {
        let whole = panel.best(|_| true).map_or("none".to_owned(), |(design, cost)| {
            format!("{:.2} % chord, {:.0} deg: {cost:.4} s", design.at[0], design.at[1])
        });
        let mut row = vec![panel.configuration.label.clone()];
        row.extend(match panel.best(|design| in_table4(findings.setup, design)) {
            None => vec!["none".to_owned(); 6],
            Some((design, cost)) => {
                let terms = design.outcome.clone().unwrap_or([f64::NAN; 2]);
                vec![
                    format!("{:.2}", design.at[0]),
                    format!("{:.0}", design.at[1]),
                    format!("{cost:.4}"),
                    format!("{:.1}", 100.0 * terms[0] / cost),
                    format!("{:.1}", 100.0 * terms[1] / cost),
                    design.growth_per_s.as_ref().map_or("–".to_owned(), |growth| format!("{growth:.2}")),
                ]
            }
        });
        row.push(whole);
        table.push(row);
    }
    table
}

fn count_table(panels: &[PanelFlights<'_>]) -> Table {
    let mut table = Table::new(vec![
        Column::new("configuration", ""),
        Column::new("designs", "1"),
        Column::new("slack line", "1"),
        Column::new("left the model, or no trim", "1"),
        Column::new("no equilibrium at some speed", "1"),
        Column::new("unstable", "1"),
        Column::new("of these without a cost", "1"),
        Column::new("unstable up to", "% chord"),
    ]);
    for panel in panels {
        let furthest = panel.unstable().map(|design| design.at[0]).reduce(f64::max);
        table.push(vec![
            panel.configuration.label.clone(),
            panel.designs().count().to_string(),
            panel.slack().to_string(),
            panel.other_failures().to_string(),
            panel.without_equilibrium().to_string(),
            panel.unstable().count().to_string(),
            panel.unstable().filter(|design| design.cost().is_none()).count().to_string(),
            furthest.map_or("–".to_owned(), |x| format!("{x:.2}")),
        ]);
    }
    table
}

/// The middle of the values, and what four fifths of them stay below and above.
fn spread(mut values: Vec<f64>) -> Option<[f64; 3]> {
    values.sort_by(f64::total_cmp);
    let at = |share: f64| values.get((share * (values.len().max(1) - 1) as f64).round() as usize).copied();
    Some([at(0.1)?, at(0.5)?, at(0.9)?])
}

/// The cost of each stable design within Table 4 relative to the same design elsewhere.
fn ratios(setup: &Setup, of: &PanelFlights<'_>, to: &PanelFlights<'_>) -> Vec<f64> {
    let pairs = of.designs().zip(to.designs());
    pairs
        .filter(|(a, b)| a.is_stable() && b.is_stable() && in_table4(setup, a))
        .filter_map(|(a, b)| Some(a.cost()? / b.cost()?))
        .collect()
}

/// Whether the best of the allowed designs lies where the allowed lattice ends.
fn is_at_an_end(setup: &Setup, design: &Design) -> bool {
    let mut x = setup.center_of_mass.places();
    x.retain(|x| is_allowed(setup, *x));
    [(x, design.at[0]), (setup.trim_pitch.places(), design.at[1])].iter().any(|(places, at)| {
        let is_end = |end: Option<&f64>| end.is_some_and(|end| (end - at).abs() < 1e-9);
        is_end(places.first()) || is_end(places.last())
    })
}

/// Where the best designs lie, and what moves them.
fn about_the_best(findings: &Findings<'_>) -> Vec<String> {
    let (setup, panels) = (findings.setup, &findings.stand_in);
    let inside = |design: &Design| in_table4(setup, design);
    let mut sentences = Vec::new();
    let best: Vec<&Design> = panels.iter().filter_map(|panel| Some(panel.best(inside)?.0)).collect();
    let at_an_end = best.iter().filter(|design| is_at_an_end(setup, design)).count();
    sentences.push(format!(
        "Within Table 4, {at_an_end} of the {} best designs lie at an end of the range of center of mass or trim pitch: there the \
         range decides and not the cost.",
        best.len()
    ));
    let first = &panels[0];
    if let (Some((_, low)), Some((_, high))) = (first.best(inside), first.worst(inside)) {
        sentences.push(format!(
            "In the first panel the cost varies by a factor of {:.0} over the stable designs within Table 4.",
            high / low
        ));
    }
    for panel in &panels[1..] {
        let at_best = first.best(inside).and_then(|(best, cost)| {
            let same = panel.designs().find(|design| design.at.map(f64::to_bits) == best.at.map(f64::to_bits))?;
            Some(same.cost()? / cost)
        });
        if let (Some([low, middle, high]), Some(at_best)) = (spread(ratios(setup, panel, first)), at_best) {
            sentences.push(format!(
                "{}: {middle:.2} times the cost of the same design in the first panel (median of the stable designs within Table 4; \
                 {low:.2} to {high:.2} for four fifths); {at_best:.2} times at the first panel's best design.",
                panel.configuration.label
            ));
        }
    }
    sentences
}

/// How far apart the growth rates of two panels are, at most.
fn growth_apart(a: &PanelFlights<'_>, b: &PanelFlights<'_>) -> Option<f64> {
    let pairs = a.designs().zip(b.designs());
    pairs
        .filter_map(|(a, b)| Some((a.growth_per_s.as_ref().ok()? - b.growth_per_s.as_ref().ok()?).abs()))
        .reduce(f64::max)
}

/// What the panels say, in sentences.
fn sentences(findings: &Findings<'_>) -> Vec<String> {
    let (setup, panels) = (findings.setup, &findings.stand_in);
    let inside = |design: &Design| in_table4(setup, design);
    let mut sentences = about_the_best(findings);
    for panel in &panels[1..] {
        if let Some(apart) = growth_apart(panel, &panels[0]).filter(|apart| *apart < 1e-9) {
            sentences.push(format!(
                "{}: its modes are those of the first panel (growth rates within {:.0e} 1/s). In this plant the layout decides only \
                 which way a reeled line pitches the body, so the difference in cost is the answer to the perturbation, whose times \
                 are ours, and no better or worse flight by itself.",
                panel.configuration.label,
                10.0_f64.powf(apart.max(1e-16).log10().ceil())
            ));
        }
    }
    let unstable: Vec<&Design> = panels.iter().flat_map(PanelFlights::unstable).collect();
    let model_unstable = findings.model.iter().flat_map(PanelFlights::unstable).count();
    if let Some(aft) = unstable.iter().map(|design| design.at[0]).reduce(f64::max) {
        let within = unstable.iter().filter(|design| inside(design)).count();
        sentences.push(format!(
            "{} of {} designs are unstable in the stand-in, none with the center of mass aft of {aft:.2} % chord ({within} within \
             Table 4); in the numerical model {model_unstable} are.",
            unstable.len(),
            panels.iter().flat_map(PanelFlights::designs).count()
        ));
    } else {
        sentences.push(format!("No design is unstable in the stand-in; in the numerical model {model_unstable} are."));
    }
    let terms = panels.iter().flat_map(PanelFlights::designs).filter_map(|design| design.outcome.as_ref().ok());
    if let Some([low, middle, high]) =
        spread(terms.map(|[heading, lateral]| 100.0 * lateral / (heading + lateral)).collect())
    {
        sentences.push(format!(
            "The two terms of (20) are called equally important; as weighted, the lateral position makes {middle:.1} % of the \
             cost (median; {low:.1} to {high:.1} % for four fifths): 10 deg of heading weigh as much as {:.2} m of position.",
            10.0_f64.to_radians() * (setup.weights.heading / setup.weights.lateral).sqrt()
        ));
    }
    let pairs = findings.stand_in.iter().zip(&findings.model);
    if let Some([low, middle, high]) = spread(pairs.flat_map(|(a, b)| ratios(setup, a, b)).collect()) {
        sentences.push(format!(
            "The stand-in's cost is {middle:.1} times the numerical model's at the same design (median of the stable designs within \
             Table 4; {low:.1} to {high:.1} for four fifths)."
        ));
    }
    sentences
}

/// What the dissertation claims in this chapter, and what of it came out.
pub(crate) fn claims(findings: &Findings<'_>) -> Vec<Claim> {
    let inside = |design: &Design| in_table4(findings.setup, design);
    let spans: Vec<f64> =
        findings.stand_in.iter().filter_map(|panel| Some(panel.worst(inside)?.1 / panel.best(inside)?.1)).collect();
    let depends = spans.len() == findings.stand_in.len() && spans.iter().all(|span| *span > MATTERS);
    let words: Vec<String> = spans.iter().map(|span| format!("{span:.1}")).collect();
    let claim = Claim::new(
        Place::Figure(14),
        "In each of four configurations the open-loop cost depends on trim pitch and center of mass",
        Verdict::in_kind_if(depends),
        format!(
            "In the stand-in the highest cost of the stable designs within Table 4 is {} times the lowest, panel by panel. The figure \
             prints no numbers that could be compared.",
            words.join(", ")
        ),
    );
    vec![claim.shown_in(&["figure-14"])]
}

/// A cost that varies by less than this factor would depend on nothing.
const MATTERS: f64 = 1.5;

/// The page of the study.
pub(crate) fn page(findings: &Findings<'_>, claims: &[Claim], pictures: &[Picture]) -> Page {
    let mut page = Page::new("Chapter 3: which configurations fly well without a controller");
    claims::begin(&mut page, claims, pictures.first());
    page.note(SURROGATE);
    page.paragraph(
        "Before anything is optimized, the bare machine is compared in four configurations: with the horizontal fin at three angles \
         of incidence, and with one or two of its three lines forward. No controller runs. The center of mass and the trim pitch \
         are varied, the lines are reeled in and out one after the other at three flow speeds, and the cost is the integral of \
         heading and lateral position squared.",
    );
    page.heading("Figure 14");
    page.list(&sentences(findings));
    page.table(&best_table(findings, &findings.stand_in), BEST_CAPTION);
    page.table(&count_table(&findings.stand_in), COUNT_CAPTION);
    page.heading("The test");
    pictures[2].show_in(&mut page);
    page.heading("The same in the numerical model");
    page.paragraph("Without stall and added mass, which is what a designer has before any experiment.");
    pictures[1].show_in(&mut page);
    page.table(&best_table(findings, &findings.model), BEST_CAPTION);
    page.table(&count_table(&findings.model), COUNT_CAPTION);
    page.heading("Every number");
    page.table(
        &provenance_table(&findings.setup.records),
        "Plant, controller and test: value, unit and where each comes from. Center of mass, pitch set point, fin incidence and \
         layout are replaced by those of each design; the controller's gains are not used.",
    );
    page.paragraph(&format!("Made by `cargo xtask reproduce-chapter3` in {:.0} s.", findings.seconds));
    page
}

/// The results as a page of `docs/`.
pub(crate) fn markdown(findings: &Findings<'_>, claims: &[Claim]) -> String {
    format!(
        "# Chapter 3: results\n\n\
         Written by `cargo xtask reproduce-chapter3`; `cargo xtask ci` fails when this page is not what the command finds.\n\
         {SURROGATE}\n\n{}\n\
         ## Figure 14, in the stand-in\n\n{}\n{BEST_CAPTION}\n\n{}\n{COUNT_CAPTION}\n\n{}\n\
         ## In the numerical model\n\n{}\n{}",
        claims::beginning(claims),
        markdown_list(&sentences(findings)),
        best_table(findings, &findings.stand_in).markdown(),
        count_table(&findings.stand_in).markdown(),
        best_table(findings, &findings.model).markdown(),
        count_table(&findings.model).markdown(),
    )
}

/// The closing summary.
#[expect(clippy::print_stdout, reason = "the result of the command")]
pub(crate) fn print(findings: &Findings<'_>, out: &Path) {
    println!(
        "\nChapter 3: which configurations fly well without a controller (in the stand-in for the water channel)\n"
    );
    println!("{}\n", best_table(findings, &findings.stand_in).text());
    for sentence in sentences(findings) {
        println!("- {sentence}");
    }
    println!("\nPage, figures and data: {} (open index.html), after {:.0} s.", out.display(), findings.seconds);
}
