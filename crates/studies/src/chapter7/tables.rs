//! The tables of Chapter 7.

use water_channel::Record;

use super::campaigns::{Runs, Step};
use super::file::{Case, Standing};
use super::findings::{Findings, Found};
use super::flights::READINGS;
use super::wrong::Choice;
use crate::bat::STAND_IN;
use crate::variable::Variable;
use crate::words::{number, signed};
use page::Summary;
use page::{Column, Table};

/// A column of a table of designs: the variables, and then what belongs to the row.
struct Quantity<'a> {
    column: Column,
    decimals: usize,
    of: Box<dyn Fn(&Step) -> f64 + 'a>,
}

fn quantities<'a>(case: &'a Case, found: &'a Found) -> Vec<Quantity<'a>> {
    let mut all = Vec::new();
    let mut push = |column: Column, decimals, of: Box<dyn Fn(&Step) -> f64 + 'a>| {
        all.push(Quantity { column, decimals, of });
    };
    for (k, variable) in case.space.variables.iter().enumerate() {
        push(variable.column(), 2, Box::new(move |step| step.point[k]));
        if *variable == Variable::CenterOfMass {
            push(
                Column::new("CM_CB", variable.unit()),
                2,
                Box::new(move |step| case.center_of_buoyancy - step.point[k]),
            );
        }
    }
    push(Column::new("Space left", "%"), 2, Box::new(|step| step.share));
    push(Column::new("True cost", "s"), 3, Box::new(|step| step.cost));
    push(Column::new("Regret", "s"), 3, Box::new(|step| step.cost - found.best.cost));
    all
}

/// Which rows a table of designs has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rows {
    /// The published ones, ours without noise, the seed of median regret, and how ours spread.
    All,
    /// The same without the spread.
    Short,
    /// Ours without noise, the seed of median regret, and the medians.
    Ours,
}

/// Table 5 or 6 beside ours.
pub(crate) fn designs(case: &Case, found: &Found, runs: &Runs, which: Rows) -> Table {
    let quantities = quantities(case, found);
    let mut columns = vec![Column::new("Iteration", "1"), Column::new("Source", ""), Column::new("Row is", "")];
    columns.extend(quantities.iter().map(|quantity| quantity.column.clone()));
    let mut table = Table::new(columns);
    let number = |quantity: &Quantity<'_>, value: f64| number(value, quantity.decimals);
    let mut push = |iteration: usize, source: &str, standing: &str, cells: &dyn Fn(&Quantity<'_>) -> String| {
        let mut row = vec![iteration.to_string(), source.to_owned(), standing.to_owned()];
        row.extend(quantities.iter().map(cells));
        table.push(row);
    };
    let flown = |point: &[f64], share| {
        let cost = case.bat.cost(point, STAND_IN).unwrap_or(f64::NAN);
        Step { point: point.to_vec(), cost, share }
    };
    for (iteration, row) in case.published.iter().enumerate() {
        let standing = row.standing.words();
        if which != Rows::Ours {
            let theirs = flown(&row.point, row.share);
            push(iteration, "dissertation", "published", &|quantity| number(quantity, (quantity.of)(&theirs)));
        }
        if iteration == 0 {
            if which != Rows::Ours {
                let model = flown(&found.numerical.point, 100.0);
                push(0, "model itself", standing, &|quantity| number(quantity, (quantity.of)(&model)));
            }
            if let Some(report) = runs.quiet_campaign.reports().first() {
                let surface = flown(&report.screening.simulation_optimum, 100.0);
                let standing = Standing::Predicted.words();
                push(0, "its first surface", standing, &|quantity| number(quantity, (quantity.of)(&surface)));
            }
            continue;
        }
        match runs.quiet.0.get(iteration - 1) {
            Some(step) => push(iteration, "no noise", standing, &|quantity| number(quantity, (quantity.of)(step))),
            None => push(iteration, "had ended", standing, &|_| "–".to_owned()),
        }
        if let Some((seed, steps)) = runs.median() {
            let source = format!("seed {seed}, median regret");
            match steps.0.get(iteration - 1) {
                Some(step) => push(iteration, &source, standing, &|quantity| number(quantity, (quantity.of)(step))),
                None => push(iteration, &source, standing, &|_| "–".to_owned()),
            }
        }
        if which == Rows::Short {
            continue;
        }
        let summary = |quantity: &Quantity<'_>| Summary::of(&runs.over_seeds(iteration, &quantity.of));
        let count = runs.over_seeds(iteration, |step| step.share).len();
        let of = |pick: fn(&Summary) -> f64| {
            move |quantity: &Quantity<'_>| summary(quantity).map_or("–".to_owned(), |s| number(quantity, pick(&s)))
        };
        push(iteration, &format!("medians of {count}, no design"), standing, &of(|s| s.median));
        if which == Rows::All {
            push(iteration, "smallest of each", standing, &of(|s| s.minimum));
            push(iteration, "largest of each", standing, &of(|s| s.maximum));
        }
    }
    table
}

fn seconds(value: f64) -> String {
    if value.is_finite() { format!("{value:.3}") } else { "does not fly".to_owned() }
}

/// What the wrong choices cost in one study.
pub(crate) fn choices(found: &Found) -> Table {
    let mut table = Table::new(vec![
        Column::new("Choice", ""),
        Column::new("Regret, median", "s"),
        Column::new("worst", "s"),
        Column::new("Better than the loop in", "1"),
        Column::new("Best dropped in", "1"),
        Column::new("What is done", ""),
    ]);
    for (number, choice) in found.choices.iter().enumerate() {
        let n = choice.regrets.len();
        let better = |own: &Choice| format!("{} of {n}", choice.beats(own));
        table.push(vec![
            choice.label.to_owned(),
            seconds(choice.median()),
            seconds(choice.worst()),
            found.choices.first().filter(|_| number > 0).map_or("–".to_owned(), better),
            choice.lost.map_or("–".to_owned(), |lost| format!("{lost} of {n}")),
            choice.how.clone(),
        ]);
    }
    table
}

