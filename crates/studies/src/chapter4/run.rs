//! The order of things in Chapter 4.

use super::figures::Material;
use super::file::Setup;
use super::findings::{CHECKED_POINTS, Findings};
use super::lattice::Lattice;
use super::loops::{Direct, PHYSICS};
use super::rows::Rows;
use super::seeds::followed;
use super::tables::Digits;
use super::{claims, figures, loops, margins, page, tables};
use crate::bat::{MODEL, STAND_IN};
use crate::handover::Handover;
#[cfg(feature = "global")]
use crate::memory::Memory;
use crate::reproduction::{self, Extent, Picture, Reproduction, Run, progress};
use ::page::{Column, write_columns_csv};
use anyhow::{Context as _, Result};
use infuse::codesign::CodesignReport;
use rayon::prelude::*;
use std::path::Path;
use std::time::Instant;

/// The study, and the committed copy of its results.
pub(crate) const CHAPTER: Reproduction = Reproduction {
    command: "reproduce-chapter4",
    name: "chapter4",
    title: "Chapter 4",
    has_claims: true,
    run: Run::Remembering(reproduce),
};

/// Runs the study of Chapter 4 and writes the page, the figures and the data.
pub(crate) fn reproduce(root: &Path, extent: Extent) -> Result<()> {
    let started = Instant::now();
    let setup = Setup::read(&root.join("fixtures/bat/chapter4.toml"))?;
    let out = CHAPTER.prepare(root, extent)?;
    #[cfg(feature = "global")]
    Memory::of(root, extent).remind(&setup.bat, setup.problem.region(), &PHYSICS.map(|(_, fidelity)| fidelity))?;
    eprintln!("{}: the stand-in for the water channel is a richer model, not an experiment.", setup.file.title);

    let bar = progress("1/4 cost landscapes: flights of model and stand-in", 2 * Lattice::size(&setup));
    let done = |n: usize| bar.inc(n as u64);
    let model = Lattice::fly(&setup, MODEL, done);
    let stand_in = Lattice::fly(&setup, STAND_IN, done);
    bar.finish();

    let iterations = setup.loop_settings(&setup.file.variant[0]).max_iterations * setup.file.variant.len();
    let bar = progress("2/4 loops without noise: iterations", iterations);
    let Direct { campaigns, optima } = loops::direct(&setup, || bar.inc(1))?;
    bar.finish();

    let noisy = setup.file.variant.iter().filter(|variant| variant.with_noise).count();
    let bar = progress("3/4 loops with noise: campaigns", setup.file.noise.seeds as usize * noisy);
    let seeded = loops::seeded(&setup, &model, || bar.inc(1))?;
    bar.finish();

    let bar = progress("4/4 reported designs, margins over the box, pictures", margins::n_flights() + 2);
    let interpolation_error = interpolation_error(&setup, &model)?;
    let rows = Rows::fly(&setup, campaigns)?;
    let box_table = margins::box_table(&setup, |n| bar.inc(n as u64));
    let physics_table = margins::physics_table(&setup, &optima, &rows[0].first().point);
    let step_table = margins::step_table(&setup, &rows[0].first().point)?;
    bar.inc(1);
    let material = Material { setup: &setup, rows: &rows, model: &model, stand_in: &stand_in, seeded: &seeded };
    let pictures = pictures(&material);
    bar.inc(1);
    bar.finish();

    let findings = Findings {
        material,
        best: of_stand_in(optima).context("the optimum of the stand-in")?,
        interpolation_error,
        box_table,
        physics_table,
        step_table,
        seconds: started.elapsed().as_secs_f64(),
        pictures: &pictures,
    };
    write(&out, &findings)?;
    page::print(&findings, &CHAPTER.out());
    Ok(())
}

fn of_stand_in(optima: Vec<CodesignReport>) -> Option<CodesignReport> {
    PHYSICS.iter().zip(optima).find_map(|((_, fidelity), optimum)| (*fidelity == STAND_IN).then_some(optimum))
}

