//! What a workbook may hold, looked at before it is read: the reader takes memory for whatever number stands in it.

use std::io::{self, BufReader, Cursor, Read as _};

use anyhow::{Result, bail, ensure};
use quick_xml::events::{BytesStart, Event};
use zip::ZipArchive;

/// A sheet has no more rows and columns.
pub(super) const MOST_ROWS: u32 = 1_048_576;
pub(super) const MOST_COLUMNS: u32 = 16_384;
/// What the parts of a workbook hold together when they are unpacked.
const MOST_BYTES: u64 = 100_000_000;
/// No sheet has more texts that differ.
const MOST_TEXTS: u64 = 100_000_000;

/// Refuses a workbook that no spreadsheet writes. What cannot be read at all is left to the reader.
pub(super) fn check(bytes: &[u8]) -> Result<()> {
    let Ok(mut archive) = ZipArchive::new(Cursor::new(bytes)) else {
        return Ok(());
    };
    let mut left = MOST_BYTES;
    for index in 0..archive.len() {
        let Ok(part) = archive.by_index(index) else {
            continue;
        };
        let name = part.name().map_or_else(|_| index.to_string(), std::borrow::Cow::into_owned);
        // One byte more than may be there shows that there is more.
        let mut part = part.take(left + 1);
        let mut reader = quick_xml::Reader::from_reader(BufReader::new(&mut part));
        reader.config_mut().check_end_names = false;
        let mut buffer = Vec::new();
        while let Ok(event) = reader.read_event_into(&mut buffer) {
            match event {
                Event::Start(element) | Event::Empty(element) => {
                    element_is_sound(&element).map_err(|error| error.context(format!("part `{name}`")))?;
                }
                Event::Eof => break,
                _ => {}
            }
            buffer.clear();
        }
        // What stands behind a fault counts, too.
        let _ = io::copy(&mut part, &mut io::sink());
        let Some(rest) = part.limit().checked_sub(1) else {
            bail!("it holds more than {} MB when it is unpacked", MOST_BYTES / 1_000_000);
        };
        left = rest;
    }
    Ok(())
}

fn element_is_sound(element: &BytesStart<'_>) -> Result<()> {
    for attribute in element.attributes().with_checks(false).flatten() {
        let (name, value) = (attribute.key, &*attribute.value);
        match name.as_ref() {
            "r" | "ref" => {
                let is_cell = matches!(element.local_name().as_ref(), "c" | "row");
                ensure!(!is_cell || row_and_column(value).is_some(), "`{}` is no cell", crate::echo::echo(value));
                range_is_sound(value)?;
            }
            "uniqueCount" => {
                let count: Option<u64> = value.trim().parse().ok();
                ensure!(count.is_none_or(|count| count <= MOST_TEXTS), "it says to hold `{value}` texts");
            }
            _ => {}
        }
    }
    Ok(())
}

/// Refuses cells beyond all sheets, and a range that ends before it begins. What names no cells is left to the reader.
fn range_is_sound(range: &str) -> Result<()> {
    let mut last = (0, 0);
    for place in range.split(':') {
        let Some((row, column)) = row_and_column(place) else {
            continue;
        };
        ensure!(
            row <= u64::from(MOST_ROWS) && column <= u64::from(MOST_COLUMNS),
            "`{}` lies beyond the {MOST_ROWS} rows and {MOST_COLUMNS} columns of a sheet",
            crate::echo::echo(range)
        );
        ensure!(row >= last.0 && column >= last.1, "`{}` ends before it begins", crate::echo::echo(range));
        last = (row, column);
    }
    Ok(())
}

/// Counted from 1; 0 for a part that is not there, and the highest number for what is higher.
fn row_and_column(place: &str) -> Option<(u64, u64)> {
    let digits = place.find(|c: char| c.is_ascii_digit()).unwrap_or(place.len());
    let (letters, digits) = place.split_at(digits);
    let is_place = letters.bytes().all(|c| c.is_ascii_alphabetic()) && digits.bytes().all(|c| c.is_ascii_digit());
    if !is_place {
        return None;
    }
    let number = |so_far: u64, base: u64, digit: u8| so_far.saturating_mul(base).saturating_add(u64::from(digit));
    let column = letters.bytes().fold(0, |so_far, c| number(so_far, 26, c.to_ascii_uppercase() - b'A' + 1));
    let row = digits.bytes().fold(0, |so_far, c| number(so_far, 10, c - b'0'));
    Some((row, column))
}
