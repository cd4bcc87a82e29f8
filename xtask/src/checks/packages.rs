//! The packages as a registry would get them: packed, resolved and compiled without one.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Command;

use anyhow::{Context as _, Result, ensure};
use serde::Deserialize;
use sha2::{Digest as _, Sha256};
use toml::{Table, Value};

use crate::workspace::{self, Metadata, metadata, run_cargo, run_quietly};

/// Packs every crate, and compiles it from what was packed.
///
/// Cargo's own verification unpacks into cargo's home under a name that holds the version but not the content, and finds
/// there what an earlier run has left. So it is done here: the packages are the members of a workspace of their own, in
/// which they find each other, and nothing needs to be published. All else was fetched by the steps before, and
/// `--offline` keeps cargo from asking the registry for news.
pub(crate) fn check() -> Result<()> {
    run_cargo(&[
        "package",
        "--workspace",
        "--exclude",
        "xtask",
        "--exclude",
        "studies",
        "--exclude",
        workspace::PYTHON_PACKAGE,
        "--allow-dirty",
        "--offline",
        "--no-verify",
    ])?;
    let metadata = metadata()?;
    let folder = metadata.target_directory.join("package");
    let unpacked = folder.join("unpacked");
    if unpacked.exists() {
        fs::remove_dir_all(&unpacked).with_context(|| unpacked.display().to_string())?;
    }
    fs::create_dir_all(&unpacked).with_context(|| unpacked.display().to_string())?;
    let packed = metadata
        .packages
        .iter()
        .filter(|package| !["studies", "xtask", workspace::PYTHON_PACKAGE].contains(&&*package.name));
    let packed: Vec<(&str, String)> =
        packed.map(|package| (&*package.name, format!("{}-{}", package.name, package.version))).collect();
    for (_, stem) in &packed {
        let archive = folder.join(format!("{stem}.crate"));
        run_quietly(Command::new("tar").arg("-xzf").arg(archive).arg("-C").arg(&unpacked))?;
    }
    let lock = "Cargo.lock";
    let root = workspace::root()?;
    let own = fs::read_to_string(root.join(lock)).context(lock)?;
    check_locks(&folder, &unpacked, &packed, &own)?;
    let manifest = unpacked.join("Cargo.toml");
    let root_manifest = fs::read_to_string(root.join("Cargo.toml")).context("Cargo.toml")?;
    let of_others = with_the_same_features(&unpacked, &metadata, &root_manifest)?;
    let text = workspace_of(&packed, &of_others, &root_manifest)?;
    fs::write(&manifest, text).with_context(|| manifest.display().to_string())?;
    fs::write(unpacked.join(lock), own).context(lock)?;
    let arguments = ["check", "--release", "--workspace", "--offline"];
    let mut check = workspace::cargo(&arguments)?;
    run_quietly(check.current_dir(&unpacked).arg("--target-dir").arg(&metadata.target_directory))
}

/// A workspace of these unpacked packages, each in the folder of its own name, with the profiles of the workspace itself,
/// so that what was compiled with them is used again.
fn workspace_of(packed: &[(&str, String)], of_others: &[String], root_manifest: &str) -> Result<String> {
    let members: Vec<&String> = packed.iter().map(|(_, stem)| stem).chain(of_others).collect();
    let patches: Vec<String> = packed.iter().map(|(name, stem)| format!("{name} = {{ path = {stem:?} }}\n")).collect();
    let root: Table = toml::from_str(root_manifest).context("Cargo.toml")?;
    let dependencies = table(&root, "workspace").and_then(|workspace| table(workspace, "dependencies"));
    let dependencies = of_others_only(dependencies.context("no [workspace.dependencies]")?);
    let dependencies = toml::to_string(&within("workspace", within("dependencies", dependencies)))?;
    let profiles = root_manifest.find("[profile.").map_or("", |at| &root_manifest[at..]);
    let members = format!("[workspace]\nresolver = \"3\"\nmembers = {members:?}\n");
    let patches = format!("[patch.crates-io]\n{}", patches.concat());
    Ok(format!("{members}\n{dependencies}\n{patches}\n{profiles}"))
}

