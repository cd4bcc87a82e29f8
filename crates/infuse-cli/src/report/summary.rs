//! The beginning of the page: what a reader should know if nothing else.

use std::path::Path;

use anyhow::Result;

use super::html::Page;
use crate::campaign::{Campaign, Stage};
use crate::command::status;

pub(super) fn write(page: &mut Page, campaign: &Campaign, stage: &Stage) -> Result<()> {
    page.section("stands", "Where the campaign stands");
    page.paragraph(status::standing(campaign).trim());
    let next = status::next(campaign, stage, Path::new("."));
    page.note(&(status::best(campaign)? + &next));
    if !campaign.now.reports().is_empty() {
        page.terminal_text(&status::lesson(campaign)?);
        page.terminal_text(&status::prospects(campaign)?);
    }
    for notice in &campaign.notices {
        page.paragraph(&format!("Note: {notice}."));
    }
    Ok(())
}
