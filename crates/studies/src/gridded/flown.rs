//! The cost at every cell of a design space, flown once and kept on disk.

use std::fs::{self, File, OpenOptions};
use std::io::{Read as _, Write as _};
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result};
use bat_dynamics::Fidelity;

use super::key::key;
use super::on_demand::{Begun, OnDemand};
use super::space::Space;
use crate::study::{Cost, Study};

/// Flights between two writes: an interrupt loses a few seconds.
const PIECE: usize = 1024;
/// What stands before the reason of a flight without a cost.
const FAILED: &str = "failed: ";

/// Where flown cells are kept: one file for each combination of study, space and fidelity, named after all of it.
///
/// A file is a list of lines, cell and cost (or the reason why there is none) parted by a tabulator, in any order. It
/// only grows; what a killed process leaves of a line is cut off by the next one.
#[derive(Clone, Debug)]
pub(crate) struct FlightStore {
    directory: PathBuf,
}

impl FlightStore {
    pub(crate) fn new(directory: PathBuf) -> Self {
        Self { directory }
    }

    /// The costs at every cell of a space, flown where no file knows them. `landed` hears of each, known ones included.
    pub(crate) fn fly(
        &self,
        study: &Study,
        space: &Space,
        fidelity: Fidelity,
        landed: impl Fn(usize) + Sync,
    ) -> Result<FlownGrid> {
        let Kept { key, path, mut file, mut costs } = self.kept(study, space, fidelity)?;
        let missing: Vec<usize> = (0..costs.len()).filter(|cell| costs[*cell].is_none()).collect();
        landed(costs.len() - missing.len());
        for piece in missing.chunks(PIECE) {
            let points = piece.iter().map(|cell| space.point(*cell)).collect::<Result<Vec<_>>>()?;
            let flown = study.flown_costs(&points, fidelity, &landed);
            let lines: String = piece.iter().zip(&flown).map(|(cell, cost)| line(*cell, cost)).collect();
            file.write_all(lines.as_bytes()).with_context(|| path.display().to_string())?;
            for (cell, cost) in piece.iter().zip(flown) {
                costs[*cell] = Some(cost);
            }
        }
        Ok(FlownGrid { key, costs: costs.into_iter().flatten().collect() })
    }

    /// The costs of single cells of a space, flown when they are asked for; `range` is what their noise is a part of.
    pub(crate) fn on_demand<'a>(
        &self,
        study: &'a Study,
        space: &'a Space,
        fidelity: Fidelity,
        range: f64,
    ) -> Result<OnDemand<'a>> {
        let Kept { key, path, file, costs } = self.kept(study, space, fidelity)?;
        let known = costs.into_iter().enumerate().filter_map(|(cell, cost)| Some((cell, cost?))).collect();
        Ok(OnDemand::new(study, space, fidelity, Begun { key: format!("{key} {range}"), range, known, file, path }))
    }

    /// How many cells no file knows.
    pub(crate) fn n_missing(&self, study: &Study, space: &Space, fidelity: Fidelity) -> Result<usize> {
        Ok(self.kept(study, space, fidelity)?.costs.iter().filter(|cost| cost.is_none()).count())
    }

    fn kept(&self, study: &Study, space: &Space, fidelity: Fidelity) -> Result<Kept> {
        let key = Self::key(study, space, fidelity)?;
        let path = self.directory.join(format!("{key}.tsv"));
        fs::create_dir_all(&self.directory).with_context(|| self.directory.display().to_string())?;
        let mut costs = vec![None; space.n_cells()];
        let file = open(&path, &mut costs).with_context(|| path.display().to_string())?;
        Ok(Kept { key, path, file, costs })
    }

    /// Everything that the costs depend on. That includes the plant, the controller and the integration of this program,
    /// of which the costs of designs all over the space tell.
    fn key(study: &Study, space: &Space, fidelity: Fidelity) -> Result<String> {
        let probes = (0..PROBES).map(|probe| probe * (space.n_cells() - 1) / (PROBES - 1));
        let points = probes.map(|cell| space.point(cell)).collect::<Result<Vec<_>>>()?;
        let probes = format!("{:?}", study.costs(&points, fidelity, |_| {}));
        let region = serde_json::to_string(space.region())?;
        Ok(key([study.contents(fidelity).as_str(), &region, &probes]))
    }
}

/// Designs whose costs stand for the program.
const PROBES: usize = 24;

