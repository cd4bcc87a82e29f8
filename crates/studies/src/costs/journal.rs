//! A file of flown costs, which only grows: a line for each point.

use std::fs::{File, OpenOptions};
use std::io::{Read as _, Write as _};
use std::path::{Path, PathBuf};

use super::cost::{Failure, Flown, Kind};
use super::line::{FAILED, in_a_line, numbers};

/// A point with its cost.
pub(crate) type FlownPoint = (Vec<f64>, Flown);

/// The end of a file of costs.
///
/// A line is a point, its numbers parted by blanks, a tabulator, and the cost or the kind of its failure and the words
/// for people. Lines come in any order; what a killed process leaves of a line is cut off by the next one.
#[derive(Debug)]
pub(super) struct Journal {
    path: PathBuf,
    file: File,
}

impl Journal {
    /// Opens a file to go on with it, with the points that it knows. Lines that make no sense are as good as not there.
    pub(super) fn open(path: &Path) -> std::io::Result<(Self, Vec<FlownPoint>)> {
        let mut file = OpenOptions::new().read(true).append(true).create(true).open(path)?;
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes)?;
        let whole = bytes.iter().rposition(|byte| *byte == b'\n').map_or(0, |end| end + 1);
        file.set_len(whole as u64)?;
        Ok((Self { path: path.to_owned(), file }, read_lines(&bytes[..whole])))
    }

    /// Writes costs down. Who cannot write flies again next time, so a failure is only said.
    pub(super) fn add<'a>(&mut self, costs: impl IntoIterator<Item = (&'a [f64], &'a Flown)>) {
        let lines: String = costs.into_iter().map(|(point, cost)| line(point, cost)).collect();
        if let Err(error) = self.file.write_all(lines.as_bytes()) {
            eprintln!("warning: {}: {error}; these flights will not be remembered", self.path.display());
        }
    }
}

/// The points that a file knows, which is left as it is; none where there is none.
#[cfg(feature = "global")]
pub(crate) fn read(path: &Path) -> std::io::Result<Vec<FlownPoint>> {
    match std::fs::read(path) {
        Ok(bytes) => Ok(read_lines(&bytes)),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(Vec::new()),
        Err(error) => Err(error),
    }
}

fn read_lines(bytes: &[u8]) -> Vec<FlownPoint> {
    String::from_utf8_lossy(bytes).lines().filter_map(read_line).collect()
}

fn line(point: &[f64], cost: &Flown) -> String {
    let point = numbers(point);
    match cost {
        Ok(cost) => format!("{point}\t{cost}\n"),
        Err(Failure { kind, words }) => {
            format!("{point}\t{FAILED}{}: {}\n", kind.name(), in_a_line(words))
        }
    }
}

fn read_line(line: &str) -> Option<FlownPoint> {
    let (point, cost) = line.split_once('\t')?;
    let cost = match cost.strip_prefix(FAILED) {
        Some(failure) => {
            let (kind, words) = failure.split_once(": ")?;
            Err(Failure { kind: Kind::of_name(kind)?, words: words.to_owned() })
        }
        None => Ok(cost.parse::<f64>().ok().filter(|cost| cost.is_finite())?),
    };
    let point = point.split(' ').map(|x| x.parse().ok()).collect::<Option<Vec<f64>>>()?;
    Some((point, cost))
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn a_line_comes_back_bit_for_bit() {
        let failure = |words: &str| Failure { kind: Kind::Slack, words: words.to_owned() };
        for cost in [Ok(0.1 + 0.2), Ok(1e-300), Err(failure("a line\twent\nslack"))] {
            let point = [0.1 + 0.7, -0.0, 1e-17];
            let written = line(&point, &cost);
            let (same, read) = read_line(written.trim_end()).expect("a line");
            assert_eq!(same.iter().map(|x| x.to_bits()).collect::<Vec<_>>(), point.map(f64::to_bits));
            match (cost, read) {
                (Ok(cost), Ok(read)) => assert_eq!(cost.to_bits(), read.to_bits()),
                (_, read) => {
                    let read = read.expect_err("it failed");
                    assert_eq!((read.to_string().as_str(), &read), ("a line went slack", &failure("in other words")));
                }
            }
        }
    }

    #[test]
    fn a_torn_line_is_cut_off_and_flown_again() {
        let folder = tempfile::tempdir().expect("a writable directory");
        let path = folder.path().join("torn.tsv");
        fs::write(&path, "0.5 1\t1.5\n1 1\tnonsense\n2 1\tNaN\nx 1\t1\n4 1\tfailed: of no kind\n3 1\t2.")
            .expect("a writable directory");
        let (mut journal, known) = Journal::open(&path).expect("an openable file");
        assert_eq!(known, [(vec![0.5, 1.0], Ok(1.5))]);
        journal.add([([3.0, 1.0].as_slice(), &Ok(2.25))]);
        drop(journal);
        let text = fs::read_to_string(&path).expect("just written");
        assert_eq!(text, "0.5 1\t1.5\n1 1\tnonsense\n2 1\tNaN\nx 1\t1\n4 1\tfailed: of no kind\n3 1\t2.25\n");
    }
}
