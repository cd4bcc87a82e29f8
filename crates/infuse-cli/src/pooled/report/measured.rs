//! The designs that measured best, and the experiments that taught most.

use std::collections::BTreeMap;

use anyhow::Result;
use design_space::Cell;
use infuse::pooled::Standing;
use infuse::pooled::reported::Constrained;
use page::{Column, Page, Table};

use super::super::best::has_shifts;
use super::nothing::NOTHING;
use super::view::{AS_READ, Run, View};
use crate::number::{resolved, short};
use crate::pooled::bands::{NINE_IN_TEN, resolution};
use crate::pooled::campaign::Origin;
use crate::problem::shown;
use crate::report::sheets::settings_columns;

/// Rows of each table.
const MOST_BEST: usize = 10;
const MOST_TELLING: usize = 5;

pub(super) fn write(page: &mut Page, view: &View) -> Result<()> {
    let best = best(view)?;
    let caption = "The designs that measured best, by the mean of their runs; a run at settings between designs counts for \
                   the nearest.";
    let caption = match has_shifts(&view.found) {
        true => format!(
            "{caption} Measured: as it was read. Without shift: without what their batches are off by, by which they are ordered; \
             expected: in the mean over batches and sources."
        ),
        false => caption.to_owned(),
    };
    let caption = match view.campaign.problem.constraints.is_empty() {
        true => caption,
        false => format!("{caption} What has to stay within bounds is as measured, or in brackets as expected."),
    };
    page.table(&best_table(view, &best), &caption);
    let telling = telling(view)?;
    if !telling.is_empty() {
        let table = telling_table(view, &telling)?;
        let caption = "The experiments that taught most: those farthest from what all others say of their settings, in \
                       standard deviations. Far is more than 4.";
        let as_read = if has_shifts(&view.found) { AS_READ } else { "" };
        page.table(&table, &format!("{caption}{as_read}"));
    }
    Ok(())
}

/// Best first, each with the mean of its costs, without what their batches are off by.
fn best(view: &View) -> Result<Vec<(Standing, f64)>> {
    let mut sums: BTreeMap<Cell, (f64, f64)> = BTreeMap::new();
    for (run, shift) in view.runs.iter().zip(view.campaign.shifts_of_readings(&view.found)) {
        let (sum, n) = sums.entry(run.cell).or_insert((0.0, 0.0));
        *sum += view.response().cost(run.value) - shift;
        *n += 1.0;
    }
    let mut means: Vec<(f64, Cell)> = sums.into_iter().map(|(cell, (sum, n))| (sum / n, cell)).collect();
    means.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    means.truncate(MOST_BEST);
    let cells: Vec<Cell> = means.iter().map(|(_, cell)| *cell).collect();
    let best = view.campaign.with_loop(|now, simulate| now.standings(&cells, simulate))?.unwrap_or_default();
    Ok(best.into_iter().zip(means).map(|(there, (mean, _))| (there, mean)).collect())
}

fn best_table(view: &View, best: &[(Standing, f64)]) -> Table {
    let (response, unit, known_to) = (view.response(), &view.response().unit, resolution(&view.found));
    let mut columns: Vec<Column> = settings_columns(&view.campaign.problem).collect();
    columns.extend([
        Column::number("measured", unit),
        Column::number("without shift", unit),
        Column::number("runs", ""),
        Column::number("expected", unit),
        Column::number(response.band_heading(), response.unit_of_differences()),
    ]);
    let constraints = &view.campaign.problem.constraints;
    columns.extend(constraints.iter().map(|held| Column::number(held.name(), &held.unit)));
    columns.push(Column::words("may still be the best"));
    let has_band = view.found.needed.is_none();
    let row = |(there, without_shift): &(Standing, f64)| {
        let mut cells = written(view, &there.point);
        cells.extend([
            there.measured.map_or_else(|| NOTHING.to_owned(), |cost| response.number_to(cost, known_to)),
            response.number_to(*without_shift, known_to),
            there.n_readings.to_string(),
            response.number_to(there.mean, known_to),
            match has_band {
                true => short(response.of_difference(NINE_IN_TEN * there.deviation)),
                false => NOTHING.to_owned(),
            },
        ]);
        cells.extend(there.constrained.iter().map(constrained_in_short));
        cells.push(verdict(view, there));
        cells
    };
    let table = Table { columns, rows: best.iter().map(row).collect() };
    if has_shifts(&view.found) { table } else { table.without("without shift") }
}

/// As measured, or in brackets as expected.
fn constrained_in_short(there: &Constrained) -> String {
    match (there.measured, there.expected) {
        (Some(measured), _) => short(measured),
        (None, Some((expected, _))) => format!("({})", short(expected)),
        (None, None) => NOTHING.to_owned(),
    }
}

