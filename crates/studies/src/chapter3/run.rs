//! The order of things in Chapter 3.

use super::file::Setup;
use super::findings::{Findings, in_table4};
#[cfg(feature = "global")]
use super::kept;
use super::panels::{self, PanelFlights};
use super::{claims, figures, page};
use crate::bat::STAND_IN;
use crate::handover::Handover;
use crate::logged::LOG_EVERY;
use crate::reproduction::{self, Extent, Picture, Reproduction, Run, progress};
use ::page::{Column, Table, write_columns_csv};
use anyhow::{Context as _, Result};
use rayon::prelude::*;
use std::path::Path;
use std::time::Instant;
use water_channel::{FlightLog, fly_logged};

/// The study, and the committed copy of its results.
pub(crate) const CHAPTER: Reproduction = Reproduction {
    command: "reproduce-chapter3",
    name: "chapter3",
    title: "Chapter 3",
    has_claims: true,
    run: Run::Remembering(reproduce),
};

pub(crate) fn reproduce(root: &Path, extent: Extent) -> Result<()> {
    let started = Instant::now();
    let setup = Setup::read(&root.join("fixtures/bat/chapter3.toml"))?;
    let out = CHAPTER.prepare(root, extent)?;
    eprintln!("{}: the stand-in for the water channel is a richer model, not an experiment.", setup.title);

    let designs = setup.center_of_mass.places().len() * setup.trim_pitch.places().len();
    let bar = progress("1/2 open-loop flights of stand-in and model", 2 * setup.configurations.len() * designs);
    let done = |n: usize| bar.inc(n as u64);
    #[cfg(feature = "global")]
    let [stand_in, model] = kept::panels(&setup, root, extent, done)?;
    #[cfg(not(feature = "global"))]
    let [stand_in, model] = panels::fly_panels(&setup, done);
    bar.finish();

    let bar = progress("2/2 pictures", 1);
    let shown = shown_flight(&setup, &stand_in[0])?;
    let findings = Findings { setup: &setup, stand_in, model, shown, seconds: started.elapsed().as_secs_f64() };
    let draw: [fn(&Findings<'_>) -> Picture; 4] = [
        figures::lowest,
        |f| figures::figure14(f, &f.stand_in, "figure-14", "the stand-in for the water channel"),
        |f| figures::figure14(f, &f.model, "figure-14-model", "the numerical model"),
        figures::one_flight,
    ];
    let pictures: Vec<Picture> = draw.par_iter().map(|one| one(&findings)).collect();
    bar.inc(1);
    bar.finish();

    let claims = claims::claims(&findings);
    let first = page::first_screen(&findings, &pictures)?;
    let page = page::page(&findings, &claims, &pictures, &first)?;
    let results = page::markdown(&findings, &claims, &first.markdown(&CHAPTER.kept_picture()));
    reproduction::save_page(&out, &pictures, &page, &results, first.picture)?;
    Handover::new(claims, &pictures).save(&out)?;
    designs_csv(&findings, &out.join("designs.csv"))?;
    page::print(&findings, &CHAPTER.out());
    Ok(())
}

/// The best design of a panel once more, with its log.
pub(crate) fn shown_flight(setup: &Setup, panel: &PanelFlights<'_>) -> Result<FlightLog> {
    let (best, _) = panel.best(|design| in_table4(setup, design)).context("no design of the first panel flies")?;
    let request = setup.request(panel.configuration, best.at, STAND_IN);
    let (flight, log) = fly_logged(&request, &setup.profile, &setup.settings, LOG_EVERY)?;
    flight?;
    Ok(log)
}

/// Every design of every panel.
pub(crate) fn designs_csv(findings: &Findings<'_>, path: &Path) -> Result<()> {
    let mut labels = Table::new(vec![Column::new("panel", "1"), Column::new("configuration", "")]);
    let mut columns: [Vec<f64>; 8] = Default::default();
    for (physics, panels) in [(0.0, &findings.stand_in), (1.0, &findings.model)] {
        for (number, panel) in panels.iter().enumerate() {
            for design in panel.designs() {
                let [heading, lateral] = design.outcome.clone().unwrap_or([f64::NAN; 2]);
                let slack = f64::from(u8::from(matches!(design.outcome, Err(panels::Failure::Slack(_)))));
                let row = [
                    physics,
                    number as f64 + 1.0,
                    design.at[0],
                    design.at[1],
                    heading,
                    lateral,
                    design.growth_per_s.clone().unwrap_or(f64::NAN),
                    slack,
                ];
                for (column, value) in columns.iter_mut().zip(row) {
                    column.push(value);
                }
            }
        }
    }
    for (number, panel) in findings.stand_in.iter().enumerate() {
        labels.push(vec![(number + 1).to_string(), panel.configuration.label.clone()]);
    }
    labels.write_csv(&path.with_file_name("panels.csv"))?;
    let heads = [
        ("physics: 0 stand-in, 1 numerical model", "1"),
        ("panel", "1"),
        ("center of mass", "% chord"),
        ("trim pitch", "deg"),
        ("cost of heading", "s"),
        ("cost of lateral position", "s"),
        ("fastest growth of a mode", "1/s"),
        ("a line went slack", "1"),
    ];
    let columns: Vec<(Column, &[f64])> =
        heads.iter().zip(&columns).map(|((name, unit), values)| (Column::new(name, unit), values.as_slice())).collect();
    Ok(write_columns_csv(path, &columns)?)
}
