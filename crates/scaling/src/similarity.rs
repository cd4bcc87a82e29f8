//! Whether set-ups are similar, and what would make them so.

use std::fmt;

use num_rational::BigRational;
use num_traits::{Signed, ToPrimitive, Zero};

use crate::error::Error;
use crate::group::Group;
use crate::groups::Groups;
use crate::near::near_misses;
use crate::number::significant;
use crate::set_up::SetUp;

/// Every group at every set-up.
///
/// In a file an infinite [spread](Row::spread) is what its format makes of it; JSON has no such number and does not return it.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(try_from = "UncheckedSimilarity")]
pub struct Similarity {
    tolerance: f64,
    set_ups: Vec<SetUp>,
    rows: Vec<Row>,
    unchecked: Vec<Unchecked>,
}

/// A comparison as it stands in a file.
#[derive(serde::Deserialize)]
#[serde(rename = "Similarity", deny_unknown_fields)]
struct UncheckedSimilarity {
    tolerance: f64,
    set_ups: Vec<SetUp>,
    rows: Vec<Row>,
    unchecked: Vec<Unchecked>,
}

impl TryFrom<UncheckedSimilarity> for Similarity {
    type Error = Error;

    fn try_from(read: UncheckedSimilarity) -> Result<Self, Error> {
        let UncheckedSimilarity { tolerance, set_ups, rows, unchecked } = read;
        check_set_ups(&set_ups, tolerance)?;
        let expected = set_ups.len();
        match rows.iter().find(|row| row.values.len() != expected) {
            Some(row) => Err(Error::ValueCount { group: row.group.to_string(), found: row.values.len(), expected }),
            None => Ok(Self { tolerance, set_ups, rows, unchecked }),
        }
    }
}

/// One group.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Row {
    /// The group.
    pub group: Group,
    /// Its value at each set-up, in their order.
    pub values: Vec<f64>,
    /// The largest magnitude divided by the smallest, minus 1; infinite if signs differ or only some values are zero.
    ///
    /// A group and its inverse have the same spread.
    pub spread: f64,
    /// The spread that the printed digits of the extreme values allow, 0 if all values are exact.
    pub rounding: f64,
    /// What to make of it.
    pub verdict: Verdict,
}

/// Whether a group matches.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The spread is within the tolerance.
    Match,
    /// The spread is above the tolerance, but the printed digits allow a spread within it.
    Rounding,
    /// The spread is above the tolerance.
    Mismatch,
}

/// A group that could not be compared.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Unchecked {
    /// The group.
    pub group: Group,
    /// The variables that at least one set-up does not give.
    pub missing: Vec<String>,
}

/// The values of one variable that would make all set-ups match a reference.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Remedies {
    /// The variable to adjust.
    pub variable: String,
    /// Name of the reference set-up.
    pub reference: String,
    /// One for each set-up, in their order; at the reference the value stays.
    pub values: Vec<Remedy>,
    /// Mismatched groups without this variable, which stay as they are.
    pub remaining: Vec<Group>,
}

/// The value of the adjusted variable at one set-up.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Remedy {
    /// Name of the set-up.
    pub set_up: String,
    /// The present value, in the coherent unit.
    pub present: f64,
    /// The value that makes the groups match, in the coherent unit.
    pub required: f64,
}

impl Similarity {
    /// Compares set-ups group by group.
    ///
    /// `tolerance` is the largest spread (see [`Row::spread`]) that still counts as a match: 0.01 is one per cent.
    /// Values given by [`SetUp::printed`] widen it by what their digits leave open.
    /// A group with a variable that a set-up does not give is not compared, but listed in
    /// [`unchecked`](Self::unchecked).
    ///
    /// # Errors
    /// [`Error::TooFewSetUps`], [`Error::BadTolerance`], [`Error::Duplicate`] for two set-ups of one name,
    /// [`Error::UnknownVariable`] for a value that no variable has, [`Error::WrongDimension`], and what
    /// [`Group::value`] says, a missing value excepted.
    pub fn check(groups: &Groups, set_ups: &[SetUp], tolerance: f64) -> Result<Self, Error> {
        check_set_ups(set_ups, tolerance)?;
        set_ups.iter().try_for_each(|set_up| check_dimensions(groups, set_up))?;
        let mut similarity = Self { tolerance, set_ups: set_ups.to_vec(), rows: Vec::new(), unchecked: Vec::new() };
        for group in groups {
            let absent = |name: &str| set_ups.iter().any(|set_up| set_up.value(name).is_none());
            let missing: Vec<_> =
                group.factors().filter(|(name, _)| absent(name)).map(|(name, _)| name.to_owned()).collect();
            if missing.is_empty() {
                similarity.rows.push(row(group, set_ups, tolerance)?);
            } else {
                similarity.unchecked.push(Unchecked { group: group.clone(), missing });
            }
        }
        Ok(similarity)
    }

