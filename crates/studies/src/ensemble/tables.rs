//! The tables of the page.

use page::{Column, Summary, Table};

use super::claims::{Claim, JUDGED};
use super::decides::Decided;
use super::judge::{Judged, met_by};
use super::kept::Case;
use super::row::{Method, Reading, Study, World};
use crate::rules::{Count, Verdict};
use crate::words::number;

/// A claim with what became of it in still and in moving water.
pub(super) struct Both {
    pub(super) claim: Claim,
    pub(super) judged: [Judged; 2],
}

impl Both {
    /// In one cell.
    pub(super) fn words(&self) -> String {
        let each = World::OF_CAMPAIGNS.into_iter().zip(&self.judged).filter_map(|(world, judged)| {
            let words = judged.words()?;
            Some(format!("{}: {}, {words}", world.name(), judged.verdict()?.short()))
        });
        let each: Vec<String> = each.collect();
        if each.is_empty() { "–".to_owned() } else { each.join("; ") }
    }
}

/// What became of the claims.
pub(super) fn claims(all: &[Both]) -> Table {
    let mut table = Table::new(vec![
        Column::new("Where", ""),
        Column::new("The dissertation says", ""),
        Column::new("Here it holds where", ""),
        Column::new("Still water", ""),
        Column::new("Moving water", ""),
    ]);
    for Both { claim, judged } in all {
        let mut row = vec![claim.place.to_string(), claim.words(), claim.rule.to_owned()];
        row.extend(judged.iter().map(|judged| {
            let words = judged.verdict().zip(judged.words());
            words.map_or("–".to_owned(), |(verdict, words)| format!("**{}**: {words}", verdict.short()))
        }));
        table.push(row);
    }
    table
}

const WAYS: [(Method, &str); 7] = [
    (Method::Dissertation, "dissertation's loop"),
    (Method::Pooled, "pooled loop"),
    (Method::Process, "Sobol points, Gaussian process"),
    (Method::Alone, "its experiments, regression without simulation"),
    (Method::Numerical, "optimum of the model, no experiment"),
    (Method::Center, "center of the box, no experiment"),
    (Method::Random, "random design"),
];

fn cases_of<'a, 'b>(cases: &'b [Case<'a>], study: Study, world: World) -> impl Iterator<Item = &'b Case<'a>> {
    cases.iter().filter(move |case| case.study == study && case.world == world)
}

/// Median with quartiles, in per cent.
fn quartiles(values: &[f64]) -> String {
    let at = |share: f64| page::quantile(values, share).unwrap_or(f64::NAN);
    let words = |value: f64| if value.is_finite() { number(100.0 * value, 1) } else { "∞".to_owned() };
    format!("{} ({} to {})", words(at(0.5)), words(at(0.25)), words(at(0.75)))
}

/// Median with quartiles; a dash where there is nothing.
pub(super) fn quartiles_of(values: &[f64], decimals: usize) -> String {
    Summary::of(values).map_or("–".to_owned(), |summary| with_quartiles(&summary, decimals))
}

/// Median with quartiles.
fn with_quartiles(summary: &Summary, decimals: usize) -> String {
    let words = |value: f64| number(value, decimals);
    let Summary { median, lower_quartile, upper_quartile, .. } = *summary;
    format!("{} ({} to {})", words(median), words(lower_quartile), words(upper_quartile))
}