/// The designs before and after infusion, in the stand-in.
pub(crate) fn flights(findings: &Findings) -> Table {
    let mut table = Table::new(vec![
        Column::new("Study", ""),
        Column::new("In the stand-in", ""),
        Column::new("Before", "1"),
        Column::new("After", "1"),
        Column::new("Change", "%"),
        Column::new("After, median", "1"),
        Column::new("smallest … largest", "1"),
        Column::new("Better in", "1"),
    ]);
    for (case, found) in findings.cases() {
        let (before, after) = (found.flights.before.means(), found.flights.after.means());
        for (name, unit, reading) in READINGS {
            let seeds: Vec<f64> = found.flights.after_seeds.iter().map(reading).collect();
            let Some(summary) = Summary::of(&seeds) else { continue };
            let better = seeds.iter().filter(|after| **after < reading(&before)).count();
            table.push(vec![
                case.entry.label.clone(),
                format!("{name} ({unit})"),
                format!("{:.3}", reading(&before)),
                format!("{:.3}", reading(&after)),
                signed(100.0 * (reading(&after) / reading(&before) - 1.0), 1),
                format!("{:.3}", summary.median),
                format!("{:.3} … {:.3}", summary.minimum, summary.maximum),
                format!("{better} of {}", seeds.len()),
            ]);
        }
    }
    table
}

/// The weights of the cost, which are all that differs from Chapter 4.
pub(crate) fn weights(findings: &Findings) -> Table {
    let mut table = Table::new(vec![
        Column::new("Weight", ""),
        Column::new("Unit", ""),
        Column::new("Chapter 4, (21)", "1"),
        Column::new("Chapters 6 and 7, (60)", "1"),
    ]);
    let [ours, theirs] = &findings.setup.weights;
    for weight in ours {
        let value = |record: &Record| record.value.to_string();
        let other = theirs.iter().find(|other| other.key == weight.key).map_or("–".to_owned(), value);
        table.push(vec![weight.key.replace('_', " "), weight.unit.clone(), other, value(weight)]);
    }
    table
}

/// The costs over the grids that are flown, and the optima.
pub(crate) fn fields(findings: &Findings) -> Table {
    let mut table = Table::new(vec![
        Column::new("Study", ""),
        Column::new("Physics", ""),
        Column::new("Cells flown", "1"),
        Column::new("do not fly", "1"),
        Column::new("Lowest cell", "s"),
        Column::new("Range", "s"),
        Column::new("Best design known", ""),
        Column::new("Its cost", "s"),
    ]);
    for (case, found) in findings.cases() {
        for (physics, grid, best) in
            [("numerical model", &found.model, &found.numerical), ("stand-in", &found.truth, &found.best)]
        {
            table.push(vec![
                case.entry.label.clone(),
                physics.to_owned(),
                case.flown.n_cells().to_string(),
                grid.n_failed().to_string(),
                grid.lowest().map_or("–".to_owned(), |(_, cost)| format!("{cost:.3}")),
                format!("{:.3}", grid.range()),
                case.space.words(&best.point),
                format!("{:.3}", best.cost),
            ]);
        }
    }
    table
}

/// Every iteration of every campaign.
pub(crate) fn every_step(findings: &Findings) -> Table {
    let mut columns = vec![
        Column::new("study", ""),
        Column::new("regressor", ""),
        Column::new("seed", "1"),
        Column::new("iteration", "1"),
    ];
    columns.extend(Variable::ALL.map(|variable| Column::new(&variable.label().to_lowercase(), variable.unit())));
    columns.extend([Column::new("space left", "%"), Column::new("true cost", "s"), Column::new("regret", "s")]);
    let mut table = Table::new(columns);
    for (case, found) in findings.cases() {
        for runs in &found.runs {
            let seeds = std::iter::once("no noise".to_owned()).chain(runs.seeds.iter().map(u64::to_string));
            for (seed, steps) in seeds.zip(std::iter::once(&runs.quiet).chain(&runs.noisy)) {
                for (number, step) in steps.0.iter().enumerate() {
                    let mut row =
                        vec![case.entry.label.clone(), runs.label.clone(), seed.clone(), (number + 1).to_string()];
                    // Areas that a study does not vary are nominal.
                    row.extend((0..4).map(|k| step.point.get(k).map_or("1".to_owned(), f64::to_string)));
                    row.extend([step.share, step.cost, step.cost - found.best.cost].map(|value| value.to_string()));
                    table.push(row);
                }
            }
        }
    }
    table
}

/// Every seed of every wrong choice.
pub(crate) fn every_choice(findings: &Findings) -> Table {
    let mut table = Table::new(vec![
        Column::new("study", ""),
        Column::new("choice", ""),
        Column::new("seed", "1"),
        Column::new("regret", "s"),
    ]);
    let noise = &findings.setup.file.noise;
    for (case, found) in findings.cases() {
        for choice in &found.choices {
            for (seed, regret) in noise.numbers(noise.seeds).iter().zip(&choice.regrets) {
                table.push(vec![
                    case.entry.label.clone(),
                    choice.label.to_owned(),
                    seed.to_string(),
                    regret.to_string(),
                ]);
            }
        }
    }
    table
}
