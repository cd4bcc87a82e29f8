//! The fenced blocks of a tutorial in Markdown: what is to be run, and what it should print.

use std::ops::Range;

use anyhow::{Result, bail, ensure};

/// A block ```` ```sh ````, with what should come of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Block {
    /// Of its fence, from one.
    pub(super) line: usize,
    pub(super) script: String,
    pub(super) end: End,
    /// The lines, from zero, of the block ```` ```text ```` that directly follows; none where none does.
    pub(super) expected: Option<Range<usize>>,
}

/// How a block has to end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum End {
    Succeeds,
    /// Marked `sh fails`: with an exit code that is not zero.
    Fails,
}

/// Any fenced block.
struct Fenced<'a> {
    info: &'a str,
    /// Of its contents, from zero.
    lines: Range<usize>,
}

/// The blocks to run, in their order; one that is marked `sh ignore` is none.
pub(super) fn blocks(text: &str) -> Result<Vec<Block>> {
    let lines: Vec<&str> = text.lines().collect();
    let fenced = fenced(&lines)?;
    let mut blocks = Vec::new();
    for (k, block) in fenced.iter().enumerate() {
        let line = block.lines.start;
        let end = match block.info.split_whitespace().collect::<Vec<_>>().as_slice() {
            ["sh"] => End::Succeeds,
            ["sh", "fails"] => End::Fails,
            ["sh", "ignore"] => continue,
            ["sh", ..] => bail!("line {line}: `{}`: it must be sh, sh fails or sh ignore", block.info),
            _ => continue,
        };
        let next = fenced.get(k + 1).filter(|next| {
            let between = block.lines.end + 1..next.lines.start - 1;
            next.info == "text" && lines[between].iter().all(|line| line.trim().is_empty())
        });
        blocks.push(Block {
            line,
            script: lines[block.lines.clone()].join("\n"),
            end,
            expected: next.map(|next| next.lines.clone()),
        });
    }
    Ok(blocks)
}

fn fenced<'a>(lines: &[&'a str]) -> Result<Vec<Fenced<'a>>> {
    let mut blocks = Vec::new();
    let mut open: Option<(usize, &str, usize)> = None;
    for (k, line) in lines.iter().enumerate() {
        let ticks = line.len() - line.trim_start_matches('`').len();
        let info = line[ticks..].trim();
        match open {
            None if ticks >= 3 => open = Some((ticks, info, k + 1)),
            Some((opened, info_of_block, start)) if ticks >= opened && info.is_empty() => {
                blocks.push(Fenced { info: info_of_block, lines: start..k });
                open = None;
            }
            _ => {}
        }
    }
    match open {
        Some((_, _, start)) => bail!("line {start}: a fence without an end"),
        None => Ok(blocks),
    }
}

/// The text with other lines in place of some of its own; the ranges ascend.
pub(super) fn with(text: &str, replacements: &[(Range<usize>, Vec<String>)]) -> Result<String> {
    let lines: Vec<&str> = text.lines().collect();
    let mut result: Vec<&str> = Vec::new();
    let mut taken = 0;
    for (range, new) in replacements {
        let fence = new.iter().find(|line| line.starts_with("```"));
        ensure!(fence.is_none(), "line {}: what was printed would end its own block", range.start);
        result.extend(&lines[taken..range.start]);
        result.extend(new.iter().map(String::as_str));
        taken = range.end;
    }
    result.extend(&lines[taken..]);
    Ok(result.join("\n") + "\n")
}
