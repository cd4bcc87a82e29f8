//! The tasks in Python, by a program that answers line by line.

use std::io::{BufRead as _, BufReader, Write as _};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use anyhow::{Context as _, Result};

/// The program, waiting for the next task.
#[derive(Debug)]
pub(super) struct Theirs {
    program: &'static str,
    child: Child,
    questions: ChildStdin,
    answers: BufReader<ChildStdout>,
    versions: String,
}

impl Theirs {
    /// `needed` is what the program imports, in words.
    pub(super) fn start(root: &Path, program: &'static str, needed: &str) -> Result<Self> {
        let python = std::env::var_os("PYTHON").unwrap_or_else(|| "python3".into());
        let mut command = Command::new(&python);
        command.arg(root.join(program)).stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut child = command.spawn().with_context(|| format!("cannot start {}", python.display()))?;
        let questions = child.stdin.take().context("its input")?;
        let mut answers = BufReader::new(child.stdout.take().context("its output")?);
        let mut versions = String::new();
        answers.read_line(&mut versions)?;
        anyhow::ensure!(
            !versions.trim().is_empty(),
            "{program} says nothing: it needs a Python with {needed}; the variable PYTHON may name one"
        );
        Ok(Self { program, child, questions, answers, versions: versions.trim().to_owned() })
    }

    /// Which versions of what.
    pub(super) fn versions(&self) -> &str {
        &self.versions
    }

    /// Runs a task once: its time in seconds, and the sum of its estimates.
    pub(super) fn run(&mut self, task: &str) -> Result<(f64, f64)> {
        writeln!(self.questions, "{task}").with_context(|| format!("{}, {task}", self.program))?;
        let mut answer = String::new();
        self.answers.read_line(&mut answer)?;
        let numbers = answer.split_whitespace().map(str::parse::<f64>).collect::<Result<Vec<f64>, _>>();
        match numbers.as_deref() {
            Ok(&[seconds, sum]) => Ok((seconds, sum)),
            _ => anyhow::bail!("{}, {task}: it answered `{}`, expected two numbers", self.program, answer.trim()),
        }
    }
}

impl Drop for Theirs {
    fn drop(&mut self) {
        // It ends with its input anyway.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
