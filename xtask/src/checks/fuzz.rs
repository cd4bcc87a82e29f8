//! `cargo xtask fuzz`: readers of files fed with files that were changed at random, guided by what of the program they reach.
//!
//! The programs are those that users run, compiled with counters by `cargo afl`. What reached something new is kept in
//! `fixtures/fuzz`, and `cargo xtask ci` feeds it to the programs again.

use std::collections::hash_map::DefaultHasher;
use std::fs;
use std::hash::{Hash as _, Hasher as _};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result, bail, ensure};

use crate::workspace::{self, cargo, root, run_quietly, target_directory};

/// A program that reads a file.
#[derive(Debug, Clone, Copy)]
struct Reader {
    name: &'static str,
    package: &'static str,
    program: Program,
    /// The file, in a folder of its own.
    file: &'static str,
    /// `FOLDER` and `ROOT` are replaced.
    arguments: &'static [&'static str],
    /// Files to begin with, from the root.
    seeds: &'static [&'static str],
    folder: Folder,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Program {
    Binary(&'static str),
    Example(&'static str),
}

/// What stands in the folder besides.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Folder {
    Empty,
    /// A campaign that has asked for its first batch.
    Campaign,
    /// Rig, test and cost of the turbine.
    Turbine,
}

const INFUSE: Program = Program::Binary("infuse");

const READERS: [Reader; 8] = [
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
        file: "journal.jsonl",
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

/// What was measured before the campaign that `infuse new` makes.
const EARLIER: &str = "spring [N/mm],damper gain [N s/mm],vibration [mm/s],note\n20,1.1,5.5,\n22.0,0.9,6.25,at noon\n";
/// With this a program of Rust ends after a panic.
const PANIC: i32 = 101;
/// A program that takes longer over a file hangs.
const PATIENCE: Duration = Duration::from_secs(20);
/// Longer files are not kept.
const MOST_BYTES: u64 = 16_384;
/// Counters of the largest program; the fuzzer cannot ask a program behind a shell how many it has.
const MAP_SIZE: &str = "8388608";
/// So many files are kept for each reader.
const MOST_FILES: usize = 40;

/// Changes files of one reader for so many minutes, and keeps what reached something new.
pub(crate) fn run(name: &str, minutes: &str) -> Result<()> {
    let reader = READERS.iter().find(|reader| reader.name == name);
    let names = || READERS.map(|reader| reader.name).join(", ");
    let reader = reader.with_context(|| format!("no reader `{name}`, expected one of {}", names()))?;
    let minutes: u32 = minutes.parse().ok().filter(|minutes| *minutes > 0).context("minutes: expected 1 or more")?;
    if !cargo(&["afl", "--version"])?.output().is_ok_and(|output| output.status.success()) {
        bail!("`cargo install cargo-afl --locked && cargo afl config --build` gets what is needed");
    }
    let target = target_directory()?.join("fuzz");
    let program = reader.built(&target, "afl")?;
    let place = target.join("runs").join(reader.name);
    if place.exists() {
        fs::remove_dir_all(&place).with_context(|| place.display().to_string())?;
    }
    let (folder, seeds, found) = (place.join("folder"), place.join("seeds"), place.join("found"));
    fs::create_dir_all(&seeds).with_context(|| seeds.display().to_string())?;
    reader.prepare(&folder, &program)?;
    for (number, seed) in reader.seeds(&folder)?.iter().enumerate() {
        fs::copy(seed, seeds.join(number.to_string())).with_context(|| seed.display().to_string())?;
    }
    fuzz(reader, &program, [&folder, &seeds, &found], minutes)?;
    keep(reader, &found.join("default/queue"))?;
    let hangs = reader.hangs(&target, &found.join("default/hangs"))?;
    tell(reader, &found.join("default"), &hangs)
}

fn fuzz(reader: &Reader, program: &Path, [folder, seeds, found]: [&Path; 3], minutes: u32) -> Result<()> {
    let mut command = cargo(&["afl", "fuzz", "-t", "2000", "-m", "2000"])?;
    command.arg("-i").arg(seeds).arg("-o").arg(found).arg("-f").arg(folder.join(reader.file));
    command.arg("-V").arg((60 * minutes).to_string()).arg("--");
    // What a sheet tells is not to be written down, so that each one is told the same campaign: files may not grow beyond the
    // length that the journal has.
    let journal = folder.join("journal.jsonl");
    if reader.folder == Folder::Campaign && reader.file != "journal.jsonl" {
        let length = fs::metadata(&journal).with_context(|| journal.display().to_string())?.len();
        let script = format!("trap '' XFSZ; ulimit -f {}; exec \"$0\" \"$@\"", length / 512);
        command.args(["/bin/sh", "-c", &script]).env("AFL_SKIP_BIN_CHECK", "1").env("AFL_MAP_SIZE", MAP_SIZE);
    }
    command.arg(program).args(reader.arguments(folder)?);
    let settings = ["AFL_NO_UI", "AFL_SKIP_CPUFREQ", "AFL_NO_AFFINITY", "AFL_I_DONT_CARE_ABOUT_MISSING_CRASHES"];
    command.envs(settings.map(|name| (name, "1"))).env("AFL_CRASH_EXITCODE", PANIC.to_string());
    run_quietly(command.current_dir(folder))
}

/// What the run has found, as the fuzzer counts it.
fn tell(reader: &Reader, found: &Path, hangs: &[PathBuf]) -> Result<()> {
    let stats = found.join("fuzzer_stats");
    let text = fs::read_to_string(&stats).with_context(|| stats.display().to_string())?;
    let number = |name: &str| {
        let line = text.lines().find_map(|line| line.split_once(':').filter(|(key, _)| key.trim() == name));
        line.map_or("?", |(_, value)| value.trim())
    };
    println!(
        "{}: {} files in {} s, {} of them reached something new; {} panics, {} hangs",
        reader.name,
        number("execs_done"),
        number("run_time"),
        number("corpus_count"),
        number("saved_crashes"),
        hangs.len()
    );
    let is_clean = number("saved_crashes") == "0" && hangs.is_empty();
    ensure!(is_clean, "what made them is under {}: {hangs:?}", found.display());
    Ok(())
}

/// Keeps the smallest of the files that reached something new, beside those of earlier runs.
fn keep(reader: &Reader, queue: &Path) -> Result<()> {
    let kept = root()?.join("fixtures/fuzz").join(reader.name);
    fs::create_dir_all(&kept).with_context(|| kept.display().to_string())?;
    let mut files: Vec<(u64, PathBuf)> = Vec::new();
    for file in files_in(queue)? {
        let length = fs::metadata(&file).with_context(|| file.display().to_string())?.len();
        if (1..=MOST_BYTES).contains(&length) {
            files.push((length, file));
        }
    }
    // Early ones and late ones: each reached what none before it had.
    files.sort_by(|(_, a), (_, b)| a.cmp(b));
    let room = MOST_FILES.saturating_sub(files_in(&kept)?.len());
    let step = files.len().div_ceil(room.max(1)).max(1);
    for (_, file) in files.iter().step_by(step).take(room) {
        let bytes = fs::read(file).with_context(|| file.display().to_string())?;
        let mut hasher = DefaultHasher::new();
        bytes.hash(&mut hasher);
        fs::write(kept.join(format!("{:016x}", hasher.finish())), bytes).context("fixtures/fuzz")?;
    }
    Ok(())
}

fn files_in(folder: &Path) -> Result<Vec<PathBuf>> {
    let entries = fs::read_dir(folder).with_context(|| folder.display().to_string())?;
    let mut files = Vec::new();
    for entry in entries {
        let path = entry.with_context(|| folder.display().to_string())?.path();
        if path.is_file() {
            files.push(path);
        }
    }
    files.sort();
    Ok(files)
}

impl Reader {
    /// Builds the program in a folder of its own, by a subcommand of cargo that builds.
    fn built(&self, target: &Path, by: &str) -> Result<PathBuf> {
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

    fn arguments(&self, folder: &Path) -> Result<Vec<String>> {
        let (folder, root) = (folder.display().to_string(), root()?.display().to_string());
        Ok(self.arguments.iter().map(|word| word.replace("FOLDER", &folder).replace("ROOT", &root)).collect())
    }

    /// Everything that the program wants to find in the folder but its file, which may be there too.
    fn prepare(&self, folder: &Path, program: &Path) -> Result<()> {
        match self.folder {
            Folder::Empty => fs::create_dir_all(folder).with_context(|| folder.display().to_string()),
            Folder::Turbine => {
                fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
                for file in ["rig.toml", "test-profile.toml", "cost-chapter7.toml"] {
                    fs::copy(root()?.join("fixtures/bat").join(file), folder.join(file)).context(file)?;
                }
                Ok(())
            }
            Folder::Campaign => {
                if let Some(parent) = folder.parent() {
                    fs::create_dir_all(parent).with_context(|| parent.display().to_string())?;
                }
                run_quietly(Command::new(program).arg("new").arg(folder))?;
                run_quietly(Command::new(program).arg("-C").arg(folder).arg("ask"))?;
                fs::write(folder.join("earlier.csv"), EARLIER).context("earlier.csv")
            }
        }
    }

    /// The file as the folder has it, those of the project, and those of earlier runs.
    fn seeds(&self, folder: &Path) -> Result<Vec<PathBuf>> {
        let root = root()?;
        let own = Some(folder.join(self.file)).filter(|file| file.is_file());
        let mut seeds: Vec<PathBuf> = own.into_iter().chain(self.seeds.iter().map(|seed| root.join(seed))).collect();
        let kept = root.join("fixtures/fuzz").join(self.name);
        if kept.is_dir() {
            seeds.extend(files_in(&kept)?);
        }
        Ok(seeds)
    }

    /// Of the files that took the fuzzer's patience those that take ours, too: the machine may have been busy.
    fn hangs(&self, target: &Path, found: &Path) -> Result<Vec<PathBuf>> {
        let suspects = if found.is_dir() { files_in(found)? } else { Vec::new() };
        Ok(self.feed(target, &suspects)?.into_iter().map(|(file, _)| file).collect())
    }

    /// Feeds every kept file to the program as it is built.
    fn replay(&self, target: &Path) -> Result<()> {
        let kept = root()?.join("fixtures/fuzz").join(self.name);
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

/// Feeds all kept files to the programs as they are built.
pub(crate) fn replay() -> Result<()> {
    workspace::build_programs()?;
    let target = target_directory()?;
    std::thread::scope(|scope| {
        let halves = READERS.chunks(READERS.len().div_ceil(2));
        let threads: Vec<_> = halves
            .map(|readers| {
                let target = &target;
                scope.spawn(move || readers.iter().try_for_each(|reader| reader.replay(target)))
            })
            .collect();
        let ended = threads.into_iter().map(|thread| thread.join().unwrap_or_else(|_| bail!("a thread panicked")));
        ended.fold(Ok(()), Result::and)
    })
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
            let has_own = reader.folder == Folder::Campaign || !reader.seeds.is_empty();
            assert!(has_own, "{} begins with nothing", reader.name);
        }
    }
}
