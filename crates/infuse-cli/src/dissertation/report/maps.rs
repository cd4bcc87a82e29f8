//! The combined surface over pairs of parameters, through the best design.

use std::collections::BTreeSet;

use anyhow::Result;
use page::palette::{INK, VERMILION, gray};
use page::{Key, Mark, Page};

use super::last::{Last, Origin};
use crate::report::maps::{Apart, Cell, Map, Maps, Plane, most_varied};

pub(super) fn write(page: &mut Page, last: &Last) -> Result<()> {
    let maps = Maps {
        problem: &last.campaign.problem,
        grid: last.campaign.now.grid(),
        through: last.report.screening.optimum_cell,
        marks: marks(last),
    };
    let planes = maps.planes()?;
    if planes.is_empty() {
        return Ok(());
    }
    let n_pairs = planes.len();
    let all = planes.into_iter().map(|plane| map(last, plane)).collect::<Result<Vec<_>>>()?;
    let shown = most_varied(all);
    page.subheading("Over pairs of parameters, through the best design");
    let caption = caption(last) + &maps.left_out(&shown, n_pairs);
    page.charts(&maps.charts(&shown), &legend(last, &shown), &caption);
    Ok(())
}

fn map(last: &Last, plane: Plane) -> Result<Map> {
    let now = &last.campaign.now;
    let cell = |&cell: &design_space::Cell| {
        let value = last.value(&last.surfaces.combined, &now.grid().point(cell)?)?;
        let dropped = now.why_dropped(cell).map(|dropped| dropped.batch).or(now.failed_in(cell));
        let class = dropped.map_or_else(|| "left".to_owned(), |batch| format!("dropped by-{batch}"));
        let apart = dropped
            .map(|batch| Apart { fill: gray(batch, last.report.number), words: format!("dropped by batch {batch}") });
        Ok(Cell { value, class, apart })
    };
    let cells = plane.designs.iter().map(cell).collect::<Result<Vec<_>>>()?;
    Ok(Map::new(plane, cells))
}

/// Runs, simulations and the best design, in the order in which they are drawn.
fn marks(last: &Last) -> Vec<(Vec<f64>, Mark)> {
    let runs = last.runs.iter().map(|run| (run.settings.clone(), mark(run.origin, run.cost.is_none())));
    let simulations = last.report.simulations.iter().map(|simulation| (simulation.point.clone(), Mark::Speck));
    let best = (last.report.screening.optimum.clone(), Mark::Target);
    runs.chain(simulations).chain([best]).collect()
}

fn mark(origin: Origin, is_failed: bool) -> Mark {
    match origin {
        _ if is_failed => Mark::Cross,
        Origin::Imported => Mark::Square,
        Origin::Training | Origin::Validation => Mark::Ring,
    }
}

fn legend(last: &Last, maps: &[Map]) -> Vec<Key> {
    let mut keys = vec![Key::new("best design").mark(Mark::Target, VERMILION)];
    let is_there = |origin: Origin, is_failed: bool| {
        last.runs.iter().any(|run| {
            (run.origin == Origin::Imported) == (origin == Origin::Imported) && run.cost.is_none() == is_failed
        })
    };
    for (origin, is_failed, text) in [
        (Origin::Training, false, "experiment"),
        (Origin::Training, true, "experiment without a result"),
        (Origin::Imported, false, "imported experiment"),
    ] {
        if is_there(origin, is_failed) {
            keys.push(Key::new(text).mark(mark(origin, is_failed), INK));
        }
    }
    keys.push(Key::new("simulation").mark(Mark::Speck, INK));
    let fates = maps.iter().flat_map(|map| &map.cells).filter_map(|cell| cell.apart.as_ref());
    let fates: BTreeSet<(&str, &str)> = fates.map(|apart| (apart.words.as_str(), apart.fill.as_str())).collect();
    if !fates.is_empty() {
        keys.push(Key::new("edge of what is left").border());
    }
    // Grays darken from batch to batch, and words of batches beyond the ninth sort before those of the second.
    let mut fates: Vec<(&str, &str)> = fates.into_iter().collect();
    fates.sort_by_key(|&(words, _)| (words.len(), words));
    for (words, fill) in fates {
        keys.push(Key::new(words).field(fill));
    }
    keys
}

fn caption(last: &Last) -> String {
    let (response, best) = (last.response(), &last.report.screening.optimum);
    let mut text = format!(
        "Color: {} by the combined surface of batch {}; darker is better, and colors change faster near the best.",
        response.heading(),
        last.report.number
    );
    let others = last.parameters().len() > 2;
    if others {
        text.push_str(&format!(
            " The other parameters are at their best settings, {}; runs are drawn whatever their settings of them.",
            last.campaign.problem.describe(best)
        ));
    }
    text.push_str(" Experiments and simulations are those of this batch.");
    text
}
