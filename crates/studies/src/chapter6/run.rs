//! The order of things in Chapter 6.

use super::campaigns::{Campaigns, fly};
use super::file::Setup;
use super::findings::Findings;
use super::{all_levels, claims, figures, flights, page, tables};
use crate::bat::MODEL;
use crate::handover::Handover;
use crate::memory::Memory;
use crate::reproduction::{self, Extent, Picture, Reproduction, Run, progress};
use anyhow::Result;
use std::path::Path;
use std::time::Instant;

/// The study, and the committed copy of its results.
pub(crate) const CHAPTER: Reproduction = Reproduction {
    command: "reproduce-chapter6",
    name: "chapter6",
    title: "Chapter 6",
    has_claims: true,
    run: Run::OrFull(reproduce),
};

pub(crate) fn reproduce(root: &Path, extent: Extent) -> Result<()> {
    let out = CHAPTER.prepare(root, extent)?;
    let (findings, pictures) = study(root, extent)?;
    let claims = claims::claims(&findings);
    let mut first = page::first_screen(&findings, &claims, &pictures)?;
    let fewer = if extent == Extent::Full {
        eprintln!("The same with fewer levels, to be put beside it:");
        let fewer = claims::claims(&study(root, Extent::Default)?.0);
        first.findings.insert(2, page::changed(&claims, &fewer));
        all_levels::keep(root, &claims)?;
        Some(fewer)
    } else {
        None
    };
    let page = page::page(&findings, &claims, &pictures, &first)?;
    let kept_picture = first.markdown(&CHAPTER.kept_picture_of(extent));
    let results = page::markdown(&findings, &claims, fewer.as_deref(), &kept_picture)?;
    reproduction::save_page(&out, &pictures, &page, &results, first.picture)?;
    tables::iterations(&findings).write_csv(&out.join("iterations.csv"))?;
    tables::campaigns(&findings).write_csv(&out.join("campaigns.csv"))?;
    let handover = Handover::new(claims, &pictures);
    handover.save(&out)?;
    page::print(&findings, &handover.claims, &CHAPTER.out_of(extent))
}

/// All flights and campaigns, with their pictures.
fn study(root: &Path, extent: Extent) -> Result<(Findings, Vec<Picture>)> {
    let started = Instant::now();
    let setup = Setup::read(&root.join("fixtures/bat/chapter6.toml"), extent)?;
    let memory = Memory::of(root, extent);
    for space in &setup.spaces {
        memory.remind(&space.bat, space.space.region(), &setup.fidelities())?;
    }
    let designs = memory.designs()?;
    eprintln!("{}: the experiments are flights of a richer model with noise.", setup.file.title);

    let n_flights: usize = setup.spaces.iter().map(|space| space.space.n_cells() * (1 + setup.n_truths())).sum();
    if extent == Extent::Full {
        eprintln!("--full: {}", estimate(&setup)?);
    }
    let bar = progress("1/3 true costs: flights of model and richer models", n_flights);
    let flown = fly(&setup, |n| bar.inc(n as u64))?;
    bar.finish();

    let cases = setup.cases();
    let bar = progress("2/3 campaigns: iterations", cases.len() * setup.file.iterations.iterations);
    let study = Campaigns { setup: &setup, flown: &flown, designs: &designs };
    let ended = study.run(&cases, |n| bar.inc(n as u64))?;
    bar.finish();

    let bar = progress("3/3 designs of the figures, pictures", 2);
    let mut findings = Findings { setup, extent, flown, ended, footprints: Vec::new(), seconds: 0.0 };
    findings.footprints = flights::all(&findings.setup, &findings.all_shown()?)?;
    bar.inc(1);
    let pictures = figures::all(&findings)?;
    bar.inc(1);
    bar.finish();
    findings.seconds = started.elapsed().as_secs_f64();
    Ok((findings, pictures))
}

/// How long the flights will take, by the pace of a few.
pub(crate) fn estimate(setup: &Setup) -> Result<String> {
    const TIMED: usize = 64;
    let (mut missing, mut seconds) = (0, 0.0);
    for space in &setup.spaces {
        let points = space.space.points()?;
        for fidelity in setup.fidelities() {
            missing += space.bat.n_missing(&points, fidelity);
        }
        let timed: Vec<_> = points.iter().step_by(points.len().div_ceil(TIMED)).cloned().collect();
        let started = Instant::now();
        space.bat.flown_costs(&timed, MODEL, |_| {});
        seconds = started.elapsed().as_secs_f64() / timed.len() as f64;
    }
    Ok(format!(
        "{missing} flights of 300 s are missing, about {:.0} minutes at the present pace of this machine; then the campaigns. What was \
         flown is remembered, and an interrupted run goes on where it was.",
        (missing as f64 * seconds / 60.0).ceil()
    ))
}
