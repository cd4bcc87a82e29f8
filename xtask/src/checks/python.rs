//! `cargo xtask python`: the Python package as its users get it: a wheel in an environment of its own, with all its tests.

use std::env;
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Mutex, PoisonError};
use std::thread::{self, JoinHandle};

use anyhow::{Context as _, Result, bail, ensure};
use toml::{Table, Value};

use crate::workspace::{self, run_quietly, run_side_by_side};

const FOLDER: &str = "crates/infuse-python";

/// Where the wheel is built, installed and tested.
struct Place {
    root: PathBuf,
    /// Everything that is written, in the target directory.
    folder: PathBuf,
    venv: PathBuf,
}

/// What the tests are run on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Build {
    /// A wheel as `pip install` makes it, which compiles all dependencies with the features of this package alone.
    Wheel,
    /// The library as it is compiled with all other packages.
    Library,
}

/// Builds the package and runs everything there is to run; says so, and nothing else, where there is no Python.
pub(crate) fn check(build: Build) -> Result<()> {
    match workspace::interpreter() {
        Some(python) => check_with(&python, build),
        None => {
            println!("NOT CHECKED: there is no python3 with venv and pip (or none of the name in PYTHON)");
            Ok(())
        }
    }
}

/// An environment that is being made.
static BEGUN: Mutex<Option<JoinHandle<Result<bool>>>> = Mutex::new(None);

/// Begins to make the environment: pip mostly waits for others, and what is done meanwhile costs no time.
pub(crate) fn begin() {
    let make = || match workspace::interpreter() {
        Some(python) => Place::of_workspace()?.prepare(&python),
        None => Ok(false),
    };
    *BEGUN.lock().unwrap_or_else(PoisonError::into_inner) = Some(thread::spawn(make));
}

fn begun() -> Option<JoinHandle<Result<bool>>> {
    BEGUN.lock().unwrap_or_else(PoisonError::into_inner).take()
}

fn check_with(python: &Path, build: Build) -> Result<()> {
    let place = Place::of_workspace()?;
    let is_ready = match begun() {
        Some(thread) => thread.join().unwrap_or_else(|_| bail!("a thread panicked"))?,
        None => place.prepare(python)?,
    };
    if !is_ready {
        println!("NOT CHECKED: pip cannot get what the tests of the Python package need");
        return Ok(());
    }
    workspace::build_programs()?;
    match build {
        Build::Wheel => place.install_wheel()?,
        Build::Library => place.install_library()?,
    }
    place.test()
}

impl Place {
    fn of_workspace() -> Result<Self> {
        let folder = workspace::target_directory()?.join("python");
        Ok(Self { venv: folder.join("venv"), root: workspace::root()?, folder })
    }

    /// An environment with what the package is built with and tested by; `false` where pip cannot get it. One that is
    /// there is used again, as long as the list is the same.
    fn prepare(&self, python: &Path) -> Result<bool> {
        let text = fs::read_to_string(self.root.join(FOLDER).join("pyproject.toml")).context("pyproject.toml")?;
        let needed = needed(&text)?;
        let list = self.folder.join("installed.txt");
        if fs::read_to_string(&list).is_ok_and(|installed| installed == needed.join("\n")) {
            return Ok(true);
        }
        run_quietly(Command::new(python).args(["-m", "venv", "--clear"]).arg(&self.venv))?;
        // Most of it is never imported, and compiling it takes longer than fetching it; what is imported is compiled then.
        if run_quietly(self.python(["-m", "pip", "install", "--quiet", "--no-compile"]).args(&needed)).is_err() {
            return Ok(false);
        }
        fs::write(&list, needed.join("\n")).with_context(|| list.display().to_string())?;
        Ok(true)
    }

    /// The Python of the environment, which writes nothing into the tree: what it compiles is kept beside the environment.
    fn python<const N: usize>(&self, arguments: [&str; N]) -> Command {
        let bin = self.venv.join(if cfg!(windows) { "Scripts" } else { "bin" });
        let mut command = Command::new(bin.join("python"));
        command.args(arguments).env("PYTHONPYCACHEPREFIX", self.folder.join("compiled"));
        command.current_dir(self.root.join(FOLDER));
        command
    }

