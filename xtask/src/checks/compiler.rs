//! The compiler as `ci` has it: compiles as cargo says, and then reads the same source for lints and for its documentation.
//!
//! `cargo clippy` and `cargo doc` ask others' packages for their types alone, and cargo compiles them once more for that. What they
//! were compiled to for programs tells the types as well; so this program stands between cargo and the compiler of our own packages
//! (`RUSTC_WORKSPACE_WRAPPER`), and hands each call on, first to the compiler, then to clippy, then to rustdoc. Cargo remembers what
//! has passed, as it does with the compiler.
//!
//! A library or program that has unit tests is compiled a second time with them: clippy reads it then, tests and all. What the
//! tests alone use is no use; so without them it is the compiler that is told to refuse what it would warn of.
//!
//! Libraries are optimized as cargo says. All else is used once here, tests, examples and programs, or not run at all, as benches:
//! it takes longer to optimize than to run, and what it calls of libraries is optimized.
//!
//! With other features than those of the workspace, or unpacked, our packages are read and not run: then their types are all that is
//! made of them.

use std::env;
use std::ffi::{OsStr, OsString};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use anyhow::{Context as _, Result};
use sha2::{Digest as _, Sha256};
use toml::{Table, Value};

use crate::workspace;

/// What this program does where it stands for the compiler.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Task {
    /// Compiles, and reads for lints and documentation.
    Programs,
    /// Reads for lints, and makes types alone.
    Lints,
    /// Makes types alone.
    Types,
}

const TASKS: [Task; 3] = [Task::Programs, Task::Lints, Task::Types];

impl Task {
    /// The name of this program then.
    const fn name(self) -> &'static str {
        match self {
            Self::Programs => "checking-compiler",
            Self::Lints => "checking-lints",
            Self::Types => "checking-types",
        }
    }
}

/// What clippy is told in a file.
const SETTINGS: &str = "clippy.toml";
/// Programs that are documented for those who change them, with all that is private. Of other packages it is the libraries.
const DOCUMENTED: [&str; 3] = ["studies", "checks", "xtask"];
const DENY: [&str; 2] = ["-D", "warnings"];

/// Makes what cargo is to start in place of the compiler, to compile programs: a copy of this program, since cargo may build it anew
/// meanwhile, and beside it one for each other task. What has passed with other settings of clippy counts for nothing, because cargo
/// knows the compiler by its path.
pub(crate) fn prepare(root: &Path, target: &Path) -> Result<PathBuf> {
    let settings = root.join(SETTINGS);
    let text = fs::read(&settings).with_context(|| settings.display().to_string())?;
    let digest: String = Sha256::digest(text).iter().take(4).map(|byte| format!("{byte:02x}")).collect();
    let folder = target.join("checked").join(digest);
    fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
    let own = env::current_exe().context("where this program is")?;
    let copy = |task: Task| folder.join(task.name()).with_extension(env::consts::EXE_EXTENSION);
    for task in TASKS {
        fs::copy(&own, copy(task)).with_context(|| copy(task).display().to_string())?;
    }
    Ok(copy(Task::Programs))
}

/// Cargo as it was called, where our own packages are compiled for this task.
pub(crate) fn for_task<'a>(cargo: &'a mut Command, compiler: &Path, task: Task) -> &'a mut Command {
    let program = compiler.with_file_name(task.name()).with_extension(env::consts::EXE_EXTENSION);
    cargo.env(workspace::COMPILED_BY, program)
}

/// Compiles, if that is what this program was started for.
pub(crate) fn stand_in() -> Option<ExitCode> {
    let own = PathBuf::from(env::args_os().next()?);
    let task = TASKS.into_iter().find(|task| own.file_stem().is_some_and(|stem| stem == task.name()))?;
    let command: Vec<OsString> = env::args_os().skip(1).collect();
    Some(match carry_out(task, &command, &own) {
        Ok(code) => ExitCode::from(code),
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    })
}

fn carry_out(task: Task, command: &[OsString], own: &Path) -> Result<u8> {
    let (compiler, arguments) = command.split_first().context("cargo names no compiler")?;
    let Some(unit) = Unit::of(arguments) else { return run(Command::new(compiler).args(arguments)) };
    match task {
        Task::Programs => compile_and_check(compiler, &unit, own),
        Task::Lints => make_types(Command::new("clippy-driver").arg(compiler), &unit, &DENY),
        Task::Types => make_types(&mut Command::new(compiler), &unit, &[]),
    }
}

