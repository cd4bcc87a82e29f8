//! What all studies share: where they write, how they show progress, and the committed copy of their results.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, bail, ensure};
use indicatif::{ProgressBar, ProgressStyle};

use page::Page;

/// How much of a study is run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Extent {
    /// What fits into a few minutes.
    Default,
    /// With the finest grid, for as long as it takes: `--full`.
    Full,
    /// What fits into a few minutes, of which what is kept with the sources is taken over, and a part of it made anew: `--check`.
    WithKept,
    /// The same from nothing, so that it can be kept: `reproduce-all --keep`.
    Anew,
}

impl Extent {
    /// What names of files end with.
    fn suffix(self) -> &'static str {
        match self {
            Self::Default | Self::WithKept | Self::Anew => "",
            Self::Full => "-full",
        }
    }
}

/// A study that writes a page and keeps its short form in `docs/`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reproduction {
    /// What a person types.
    pub(crate) command: &'static str,
    /// What its folder and its page of results are called.
    pub(crate) name: &'static str,
    /// What a person calls it.
    pub(crate) title: &'static str,
    /// Whether it looks at claims of the dissertation.
    pub(crate) has_claims: bool,
    /// Runs the study and writes everything, `results.md` included.
    pub(crate) run: Run,
}

/// A study as a function of the root of the workspace.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Run {
    /// It has one extent.
    Always(fn(&Path) -> Result<()>),
    /// It takes over, in a check, what is kept.
    Remembering(fn(&Path, Extent) -> Result<()>),
    /// It can also be run in full.
    OrFull(fn(&Path, Extent) -> Result<()>),
}

impl Reproduction {
    /// Where the study writes, from the root.
    pub(crate) fn out(&self) -> PathBuf {
        self.out_of(Extent::Default)
    }

    /// Where it writes what it finds in this extent.
    pub(crate) fn out_of(&self, extent: Extent) -> PathBuf {
        PathBuf::from(format!("target/reproduction/{}{}", self.name, extent.suffix()))
    }

    /// Runs the study.
    pub(crate) fn run(&self, root: &Path, extent: Extent) -> Result<()> {
        match (self.run, extent) {
            (Run::Always(_) | Run::Remembering(_), Extent::Full) => {
                bail!("{} has no --full: it always runs in full", self.command)
            }
            (Run::Always(run), _) => run(root),
            (Run::Remembering(run) | Run::OrFull(run), extent) => run(root, extent),
        }
    }

    /// The same from anywhere, made if it is not there: a study should not find out after its flights that it cannot write.
    pub(crate) fn prepare(&self, root: &Path, extent: Extent) -> Result<PathBuf> {
        let out = root.join(self.out_of(extent));
        std::fs::create_dir_all(&out).with_context(|| out.display().to_string())?;
        Ok(out)
    }

    /// Runs the study and fails when it finds something else than the committed page of results says.
    pub(crate) fn check(&self, root: &Path) -> Result<()> {
        self.run(root, Extent::WithKept)?;
        compare(root, &self.out().join(RESULTS), &format!("docs/results-{}.md", self.name))?;
        compare(root, &self.out().join(KEPT_PICTURE), &format!("docs/{}", self.kept_picture()))
    }

    /// What the picture on its page in `docs/` is called there.
    pub(crate) fn kept_picture(&self) -> String {
        self.kept_picture_of(Extent::Default)
    }

    /// The same of a study in this extent.
    pub(crate) fn kept_picture_of(&self, extent: Extent) -> String {
        format!("results-{}{}.svg", self.name, extent.suffix())
    }
}

/// The results in short, and the picture that they begin with, among the output of a study.
const RESULTS: &str = "results.md";
const KEPT_PICTURE: &str = "results.svg";

/// A picture is one line.
const LONGEST_LINE: usize = 2000;

/// That a committed page says what a run found.
pub(crate) fn compare(root: &Path, fresh_at: &Path, committed_at: &str) -> Result<()> {
    let fresh = std::fs::read_to_string(root.join(fresh_at)).with_context(|| fresh_at.display().to_string())?;
    let committed = std::fs::read_to_string(root.join(committed_at)).with_context(|| committed_at.to_owned())?;
    let differing = fresh.lines().zip(committed.lines()).find(|(a, b)| a != b);
    if let Some((found, said)) = differing {
        let short = |line: &str| line.chars().take(LONGEST_LINE).collect::<String>();
        let (found, said) = (short(found), short(said));
        bail!("{committed_at} is out of date; copy {} over it\n  page: {said}\n  run:  {found}", fresh_at.display());
    }
    ensure!(fresh == committed, "{committed_at} is out of date: it is longer or shorter than what the run finds");
    Ok(())
}

/// A picture with the name of its file and what it shows.
#[derive(Clone, Debug)]
pub(crate) struct Picture {
    pub(crate) name: String,
    pub(crate) svg: String,
    pub(crate) caption: String,
}

impl Picture {
    pub(crate) fn show_in(&self, page: &mut Page) {
        page.figure(&self.svg, &self.caption);
    }
}

/// The largest picture that is kept in `docs/`, in bytes.
const LARGEST_KEPT: usize = 60_000;

/// Writes what every study has: its pictures, the page that shows them, and its results in short with the picture that they
/// begin with.
pub(crate) fn save_page(out: &Path, pictures: &[Picture], page: &Page, results: &str, first: &Picture) -> Result<()> {
    for picture in pictures {
        save(out, &format!("{}.svg", picture.name), &picture.svg)?;
    }
    save(out, "index.html", &page.html())?;
    save_results(out, results, first)
}

/// Writes what is kept in `docs/` alone.
pub(crate) fn save_results(out: &Path, results: &str, first: &Picture) -> Result<()> {
    save(out, RESULTS, results)?;
    save_kept_picture(out, KEPT_PICTURE, first)
}

/// Writes a picture that is kept in `docs/`, too.
pub(crate) fn save_kept_picture(out: &Path, name: &str, picture: &Picture) -> Result<()> {
    let size = picture.svg.len();
    ensure!(size <= LARGEST_KEPT, "{} has {size} bytes, expected at most {LARGEST_KEPT}", picture.name);
    save(out, name, &format!("{}\n", picture.svg))
}

/// The picture of this name.
pub(crate) fn picture<'a>(pictures: &'a [Picture], name: &str) -> Result<&'a Picture> {
    pictures.iter().find(|picture| picture.name == name).with_context(|| format!("no picture is called {name}"))
}

/// Writes a file of a study's output.
pub(crate) fn save(out: &Path, name: &str, text: &str) -> Result<()> {
    let path = out.join(name);
    if let Some(directory) = path.parent() {
        std::fs::create_dir_all(directory).with_context(|| directory.display().to_string())?;
    }
    std::fs::write(&path, text).with_context(|| path.display().to_string())
}

/// A bar that fills while a part of a study runs.
pub(crate) fn progress(what: &str, length: usize) -> ProgressBar {
    let bar = ProgressBar::new(length as u64);
    if let Ok(style) = ProgressStyle::with_template("{msg:52} [{bar:24}] {pos}/{len} {elapsed}") {
        bar.set_style(style);
    }
    bar.set_message(what.to_owned());
    bar
}

/// A list in Markdown.
pub(crate) fn markdown_list(items: &[String]) -> String {
    items.iter().map(|item| format!("- {item}\n")).collect()
}