    /// Puts the library and the Python files where pip would.
    fn install_library(&self) -> Result<()> {
        let found = self.python(["-c", "import sysconfig; print(sysconfig.get_path('platlib'))"]).output();
        let found = found.context("the Python of the environment")?;
        let package = Path::new(str::from_utf8(&found.stdout)?.trim()).join("infuse");
        if package.exists() {
            fs::remove_dir_all(&package).with_context(|| package.display().to_string())?;
        }
        fs::create_dir_all(&package).with_context(|| package.display().to_string())?;
        for file in fs::read_dir(self.root.join(FOLDER).join("python/infuse")).context("python/infuse")? {
            let file = file?;
            if file.file_type()?.is_file() {
                fs::copy(file.path(), package.join(file.file_name()))
                    .with_context(|| file.path().display().to_string())?;
            }
        }
        let library = format!("{}_native{}", env::consts::DLL_PREFIX, env::consts::DLL_SUFFIX);
        let library = workspace::target_directory()?.join("release").join(library);
        let name = if cfg!(windows) { "_native.pyd" } else { "_native.abi3.so" };
        fs::copy(&library, package.join(name)).with_context(|| library.display().to_string())?;
        Ok(())
    }

    /// Builds the wheel as `pip install` does, and installs it.
    fn install_wheel(&self) -> Result<()> {
        let wheels = self.folder.join("wheels");
        if wheels.exists() {
            fs::remove_dir_all(&wheels).with_context(|| wheels.display().to_string())?;
        }
        run_quietly(self.python(["-m", "maturin", "build", "--release", "--out"]).arg(&wheels))?;
        let found = fs::read_dir(&wheels).with_context(|| wheels.display().to_string())?;
        let found: Vec<PathBuf> = found.map(|entry| Ok(entry?.path())).collect::<Result<_>>()?;
        let [wheel] = found.as_slice() else { bail!("{} wheels, expected one", found.len()) };
        ensure!(wheel.extension() == Some(OsStr::new("whl")), "{} is no wheel", wheel.display());
        let install = ["-m", "pip", "install", "--quiet", "--no-deps", "--force-reinstall"];
        run_quietly(self.python(install).arg(wheel))
    }

    /// Tests, examples in docstrings and pages, types, stubs: what none of them writes is another's to read.
    fn test(&self) -> Result<()> {
        let example = workspace::target_directory()?.join("release/examples/same_bits");
        let mut tests = self.python(["-m", "pytest", "-q"]);
        tests.env("SAME_BITS", example.with_extension(env::consts::EXE_EXTENSION));
        let docstrings = self.python(["-m", "pytest", "-q", "--doctest-modules", "--pyargs", "infuse"]);
        // They write files.
        let mut pages = self.python(["-m", "pytest", "-q", "-p", "no:cacheprovider", "--doctest-glob=*.md"]);
        pages.args(["crates/infuse-python/README.md", "docs/python.md"].map(|page| self.root.join(page)));
        pages.current_dir(&self.folder);
        let example = self.python(["examples/campaign.py"]);
        let mut types = self.python(["-m", "mypy", "--cache-dir"]);
        types.arg(self.folder.join("mypy")).args(["python", "tests", "examples"]);
        let mut stubs = self.python(["-m", "mypy.stubtest", "infuse", "--mypy-config-file"]);
        stubs.arg(self.root.join(FOLDER).join("pyproject.toml")).current_dir(&self.folder);
        run_side_by_side(vec![tests, types, stubs, docstrings, pages, example])
    }
}

/// What the manifest says that the package is built with, runs with and is tested with.
fn needed(manifest: &str) -> Result<Vec<String>> {
    let manifest: Table = manifest.parse().context("pyproject.toml")?;
    let list = |path: &[&str]| {
        let found = path.iter().try_fold(&Value::Table(manifest.clone()), |value, key| value.get(key)).cloned();
        let list = found.and_then(|found| found.try_into::<Vec<String>>().ok());
        list.with_context(|| format!("pyproject.toml: no list `{}`", path.join(".")))
    };
    let build = list(&["build-system", "requires"])?;
    Ok([build, list(&["project", "dependencies"])?, list(&["project", "optional-dependencies", "test"])?].concat())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_needed_is_read_from_the_manifest() {
        let manifest = "[build-system]\nrequires = [\"maturin\"]\n[project]\ndependencies = [\"numpy\"]\n\
                        [project.optional-dependencies]\ntest = [\"pytest\"]\n";
        assert_eq!(needed(manifest).expect("all lists"), ["maturin", "numpy", "pytest"]);
        let error = needed("[project]\n").expect_err("no lists");
        assert_eq!(error.to_string(), "pyproject.toml: no list `build-system.requires`");
    }
}
