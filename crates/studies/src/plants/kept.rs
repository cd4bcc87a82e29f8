//! The costs on the rigs that a check needs, kept with the sources: it takes them over and finds some of them anew.
//!
//! Whoever runs campaigns, or writes the page, finds all costs anew.

use std::path::Path;

use anyhow::{Context as _, Result};
use design_space::Cell;

use super::case::Case;
use crate::costs::Cost;
use crate::costs::key::Key;
use crate::costs::line::{FAILED, in_a_line};
use crate::kept::{KeptFile, SAMPLE};

const REMEDY: &str = "take it back from version control, or remove it and run `cargo xtask plants`";

/// Designs of a case that stand for the program.
const N_PROBES: u64 = 24;

/// The file, and what it must be made from: the cells, and what this program makes of some of them.
pub(super) fn file(path: &Path, cases: &[Case]) -> Result<KeptFile> {
    let mut key = Key::default();
    for case in cases {
        key = key.with(case.name).with(serde_json::to_string(&case.region)?);
        for cost in case.anew(&case.cells(N_PROBES))? {
            key = match cost {
                Ok(cost) => key.with(cost.to_le_bytes()),
                Err(_) => key.with("failed"),
            };
        }
    }
    Ok(KeptFile { path: path.to_path_buf(), key: key.name(), remedy: REMEDY })
}

/// Has cases know what is kept, if it is what this program finds: of every so many designs one is flown or driven anew, and has to
/// cost the same bit for bit.
pub(super) fn take_over(file: &KeptFile, cases: &[Case]) -> Result<()> {
    let Some(rows) = file.rows()? else { return Ok(()) };
    let of_cases = read(&rows, cases).with_context(|| format!("{}; {REMEDY}", file.path.display()))?;
    for (case, rows) in cases.iter().zip(of_cases) {
        let sample: Vec<&(Cell, Cost)> = rows.iter().step_by(SAMPLE).collect();
        let cells: Vec<Cell> = sample.iter().map(|(cell, _)| *cell).collect();
        for ((cell, cost), anew) in sample.into_iter().zip(case.anew(&cells)?) {
            let what = || format!("the cost of {} at {:?}", case.name, case.grid.point(*cell).unwrap_or_default());
            file.ensure_same(&what(), cost, &anew.map_err(|words| in_a_line(&words)))?;
        }
        rows.into_iter().for_each(|(cell, cost)| case.costs.know(cell, cost));
    }
    Ok(())
}

/// Keeps what cases know in the place of what was kept.
pub(super) fn keep(file: &KeptFile, cases: &[Case]) -> Result<()> {
    file.write(&cases.iter().map(|case| lines(case.name, &case.costs.all())).collect::<String>())
}

/// A line with the name of a case, below it a line for each design: its cell, a tabulator, and the cost or the reason why there is none.
fn lines(name: &str, costs: &[(Cell, Cost)]) -> String {
    let line = |(cell, cost): &(Cell, Cost)| match cost {
        Ok(cost) => format!("{}\t{cost}\n", cell.index()),
        Err(words) => format!("{}\t{FAILED}{}\n", cell.index(), in_a_line(words)),
    };
    std::iter::once(format!("{name}\n")).chain(costs.iter().map(line)).collect()
}

/// The rows of each case.
fn read(text: &str, cases: &[Case]) -> Result<Vec<Vec<(Cell, Cost)>>> {
    let mut of_cases = vec![Vec::new(); cases.len()];
    let mut case = None;
    for (line, number) in text.lines().zip(2..) {
        let words = || format!("line {number} is no design of a case");
        match line.split_once('\t') {
            None => case = Some(cases.iter().position(|case| case.name == line).with_context(words)?),
            Some((cell, cost)) => {
                let row = cell.parse().ok().map(Cell::new).zip(read_cost(cost)).with_context(words)?;
                of_cases[case.with_context(words)?].push(row);
            }
        }
    }
    Ok(of_cases)
}

