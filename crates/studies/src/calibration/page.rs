//! `docs/results-calibration.md`: how wide the plants spread, what they say of rows that nothing was fitted to, and what their models
//! are worth.

use std::path::Path;

use anyhow::Result;
use bat_dynamics::Fidelity;
use page::{Axis, Column, Finding, StripFigure, Table, strip_figure};

use super::candidate::STUDIES;
use super::default_plant::DefaultPlant;
use super::file::Calibration;
use super::free::Free;
use super::landscape::Diagnostics;
use super::outcome::{Member, Refusal};
use super::seen::{Look, Plants, Seen};
use super::store::Store;
use crate::bat::STAND_IN;
use crate::first_screen::around;
use crate::kept;
use crate::words::digits;

const PAGE: &str = "docs/results-calibration.md";
const PICTURE: &str = "docs/results-calibration.svg";

pub(super) fn write(root: &Path, calibration: &Calibration, store: &Store, beyond: &Store) -> Result<()> {
    let seen = Plants::new(root, calibration, &store.members)?.see_all()?;
    kept::write(root, &texts(calibration, [store, beyond], &seen)?)
}

/// That the committed page follows from the plants that are kept.
pub(super) fn check(root: &Path, calibration: &Calibration, stores: [&Store; 2], look: Look) -> Result<()> {
    let remedy = "does not follow from the plants kept: run `cargo xtask calibrate --page`";
    let seen = Plants::new(root, calibration, &stores[0].members)?.look_up(look)?;
    kept::check(root, &texts(calibration, stores, &seen)?, remedy)
}

