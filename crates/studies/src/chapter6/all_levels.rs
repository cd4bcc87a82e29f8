//! What became of the claims of Chapter 6 with all 24⁴ designs: kept from a run of `--full`, which takes half an hour, for the page
//! over all chapters, where a run with fewer levels stands in its place.

use std::path::Path;

use anyhow::{Context as _, Result};
use serde::{Deserialize, Serialize};

use crate::claims::{Claim, Place, Truth};
use crate::costs::key::Key;
use crate::decisive::decisive;
use crate::kept;
use crate::rules::Judged;

const FILE: &str = "fixtures/bat/chapter6-all-levels.json";
const WRITTEN_BY: &str = "cargo xtask reproduce-chapter6 --full";
/// What decides of it.
const FILES: [&str; 4] = ["chapter6.toml", "rig.toml", "test-profile.toml", "cost-chapter7.toml"];

/// Names what the files of today say, but for their words.
fn made_from(root: &Path) -> Result<String> {
    let mut key = Key::default();
    for name in FILES {
        key = key.with(decisive(&root.join("fixtures/bat").join(name), &[])?.to_string());
    }
    Ok(key.name())
}

/// A claim as all levels judge it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Row {
    place: Place,
    says: String,
    truth: Truth,
    judged: Judged,
}

impl Row {
    /// Without what was found.
    #[cfg(feature = "ensemble")]
    fn claim(&self) -> Claim {
        Claim::new(self.place.clone(), &self.says, self.judged, String::new()).with_truth(self.truth)
    }
}

/// All that are judged.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct AllLevels {
    written_by: String,
    /// Names the study, the rig, the test and the weights.
    made_from: String,
    rows: Vec<Row>,
}

impl AllLevels {
    fn of(claims: &[Claim], made_from: String) -> Self {
        let row = |claim: &Claim| {
            let (place, says) = (claim.place.clone(), claim.says.clone());
            Some(Row { place, says, truth: claim.truth, judged: claim.judged? })
        };
        Self { written_by: WRITTEN_BY.to_owned(), made_from, rows: claims.iter().filter_map(row).collect() }
    }

    /// What is kept of today's files; of others it says nothing, with a warning.
    #[cfg(feature = "ensemble")]
    pub(crate) fn read(root: &Path) -> Result<Self> {
        let text = std::fs::read_to_string(root.join(FILE)).context(FILE)?;
        let kept: Self =
            serde_json::from_str(&text).with_context(|| format!("{FILE}: take it back from version control"))?;
        let today = made_from(root)?;
        if kept.made_from == today {
            return Ok(kept);
        }
        eprintln!(
            "warning: {FILE} was made from `{}`, today's files are `{today}`: it overrules nothing until `{WRITTEN_BY}` makes it anew",
            kept.made_from
        );
        Ok(Self { rows: Vec::new(), ..kept })
    }

    /// Puts the judgement by all levels in the place of that by fewer, where it comes to another word. Whether it does.
    #[cfg(feature = "ensemble")]
    pub(crate) fn overrule(&self, claim: &mut Claim) -> bool {
        let Some(whole) = self.rows.iter().map(Row::claim).find(|whole| whole.is_same(claim)) else {
            return false;
        };
        if whole.verdict == claim.verdict {
            return false;
        }
        claim.found = format!(
            "With all levels: {}. With fewer: {}. Of these: {}",
            whole.verdict_words(),
            claim.verdict_words(),
            claim.found
        );
        (claim.verdict, claim.judged) = (whole.verdict, whole.judged);
        // What is said in short is said of fewer levels.
        claim.in_short = whole.judged.map_or_else(String::new, |judged| format!("with all levels, {}", judged.count));
        true
    }
}

/// Keeps what a run with all levels came to.
pub(super) fn keep(root: &Path, claims: &[Claim]) -> Result<()> {
    let text = serde_json::to_string_pretty(&AllLevels::of(claims, made_from(root)?)).context(FILE)?;
    kept::replace(&root.join(FILE), format!("{text}\n").as_bytes())
}

#[cfg(feature = "ensemble")]
#[cfg(test)]
mod tests {
    use super::*;
    use crate::claims::Verdict;
    use crate::rules::{Count, Standing};
    use crate::seal::Copies;

    fn root() -> std::path::PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
    }

    /// The page of the same run says the same of every claim.
    #[test]
    fn what_is_kept_is_what_the_page_says() {
        let page = std::fs::read_to_string(root().join("docs/results-chapter6-full.md")).expect("a page");
        let kept = AllLevels::read(&root()).expect("kept");
        for claim in kept.rows.iter().map(Row::claim) {
            let (place, words) = (&claim.place, claim.words());
            let row = page.lines().find(|line| line.starts_with(&format!("| {place} | {words} |")));
            let row = row.unwrap_or_else(|| panic!("{place}, {words} is not on the page"));
            assert!(row.ends_with(&format!("| {} |", claim.verdict_words())), "{row}\n{}", claim.verdict_words());
        }
        let n = page
            .lines()
            .filter(|line| line.starts_with("| ") && line.contains(" of ") && line.matches(" | ").count() == 3);
        assert_eq!(
            n.filter(|line| line.contains("reproduced") || line.contains("check") || line.contains("discriminating"))
                .count(),
            kept.rows.len()
        );
    }

    #[test]
    fn of_another_plant_nothing_is_overruled() {
        let copies = Copies::of(&FILES);
        let path = copies.root().join(FILE);
        std::fs::copy(root().join(FILE), path).expect("a copy");
        let n_rows = || AllLevels::read(copies.root()).expect("kept").rows.len();
        assert!(n_rows() > 0, "of today's files");
        let after = copies.with("cost-chapter7.toml", ["value = ", "value = 1"], n_rows);
        assert_eq!(after, 0, "other weights");
    }

    #[test]
    fn all_levels_overrule_where_they_say_another_word() {
        let judged = |holding| Judged::of(Count { holding, cases: 26 }, Standing::StandIn);
        let fewer = |holding| Claim::new(Place::Section("5.5".into()), "It keeps", judged(holding), "So.".into());
        let kept = AllLevels::of(&[fewer(16)], String::new());
        let mut claim = fewer(26);
        assert!(kept.overrule(&mut claim));
        assert_eq!((claim.verdict, claim.judged), (Verdict::InPart, Some(judged(16))));
        let found =
            "With all levels: reproduced in part: 16 of 26. With fewer: reproduced in kind: 26 of 26. Of these: So.";
        assert_eq!(claim.found, found);
        let mut of_other_truth = fewer(26).with_truth(Truth::Printed);
        assert!(!kept.overrule(&mut of_other_truth), "another truth is another claim");
        let mut same = fewer(17);
        assert!(!kept.overrule(&mut same));
        assert_eq!(same, fewer(17));
    }
}