    /// The groups that could be compared.
    #[must_use]
    pub fn rows(&self) -> &[Row] {
        &self.rows
    }

    /// The groups that could not be compared, because a value is missing.
    #[must_use]
    pub fn unchecked(&self) -> &[Unchecked] {
        &self.unchecked
    }

    /// The set-ups, in the order of the values of a row.
    #[must_use]
    pub fn set_ups(&self) -> &[SetUp] {
        &self.set_ups
    }

    /// The rows that do not match.
    pub fn mismatches(&self) -> impl Iterator<Item = &Row> {
        self.rows.iter().filter(|row| row.verdict == Verdict::Mismatch)
    }

    /// Whether every group was compared and none is mismatched.
    #[must_use]
    pub fn is_similar(&self) -> bool {
        self.unchecked.is_empty() && self.mismatches().next().is_none()
    }

    /// The values of `variable` that make the mismatched groups equal to those of the set-up `reference`.
    ///
    /// Where several compared groups contain the variable, also matching ones, the value must serve them all within
    /// the tolerance; then it is the one that the first mismatched group asks for.
    ///
    /// # Errors
    /// [`Error::NoSuchSetUp`], [`Error::UnknownVariable`]; [`Error::NoRemedy`] if no mismatched group contains the variable;
    /// [`Error::NoSingleValue`] if the groups ask for different values; [`Error::Unreachable`].
    pub fn remedy(&self, variable: &str, reference: usize) -> Result<Remedies, Error> {
        let Some(reference_set_up) = self.set_ups.get(reference) else {
            return Err(Error::NoSuchSetUp { index: reference, count: self.set_ups.len() });
        };
        let known: Vec<&str> = self.set_ups.iter().flat_map(SetUp::variables).collect();
        if !known.contains(&variable) {
            let near = near_misses(variable, known.into_iter().map(str::to_owned));
            return Err(Error::UnknownVariable { name: variable.to_owned(), near });
        }
        let (with, without): (Vec<_>, Vec<_>) =
            self.mismatches().partition(|row| !row.group.exponent(variable).is_zero());
        let Some(first) = with.first() else {
            let mismatched = without.iter().map(|row| row.group.to_string()).collect();
            return Err(Error::NoRemedy { variable: variable.to_owned(), mismatched });
        };
        let values = (0..self.set_ups.len())
            .map(|index| self.remedy_at(index, variable, reference, first))
            .collect::<Result<_, _>>()?;
        Ok(Remedies {
            variable: variable.to_owned(),
            reference: reference_set_up.name().to_owned(),
            values,
            remaining: without.iter().map(|row| row.group.clone()).collect(),
        })
    }

    fn remedy_at(&self, index: usize, variable: &str, reference: usize, first: &Row) -> Result<Remedy, Error> {
        let set_up = &self.set_ups[index];
        let present = set_up.value(variable).unwrap_or(f64::NAN);
        let required = self.wanted(index, variable, reference, first)?;
        let remedy = Remedy { set_up: set_up.name().to_owned(), present, required };
        if index == reference {
            return Ok(remedy);
        }
        let concerned = self.rows.iter().filter(|row| !row.group.exponent(variable).is_zero());
        let mut wanted = Vec::new();
        let mut served = true;
        for row in concerned {
            let value = self.wanted(index, variable, reference, row)?;
            let exponent = to_f64(&row.group.exponent(variable)).abs();
            let rounding = self.rounding(row, index) + self.rounding(row, reference);
            served &= (value / required).ln().abs() * exponent <= self.tolerance.ln_1p() + rounding + 1e-12;
            wanted.push((row.group.to_string(), value));
        }
        if served {
            return Ok(remedy);
        }
        Err(Error::NoSingleValue { variable: variable.to_owned(), set_up: set_up.name().to_owned(), wanted })
    }

    /// The value that takes one group to its reference value.
    fn wanted(&self, index: usize, variable: &str, reference: usize, row: &Row) -> Result<f64, Error> {
        let (from, to) = (row.values[index], row.values[reference]);
        let present = self.set_ups[index].value(variable).unwrap_or(f64::NAN);
        if index == reference {
            return Ok(present);
        }
        let wanted = present * (to / from).powf(1.0 / to_f64(&row.group.exponent(variable)));
        if wanted.is_finite() && wanted != 0.0 && to / from > 0.0 {
            return Ok(wanted);
        }
        Err(Error::Unreachable {
            variable: variable.to_owned(),
            group: row.group.to_string(),
            set_up: self.set_ups[index].name().to_owned(),
            from,
            to,
        })
    }

    fn rounding(&self, row: &Row, index: usize) -> f64 {
        rounding(&row.group, &self.set_ups[index])
    }
}

