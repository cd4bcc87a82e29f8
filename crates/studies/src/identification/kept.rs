//! The flights that a check needs, kept with the sources: it takes them over and flies some of them anew.
//!
//! Whoever identifies flies all that is reported, and keeps what a check is going to need.

use std::path::Path;

use anyhow::{Context as _, Result};
use water_channel::{CostBreakdown, N_TERMS};

use super::file::Study;
use super::flights::{Flown, Pair};
use super::plant::Doubted;
use super::store::REMEDY;
use crate::blind;
use crate::costs::key::Key;
use crate::costs::line::{FAILED, in_a_line, numbers};
use crate::kept::{KeptFile, SAMPLE};

const FILE: &str = "flights.tsv";

/// Pairs that stand for the program.
const N_PROBES: usize = 8;

/// A flight as it is kept.
type Row = ([Vec<f64>; 2], Flown);

/// The file of a folder. `key` names what campaigns follow from; plant, controller and integration of this program are in the key of
/// the flights by what they make of some pairs.
pub(super) fn file(folder: &Path, study: &Study, key: &str) -> Result<KeptFile> {
    let designs = blind::points(study.setup.problem.region(), N_PROBES);
    let unknowns = blind::points(study.unknowns.region(), N_PROBES);
    let with_unknowns = unknowns.iter().zip(&designs).map(|(unknowns, design)| (&unknowns[..], &design[..]));
    let of_start = designs.iter().map(|design| (study.unknowns.start(), &design[..]));
    let of_stand_in = designs.iter().map(|design| (&[][..], &design[..]));
    let pairs: Vec<Pair<'_>> = of_stand_in.chain(of_start).chain(with_unknowns).collect();
    let mut key = Key::default().with(key);
    for flown in Doubted(study).fly_anew(&pairs) {
        key = match flown {
            Ok(cost) => key.with(serde_json::to_string(&cost)?),
            Err(_) => key.with("failed"),
        };
    }
    Ok(KeptFile { path: folder.join(FILE), key: key.name(), remedy: REMEDY })
}

/// Has a study know what is kept, if it is what this program flies: of every so many flights one is flown anew, and has to come out
/// the same bit for bit.
pub(super) fn take_over(file: &KeptFile, study: &Study) -> Result<()> {
    let Some(rows) = file.rows()? else { return Ok(()) };
    let rows = read(&rows).with_context(|| format!("{}; {REMEDY}", file.path.display()))?;
    let sample: Vec<&Row> = rows.iter().step_by(SAMPLE).collect();
    let pairs: Vec<Pair<'_>> = sample.iter().map(|([unknowns, design], _)| (&unknowns[..], &design[..])).collect();
    for ((pair, flown), anew) in sample.iter().zip(Doubted(study).fly_anew(&pairs)) {
        file.ensure_same(&format!("the flight of {pair:?}"), flown, &anew.map_err(|words| in_a_line(&words)))?;
    }
    for ([unknowns, design], flown) in rows {
        study.flights.know((&unknowns, &design), flown);
    }
    Ok(())
}

/// Keeps what a study knows in the place of what was kept.
pub(super) fn keep(file: &KeptFile, study: &Study) -> Result<()> {
    file.write(&lines(&study.flights.all()))
}

/// Numbers as they were.
fn read_numbers(text: &str) -> Option<Vec<f64>> {
    if text.is_empty() { Some(Vec::new()) } else { text.split(' ').map(|x| x.parse().ok()).collect() }
}

/// A line of unknowns, below it a line for each design that was flown with them: the design, a tabulator, and the cost with its terms
/// or the reason why there is none.
fn lines(rows: &[Row]) -> String {
    let mut text = String::new();
    let mut last: Option<&[f64]> = None;
    for ([unknowns, design], flown) in rows {
        if last != Some(unknowns) {
            text += &format!("{}\n", numbers(unknowns));
            last = Some(unknowns);
        }
        let flown = match flown {
            Ok(cost) => format!("{} {}", cost.total, numbers(&cost.terms)),
            Err(words) => format!("{FAILED}{}", in_a_line(words)),
        };
        text += &format!("{}\t{flown}\n", numbers(design));
    }
    text
}

fn read(text: &str) -> Result<Vec<Row>> {
    let mut unknowns = Vec::new();
    let mut rows = Vec::new();
    for (line, number) in text.lines().zip(2..) {
        let row = match line.split_once('\t') {
            None => read_numbers(line).map(|read| unknowns = read),
            Some((design, flown)) => read_numbers(design)
                .zip(read_flown(flown))
                .map(|(design, flown)| rows.push(([unknowns.clone(), design], flown))),
        };
        row.with_context(|| format!("line {number} is no flight"))?;
    }
    Ok(rows)
}