fn texts(calibration: &Calibration, stores: [&Store; 2], seen: &[Seen]) -> Result<[(&'static str, String); 2]> {
    let default_plant = DefaultPlant::of(calibration, &stores[0].members)?;
    let page = markdown(calibration, stores, seen, &default_plant);
    Ok([(PAGE, page), (PICTURE, picture(calibration, stores[0]))])
}

/// Lowest, median and highest.
fn spread(values: impl Iterator<Item = f64>) -> [f64; 3] {
    let values: Vec<f64> = values.collect();
    [0.0, 0.5, 1.0].map(|share| page::quantile(&values, share).unwrap_or(f64::NAN))
}

fn words([low, middle, high]: [f64; 3], digits: usize) -> String {
    format!("{middle:.digits$} ({low:.digits$} to {high:.digits$})")
}

/// In how many fifths of its range a number lies in some plant.
fn n_fifths(calibration: &Calibration, store: &Store, index: usize) -> usize {
    let free = &calibration.free[index];
    let shares = || store.members.iter().map(|member| free.share(member.values[index]));
    (0..5).filter(|fifth| shares().any(|share| (share * 5.0).floor().clamp(0.0, 4.0) as usize == *fifth)).count()
}

fn markdown(
    calibration: &Calibration,
    [store, beyond]: [&Store; 2],
    seen: &[Seen],
    default_plant: &DefaultPlant<'_>,
) -> String {
    let mut text = format!("# {}\n\n", calibration.title);
    let mut findings = findings(calibration, store, seen);
    findings.extend([evidence_met(calibration, store), cloud(calibration, [store, beyond]), worth(seen)]);
    findings.push(Finding::new(default_words(default_plant)));
    text += &around(
        &findings,
        "![Where the plants lie in their ranges](results-calibration.svg)",
        "Each row is a number that is free, each dot a plant, from the lower end of the range at 0 to the upper at 1.",
    );
    text += "\nWritten by `cargo xtask calibrate` from `fixtures/bat/calibration.toml`, which has every range with its reason; the plants are \
             in `fixtures/bat/ensemble`. A run that is killed goes on where it was, `--page` writes this page alone, and `--check`, a \
             part of `cargo xtask ci`, flies every plant against its evidence.\n\n";
    text += "## Evidence\n\nWhat was fitted: it counts for nothing. Optima are the lowest cost over the box, between flights by cubic \
             interpolation.\n\n";
    text += &evidence_table(calibration, seen).markdown();
    text += &on_bounds(calibration, seen);
    text += "\n## Held out\n\nPublished numbers that nothing was fitted to: those of this table, the designs of Table 6 below, and on the \
             [page of the ensemble](results-ensemble.md) the shares of the space left (Tables 5 and 6) and Figures 20 to 23 and 26 to 28. \
             Figures 16 to 18 and 24 lie between fitted ends. Of the text no statement with a number was made evidence: all of them are held \
             out.\n\n";
    text += &held_out_table(calibration, seen).markdown();
    text += "\n### The path of Table 6\n\nWhat its designs cost in the stand-in as a part of what row 0 costs; the dissertation says that \
             the system becomes better along them, and prints no cost.\n\n";
    text += &table_6_table(seen).markdown();
    text += "\n## What a model of these plants is worth\n\nRank correlation of model and stand-in over the box; the share of the box that \
             is better in the stand-in than the optimum of the model; R² of the printed regressor (61) and of the full quadratic in the \
             stand-in's cost. Plants by the number of their start.\n\n";
    text += &diagnostics_table(store, seen).markdown();
    text +=
        "\n## Ranges\n\nLowest, median and highest of the plants, and in how many fifths of its range one lies.\n\n";
    text += &ranges_table(calibration, store).markdown();
    text
}

/// A center of mass or pitch nearer to the end of its range is on it, in per cent of chord and deg.
const ON_BOUND: f64 = 0.01;

/// In how many plants an optimum of the evidence lies on an end of its box: there the box has its share in the match.
fn on_bounds(calibration: &Calibration, seen: &[Seen]) -> String {
    let is_on = |[lower, upper]: [f64; 2], x: f64| x <= lower + ON_BOUND || x >= upper - ON_BOUND;
    let words =
        calibration.evidence.iter().enumerate().filter(|(_, evidence)| evidence.is_optimum).map(|(k, evidence)| {
            let bounds = calibration.boxes[evidence.study];
            let designs = seen.iter().filter_map(|seen| seen.evidence[k].0);
            let n = designs.filter(|design| (0..2).any(|axis| is_on(bounds[axis], design[axis]))).count();
            format!("{} in {n}", evidence.label)
        });
    format!(
        "\nOn an end of the box, of {} plants: {}. There the box, and not the plant alone, brings the optimum to the published place, and a claim that \
         a loop leads away from it can hardly fail.\n",
        seen.len(),
        words.collect::<Vec<_>>().join("; ")
    )
}

/// How many starts were refused for which reason.
fn refused(store: &Store) -> impl Iterator<Item = String> {
    Refusal::ALL.into_iter().filter_map(|refusal| {
        let count = store.starts.iter().filter(|start| start.refusal == Some(refusal)).count();
        (count > 0).then(|| format!("{count}: {}", refusal.words()))
    })
}

/// The first screen.
fn findings(calibration: &Calibration, store: &Store, seen: &[Seen]) -> Vec<Finding> {
    let n = store.members.len();
    let falls =
        seen.iter().filter(|seen| matches!((seen.table_6[0], seen.table_6[5]), (Some(a), Some(b)) if b < a)).count();
    let row_2 = spread(seen.iter().map(|seen| seen.held_out[0]));
    let printed = calibration.held_out[0].cost.unwrap_or(f64::NAN);
    let sentences = [
        format!(
            "{n} plants, from {} starts, meet the rows of Tables 3 and 5 that were fitted. They are a cloud about one plant, and not all that \
             the evidence allows: a free number spreads in the mean by {:.3} of its range (standard deviation over the plants), evenly drawn \
             ones by {:.3}.",
            store.starts.len(),
            mean_spread(calibration, &store.members),
            (1.0_f64 / 12.0).sqrt(),
        ),
        format!(
            "Predicted, not fitted: the experiment of Table 3, row 2, costs {} s where {printed} is printed (median, lowest to highest): {}.",
            words(row_2, 2),
            missed_words(calibration, seen, printed)
        ),
        worth_words(seen),
        format!("Along the printed path of Table 6 the cost falls from row 0 to row 5 in {falls} of {n} plants."),
    ];
    sentences.map(Finding::new).into()
}

/// What a plant has to meet, and why starts were refused.
fn evidence_met(calibration: &Calibration, store: &Store) -> Finding {
    let head = Finding::new(format!(
        "A plant is kept if each optimum lies within {} % of chord and {} deg of the printed one, over the whole box, and each cost within {} \
         %. Of {} starts were refused:",
        calibration.tolerance.center_of_mass,
        calibration.tolerance.pitch_set_point,
        100.0 * calibration.tolerance.cost,
        store.starts.len()
    ));
    head.with_sentences(refused(store).map(|words| format!("{words}.")))
}

/// How far the plants spread, and how many starts were kept by how far away they began.
fn cloud(calibration: &Calibration, [store, beyond]: [&Store; 2]) -> Finding {
    let fifths: Vec<usize> = (0..calibration.free.len()).map(|k| n_fifths(calibration, store, k)).collect();
    let wide = fifths.iter().filter(|count| **count >= 4).count();
    let head = Finding::new(format!(
        "Starts went {:.0} to {:.0} % of the way from the one where all begin to one drawn over the ranges.",
        100.0 * calibration.reach[0],
        100.0 * calibration.reach[1]
    ));
    let details = [
        format!("Of {} free numbers {wide} lie in at least four of the five fifths of their range.", fifths.len()),
        format!("Kept were, by reach: {}.", by_reach(calibration, store)),
        format!(
            "Of {} starts of {:.0} to {:.0} %, tried beside them, {} were kept ({}).",
            beyond.starts.len(),
            100.0 * calibration.beyond.0[0],
            100.0 * calibration.beyond.0[1],
            beyond.members.len(),
            refused(beyond).collect::<Vec<_>>().join("; ")
        ),
        format!(
            "With these a free number would spread by {:.3}.",
            mean_spread(calibration, &[store.members.as_slice(), &beyond.members].concat())
        ),
    ];
    head.with_sentences(details)
}

/// What the models of the plants are worth, study by study.
fn worth(seen: &[Seen]) -> Finding {
    let of =
        |study: usize, read: fn(&Diagnostics) -> f64| spread(seen.iter().map(|seen| read(&seen.diagnostics[study])));
    let each = |read: fn(&Diagnostics) -> f64, digits: usize| [0, 1].map(|study| words(of(study, read), digits));
    let [ranks, better, fits] =
        [each(|d| d.rank_correlation, 2), each(|d| 100.0 * d.better_than_model, 0), each(|d| d.additive_fit, 2)];
    let head = Finding::new(
        "What a model is worth, which was not made evidence, in Chapter 4 and in Chapter 7 with two parameters, median (lowest to highest):",
    );
    let details = [
        format!("Rank correlation of model and stand-in over the box: {} and {}.", ranks[0], ranks[1]),
        format!("Part of the box that is better than the model's optimum: {} and {} %.", better[0], better[1]),
        format!("R² of (61): {} and {}.", fits[0], fits[1]),
    ];
    head.with_sentences(details)
}

/// Standard deviation of a number over the plants, as a share of its range, in the mean over all numbers.
fn mean_spread(calibration: &Calibration, members: &[Member]) -> f64 {
    let of = |(index, free): (usize, &Free)| {
        let shares: Vec<f64> = members.iter().map(|member| free.share(member.values[index])).collect();
        let mean = shares.iter().sum::<f64>() / shares.len() as f64;
        (shares.iter().map(|share| (share - mean).powi(2)).sum::<f64>() / shares.len() as f64).sqrt()
    };
    calibration.free.iter().enumerate().map(of).sum::<f64>() / calibration.free.len() as f64
}

/// Quarters of the reach: how many starts of each were kept.
fn by_reach(calibration: &Calibration, store: &Store) -> String {
    let [least, most] = calibration.reach;
    let width = (most - least) / N_REACHES as f64;
    let of = |k: usize| {
        let from = least + width * k as f64;
        let inside = |reach: f64| ((reach - least) / width).floor().clamp(0.0, (N_REACHES - 1) as f64) as usize == k;
        let starts = store.starts.iter().filter(|start| inside(calibration.reach_of(start.number)));
        let kept = starts.clone().filter(|start| start.refusal.is_none()).count();
        format!("{kept} of {} starts of {:.0} to {:.0} %", starts.count(), 100.0 * from, 100.0 * (from + width))
    };
    (0..N_REACHES).map(of).collect::<Vec<_>>().join(", ")
}

const N_REACHES: usize = 4;

/// Whether plants meet the row that was held out as well as they have to meet those that were fitted.
fn missed_words(calibration: &Calibration, seen: &[Seen], printed: f64) -> String {
    let tolerance = calibration.tolerance.cost;
    let near = seen.iter().filter(|seen| (seen.held_out[0] / printed - 1.0).abs() <= tolerance).count();
    match near {
        0 => format!("every plant misses it by more than the {:.0} % of a fitted cost", 100.0 * tolerance),
        n => format!("within the {:.0} % of a fitted cost in {n} of {} plants", 100.0 * tolerance, seen.len()),
    }
}

/// A model ranks designs well from this rank correlation on.
const RANKS_WELL: f64 = 0.7;

fn worth_words(seen: &[Seen]) -> String {
    let ranks = || seen.iter().flat_map(|seen| seen.diagnostics.iter().map(|found| found.rank_correlation));
    let highest = ranks().fold(f64::NEG_INFINITY, f64::max);
    let least = seen.iter().flat_map(|seen| seen.diagnostics.iter().map(|found| found.better_than_model));
    let least = least.fold(f64::INFINITY, f64::min);
    if highest < RANKS_WELL {
        format!(
            "No plant has a model that ranks designs well: the highest rank correlation is {highest:.2}, and at least {:.0} % of the box is better \
             than the model's optimum in each.",
            100.0 * least
        )
    } else {
        format!("The highest rank correlation is {highest:.2}.")
    }
}

fn default_words(DefaultPlant { member, mean_distance }: &DefaultPlant<'_>) -> String {
    format!(
        "The default plant of the other commands is plant {} of these, chosen by a rule: it is the medoid, the one with the least mean \
         distance to all others, {mean_distance:.3}, each free number taken as a share of its range. `cargo xtask calibrate --default` \
         writes its numbers, to seven digits, into the rig and the weights.",
        member.start
    )
}

fn fidelity_words(fidelity: Fidelity) -> &'static str {
    if fidelity == STAND_IN { "stand-in" } else { "model" }
}

