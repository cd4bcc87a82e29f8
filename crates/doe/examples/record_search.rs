//! Searches a G-optimal design for the full quadratic model on the cube and keeps it if it is the best so far; the one that
//! is there is polished first.
//!
//! `record_search K N seconds seed [directory]` writes `k<K>_n<N>.csv` with the coded runs and a line of
//! `manifest.csv`: efficiency over the cube, and the settings that repeat the search.

use std::collections::BTreeMap;
use std::error::Error;
use std::fs;
use std::io::{Write as _, stdout};
use std::path::Path;
use std::time::Duration;

use doe::{Criterion, Design, Found, Model, Problem, Settings, Space, polished, search};

const HEADER: &str = "k,n,model,g_percent_over_the_cube,seed,starts,best_start";

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |at: usize, default: u32| arguments.get(at).map_or(Ok(default), |text| text.parse());
    let (k, n, seconds, seed) = (number(0, 2)?, number(1, 7)?, number(2, 2)?, number(3, 1)?);
    let problem = Problem::new(Model::quadratic(k as usize)?, Space::cube(k as usize)?, n as usize, Criterion::G)?;
    let mut settings = Settings::default();
    settings.seed = u64::from(seed);
    settings.starts = u64::MAX;
    settings.time_limit = Some(Duration::from_secs(u64::from(seconds)));
    let found = search(&problem, &settings)?;
    writeln!(stdout(), "K {k} N {n}: {}", found.efficiency)?;
    writeln!(stdout(), "{:?}", found.report)?;
    match arguments.get(4) {
        Some(directory) => {
            polish_kept(Path::new(directory), (k, n), &problem)?;
            keep(Path::new(directory), (k, n), &found, settings.seed)
        }
        None => Ok(()),
    }
}

/// A line of the manifest by its numbers of factors and runs, with its efficiency.
type Lines = BTreeMap<(u32, u32), (f64, String)>;

fn manifest(directory: &Path) -> Result<Lines, Box<dyn Error>> {
    let old = fs::read_to_string(directory.join("manifest.csv")).unwrap_or_default();
    let mut lines = BTreeMap::new();
    for line in old.lines().skip(1) {
        let fields: Vec<&str> = line.split(',').collect();
        if let [a, b, _, percent, ..] = fields[..] {
            lines.insert((a.parse::<u32>()?, b.parse::<u32>()?), (percent.parse::<f64>()?, line.to_owned()));
        }
    }
    Ok(lines)
}

fn write(directory: &Path, (k, n): (u32, u32), lines: &Lines, design: &Design) -> Result<(), Box<dyn Error>> {
    let text: Vec<&str> = std::iter::once(HEADER).chain(lines.values().map(|(_, line)| line.as_str())).collect();
    fs::write(directory.join(format!("k{k}_n{n}.csv")), csv(design))?;
    fs::write(directory.join("manifest.csv"), text.join("\n") + "\n")?;
    Ok(())
}

/// Takes the design that is kept to its local optimum, if a digit of the manifest notices.
fn polish_kept(directory: &Path, (k, n): (u32, u32), problem: &Problem) -> Result<(), Box<dyn Error>> {
    const NOTICED: f64 = 2e-6;
    let mut lines = manifest(directory)?;
    let Some((percent, line)) = lines.get_mut(&(k, n)) else { return Ok(()) };
    let mut reader = csv::Reader::from_path(directory.join(format!("k{k}_n{n}.csv")))?;
    let runs = reader.deserialize().collect::<Result<Vec<Vec<f64>>, _>>()?;
    let design = polished(problem, &Design::from_runs(&runs)?)?;
    let better = problem.criterion().efficiency(problem.model(), problem.space(), &design)?.percent;
    if better <= *percent + NOTICED {
        return Ok(());
    }
    *line = line.replacen(&format!("{percent:.6}"), &format!("{better:.6}"), 1);
    *percent = better;
    write(directory, (k, n), &lines, &design)
}

/// Writes design and manifest unless a better design is there.
fn keep(directory: &Path, (k, n): (u32, u32), found: &Found, seed: u64) -> Result<(), Box<dyn Error>> {
    let mut lines = manifest(directory)?;
    let percent = found.efficiency.percent;
    if lines.get(&(k, n)).is_some_and(|kept| kept.0 >= percent) {
        return Ok(());
    }
    let report = &found.report;
    let line = format!("{k},{n},quadratic,{percent:.6},{seed},{},{}", report.starts, report.best_start);
    lines.insert((k, n), (percent, line));
    write(directory, (k, n), &lines, &found.design)
}

fn csv(design: &Design) -> String {
    let names: Vec<String> = (1..=design.n_factors()).map(|j| format!("x{j}")).collect();
    let mut text = names.join(",") + "\n";
    for run in design.runs() {
        let row: Vec<String> = run.iter().map(|x| format!("{x:?}")).collect();
        text += &(row.join(",") + "\n");
    }
    text
}