/// A file and what it knows.
struct Kept {
    key: String,
    path: PathBuf,
    file: File,
    costs: Vec<Option<Cost>>,
}

pub(super) fn line(cell: usize, cost: &Cost) -> String {
    match cost {
        Ok(cost) => format!("{cell}\t{cost}\n"),
        Err(reason) => format!("{cell}\t{FAILED}{}\n", reason.replace(['\n', '\t'], " ")),
    }
}

fn read_line(line: &str) -> Option<(usize, Cost)> {
    let (cell, cost) = line.split_once('\t')?;
    let cost = match cost.strip_prefix(FAILED) {
        Some(reason) => Err(reason.to_owned()),
        None => Ok(cost.parse::<f64>().ok().filter(|cost| cost.is_finite())?),
    };
    Some((cell.parse().ok()?, cost))
}

/// Opens a file to go on with it, and notes what it knows. Lines that make no sense are as good as not there.
fn open(path: &Path, costs: &mut [Option<Cost>]) -> std::io::Result<File> {
    let mut file = OpenOptions::new().read(true).append(true).create(true).open(path)?;
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes)?;
    let whole = bytes.iter().rposition(|byte| *byte == b'\n').map_or(0, |end| end + 1);
    file.set_len(whole as u64)?;
    for line in String::from_utf8_lossy(&bytes[..whole]).lines() {
        if let Some((cell, cost)) = read_line(line)
            && let Some(place) = costs.get_mut(cell)
        {
            *place = Some(cost);
        }
    }
    Ok(file)
}

/// The cost at every cell of a space.
#[derive(Clone, Debug)]
pub(crate) struct FlownGrid {
    /// A name for all that these costs depend on.
    pub(crate) key: String,
    costs: Vec<Cost>,
}

impl FlownGrid {
    /// Costs that were not flown.
    #[cfg(test)]
    pub(super) fn of_costs(key: &str, costs: Vec<Cost>) -> Self {
        Self { key: key.to_owned(), costs }
    }

    pub(crate) fn cost(&self, cell: usize) -> &Cost {
        &self.costs[cell]
    }

    /// The costs, NaN where there is none.
    pub(crate) fn values(&self) -> Vec<f64> {
        self.costs.iter().map(|cost| cost.as_ref().copied().unwrap_or(f64::NAN)).collect()
    }

    pub(crate) fn n_failed(&self) -> usize {
        self.costs.iter().filter(|cost| cost.is_err()).count()
    }

    fn flown(&self) -> impl Iterator<Item = (usize, f64)> {
        self.costs.iter().enumerate().filter_map(|(cell, cost)| Some((cell, *cost.as_ref().ok()?)))
    }

    /// The cell of the lowest cost, of equals the first.
    pub(crate) fn lowest(&self) -> Result<(usize, f64)> {
        self.flown().min_by(|a, b| a.1.total_cmp(&b.1)).context("no design of the space flies")
    }

    /// Highest less lowest cost.
    pub(crate) fn range(&self) -> f64 {
        let (lowest, highest) = self
            .flown()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (_, cost)| (low.min(cost), high.max(cost)));
        highest - lowest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_comes_back_bit_for_bit() {
        for cost in [Ok(0.1 + 0.2), Ok(1e-300), Err("a line\twent\nslack".to_owned())] {
            let written = line(17, &cost);
            let (cell, read) = read_line(written.trim_end()).expect("a line");
            assert_eq!(cell, 17);
            match (cost, read) {
                (Ok(cost), Ok(read)) => assert_eq!(cost.to_bits(), read.to_bits()),
                (_, read) => assert_eq!(read, Err("a line went slack".to_owned())),
            }
        }
    }

    #[test]
    fn a_torn_line_is_cut_off_and_flown_again() {
        let path = std::env::temp_dir().join(format!("xtask-{}-torn.tsv", std::process::id()));
        fs::write(&path, "0\t1.5\n1\tnonsense\n2\tNaN\n9\t1\n3\t2.").expect("a writable directory");
        let mut costs = vec![None; 4];
        let mut file = open(&path, &mut costs).expect("an openable file");
        assert_eq!(costs, [Some(Ok(1.5)), None, None, None]);
        file.write_all(line(3, &Ok(2.25)).as_bytes()).expect("a writable file");
        drop(file);
        let text = fs::read_to_string(&path).expect("just written");
        fs::remove_file(&path).expect("just written");
        assert_eq!(text, "0\t1.5\n1\tnonsense\n2\tNaN\n9\t1\n3\t2.25\n");
    }
}
