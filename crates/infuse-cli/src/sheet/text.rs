//! Tables as text: however it is encoded and its cells are separated.

use anyhow::{Result, bail, ensure};

use super::cells::{Cell, Records, Separator};

/// The rows of a text. Lines that begin with `#` are comments; a first line `sep=;` names the separator.
pub(super) fn records(bytes: &[u8]) -> Result<Records> {
    let text = decoded(bytes)?;
    ensure!(!text.trim().is_empty(), "the file is empty, expected headings and rows");
    let (separator, text) = match named_separator(&text) {
        Some((separator, rest)) => (separator, rest),
        None => (most_used_separator(&text), &*text),
    };
    if let Some(row) = open_quote(text.as_bytes(), separator) {
        bail!("row {row}: a quote (\") begins a cell and does not end it, expected a second one where its text ends");
    }
    let mut reader = csv::ReaderBuilder::new();
    reader.has_headers(false).flexible(true).trim(csv::Trim::All).delimiter(separator).comment(Some(b'#'));
    let mut rows: Vec<(usize, Vec<Cell>)> = Vec::new();
    let mut n_breaks = 0;
    for record in reader.from_reader(text.as_bytes()).records() {
        let record = record?;
        // Rows as a spreadsheet counts them: empty ones and comments, too, and one with a line break in a cell once.
        let (start, line) = record.position().map_or((0, 0), |at| (at.byte(), at.line()));
        let before = text.as_bytes().get(usize::try_from(start).unwrap_or(usize::MAX)..).unwrap_or_default();
        let line = usize::try_from(line).unwrap_or(usize::MAX).saturating_add(lines_without_cells(before));
        let number = line.saturating_sub(n_breaks);
        if record.iter().any(|cell| holds_rows(cell, separator)) {
            bail!("row {number}: a cell holds whole rows, expected a second quote (\") where its text ends");
        }
        n_breaks += record.iter().map(|cell| cell.matches('\n').count()).sum::<usize>();
        rows.push((number, record.iter().map(Cell::plain).collect()));
    }
    // Spreadsheets leave out cells at the end of a row, but not its end.
    if let ([(_, headings), .., (number, last)], false) = (&rows[..], text.ends_with('\n'))
        && last.len() < headings.len()
    {
        bail!(
            "row {number}: the file ends within it, after {} of {} cells, as if it were cut short; if the row is whole, end it with a \
             line break",
            last.len(),
            headings.len()
        );
    }
    let separator = if separator == b',' { Separator::Comma } else { Separator::Other };
    Ok(Records { rows, separator })
}

/// The text of a file in UTF-8, or in UTF-16 with its byte order mark.
fn decoded(bytes: &[u8]) -> Result<String> {
    match bytes {
        [0xff, 0xfe, rest @ ..] => utf_16(rest, u16::from_le_bytes),
        [0xfe, 0xff, rest @ ..] => utf_16(rest, u16::from_be_bytes),
        _ => {
            let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
            let text = std::str::from_utf8(bytes).map_err(|error| {
                let at = error.valid_up_to();
                let line = bytes[..at].iter().filter(|&&byte| byte == b'\n').count() + 1;
                anyhow::anyhow!("line {line}: byte {at} of the file is no UTF-8: save the table as CSV in UTF-8")
            })?;
            ensure!(!text.contains('\0'), "the file holds zero bytes, expected a table: save it as CSV in UTF-8");
            Ok(text.to_owned())
        }
    }
}

fn utf_16(bytes: &[u8], unit: fn([u8; 2]) -> u16) -> Result<String> {
    let (pairs, rest) = bytes.as_chunks::<2>();
    let text = String::from_utf16(&pairs.iter().map(|&pair| unit(pair)).collect::<Vec<_>>()).ok();
    text.filter(|_| rest.is_empty()).ok_or_else(|| {
        anyhow::anyhow!("it begins like UTF-16 and does not go on like it: save the table as CSV in UTF-8")
    })
}

/// What a first line `sep=;` names, and the lines after it; a spreadsheet doesn't show that line, nor count it.
fn named_separator(text: &str) -> Option<(u8, &str)> {
    let (first, rest) = text.split_once('\n')?;
    let first = first.trim_end_matches('\r').trim_matches('"');
    match first.strip_prefix("sep=").or_else(|| first.strip_prefix("SEP="))?.as_bytes() {
        &[separator @ (b',' | b';' | b'\t')] => Some((separator, rest)),
        _ => None,
    }
}

/// Comma, semicolon or tab, whichever comes most often in the headings.
fn most_used_separator(text: &str) -> u8 {
    let is_heading = |line: &&str| !line.trim().is_empty() && !line.starts_with('#');
    let headings = text.lines().find(is_heading).unwrap_or_default();
    let n = |separator: u8| headings.bytes().filter(|&byte| byte == separator).count();
    // Of equals the last wins, so commas count a little more.
    let order = [b',', b';', b'\t'].into_iter();
    order.max_by_key(|&separator| 2 * n(separator) + usize::from(separator == b',')).unwrap_or(b',')
}

/// How many lines the reader skips from here on before a row.
fn lines_without_cells(bytes: &[u8]) -> usize {
    let lines = bytes.split_inclusive(|&byte| byte == b'\n');
    let is_empty = |line: &[u8]| line == b"\n" || line == b"\r\n";
    lines.take_while(|line| line.ends_with(b"\n") && (line.starts_with(b"#") || is_empty(line))).count()
}

/// The row of a cell that begins with a quote and does not end with one.
fn open_quote(text: &[u8], separator: u8) -> Option<usize> {
    let (mut at, mut row, mut begins_row) = (0, 1, true);
    while at < text.len() {
        let is_remark = begins_row && text[at] == b'#';
        let ends = |byte: u8| byte == b'\n' || (byte == separator && !is_remark);
        if text[at] == b'"' {
            let Some(end) = end_of_quote(text, at + 1) else { return Some(row) };
            let blanks = text[end..].iter().take_while(|&&byte| byte == b' ' || byte == b'\r').count();
            at = end + blanks;
            if text.get(at).is_some_and(|&byte| !ends(byte)) {
                return Some(row);
            }
        }
        let Some(length) = text[at..].iter().position(|&byte| ends(byte)) else { break };
        at += length + 1;
        begins_row = text[at - 1] == b'\n';
        row += usize::from(begins_row);
    }
    None
}

/// After the quote that closes a text which begins here; two quotes stand for one.
fn end_of_quote(text: &[u8], begin: usize) -> Option<usize> {
    let mut at = begin;
    loop {
        at += text[at..].iter().position(|&byte| byte == b'"')? + 1;
        if text.get(at) != Some(&b'"') {
            return Some(at);
        }
        at += 1;
    }
}

/// Whether a cell goes on over lines that are rows of their own: a quote that was opened and never closed.
fn holds_rows(cell: &str, separator: u8) -> bool {
    cell.lines().skip(1).any(|line| line.matches(char::from(separator)).count() >= 3)
}
