//! `cargo xtask reproduce-all`: every study, and one page over what the dissertation claims.

use std::path::Path;

use anyhow::{Context as _, Result};

use crate::chapter6::{self, AllLevels};
use crate::claims::{self, Claim, Place, Truth};
use crate::ensemble::{self, OverEnsemble};
use crate::exemptions;
use crate::first_screen::FirstScreen;
use crate::handover::Handover;
use crate::memory;
use crate::reproduction::{self, Extent, Picture, Reproduction};
use crate::rules::{self, Verdict};
use crate::words::counted;
use page::{Axis, Column, CountFigure, Finding, Link, Page, Table, count_figure};

const DIRECTORY: &str = "target/reproduction";
const NAME: &str = "reproduction.md";
const PICTURE: &str = "reproduction.svg";

const NOTE: &str = "No experiment was made: the water channel is replaced by a stand-in, the numerical model plus stall plus added mass. \
    A claim about experiments can therefore be reproduced in kind at most, and what was fitted counts for nothing: the plant to rows 1 \
    of Table 3 and 0 of Table 5, the stand-in to the best designs of Tables 3 and 5, the weights of the costs to both tables, in Table 3 \
    with the costs at both ends. What leads from one fitted end to the other is called partly calibrated and does not count as reproduced: neither do flights there, \
    though they were not fitted one by one, because the cost that they add up to was (Figures 16 to 18 and 24).";

const CASES: &str = "In the column of the one plant the cases are the campaigns without noise and with every seed of it, or what a row says. By chance: 64 designs \
    spread over the box, flown as the end of the loop is. Claims of Chapter 6 are judged twice, with the truth that the dissertation flies, the \
    model with stall, and with the stand-in, which is ours and harder.";

const CLAIM_CAPTION: &str = "Every contribution, section, table and figure that says something of results, with what the latest run found. \
    Commands go after `cargo xtask`. Over the ensemble: in how many plants that meet the published numbers, and in how many of their \
    campaigns, in still and in moving water.";
const OF_ENSEMBLE: &str = "More of the ensemble is on [its page](results-ensemble.md).";

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
        self.claims.iter().find(|over| over.is_of(claim))
    }

    /// Those that no chapter has.
    fn alone<'a>(&'a self, listed: &'a [Listed<'_>]) -> impl Iterator<Item = &'a OverEnsemble> {
        self.claims.iter().filter(move |over| !listed.iter().any(|one| over.is_of(one.claim)))
    }
}

impl OverEnsemble {
    /// Whether a chapter judges the same; both fly the stand-in but where they name the printed truth.
    fn is_of(&self, claim: &Claim) -> bool {
        let is_printed = [self.truth, claim.truth].map(|truth| truth == Truth::Printed);
        self.place == claim.place && self.says == claim.says && is_printed[0] == is_printed[1]
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
    let mut chapters = chosen.into_iter().map(read).collect::<Result<Vec<_>>>()?;
    let all_levels = AllLevels::read(root)?;
    let of_chapter6 = chapters.iter_mut().filter(|chapter| chapter.study.command == chapter6::CHAPTER.command);
    let claims = of_chapter6.flat_map(|chapter| &mut chapter.handover.claims);
    let n_overruled = claims.map(|claim| all_levels.overrule(claim)).filter(|is_other| *is_other).count();
    let mut listed: Vec<Listed<'_>> = chapters
        .iter()
        .flat_map(|chapter| chapter.handover.claims.iter().map(move |claim| Listed { claim, chapter }))
        .collect();
    listed.sort_by(|a, b| a.claim.place.cmp(&b.claim.place));
    let places = listed.iter().map(|one| &one.claim.place).chain(over.claims.iter().map(|over| &over.place));
    exemptions::check(places)?;
    let out = root.join(DIRECTORY);
    let picture = verdicts(&chapters);
    let first = first_screen(&listed, &over, n_overruled, &picture);
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
    let kinds = Verdict::ALL.map(|verdict| (verdict.to_string(), verdict.color()));
    let count = |chapter: &Chapter<'_>, verdict: Verdict| {
        chapter.handover.claims.iter().filter(|claim| claim.verdict == verdict).count()
    };
    let bars = chapters.iter().map(|chapter| {
        let counts = Verdict::ALL.iter().map(|verdict| count(chapter, *verdict)).collect();
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
        caption: "A box for each claim, by the study that looked at it and by what became of it; gray ones count for nothing: \
                  chance meets them too, they were fitted or put in, or they could not fail."
            .to_owned(),
    }
}

/// What the pages begin with: how many claims came out, the contributions with their numbers, and all verdicts at once.
fn first_screen<'a>(listed: &[Listed<'_>], over: &Over, n_overruled: usize, picture: &'a Picture) -> FirstScreen<'a> {
    let contributions = listed.iter().filter(|one| matches!(one.claim.place, Place::Contribution(_)));
    let contributions = contributions.map(|one| claims::finding(one.claim));
    let head = Finding::new("The contributions that the dissertation names:");
    let head_over = Finding::new(
        "The same over an ensemble of plants that meet the published numbers, a cloud about one start, of which the one plant of the chapters is the middle:",
    );
    let over = over.counts.iter().map(|words| Finding::new(words.clone())).fold(head_over, Finding::detail);
    let few = few_words(listed.iter().map(|one| one.claim));
    let few = Finding::new(format!(
        "{few} Chapter 6 is run with fewer levels here; {n_overruled} of its claims come to another word with [all 24⁴ designs]\
         (results-chapter6-full.md), and count as they do there ([both counts, claim by claim]\
         (results-chapter6-full.md#with-fewer-levels-and-with-all))."
    ));
    FirstScreen { findings: vec![counts(listed), few, over, contributions.fold(head, Finding::detail)], picture }
}

