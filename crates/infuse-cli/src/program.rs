//! A command that turns a point into a value.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{Read as _, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};
use std::process::{ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result, bail, ensure};
use design_space::Region;
use process_wrap::std::{ChildWrapper, CommandWrap};
use serde_json::{Map, Value, json};

use crate::left_running::Noted;
use crate::number::{self, plain};
use crate::problem::{Input, Program, said, written};

/// How often a running program is looked at: at first, and at most.
const PAUSES: (Duration, Duration) = (Duration::from_micros(200), Duration::from_millis(20));
/// Of what a failing program says, the end is shown.
const SHOWN: usize = 300;

/// Set when a person wants to stop.
static INTERRUPTED: AtomicBool = AtomicBool::new(false);
/// How many programs run.
static RUNNING: AtomicUsize = AtomicUsize::new(0);

/// What an interrupt does: programs that run are stopped and what they gave is written down. While none runs, and the
/// second time, it ends this process at once, which loses nothing either.
pub(crate) fn interrupt(exit_code: i32) {
    let again = INTERRUPTED.swap(true, Ordering::SeqCst);
    if again || RUNNING.load(Ordering::SeqCst) == 0 {
        std::process::exit(exit_code);
    }
}

/// Whether a person wants to stop.
pub(crate) fn is_interrupted() -> bool {
    INTERRUPTED.load(Ordering::Relaxed)
}

/// Something that has to be told of an interrupt, as long as it lives.
#[derive(Debug)]
pub(crate) struct Running;

impl Running {
    pub(crate) fn new() -> Self {
        RUNNING.fetch_add(1, Ordering::SeqCst);
        Self
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        RUNNING.fetch_sub(1, Ordering::SeqCst);
    }
}

/// What became of a run.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Ran {
    /// With every other number that it gave, by name.
    Value {
        value: f64,
        others: BTreeMap<String, f64>,
        /// Printed as nothing but digits, as schedulers print the number of a job.
        is_plain_and_whole: bool,
    },
    /// The point has no value, and the reason is worth writing down.
    Failed(String),
    /// Stopped from outside: it says nothing about the point.
    Interrupted,
}

impl Program {
    /// Runs the command once in this folder. `run` is the number of the experiment, if it is one.
    ///
    /// # Errors
    ///
    /// The command could not be started at all: no such program, no temporary files.
    pub(crate) fn run(&self, folder: &Path, region: &Region, point: &[f64], run: Option<u64>) -> Result<Ran> {
        let words = self.words(folder, region, point, run);
        let (program, arguments) = (&words[0], &words[1..]);
        // Files and not pipes: whatever a program leaves behind when it is stopped, nobody waits for it.
        let temporary = || tempfile::tempfile().context("a temporary file for the output of a command");
        let (mut output, mut errors) = (temporary()?, temporary()?);
        let input = match self.input {
            Input::Arguments => Stdio::null(),
            Input::Json => Stdio::from(standard_input(&self.input_text(region, point, run))?),
        };
        let mut command = CommandWrap::with_new(program, |_| {});
        let inner = command.command_mut();
        inner.args(arguments).current_dir(folder).stdin(input);
        inner.stdout(output.try_clone().context("output")?).stderr(errors.try_clone().context("output")?);
        #[cfg(unix)]
        command.wrap(process_wrap::std::ProcessGroup::leader());
        #[cfg(windows)]
        command.wrap(process_wrap::std::JobObject);
        let mut child = command.spawn().with_context(|| format!("cannot start `{program}`"))?;
        let (running, noted) = (Running::new(), Noted::new(folder, child.id()));
        let waited = self.wait(child.as_mut());
        drop((running, noted));
        let status = match waited? {
            Waited::Ended(status) => {
                // What it has left behind in its group ends with it.
                let _ = child.start_kill();
                status
            }
            Waited::Interrupted => return Ok(Ran::Interrupted),
            Waited::TooLong => {
                let seconds = plain(self.timeout.as_secs_f64());
                return Ok(Ran::Failed(format!("stopped after {seconds} s, see `timeout_seconds`")));
            }
        };
        let (output, errors) = (tail(&mut output)?, tail(&mut errors)?);
        if is_interrupted() && !status.success() {
            return Ok(Ran::Interrupted);
        }
        Ok(ended(status.success(), &status.to_string(), &output, &errors))
    }

    /// Asks a command that answers with 1 or 0.
    ///
    /// # Errors
    ///
    /// Any other answer, and none.
    pub(crate) fn says_yes(&self, folder: &Path, region: &Region, point: &[f64]) -> Result<bool> {
        const EXPECTED: &str = "expected 1 on its last line if the design can be built, 0 if not";
        match self.run(folder, region, point, None)? {
            Ran::Value { value, .. } => {
                let answers = [0.0, 1.0];
                ensure!(answers.iter().any(|answer| (value - answer).abs() < 1e-12), "it printed {value}, {EXPECTED}");
                Ok(value > 0.5)
            }
            Ran::Failed(reason) => bail!("it failed: {reason}; {EXPECTED}"),
            Ran::Interrupted => bail!("interrupted: ask again to go on"),
        }
    }

    /// The command at a point, word by word; a program named with a folder is looked for from the folder of the campaign.
    pub(crate) fn words(&self, folder: &Path, region: &Region, point: &[f64], run: Option<u64>) -> Vec<String> {
        let mut words: Vec<String> = self.command.iter().map(|word| filled(word, region, point, run)).collect();
        if let Some(program) = words.first_mut() {
            *program = executable(folder, program).display().to_string();
        }
        words
    }

