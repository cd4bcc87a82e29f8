//! The beginning of the page: what a reader should know if nothing else.

use anyhow::Result;
use page::{Finding, Page};

use super::view::View;
use crate::campaign::Campaign as _;
use crate::findings::{next, standing};
use crate::pooled::campaign::Campaign;
use crate::pooled::findings::known;
use crate::pooled::warnings::warnings;

/// Blocks of what is known.
const BEST: usize = 0;
const CERTIFICATE: usize = 2;

pub(super) fn write(page: &mut Page, campaign: &Campaign, view: Option<&View>) -> Result<()> {
    page.section("stands", "Where the campaign stands");
    page.finding(&standing(campaign));
    let next = next(campaign, &campaign.stage()?);
    match view {
        Some(view) => {
            let (first, rest) = first_and_rest(known(campaign, &view.found)?);
            let warnings = warnings(campaign, &view.found)?;
            page.key_findings(&[first, warnings].concat());
            page.subheading("What to do next");
            page.key_findings(&[next]);
            page.subheading("What else is known");
            rest.iter().for_each(|finding| page.finding(finding));
        }
        None => page.key_findings(&[next]),
    }
    for notice in &campaign.notices {
        page.paragraph(&format!("Note: {notice}."));
    }
    Ok(())
}

/// The recommended design and the certificate, which stand at the beginning of their blocks; and all else.
fn first_and_rest(blocks: Vec<Vec<Finding>>) -> (Vec<Finding>, Vec<Finding>) {
    let (mut first, mut rest) = (Vec::new(), Vec::new());
    for (index, block) in blocks.into_iter().enumerate() {
        let mut findings = block.into_iter();
        match index {
            // What stands before the recommended design says how far to believe it.
            BEST => first.extend(findings.by_ref()),
            CERTIFICATE => first.extend(findings.next()),
            _ => {}
        }
        rest.extend(findings);
    }
    (first, rest)
}
