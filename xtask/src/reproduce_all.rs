//! `cargo xtask reproduce-all`: every study, and one page over what the dissertation claims.

use std::path::Path;

use anyhow::{Context as _, Result};

use crate::claims::{self, Claim, Verdict};
use crate::page::Page;
use crate::reproduction::{self, Extent, Reproduction};

const DIRECTORY: &str = "target/reproduction";
const NAME: &str = "reproduction.md";

const NOTE: &str = "No experiment was made: the water channel is replaced by a surrogate, the numerical model plus stall plus added mass. \
    A claim about experiments can therefore be reproduced in kind at most, and what was fitted counts for nothing: the plant to rows 1 \
    of Table 3 and 0 of Table 5, the stand-in to the best designs of Tables 3 and 5, the weights of the costs to both.";

const WORDS: &str = "Reproduced: it comes out, and nothing was fitted to it. In kind: what it says comes out, on a surrogate or with \
    other numbers. In part: in some cases and not in others. Not reproduced: it does not come out. Calibrated: it was fitted. Taken over: \
    it says what is put in.";

const NOTHING: &str = "Figures 1 to 10, 13, 19 and 25 are photographs, drawings and flow charts, with nothing in them that could come out. \
    What the charts of Figures 3 and 13 say is `infuse::GradientLoop`, Figures 4 and 19 `infuse::GlobalLoop`, Figure 6 `bat-dynamics`, \
    Figure 9 `tether-control`.";

/// A claim with the study that it was looked at in.
struct Told<'a> {
    claim: Claim,
    study: &'a Reproduction,
}

/// Runs every study of a chapter and writes the page over all; with `check` the committed pages must say the same.
pub(crate) fn run(root: &Path, studies: &[Reproduction], check: bool) -> Result<()> {
    let chapters: Vec<&Reproduction> = studies.iter().filter(|study| study.name.starts_with("chapter")).collect();
    for (number, study) in chapters.iter().enumerate() {
        eprintln!("\n[{}/{}] {}", number + 1, chapters.len(), study.command);
        if check { study.check(root) } else { study.run(root, Extent::Default) }.context(study.command)?;
    }
    let mut told = Vec::new();
    for study in &chapters {
        let claims = claims::read(&root.join(study.out()))?;
        told.extend(claims.into_iter().map(|claim| Told { claim, study }));
    }
    told.sort_by(|a, b| a.claim.place.cmp(&b.claim.place));
    let out = root.join(DIRECTORY);
    reproduction::save(&out, "index.html", &page(root, &chapters, &told)?.html())?;
    reproduction::save(&out, NAME, &markdown(&told))?;
    print(&told);
    if check { reproduction::compare(root, &Path::new(DIRECTORY).join(NAME), &format!("docs/{NAME}")) } else { Ok(()) }
}

fn table(told: &[Told<'_>]) -> crate::table::Table {
    claims::table_with_commands(told.iter().map(|told| (&told.claim, told.study.command)))
}

fn count_words(told: &[Told<'_>]) -> String {
    let count = |verdict: Verdict| told.iter().filter(|told| told.claim.verdict == verdict).count();
    format!(
        "Of {} claims {} are reproduced, {} in kind, {} in part, and {} not; {} were calibrated and {} are inputs.",
        told.len(),
        count(Verdict::Reproduced),
        count(Verdict::InKind),
        count(Verdict::InPart),
        count(Verdict::NotReproduced),
        count(Verdict::Calibrated),
        count(Verdict::TakenOver)
    )
}

/// All claims, then each with its pictures, from top to bottom.
fn page(root: &Path, chapters: &[&Reproduction], told: &[Told<'_>]) -> Result<Page> {
    let mut page = Page::new("What of the dissertation comes out");
    page.note(NOTE);
    page.paragraph(&count_words(told));
    page.paragraph(WORDS);
    page.heading("Claim by claim");
    page.table(
        &table(told),
        "Every contribution, table and figure that says something of results, with what the latest run found.",
    );
    page.paragraph(NOTHING);
    page.heading("The pages");
    let pages =
        chapters.iter().map(|study| format!("{}/index.html: made by cargo xtask {}", study.name, study.command));
    page.list(&pages.collect::<Vec<_>>());
    page.heading("The figures");
    for told in told.iter().filter(|told| !told.claim.pictures.is_empty()) {
        let Told { claim, study } = told;
        for name in &claim.pictures {
            let path = root.join(study.out()).join(format!("{name}.svg"));
            let svg = std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
            page.figure(&svg, &format!("{}: {}: {}. {}", claim.place, claim.says, claim.verdict, claim.found));
        }
    }
    Ok(page)
}

fn markdown(told: &[Told<'_>]) -> String {
    format!(
        "# What of the dissertation comes out\n\n\
         Written by `cargo xtask reproduce-all`; `cargo xtask ci` fails when this page is not what the command finds.\n\n\
         {NOTE}\n\n{}\n\n{WORDS}\n\n{}\n{NOTHING}\n",
        count_words(told),
        table(told).markdown()
    )
}

#[expect(clippy::print_stdout, reason = "the result of the command")]
fn print(told: &[Told<'_>]) {
    println!("\nWhat of the dissertation comes out\n");
    for told in told {
        println!("{:22} {:19} {}", told.claim.place.to_string(), told.claim.verdict.to_string(), told.claim.says);
    }
    println!("\n{}\nOne page over all: {DIRECTORY}/index.html", count_words(told));
}
