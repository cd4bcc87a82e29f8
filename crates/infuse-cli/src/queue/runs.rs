//! The folder of a batch of runs in the queue: what is to be run, and what came of it.

use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result};
use design_space::Region;

use super::script::{of_a_run, of_a_task};
use super::task::Task;
use crate::disk::replace;
use crate::journal::Measured;
use crate::problem::{Program, Queue};
use crate::program::{Ran, ended, tail};

/// In the folder of a campaign.
const RUNS: &str = "runs";

/// A folder that the machines of the cluster see.
#[derive(Debug)]
pub(super) struct Runs {
    path: PathBuf,
}

impl Runs {
    pub(super) fn of(folder: &Path, stem: &str) -> Self {
        let path = folder.join(RUNS).join(stem);
        Self { path: std::path::absolute(&path).unwrap_or(path) }
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    fn file(&self, number: usize, kind: &str) -> PathBuf {
        self.path.join(format!("{number}.{kind}"))
    }

    /// Writes what each run needs, numbered from 1, but for those that have their result, and the script of a submission; again, if it was there before.
    pub(super) fn write(
        &self,
        folder: &Path,
        region: &Region,
        program: &Program,
        queue: &Queue,
        name: &str,
        tasks: &[Option<&Task>],
    ) -> Result<PathBuf> {
        let name_of = |path: &Path| path.display().to_string();
        std::fs::create_dir_all(&self.path).with_context(|| name_of(&self.path))?;
        let folder = std::path::absolute(folder).with_context(|| name_of(folder))?;
        let put = |path: PathBuf, text: String| std::fs::write(&path, text).with_context(|| name_of(&path));
        for (index, task) in tasks.iter().enumerate().filter_map(|(index, task)| Some((index, (*task)?))) {
            let words = program.words(&folder, region, &task.point, task.key.id());
            put(self.file(index + 1, "sh"), of_a_run(&folder, &words))?;
            put(self.file(index + 1, "in"), program.input_text(region, &task.point, task.key.id()))?;
        }
        let script = self.path.join(format!("{name}.sh"));
        let seconds = program.timeout.as_secs_f64();
        put(script.clone(), of_a_task(&self.path, queue.runs_per_task, seconds))?;
        Ok(script)
    }

    /// What came of a run, if it has ended.
    pub(super) fn result(&self, number: usize) -> Option<(Measured, BTreeMap<String, f64>)> {
        let code = std::fs::read_to_string(self.file(number, "done")).ok()?;
        let read = |kind: &str| -> Result<String> { tail(&mut File::open(self.file(number, kind))?) };
        // Where it is done, both are there; a folder that is not seen yet as a whole is read again.
        let (output, errors) = (read("out").ok()?, read("err").ok()?);
        let status = match code.trim() {
            "124" | "137" => "stopped, see `timeout_seconds` and the limits of the queue".to_owned(),
            code => format!("exit status: {code}"),
        };
        Some(match ended(code.trim() == "0", &status, &output, &errors) {
            Ran::Value { value, others, .. } => (Measured::Value(value), others),
            Ran::Failed(reason) => (Measured::Failed(reason), BTreeMap::new()),
            Ran::Interrupted => (Measured::Failed(status), BTreeMap::new()),
        })
    }

    /// Notes that the scheduler took a submission, with what it said.
    pub(super) fn note_taken(&self, name: &str, said: &str) -> Result<()> {
        replace(&self.taken(name), said.as_bytes())
    }

    /// What the scheduler said when it took a submission; none if nobody knows whether it did.
    pub(super) fn said(&self, name: &str) -> Option<String> {
        std::fs::read_to_string(self.taken(name)).ok()
    }

    /// The file that notes it.
    pub(super) fn taken(&self, name: &str) -> PathBuf {
        self.path.join(format!("{name}.taken"))
    }

    /// Notes that a list has shown a submission.
    pub(super) fn note_shown(&self, name: &str) -> Result<()> {
        if self.was_shown(name) {
            return Ok(());
        }
        replace(&self.shown(name), b"")
    }

    /// Whether a list has ever shown a submission.
    pub(super) fn was_shown(&self, name: &str) -> bool {
        self.shown(name).exists()
    }

    fn shown(&self, name: &str) -> PathBuf {
        self.path.join(format!("{name}.shown"))
    }

    /// Notes that a submission was stopped from here.
    pub(super) fn note_stopped(&self, name: &str) -> Result<()> {
        replace(&self.stopped(name), b"")
    }

    /// Whether a submission was stopped from here.
    pub(super) fn was_stopped(&self, name: &str) -> bool {
        self.stopped(name).exists()
    }

    fn stopped(&self, name: &str) -> PathBuf {
        self.path.join(format!("{name}.stopped"))
    }
}
