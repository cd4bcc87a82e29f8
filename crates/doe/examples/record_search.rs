//! Searches a G-optimal design for the full quadratic model on the cube and keeps it if it is the best so far.
//!
//! `record_search K N seconds seed [directory]` writes `k<K>_n<N>.csv` with the coded runs and a line of
//! `manifest.csv`: efficiency over the cube, and the settings that repeat the search.

use std::collections::BTreeMap;
use std::error::Error;
use std::fs;
use std::io::{Write as _, stdout};
use std::path::Path;
use std::time::Duration;

use doe::{Criterion, Design, Found, Model, Problem, Settings, Space, search};

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
        Some(directory) => keep(Path::new(directory), (k, n), &found, settings.seed),
        None => Ok(()),
    }
}

/// Writes design and manifest unless a better design is there.
fn keep(directory: &Path, (k, n): (u32, u32), found: &Found, seed: u64) -> Result<(), Box<dyn Error>> {
    let manifest = directory.join("manifest.csv");
    let old = fs::read_to_string(&manifest).unwrap_or_default();
    let mut lines = BTreeMap::new();
    for line in old.lines().skip(1) {
        let fields: Vec<&str> = line.split(',').collect();
        if let [a, b, _, percent, ..] = fields[..] {
            lines.insert((a.parse::<u32>()?, b.parse::<u32>()?), (percent.parse::<f64>()?, line.to_owned()));
        }
    }
    let percent = found.efficiency.percent;
    if lines.get(&(k, n)).is_some_and(|kept| kept.0 >= percent) {
        return Ok(());
    }
    let report = &found.report;
    let line = format!("{k},{n},quadratic,{percent:.6},{seed},{},{}", report.starts, report.best_start);
    lines.insert((k, n), (percent, line));
    let text: Vec<&str> = std::iter::once(HEADER).chain(lines.values().map(|(_, line)| line.as_str())).collect();
    fs::write(directory.join(format!("k{k}_n{n}.csv")), csv(&found.design))?;
    fs::write(manifest, text.join("\n") + "\n")?;
    Ok(())
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