/// What others are compiled with, and no program: of a library, a file without content stands for what would be linked, since cargo
/// makes anew what is not there.
fn make_types(driver: &mut Command, unit: &Unit<'_>, lints: &[&str]) -> Result<u8> {
    let code = run(driver.args(unit.typed_with()).args(lints))?;
    if let (0, Some(linked)) = (code, unit.linked_library()) {
        fs::write(&linked, "").with_context(|| linked.display().to_string())?;
    }
    Ok(code)
}

/// The exit code of the first of the calls that fails.
fn compile_and_check(compiler: &OsStr, unit: &Unit<'_>, own: &Path) -> Result<u8> {
    let has_tests = unit.is_root() && has_tests()?;
    let compiled = run(Command::new(compiler).args(unit.arguments).args(unit.compiled_with(has_tests)))?;
    if compiled != 0 {
        return Ok(compiled);
    }
    if !has_tests {
        // For what nobody reads.
        let folder = tempfile::tempdir().context("a folder for what clippy writes")?;
        let linted = run(Command::new("clippy-driver").arg(compiler).args(unit.linted_with(folder.path())))?;
        if linted != 0 {
            return Ok(linted);
        }
    }
    if !unit.is_documented() {
        return Ok(0);
    }
    let documentation = own.parent().context("this program is in no folder")?.join("documentation");
    run(Command::new("rustdoc").args(unit.documented_with(&documentation)))
}

/// Whether cargo compiles the package that it names once more, with its unit tests: unless its manifest says no.
fn has_tests() -> Result<bool> {
    let manifest = PathBuf::from(env::var_os("CARGO_MANIFEST_PATH").context("cargo names no manifest")?);
    let name = || manifest.display().to_string();
    let text = fs::read_to_string(&manifest).with_context(name)?;
    let manifest: Table = text.parse().with_context(name)?;
    Ok(!says_no_tests(&manifest))
}

fn says_no_tests(manifest: &Table) -> bool {
    let programs = manifest.get("bin").and_then(Value::as_array).into_iter().flatten();
    let mut targets = manifest.get("lib").into_iter().chain(programs);
    targets.any(|target| target.get("test").and_then(Value::as_bool) == Some(false))
}

fn run(command: &mut Command) -> Result<u8> {
    let status = command.status().with_context(|| format!("cannot start {}", command.get_program().display()))?;
    Ok(status.code().and_then(|code| u8::try_from(code).ok()).unwrap_or(1))
}

/// What the compiler is called for.
#[derive(Debug)]
struct Unit<'a> {
    arguments: &'a [OsString],
}

impl<'a> Unit<'a> {
    /// Nothing where cargo asks the compiler about itself.
    fn of(arguments: &'a [OsString]) -> Option<Self> {
        let unit = Self { arguments };
        unit.value_of("--emit").is_some().then_some(unit)
    }

