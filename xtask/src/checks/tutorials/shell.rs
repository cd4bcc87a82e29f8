//! A reader's shell: one folder, one block after the other.

use std::ffi::{OsStr, OsString};
use std::fs;
use std::io::{PipeReader, Read as _};
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result, bail};
use process_wrap::std::{ChildWrapper, CommandWrap};
use tempfile::TempDir;

/// How often is looked whether a block has ended.
const LOOK: Duration = Duration::from_millis(10);
/// Where whoever asks for the network finds nobody.
const NOWHERE: &str = "http://127.0.0.1:9";

/// Where a block is run: each in a shell of its own, in the directory that the one before went to.
pub(super) struct Shell {
    search_path: OsString,
    time_limit: Duration,
    directory: PathBuf,
    /// Deleted with this value.
    home: TempDir,
    /// Holds what the tutorial should not see.
    aside: TempDir,
}

/// A block that was run.
pub(super) struct Done {
    /// Standard output and standard error, in the order in which they were written.
    pub(super) printed: String,
    /// None where a signal ended it.
    pub(super) code: Option<i32>,
}

impl Shell {
    pub(super) fn new(search_path: &OsStr, time_limit: Duration) -> Result<Self> {
        let home = tempfile::tempdir().context("temporary folder")?;
        let aside = tempfile::tempdir().context("temporary folder")?;
        let directory = home.path().to_owned();
        Ok(Self { search_path: search_path.to_owned(), time_limit, directory, home, aside })
    }

    /// Runs a script with `sh -eu`; what it leaves running ends with it.
    pub(super) fn run(&mut self, script: &str) -> Result<Done> {
        let went_to = self.aside.path().join("directory");
        let (reader, mut child) = self.start(&format!("trap 'pwd >\"$WENT_TO\"' EXIT\n{script}"), &went_to)?;
        let listener = thread::spawn(move || listen(reader));
        let start = Instant::now();
        let status = loop {
            if let Some(status) = child.try_wait().context("sh")? {
                break Some(status);
            }
            if start.elapsed() > self.time_limit {
                break None;
            }
            thread::sleep(LOOK);
        };
        // An error says that nobody is left.
        let _ = child.start_kill();
        let printed = listener.join().ok().context("the listener")?.context("what the block printed")?;
        let Some(status) = status else {
            child.wait().context("sh")?;
            bail!("not done after {} s; it printed\n{}", self.time_limit.as_secs_f64(), printed.trim_end());
        };
        if let Ok(directory) = fs::read_to_string(&went_to) {
            self.directory = PathBuf::from(directory.trim_end_matches('\n'));
        }
        Ok(Done { printed, code: status.code() })
    }

    fn start(&self, script: &str, went_to: &PathBuf) -> Result<(PipeReader, Box<dyn ChildWrapper>)> {
        let (reader, writer) = std::io::pipe().context("pipe")?;
        let mut command = Command::new("sh");
        command.args(["-eu", "-c", script]).current_dir(&self.directory);
        command.env("PATH", &self.search_path).env("HOME", self.home.path()).env("WENT_TO", went_to);
        // What a reader's own settings could change in what is printed.
        command.env("LC_ALL", "C").env("TERM", "dumb").env_remove("RUST_BACKTRACE").env_remove("RUST_LOG");
        for variable in ["http_proxy", "https_proxy", "HTTP_PROXY", "HTTPS_PROXY", "ALL_PROXY"] {
            command.env(variable, NOWHERE);
        }
        command.stdin(Stdio::null()).stdout(writer.try_clone().context("pipe")?).stderr(writer);
        let mut command = CommandWrap::from(command);
        #[cfg(unix)]
        command.wrap(process_wrap::std::ProcessGroup::leader());
        #[cfg(windows)]
        command.wrap(process_wrap::std::JobObject);
        Ok((reader, command.spawn().context("cannot start sh")?))
    }
}

fn listen(mut reader: PipeReader) -> std::io::Result<String> {
    let mut bytes = Vec::new();
    reader.read_to_end(&mut bytes)?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}
