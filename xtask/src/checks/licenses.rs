//! `cargo xtask licenses`: what the programs and the Python package contain of others, with the texts that must go with it;
//! and whether all of it compiles with the Rust version that the workspace promises.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use anyhow::{Context as _, Result, bail, ensure};
use serde::Deserialize;

use crate::tutorials::Texts;
use crate::workspace;

const PAGE: &str = "THIRD-PARTY-LICENSES.txt";
/// What is handed to people in compiled form.
const SHIPPED: [&str; 2] = ["infuse-cli", "infuse-python"];
const TEXTS: [&str; 5] = ["LICENSE", "LICENCE", "COPYING", "NOTICE", "UNLICENSE"];

#[derive(Deserialize)]
struct Graph {
    packages: Vec<Package>,
    resolve: Resolve,
}

#[derive(Deserialize)]
struct Package {
    id: String,
    name: String,
    version: String,
    license: Option<String>,
    /// Nothing for a package of the workspace.
    source: Option<String>,
    rust_version: Option<String>,
    manifest_path: String,
}

#[derive(Deserialize)]
struct Resolve {
    nodes: Vec<Node>,
}

#[derive(Deserialize)]
struct Node {
    id: String,
    deps: Vec<Dependency>,
}

#[derive(Deserialize)]
struct Dependency {
    pkg: String,
    dep_kinds: Vec<Kind>,
}

#[derive(Deserialize)]
struct Kind {
    /// Nothing for what ends up in the program.
    kind: Option<String>,
}

/// Writes the page, or compares it with what is there.
pub(crate) fn run(texts: Texts) -> Result<()> {
    let graph = graph()?;
    check_rust_versions(&graph)?;
    let (path, found) = (workspace::root()?.join(PAGE), page(&graph)?);
    if texts == Texts::Write {
        return fs::write(&path, found).context(PAGE);
    }
    let kept = fs::read_to_string(&path).context(PAGE)?;
    ensure!(kept == found, "{PAGE}: not what the lock file says; `cargo xtask licenses --write` writes it");
    Ok(())
}

fn graph() -> Result<Graph> {
    let output = workspace::cargo(&["metadata", "--format-version", "1", "--locked"])?.output().context("cargo")?;
    if !output.status.success() {
        bail!("cargo metadata: {}", String::from_utf8_lossy(&output.stderr));
    }
    serde_json::from_slice(&output.stdout).context("cargo metadata")
}

/// No package asks for a later Rust than the workspace does. Those that say nothing are taken at their word.
fn check_rust_versions(graph: &Graph) -> Result<()> {
    let own = graph.packages.iter().filter(|package| package.source.is_none());
    let promised = own.filter_map(|package| package.rust_version.as_deref()).min_by_key(|version| numbers(version));
    let promised = promised.context("no rust-version in the workspace")?;
    let later =
        |package: &&Package| package.rust_version.as_deref().is_some_and(|one| numbers(one) > numbers(promised));
    let later: Vec<&str> = graph.packages.iter().filter(later).map(|package| package.name.as_str()).collect();
    ensure!(later.is_empty(), "the workspace promises Rust {promised}, which is too old for {}", later.join(", "));
    Ok(())
}

fn numbers(version: &str) -> [u32; 3] {
    let mut parts = version.split('.').map(|part| part.parse().unwrap_or(0));
    std::array::from_fn(|_| parts.next().unwrap_or(0))
}