fn evidence_table(calibration: &Calibration, seen: &[Seen]) -> Table {
    let heads = ["evidence", "study", "fidelity"].map(Column::words);
    let numbers = [
        ("center of mass", "% chord"),
        ("found", "% chord"),
        ("pitch", "deg"),
        ("found", "deg"),
        ("cost", "s"),
        ("found", "s"),
    ];
    let mut table =
        Table::new(heads.into_iter().chain(numbers.map(|(name, unit)| Column::number(name, unit))).collect());
    for (index, evidence) in calibration.evidence.iter().enumerate() {
        let found = |k: usize, digits: usize| {
            let places = seen.iter().filter_map(|seen| Some(seen.evidence[index].0?[k]));
            if evidence.is_optimum { words(spread(places), digits) } else { String::new() }
        };
        let cost = || words(spread(seen.iter().map(|seen| seen.evidence[index].1)), 2);
        table.push(vec![
            evidence.label.clone(),
            STUDIES[evidence.study].to_owned(),
            fidelity_words(evidence.fidelity).to_owned(),
            evidence.design[0].to_string(),
            found(0, 2),
            evidence.design[1].to_string(),
            found(1, 2),
            evidence.cost.map_or_else(String::new, |cost| cost.to_string()),
            if evidence.cost.is_some() { cost() } else { String::new() },
        ]);
    }
    table
}

