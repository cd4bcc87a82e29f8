//! The packages as a registry would get them: packed, resolved and compiled without one.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Command;

use anyhow::{Context as _, Result, ensure};
use serde::Deserialize;
use sha2::{Digest as _, Sha256};
use toml::{Table, Value};

use crate::compiler::{self, Task};
use crate::workspace::{self, Metadata, metadata, run_cargo, run_quietly};

/// What packages are compiled with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Features {
    /// What those that are published ask of others' packages together: as their users have them.
    OfThePublished,
    /// What the workspace and its tests ask: others' packages are there, as they were compiled for programs and tests.
    OfTheWorkspace,
}

/// Packs every crate, and compiles it from what was packed.
///
/// Cargo's own verification unpacks into cargo's home under a name that holds the version but not the content, and finds
/// there what an earlier run has left. So it is done here: the packages are the members of a workspace of their own, in
/// which they find each other, and nothing needs to be published. All else was fetched by the steps before, and
/// `--offline` keeps cargo from asking the registry for news.
pub(crate) fn check(features: Features) -> Result<()> {
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
        // With today's time: in an archive all files are of one day, and the compiler would take what it made of others.
        run_quietly(Command::new("tar").arg("-xzmf").arg(archive).arg("-C").arg(&unpacked))?;
    }
    let lock = "Cargo.lock";
    let root = workspace::root()?;
    let own = fs::read_to_string(root.join(lock)).context(lock)?;
    check_locks(&folder, &unpacked, &packed, &own)?;
    let manifest = unpacked.join("Cargo.toml");
    let root = fs::read_to_string(root.join("Cargo.toml")).context("Cargo.toml")?;
    let root: Table = toml::from_str(&root).context("Cargo.toml")?;
    let askers = if features == Features::OfTheWorkspace { askers(&metadata, &root)? } else { Vec::new() };
    askers.iter().try_for_each(|asker| asker.write(&unpacked))?;
    let text = toml::to_string(&workspace_of(&packed, &askers, &root)?)?;
    fs::write(&manifest, text).with_context(|| manifest.display().to_string())?;
    fs::write(unpacked.join(lock), own).context(lock)?;
    let compile = if features == Features::OfTheWorkspace { "build" } else { "check" };
    let mut cargo = workspace::cargo(&[compile, "--release", "--workspace", "--offline"])?;
    cargo.env_remove(workspace::COMPILED_BY).current_dir(&unpacked).arg("--target-dir").arg(&metadata.target_directory);
    // That they compile is all that is asked of them.
    match workspace::compiler() {
        Some(compiler) => run_quietly(compiler::for_task(&mut cargo, compiler, Task::Types)),
        None => run_quietly(&mut cargo),
    }
}

/// A workspace of these members, packed ones each in the folder of its own name, with the profiles of the workspace itself, so that
/// what was compiled with them is used again.
fn workspace_of(packed: &[(&str, String)], askers: &[Asker], root: &Table) -> Result<Table> {
    let members = packed.iter().map(|(_, stem)| stem).chain(askers.iter().map(|asker| &asker.name));
    let members = members.map(|member| Value::String(member.clone())).collect();
    let patch = |(name, stem): &(&str, String)| ((*name).to_owned(), Value::Table(of("path", stem.clone())));
    let dependencies = elsewhere(table(table(root, "workspace")?, "dependencies")?);
    let workspace = Table::from_iter([
        ("resolver".to_owned(), "3".into()),
        ("members".to_owned(), Value::Array(members)),
        ("dependencies".to_owned(), Value::Table(dependencies)),
    ]);
    let mut manifest = of("workspace", workspace);
    manifest.extend(of("patch", of("crates-io", packed.iter().map(patch).collect::<Table>())));
    manifest.extend(of("profile", table(root, "profile")?.clone()));
    Ok(manifest)
}

/// An empty package that asks of others' packages what one of ours asks, or its tests. What is compiled of a package depends on what
/// all ask of it together: without the tests and the programs that are not published it would be less, and compiled once more.
#[derive(Debug, PartialEq)]
struct Asker {
    name: String,
    manifest: Table,
}

