//! `cargo xtask tutorials`: the tutorials on campaigns, executed as a reader would, their outputs compared or written.

mod document;
mod shell;

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::{Context as _, Result, bail, ensure};

use crate::workspace;
use document::{Block, End};
use shell::Shell;

/// Tutorials that need what this workspace does not have, executed by hand, and by which program.
const BY_HAND: [(&str, &str); 1] = [("tutorial-campaign-circuit.md", "ngspice")];

/// For each block.
const TIME_LIMIT: Duration = Duration::from_secs(300);

/// What becomes of a printed text that the tutorial does not have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Texts {
    Compare,
    Write,
}

/// Runs every tutorial and says so.
pub(crate) fn run(texts: Texts) -> Result<()> {
    for (name, n_blocks) in run_all(texts)? {
        println!("{name}: {n_blocks} blocks as they are written down");
    }
    for (name, program) in BY_HAND {
        println!("docs/{name}: not executed here, it needs {program}");
    }
    Ok(())
}

/// Runs every tutorial, quietly.
pub(crate) fn check() -> Result<()> {
    run_all(Texts::Compare).map(|_| ())
}

fn run_all(texts: Texts) -> Result<Vec<(String, usize)>> {
    let root = workspace::root()?;
    let paths = tutorials(&root.join("docs"))?;
    let programs = search_path(&build()?)?;
    let mut done = Vec::new();
    let mut complaints = Vec::new();
    for path in paths {
        let name = path.strip_prefix(&root).unwrap_or(&path).display().to_string();
        let text = fs::read_to_string(&path).with_context(|| name.clone())?;
        let played = play(&text, &programs, TIME_LIMIT).with_context(|| name.clone())?;
        if texts == Texts::Write {
            fs::write(&path, played.text).with_context(|| name.clone())?;
        } else {
            complaints.extend(played.differences.iter().map(|difference| format!("{name}, {difference}")));
        }
        done.push((name, played.n_blocks));
    }
    if complaints.is_empty() {
        return Ok(done);
    }
    bail!("{}\n`cargo xtask tutorials --write` puts down what was printed", complaints.join("\n"))
}

/// A check of no tutorial would never fail.
fn tutorials(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut paths = Vec::new();
    for entry in fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let path = entry.with_context(|| folder.display().to_string())?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let is_by_hand = BY_HAND.iter().any(|(by_hand, _)| *by_hand == name);
        if name.starts_with("tutorial-campaign-") && name.ends_with(".md") && !is_by_hand {
            paths.push(path);
        }
    }
    ensure!(!paths.is_empty(), "{}: no tutorial-campaign-*.md", folder.display());
    paths.sort();
    Ok(paths)
}

/// The programs that tutorials call; the folders that hold them.
fn build() -> Result<[PathBuf; 2]> {
    workspace::build_programs()?;
    let release = workspace::target_directory()?.join("release");
    Ok([release.clone(), release.join("examples")])
}

/// `PATH` with the programs of this workspace before all others.
fn search_path(folders: &[PathBuf]) -> Result<OsString> {
    let present = std::env::var_os("PATH").unwrap_or_default();
    let paths = folders.iter().cloned().chain(std::env::split_paths(&present));
    std::env::join_paths(paths).context("PATH")
}

/// A tutorial that was executed.
struct Played {
    /// With the printed texts put in.
    text: String,
    /// Block by block, where a printed text is another one.
    differences: Vec<String>,
    n_blocks: usize,
}

/// Executes the blocks of a tutorial in a fresh folder.
///
/// # Errors
/// What is no tutorial, and the first block that does not end as it should: those after it would build on it.
fn play(text: &str, search_path: &OsString, time_limit: Duration) -> Result<Played> {
    let blocks = document::blocks(text)?;
    ensure!(!blocks.is_empty(), "no block to run");
    let mut shell = Shell::new(search_path, time_limit)?;
    let mut printed = Vec::new();
    let mut differences = Vec::new();
    for (number, block) in blocks.iter().enumerate() {
        let place = format!("line {}, block {}", block.line, number + 1);
        let output = run_block(&mut shell, block).with_context(|| place.clone())?;
        if let Some(lines) = &block.expected {
            let expected: Vec<&str> = text.lines().collect();
            let difference = difference(&expected[lines.clone()], &output);
            differences.extend(difference.map(|difference| format!("{place}: printed something else\n{difference}")));
            printed.push((lines.clone(), output));
        }
    }
    Ok(Played { text: document::with(text, &printed)?, differences, n_blocks: blocks.len() })
}

/// What a block printed, line by line.
fn run_block(shell: &mut Shell, block: &Block) -> Result<Vec<String>> {
    let done = shell.run(&block.script)?;
    let lines = trimmed(done.printed.lines());
    match (done.code, block.end) {
        (None, _) => bail!("ended by a signal, after\n{}", lines.join("\n")),
        (Some(0), End::Fails) => {
            bail!("ended with exit code 0, but is marked `fails`; it printed\n{}", lines.join("\n"))
        }
        (Some(code), End::Succeeds) if code != 0 => {
            bail!("ended with exit code {code}; it printed\n{}", lines.join("\n"))
        }
        _ => Ok(lines),
    }
}

/// Without the blanks at the ends of lines, and without the empty lines at the end.
fn trimmed<'a>(lines: impl Iterator<Item = &'a str>) -> Vec<String> {
    let mut lines: Vec<String> = lines.map(|line| line.trim_end().to_owned()).collect();
    while lines.last().is_some_and(String::is_empty) {
        lines.pop();
    }
    lines
}

/// The lines between the common beginning and the common end, as written and as printed.
fn difference(written: &[&str], printed: &[String]) -> Option<String> {
    let written = trimmed(written.iter().copied());
    if written == printed {
        return None;
    }
    let same = |(a, b): &(&String, &String)| a == b;
    let before = written.iter().zip(printed).take_while(same).count();
    let (written, printed) = (&written[before..], &printed[before..]);
    let after = written.iter().rev().zip(printed.iter().rev()).take_while(same).count();
    let marked = |sign: &str, lines: &[String]| -> Vec<String> {
        lines[..lines.len() - after].iter().map(|line| format!("  {sign} {line}")).collect()
    };
    Some([marked("-", written), marked("+", printed)].concat().join("\n"))
}

#[cfg(test)]
mod tests;