/// Whether a design may still be the best, or why not.
fn verdict(view: &View, there: &Standing) -> String {
    if there.cell == view.found.recommended.cell {
        return "yes, it is recommended".to_owned();
    }
    if let Some(why_not) = view.campaign.why_not(there.cell) {
        return format!("no, {why_not}");
    }
    let pairs = view.campaign.problem.constraints.iter().zip(&there.constrained);
    let broken = pairs.clone().find(|(held, there)| there.measured.is_some_and(|value| !held.constraint.allows(value)));
    let unsure = || pairs.clone().find(|(held, there)| there.within < held.constraint.probability);
    match (broken, there.may_be_best) {
        (Some((held, _)), _) => format!("no, it breaks the bound of {}", held.name()),
        (None, true) => "yes".to_owned(),
        (None, false) => match unsure() {
            Some((held, there)) if there.within < 0.5 => format!("no, it would break the bound of {}", held.name()),
            Some((held, _)) => format!("no, it is not sure to keep to {}", held.name()),
            None => "no".to_owned(),
        },
    }
}

/// Settings as a table has them.
fn written(view: &View, point: &[f64]) -> Vec<String> {
    let pairs = point.iter().zip(view.parameters());
    pairs.map(|(&value, parameter)| shown(parameter, value)).collect()
}

/// Runs of equal settings, and how far they are from what all others say: as measured, above or below.
#[derive(Debug)]
struct Telling<'a> {
    runs: Vec<&'a Run>,
    deviations: f64,
}

/// Farthest first.
fn telling<'a>(view: &'a View) -> Result<Vec<Telling<'a>>> {
    let surprises = view.campaign.with_loop(|now, simulate| now.surprises(simulate))?.unwrap_or_default();
    let mut by_settings: BTreeMap<Vec<u64>, Telling> = BTreeMap::new();
    for (run, &surprise) in view.runs.iter().zip(&surprises) {
        let place = run.settings.iter().map(|setting| (setting + 0.0).to_bits()).collect();
        let deviations = view.response().of_deviations(surprise);
        by_settings.entry(place).or_insert_with(|| Telling { runs: Vec::new(), deviations }).runs.push(run);
    }
    let mut telling: Vec<Telling> = by_settings.into_values().filter(|one| one.deviations.abs() > 0.0).collect();
    telling.sort_by(|a, b| b.deviations.abs().total_cmp(&a.deviations.abs()));
    telling.truncate(MOST_TELLING);
    Ok(telling)
}

fn telling_table(view: &View, telling: &[Telling]) -> Result<Table> {
    let (unit, known_to) = (&view.response().unit, resolution(&view.found));
    let mut columns = vec![Column::words("experiment")];
    columns.extend(settings_columns(&view.campaign.problem));
    columns.extend([
        Column::number("measured", unit),
        Column::number("expected", unit),
        Column::number("off by", "standard deviations"),
        Column::words("note"),
    ]);
    let row = |one: &Telling| {
        let mut cells = vec![names(view, &one.runs)];
        cells.extend(one.runs.first().map(|run| written(view, &run.settings)).unwrap_or_default());
        let measured: Vec<String> = one.runs.iter().map(|run| resolved(run.value, known_to)).collect();
        let expected = one.runs.first().and_then(|run| view.expected(run.cell));
        let side = if one.deviations > 0.0 { "above" } else { "below" };
        cells.extend([
            measured.join(", "),
            expected.map_or_else(|| NOTHING.to_owned(), |value| resolved(value, known_to)),
            format!("{:.1} {side}", one.deviations.abs()),
            notes(view, &one.runs),
        ]);
        cells
    };
    let table = Table { columns, rows: telling.iter().map(row).collect() };
    let has_notes = table.rows.iter().any(|row| row.last().is_some_and(|note| !note.is_empty()));
    Ok(if has_notes { table } else { table.without("note") })
}

/// Each experiment once.
fn names(view: &View, runs: &[&Run]) -> String {
    let mut names: Vec<String> = Vec::new();
    for run in runs {
        let name = match run.origin {
            Origin::Own(id) => id.to_string(),
            origin @ Origin::Imported(_) => view.campaign.name_of(origin),
        };
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names.join(", ")
}

fn notes(view: &View, runs: &[&Run]) -> String {
    let mut notes: Vec<&str> = Vec::new();
    for run in runs {
        let note = match run.origin {
            Origin::Own(id) => view.campaign.experiments.readings.get(&id).map(|reading| &reading.note),
            Origin::Imported(index) => view.campaign.imported.get(index).map(|imported| &imported.note),
        };
        let note = note.map_or("", String::as_str);
        if !note.is_empty() && !notes.contains(&note) {
            notes.push(note);
        }
    }
    notes.join("; ")
}