fn held_out_table(calibration: &Calibration, seen: &[Seen]) -> Table {
    let mut table = Table::new(vec![
        Column::words("row"),
        Column::number("printed", "s"),
        Column::number("predicted", "s"),
        Column::number("predicted over printed", "1"),
    ]);
    for (index, row) in calibration.held_out.iter().enumerate() {
        let predicted = || seen.iter().map(|seen| seen.held_out[index]);
        let printed = row.cost.unwrap_or(f64::NAN);
        table.push(vec![
            row.label.clone(),
            row.cost.map_or_else(String::new, |cost| cost.to_string()),
            words(spread(predicted()), 2),
            words(spread(predicted().map(|cost| cost / printed)), 3),
        ]);
    }
    table
}

fn table_6_table(seen: &[Seen]) -> Table {
    let heads = vec![Column::words("row of Table 6"), Column::number("cost as a part of that of row 0", "1")];
    let mut table = Table::new(heads);
    for row in 0..seen.first().map_or(0, |seen| seen.table_6.len()) {
        let share = seen.iter().filter_map(|seen| Some(seen.table_6[row]? / seen.table_6[0]?));
        table.push(vec![row.to_string(), words(spread(share), 2)]);
    }
    table
}

fn diagnostics_table(store: &Store, seen: &[Seen]) -> Table {
    let names = ["rank correlation", "better than the model's optimum, %", "R² of (61)", "R² of the quadratic"];
    let of_each = STUDIES.iter().flat_map(|study| names.map(|name| Column::number(&format!("{study}: {name}"), "1")));
    let mut table = Table::new(std::iter::once(Column::number("start", "1")).chain(of_each).collect());
    for (Member { start, .. }, seen) in store.members.iter().zip(seen) {
        let numbers = seen.diagnostics.iter().flat_map(|found| {
            [
                format!("{:.2}", found.rank_correlation),
                format!("{:.0}", 100.0 * found.better_than_model),
                format!("{:.2}", found.additive_fit),
                format!("{:.2}", found.quadratic_fit),
            ]
        });
        table.push(std::iter::once(start.to_string()).chain(numbers).collect());
    }
    table
}

