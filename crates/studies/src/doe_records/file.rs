//! The published record and our kept designs, read and checked.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::{Context as _, Result, ensure};
use doe::{Criterion, Design, Efficiency, Model, Space};
use serde::Deserialize;

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct PublishedFile {
    case: Vec<Published>,
}

/// The best published design of one size, in per cent of G-efficiency.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Published {
    pub(crate) factors: usize,
    pub(crate) runs: usize,
    /// Over the whole cube.
    pub(crate) cube: f64,
    /// Over five levels per factor.
    pub(crate) lattice: f64,
    /// What an earlier search of our own had reached.
    pub(crate) earlier: Option<f64>,
}

/// A design that we keep, verified in this run.
#[derive(Clone, Debug)]
pub(crate) struct Kept {
    pub(crate) design: Design,
    /// Over the cube.
    pub(crate) efficiency: Efficiency,
}

/// Factors and runs.
pub(crate) type Size = (usize, usize);

/// Everything that the fixtures hold.
#[derive(Debug)]
pub(crate) struct Record {
    pub(crate) published: BTreeMap<Size, Published>,
    pub(crate) kept: BTreeMap<Size, Kept>,
}

/// A line of the manifest.
#[derive(Debug, Deserialize)]
struct Line {
    k: usize,
    n: usize,
    model: String,
    g_percent_over_the_cube: f64,
}

/// What the manifest prints of an efficiency.
const MANIFEST_DIGITS: f64 = 2e-6;

impl Record {
    pub(crate) fn read(directory: &Path) -> Result<Self> {
        let path = directory.join("published.toml");
        let text = std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
        let file: PublishedFile = toml::from_str(&text).with_context(|| path.display().to_string())?;
        let published = file.case.into_iter().map(|case| ((case.factors, case.runs), case)).collect();

        let path = directory.join("manifest.csv");
        let mut reader = csv::Reader::from_path(&path).with_context(|| path.display().to_string())?;
        let mut kept = BTreeMap::new();
        for line in reader.deserialize() {
            let line: Line = line.with_context(|| path.display().to_string())?;
            ensure!(line.model == "quadratic", "{}: model `{}`: it must be quadratic", path.display(), line.model);
            let design = read_design(&directory.join(format!("k{}_n{}.csv", line.k, line.n)))?;
            ensure!(
                (design.n_factors(), design.n_runs()) == (line.k, line.n),
                "k{}_n{}.csv has {} runs in {} factors",
                line.k,
                line.n,
                design.n_runs(),
                design.n_factors()
            );
            let efficiency = Criterion::G.efficiency(&Model::quadratic(line.k)?, &Space::cube(line.k)?, &design)?;
            ensure!(
                (efficiency.percent - line.g_percent_over_the_cube).abs() < MANIFEST_DIGITS,
                "k{}_n{}.csv: {} %, but {} says {} %",
                line.k,
                line.n,
                efficiency.percent,
                path.display(),
                line.g_percent_over_the_cube
            );
            kept.insert((line.k, line.n), Kept { design, efficiency });
        }
        Ok(Self { published, kept })
    }
}

/// A design in coded units, one run a line under a header.
fn read_design(path: &Path) -> Result<Design> {
    let mut reader = csv::Reader::from_path(path).with_context(|| path.display().to_string())?;
    let n_factors = reader.headers()?.len();
    let mut coordinates = Vec::new();
    for record in reader.deserialize() {
        let run: Vec<f64> = record.with_context(|| path.display().to_string())?;
        coordinates.extend(run);
    }
    Design::new(n_factors, coordinates).with_context(|| path.display().to_string())
}
