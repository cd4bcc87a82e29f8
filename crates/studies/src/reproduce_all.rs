//! `cargo xtask reproduce-all`: every study, and one page over what the dissertation claims.

use std::path::Path;

use anyhow::{Context as _, Result};

use crate::claims::{self, Claim, ORDER, Place, Verdict};
use crate::ensemble::{self, OverEnsemble};
use crate::exemptions;
use crate::first_screen::FirstScreen;
use crate::handover::Handover;
use crate::memory;
use crate::reproduction::{self, Extent, Picture, Reproduction, markdown_list};
use page::{Axis, Column, CountFigure, Finding, Link, Page, Table, count_figure, palette};

const DIRECTORY: &str = "target/reproduction";
const NAME: &str = "reproduction.md";
const PICTURE: &str = "reproduction.svg";

const NOTE: &str = "No experiment was made: the water channel is replaced by a stand-in, the numerical model plus stall plus added mass. \
    A claim about experiments can therefore be reproduced in kind at most, and what was fitted counts for nothing: the plant to rows 1 \
    of Table 3 and 0 of Table 5, the stand-in to the best designs of Tables 3 and 5, the weights of the costs to both tables, in Table 3 \
    with the costs at both ends. What leads from one fitted end to the other is called partly calibrated and does not count as reproduced.";

const WORDS: &str = "Reproduced: it comes out, and nothing was fitted to it. In kind: what it says comes out, on a stand-in or with \
    other numbers. In part: in some cases and not in others. Not reproduced: it does not come out. Partly calibrated: both ends were \
    fitted; that the loop goes from the one towards the other is all that came out. Calibrated: it was fitted. Taken over: it says what is \
    put in. Flights between fitted ends (Figures 16 to 18 and 24) were not fitted one by one, but the cost that they add up to was.";

const CLAIM_CAPTION: &str = "Every contribution, section, table and figure that says something of results, with what the latest run found. \
    Commands go after `cargo xtask`. Over the ensemble: in how many plants that meet the published numbers, and in how many of their \
    campaigns, in still and in moving water.";
const OF_ENSEMBLE: &str = "The rules and the words of the ensemble are on [its page](results-ensemble.md).";

const EXEMPT_CAPTION: &str =
    "Sections and figures without a claim, and why; equations have a page of their own, `docs/equations.md`.";

/// A study with what its latest run handed on.
struct Chapter<'a> {
    study: &'a Reproduction,
    handover: Handover,
}

/// A claim with the study that it was looked at in.
struct Listed<'a> {
    claim: &'a Claim,
    chapter: &'a Chapter<'a>,
}

/// What is on the page over all beside the chapters, from what is kept.
struct Over {
    claims: Vec<OverEnsemble>,
    counts: Vec<String>,
}

impl Over {
    fn of(&self, claim: &Claim) -> Option<&OverEnsemble> {
        self.claims.iter().find(|over| over.place == claim.place && over.says == claim.says)
    }

    /// Those that no chapter has.
    fn alone<'a>(&'a self, listed: &'a [Listed<'_>]) -> impl Iterator<Item = &'a OverEnsemble> {
        let has = |over: &&OverEnsemble| {
            listed.iter().any(|one| one.claim.place == over.place && one.claim.says == over.says)
        };
        self.claims.iter().filter(move |over| !has(over))
    }
}

/// Runs every study of a chapter from nothing, writes the page over all, and keeps the flights and designs for the checks.
pub(crate) fn keep(root: &Path, studies: &[Reproduction]) -> Result<()> {
    memory::forget(root)?;
    run(root, studies, Extent::Anew)?;
    memory::keep(root)
}

/// Runs every study of a chapter and writes the page over all; with what is kept, the committed pages must say the same.
pub(crate) fn run(root: &Path, studies: &[Reproduction], extent: Extent) -> Result<()> {
    let check = extent == Extent::WithKept;
    let chosen: Vec<&Reproduction> = studies.iter().filter(|study| is_chapter(study)).collect();
    for (number, study) in chosen.iter().enumerate() {
        eprintln!("\n[{}/{}] {}", number + 1, chosen.len(), study.command);
        if check { study.check(root) } else { study.run(root, extent) }.context(study.command)?;
    }
    write_page(root, studies, check)
}

