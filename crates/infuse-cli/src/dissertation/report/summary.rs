//! The beginning of the page: what a reader should know if nothing else.

use anyhow::Result;
use page::{Finding, Page};

use crate::campaign::Campaign as _;
use crate::dissertation::campaign::Campaign;
use crate::dissertation::findings::{best, lesson, prospects};
use crate::findings::{next, standing};

pub(super) fn write(page: &mut Page, campaign: &Campaign) -> Result<()> {
    page.section("stands", "Where the campaign stands");
    page.finding(&standing(campaign));
    let first: Vec<Finding> = best(campaign).into_iter().chain([next(campaign, &campaign.stage()?)]).collect();
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
