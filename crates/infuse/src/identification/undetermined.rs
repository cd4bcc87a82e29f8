//! Directions that data leave open, in words.

use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use super::unknowns::Unknowns;

/// A change of the unknowns that what was measured does not tell.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Direction {
    /// Change of each unknown in its unit; the largest is a tenth of a range.
    pub change: Vec<f64>,
    /// Standard error along it as a share of the range; none where what was measured does not depend on it at all.
    pub standard_error: Option<f64>,
    /// What that means, by name.
    pub words: String,
}

/// Entries below this share of the largest are left out of the words.
const VISIBLE: f64 = 0.05;
/// The change that is told, as a share of the range.
const TOLD: f64 = 0.1;

/// The space that these rows span, given in shares of the ranges, in directions that each name as few unknowns as possible.
/// `errors` are the standard errors along the rows.
pub(super) fn directions(unknowns: &Unknowns, rows: &DMatrix<f64>, errors: &[f64]) -> Vec<Direction> {
    let least = errors.iter().copied().fold(f64::INFINITY, f64::min);
    let mut sparse = reduced(rows.clone());
    sparse.sort_by_key(|direction| direction.iter().position(|entry| entry.abs() > VISIBLE));
    sparse.iter().map(|direction| told(unknowns, direction, least)).collect()
}

/// Gauss and Jordan with pivots over all columns: each row has a column of its own, and its largest entry made 1.
fn reduced(mut rows: DMatrix<f64>) -> Vec<Vec<f64>> {
    let (n_rows, n_columns) = rows.shape();
    let mut done = vec![false; n_rows];
    for _ in 0..n_rows {
        let open =
            (0..n_rows).filter(|row| !done[*row]).flat_map(|row| (0..n_columns).map(move |column| (row, column)));
        let size = |at: &(usize, usize)| rows[*at].abs();
        let Some(pivot) = open.max_by(|a, b| size(a).total_cmp(&size(b))) else { break };
        let scaled = rows.row(pivot.0) / rows[pivot];
        for row in (0..n_rows).filter(|row| *row != pivot.0) {
            let factor = rows[(row, pivot.1)];
            let rest = rows.row(row) - &scaled * factor;
            rows.set_row(row, &rest);
        }
        rows.set_row(pivot.0, &scaled);
        done[pivot.0] = true;
    }
    let entries = |row: usize| -> Vec<f64> {
        let row = rows.row(row);
        let largest = row.amax();
        row.iter().map(|entry| if entry.abs() < VISIBLE * largest { 0.0 } else { entry / largest }).collect()
    };
    (0..n_rows).map(entries).collect()
}

fn told(unknowns: &Unknowns, direction: &[f64], error: f64) -> Direction {
    let parameters = unknowns.region().parameters();
    let change: Vec<f64> = direction.iter().zip(parameters).map(|(entry, p)| TOLD * entry * p.width()).collect();
    let involved: Vec<usize> = (0..direction.len()).filter(|j| direction[*j] != 0.0).collect();
    let name = |j: &usize| format!("`{}`", parameters[*j].name());
    let names = listed(&involved.iter().map(name).collect::<Vec<_>>());
    let is_seen = error.is_finite();
    let words = match &involved[..] {
        [_] if !is_seen => format!("{names} has no effect on what was measured"),
        [_] => format!(
            "what was measured says no more of {names} than its bounds do: standard error {error:.2} of the range"
        ),
        _ => {
            // The first goes up.
            let sign = involved.first().map_or(1.0, |j| change[*j].signum());
            let moved = |j: &usize| {
                let verb = if sign * change[*j] > 0.0 { "a rise" } else { "a fall" };
                let unit = parameters[*j].unit();
                format!(
                    "{verb} of {} by {}{}{unit}",
                    name(j),
                    digits(change[*j].abs()),
                    if unit.is_empty() { "" } else { " " }
                )
            };
            let moves = listed(&involved.iter().map(moved).collect::<Vec<_>>());
            let leaves = if is_seen {
                "together can hardly be told from none"
            } else {
                "together change nothing of what was measured"
            };
            format!("{names} are determined only together: {moves} {leaves}")
        }
    };
    Direction { change, standard_error: is_seen.then_some(error), words }
}

/// With three significant digits.
fn digits(value: f64) -> String {
    let scientific = format!("{value:.2e}");
    let exponent = scientific.split_once('e').and_then(|(_, exponent)| exponent.parse::<i32>().ok());
    match exponent {
        Some(exponent @ -4..6) => format!("{value:.*}", usize::try_from(2 - exponent).unwrap_or(0)),
        _ => scientific,
    }
}

fn listed(words: &[String]) -> String {
    match words {
        [] => String::new(),
        [only] => only.clone(),
        [rest @ .., last] => format!("{} and {last}", rest.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use design_space::{Parameter, Region};

    #[test]
    fn directions_come_in_the_order_of_the_unknowns() {
        let parameter = |name: &str| Parameter::continuous(name, "", 0.0, 1.0).unwrap();
        let region = Region::new(["a", "b", "c"].map(parameter).to_vec()).unwrap();
        let unknowns = Unknowns::new(region, vec![0.5; 3]).unwrap();
        let rows = DMatrix::from_row_slice(2, 3, &[0.0, 0.0, 1.0, 1.0, 0.0, 0.0]);
        let found = directions(&unknowns, &rows, &[f64::INFINITY; 2]);
        let words: Vec<&str> = found.iter().map(|direction| direction.words.as_str()).collect();
        assert_eq!(words, ["a", "c"].map(|name| format!("`{name}` has no effect on what was measured")));
        let rows = DMatrix::from_row_slice(1, 3, &[0.0, 1.0, 0.0]);
        let said = "what was measured says no more of `b` than its bounds do: standard error 0.70 of the range";
        let found = directions(&unknowns, &rows, &[0.7]);
        assert_eq!((found[0].words.as_str(), found[0].standard_error), (said, Some(0.7)));
    }
}
