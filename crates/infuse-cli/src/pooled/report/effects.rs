//! How much each parameter matters.

use anyhow::Result;
use design_space::{Cell, Levels, Parameter};
use page::{Column, Page, Table};

use super::nothing::NOTHING;
use super::view::View;
use crate::number::{percent, short};
use crate::problem::{Scale, shown};
use crate::spread::spread;

/// Designs all over the grid of which the surface is asked, at most.
const MOST_ASKED: u64 = 1_000;
/// A parameter of more settings than these is looked at in groups of neighboring ones: so many.
const MOST_LEVELS: u32 = 16;
const GROUPS: u32 = 12;
/// With fewer designs nothing is said of shares.
const FEWEST: usize = 50;

pub(super) fn write(page: &mut Page, view: &View) -> Result<()> {
    let shares = shares(view)?;
    let unit = &view.response().unit;
    let range = match view.response().scale {
        Scale::Linear => "range along it",
        Scale::Log => "highest / lowest",
    };
    let columns = vec![
        Column::words("parameter"),
        Column::words("recommended"),
        Column::number("lowest along it", unit),
        Column::number("highest along it", unit),
        Column::number(range, view.response().unit_of_differences()),
        Column::number("alone explains", ""),
    ];
    let row = |at: usize| {
        let parameter = &view.parameters()[at];
        let along: Vec<f64> = view.lines[at].iter().filter_map(|&cell| view.expected(cell)).collect();
        let (low, high) =
            along.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &y| (low.min(y), high.max(y)));
        let share =
            shares.as_ref().and_then(|shares| shares.get(at)).map_or_else(|| NOTHING.to_owned(), |&s| percent(s));
        let best = crate::number::with_unit(&shown(parameter, view.best()[at]), parameter.unit());
        vec![parameter.name().to_owned(), best, short(low), short(high), short(view.response().less(high, low)), share]
    };
    let table = Table { columns, rows: (0..view.parameters().len()).map(row).collect() };
    let mut caption = "What is expected where one parameter is moved and the others are as recommended.".to_owned();
    if shares.is_some() {
        caption.push_str(
            " Alone explains: the share of the variance of what is expected over all designs that follows from this parameter \
             alone, whatever the others; what is missing to 100 % the parameters explain together.",
        );
    }
    page.subheading("How much each parameter matters");
    page.table(&table, &caption);
    Ok(())
}

/// The share of the variance over all designs that each parameter explains alone: that between groups of its settings, less what
/// chance would put there. None where there are too few designs, or no variance.
fn shares(view: &View) -> Result<Option<Vec<f64>>> {
    let (campaign, grid) = (view.campaign, &view.campaign.grid);
    let n = grid.n_cells();
    let asked: Vec<Cell> = match n <= MOST_ASKED {
        true => grid.cells().collect(),
        false => (0..MOST_ASKED).map(|k| Cell::new(spread(k, n))).collect(),
    };
    let asked: Vec<Cell> = asked.into_iter().filter(|&cell| campaign.why_not(cell).is_none()).collect();
    if asked.len() < FEWEST {
        return Ok(None);
    }
    let Some(expected) = campaign.expectations(&asked)? else { return Ok(None) };
    let values: Vec<f64> = expected.iter().map(|one| one.mean).collect();
    let points = asked.iter().map(|&cell| Ok(grid.point(cell)?)).collect::<Result<Vec<_>>>()?;
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let total: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    if total <= 0.0 {
        return Ok(None);
    }
    // Of all designs nothing is left to chance.
    let is_sample = asked.len() as u64 != n;
    let share = |at: usize| {
        let settings: Vec<f64> = points.iter().map(|point| point[at]).collect();
        let groups = grouped(&view.parameters()[at], &settings, values.iter().map(|value| value - mean));
        let n_groups = groups.len() as f64;
        let between: f64 = groups.iter().map(|(sum, n)| sum * sum / n).sum();
        let within = (total - between) / (values.len() as f64 - n_groups).max(1.0);
        let by_chance = if is_sample { (n_groups - 1.0) * within } else { 0.0 };
        ((between - by_chance) / total).clamp(0.0, 1.0)
    };
    Ok(Some((0..view.parameters().len()).map(share).collect()))
}

/// Sum and number of the values by setting, or by groups of neighboring settings where there are many.
fn grouped(parameter: &Parameter, settings: &[f64], values: impl Iterator<Item = f64>) -> Vec<(f64, f64)> {
    let n_levels = match parameter.levels() {
        Levels::Count(n) if n <= MOST_LEVELS || parameter.choices().is_some() => n,
        _ => GROUPS,
    };
    let mut groups = vec![(0.0, 0.0); n_levels.max(1) as usize];
    for (setting, value) in settings.iter().zip(values) {
        let share = ((setting - parameter.lower()) / parameter.width()).clamp(0.0, 1.0);
        let group = match n_levels {
            GROUPS => ((share * f64::from(GROUPS)) as usize).min(GROUPS as usize - 1),
            n => (share * f64::from(n - 1)).round() as usize,
        };
        groups[group].0 += value;
        groups[group].1 += 1.0;
    }
    groups.retain(|(_, n)| *n > 0.0);
    groups
}
