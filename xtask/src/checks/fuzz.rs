//! `cargo xtask fuzz`: readers of files fed with files that were changed at random, guided by what of the program they reach.
//!
//! The programs are those that users run, compiled with counters by `cargo afl`. What reached something new is kept in
//! `fixtures/fuzz`, and `cargo xtask ci` feeds it to the programs again.

use std::collections::hash_map::DefaultHasher;
use std::fs;
use std::hash::{Hash as _, Hasher as _};
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, bail, ensure};

use self::folders::{JOURNAL, files_in};
use self::readers::{Folder, PANIC, READERS, Reader};
use crate::workspace::{self, cargo, run_quietly, target_directory};

mod folders;
mod readers;

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
    let journal = folder.join(JOURNAL);
    if reader.folder == Folder::Campaign && reader.file != JOURNAL {
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
    let kept = reader.kept()?;
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
