//! One HTML page about a campaign that stands alone. The same campaign gives the same bytes.

mod bounds;
mod curves;
mod history;
mod last;
mod left;
mod maps;
mod replay;
mod settings;
mod sheets;
mod summary;
mod trends;

use anyhow::Result;
use page::Page;

use super::campaign::Campaign;
use crate::journal::Journal;
use crate::report::provenance;
use last::Last;

/// Before the first batch is complete.
const NO_SURFACE: &str = "No batch is closed yet, so there is no surface.";

/// The page, from top to bottom. The journal is the one that the campaign follows from.
pub(super) fn page(campaign: &Campaign, journal: &Journal) -> Result<String> {
    let last = Last::of(campaign)?;
    let observed = replay::observed_errors(campaign)?;
    let mut page = Page::new(&campaign.problem.title);
    summary::write(&mut page, campaign)?;
    history::write(&mut page, campaign, &observed);
    page.section("surfaces", "Surfaces");
    match &last {
        Some(last) => {
            curves::write(&mut page, last)?;
            maps::write(&mut page, last)?;
        }
        None => page.paragraph(NO_SURFACE),
    }
    left::write(&mut page, campaign)?;
    bounds::write(&mut page, campaign)?;
    sheets::write(&mut page, campaign)?;
    provenance::write(&mut page, &campaign.problem, journal, settings::rows(campaign));
    Ok(page.html())
}

/// Its pictures without the rest: batch by batch, along each parameter, and over pairs of them.
pub(super) fn pictures(campaign: &Campaign) -> Result<String> {
    let mut page = Page::new("Pictures");
    match Last::of(campaign)? {
        Some(last) => {
            trends::write(&mut page, campaign, &replay::observed_errors(campaign)?);
            curves::write(&mut page, &last)?;
            maps::write(&mut page, &last)?;
        }
        None => page.paragraph(NO_SURFACE),
    }
    Ok(page.html())
}
