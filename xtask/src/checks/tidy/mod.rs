//! `cargo xtask tidy`: the rules of the tree that no compiler checks.

mod circles;
mod equations;
mod layers;
mod pages;
mod source;

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, bail};
use toml::{Table, Value};

use crate::workspace;

/// First parts of paths that exist on one machine only.
const MACHINE_DIRECTORIES: &[&str] = &["home", "mnt", "root", "tmp", "Users", "work", "workspace"];

const MAIN_LINES: usize = 100;

/// Checks the tree and says that it is in order.
pub(crate) fn run() -> Result<()> {
    check()?;
    println!("The tree is tidy.");
    Ok(())
}

/// Checks the tree; the error lists every complaint.
pub(crate) fn check() -> Result<()> {
    let complaints = complaints(&workspace::root()?)?;
    if complaints.is_empty() {
        return Ok(());
    }
    bail!("{} complaints\n{}", complaints.len(), complaints.join("\n"))
}

fn complaints(root: &Path) -> Result<Vec<String>> {
    let mut complaints = Vec::new();
    let texts = texts(root)?;
    for (name, text) in &texts {
        complaints.extend(source_complaints(name, text));
        complaints.extend(path_complaints(name, text));
        if name.ends_with(".md") {
            complaints.extend(pages::complaints(name, text));
            complaints.extend(pages::missing_tests(name, text, &texts));
        }
    }
    let names: Vec<&str> = texts.iter().map(|(name, _)| name.as_str()).collect();
    if let Some((name, text)) = texts.iter().find(|(name, _)| name == layers::PAGE) {
        complaints.extend(pages::missing_places(name, text, &names));
    }
    complaints.extend(equation_complaints(&texts));
    complaints.extend(layers::page_complaints(&texts));
    let packages = package_directories(root)?;
    let folders =
        packages.iter().map(|path| path.strip_prefix(root).unwrap_or(path).to_string_lossy().replace('\\', "/"));
    let front = texts.iter().find(|(name, _)| name == pages::FRONT).map_or("", |(_, text)| text);
    complaints.extend(pages::crate_rows(front, &folders.collect::<Vec<_>>()));
    for package in packages {
        let name = package.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let read = |file: &str| fs::read_to_string(package.join(file)).ok();
        let manifest = read("Cargo.toml").with_context(|| format!("{name}: no Cargo.toml"))?;
        let manifest: Table = manifest.parse().with_context(|| format!("{name}/Cargo.toml"))?;
        complaints.extend(layers::complaints(&name, &manifest));
        for program in ["src", "src/checks"].map(|folder| package.join(folder)) {
            if program.is_dir() {
                complaints.extend(circles::complaints(&name, &sources(&program)?));
            }
        }
        if name != "xtask" {
            complaints.extend(crate_complaints(&name, &manifest, read("CHANGELOG.md").as_deref()));
            if read("README.md").is_none_or(|text| text.trim().is_empty()) {
                complaints.push(format!("{name}: no README.md"));
            }
            let is_program = manifest.get("package").is_some_and(|package| package.get("publish").is_some());
            if !is_program && !has_example(&package) {
                complaints.push(format!("{name}: no example"));
            }
        }
    }
    Ok(complaints)
}

/// All texts of the tree, with their names from the root.
fn texts(root: &Path) -> Result<Vec<(String, String)>> {
    let mut texts = Vec::new();
    for path in files_below(root)? {
        let name = path.strip_prefix(root).unwrap_or(&path).to_string_lossy().replace('\\', "/");
        let bytes = fs::read(&path).with_context(|| name.clone())?;
        texts.extend(String::from_utf8(bytes).ok().map(|text| (name, text)));
    }
    Ok(texts)
}

/// Writes the page from equation number to code.
pub(crate) fn write_equations() -> Result<()> {
    let root = workspace::root()?;
    let page = equations::page(&sources_of_crates(&texts(&root)?));
    fs::write(root.join(equations::PAGE), page).context(equations::PAGE)
}