fn read_flown(text: &str) -> Option<Flown> {
    if let Some(words) = text.strip_prefix(FAILED) {
        return Some(Err(words.to_owned()));
    }
    let values = read_numbers(text)?;
    let (total, terms) = values.split_first()?;
    let terms: [f64; N_TERMS + 1] = terms.try_into().ok()?;
    Some(Ok(CostBreakdown { total: *total, terms }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn study() -> Study {
        Study::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")).expect("a study")
    }

    /// The second design has a center of mass at which nothing flies.
    const DESIGNS: [[f64; 2]; 3] = [[48.0, 12.0], [90.0, 12.0], [49.0, 0.1 + 0.2]];

    fn pairs(study: &Study) -> [Pair<'_>; 4] {
        let start = study.unknowns.start();
        [(&[], &DESIGNS[0]), (start, &DESIGNS[0]), (start, &DESIGNS[1]), (start, &DESIGNS[2])]
    }

    fn bits(flown: &[Flown]) -> Vec<Result<Vec<u64>, String>> {
        let of = |cost: CostBreakdown| [&[cost.total], &cost.terms[..]].concat().iter().map(|x| x.to_bits()).collect();
        flown.iter().map(|flown| flown.clone().map(of)).collect()
    }

    #[test]
    fn flights_are_taken_over_as_they_were_kept() {
        let (folder, study) = (tempfile::tempdir().expect("a folder"), study());
        let kept = file(folder.path(), &study, "abc").expect("a key");
        let pairs = pairs(&study);
        take_over(&kept, &study).expect("nothing is kept");
        let flown = Doubted(&study).fly(&pairs);
        assert_eq!((study.flights.n_flown(), flown[0] == flown[1], flown[2].is_err()), (4, false, true), "{flown:?}");
        keep(&kept, &study).expect("written");
        for (key, n_flown) in [("abc", 0), ("abd", 4)] {
            let other = self::study();
            take_over(&file(folder.path(), &other, key).expect("a key"), &other)
                .expect("the same, or nothing of today");
            assert_eq!(bits(&Doubted(&other).fly(&pairs)), bits(&flown));
            assert_eq!(other.flights.n_flown(), n_flown, "{key}");
        }
    }

    /// Whoever changes a number by hand, sum and all, and whoever spoils a line.
    #[test]
    fn a_flipped_digit_and_a_line_without_sense_are_noticed() {
        let (folder, study) = (tempfile::tempdir().expect("a folder"), study());
        let kept = file(folder.path(), &study, "abc").expect("a key");
        Doubted(&study).fly(&pairs(&study));
        keep(&kept, &study).expect("written");
        let rows = kept.rows().expect("a file").expect("rows");
        let refused = |rows: &str| {
            kept.write(rows).expect("written");
            format!("{:#}", take_over(&kept, &study).expect_err("it was changed"))
        };
        // The first flight is one of the sample; its cost begins the second column.
        let (before, after) = rows.split_once('\t').expect("a column");
        let flipped = format!("{before}\t{}{}", if after.starts_with('1') { '2' } else { '1' }, &after[1..]);
        let error = refused(&flipped);
        assert!(error.contains("[48.0, 12.0]") && error.contains("this program finds"), "{error}");
        let error = refused(&format!("{before}\tfailed to fly\n"));
        assert!(error.contains("flights.tsv") && error.contains("this program finds"), "{error}");
        let error = refused(&rows.replacen('\t', "\tx", 1));
        assert!(error.contains("line 3 is no flight") && error.contains("cargo xtask identify"), "{error}");
    }

    #[test]
    fn a_line_comes_back_bit_for_bit() {
        let cost = CostBreakdown { total: 0.1 + 0.2, terms: [1e-300, -0.0, 1.0, 2.5, 0.1 + 0.7, 1e-17, 3.0] };
        let (none, some) = (Vec::new(), vec![0.1 + 0.7, -0.0]);
        let rows: Vec<Row> = vec![
            ([none.clone(), vec![48.0, 12.0]], Ok(cost)),
            ([some.clone(), vec![48.0, -0.0]], Err(in_a_line("a line\twent\nslack"))),
            ([some, vec![48.0, 0.1 + 0.2]], Ok(cost)),
        ];
        let text = lines(&rows);
        assert_eq!(text.lines().count(), 5, "unknowns stand once: {text}");
        assert_eq!(format!("{:?}", read(&text).expect("rows")), format!("{rows:?}"));
        assert_eq!(rows[1].1, Err("a line went slack".to_owned()));
    }
}
