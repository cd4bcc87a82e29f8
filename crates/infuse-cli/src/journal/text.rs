//! What the bytes of a journal say, however they came to be.

use anyhow::{Result, bail};

use super::checksum::{Checksum, Fault};
use super::event::Event;
use super::name::JOURNAL;

/// A journal as read.
#[derive(Debug, Default)]
pub(crate) struct Text {
    /// Complete lines, each with its number from 1.
    pub(crate) events: Vec<(usize, Event)>,
    /// Up to here the bytes are complete.
    pub(crate) n_bytes: usize,
    /// Whether the last complete line lacks its line break.
    pub(crate) is_open: bool,
    /// Of the complete lines.
    pub(crate) checksum: Checksum,
}

/// Reads the lines. What follows `n_bytes` is the trace of a call that was interrupted while writing, before it could say that it
/// had taken anything: a line cut short, or the first lines of a group.
///
/// # Errors
///
/// A line that cannot be read although others follow it, by its number.
pub(crate) fn read(bytes: &[u8]) -> Result<Text> {
    let mut text = Text::default();
    let mut group: Vec<(usize, Event)> = Vec::new();
    let (mut at, mut number) = (0, 0);
    // With the lines of a group that is not complete yet.
    let mut checksum = Checksum::default();
    while at < bytes.len() {
        number += 1;
        let end = bytes[at..].iter().position(|&byte| byte == b'\n').map(|length| at + length + 1);
        let line = &bytes[at..end.unwrap_or(bytes.len())];
        at += line.len();
        let line = if number == 1 { line.strip_prefix(b"\xef\xbb\xbf").unwrap_or(line) } else { line };
        if line.trim_ascii().is_empty() {
            if group.is_empty() {
                text.n_bytes = at;
            }
            continue;
        }
        let event = match checksum.event(line) {
            Ok(event) => event,
            // A line without its end that is no event was cut short.
            Err(Fault::Unreadable(_)) if end.is_none() => break,
            Err(Fault::Unreadable(error)) => bail!("{JOURNAL}, line {number}: {error}\n  {}", excerpt(line)),
            Err(Fault::Changed(error)) => return Err(error.context(format!("{JOURNAL}, line {number}"))),
        };
        checksum.add(line);
        let (row, rows) = event.group();
        if row != group.len() + 1 || group.last().is_some_and(|(_, first)| first.group().1 != rows) || row > rows {
            if row == 1 && !group.is_empty() {
                // The group before was cut short; later calls have set such lines aside, so someone has put them back.
                bail!(
                    "{JOURNAL}, line {number}: the lines before it are {} of {} that were written at once",
                    group.len(),
                    group[0].1.group().1
                );
            }
            bail!("{JOURNAL}, line {number}: `row` is {row} of {rows}, expected {}", group.len() + 1);
        }
        group.push((number, event));
        if row == rows {
            text.events.append(&mut group);
            text.checksum = checksum.clone();
            text.n_bytes = at;
            text.is_open = end.is_none();
        }
    }
    Ok(text)
}

fn excerpt(line: &[u8]) -> String {
    let text = String::from_utf8_lossy(line.trim_ascii());
    if text.chars().count() <= 120 { text.into_owned() } else { text.chars().take(120).chain("...".chars()).collect() }
}