/// Every equation has a home, and the page of them is as the code says.
fn equation_complaints(texts: &[(String, String)]) -> Vec<String> {
    let sources = sources_of_crates(texts);
    let mut complaints = equations::complaints(&sources);
    let kept = texts.iter().find(|(name, _)| name == equations::PAGE).map(|(_, text)| text.as_str());
    if kept != Some(&*equations::page(&sources)) {
        complaints.push(format!("{}: not as the code says; `cargo xtask equations` writes it", equations::PAGE));
    }
    complaints
}

fn sources_of_crates(texts: &[(String, String)]) -> Vec<(String, String)> {
    let is_source = |name: &str| name.starts_with("crates/") && name.contains("/src/") && name.ends_with(".rs");
    texts.iter().filter(|(name, _)| is_source(name)).cloned().collect()
}

/// All files that belong to the tree, in a fixed order.
fn files_below(directory: &Path) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for path in entries(directory)? {
        // In a second work tree `.git` is a file.
        let name = path.file_name().unwrap_or_default();
        if name == "target" || name == ".git" {
            continue;
        }
        if path.is_dir() {
            files.extend(files_below(&path)?);
        } else {
            files.push(path);
        }
    }
    Ok(files)
}

fn package_directories(root: &Path) -> Result<Vec<PathBuf>> {
    let mut packages = entries(&root.join("crates"))?;
    packages.retain(|path| path.is_dir());
    packages.push(root.join("xtask"));
    Ok(packages)
}

/// The names below the folder of a crate's root module and the texts of its sources.
fn sources(folder: &Path) -> Result<Vec<(String, String)>> {
    let mut sources = Vec::new();
    for path in files_below(folder)?.into_iter().filter(|path| path.extension().is_some_and(|end| end == "rs")) {
        let name = path.strip_prefix(folder).unwrap_or(&path).to_string_lossy().replace('\\', "/");
        sources.push((name, fs::read_to_string(&path).with_context(|| path.display().to_string())?));
    }
    Ok(sources)
}

/// A program to run or a campaign to begin.
fn has_example(package: &Path) -> bool {
    let is_example = |path: &PathBuf| {
        path.extension().is_some_and(|end| end == "rs")
            || ["main.rs", "campaign.toml"].iter().any(|name| path.join(name).is_file())
    };
    entries(&package.join("examples")).is_ok_and(|paths| paths.iter().any(is_example))
}

fn entries(directory: &Path) -> Result<Vec<PathBuf>> {
    let mut paths = Vec::new();
    for entry in fs::read_dir(directory).with_context(|| directory.display().to_string())? {
        paths.push(entry.with_context(|| directory.display().to_string())?.path());
    }
    paths.sort();
    Ok(paths)
}

/// Every source file says first what it is; a main function only dispatches.
fn source_complaints(name: &str, text: &str) -> Vec<String> {
    let mut complaints = Vec::new();
    if name.ends_with(".rs") && !text.starts_with("//!") && !text.starts_with("#![doc") {
        complaints.push(format!("{name}: does not start with `//!` or `#![doc`"));
    }
    let lines = text.lines().count();
    if name == "xtask/src/main.rs" && lines >= MAIN_LINES {
        complaints.push(format!("{name}: {lines} lines, but must stay below {MAIN_LINES}"));
    }
    complaints
}

/// No file names a place that only one machine has.
fn path_complaints(name: &str, text: &str) -> Vec<String> {
    text.lines()
        .enumerate()
        .filter(|(_, line)| has_machine_path(line))
        .map(|(number, line)| format!("{name}:{}: a machine's path: {}", number + 1, line.trim()))
        .collect()
}

/// Whether a slash at the start of a word is followed by one of [`MACHINE_DIRECTORIES`].
fn has_machine_path(line: &str) -> bool {
    line.match_indices('/').any(|(at, _)| {
        let starts = line[..at]
            .chars()
            .next_back()
            .is_none_or(|before| !(before.is_alphanumeric() || "/._-*}~)".contains(before)));
        let first = line[at + 1..].split(|c: char| !(c.is_alphanumeric() || "_-".contains(c))).next();
        starts && first.is_some_and(|first| MACHINE_DIRECTORIES.contains(&first))
    })
}

