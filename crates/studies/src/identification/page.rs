//! `docs/results-identification.md`: Table 3 by each mechanism, what it does to predictions, and what the identified numbers mean.

use std::path::Path;

use anyhow::{Context as _, Result};
use page::{Axis, Column, Finding, Group, Reference, SpreadFigure, Table, spread_figure};
use rayon::prelude::*;

use super::file::Study;
use super::held_out::{HeldOut, Score};
use super::plant::Doubted;
use super::store::{Found, Kept, Store};
use super::which::Which;
use crate::first_screen::around;
use crate::kept;
use crate::words::{capitalized, digits, number, signed};

const PAGE: &str = "docs/results-identification.md";
const PICTURE: &str = "docs/results-identification.svg";

/// What the flights of a campaign say.
struct Seen<'a> {
    kept: &'a Kept,
    /// The design of each iteration in the stand-in, noise taken off.
    costs: Vec<f64>,
    score: Score,
}

/// Campaigns of one loop.
struct LoopSeen<'a> {
    label: &'a str,
    silent: Seen<'a>,
    noisy: Vec<Seen<'a>>,
}

pub(super) fn write(root: &Path, study: &Study, store: &Store) -> Result<()> {
    kept::write(root, &texts(study, store)?)
}

/// That the committed page follows from the campaigns that are kept.
pub(super) fn check(root: &Path, study: &Study, store: &Store) -> Result<()> {
    let remedy = "does not follow from the campaigns kept: run `cargo xtask identify --page`";
    kept::check(root, &texts(study, store)?, remedy)
}

fn texts(study: &Study, store: &Store) -> Result<[(&'static str, String); 2]> {
    let held_out = HeldOut::fly(study);
    held_out.fly_last(study, store.campaigns());
    // Flown together they fill the lanes.
    let designs = store.campaigns().iter().flat_map(|kept| kept.turns.iter().map(|turn| turn.design.clone()));
    Doubted(study).stand_in(&designs.collect::<Vec<_>>());
    let loops = study.loops.iter().enumerate().map(|(index, entry)| {
        let silent =
            store.find(Which { index, seed: None }).with_context(|| format!("no campaign `{}`", entry.label))?;
        let noisy = store.noisy(index);
        let noisy = noisy.par_iter().map(|kept| see(study, &held_out, kept)).collect::<Result<_>>()?;
        Ok(LoopSeen { label: &entry.label, silent: see(study, &held_out, silent)?, noisy })
    });
    let loops: Vec<LoopSeen<'_>> = loops.collect::<Result<_>>()?;
    let zero = [0.0; 2];
    let untouched = held_out.score(study, study.unknowns.start(), &zero, 0.0);
    Ok([(PAGE, markdown(study, &loops, &held_out, untouched)), (PICTURE, picture(study, &loops))])
}

fn see<'a>(study: &Study, held_out: &HeldOut, kept: &'a Kept) -> Result<Seen<'a>> {
    let designs: Vec<Vec<f64>> = kept.turns.iter().map(|turn| turn.design.clone()).collect();
    let flown = Doubted(study).stand_in(&designs);
    let score = held_out.score_of(study, kept).context("a campaign without an iteration")?;
    Ok(Seen { kept, costs: flown.into_iter().map(|flown| flown.map_or(f64::NAN, |cost| cost.total)).collect(), score })
}

impl Seen<'_> {
    fn first(&self) -> f64 {
        self.costs.first().copied().unwrap_or(f64::NAN)
    }

    fn last(&self) -> f64 {
        self.costs.last().copied().unwrap_or(f64::NAN)
    }
}

/// Median, with lowest and highest.
fn spread(values: impl Iterator<Item = f64>, decimals: usize) -> String {
    let values: Vec<f64> = values.collect();
    let at = |share: f64| page::quantile(&values, share).unwrap_or(f64::NAN);
    let [low, middle, high] = [0.0, 0.5, 1.0].map(|share| number(at(share), decimals));
    if low == high { middle } else { format!("{middle} ({low} … {high})") }
}