/// Writes the page over all from what the latest run of each study found.
pub(crate) fn write_page(root: &Path, studies: &[Reproduction], check: bool) -> Result<()> {
    let chosen: Vec<&Reproduction> = studies.iter().filter(|study| is_chapter(study)).collect();
    let (claims, counts) = ensemble::over(root)?;
    let over = Over { claims, counts };
    let read = |study| Ok(Chapter { study, handover: Handover::read(&root.join(study.out()))? });
    let chapters = chosen.into_iter().map(read).collect::<Result<Vec<_>>>()?;
    let mut listed: Vec<Listed<'_>> = chapters
        .iter()
        .flat_map(|chapter| chapter.handover.claims.iter().map(move |claim| Listed { claim, chapter }))
        .collect();
    listed.sort_by(|a, b| a.claim.place.cmp(&b.claim.place));
    let places = listed.iter().map(|one| &one.claim.place).chain(over.claims.iter().map(|over| &over.place));
    exemptions::check(places)?;
    let out = root.join(DIRECTORY);
    let picture = verdicts(&chapters);
    let first = first_screen(&listed, &over, &picture);
    reproduction::save(&out, "index.html", &page(root, studies, &chapters, (&listed, &over), &first)?.html())?;
    reproduction::save(&out, NAME, &markdown(&listed, &over, &first.markdown(PICTURE)))?;
    reproduction::save_kept_picture(&out, PICTURE, &picture)?;
    print(&listed);
    if check {
        for name in [NAME, PICTURE] {
            reproduction::compare(root, &Path::new(DIRECTORY).join(name), &format!("docs/{name}"))?;
        }
    }
    Ok(())
}

/// What became of the claims, study by study.
fn verdicts(chapters: &[Chapter<'_>]) -> Picture {
    let kinds = ORDER.map(|verdict| {
        let color = match verdict {
            Verdict::Reproduced => palette::GREEN,
            Verdict::InKind => "#7fc8ae",
            Verdict::InPart => palette::ORANGE,
            Verdict::NotReproduced => palette::VERMILION,
            Verdict::PartlyCalibrated => "#999999",
            Verdict::Calibrated => "#bbbbbb",
            Verdict::TakenOver => "#dddddd",
        };
        (verdict.to_string(), color)
    });
    let count = |chapter: &Chapter<'_>, verdict: Verdict| {
        chapter.handover.claims.iter().filter(|claim| claim.verdict == verdict).count()
    };
    let bars = chapters.iter().map(|chapter| {
        let counts = ORDER.iter().map(|verdict| count(chapter, *verdict)).collect();
        (chapter.study.title.to_owned(), counts)
    });
    let figure = CountFigure {
        title: "What became of the claims of the dissertation".to_owned(),
        x_axis: Axis::new("claims", "1"),
        kinds: kinds.into(),
        bars: bars.collect(),
    };
    Picture {
        name: "verdicts".to_owned(),
        svg: count_figure(&figure),
        caption: "A box for each claim, by the study that looked at it and by what became of it; gray ones were fitted or put in, and \
                  count for nothing."
            .to_owned(),
    }
}

/// What the pages begin with: how many claims came out, the contributions with their numbers, and all verdicts at once.
fn first_screen<'a>(listed: &[Listed<'_>], over: &Over, picture: &'a Picture) -> FirstScreen<'a> {
    let contributions = listed.iter().filter(|one| matches!(one.claim.place, Place::Contribution(_)));
    let contributions = contributions.map(|one| claims::finding(one.claim));
    let head = Finding::new("The contributions that the dissertation names:");
    let head_over = Finding::new(
        "The same over an ensemble of plants that meet the published numbers, the one plant of the chapters being one of many:",
    );
    let over = over.counts.iter().map(|words| Finding::new(words.clone())).fold(head_over, Finding::detail);
    FirstScreen { findings: vec![counts(listed), over, contributions.fold(head, Finding::detail)], picture }
}

/// Whether a study has claims of the dissertation.
fn is_chapter(study: &Reproduction) -> bool {
    study.has_claims
}