fn ranges_table(calibration: &Calibration, store: &Store) -> Table {
    let heads = [Column::words("number"), Column::words("unit")];
    let numbers = ["lower", "upper", "plants", "fifths"].map(|name| Column::number(name, "1"));
    let mut table = Table::new(heads.into_iter().chain(numbers).chain([Column::words("reason")]).collect());
    for (index, free) in calibration.free.iter().enumerate() {
        let [low, middle, high] = spread(store.members.iter().map(|member| member.values[index]));
        table.push(vec![
            format!("`{}`", free.key),
            free.unit.clone(),
            format!("{}", free.lower),
            format!("{}", free.upper),
            format!("{} ({} to {})", digits(middle), digits(low), digits(high)),
            n_fifths(calibration, store, index).to_string(),
            free.reason.clone(),
        ]);
    }
    table
}

fn picture(calibration: &Calibration, store: &Store) -> String {
    let row = |(index, free): (usize, &Free)| {
        let shares = store.members.iter().map(|member| free.share(member.values[index]));
        (free.key.trim_start_matches("plant.").replace('_', " "), shares.collect())
    };
    strip_figure(&StripFigure {
        title: format!("{} plants within their ranges", store.members.len()),
        x_axis: Axis::new("share of the range", "1").with_range(0.0, 1.0),
        rows: calibration.free.iter().enumerate().map(row).collect(),
    })
}