/// Every crate has a version of its own, and a changelog that knows it.
fn crate_complaints(name: &str, manifest: &Table, changelog: Option<&str>) -> Vec<String> {
    let package = manifest.get("package").and_then(Value::as_table);
    let Some(version) = package.and_then(|table| table.get("version")).and_then(Value::as_str) else {
        return vec![format!("{name}: no version of its own")];
    };
    match changelog {
        None => vec![format!("{name}: no CHANGELOG.md")],
        Some(text) if !text.lines().any(|line| is_entry_of(line, version)) => {
            vec![format!("{name}: CHANGELOG.md has no entry for {version}")]
        }
        Some(_) => Vec::new(),
    }
}

fn is_entry_of(line: &str, version: &str) -> bool {
    line.strip_prefix("## ").and_then(|heading| heading.split_whitespace().next()).is_some_and(|first| first == version)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tree_is_tidy() {
        let root = workspace::root().expect("a workspace");
        let complaints = complaints(&root).expect("a readable tree");
        assert!(complaints.is_empty(), "{}", complaints.join("\n"));
    }

    #[test]
    fn source_without_a_first_line_is_found() {
        assert!(source_complaints("a.rs", "//! A.\n").is_empty(), "as it should be");
        assert!(source_complaints("a.rs", "#![doc = \"A\"]\n").is_empty(), "as it should be");
        assert!(source_complaints("a.toml", "x = 1\n").is_empty(), "not a source");
        assert_eq!(source_complaints("a.rs", "fn a() {}\n").len(), 1, "nothing said");
    }

    #[test]
    fn long_main_is_found() {
        let long = format!("//! A.\n{}", "\n".repeat(MAIN_LINES - 1));
        assert_eq!(source_complaints("xtask/src/main.rs", &long).len(), 1, "100 lines");
        assert!(source_complaints("xtask/src/ci.rs", &long).is_empty(), "not a main");
    }

    #[test]
    fn machine_paths_are_found() {
        for directory in MACHINE_DIRECTORIES {
            for line in
                [format!("/{directory}/me/file"), format!("cd /{directory}"), format!("path = \"/{directory}/file\"")]
            {
                assert_eq!(path_complaints("a.md", &line).len(), 1, "{line}");
            }
            for line in [
                format!("https://example.org/{directory}/page"),
                format!("a/{directory}/b"),
                format!("/{directory}like/b"),
                format!("m/{directory}"),
            ] {
                assert!(path_complaints("a.md", &line).is_empty(), "{line}");
            }
        }
    }

    #[test]
    fn examples_are_files_or_folders_with_a_main_file() {
        let folder = tempfile::tempdir().expect("a folder");
        let examples = folder.path().join("examples");
        assert!(!has_example(folder.path()), "no folder");
        fs::create_dir_all(examples.join("one")).expect("a folder");
        fs::write(examples.join("data.csv"), "").expect("a file");
        assert!(!has_example(folder.path()), "nothing to run");
        fs::write(examples.join("one/main.rs"), "").expect("a file");
        assert!(has_example(folder.path()), "a folder");
        fs::remove_dir_all(examples.join("one")).expect("the folder is there");
        fs::write(examples.join("one.rs"), "").expect("a file");
        assert!(has_example(folder.path()), "a file");
    }

    #[test]
    fn crates_without_version_or_changelog_are_found() {
        let check = |manifest: &str, changelog| {
            crate_complaints("a", &manifest.parse().expect("a manifest"), changelog).join("\n")
        };
        let versioned = "[package]\nversion = \"0.2.0\"";
        assert_eq!(check(versioned, Some("## 0.2.0 - unreleased")), "");
        assert_eq!(check(versioned, Some("## 0.1.0")), "a: CHANGELOG.md has no entry for 0.2.0");
        assert_eq!(check(versioned, None), "a: no CHANGELOG.md");
        assert_eq!(check("[package]\nversion.workspace = true", None), "a: no version of its own");
    }
}