fn read_cost(text: &str) -> Option<Cost> {
    match text.strip_prefix(FAILED) {
        Some(words) => Some(Err(words.to_owned())),
        None => text.parse().ok().map(Ok),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plants::case::N_CASES;

    fn cases() -> [Case; N_CASES] {
        Case::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")).expect("the cases")
    }

    fn bits(cost: &Cost) -> Result<u64, String> {
        cost.clone().map(f64::to_bits)
    }

    /// What the cases cost at three cells, and the file that keeps it.
    fn kept(folder: &Path) -> (KeptFile, [Case; N_CASES], Vec<Cost>) {
        let cases = cases();
        let file = file(&folder.join("costs.tsv"), &cases).expect("a key");
        let costs = costs_of(&cases);
        keep(&file, &cases).expect("written");
        (file, cases, costs)
    }

    fn costs_of(cases: &[Case]) -> Vec<Cost> {
        cases.iter().flat_map(|case| case.on_the_rig(&case.cells(3)).expect("costs")).collect()
    }

    #[test]
    fn costs_are_taken_over_as_they_were_kept() {
        let folder = tempfile::tempdir().expect("a folder");
        let (file, _, costs) = kept(folder.path());
        assert!(costs.iter().any(Result::is_ok));
        for (key, n_made) in [(file.key.clone(), 0), ("another".to_owned(), 3)] {
            let others = cases();
            take_over(&KeptFile { key, ..file_of(&file) }, &others).expect("the same, or nothing of today");
            assert_eq!(
                costs_of(&others).iter().map(bits).collect::<Vec<_>>(),
                costs.iter().map(bits).collect::<Vec<_>>()
            );
            assert_eq!(others.map(|case| case.costs.n_made()), [n_made; N_CASES]);
        }
    }

    fn file_of(file: &KeptFile) -> KeptFile {
        KeptFile { path: file.path.clone(), key: file.key.clone(), remedy: file.remedy }
    }

    /// Whoever changes a number by hand, sum and all, and whoever spoils a line. The first cost of each case is one of the sample.
    #[test]
    fn a_flipped_digit_and_a_line_without_sense_are_noticed() {
        let folder = tempfile::tempdir().expect("a folder");
        let (file, cases, costs) = kept(folder.path());
        let rows = file.rows().expect("a file").expect("rows");
        let refused = |from: &str, to: &str| {
            assert!(rows.contains(from), "{rows}");
            file.write(&rows.replacen(from, to, 1)).expect("written");
            format!("{:#}", take_over(&file, &cases).expect_err("it was changed"))
        };
        for (case, cost) in cases.iter().zip(costs.iter().step_by(3)) {
            let cost = cost.as_ref().expect("a cost");
            let error = refused(&cost.to_string(), &(cost * (1.0 + 1e-14)).to_string());
            assert!(error.contains(case.name) && error.contains("this program finds"), "{error}");
            let error = refused(&cost.to_string(), "failed to go");
            assert!(error.contains(case.name) && error.contains("this program finds"), "{error}");
        }
        let error = refused("\n0\t", "\nx\t");
        assert!(error.contains("costs.tsv") && error.contains("line 3") && error.contains("xtask plants"), "{error}");
        let error = refused("suspension\n", "suspensions\n");
        assert!(error.contains("line 6 is no design of a case"), "{error}");
    }

    #[test]
    fn a_line_comes_back_bit_for_bit() {
        let costs = [(Cell::new(3), Ok(0.1 + 0.2)), (Cell::new(7), Err("a strut\tat\nits end".to_owned()))];
        let text = lines("suspension", &costs);
        assert_eq!(text.lines().count(), 3, "{text}");
        let [turbine, suspension, formula] = &read(&text, &cases()).expect("rows")[..] else { panic!("three cases") };
        assert!(turbine.is_empty() && formula.is_empty());
        assert_eq!(suspension[0], costs[0]);
        assert_eq!(suspension[1].1, Err("a strut at its end".to_owned()));
    }
}