impl Asker {
    /// For what a package of this manifest asks under this key; nothing if that is nothing.
    fn of(package: &str, manifest: &Table, key: &str, root: &Table) -> Result<Option<Self>> {
        let Some(asked) = manifest.get(key).and_then(Value::as_table) else { return Ok(None) };
        let in_workspace = table(table(root, "workspace")?, "dependencies")?;
        let mut asked = elsewhere(asked);
        asked.retain(|name, _| !in_workspace.get(name).is_some_and(is_own));
        asked.iter_mut().filter_map(|(_, asked)| asked.as_table_mut()).for_each(|asked| {
            asked.remove("optional");
        });
        let name = format!("{key}-of-{package}");
        let head = [("name", name.as_str()), ("version", "0.0.0"), ("edition", "2024")];
        let head: Table = head.map(|(key, value)| (key.to_owned(), value.into())).into_iter().collect();
        let mut manifest = of("package", head);
        manifest.extend(of("dependencies", asked));
        Ok(Some(Self { name, manifest }))
    }

    fn write(&self, unpacked: &Path) -> Result<()> {
        let folder = unpacked.join(&self.name);
        let words = || folder.display().to_string();
        fs::create_dir_all(folder.join("src")).with_context(words)?;
        fs::write(folder.join("src/lib.rs"), "").with_context(words)?;
        fs::write(folder.join("Cargo.toml"), toml::to_string(&self.manifest)?).with_context(words)
    }
}

/// One for each package that is built here and for its tests.
fn askers(metadata: &Metadata, root: &Table) -> Result<Vec<Asker>> {
    let is_built = |name: &str| name != workspace::PYTHON_PACKAGE || workspace::interpreter().is_some();
    let mut askers = Vec::new();
    for package in metadata.packages.iter().filter(|package| is_built(&package.name)) {
        let text = fs::read_to_string(&package.manifest_path).with_context(|| package.name.clone())?;
        let manifest: Table = toml::from_str(&text).with_context(|| package.name.clone())?;
        for key in ["dependencies", "dev-dependencies"] {
            askers.extend(Asker::of(&package.name, &manifest, key, root)?);
        }
    }
    Ok(askers)
}

fn table<'a>(table: &'a Table, name: &str) -> Result<&'a Table> {
    table.get(name).and_then(Value::as_table).with_context(|| format!("Cargo.toml: no table `{name}`"))
}

/// A table of one entry.
fn of(name: &str, value: impl Into<Value>) -> Table {
    Table::from_iter([(name.to_owned(), value.into())])
}

/// Whether it lies in the workspace.
fn is_own(asked: &Value) -> bool {
    asked.get("path").is_some()
}

/// Of a table of dependencies those that lie elsewhere.
fn elsewhere(dependencies: &Table) -> Table {
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

    fn parsed(text: &str) -> Table {
        toml::from_str(text).expect("a table")
    }

    const ROOT: &str = r#"
        [workspace.dependencies]
        doe = { package = "infuse-doe", path = "crates/doe" }
        csv = "1.4"
        rand = { version = "0.10", default-features = false }
        [profile.release]
        lto = "off"
        [profile.release.package]
        csv = { opt-level = 0 }"#;

    #[test]
    fn an_asker_asks_all_of_others_and_nothing_of_ours() {
        let manifest = parsed(
            "[dependencies]\ndoe.workspace = true\ncsv.workspace = true\n\
             rand = { workspace = true, features = [\"std\"], optional = true }\nown = { path = \"../own\" }\n",
        );
        let asker = Asker::of("studies", &manifest, "dependencies", &parsed(ROOT)).expect("tables").expect("it asks");
        let expected = "[package]\nname = \"dependencies-of-studies\"\nversion = \"0.0.0\"\nedition = \"2024\"\n\
                        [dependencies]\ncsv.workspace = true\nrand = { workspace = true, features = [\"std\"] }\n";
        assert_eq!(asker.manifest, parsed(expected));
        assert_eq!(Asker::of("studies", &manifest, "dev-dependencies", &parsed(ROOT)).expect("tables"), None);
    }

    #[test]
    fn the_packed_workspace_has_the_profiles_and_versions_of_ours() {
        let packed = [("infuse-doe", "infuse-doe-0.1.0".to_owned())];
        let asker = Asker { name: "dependencies-of-studies".to_owned(), manifest: Table::new() };
        let found = workspace_of(&packed, &[asker], &parsed(ROOT)).expect("tables");
        let expected = r#"
            [workspace]
            resolver = "3"
            members = ["infuse-doe-0.1.0", "dependencies-of-studies"]
            [workspace.dependencies]
            csv = "1.4"
            rand = { version = "0.10", default-features = false }
            [patch.crates-io]
            infuse-doe = { path = "infuse-doe-0.1.0" }
            [profile.release]
            lto = "off"
            [profile.release.package]
            csv = { opt-level = 0 }"#;
        assert_eq!(found, parsed(expected));
    }

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