/// All figures, drawn side by side.
fn pictures(material: &Material<'_>) -> Vec<Picture> {
    let draw: [fn(&Material<'_>) -> Vec<Picture>; 4] = [
        |m| vec![figures::costs(m), figures::test_profile(m)],
        |m| figures::errors(m).to_vec(),
        |m| figures::landscapes(m).to_vec(),
        figures::spreads,
    ];
    draw.par_iter().flat_map_iter(|one| one(material)).collect()
}

/// Largest departure of the interpolated model cost from a flight, relative, over points between the lattice's.
pub(crate) fn interpolation_error(setup: &Setup, model: &Lattice) -> Result<f64> {
    let interpolant = model.interpolant()?;
    let points: Vec<Vec<f64>> = (0..CHECKED_POINTS)
        .map(|k| {
            // A rank-one lattice fills the box without repeating a coordinate.
            let share = (k as f64 + 0.5) / CHECKED_POINTS as f64;
            let other = (share * 0.618_033_988_75 * CHECKED_POINTS as f64).fract();
            let at = |k: usize, s: f64| setup.bounds(k).0 + s * (setup.bounds(k).1 - setup.bounds(k).0);
            vec![at(0, share), at(1, other)]
        })
        .collect();
    let flown = setup.bat.costs(&points, MODEL, |_| {});
    let mut largest = 0.0_f64;
    for (point, cost) in points.iter().zip(flown) {
        if let (Ok(cost), Ok(guess)) = (cost, interpolant(point)) {
            largest = largest.max((guess / cost - 1.0).abs());
        }
    }
    Ok(largest)
}

/// The page, the figures and the data.
pub(crate) fn write(out: &Path, findings: &Findings<'_>) -> Result<()> {
    let claims = claims::claims(findings);
    let first = page::first_screen(findings)?;
    let page = page::page(findings, &claims, &first);
    let results = page::markdown(findings, &claims, &first.markdown(&CHAPTER.kept_picture()));
    reproduction::save_page(out, findings.pictures, &page, &results, first.picture)?;
    Handover::new(claims, findings.pictures).save(out)?;
    let m = &findings.material;
    tables::iteration_table(m.setup, &m.rows[0], Digits::All).write_csv(&out.join("table-3.csv"))?;
    tables::variant_table(m.setup, m.rows, Digits::All).write_csv(&out.join("loops.csv"))?;
    tables::cost_table(&m.rows[0], Digits::All).write_csv(&out.join("costs.csv"))?;
    tables::flight_table(&m.rows[0], Digits::All).write_csv(&out.join("flights.csv"))?;
    tables::seed_data(m.setup, m.seeded).write_csv(&out.join("seeds-summary.csv"))?;
    seeds_csv(findings, &out.join("seeds.csv"))?;
    for (lattice, name) in [(m.model, "landscape-model.csv"), (m.stand_in, "landscape-stand-in.csv")] {
        landscape_csv(m.setup, lattice, &out.join(name))?;
    }
    for (row, name) in [(m.rows[0].first(), "flight-before.csv"), (m.rows[0].last(), "flight-after.csv")] {
        let path = out.join(name);
        let file = std::fs::File::create(&path).with_context(|| path.display().to_string())?;
        row.logged.log.write_csv(std::io::BufWriter::new(file))?;
    }
    Ok(())
}

pub(crate) fn landscape_csv(setup: &Setup, lattice: &Lattice, path: &Path) -> Result<()> {
    let column = |k| Column::new(setup.variable(k).label(), setup.variable(k).unit());
    let (axes, rows) = lattice.box_rows();
    let (mut x, mut y, mut z) = (Vec::new(), Vec::new(), Vec::new());
    for (pitch, row) in axes[1].iter().zip(rows) {
        x.extend(&axes[0]);
        y.extend(std::iter::repeat_n(*pitch, row.len()));
        z.extend(row);
    }
    Ok(write_columns_csv(path, &[(column(0), &x), (column(1), &y), (Column::new("cost", "s"), &z)])?)
}

/// Every iteration of every seed of every loop.
pub(crate) fn seeds_csv(findings: &Findings<'_>, path: &Path) -> Result<()> {
    let m = &findings.material;
    let mut columns = vec![Column::new("loop", ""), Column::new("seed", "1"), Column::new("iteration", "1")];
    let followed = followed(m.setup);
    columns.extend(followed.iter().map(|followed| followed.column.clone()));
    columns.push(Column::new("Experimental cost as measured", "s"));
    let mut table = ::page::Table::new(columns);
    for seeded in m.seeded {
        for (seed, campaign) in &seeded.campaigns {
            for report in &campaign.reports {
                let mut row = vec![seeded.label.clone(), seed.to_string(), report.iteration.to_string()];
                row.extend(followed.iter().map(|followed| (followed.of)(m.setup, report).to_string()));
                row.push(report.experiment_cost.map_or(String::new(), |cost| cost.to_string()));
                table.push(row);
            }
        }
    }
    Ok(table.write_csv(path)?)
}