/// All claims of the chapters with what became of each over the ensemble, and those of the ensemble alone, by place.
fn table(listed: &[Listed<'_>], over: &Over) -> Table {
    let mut table = claims::table_with_commands(listed.iter().map(|one| (one.claim, one.chapter.study.command)));
    table.columns.push(Column::new("Over the ensemble", ""));
    let words = listed.iter().map(|one| over.of(one.claim).map_or("–".to_owned(), |over| over.words.clone()));
    table.rows.iter_mut().zip(words).for_each(|(row, words)| row.push(words));
    let mut rows: Vec<(Place, Vec<String>)> =
        listed.iter().map(|one| one.claim.place.clone()).zip(std::mem::take(&mut table.rows)).collect();
    rows.extend(over.alone(listed).map(|over| {
        let [command, none] = [COMMAND_OF_ENSEMBLE, "–"].map(str::to_owned);
        (over.place.clone(), vec![over.place.to_string(), over.says.clone(), none, command, over.words.clone()])
    }));
    rows.sort_by(|a, b| a.0.cmp(&b.0));
    table.rows = rows.into_iter().map(|(_, row)| row).collect();
    table
}

const COMMAND_OF_ENSEMBLE: &str = "`reproduce-all --ensemble`";
/// How a page divides its width among the columns of [`table`], in per cent.
const WIDTHS_PCT: [u32; 5] = [12, 33, 12, 16, 27];

fn count_words<'a>(claims: impl Iterator<Item = &'a Claim> + Clone) -> String {
    let count = |verdict: Verdict| claims.clone().filter(|claim| claim.verdict == verdict).count();
    let be = |n: usize, [one, many]: [&str; 2]| format!("{n} {}", if n == 1 { one } else { many });
    format!(
        "Of {} claims {} reproduced, {} in kind, {} in part, and {} not. {} partly calibrated, {} calibrated, and {}: none of these counts.",
        claims.clone().count(),
        be(count(Verdict::Reproduced), ["is", "are"]),
        count(Verdict::InKind),
        count(Verdict::InPart),
        count(Verdict::NotReproduced),
        be(count(Verdict::PartlyCalibrated), ["was", "were"]),
        count(Verdict::Calibrated),
        be(count(Verdict::TakenOver), ["is an input", "are inputs"])
    )
}