/// That these can be compared, within this tolerance.
fn check_set_ups(set_ups: &[SetUp], tolerance: f64) -> Result<(), Error> {
    if set_ups.len() < 2 {
        return Err(Error::TooFewSetUps { count: set_ups.len() });
    }
    if !tolerance.is_finite() || tolerance < 0.0 {
        return Err(Error::BadTolerance { tolerance });
    }
    for (position, set_up) in set_ups.iter().enumerate() {
        if set_ups[..position].iter().any(|other| other.name() == set_up.name()) {
            return Err(Error::Duplicate { what: "set-up", name: set_up.name().to_owned() });
        }
    }
    Ok(())
}

fn check_dimensions(groups: &Groups, set_up: &SetUp) -> Result<(), Error> {
    for name in set_up.variables() {
        let variable = groups.system().variable(name)?;
        if let Some((unit, found)) = set_up.unit(name).filter(|(_, found)| *found != variable.dimension) {
            return Err(Error::WrongDimension {
                set_up: set_up.name().to_owned(),
                variable: name.to_owned(),
                unit: unit.clone(),
                found: found.to_string(),
                expected: variable.dimension.to_string(),
            });
        }
    }
    Ok(())
}

fn row(group: &Group, set_ups: &[SetUp], tolerance: f64) -> Result<Row, Error> {
    let values: Vec<f64> = set_ups.iter().map(|set_up| group.value(set_up)).collect::<Result<_, _>>()?;
    let roundings: Vec<f64> = set_ups.iter().map(|set_up| rounding(group, set_up)).collect();
    let (mut spread, mut open, mut verdict) = (0.0, 0.0, Verdict::Match);
    for (i, a) in values.iter().enumerate() {
        for (j, b) in values.iter().enumerate().skip(i + 1) {
            let pair = pair_spread(*a, *b);
            let pair_open = roundings[i] + roundings[j];
            if pair > spread {
                (spread, open) = (pair, pair_open);
            }
            verdict = match verdict {
                _ if pair.ln_1p() > tolerance.ln_1p() + pair_open => Verdict::Mismatch,
                Verdict::Match if pair > tolerance => Verdict::Rounding,
                unchanged => unchanged,
            };
        }
    }
    Ok(Row { group: group.clone(), values, spread, rounding: open, verdict })
}

/// The larger magnitude over the smaller, minus 1.
fn pair_spread(a: f64, b: f64) -> f64 {
    if a == 0.0 && b == 0.0 {
        0.0
    } else if a == 0.0 || b == 0.0 || (a < 0.0) != (b < 0.0) {
        f64::INFINITY
    } else {
        (a.abs().max(b.abs()) - a.abs().min(b.abs())) / a.abs().min(b.abs())
    }
}

/// By what fraction the printed digits leave a group open, to first order.
fn rounding(group: &Group, set_up: &SetUp) -> f64 {
    group.factors().map(|(name, exponent)| to_f64(&exponent.abs()) * set_up.relative_rounding(name)).sum()
}

fn to_f64(exponent: &BigRational) -> f64 {
    exponent.to_f64().unwrap_or(f64::NAN)
}

impl fmt::Display for Similarity {
    /// A table: group, value at each set-up, spread, verdict; then what could not be compared.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut header = vec!["group".to_owned()];
        header.extend(self.set_ups.iter().map(|set_up| set_up.name().to_owned()));
        header.extend(["spread".to_owned(), "verdict".to_owned()]);
        let mut lines = vec![header];
        for row in &self.rows {
            let mut line = vec![row.group.to_string()];
            line.extend(row.values.iter().map(|value| significant(*value)));
            line.push(format!("{:.2} %", 100.0 * row.spread));
            line.push(match row.verdict {
                Verdict::Match => "matches".to_owned(),
                Verdict::Rounding => format!("within rounding ({:.2} %)", 100.0 * row.rounding),
                Verdict::Mismatch => "MISMATCH".to_owned(),
            });
            lines.push(line);
        }
        let columns = self.set_ups.len() + 3;
        let width = |column: usize| lines.iter().map(|line| line[column].chars().count()).max().unwrap_or(0);
        let widths: Vec<_> = (0..columns).map(width).collect();
        for line in &lines {
            write!(f, "{:<w$}", line[0], w = widths[0])?;
            for (cell, w) in line[1..columns - 1].iter().zip(&widths[1..]) {
                write!(f, "  {cell:>w$}")?;
            }
            writeln!(f, "  {}", line[columns - 1])?;
        }
        for Unchecked { group, missing } in &self.unchecked {
            writeln!(f, "not compared: {group} ({} not given everywhere)", missing.join(", "))?;
        }
        Ok(())
    }
}

impl fmt::Display for Remedies {
    /// One line a set-up, in coherent units.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for Remedy { set_up, present, required } in &self.values {
            let (present, required) = (significant(*present), significant(*required));
            writeln!(f, "{set_up}: {} = {required} instead of {present}", self.variable)?;
        }
        for group in &self.remaining {
            writeln!(f, "{group} stays mismatched: {} is not in it", self.variable)?;
        }
        Ok(())
    }
}
