//! Words and numbers that claims share.

use crate::chapter7::file::Case;
use crate::claims::Place;
use page::Summary;

/// What a claim says first when there was nothing to find at either end.
pub(super) const FITTED: &str = "Numerical optimum and best design of the stand-in were both calibrated; that the loop goes from the one towards \
    the other is what came out.";

pub(super) fn table_place(case: &Case) -> Place {
    Place::Table(u8::try_from(case.entry.table).unwrap_or_default())
}

pub(super) fn median(values: impl Iterator<Item = f64>) -> f64 {
    Summary::of(&values.collect::<Vec<_>>()).map_or(f64::NAN, |summary| summary.median)
}

pub(super) fn median_words(values: impl Iterator<Item = f64>, decimals: usize) -> String {
    Summary::of(&values.collect::<Vec<_>>())
        .map_or("–".to_owned(), |summary| format!("{:.decimals$}", summary.median))
}
