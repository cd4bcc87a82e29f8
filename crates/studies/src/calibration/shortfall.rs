//! What a search says that ended with fewer plants than were asked for: why starts were refused, and the best miss row by row.

use anyhow::{Error, Result, anyhow};

use super::evidence::Found;
use super::file::Calibration;
use super::fit::MET;
use super::outcome::{Refusal, Start};
use super::store::Store;

/// The refused start that came nearest: of those that do not meet the evidence the one with the least of largest residuals, else
/// the first that was refused for what the whole box shows.
fn nearest(starts: &[Start]) -> Option<&Start> {
    let of = |refusal: Refusal| starts.iter().filter(move |start| start.refusal == Some(refusal));
    let key = |start: &&Start| start.worst.unwrap_or(f64::INFINITY);
    let not_met = of(Refusal::NotMet).min_by(|a, b| key(a).total_cmp(&key(b)));
    not_met.or_else(|| of(Refusal::OtherOptimum).chain(of(Refusal::FailsInBox)).next())
}

/// The error that ends the search; the nearest start is fitted once more to say where its fit ends.
pub(super) fn shortfall(calibration: &Calibration, store: &Store) -> Result<Error> {
    let mut text = format!(
        "{} of {} plants after {} starts, and `most_starts` allows no more; {}",
        store.members.len(),
        calibration.n_members,
        store.starts.len(),
        refusals(&store.starts)
    );
    match nearest(&store.starts) {
        Some(start) => {
            let rows = calibration.try_start(start.number, calibration.reach)?.rows;
            let words = start.refusal.map_or("", Refusal::words);
            text += &format!("\nThe nearest of them is start {} ({words}):\n\n", start.number);
            text += &table(&rows);
            text += &format!("\nA fit has met a row within {MET} of what is allowed. ");
        }
        None => text += ", and none came as far as the evidence. ",
    }
    text += "Widen ranges, `reach` or `tolerance` in fixtures/bat/calibration.toml, or raise `most_starts`; no page was written";
    Ok(anyhow!(text))
}

fn refusals(starts: &[Start]) -> String {
    let counts = Refusal::ALL.into_iter().filter_map(|refusal| {
        let count = starts.iter().filter(|start| start.refusal == Some(refusal)).count();
        (count > 0).then(|| format!("{count}: {}", refusal.words()))
    });
    let counts: Vec<String> = counts.collect();
    if counts.is_empty() {
        "none of them was refused".to_owned()
    } else {
        format!("refused were {}", counts.join("; "))
    }
}

/// The rows one below the other.
fn table(rows: &[Found]) -> String {
    let head = ["evidence", "published", "nearest", "allowed", "away by", ""].map(str::to_owned);
    let lines = rows.iter().map(|row| {
        let Found { label, what, printed, found, allowed } = row;
        let away = (found - printed).abs();
        let verdict = if away <= *allowed { "" } else { "missed" };
        let digits = |value: f64| format!("{value:.3}");
        [
            format!("{label}: {what}"),
            printed.to_string(),
            digits(*found),
            digits(*allowed),
            digits(away),
            verdict.to_owned(),
        ]
    });
    let lines: Vec<[String; 6]> = std::iter::once(head).chain(lines).collect();
    let width = |k: usize| lines.iter().map(|line| line[k].chars().count()).max().unwrap_or(0);
    let widths: [usize; 6] = core::array::from_fn(width);
    let line = |line: &[String; 6]| {
        let [label, numbers @ .., verdict] = line;
        let mut text = format!("  {label:0$}", widths[0]);
        for (number, width) in numbers.iter().zip(&widths[1..]) {
            text += &format!("  {number:>width$}");
        }
        format!("{text}  {verdict}").trim_end().to_owned() + "\n"
    };
    lines.iter().map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn start(number: u64, refusal: Refusal, worst: Option<f64>) -> Start {
        Start { number, refusal: Some(refusal), worst }
    }

    #[test]
    fn nearest_is_the_one_that_misses_least() {
        let starts = [
            start(0, Refusal::CannotFly, None),
            start(1, Refusal::FailsInBox, Some(0.1)),
            start(2, Refusal::NotMet, Some(3.0)),
            start(3, Refusal::NotMet, Some(2.0)),
            Start { number: 4, refusal: None, worst: Some(0.2) },
        ];
        let number = |starts: &[Start]| nearest(starts).map(|start| start.number);
        assert_eq!(number(&starts), Some(3));
        assert_eq!(number(&starts[..2]), Some(1));
        assert_eq!(number(&starts[..1]), None);
    }

    #[test]
    fn rows_stand_below_each_other() {
        let row = |what, printed, found, allowed| Found { label: "Table 3".to_owned(), what, printed, found, allowed };
        let text = table(&[row("pitch set point, deg", 17.3, 17.0, 1.0), row("cost, s", 1.5, 4.123_4, 0.03)]);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], "  evidence                       published  nearest  allowed  away by");
        assert_eq!(lines[1], "  Table 3: pitch set point, deg       17.3   17.000    1.000    0.300");
        assert_eq!(lines[2], "  Table 3: cost, s                     1.5    4.123    0.030    2.623  missed");
    }

    /// A search whose evidence no plant can meet ends with an error that has every row, and writes no page.
    #[test]
    fn evidence_that_cannot_be_met_ends_with_the_best_miss() {
        let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let folder = tempfile::tempdir().expect("a folder");
        let bat = folder.path().join("fixtures/bat");
        std::fs::create_dir_all(&bat).expect("a folder");
        for name in ["rig.toml", "test-profile.toml", "cost-chapter4.toml", "cost-chapter7.toml"] {
            std::fs::copy(root.join("fixtures/bat").join(name), bat.join(name)).expect("a copy");
        }
        let text = std::fs::read_to_string(root.join("fixtures/bat/calibration.toml")).expect("a file");
        let mut table: toml::Table = text.parse().expect("a file");
        // One number is free, two plants are asked for, of two starts; the cost is one that none has.
        let rows = |key: &str, keep: fn(&toml::Value) -> bool| -> toml::Value {
            table[key].as_array().expect("rows").iter().filter(|row| keep(row)).cloned().collect::<Vec<_>>().into()
        };
        let free = rows("free", |row| row["key"].as_str() == Some("plant.hull.lift_slope"));
        let mut evidence = rows("evidence", |row| row["fidelity"].as_str() == Some("stand-in"));
        evidence[0]["cost"] = 1.5.into();
        for (key, value) in [("members", 2.into()), ("most_starts", 2.into()), ("free", free), ("evidence", evidence)] {
            table.insert(key.to_owned(), value);
        }
        std::fs::write(bat.join("calibration.toml"), table.to_string()).expect("written");
        // The second time the starts are known.
        let first = super::super::run(folder.path()).expect_err("no plant").to_string();
        let second = super::super::run(folder.path()).expect_err("no plant").to_string();
        assert_eq!(first, second);
        let words = [
            "0 of 2 plants after 2 starts",
            "2: evidence not met",
            "Table 3, row 1: the experiment there: cost, s",
            "1.5",
            "missed",
        ];
        assert!(words.iter().all(|word| first.contains(word)), "{first}");
        let error = format!("{:#}", super::super::write_page(folder.path()).expect_err("no page"));
        assert!(error.contains("0 plants of 2") && error.contains("cargo xtask calibrate"), "{error}");
        assert!(!folder.path().join("docs").exists());
    }
}