fn counts(listed: &[Listed<'_>]) -> Finding {
    let finding = Finding::new(count_words(listed.iter().map(|one| one.claim)));
    ORDER.into_iter().fold(finding, |finding, verdict| {
        let n = listed.iter().filter(|one| one.claim.verdict == verdict).count();
        finding.with(&verdict.to_string(), n as f64, "1")
    })
}

/// The way to the page of a study; without a link while there is no page.
fn link(root: &Path, study: &Reproduction) -> Link {
    let by = format!("made by `cargo xtask {}`", study.command);
    let page = format!("{}/index.html", study.name);
    let is_there = root.join(DIRECTORY).join(&page).is_file();
    let about = match (is_there, is_chapter(study)) {
        (true, true) => format!(": {by}"),
        (true, false) => format!(": {by}, which is not run again for this page"),
        (false, _) => format!(": {by}, which was not yet run here"),
    };
    Link { to: is_there.then_some(page), text: study.title.to_owned(), about }
}

/// All claims, then each with its pictures, from top to bottom.
fn page(
    root: &Path,
    studies: &[Reproduction],
    chapters: &[Chapter<'_>],
    (listed, over): (&[Listed<'_>], &Over),
    first: &FirstScreen<'_>,
) -> Result<Page> {
    let mut page = Page::new("What of the dissertation comes out");
    let shown = pictures(listed);
    let picture = |(chapter, name): &(&Chapter<'_>, &String)| -> Result<Picture> {
        let mut picture = chapter.handover.picture(&root.join(chapter.study.out()), name)?;
        for claim in chapter.handover.claims.iter().filter(|claim| claim.pictures.contains(*name)) {
            picture.caption.push_str(&format!(" {}: “{}”: {}.", claim.place, claim.says, claim.verdict));
        }
        Ok(picture)
    };
    first.show_in(&mut page);
    page.paragraph(NOTE);
    page.paragraph(WORDS);
    page.heading("The pages");
    page.links(&studies.iter().map(|study| link(root, study)).collect::<Vec<_>>());
    page.heading("Claim by claim");
    page.prose_table(&table(listed, over), CLAIM_CAPTION, &WIDTHS_PCT);
    page.paragraph(claims::FOUND);
    page.list(&claims::found(listed.iter().map(|one| one.claim)));
    page.prose_table(&exemptions::table(), EXEMPT_CAPTION, &exemptions::WIDTHS_PCT);
    for excerpt in chapters.iter().flat_map(|chapter| &chapter.handover.excerpts) {
        excerpt.show_in(&mut page);
    }
    page.heading("The figures");
    for one in &shown {
        picture(one)?.show_in(&mut page);
    }
    Ok(page)
}

/// Every picture that shows a claim, once, where its first claim is.
fn pictures<'a>(listed: &[Listed<'a>]) -> Vec<(&'a Chapter<'a>, &'a String)> {
    let mut pictures: Vec<(&Chapter<'_>, &String)> = Vec::new();
    for Listed { claim, chapter } in listed {
        for name in &claim.pictures {
            let is_shown =
                |(of, shown): &(&Chapter<'_>, &String)| of.study.name == chapter.study.name && *shown == name;
            if !pictures.iter().any(is_shown) {
                pictures.push((chapter, name));
            }
        }
    }
    pictures
}

fn markdown(listed: &[Listed<'_>], over: &Over, first: &str) -> String {
    format!(
        "# What of the dissertation comes out\n\n{first}\n\
         Written by `cargo xtask reproduce-all`; `cargo xtask ci` fails when this page is not what the command finds.\n\n\
         {NOTE}\n\n{WORDS}\n\n{CLAIM_CAPTION} {OF_ENSEMBLE}\n\n{}\n{}\n\n{}\n{EXEMPT_CAPTION}\n\n{}",
        table(listed, over).markdown(),
        claims::FOUND,
        markdown_list(&claims::found(listed.iter().map(|one| one.claim))),
        exemptions::table().markdown()
    )
}

#[expect(clippy::print_stdout, reason = "the result of the command")]
fn print(listed: &[Listed<'_>]) {
    println!("\nWhat of the dissertation comes out\n");
    for Listed { claim, .. } in listed {
        println!("{:22} {:19} {}", claim.place.to_string(), claim.verdict.to_string(), claim.says);
    }
    println!("\n{}\nOne page over all: {DIRECTORY}/index.html", counts(listed).sentence());
}

#[cfg(test)]
mod tests {
    use super::*;

    fn claims(verdicts: &[Verdict]) -> Vec<Claim> {
        verdicts.iter().map(|verdict| Claim::new(Place::Table(1), "it", *verdict, String::new())).collect()
    }

    #[test]
    fn counts_follow_their_numbers() {
        use Verdict::{Calibrated, InKind, NotReproduced, PartlyCalibrated, Reproduced, TakenOver};
        let one = claims(&[Reproduced, InKind, InKind, NotReproduced, PartlyCalibrated, Calibrated, TakenOver]);
        assert_eq!(
            count_words(one.iter()),
            "Of 7 claims 1 is reproduced, 2 in kind, 0 in part, and 1 not. 1 was partly calibrated, 1 calibrated, and 1 is an input: \
             none of these counts."
        );
        let two = claims(&[Reproduced, Reproduced, PartlyCalibrated, PartlyCalibrated, TakenOver, TakenOver]);
        assert_eq!(
            count_words(two.iter()),
            "Of 6 claims 2 are reproduced, 0 in kind, 0 in part, and 0 not. 2 were partly calibrated, 0 calibrated, and 2 are inputs: \
             none of these counts."
        );
    }

    #[test]
    fn picture_of_two_claims_is_shown_once() {
        const STUDY: Reproduction = Reproduction {
            command: "none",
            name: "chapter0",
            title: "Chapter 0",
            has_claims: true,
            run: reproduction::Run::Always(|_| Ok(())),
        };
        let claims = claims(&[Verdict::InKind, Verdict::InPart]).into_iter().map(|claim| claim.shown_in(&["a", "b"]));
        let chapter = Chapter { study: &STUDY, handover: Handover::new(claims.collect(), &[]) };
        let listed: Vec<Listed<'_>> =
            chapter.handover.claims.iter().map(|claim| Listed { claim, chapter: &chapter }).collect();
        let names: Vec<&str> = pictures(&listed).into_iter().map(|(_, name)| name.as_str()).collect();
        assert_eq!(names, ["a", "b"]);
    }
}
