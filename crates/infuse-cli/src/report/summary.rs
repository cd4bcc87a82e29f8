//! The beginning of the page: what a reader should know if nothing else.

use std::path::Path;

use anyhow::Result;
use page::{Finding, Page};

use crate::campaign::{Campaign, Stage};
use crate::findings::{best, lesson, next, prospects, standing};

pub(super) fn write(page: &mut Page, campaign: &Campaign, stage: &Stage) -> Result<()> {
    page.section("stands", "Where the campaign stands");
    page.finding(&standing(campaign));
    let first: Vec<Finding> = best(campaign).into_iter().chain([next(campaign, stage, Path::new("."))]).collect();
    page.key_findings(&first);
    if let Some(lesson) = lesson(campaign) {
        page.finding(&lesson);
        prospects(campaign)?.iter().for_each(|finding| page.finding(finding));
    }
    for notice in &campaign.notices {
        page.paragraph(&format!("Note: {notice}."));
    }
    Ok(())
}
