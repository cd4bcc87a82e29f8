//! What a study hands on to the page over all studies: a file beside its own page.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::{Context as _, Result};
use serde::{Deserialize, Serialize};

use crate::claims::Claim;
use crate::reproduction::Picture;
use page::Page;
use page::Table;

/// A table of a study with what is to be said of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Excerpt {
    pub(crate) heading: String,
    pub(crate) paragraphs: Vec<String>,
    pub(crate) table: Table,
    pub(crate) caption: String,
}

impl Excerpt {
    pub(crate) fn show_in(&self, page: &mut Page) {
        page.heading(&self.heading);
        for paragraph in &self.paragraphs {
            page.paragraph(paragraph);
        }
        page.table(&self.table, &self.caption);
    }
}

/// Everything that a study hands on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Handover {
    pub(crate) claims: Vec<Claim>,
    /// By the names of the pictures.
    captions: BTreeMap<String, String>,
    pub(crate) excerpts: Vec<Excerpt>,
}

const FILE: &str = "handover.json";

impl Handover {
    pub(crate) fn new(claims: Vec<Claim>, pictures: &[Picture]) -> Self {
        let captions = pictures.iter().map(|picture| (picture.name.clone(), picture.caption.clone())).collect();
        Self { claims, captions, excerpts: Vec::new() }
    }

    /// The same with tables that the page over all should show.
    pub(crate) fn with_excerpts(self, excerpts: Vec<Excerpt>) -> Self {
        Self { excerpts, ..self }
    }

    /// A picture of the study, drawn in `out`.
    pub(crate) fn picture(&self, out: &Path, name: &str) -> Result<Picture> {
        let path = out.join(format!("{name}.svg"));
        let svg = std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
        let caption = self.captions.get(name).with_context(|| format!("no caption of {}", path.display()))?;
        Ok(Picture { name: name.to_owned(), svg, caption: caption.clone() })
    }

    /// Writes it into the folder of the study.
    pub(crate) fn save(&self, out: &Path) -> Result<()> {
        let path = out.join(FILE);
        std::fs::write(&path, serde_json::to_string_pretty(self)?).with_context(|| path.display().to_string())
    }

    /// Reads what the latest run of a study handed on.
    pub(crate) fn read(out: &Path) -> Result<Self> {
        let path = out.join(FILE);
        let text = std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
        serde_json::from_str(&text).with_context(|| path.display().to_string())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::claims::{Place, Verdict};
    use crate::rules::{Count, Judged, Standing};
    use page::Column;

    #[test]
    fn handover_comes_back_from_its_file() {
        let folder = tempfile::tempdir().expect("a writable directory");
        let out = folder.path().to_owned();
        let claims = vec![
            Claim::new(
                Place::Table(3),
                "The cost falls",
                Judged::of(Count::one(true), Standing::StandIn),
                "15 %".into(),
            )
            .shown_in(&["a"]),
            Claim::given(Place::Contribution(1), "A loop", Verdict::Calibrated, "none".into()),
        ];
        let picture = Picture { name: "a".into(), svg: "<svg/>".into(), caption: "A fall".into() };
        let mut table = Table::new(vec![Column::new("cost", "s")]);
        table.push(vec!["1".into()]);
        let excerpt =
            Excerpt { heading: "Costs".into(), paragraphs: vec!["Low.".into()], table, caption: "All".into() };
        let given = Handover::new(claims, std::slice::from_ref(&picture)).with_excerpts(vec![excerpt]);
        let outcome = given.save(&out).and_then(|()| Ok(std::fs::write(out.join("a.svg"), &picture.svg)?));
        let read = outcome.and_then(|()| Handover::read(&out));
        let shown = given.picture(&out, "a");
        assert_eq!(read.expect("just written"), given);
        assert_eq!(shown.expect("a picture with its caption").caption, "A fall");
    }
}