/// Empty packages that ask of others' packages what those of the workspace and their tests ask, by their folders: what is compiled
/// depends on what all ask together, and would be compiled once more for fewer.
fn with_the_same_features(unpacked: &Path, metadata: &Metadata, root_manifest: &str) -> Result<Vec<String>> {
    let root: Table = toml::from_str(root_manifest).context("Cargo.toml")?;
    let own = table(&root, "workspace").and_then(|workspace| table(workspace, "dependencies"));
    let own = own.iter().flat_map(|own| own.iter()).filter(|(_, asked)| is_own(asked));
    let own: Vec<&str> = own.map(|(name, _)| name.as_str()).collect();
    let is_built = |name: &str| name != workspace::PYTHON_PACKAGE || workspace::interpreter().is_some();
    let mut folders = Vec::new();
    for package in metadata.packages.iter().filter(|package| is_built(&package.name)) {
        let text = fs::read_to_string(&package.manifest_path).with_context(|| package.name.clone())?;
        let manifest: Table = toml::from_str(&text).with_context(|| package.name.clone())?;
        for kind in ["dependencies", "dev-dependencies"] {
            let Some(asked) = table(&manifest, kind) else { continue };
            let mut asked = of_others_only(asked);
            asked.retain(|name, _| !own.contains(&name));
            asked.iter_mut().filter_map(|(_, asked)| asked.as_table_mut()).for_each(|asked| {
                asked.remove("optional");
            });
            let name = format!("{kind}-of-{}", package.name);
            let head = format!("[package]\nname = \"{name}\"\nversion = \"0.0.0\"\nedition = \"2024\"\n");
            let source = unpacked.join(&name).join("src");
            fs::create_dir_all(&source).with_context(|| source.display().to_string())?;
            fs::write(source.join("lib.rs"), "")?;
            let manifest = format!("{head}\n{}", toml::to_string(&within("dependencies", asked))?);
            fs::write(unpacked.join(&name).join("Cargo.toml"), manifest)?;
            folders.push(name);
        }
    }
    Ok(folders)
}

fn table<'a>(table: &'a Table, name: &str) -> Option<&'a Table> {
    table.get(name)?.as_table()
}

fn within(name: &str, table: Table) -> Table {
    Table::from_iter([(name.to_owned(), Value::Table(table))])
}

/// Whether it lies in the workspace.
fn is_own(asked: &Value) -> bool {
    asked.get("path").is_some()
}

/// Of a table of dependencies those that lie elsewhere.
fn of_others_only(dependencies: &Table) -> Table {
    let others = dependencies.iter().filter(|(_, asked)| !is_own(asked));
    others.map(|(name, asked)| (name.clone(), asked.clone())).collect()
}

/// A lock file, as far as it says which packages were taken.
#[derive(Deserialize)]
struct Lock {
    package: Vec<Locked>,
}

#[derive(Deserialize)]
struct Locked {
    name: String,
    version: String,
    checksum: Option<String>,
}

/// The lock file in each package names our own packages as they were packed just now, and otherwise only what that of the
/// workspace names: nobody's package of the name of one of our libraries.
fn check_locks(folder: &Path, unpacked: &Path, packed: &[(&str, String)], own: &str) -> Result<()> {
    let mut checksums = BTreeMap::new();
    for (name, stem) in packed {
        let archive = folder.join(format!("{stem}.crate"));
        let bytes = fs::read(&archive).with_context(|| archive.display().to_string())?;
        let sum: Vec<String> = Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect();
        checksums.insert((*name).to_owned(), sum.concat());
    }
    let own: Lock = toml::from_str(own).context("Cargo.lock")?;
    for (name, stem) in packed {
        let path = unpacked.join(stem).join("Cargo.lock");
        let text = fs::read_to_string(&path).with_context(|| path.display().to_string())?;
        let lock: Lock = toml::from_str(&text).with_context(|| path.display().to_string())?;
        let strangers = strangers(&lock, &own, &checksums);
        ensure!(
            strangers.is_empty(),
            "the lock file in {name} names packages that are not ours: {}",
            strangers.join(", ")
        );
    }
    Ok(())
}

/// Packages of a lock file that are neither ours, by checksum, nor in the lock file of the workspace.
fn strangers(lock: &Lock, own: &Lock, checksums: &BTreeMap<String, String>) -> Vec<String> {
    let is_known = |locked: &&Locked| match (checksums.get(&locked.name), &locked.checksum) {
        (Some(packed), Some(checksum)) => packed == checksum,
        // The package itself.
        (Some(_), None) => true,
        (None, checksum) => own.package.iter().any(|one| {
            (&one.name, &one.version, &one.checksum) == (&locked.name, &locked.version, checksum) && checksum.is_some()
        }),
    };
    let strange = lock.package.iter().filter(|locked| !is_known(locked));
    strange.map(|locked| format!("{} {}", locked.name, locked.version)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_strangers_package_in_a_lock_file_is_found() {
        let lock = |entries: &[(&str, &str)]| Lock {
            package: entries
                .iter()
                .map(|(name, sum)| Locked {
                    name: (*name).to_owned(),
                    version: "0.1.0".to_owned(),
                    checksum: Some((*sum).to_owned()).filter(|sum| !sum.is_empty()),
                })
                .collect(),
        };
        let own = lock(&[("infuse-doe", ""), ("infuse-cli", ""), ("csv", "c5")]);
        let checksums =
            BTreeMap::from([("infuse-doe".to_owned(), "a1".to_owned()), ("infuse-cli".to_owned(), "b2".to_owned())]);
        let found = |entries| strangers(&lock(entries), &own, &checksums);
        assert!(found(&[("infuse-cli", ""), ("infuse-doe", "a1"), ("csv", "c5")]).is_empty(), "all ours");
        assert_eq!(found(&[("infuse-doe", "ff")]), ["infuse-doe 0.1.0"], "the name, and another's content");
        assert_eq!(found(&[("doe", "d4")]), ["doe 0.1.0"], "a name of a library");
        assert_eq!(found(&[("csv", "00")]), ["csv 0.1.0"], "changed");
    }
}