    /// Of `--name value` or `--name=value`.
    fn value_of(&self, name: &str) -> Option<&'a OsStr> {
        let mut rest = self.arguments.iter();
        while let Some(argument) = rest.next() {
            if argument == name {
                return rest.next().map(OsString::as_os_str);
            }
            let value = argument.to_str().and_then(|text| text.strip_prefix(name)?.strip_prefix('='));
            if let Some(value) = value {
                return Some(OsStr::new(value));
            }
        }
        None
    }

    fn is_test(&self) -> bool {
        self.arguments.iter().any(|argument| argument == "--test")
    }

    /// Whether others are compiled with it, or link it.
    fn is_library(&self) -> bool {
        !self.is_test() && self.value_of("--crate-type").is_some_and(|kind| kind == "lib")
    }

    fn is_program(&self) -> bool {
        self.value_of("--crate-type").is_some_and(|kind| kind == "bin")
    }

    /// Whether it is the library or the program of a package, without the tests that it may have.
    fn is_root(&self) -> bool {
        let source = self.arguments.iter().map(Path::new).find(|path| path.extension() == Some(OsStr::new("rs")));
        !self.is_test() && source.is_some_and(|path| path.components().any(|part| part.as_os_str() == "src"))
    }

    fn is_documented(&self) -> bool {
        let name = self.value_of("--crate-name").and_then(OsStr::to_str);
        self.is_root() && (!self.is_program() || name.is_some_and(|name| DOCUMENTED.contains(&name)))
    }

    /// What is added for the compiler: of two levels, it takes the last. Where clippy reads the unit it says all that it would.
    fn compiled_with(&self, has_tests: bool) -> Vec<&'static str> {
        let lints: &[_] = if has_tests { &DENY } else { &["--cap-lints", "allow"] };
        let level: &[_] = if !self.is_library() { &["-C", "opt-level=0"] } else { &[] };
        [lints, level].concat()
    }

    fn linted_with(&self, folder: &Path) -> Vec<OsString> {
        let mut arguments = self.without(&["--emit", "--out-dir"]);
        arguments.extend(["--emit=metadata".into(), "--out-dir".into(), folder.into()]);
        arguments.extend(DENY.map(OsString::from));
        arguments
    }

    fn documented_with(&self, folder: &Path) -> Vec<OsString> {
        let mut arguments = self.without(&["--emit", "--out-dir", "-C"]);
        arguments.extend(["-o".into(), folder.into()]);
        if self.is_program() {
            arguments.push("--document-private-items".into());
        }
        arguments.extend(DENY.map(OsString::from));
        arguments
    }

    /// Types of what it needs are as good as what would be linked, wherever there are any.
    fn typed_with(&self) -> Vec<OsString> {
        let types = |argument: &OsString| {
            let text = argument.to_str().unwrap_or_default();
            match text {
                "--emit=dep-info,metadata,link" | "--emit=dep-info,link" => "--emit=dep-info,metadata".into(),
                _ => match text.strip_suffix(".rlib").map(|stem| format!("{stem}.rmeta")) {
                    Some(types) if types.split_once('=').is_some_and(|(_, path)| Path::new(path).exists()) => {
                        types.into()
                    }
                    _ => argument.clone(),
                },
            }
        };
        self.arguments.iter().map(types).collect()
    }

    /// What cargo expects of a library beside its types.
    fn linked_library(&self) -> Option<PathBuf> {
        let of_compiler = |name: &str| {
            let mut values = self.arguments.iter().filter_map(|argument| argument.to_str());
            values.find_map(|value| value.strip_prefix(name)?.strip_prefix('='))
        };
        let name = self.value_of("--crate-name")?.to_str()?;
        let folder = Path::new(self.value_of("--out-dir")?);
        let extra = of_compiler("extra-filename").unwrap_or_default();
        self.is_library().then(|| folder.join(format!("lib{name}{extra}.rlib")))
    }

    /// All arguments but these and their values, and without a message for each file that is written: cargo waits for those of the
    /// compiler.
    fn without(&self, names: &[&str]) -> Vec<OsString> {
        let mut kept = Vec::new();
        let mut rest = self.arguments.iter();
        while let Some(argument) = rest.next() {
            let text = argument.to_str().unwrap_or_default();
            if names.contains(&text) {
                rest.next();
            } else if let Some(messages) = text.strip_prefix("--json=") {
                let messages: Vec<&str> = messages.split(',').filter(|kind| *kind != "artifacts").collect();
                kept.push(format!("--json={}", messages.join(",")).into());
            } else if !names.iter().any(|name| text.strip_prefix(name).is_some_and(|rest| rest.starts_with('='))) {
                kept.push(argument.clone());
            }
        }
        kept
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(line: &str) -> Vec<OsString> {
        line.split(' ').map(OsString::from).collect()
    }

    const LIBRARY: &str = "--crate-name surface --edition=2024 src/lib.rs --error-format=json \
        --json=diagnostic-rendered-ansi,artifacts,future-incompat --crate-type lib --emit=dep-info,metadata,link -C opt-level=3 \
        --warn=missing_docs --cfg feature=\"a\" -C metadata=12 --out-dir /t/deps --extern rayon=/t/deps/librayon.rmeta";

    #[test]
    fn libraries_alone_are_optimized() {
        for unit in [
            "src/lib.rs --crate-type lib --test",
            "benches/batch.rs --crate-type bin",
            "src/lib.rs --crate-type cdylib",
        ] {
            let unit = words(&format!("--crate-name it {unit} --emit=dep-info,link -C opt-level=3"));
            let added = Unit::of(&unit).expect("a unit").compiled_with(false);
            assert_eq!(added, ["--cap-lints", "allow", "-C", "opt-level=0"], "{unit:?}");
        }
        let library = words(LIBRARY);
        assert_eq!(Unit::of(&library).expect("a unit").compiled_with(false), ["--cap-lints", "allow"]);
    }

    #[test]
    fn what_has_unit_tests_is_linted_with_them_and_may_warn_of_nothing_without() {
        let library = words(LIBRARY);
        let unit = Unit::of(&library).expect("a unit");
        assert!(unit.is_root());
        assert_eq!(unit.compiled_with(true), ["-D", "warnings"]);
        let with_tests = words(&format!("{LIBRARY} --test"));
        let bench = words("--crate-name batch benches/batch.rs --crate-type bin --emit=dep-info,link");
        let module = words("--crate-name it tests/it/main.rs --test --emit=dep-info,link");
        for unit in [&with_tests, &bench, &module] {
            assert!(!Unit::of(unit).expect("a unit").is_root(), "{unit:?}");
        }
        for (manifest, expected) in [
            ("[lib]\nname = 'a'", false),
            ("[lib]\ntest = false", true),
            ("[[bin]]\nname = 'b'\ntest = false", true),
            ("", false),
        ] {
            assert_eq!(says_no_tests(&manifest.parse().expect("a table")), expected, "{manifest}");
        }
    }

    #[test]
    fn what_cargo_asks_the_compiler_about_itself_is_handed_on() {
        for question in ["-vV", "- --crate-name ___ --print=file-names --crate-type bin --print=cfg"] {
            assert!(Unit::of(&words(question)).is_none(), "{question}");
        }
    }

    #[test]
    fn clippy_reads_the_same_source_and_writes_elsewhere() {
        let library = words(LIBRARY);
        let linted = Unit::of(&library).expect("a unit").linted_with(Path::new("/elsewhere"));
        let expected = "--crate-name surface --edition=2024 src/lib.rs --error-format=json \
            --json=diagnostic-rendered-ansi,future-incompat --crate-type lib -C opt-level=3 --warn=missing_docs --cfg feature=\"a\" \
            -C metadata=12 --extern rayon=/t/deps/librayon.rmeta --emit=metadata --out-dir /elsewhere -D warnings";
        assert_eq!(linted, words(expected));
    }

    #[test]
    fn types_are_made_of_types() {
        let folder = tempfile::tempdir().expect("a folder");
        let out = folder.path().display();
        std::fs::write(folder.path().join("libours-12.rmeta"), "").expect("written");
        let program = words(&format!(
            "--crate-name it --crate-type bin --emit=dep-info,link -C extra-filename=-7 --out-dir {out} \
             --extern ours={out}/libours-12.rlib --extern theirs={out}/libtheirs-3.rlib --extern macro={out}/libmacro-4.so"
        ));
        let expected = words(&format!(
            "--crate-name it --crate-type bin --emit=dep-info,metadata -C extra-filename=-7 --out-dir {out} \
             --extern ours={out}/libours-12.rmeta --extern theirs={out}/libtheirs-3.rlib --extern macro={out}/libmacro-4.so"
        ));
        let program = Unit::of(&program).expect("a unit");
        assert_eq!(program.typed_with(), expected);
        assert_eq!(program.linked_library(), None, "a program that was not linked must not be taken for one");
        let library = words(&format!("{LIBRARY} -C extra-filename=-12"));
        let library = Unit::of(&library).expect("a unit");
        assert!(library.typed_with().contains(&"--emit=dep-info,metadata".into()));
        assert_eq!(library.linked_library(), Some("/t/deps/libsurface-12.rlib".into()));
    }

    #[test]
    fn libraries_are_documented_and_of_programs_those_that_developers_change() {
        let library = words(LIBRARY);
        let unit = Unit::of(&library).expect("a unit");
        assert!(unit.is_documented());
        let expected = "--crate-name surface --edition=2024 src/lib.rs --error-format=json \
            --json=diagnostic-rendered-ansi,future-incompat --crate-type lib --warn=missing_docs --cfg feature=\"a\" \
            --extern rayon=/t/deps/librayon.rmeta -o /docs -D warnings";
        assert_eq!(unit.documented_with(Path::new("/docs")), words(expected));
        for (name, expected) in [("studies", true), ("infuse", false), ("an_example", false)] {
            let program =
                words(&format!("--crate-name {name} crates/{name}/src/main.rs --crate-type bin --emit=dep-info,link"));
            let unit = Unit::of(&program).expect("a unit");
            assert_eq!(unit.is_documented(), expected, "{name}");
            let documented = unit.documented_with(Path::new("/docs"));
            assert!(documented.contains(&"--document-private-items".into()), "{name}");
        }
        let test = words(&format!("{LIBRARY} --test"));
        assert!(!Unit::of(&test).expect("a unit").is_documented(), "a test");
    }
}
