//! What is expected over pairs of parameters, through the recommended design.

use anyhow::Result;
use design_space::Cell;
use infuse::pooled::reported::FEASIBLE;
use page::palette::{INK, VERMILION, gray};
use page::{Key, Mark, Page};

use super::view::{View, without_marks};
use crate::number::percent;
use crate::pooled::campaign::{Access, Origin};
use crate::report::maps::{self, Apart, Map, Maps, Plane, most_varied};

/// Of designs that are not sure enough to keep to their bounds, and of those that are not to be had at all.
const UNSURE: &str = "#cfcfcf";
const NOT_ALLOWED: &str = "#ffffff";
/// With more simulations than these, they are not marked.
const MOST_SIMULATED: usize = 200;

pub(super) fn write(page: &mut Page, view: &View) -> Result<()> {
    if view.planes.is_empty() {
        return Ok(());
    }
    let maps = Maps { marks: marks(view)?, ..without_marks(view) };
    let all: Vec<Map> = view.planes.iter().map(|plane| map(view, plane)).collect();
    let n_pairs = all.len();
    let shown = most_varied(all);
    page.subheading("Over pairs of parameters, through the recommended design");
    let caption = caption(view) + &maps.left_out(&shown, n_pairs);
    page.charts(&maps.charts(&shown), &legend(&maps, &shown), &caption);
    Ok(())
}

fn map(view: &View, plane: &Plane) -> Map {
    let cell = |&cell: &Cell| {
        let band = view.band(cell);
        let (value, feasible) = band.map_or((f64::NAN, 1.0), |band| (band.mean, band.feasible));
        if let Some(why_not) = view.campaign.why_not(cell) {
            let apart = Apart { fill: NOT_ALLOWED.to_owned(), words: why_not };
            return maps::Cell { value, class: "forbidden".to_owned(), apart: Some(apart) };
        }
        let is_apart = feasible < FEASIBLE;
        if !is_apart && let Some((held, within)) = view.unsure(cell) {
            let words = format!("{} is {} with {} probability", held.name(), held.bounds(), percent(within));
            let apart = Apart { fill: UNSURE.to_owned(), words };
            return maps::Cell { value, class: "unsure".to_owned(), apart: Some(apart) };
        }
        let class = if is_apart { "unlikely" } else { "expected" }.to_owned();
        let words = format!("a run gives a value with {} probability", percent(feasible));
        maps::Cell { value, class, apart: is_apart.then(|| Apart { fill: gray(1, 1), words }) }
    };
    Map::new(plane.clone(), plane.designs.iter().map(cell).collect())
}

/// Simulations where there are few, runs, and the recommended design.
fn marks(view: &View) -> Result<Vec<(Vec<f64>, Mark)>> {
    let mut marks = Vec::new();
    if view.access == Access::Budget && view.simulated.len() <= MOST_SIMULATED {
        for &cell in view.simulated.keys() {
            marks.push((view.campaign.grid.point(cell)?, Mark::Speck));
        }
    }
    marks.extend(view.runs.iter().map(|run| {
        let mark = if matches!(run.origin, Origin::Imported(_)) { Mark::Square } else { Mark::Ring };
        (run.settings.clone(), mark)
    }));
    marks.extend(view.failed.iter().map(|settings| (settings.clone(), Mark::Cross)));
    marks.push((view.best().to_vec(), Mark::Target));
    Ok(marks)
}

fn legend(maps: &Maps, shown: &[Map]) -> Vec<Key> {
    let mut keys = vec![Key::new("recommended design").mark(Mark::Target, VERMILION)];
    for (mark, text) in [
        (Mark::Ring, "experiment"),
        (Mark::Cross, "experiment without a result"),
        (Mark::Square, "imported experiment"),
        (Mark::Speck, "simulation"),
    ] {
        if maps.marks.iter().any(|(_, other)| *other == mark) {
            keys.push(Key::new(text).mark(mark, INK));
        }
    }
    for (class, fill, text) in [
        ("unlikely", &*gray(1, 1), &*format!("a run gives a value with less than {} probability", percent(FEASIBLE))),
        ("unsure", UNSURE, "not sure enough to keep to the bounds"),
        ("forbidden", NOT_ALLOWED, "not to be had"),
    ] {
        if shown.iter().flat_map(|map| &map.cells).any(|cell| cell.class == class) {
            keys.push(Key::new(text).field(fill));
        }
    }
    keys
}

fn caption(view: &View) -> String {
    let problem = &view.campaign.problem;
    let mut text = format!(
        "Color: {} as expected; darker is better, and colors change faster near the best.",
        problem.response.heading()
    );
    if view.parameters().len() > 2 {
        text.push_str(&format!(
            " The other parameters are as recommended, {}; runs are drawn whatever their settings of them.",
            problem.describe(view.best())
        ));
    }
    text
}
