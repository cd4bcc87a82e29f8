//! `cargo xtask doe-records`: our optimal designs verified beside the published record, and searched for anew.

mod file;
mod findings;
mod pictures;
mod report;

use std::path::Path;
use std::time::Instant;

use anyhow::Result;
use design_space::{Combinations, coded_level};
use doe::{Criterion, Effort, Found, Model, PredictionVariance, Problem, Settings, Space, search};
use rayon::prelude::*;

use file::{Kept, Record, Size};
use findings::{Findings, GOAL, GRID, GRID_STARTS, GridRow, LARGE_STARTS, LIST_RUNS, LIST_STARTS, MOST_STARTS, Row};

use crate::reproduction::{self, Extent, Picture, Reproduction, Run, progress};

/// The study, and the committed copy of its results.
pub(crate) const RECORDS: Reproduction = Reproduction {
    command: "doe-records",
    name: "doe-records",
    title: "Optimal designs beside the record",
    has_claims: false,
    run: Run::Always(reproduce),
};

/// Levels per factor of candidate lists in four factors, to see how the time grows with their length.
const LIST_LEVELS: [u32; 4] = [6, 12, 18, 24];
/// Sizes beyond the record, to see how the time grows: searched with a few starts.
const LARGE: [Size; 3] = [(5, 30), (6, 40), (7, 50)];

fn reproduce(root: &Path) -> Result<()> {
    let started = Instant::now();
    let out = RECORDS.prepare(root, Extent::Default)?;
    let record = Record::read(&root.join("fixtures/doe"))?;

    let bar = progress("1/3 kept designs verified, and searched for anew", record.kept.len());
    let rows = record
        .kept
        .iter()
        .map(|(size, kept)| {
            bar.inc(1);
            row(*size, kept.clone())
        })
        .collect::<Result<Vec<_>>>()?;
    bar.finish();
    let bar = progress("2/3 the grid of the case study", 4);
    let grid = [("quadratic", 18), ("quadratic", 36), ("additive quadratic", 18), ("additive quadratic", 36)]
        .into_iter()
        .map(|(model, runs)| {
            bar.inc(1);
            grid_row(model, runs)
        })
        .collect::<Result<Vec<_>>>()?;
    bar.finish();
    let bar = progress("3/3 lists, large problems, pictures", LARGE.len() + LIST_LEVELS.len() + 1);
    let lists = LIST_LEVELS
        .into_iter()
        .map(|levels| {
            bar.inc(1);
            over_list(levels)
        })
        .collect::<Result<Vec<_>>>()?;
    let large = LARGE
        .into_iter()
        .map(|(factors, runs)| {
            bar.inc(1);
            let problem = Problem::new(Model::quadratic(factors)?, Space::cube(factors)?, runs, Criterion::G)?;
            let mut settings = Settings::default();
            settings.starts = LARGE_STARTS;
            settings.effort = Effort::Quick;
            Ok(((factors, runs), search(&problem, &settings)?))
        })
        .collect::<Result<Vec<_>>>()?;
    let findings = Findings { record, rows, grid, large, lists, seconds: started.elapsed().as_secs_f64() };
    let draw: [fn(&Findings) -> Result<Picture>; 4] =
        [pictures::record, pictures::surfaces, pictures::fractions, pictures::grid_fractions];
    let pictures = draw.par_iter().map(|one| one(&findings)).collect::<Result<Vec<_>>>()?;
    bar.inc(1);
    bar.finish();

    let first = report::first_screen(&findings, &pictures)?;
    let page = report::page(&findings, &pictures, &first)?;
    let results = report::markdown(&findings, &first.markdown(&RECORDS.kept_picture()));
    reproduction::save_page(&out, &pictures, &page, &results, first.picture)?;
    report::record_table(&findings).write_csv(&out.join("record.csv"))?;
    report::search_table(&findings).write_csv(&out.join("searches.csv"))?;
    report::grid_table(&findings).write_csv(&out.join("grid.csv"))?;
    report::list_table(&findings).write_csv(&out.join("lists.csv"))?;
    report::print(&findings, &RECORDS.out());
    Ok(())
}

fn row(size: Size, kept: Kept) -> Result<Row> {
    let (factors, runs) = size;
    let problem = Problem::new(Model::quadratic(factors)?, Space::cube(factors)?, runs, Criterion::G)?;
    let mut settings = Settings::default();
    settings.starts = MOST_STARTS;
    settings.effort = Effort::Quick;
    settings.target_percent = Some(GOAL * kept.efficiency.percent);
    let again = search(&problem, &settings)?;
    let lattice_share = largest_on_lattice(&kept)? / kept.efficiency.value;
    Ok(Row { size, kept, lattice_share, again })
}

/// The largest prediction variance of a design on a lattice of about a hundred thousand points.
fn largest_on_lattice(kept: &Kept) -> Result<f64> {
    let factors = kept.design.n_factors();
    let variance = PredictionVariance::of(&Model::quadratic(factors)?, &kept.design)?;
    let levels = (1e5_f64.powf(1.0 / factors as f64).round() as u64).clamp(3, 2001);
    // An odd number, so that the middle is among them.
    let levels = levels + 1 - levels % 2;
    let mut largest = 0.0_f64;
    let lattice = Combinations::new(vec![levels; factors])?;
    for index in 0..lattice.len() {
        let point: Vec<f64> = lattice.digits(index).into_iter().map(|level| coded_level(level, levels)).collect();
        largest = largest.max(variance.at(&point)?);
    }
    Ok(largest)
}

fn grid_row(model: &'static str, runs: usize) -> Result<GridRow> {
    let terms = Model::named(model, GRID.len())?;
    let problem = Problem::new(terms, Space::grid(&GRID)?, runs, Criterion::G)?;
    let mut settings = Settings::default();
    settings.starts = GRID_STARTS;
    Ok(GridRow { model, runs, found: search(&problem, &settings)? })
}

/// A search over a list of the points of a grid in four factors, as candidates and not as a grid.
fn over_list(levels: u32) -> Result<(usize, Found)> {
    let levels = u64::from(levels);
    let level = |index: u64| coded_level(index, levels);
    let grid = Combinations::new(vec![levels; 4])?;
    // The first factor varies fastest.
    let candidates: Vec<f64> =
        (0..grid.len()).flat_map(|index| grid.digits(index).into_iter().rev().map(level)).collect();
    let n_candidates = candidates.len() / 4;
    let problem = Problem::new(Model::quadratic(4)?, Space::list(4, candidates)?, LIST_RUNS, Criterion::G)?;
    let mut settings = Settings::default();
    settings.starts = LIST_STARTS;
    Ok((n_candidates, search(&problem, &settings)?))
}