/// The packages of others in what is shipped, on any machine.
fn shipped(graph: &Graph) -> Vec<&Package> {
    let packages: BTreeMap<&str, &Package> =
        graph.packages.iter().map(|package| (package.id.as_str(), package)).collect();
    let nodes: BTreeMap<&str, &Node> = graph.resolve.nodes.iter().map(|node| (node.id.as_str(), node)).collect();
    let roots = graph.packages.iter().filter(|package| SHIPPED.contains(&&*package.name)).map(|package| &*package.id);
    let (mut open, mut seen): (Vec<&str>, BTreeSet<&str>) = (roots.collect(), BTreeSet::new());
    while let Some(id) = open.pop() {
        if seen.insert(id) {
            let deps = nodes.get(id).into_iter().flat_map(|node| &node.deps);
            let contained = deps.filter(|dependency| dependency.dep_kinds.iter().any(|kind| kind.kind.is_none()));
            open.extend(contained.map(|dependency| dependency.pkg.as_str()));
        }
    }
    let mut found: Vec<&Package> = seen.iter().filter_map(|id| packages.get(id).copied()).collect();
    found.retain(|package| package.source.is_some());
    found.sort_by_key(|package| (&package.name, &package.version));
    found
}

/// A list of the packages, then each text once, under the packages that it belongs to.
fn page(graph: &Graph) -> Result<String> {
    let mut list = String::new();
    let mut texts: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for package in shipped(graph) {
        let Package { name, version, license, .. } = package;
        let license = license.as_deref().with_context(|| format!("{name} has no license"))?;
        list += &format!("{name} {version}: {license}\n");
        for text in texts_of(package, license)? {
            texts.entry(text).or_default().push(name.clone());
        }
    }
    let mut page = format!(
        "What the program `infuse` and the Python package contain of others, on any machine.\n\
         Written by `cargo xtask licenses --write`; where there is a choice and MIT is in it, MIT is chosen.\n\n{list}"
    );
    let mut texts: Vec<(String, Vec<String>)> = texts.into_iter().collect();
    texts.sort_by(|a, b| a.1.cmp(&b.1).then(a.0.cmp(&b.0)));
    for (text, names) in texts {
        page += &format!("\n{}\n{}\n\n{text}\n", "=".repeat(78), names.join(", "));
    }
    Ok(page)
}

/// The texts that come with a package: of several licenses to choose from that of MIT, if it is one.
fn texts_of(package: &Package, license: &str) -> Result<Vec<String>> {
    let folder = Path::new(&package.manifest_path).parent().context("a manifest is in a folder")?;
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let path = entry.with_context(|| folder.display().to_string())?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().to_uppercase();
        if path.is_file() && TEXTS.iter().any(|start| name.starts_with(start)) {
            files.push((name, path));
        }
    }
    files.sort();
    if license.contains("MIT") && !license.contains(" AND ") && files.iter().any(|(name, _)| name.contains("MIT")) {
        files.retain(|(name, _)| name.contains("MIT"));
    }
    let read = |(_, path): &(String, std::path::PathBuf)| {
        let bytes = fs::read(path).with_context(|| path.display().to_string())?;
        let text = String::from_utf8_lossy(&bytes).replace('\r', "");
        let lines: Vec<&str> = text.trim_end().lines().map(str::trim_end).collect();
        Ok(lines.join("\n").trim_start_matches('\n').to_owned())
    };
    files.iter().map(read).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_is_that_of_the_lock_file_and_nothing_needs_a_later_rust() {
        run(Texts::Compare).expect("as it was written");
    }

    #[test]
    fn a_package_that_needs_a_later_rust_is_found() {
        let graph = |version: &str| {
            let package = |name: &str, source: &str, version: &str| {
                format!(
                    r#"{{"id": "{name}", "name": "{name}", "version": "1.0.0", "license": "MIT", "source": {source},
                        "rust_version": "{version}", "manifest_path": "Cargo.toml"}}"#
                )
            };
            let packages = [package("own", "null", "1.89"), package("other", "\"registry\"", version)].join(",");
            let text = format!(r#"{{"packages": [{packages}], "resolve": {{"nodes": []}}}}"#);
            serde_json::from_str::<Graph>(&text).expect("a graph")
        };
        assert!(check_rust_versions(&graph("1.89.0")).is_ok(), "the same");
        let error = check_rust_versions(&graph("1.90")).expect_err("later");
        assert_eq!(error.to_string(), "the workspace promises Rust 1.89, which is too old for other");
    }
}