fn markdown(study: &Study, loops: &[LoopSeen<'_>], held_out: &HeldOut, untouched: Score) -> String {
    let mut text = format!("# {}\n\n", study.title);
    text += &around(
        &findings(study, loops, held_out, untouched),
        "![What each mechanism makes of the cost](results-identification.svg)",
        "The cost of each iteration's design in the stand-in, noise taken off, over the noise seeds; in the dissertation, in the water \
         channel. Lower is better.",
    );
    text += "\nWritten by `cargo xtask identify` from `fixtures/bat/identification.toml`, which has every number in doubt with its range and the \
             reason; the campaigns are in `fixtures/bat/identification`. A run that is killed goes on where it was, `--page` writes this page \
             alone, and `--check`, a part of `cargo xtask ci`, runs one campaign anew and holds the others against their flights, which are kept \
             beside them: of these it flies one in fifty anew.\n\n";
    text += &setting(study);
    text += "\n## Table 3\n\nWithout noise, and as printed. The numerical cost is that of the model with what was identified, corrected \
             where the loop corrects.\n\n";
    text += &table_3(study, loops).markdown();
    text += "\n## Over noise seeds\n\nMedian (lowest … highest).\n\n";
    text += &seeds_table(loops).markdown();
    text += &format!(
        "\n## Predictions held out\n\nAt {} designs, evenly over the box, that no loop is asked to visit: root mean square of the relative \
         error of the cost, its mean, and the rank correlation with the stand-in, of the model that each loop optimized last. Without \
         noise, and median (lowest … highest) over the seeds.\n\n",
        held_out.len()
    );
    text += &scores_table(loops, untouched).markdown();
    text += "\n## What was identified\n\nWithout noise, after all experiments; ± is a standard error, with the misfit of the model taken for \
             noise. The stand-in has the numbers of the rig file, so that the truth is known: it is the start.\n\n";
    text += &unknowns_table(study, loops).markdown();
    text += &left_open(loops);
    text
}

/// The numbers that the sentences are about.
fn findings(study: &Study, loops: &[LoopSeen<'_>], held_out: &HeldOut, untouched: Score) -> Vec<Finding> {
    let noisy: Vec<&LoopSeen<'_>> = loops.iter().filter(|seen| !seen.noisy.is_empty()).collect();
    let listed = |words: fn(&LoopSeen<'_>) -> String, of: &[&LoopSeen<'_>]| -> String {
        of.iter().map(|seen| words(seen)).collect::<Vec<_>>().join("; ")
    };
    let all: Vec<&LoopSeen<'_>> = loops.iter().collect();
    let first = loops.first().map_or(f64::NAN, |seen| seen.silent.first());
    let mut sentences = vec![
        format!(
            "The numerical optimum, where all loops begin, costs {} s in the stand-in. After {} iterations without noise that {}.",
            number(first, 2),
            study.setup.file.published.len(),
            listed(|seen| format!("{} with {}", moved(change(&seen.silent)), seen.label), &all)
        ),
        format!(
            "With noise the last design costs, median (lowest … highest): {}.",
            listed(
                |seen| format!(
                    "{} {} s, {} seeds",
                    seen.label,
                    spread(seen.noisy.iter().map(Seen::last), 2),
                    seen.noisy.len()
                ),
                &noisy
            )
        ),
        format!(
            "At {} designs that nobody flew, the model as it was errs by {} % and has a rank correlation of {} with the stand-in; without noise: {}.",
            held_out.len(),
            number(untouched.error_pct, 0),
            number(untouched.rank_correlation, 2),
            listed(
                |seen| format!(
                    "{} {} %, {}",
                    seen.label,
                    number(seen.silent.score.error_pct, 0),
                    number(seen.silent.score.rank_correlation, 2)
                ),
                &all
            )
        ),
    ];
    sentences.extend(contrast(study, loops, untouched));
    let mut findings: Vec<Finding> = sentences.into_iter().map(Finding::new).collect();
    findings.extend(meaning(study, loops));
    findings
}

/// Where identification alone predicts better than the model as it was, and designs worse.
fn contrast(study: &Study, loops: &[LoopSeen<'_>], untouched: Score) -> Option<String> {
    let seen = &loops.get(study.quick().index)?.silent;
    let Score { error_pct, bias, rank_correlation } = seen.score;
    (error_pct < untouched.error_pct && seen.last() > seen.first()).then(|| {
        format!(
            "So a model that predicts costs better need not have a better optimum: identification alone corrects the mean of the cost (mean error \
             {} s before, {} s after) and not its order (rank correlation {} before, {} after), and its last design is worse than its first. What \
             moves the designs the right way is the correction of slopes.",
            signed(untouched.bias, 2),
            signed(bias, 2),
            number(untouched.rank_correlation, 2),
            number(rank_correlation, 2)
        )
    })
}

/// A change in per cent as a verb.
fn moved(change: f64) -> String {
    let verb = if change < 0.0 { "falls" } else { "rises" };
    format!("{verb} by {} %", number(change.abs(), 1))
}

/// Of the cost in the stand-in, from the first design to the last, in per cent.
fn change(seen: &Seen<'_>) -> f64 {
    100.0 * (seen.last() / seen.first() - 1.0)
}

/// What the numbers mean: how many are determined, at a bound, and away from the truth, which is their start.
fn meaning(study: &Study, loops: &[LoopSeen<'_>]) -> [Finding; 2] {
    let n = study.unknowns.len();
    let of = |seen: &LoopSeen<'_>| {
        let found = seen.silent.kept.found.as_ref()?;
        let determined = found.unknowns.iter().filter(|unknown| unknown.standard_error.is_some()).count();
        let at_bound = found.unknowns.iter().filter(|unknown| unknown.bound.is_some()).count();
        let off = found.unknowns.iter().zip(study.unknowns.start()).filter_map(|(unknown, truth)| {
            unknown.standard_error.map(|error| number(((unknown.value - truth) / error).abs(), 1))
        });
        let off: Vec<String> = off.collect();
        let off =
            if off.is_empty() { String::new() } else { format!(" ({} standard errors off the truth)", off.join(", ")) };
        Some(format!(
            "{}: {determined} determined{off}, {at_bound} at a bound, {} open; residuals {} times the noise.",
            capitalized(seen.label),
            n - determined - at_bound,
            number(found.misfit, 1)
        ))
    };
    let numbers = Finding::new(format!("What became of {n} numbers in doubt, without noise:"));
    let physical = Finding::new(
        "The identified numbers mean nothing physical: the stand-in flies with the very numbers that the model starts with, and what it has \
         besides is stall and added mass, so that every move of a number stands in for these.",
    );
    [numbers.with_sentences(loops.iter().filter_map(of)), physical.with_sentences(bounds_over_seeds(study, loops))]
}

fn bounds_over_seeds(study: &Study, loops: &[LoopSeen<'_>]) -> Option<String> {
    let founds: Vec<&Found> =
        loops.iter().flat_map(|seen| &seen.noisy).filter_map(|seen| seen.kept.found.as_ref()).collect();
    let count = |j: usize| founds.iter().filter(|found| found.unknowns[j].bound.is_some()).count();
    let words: Vec<String> = (0..study.unknowns.len())
        .filter(|j| count(*j) > 0)
        .map(|j| format!("`{}` in {} of {} campaigns with noise", study.free[j].key, count(j), founds.len()))
        .collect();
    (!words.is_empty()).then(|| format!("At a bound ends {}.", words.join(", ")))
}

fn setting(study: &Study) -> String {
    let noise = &study.setup.file.noise;
    format!(
        "## What was done\n\nThe loops are those of Chapter 4 with R = 0.1 as printed: three iterations of five experiments. After each, the \
         numbers in doubt are fitted anew to all experiments so far, from where the rig file has them; with both mechanisms together, the correction (27) \
         is then learned anew against the model so found, so that nothing counts twice.\n\n\
         Measured are the six terms inside the square of (21) at every experiment, each with noise of its own within ±{} %, and the cost with the noise \
         that the other loops of Chapter 4 meet. For the fit a term is as uncertain as noise of that size in the whole cost would make it; the loop called \
         relative takes that of the term itself. The factor that the residuals are larger than this noise is estimated, and standard errors grow with it. \
         A change of the numbers is open when its standard error is above {} of the range: there the start is kept.\n",
        number(100.0 * noise.share, 0),
        number(study.fit.largest_error, 2)
    )
}

fn table_3(study: &Study, loops: &[LoopSeen<'_>]) -> Table {
    let mut table = Table::new(vec![
        Column::words("Loop"),
        Column::number("Iteration", "1"),
        study.setup.variable(0).column(),
        study.setup.variable(1).column(),
        Column::number("Numerical cost", "s"),
        Column::number("Experimental cost", "s"),
        Column::number("Change", "%"),
    ]);
    let published = &study.setup.file.published;
    for (index, row) in published.iter().enumerate() {
        table.push(vec![
            "dissertation".to_owned(),
            (index + 1).to_string(),
            number(row.center_of_mass, 1),
            number(row.pitch_set_point, 1),
            number(row.corrected_cost, 2),
            number(row.experiment_cost, 2),
            signed(100.0 * (row.experiment_cost / published[0].experiment_cost - 1.0), 1),
        ]);
    }
    for seen in loops {
        for (index, (turn, cost)) in seen.silent.kept.turns.iter().zip(&seen.silent.costs).enumerate() {
            table.push(vec![
                seen.label.to_owned(),
                (index + 1).to_string(),
                number(turn.design[0], 2),
                number(turn.design[1], 2),
                number(turn.corrected_cost, 3),
                number(*cost, 3),
                signed(100.0 * (cost / seen.silent.first() - 1.0), 1),
            ]);
        }
    }
    table
}

fn seeds_table(loops: &[LoopSeen<'_>]) -> Table {
    let mut table = Table::new(vec![
        Column::words("Loop"),
        Column::number("Iteration", "1"),
        Column::number("Center of mass", "% chord"),
        Column::number("Pitch set point", "deg"),
        Column::number("Numerical cost", "s"),
        Column::number("True cost in the stand-in", "s"),
        Column::number("Seeds", "1"),
    ]);
    for seen in loops.iter().filter(|seen| !seen.noisy.is_empty()) {
        let longest = seen.noisy.iter().map(|one| one.costs.len()).max().unwrap_or(0);
        for index in 0..longest {
            let turns = || seen.noisy.iter().filter_map(move |one| one.kept.turns.get(index));
            table.push(vec![
                seen.label.to_owned(),
                (index + 1).to_string(),
                spread(turns().map(|turn| turn.design[0]), 2),
                spread(turns().map(|turn| turn.design[1]), 2),
                spread(turns().map(|turn| turn.corrected_cost), 2),
                spread(seen.noisy.iter().filter_map(|one| one.costs.get(index).copied()), 2),
                turns().count().to_string(),
            ]);
        }
    }
    table
}

fn scores_table(loops: &[LoopSeen<'_>], untouched: Score) -> Table {
    let of_each = ["Error", "Error over seeds", "Mean error", "Rank correlation", "Rank correlation over seeds"];
    let units = ["%", "%", "s", "1", "1"];
    let heads = of_each.iter().zip(units).map(|(name, unit)| Column::number(name, unit));
    let mut table = Table::new(std::iter::once(Column::words("Model")).chain(heads).collect());
    let mut row = |label: &str, silent: Score, noisy: &[Seen<'_>]| {
        let over = |read: fn(&Score) -> f64, decimals| {
            if noisy.is_empty() {
                "–".to_owned()
            } else {
                spread(noisy.iter().map(|seen| read(&seen.score)), decimals)
            }
        };
        table.push(vec![
            label.to_owned(),
            number(silent.error_pct, 1),
            over(|score| score.error_pct, 1),
            signed(silent.bias, 2),
            number(silent.rank_correlation, 2),
            over(|score| score.rank_correlation, 2),
        ]);
    };
    row("as it was", untouched, &[]);
    for seen in loops {
        row(seen.label, seen.silent.score, &seen.noisy);
    }
    table
}

fn unknowns_table(study: &Study, loops: &[LoopSeen<'_>]) -> Table {
    let fitted: Vec<(&LoopSeen<'_>, &Found)> =
        loops.iter().filter_map(|seen| Some((seen, seen.silent.kept.found.as_ref()?))).collect();
    let heads = [Column::words("Number"), Column::words("Unit"), Column::number("Start", "1"), Column::words("Range")];
    let of_loops = fitted.iter().map(|(seen, _)| Column::words(seen.label));
    let mut table = Table::new(heads.into_iter().chain(of_loops).chain([Column::words("Why in doubt")]).collect());
    for (j, free) in study.free.iter().enumerate() {
        let cell = |found: &Found| {
            let unknown = &found.unknowns[j];
            match (&unknown.standard_error, &unknown.bound) {
                (Some(error), _) => format!("{} ± {}", digits(unknown.value), digits(*error)),
                (None, Some(bound)) => format!("{}, its {bound} bound", digits(unknown.value)),
                (None, None) => format!("{}, open", digits(unknown.value)),
            }
        };
        let known = [
            format!("`{}`", free.key),
            free.unit.clone(),
            digits(study.unknowns.start()[j]),
            format!("{} to {}", digits(free.lower), digits(free.upper)),
        ];
        let cells = fitted.iter().map(|(_, found)| cell(found));
        table.push(known.into_iter().chain(cells).chain([free.reason.clone()]).collect());
    }
    table
}

/// What each fit without noise leaves open, in the words of the fit.
fn left_open(loops: &[LoopSeen<'_>]) -> String {
    let mut text = "\n## What the experiments leave open\n\nWithout noise, after all experiments: in the words of the fit, and the singular values \
                    of its Jacobian in shares of the ranges, in noise.\n"
        .to_owned();
    for seen in loops {
        let Some(found) = &seen.silent.kept.found else { continue };
        let values: Vec<String> = found.singular_values.iter().map(|value| digits(*value)).collect();
        text += &format!("\n{}: singular values {}.\n\n", seen.label, values.join(", "));
        for warning in &found.warnings {
            text += &format!("- {}.\n", warning.replace(" -", " −"));
        }
    }
    text
}

fn picture(study: &Study, loops: &[LoopSeen<'_>]) -> String {
    let groups = loops.iter().filter(|seen| !seen.noisy.is_empty()).map(|seen| {
        let longest = seen.noisy.iter().map(|one| one.costs.len()).max().unwrap_or(0);
        let of = |index: usize| seen.noisy.iter().filter_map(|one| one.costs.get(index).copied()).collect();
        Group { label: seen.label.to_owned(), values: (0..longest).map(of).collect() }
    });
    let published = study.setup.file.published.iter().map(|row| row.experiment_cost).collect();
    spread_figure(&SpreadFigure {
        title: "Identification, correction, and both: the cost of each design".to_owned(),
        y_axis: Axis::new("true cost in the stand-in", "s"),
        groups: groups.collect(),
        reference: Some(Reference { label: "dissertation, Table 3".to_owned(), values: published }),
    })
}