/// Of claims about the end of the loop that are met somewhere, in how many per cent of their cases others meet them.
pub(super) fn met_by_others(all: &[Both], cases: &[Case<'_>]) -> Table {
    let ways = WAYS.iter().filter(|(method, _)| *method != Method::Numerical);
    let heads = ["Where", "The dissertation says", "Water"].map(|name| Column::new(name, ""));
    let mut table = Table::new(heads.into_iter().chain(ways.clone().map(|(_, name)| Column::new(name, "%"))).collect());
    for (both, (world, judged)) in
        all.iter().flat_map(|both| World::OF_CAMPAIGNS.into_iter().zip(&both.judged).map(move |one| (both, one)))
    {
        let claim = &both.claim;
        let count = |method: Method| met_by(claim, method, world, cases);
        if judged.verdict().is_none_or(|verdict| matches!(verdict, Verdict::NotReproduced | Verdict::OutOfReach))
            || count(JUDGED).is_none()
        {
            continue;
        }
        let words = |count: Option<Count>| count.map_or("–".to_owned(), |count| number(100.0 * count.share(), 1));
        let mut row = vec![claim.place.to_string(), claim.words(), world.name().to_owned()];
        row.extend(ways.clone().map(|(method, _)| words(count(*method))));
        table.push(row);
    }
    table
}

/// Who ends how far above the best design known.
pub(super) fn baselines(cases: &[Case<'_>]) -> Table {
    let mut table = Table::new(vec![
        Column::new("Study", ""),
        Column::new("Water", ""),
        Column::new("Way", ""),
        Column::new("Designs", "1"),
        Column::new("Cost above the best known", "%"),
        Column::new("Random designs that are better", "%"),
        Column::new("Worse than the center", "%"),
    ]);
    for (study, world) in
        Study::OF_CAMPAIGNS.into_iter().flat_map(|study| World::OF_CAMPAIGNS.map(|world| (study, world)))
    {
        for (method, words) in WAYS {
            let (mut regrets, mut better, mut worse) = (Vec::new(), Vec::new(), 0);
            for case in cases_of(cases, study, world) {
                let center = case.center().map_or(f64::NAN, |row| row.cost());
                for end in case.ends(method) {
                    regrets.push(case.regret(end));
                    better.push(case.random_better(end));
                    worse += usize::from(end.cost() > center || end.cost().is_nan());
                }
            }
            if regrets.is_empty() {
                continue;
            }
            let share = worse as f64 / regrets.len() as f64;
            let worse = if method == Method::Center { "–".to_owned() } else { number(100.0 * share, 0) };
            table.push(vec![
                study.words().to_owned(),
                world.name().to_owned(),
                words.to_owned(),
                regrets.len().to_string(),
                quartiles(&regrets),
                quartiles(&better),
                worse,
            ]);
        }
    }
    table
}

/// What an experiment in moving water differs by from flight to flight.
pub(super) fn noise(cases: &[Case<'_>]) -> Table {
    let mut table = Table::new(vec![
        Column::new("Study", ""),
        Column::new("Designs", "1"),
        Column::new("Standard deviation of the cost", "s"),
        Column::new("as a share of the cost", "%"),
        Column::new("as a share of its range over random designs", "%"),
    ]);
    for study in Study::OF_CAMPAIGNS {
        let (mut seconds, mut of_cost, mut of_range) = (Vec::new(), Vec::new(), Vec::new());
        for case in cases_of(cases, study, World::Moving) {
            let random = case.random();
            let costs: Vec<f64> = random.iter().map(|row| row.cost()).filter(|cost| cost.is_finite()).collect();
            let range = Summary::of(&costs).map_or(f64::NAN, |summary| summary.maximum - summary.minimum);
            for row in random.iter().filter(|row| row.cost().is_finite()) {
                let sd = row.of(Reading::CostSd);
                seconds.push(sd);
                of_cost.push(sd / row.cost());
                of_range.push(sd / range);
            }
        }
        let Some(own) = Summary::of(&seconds) else { continue };
        let seconds = with_quartiles(&own, 3);
        table.push(vec![
            study.words().to_owned(),
            own.count.to_string(),
            seconds,
            quartiles(&of_cost),
            quartiles(&of_range),
        ]);
    }
    table
}

/// What is left of the space after each iteration of the dissertation's loop.
pub(super) fn spaces(cases: &[Case<'_>], published: &dyn Fn(Study, usize) -> Option<f64>) -> Table {
    let mut table = Table::new(vec![
        Column::new("Study", ""),
        Column::new("Iteration", "1"),
        Column::new("Still water", "%"),
        Column::new("Moving water", "%"),
        Column::new("Published", "%"),
    ]);
    for study in [Study::Two, Study::Four] {
        for step in 1..=5 {
            let of = |world: World| {
                let rows = cases_of(cases, study, world).flat_map(|case| case.rows.iter());
                let shares: Vec<f64> = rows
                    .filter(|row| row.method == Method::Dissertation && row.step == step)
                    .map(|row| row.share)
                    .collect();
                (!shares.is_empty()).then(|| quartiles(&shares))
            };
            let own = [of(World::Still), of(World::Moving)];
            if own.iter().all(Option::is_none) {
                continue;
            }
            let theirs = published(study, step).map_or("–".to_owned(), |share| number(share, 1));
            let [still, moving] = own.map(|words| words.unwrap_or("–".to_owned()));
            table.push(vec![study.words().to_owned(), step.to_string(), still, moving, theirs]);
        }
    }
    table
}

/// Median and quartiles over plants of what the designs show at the model's optimum and at the end of the loop.
pub(super) fn flights(cases: &[Case<'_>]) -> Table {
    let mut table = Table::new(vec![
        Column::new("Study", ""),
        Column::new("Water", ""),
        Column::new("Mean over the test", ""),
        Column::new("At the model's optimum", "1"),
        Column::new("At the end of the loop", "1"),
        Column::new("Random design", "1"),
    ]);
    let readings = [
        ("heading squared, deg²", Reading::Heading),
        ("pitch error squared, deg²", Reading::Pitch),
        ("roll error squared, deg²", Reading::Roll),
        ("roll offset, deg", Reading::RollOffset),
        ("zenith angle, deg", Reading::Zenith),
        ("altitude error squared, cm²", Reading::Altitude),
        ("footprint, cm²", Reading::Footprint),
    ];
    for (study, world) in
        Study::OF_CAMPAIGNS.into_iter().flat_map(|study| World::OF_CAMPAIGNS.map(|world| (study, world)))
    {
        let rows =
            |method: Method| -> Vec<_> { cases_of(cases, study, world).flat_map(|case| case.ends(method)).collect() };
        let all = [Method::Numerical, Method::Dissertation, Method::Random].map(rows);
        if all[0].is_empty() {
            continue;
        }
        for (words, reading) in readings {
            let summary = |rows: &Vec<&super::row::Row>| {
                let values: Vec<f64> = rows.iter().map(|row| row.of(reading)).collect();
                quartiles_of(&values, 2)
            };
            let mut row = vec![study.words().to_owned(), world.name().to_owned(), words.to_owned()];
            row.extend(all.iter().map(summary));
            table.push(row);
        }
    }
    table
}

/// What cameras see of designs in moving water, and what that does to their heading.
pub(super) fn cameras(cases: &[Case<'_>]) -> Table {
    let mut table = Table::new(vec![
        Column::new("Study", ""),
        Column::new("Design", ""),
        Column::new("Designs", "1"),
        Column::new("cannot fly with cameras", "1"),
        Column::new("with poses that are held", "1"),
        Column::new("Share of samples held", "%"),
        Column::new("Heading squared, state known", "deg²"),
        Column::new("with cameras", "deg²"),
    ]);
    for (study, method) in
        [Study::Two, Study::Four].into_iter().flat_map(|s| [(s, Method::Numerical), (s, Method::Dissertation)])
    {
        let (mut held, mut with, mut known, mut n) = (Vec::new(), Vec::new(), Vec::new(), 0);
        for case in cases_of(cases, study, World::Cameras) {
            let Some(seen) = case.ends(method).pop() else { continue };
            n += 1;
            let mut same = cases_of(cases, study, World::Moving).filter(|other| other.plant == case.plant);
            let own = same.next().and_then(|other| {
                other.rows.iter().find(|row| row.method == method && row.seed == seen.seed && row.step == seen.step)
            });
            if seen.cost().is_finite() {
                held.push(seen.of(Reading::Held));
                with.push(seen.of(Reading::Heading));
                known.extend(own.map(|row| row.of(Reading::Heading)));
            }
        }
        if n == 0 {
            continue;
        }
        let median = |values: &[f64]| page::quantile(values, 0.5).map_or("–".to_owned(), |value| number(value, 2));
        let name = if method == Method::Numerical { "model's optimum" } else { "end of the loop, first seed" };
        table.push(vec![
            study.words().to_owned(),
            name.to_owned(),
            n.to_string(),
            (n - held.len()).to_string(),
            held.iter().filter(|share| **share > 0.0).count().to_string(),
            quartiles(&held),
            median(&known),
            median(&with),
        ]);
    }
    table
}

/// What goes with claims that hold in some plants only: those with a p-value of at most this.
pub(super) const SIGNIFICANT: f64 = 0.05;

pub(super) fn decides(all: &[(&Both, usize, Decided)]) -> Table {
    let mut table =
        Table::new(["Claim", "Still water", "Moving water"].map(|name| Column::new(name, "")).into_iter().collect());
    let mut claims: Vec<&Both> = all.iter().map(|(both, ..)| *both).collect();
    claims.dedup_by(|a, b| std::ptr::eq(*a, *b));
    for both in claims {
        let cell = |world: usize| {
            let own =
                all.iter().find(|(other, k, one)| std::ptr::eq(*other, both) && *k == world && one.p <= SIGNIFICANT);
            own.map(|(.., one)| {
                format!(
                    "{}: {}; p {}, {}",
                    one.property,
                    number(one.correlation, 2),
                    number(one.p, 3),
                    number(one.p_of_all, 3)
                )
            })
        };
        let cells = [cell(0), cell(1)];
        if cells.iter().any(Option::is_some) {
            let [still, moving] = cells.map(|cell| cell.unwrap_or("–".to_owned()));
            table.push(vec![format!("{}, {}", both.claim.place, both.claim.words()), still, moving]);
        }
    }
    table
}

pub(super) fn estimates(all: &[[String; 3]]) -> Table {
    let mut table = Table::new(vec![Column::new("Number", ""), Column::new("Value", ""), Column::new("Source", "")]);
    for [key, value, source] in all {
        table.push(vec![format!("`{key}`"), value.clone(), source.clone()]);
    }
    table
}
