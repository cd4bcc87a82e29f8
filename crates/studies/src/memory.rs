//! Where the chapters' flights, panels, campaigns of the pooled loop and designs of batches are remembered: in the target directory what
//! runs of this tree made; with the sources, kept, what the pages in `docs/` were written from.
//!
//! Files on either side are named after what this program makes of some designs, so that nothing stale is ever found. Only
//! a `--check` takes over what is kept, and makes some of it anew: it has to come out the same bit for bit. Whoever types a
//! command without it gets numbers that were computed here.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result};
use bat_dynamics::Fidelity;
use design_space::Region;

use crate::bat::Bat;
use crate::gridded::Designs;
use crate::kept::{self, KEPT};
use crate::reproduction::Extent;

const FLIGHTS: &str = "flights";
const DESIGNS: &str = "designs";
const PANELS: &str = "panels";
const CAMPAIGNS: &str = "campaigns";

/// Of runs of this tree.
const RUNS: &str = "target/reproduction";
/// Of the run that makes everything anew.
const ANEW: &str = "target/reproduction/anew";
/// The folders that a study reads from and writes to.
#[derive(Clone, Debug)]
pub(crate) struct Memory {
    of_runs: PathBuf,
    kept: Option<PathBuf>,
    is_anew: bool,
}

impl Memory {
    pub(crate) fn of(root: &Path, extent: Extent) -> Self {
        let kept = (extent == Extent::WithKept).then(|| root.join(KEPT));
        let is_anew = extent == Extent::Anew;
        Self { of_runs: root.join(if is_anew { ANEW } else { RUNS }), kept, is_anew }
    }

    /// Has a machine go on with what is known of it in these fidelities, and remember what it flies.
    pub(crate) fn remind(&self, bat: &Bat, region: &Region, fidelities: &[Fidelity]) -> Result<()> {
        if let Some(kept) = &self.kept {
            bat.take_over(&kept.join(FLIGHTS), region, fidelities)?;
        }
        bat.keep_in(&self.of_runs.join(FLIGHTS), region, fidelities)
    }

    /// The designs of batches that are known, which grow by those that are searched for.
    pub(crate) fn designs(&self) -> Result<Designs> {
        Designs::keep_in(&self.of_runs.join(DESIGNS), self.kept.as_ref().map(|kept| kept.join(DESIGNS)).as_deref())
    }
}

/// Campaigns of the pooled loop: whole files, which nobody adds to.
impl Memory {
    /// Those that a check takes over.
    pub(crate) fn kept_campaigns(&self) -> Option<PathBuf> {
        self.kept.as_ref().map(|kept| kept.join(CAMPAIGNS))
    }

    /// Those of a run from nothing, to be kept.
    pub(crate) fn campaigns_to_keep(&self) -> Option<PathBuf> {
        self.is_anew.then(|| self.of_runs.join(CAMPAIGNS))
    }
}

/// The panels that a check takes over: whole files, which nobody adds to.
pub(crate) fn kept_panels(root: &Path) -> PathBuf {
    root.join(KEPT).join(PANELS)
}

/// Those of a run from nothing, to be kept.
pub(crate) fn panels_made_anew(root: &Path) -> PathBuf {
    root.join(ANEW).join(PANELS)
}

/// Forgets what an earlier run from nothing left.
pub(crate) fn forget(root: &Path) -> Result<()> {
    let folder = root.join(ANEW);
    if folder.exists() {
        fs::remove_dir_all(&folder).with_context(|| folder.display().to_string())?;
    }
    Ok(())
}

/// Keeps what a run from nothing made in the place of what was kept, lines that threads wrote in any order in order.
pub(crate) fn keep(root: &Path) -> Result<()> {
    for (name, as_kept) in [
        (FLIGHTS, in_order as fn(&str) -> String),
        (DESIGNS, in_order),
        (PANELS, str::to_owned),
        (CAMPAIGNS, str::to_owned),
    ] {
        let (from, to) = (root.join(ANEW).join(name), root.join(KEPT).join(name));
        if to.exists() {
            fs::remove_dir_all(&to).with_context(|| to.display().to_string())?;
        }
        for entry in fs::read_dir(&from).with_context(|| from.display().to_string())? {
            let entry = entry?;
            let text = fs::read_to_string(entry.path()).with_context(|| entry.path().display().to_string())?;
            kept::replace(&to.join(entry.file_name()), as_kept(&text).as_bytes())?;
        }
    }
    eprintln!("{KEPT}: what this run flew and searched for is kept");
    Ok(())
}

fn in_order(text: &str) -> String {
    let mut lines: Vec<&str> = text.lines().filter(|line| !line.is_empty()).collect();
    lines.sort_unstable();
    lines.iter().flat_map(|line| [line, "\n"]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_kept_is_in_order_whatever_thread_was_first() {
        assert_eq!(in_order("\nb\t2\n\na\t1\n"), "a\t1\nb\t2\n");
        assert_eq!(in_order(""), "");
    }

    #[test]
    fn only_a_check_takes_over_what_is_kept() {
        let root = Path::new("root");
        for extent in [Extent::Default, Extent::Full, Extent::Anew] {
            let memory = Memory::of(root, extent);
            assert_eq!((&memory.kept, memory.kept_campaigns()), (&None, None), "{extent:?}");
            assert_eq!(memory.campaigns_to_keep().is_some(), extent == Extent::Anew, "{extent:?}");
        }
        let memory = Memory::of(root, Extent::WithKept);
        assert!(memory.kept.is_some() && memory.kept_campaigns().is_some() && memory.campaigns_to_keep().is_none());
    }
}
