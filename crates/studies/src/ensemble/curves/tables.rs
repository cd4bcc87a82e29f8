//! What the curves say in numbers.

use page::{Column, Finding, Table, quantile};

use super::figures::{DESIGNS, fallen, lost};
use super::kept::{ERROR, ITERATIONS, LEFT, cases_of_figure21, of_bin, of_iteration, of_place, over, places_in_table4};
use crate::ensemble::file::Setup;
use crate::ensemble::kept::Case;
use crate::ensemble::row::{Study, World};
use crate::ensemble::tables::quartiles_of;
use crate::words::{capitalized, number};

/// Figure 14: where the lowest cost lies within Table 4, panel by panel.
pub(in crate::ensemble) fn lowest(setup: &Setup, cases: &[Case<'_>]) -> Table {
    let mut table = Table::new(vec![
        Column::new("Configuration", ""),
        Column::new("Plants with a stable design", "1"),
        Column::new("Lowest cost (20)", "s"),
        Column::new("at center of mass", "% chord"),
        Column::new("at an end of Table 4", "plants"),
        Column::new("Highest of the curve over the lowest", "1"),
    ]);
    let study = &setup.chapter3;
    let places = places_in_table4(study);
    let ends = [places.first(), places.last()].map(|end| end.map(|(place, _)| *place));
    for (panel, configuration) in study.configurations.iter().enumerate() {
        let (mut costs, mut at, mut spans, mut at_an_end) = (Vec::new(), Vec::new(), Vec::new(), 0);
        for case in cases.iter().filter(|case| case.study == Study::Chapter3) {
            let curve = places.iter().filter_map(|(place, x)| Some((*place, *x, case.fact(&of_place(panel, *place))?)));
            let curve: Vec<(usize, f64, f64)> = curve.collect();
            let lowest = curve.iter().min_by(|a, b| a.2.total_cmp(&b.2));
            let highest = curve.iter().map(|(.., cost)| *cost).fold(f64::NAN, f64::max);
            if let Some((place, x, cost)) = lowest {
                costs.push(*cost);
                at.push(*x);
                spans.push(highest / cost);
                at_an_end += usize::from(ends.contains(&Some(*place)));
            }
        }
        table.push(vec![
            configuration.label.clone(),
            costs.len().to_string(),
            quartiles_of(&costs, 4),
            quartiles_of(&at, 2),
            at_an_end.to_string(),
            quartiles_of(&spans, 1),
        ]);
    }
    table
}

/// Figure 21: the end, truth by truth and noise by noise.
pub(in crate::ensemble) fn errors(setup: &Setup, cases: &[Case<'_>]) -> Table {
    let study = &setup.chapter6;
    let last = ITERATIONS[ITERATIONS.len() - 1];
    let mut table = Table::new(vec![
        Column::new("Truth", ""),
        Column::new("Noise", "%"),
        Column::new("Error after the first iteration", "% of that without correction"),
        Column::new(&format!("after {last}"), "%"),
        Column::new("of the worst plant", "%"),
        Column::new("Plants with less than without", ""),
        Column::new("Space left", "%"),
    ]);
    for case in cases_of_figure21(study) {
        let of = |what: &str, iteration: usize| {
            over(cases, Study::Chapter6, World::Still, &of_iteration(study, case, iteration, what))
        };
        let shares = |what: &str, iteration: usize| -> Vec<f64> {
            of(what, iteration).into_iter().map(|share| 100.0 * share).collect()
        };
        let (errors, at_the_end) = (of(ERROR, last), shares(ERROR, last));
        table.push(vec![
            study.truth(case.truth).label.clone(),
            number(100.0 * case.noise, 0),
            quartiles_of(&shares(ERROR, ITERATIONS[0]), 0),
            quartiles_of(&at_the_end, 1),
            number(at_the_end.iter().copied().fold(f64::NAN, f64::max), 0),
            format!("{} of {}", errors.iter().filter(|share| **share < 1.0).count(), errors.len()),
            quartiles_of(&shares(LEFT, last), 1),
        ]);
    }
    table
}

/// Figure 26: of how many designs poses are lost, by the pixels that the camera has to spare.
pub(in crate::ensemble) fn headings(setup: &Setup, cases: &[Case<'_>]) -> Table {
    let mut table = Table::new(vec![
        Column::new("Design", ""),
        Column::new("To spare on each side", "px"),
        Column::new("Designs that fly before the whole image", "1"),
        Column::new("lose poses", "1"),
        Column::new("cannot fly so", "1"),
        Column::new("Largest error of the heading", "deg"),
        Column::new("worst plant", "deg"),
    ]);
    for (method, words) in DESIGNS {
        for margin_px in &setup.regions.margins_px {
            let [lose, fail, n] = lost(cases, method, *margin_px);
            let is_shown = margin_px.to_bits() == setup.regions.shown_px.to_bits();
            let largest = |case: &Case<'_>| {
                (0..).map_while(|bin| case.fact(&of_bin(method, bin))).reduce(f64::max).filter(|_| is_shown)
            };
            let largest: Vec<f64> = cases.iter().filter_map(largest).collect();
            table.push(vec![
                words.to_owned(),
                number(*margin_px, 0),
                n.to_string(),
                lose.to_string(),
                fail.to_string(),
                quartiles_of(&largest, 1),
                quantile(&largest, 1.0).map_or("–".to_owned(), |value| number(value, 1)),
            ]);
        }
    }
    table
}

/// The same with the pixels that are drawn, in a sentence.
pub(in crate::ensemble) fn lost_poses(setup: &Setup, cases: &[Case<'_>]) -> Finding {
    let each = DESIGNS.map(|(method, words)| {
        let [lose, fall, n] = lost(cases, method, setup.regions.shown_px);
        let falls = if fall > 0 { format!(" ({fall} more fall)") } else { String::new() };
        format!("{}: {lose} of {n}{falls}.", capitalized(words))
    });
    Finding::new(format!(
        "Spikes of the heading (Figure 26): before one camera with a narrow region of interest ({} px to spare) the heading is lost for a \
         while, as in the dissertation. Designs that lose it so:",
        setup.regions.shown_px
    ))
    .with_sentences(each)
}

/// What falls before the whole image, in a sentence.
pub(in crate::ensemble) fn fallen_in_words(cases: &[Case<'_>]) -> String {
    let each = DESIGNS.map(|(method, words)| {
        let [n, fall] = fallen(cases, method);
        format!("{words} {fall} of {n}")
    });
    format!("Before the whole image these cannot fly, and are left out: {}.", each.join("; "))
}