    /// What it finds on its standard input.
    pub(crate) fn input_text(&self, region: &Region, point: &[f64], run: Option<u64>) -> String {
        if self.input == Input::Arguments {
            return String::new();
        }
        let pairs = region.parameters().iter().zip(point);
        let mut object: Map<String, Value> =
            pairs.map(|(parameter, &value)| (parameter.name().to_owned(), said(parameter, value))).collect();
        if let Some(run) = run {
            object.insert("run".to_owned(), json!(run));
        }
        format!("{}\n", Value::Object(object))
    }

    fn wait(&self, child: &mut dyn ChildWrapper) -> Result<Waited> {
        let start = Instant::now();
        let mut pause = PAUSES.0;
        loop {
            if let Some(status) = child.try_wait().context("waiting for a command")? {
                return Ok(Waited::Ended(status));
            }
            let is_interrupted = is_interrupted();
            if is_interrupted || start.elapsed() >= self.timeout {
                // It may have ended by itself in between.
                let _ = child.kill();
                return Ok(if is_interrupted { Waited::Interrupted } else { Waited::TooLong });
            }
            std::thread::sleep(pause);
            pause = (2 * pause).min(PAUSES.1);
        }
    }
}

enum Waited {
    Ended(ExitStatus),
    Interrupted,
    TooLong,
}

/// A program named with a folder is looked for from the folder of the campaign, others where the shell would.
fn executable(folder: &Path, program: &str) -> PathBuf {
    let path = Path::new(program);
    if path.is_relative() && path.components().count() > 1 {
        return std::path::absolute(folder.join(path)).unwrap_or_else(|_| path.to_path_buf());
    }
    path.to_path_buf()
}

fn filled(argument: &str, region: &Region, point: &[f64], run: Option<u64>) -> String {
    let run = run.map_or_else(|| "0".to_owned(), |run| run.to_string());
    let argument = argument.replace("{run}", &run);
    let pairs = region.parameters().iter().zip(point);
    pairs.fold(argument, |argument, (parameter, &value)| {
        argument.replace(&format!("{{{}}}", parameter.name()), &written(parameter, value))
    })
}

fn standard_input(text: &str) -> Result<File> {
    let mut file = tempfile::tempfile().context("a temporary file for the input of a command")?;
    write!(file, "{text}").and_then(|()| file.rewind()).context("input of a command")?;
    Ok(file)
}

/// What became of a command that has ended: its value if it succeeded, or what it said.
pub(crate) fn ended(is_success: bool, status: &str, output: &str, errors: &str) -> Ran {
    if is_success { value_of(output) } else { Ran::Failed(failure(status, errors, output)) }
}

/// Of what a command printed so much is read, from its end.
const MOST_READ: u64 = 1 << 16;

/// The end of a file.
pub(crate) fn tail(file: &mut File) -> Result<String> {
    let mut bytes = Vec::new();
    let n_bytes = file.seek(SeekFrom::End(0)).context("output of a command")?;
    let start = SeekFrom::Start(n_bytes.saturating_sub(MOST_READ));
    file.seek(start).and_then(|_| file.read_to_end(&mut bytes)).context("output of a command")?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// The last line: a number, or an object with the value or the failure.
fn value_of(output: &str) -> Ran {
    let Some(line) = output.lines().map(str::trim).rfind(|line| !line.is_empty()) else {
        return Ran::Failed("it printed nothing, expected a number on its last line".to_owned());
    };
    if let Ok(value) = line.parse::<f64>() {
        return finite(value, BTreeMap::new(), line.bytes().all(|byte| byte.is_ascii_digit()));
    }
    if let Ok(Value::Object(object)) = serde_json::from_str(line) {
        let value = object.get("value").and_then(Value::as_f64);
        let failed = object.get("failed").and_then(Value::as_str);
        match (value, failed) {
            (Some(value), None) => {
                let others = object.iter().filter(|(name, _)| *name != "value");
                // Nothing is nothing; what is no number is kept as none, so that who needs one can say so.
                let others = others.filter(|(_, other)| !other.is_null());
                let others = others.map(|(name, other)| (name.clone(), other.as_f64().unwrap_or(f64::NAN)));
                return finite(value, others.collect(), false);
            }
            (None, Some(reason)) => return Ran::Failed(reason.to_owned()),
            _ => {}
        }
    }
    let expected = "expected a number, {\"value\": 1.5} or {\"failed\": \"why\"}";
    Ran::Failed(format!("its last line is `{}`, {expected}", end_of(line)))
}

fn finite(value: f64, others: BTreeMap<String, f64>, is_plain_and_whole: bool) -> Ran {
    match number::fault(value) {
        None => Ran::Value { value, others, is_plain_and_whole },
        Some(fault) => Ran::Failed(format!("it returned {value:?}, expected {}", fault.of_result())),
    }
}

fn failure(status: &str, errors: &str, output: &str) -> String {
    let said = [errors, output].into_iter().map(str::trim).find(|text| !text.is_empty());
    match said {
        Some(said) => format!("{status}: {}", end_of(said)),
        None => status.to_owned(),
    }
}

/// The last few words, on one line.
fn end_of(text: &str) -> String {
    let words: Vec<&str> = text.split_whitespace().collect();
    let text = words.join(" ");
    let n = text.chars().count();
    if n <= SHOWN { text } else { "...".chars().chain(text.chars().skip(n - SHOWN)).collect() }
}
