//! The programs that read files, what they are given, and whether they end well.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result, bail, ensure};

use super::folders::{self, JOURNAL, files_in};
use crate::workspace::{cargo, root, run_quietly};

/// With this a program of Rust ends after a panic.
pub(super) const PANIC: i32 = 101;
/// A program that takes longer over a file hangs.
const PATIENCE: Duration = Duration::from_secs(20);

/// A program that reads a file.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reader {
    pub(super) name: &'static str,
    package: &'static str,
    program: Program,
    /// The file, in a folder of its own.
    pub(super) file: &'static str,
    /// `FOLDER` and `ROOT` are replaced.
    arguments: &'static [&'static str],
    /// Files to begin with, from the root.
    seeds: &'static [&'static str],
    pub(super) folder: Folder,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Program {
    Binary(&'static str),
    Example(&'static str),
}

/// What stands in the folder besides.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Folder {
    Empty,
    /// A campaign that has asked for its first batch.
    Campaign,
    /// A campaign by this method after its first batch, with earlier experiments and a journal without checksums: whatever its
    /// lines say is taken at its word.
    Told {
        method: &'static str,
    },
    /// Rig, test and cost of the turbine.
    Turbine,
}

const INFUSE: Program = Program::Binary("infuse");

pub(super) const READERS: [Reader; 11] = [
    Reader {
        name: "campaign",
        package: "infuse-cli",
        program: INFUSE,
        file: "campaign.toml",
        arguments: &["-C", "FOLDER", "status"],
        seeds: &["crates/infuse-cli/examples/circuit/campaign.toml"],
        folder: Folder::Campaign,
    },
    Reader {
        name: "journal",
        package: "infuse-cli",
        program: INFUSE,
        file: JOURNAL,
        arguments: &["-C", "FOLDER", "log"],
        seeds: &[],
        folder: Folder::Campaign,
    },
    Reader {
        name: "sheet",
        package: "infuse-cli",
        program: INFUSE,
        file: "sheet-1.csv",
        arguments: &["-C", "FOLDER", "tell", "sheet-1.csv"],
        seeds: &[],
        folder: Folder::Campaign,
    },
    Reader {
        name: "import",
        package: "infuse-cli",
        program: INFUSE,
        file: "earlier.csv",
        arguments: &["-C", "FOLDER", "import", "--source", "a notebook", "earlier.csv"],
        seeds: &[],
        folder: Folder::Campaign,
    },
    Reader {
        name: "workbook",
        package: "infuse-cli",
        program: INFUSE,
        file: "sheet.xlsx",
        arguments: &["-C", "FOLDER", "tell", "sheet.xlsx"],
        seeds: &[],
        folder: Folder::Campaign,
    },
    Reader {
        name: "history",
        package: "infuse-cli",
        program: INFUSE,
        file: JOURNAL,
        arguments: &["-C", "FOLDER", "status"],
        seeds: &[],
        folder: Folder::Told { method: "pooled" },
    },
    Reader {
        name: "history-dissertation",
        package: "infuse-cli",
        program: INFUSE,
        file: JOURNAL,
        arguments: &["-C", "FOLDER", "status"],
        seeds: &[],
        folder: Folder::Told { method: "dissertation" },
    },
    Reader {
        name: "rig",
        package: "water-channel",
        program: Program::Example("design_cost"),
        file: "rig.toml",
        arguments: &["--center-of-mass", "48", "--pitch", "12", "--fixtures", "FOLDER"],
        seeds: &["fixtures/bat/rig.toml"],
        folder: Folder::Turbine,
    },
    Reader {
        name: "units",
        package: "infuse-scaling",
        program: Program::Example("convert_parameter_file"),
        file: "parameters.toml",
        arguments: &["FOLDER/parameters.toml", "L=100", "rho=1.225/1000", "g=1"],
        seeds: &["fixtures/bat/rig.toml", "fixtures/bat/test-profile.toml"],
        folder: Folder::Empty,
    },
    Reader {
        name: "problem",
        package: "infuse-doe",
        program: Program::Example("evaluate_design"),
        file: "problem.toml",
        arguments: &["FOLDER/problem.toml", "ROOT/crates/doe/examples/handmade.csv"],
        seeds: &["crates/doe/examples/rig.toml"],
        folder: Folder::Empty,
    },
    Reader {
        name: "design",
        package: "infuse-doe",
        program: Program::Example("evaluate_design"),
        file: "design.csv",
        arguments: &["ROOT/crates/doe/examples/rig.toml", "FOLDER/design.csv"],
        seeds: &["crates/doe/examples/handmade.csv"],
        folder: Folder::Empty,
    },
];

impl Reader {
    /// Builds the program in a folder of its own, by a subcommand of cargo that builds.
    pub(super) fn built(&self, target: &Path, by: &str) -> Result<PathBuf> {
        let mut command = cargo(&[by, "build", "--release", "--all-features", "--package", self.package])?;
        match self.program {
            Program::Binary(name) => command.args(["--bin", name]),
            Program::Example(name) => command.args(["--example", name]),
        };
        run_quietly(command.env("CARGO_TARGET_DIR", target))?;
        Ok(self.program_in(target))
    }

    fn program_in(&self, target: &Path) -> PathBuf {
        let path = match self.program {
            Program::Binary(name) => target.join("release").join(name),
            Program::Example(name) => target.join("release/examples").join(name),
        };
        path.with_extension(std::env::consts::EXE_EXTENSION)
    }

    pub(super) fn arguments(&self, folder: &Path) -> Result<Vec<String>> {
        let (folder, root) = (folder.display().to_string(), root()?.display().to_string());
        Ok(self.arguments.iter().map(|word| word.replace("FOLDER", &folder).replace("ROOT", &root)).collect())
    }

    /// Everything that the program wants to find in the folder but its file, which may be there too.
    pub(super) fn prepare(&self, folder: &Path, program: &Path) -> Result<()> {
        let parent = folder.parent().unwrap_or(folder);
        fs::create_dir_all(parent).with_context(|| parent.display().to_string())?;
        match self.folder {
            Folder::Empty => fs::create_dir_all(folder).with_context(|| folder.display().to_string()),
            Folder::Turbine => folders::turbine(folder),
            Folder::Campaign => folders::asked(folder, program),
            Folder::Told { method } => folders::told(folder, program, method),
        }
    }

    /// Where files that reached something new are kept.
    pub(super) fn kept(&self) -> Result<PathBuf> {
        Ok(root()?.join("fixtures/fuzz").join(self.name))
    }

    /// The file as the folder has it, those of the project, and those of earlier runs.
    pub(super) fn seeds(&self, folder: &Path) -> Result<Vec<PathBuf>> {
        let root = root()?;
        let own = Some(folder.join(self.file)).filter(|file| file.is_file());
        let mut seeds: Vec<PathBuf> = own.into_iter().chain(self.seeds.iter().map(|seed| root.join(seed))).collect();
        let kept = self.kept()?;
        if kept.is_dir() {
            seeds.extend(files_in(&kept)?);
        }
        Ok(seeds)
    }

    /// Of the files that took the fuzzer's patience those that take ours, too: the machine may have been busy.
    pub(super) fn hangs(&self, target: &Path, found: &Path) -> Result<Vec<PathBuf>> {
        let suspects = if found.is_dir() { files_in(found)? } else { Vec::new() };
        Ok(self.feed(target, &suspects)?.into_iter().map(|(file, _)| file).collect())
    }

    /// Feeds every kept file to the program as it is built.
    pub(super) fn replay(&self, target: &Path) -> Result<()> {
        let kept = self.kept()?;
        match self.feed(target, &files_in(&kept)?)?.into_iter().next() {
            Some((file, error)) => Err(error.context(format!("with {}", file.display()))),
            None => Ok(()),
        }
    }

    /// Feeds files to the program; those with which it does not end well, and how.
    fn feed(&self, target: &Path, files: &[PathBuf]) -> Result<Vec<(PathBuf, anyhow::Error)>> {
        let place = tempfile::tempdir().context("a folder for a while")?;
        let (folder, program) = (place.path().join("folder"), self.program_in(target));
        self.prepare(&folder, &program)?;
        let before = files_in(&folder)?.into_iter().map(|file| Ok((file.clone(), fs::read(&file)?)));
        let before: Vec<(PathBuf, Vec<u8>)> = before.collect::<std::io::Result<_>>().context("the folder")?;
        let mut faults = Vec::new();
        for file in files {
            for (place, bytes) in &before {
                fs::write(place, bytes).with_context(|| place.display().to_string())?;
            }
            fs::copy(file, folder.join(self.file)).with_context(|| file.display().to_string())?;
            let mut command = Command::new(&program);
            command.args(self.arguments(&folder)?).current_dir(&folder);
            if let Err(error) = ends_well(&mut command) {
                faults.push((file.clone(), error));
            }
        }
        Ok(faults)
    }
}

/// Runs a program that may refuse its file but must neither panic nor go on forever.
fn ends_well(command: &mut Command) -> Result<()> {
    let start = Instant::now();
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().context("cannot start the program")?;
    loop {
        match child.try_wait().context("the program")? {
            Some(status) => {
                ensure!(status.code().is_some_and(|code| code != PANIC), "it ended with {status}");
                return Ok(());
            }
            None if start.elapsed() > PATIENCE => {
                child.kill().context("the program")?;
                child.wait().context("the program")?;
                bail!("it did not end within {PATIENCE:?}");
            }
            None => std::thread::sleep(Duration::from_millis(2)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_and_a_program_that_goes_on_are_noticed() {
        let shell = |script: &str| ends_well(Command::new("sh").args(["-c", script]));
        assert!(shell("exit 0").is_ok() && shell("exit 1").is_ok(), "a refusal is right");
        assert!(shell("exit 101").is_err(), "a panic is not");
        assert!(shell("kill -9 $$").is_err(), "nor is a signal");
    }

    #[test]
    fn readers_have_names_of_their_own_and_files_to_begin_with() {
        let mut names = READERS.map(|reader| reader.name);
        names.sort_unstable();
        assert!(names.windows(2).all(|pair| pair[0] != pair[1]), "{names:?}");
        for reader in READERS {
            let is_made = match reader.folder {
                Folder::Campaign => reader.file != "sheet.xlsx",
                Folder::Told { .. } => true,
                Folder::Empty | Folder::Turbine => false,
            };
            let is_kept = reader.kept().is_ok_and(|kept| files_in(&kept).is_ok_and(|files| !files.is_empty()));
            assert!(is_made || is_kept || !reader.seeds.is_empty(), "{} begins with nothing", reader.name);
        }
    }
}