/// Whether a study has claims of the dissertation.
fn is_chapter(study: &Reproduction) -> bool {
    study.has_claims
}

/// All claims of the chapters with what became of each over the ensemble, and those of the ensemble alone, by place.
fn table(listed: &[Listed<'_>], over: &Over) -> Table {
    let mut table = claims::table_with_commands(listed.iter().map(|one| (one.claim, one.chapter.study.command)));
    table.columns.push(Column::new("Over the ensemble", ""));
    let words = listed.iter().map(|one| match over.of(one.claim) {
        None => "–".to_owned(),
        Some(over) if over.flown == one.chapter.study.title => over.words.clone(),
        Some(over) => format!("on the campaigns of {}: {}", over.flown, over.words),
    });
    table.rows.iter_mut().zip(words).for_each(|(row, words)| row.push(words));
    let mut rows: Vec<(Place, Vec<String>)> =
        listed.iter().map(|one| one.claim.place.clone()).zip(std::mem::take(&mut table.rows)).collect();
    rows.extend(over.alone(listed).map(|over| {
        let [command, none] = [COMMAND_OF_ENSEMBLE, "–"].map(str::to_owned);
        (
            over.place.clone(),
            vec![over.place.to_string(), over.truth.after(&over.says), none, command, over.words.clone()],
        )
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
    let twice = claims.clone().filter(|claim| claim.truth == Truth::StandIn).count();
    let twice = match twice {
        0 => String::new(),
        n => format!(" ({n} of them those of Chapter 6 a second time, with our stand-in)"),
    };
    format!(
        "Of {} claims{twice} {} reproduced, {} in kind, {} in part, and {} not. The others do not count: {} not discriminate, {} partly \
         calibrated, {} calibrated, {}, and {}.",
        claims.clone().count(),
        counted(count(Verdict::Reproduced), ["is", "are"]),
        count(Verdict::InKind),
        count(Verdict::InPart),
        count(Verdict::NotReproduced),
        counted(count(Verdict::NotDiscriminating), ["does", "do"]),
        counted(count(Verdict::PartlyCalibrated), ["was", "were"]),
        count(Verdict::Calibrated),
        counted(count(Verdict::TakenOver), ["is an input", "are inputs"]),
        counted(count(Verdict::Check), ["is a check", "are checks"])
    )
}

/// How much the verdicts that count rest on: few cases make strong words easily.
fn few_words<'a>(claims: impl Iterator<Item = &'a Claim>) -> String {
    let cases: Vec<usize> =
        claims.filter(|claim| claim.verdict.counts()).filter_map(|claim| Some(claim.judged?.count.cases)).collect();
    let one = cases.iter().filter(|n| **n == 1).count();
    let few = cases.iter().filter(|n| (2..10).contains(*n)).count();
    format!("Of the {} that count {one} rest on a single case and {few} on two to nine.", cases.len())
}

fn counts(listed: &[Listed<'_>]) -> Finding {
    let finding = Finding::new(count_words(listed.iter().map(|one| one.claim)));
    Verdict::ALL.into_iter().fold(finding, |finding, verdict| {
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
            picture.caption.push_str(&format!(" {}: “{}”: {}.", claim.place, claim.words(), claim.verdict));
        }
        Ok(picture)
    };
    first.show_in(&mut page);
    page.paragraph(NOTE);
    page.paragraph(rules::WORDS_HEAD);
    page.list(&rules::words().iter().map(|(word, meaning)| format!("{word}: {meaning}")).collect::<Vec<_>>());
    page.paragraph(CASES);
    page.heading("The pages");
    page.links(&studies.iter().map(|study| link(root, study)).collect::<Vec<_>>());
    page.heading("Claim by claim");
    page.prose_table(&table(listed, over), CLAIM_CAPTION, &WIDTHS_PCT);
    page.paragraph(claims::FOUND);
    claims::found(listed.iter().map(|one| one.claim)).iter().for_each(|finding| page.finding(finding));
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
         {NOTE}\n\n## The rule for each word\n\n{}\n{CASES}\n\n## Claim by claim\n\n{CLAIM_CAPTION} {OF_ENSEMBLE}\n\n{}\n{}\n\n{}\n\
         ## Without a claim\n\n{EXEMPT_CAPTION}\n\n{}",
        rules::words_markdown(),
        table(listed, over).markdown(),
        claims::FOUND,
        claims::markdown(&claims::found(listed.iter().map(|one| one.claim))),
        exemptions::table().markdown()
    )
}

#[expect(clippy::print_stdout, reason = "the result of the command")]
fn print(listed: &[Listed<'_>]) {
    println!("\nWhat of the dissertation comes out\n");
    for Listed { claim, .. } in listed {
        println!("{:22} {:19} {}", claim.place.to_string(), claim.verdict.to_string(), claim.words());
    }
    println!("\n{}\nOne page over all: {DIRECTORY}/index.html", counts(listed).sentence());
}

#[cfg(test)]
mod tests {
    use super::*;

    fn claims(verdicts: &[Verdict]) -> Vec<Claim> {
        verdicts.iter().map(|verdict| Claim::given(Place::Table(1), "it", *verdict, String::new())).collect()
    }

    #[test]
    fn counts_follow_their_numbers() {
        use Verdict::{
            Calibrated, Check, InKind, NotDiscriminating, NotReproduced, PartlyCalibrated, Reproduced, TakenOver,
        };
        let one = claims(&[
            Reproduced,
            InKind,
            InKind,
            NotReproduced,
            NotDiscriminating,
            PartlyCalibrated,
            Calibrated,
            TakenOver,
            Check,
        ]);
        assert_eq!(
            count_words(one.iter()),
            "Of 9 claims 1 is reproduced, 2 in kind, 0 in part, and 1 not. The others do not count: 1 does not discriminate, 1 was partly \
             calibrated, 1 calibrated, 1 is an input, and 1 is a check."
        );
        let mut two = claims(&[Reproduced, Reproduced, PartlyCalibrated, PartlyCalibrated, TakenOver, TakenOver]);
        two[0].truth = Truth::StandIn;
        assert_eq!(
            count_words(two.iter()),
            "Of 6 claims (1 of them those of Chapter 6 a second time, with our stand-in) 2 are reproduced, 0 in kind, 0 in part, and 0 not. \
             The others do not count: 0 do not discriminate, 2 were partly calibrated, 0 calibrated, 2 are inputs, and 0 are checks."
        );
    }

    #[test]
    fn the_counts_of_the_committed_page_are_those_of_its_table() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/reproduction.md");
        let page = std::fs::read_to_string(path).expect("the committed page");
        let rows = page.lines().filter(|line| line.starts_with("| ") && line.contains("| `reproduce-"));
        let cells: Vec<&str> = rows.filter_map(|row| row.split(" | ").nth(2)).filter(|cell| *cell != "–").collect();
        let claims: Vec<Verdict> = cells
            .iter()
            .map(|cell| {
                let word = cell.split(':').next().unwrap_or_default();
                *Verdict::ALL.iter().find(|verdict| verdict.to_string() == word).expect("a word of the rules")
            })
            .collect();
        let count = |verdict: Verdict| claims.iter().filter(|one| **one == verdict).count();
        let head = page.lines().find(|line| line.starts_with("- Of ")).expect("the counts");
        assert!(head.starts_with(&format!("- Of {} claims", claims.len())), "{head}");
        for (verdict, words) in [
            (Verdict::InKind, "in kind,"),
            (Verdict::InPart, "in part, and"),
            (Verdict::NotReproduced, "not. The others"),
        ] {
            assert!(head.contains(&format!(" {} {words}", count(verdict))), "{verdict}: {head}");
        }
        let others = claims.iter().filter(|verdict| !verdict.counts()).count();
        assert!(others > 0 && head.contains(&format!("{} d", count(Verdict::NotDiscriminating))), "{head}");
    }

    #[test]
    fn the_ensemble_has_a_claim_of_chapter_6_with_the_stand_in_once() {
        let over = OverEnsemble {
            place: Place::Table(1),
            flown: "Chapter 4",
            says: "it".to_owned(),
            truth: Truth::Unnamed,
            words: String::new(),
        };
        let mut claims = claims(&[Verdict::InKind, Verdict::InKind]);
        claims[0].truth = Truth::Printed;
        claims[1].truth = Truth::StandIn;
        assert_eq!(claims.iter().map(|claim| over.is_of(claim)).collect::<Vec<_>>(), [false, true]);
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
