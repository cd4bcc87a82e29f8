//! How long the shell takes for each of its calls, over a grid of 331,776 designs whose simulations lie in a table.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Instant;

use anyhow::{Context as _, Result, ensure};

use super::builds::{cargo, remove};
use super::page::{Called, METHODS};

/// In the root; made and removed.
const FOLDER: &str = "target/speed-campaign";
/// Parameters with so many settings each.
const K: usize = 4;
const LEVELS: usize = 24;
/// Experiments of a batch: 90 in the end.
const EXPERIMENTS: usize = 18;
const BATCHES: usize = 5;

/// What is called, and the longest it is meant to take (s): half of what it took when the goals were set.
const CALLS: [(&str, f64); 3] = [("ask", 0.85), ("tell", 0.2), ("status", 0.25)];
/// Batches, for the bar.
pub(super) const COUNT: usize = METHODS.len() * BATCHES;

/// A campaign of five batches with each method; `done` gets each batch.
pub(super) fn measured(root: &Path, mut done: impl FnMut()) -> Result<Vec<Called>> {
    cargo(root, &["build", "--release", "--locked", "--package", "infuse-cli"], None)?;
    // It runs in another folder.
    let root = &std::path::absolute(root)?;
    let program = root.join("target/release").join(format!("infuse{}", std::env::consts::EXE_SUFFIX));
    let mut all = Vec::new();
    for method in METHODS {
        let folder = root.join(FOLDER);
        remove(&folder)?;
        std::fs::create_dir_all(&folder)?;
        write_campaign(&folder, method)?;
        let mut called = CALLS.map(|(call, goal)| Called { call, method, goal, seconds: Vec::new() });
        for batch in 1..=BATCHES {
            let sheet = format!("sheet-{batch}.csv");
            for Called { call, seconds, .. } in &mut called {
                let arguments: &[&str] = if *call == "tell" { &["tell", &sheet] } else { &[*call] };
                seconds.push(timed(&program, &folder, arguments)?);
                if *call == "ask" {
                    fill(&folder.join(&sheet))?;
                }
            }
            done();
        }
        remove(&folder)?;
        all.extend(called);
    }
    Ok(all)
}

fn timed(program: &Path, folder: &Path, arguments: &[&str]) -> Result<f64> {
    let start = Instant::now();
    let mut command = Command::new(program);
    let output =
        command.args(arguments).current_dir(folder).stdin(Stdio::null()).output().context("cannot start infuse")?;
    let seconds = start.elapsed().as_secs_f64();
    let said = String::from_utf8_lossy(&output.stderr);
    ensure!(output.status.success(), "`infuse {}` failed: {said}", arguments.join(" "));
    Ok(seconds)
}

/// A valley whose bottom the simulation has elsewhere.
fn response(settings: &[f64], shift: f64) -> f64 {
    let x: Vec<f64> = settings.iter().map(|setting| setting / (LEVELS - 1) as f64).collect();
    let bowl: f64 = x.iter().enumerate().map(|(j, x)| (1.0 + j as f64) * (x - 0.6 + shift).powi(2)).sum();
    1.0 + bowl + 0.3 * (5.0 * x[0] * x[1] + shift).sin()
}

fn write_campaign(folder: &Path, method: &str) -> Result<()> {
    let parameter = |j: usize| {
        format!("[[parameter]]\nname = \"p{j}\"\nunit = \"mm\"\nlower = 0\nupper = {}\nstep = 1\n\n", LEVELS - 1)
    };
    let parameters: String = (1..=K).map(parameter).collect();
    let text = format!(
        "title = \"A grid\"\n\n{parameters}[response]\nname = \"y\"\nunit = \"N\"\ngoal = \"minimize\"\n\n\
         [simulator]\ntable = \"simulations.csv\"\n\n[loop]\nmethod = \"{method}\"\nexperiments = {EXPERIMENTS}\nbatches = {BATCHES}\n"
    );
    std::fs::write(folder.join("campaign.toml"), text)?;
    let mut table = csv::Writer::from_path(folder.join("simulations.csv"))?;
    table.write_record((1..=K).map(|j| format!("p{j} [mm]")).chain(["y [N]".to_owned()]))?;
    for cell in 0..LEVELS.pow(K as u32) {
        let settings: Vec<f64> = (0..K as u32).map(|j| (cell / LEVELS.pow(j) % LEVELS) as f64).collect();
        let row = settings.iter().copied().chain([response(&settings, 0.1)]);
        table.write_record(row.map(|value| value.to_string()))?;
    }
    Ok(table.flush()?)
}

/// Every experiment of a sheet with its result.
fn fill(sheet: &Path) -> Result<()> {
    let mut read = csv::Reader::from_path(sheet)?;
    let headings = read.headers()?.clone();
    let place = |name: &str| headings.iter().position(|heading| heading == name).with_context(|| name.to_owned());
    let value = place("y [N]")?;
    let parameters = (1..=K).map(|j| place(&format!("p{j} [mm]"))).collect::<Result<Vec<_>>>()?;
    let mut filled = csv::Writer::from_writer(Vec::new());
    filled.write_record(&headings)?;
    for record in read.records() {
        let mut cells: Vec<String> = record?.iter().map(str::to_owned).collect();
        let settings = parameters.iter().map(|&at| Ok(cells[at].parse()?)).collect::<Result<Vec<f64>>>()?;
        cells[value] = response(&settings, 0.0).to_string();
        filled.write_record(&cells)?;
    }
    Ok(std::fs::write(sheet, filled.into_inner()?)?)
}
