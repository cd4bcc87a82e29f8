//! `cargo xtask doe-records`: our optimal designs verified beside the published record, and searched for anew.

mod file;
mod findings;
mod kept;
mod pictures;
mod report;
mod searches;

use std::path::Path;
use std::time::Instant;

use anyhow::Result;
use design_space::{Combinations, coded_level};
use doe::{Found, Model, PredictionVariance};
use rayon::prelude::*;

use file::{Kept, Record, Size};
use findings::{Findings, GridRow, Row, Verified};
use searches::{LARGE, LIST_LEVELS, ON_GRID, Search};

use crate::reproduction::{self, Extent, Picture, Reproduction, Run, progress};

/// The study, and the committed copy of its results.
pub(crate) const RECORDS: Reproduction = Reproduction {
    command: "doe-records",
    name: "doe-records",
    title: "Optimal designs beside the record",
    has_claims: false,
    run: Run::Remembering(reproduce),
};

fn reproduce(root: &Path, extent: Extent) -> Result<()> {
    let started = Instant::now();
    let out = RECORDS.prepare(root, Extent::Default)?;
    let verified = verify(Record::read(&root.join("fixtures/doe"))?)?;
    if extent == Extent::WithKept { check(root, &out, &verified) } else { search_all(root, &out, verified, started) }
}

/// Every kept design with what a lattice says of it.
fn verify(record: Record) -> Result<Verified> {
    let bar = progress("kept designs verified", record.kept.len());
    let row = |(size, kept): (&Size, &Kept)| {
        let lattice_share = largest_on_lattice(kept)? / kept.efficiency.value;
        bar.inc(1);
        Ok(Row { size: *size, kept: kept.clone(), lattice_share })
    };
    let rows = record.kept.iter().map(row).collect::<Result<Vec<_>>>()?;
    bar.finish();
    Ok(Verified { record, rows })
}

/// Writes what is kept in `docs/`, which no search decides, and holds some searches against what they found when that was kept.
fn check(root: &Path, out: &Path, verified: &Verified) -> Result<()> {
    let pictures = [pictures::record(verified)?];
    let first = report::first_screen(verified, &pictures)?;
    let results = report::markdown(verified, &first.markdown(&RECORDS.kept_picture()));
    reproduction::save_results(out, &results, first.picture)?;
    let kinds = kept::kinds(&verified.record);
    kept::check(&kept::file(root, &kinds), &kinds)
}

/// Runs all searches and writes everything; keeps what they found where it is missing.
fn search_all(root: &Path, out: &Path, verified: Verified, started: Instant) -> Result<()> {
    let kinds = kept::kinds(&verified.record);
    let bar = progress("searches", kinds.iter().map(Vec::len).sum());
    let mut lines = String::new();
    let mut run = |searches: &Vec<Search>| {
        let one = |search: &Search| {
            let found = search.run()?;
            lines += &format!("{}\n", kept::line(*search, &found));
            bar.inc(1);
            Ok(found)
        };
        searches.iter().map(one).collect::<Result<Vec<Found>>>()
    };
    let [again, grid, lists, large] = [run(&kinds[0])?, run(&kinds[1])?, run(&kinds[2])?, run(&kinds[3])?];
    bar.finish();
    let file = kept::file(root, &kinds);
    if file.rows()?.is_none() {
        file.write(&lines)?;
    }
    let findings = Findings {
        verified,
        again,
        grid: ON_GRID.into_iter().zip(grid).map(|((model, runs), found)| GridRow { model, runs, found }).collect(),
        large: LARGE.into_iter().zip(large).collect(),
        lists: LIST_LEVELS.into_iter().map(|levels| levels.pow(4) as usize).zip(lists).collect(),
        seconds: started.elapsed().as_secs_f64(),
    };
    write(out, &findings)
}

fn write(out: &Path, findings: &Findings) -> Result<()> {
    let verified = &findings.verified;
    let draw: [&(dyn Fn() -> Result<Picture> + Sync); 4] =
        [&|| pictures::record(verified), &|| pictures::surfaces(verified), &|| pictures::fractions(verified), &|| {
            pictures::grid_fractions(findings)
        }];
    let pictures = draw.par_iter().map(|one| one()).collect::<Result<Vec<_>>>()?;
    let first = report::first_screen(verified, &pictures)?;
    let page = report::page(findings, &pictures, &first)?;
    let results = report::markdown(verified, &first.markdown(&RECORDS.kept_picture()));
    reproduction::save_page(out, &pictures, &page, &results, first.picture)?;
    report::record_table(verified).write_csv(&out.join("record.csv"))?;
    report::search_table(findings).write_csv(&out.join("searches.csv"))?;
    report::grid_table(findings).write_csv(&out.join("grid.csv"))?;
    report::list_table(findings).write_csv(&out.join("lists.csv"))?;
    report::print(findings, &RECORDS.out());
    Ok(())
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
