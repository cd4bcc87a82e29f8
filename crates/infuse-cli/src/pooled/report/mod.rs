//! One HTML page about a campaign that stands alone. The same campaign gives the same bytes.

mod bounds;
mod curves;
mod effects;
mod fit;
mod history;
mod maps;
mod measured;
mod misses;
mod nothing;
mod settings;
mod sheets;
mod summary;
mod view;

use anyhow::Result;
use page::Page;

use super::campaign::Campaign;
use crate::journal::Journal;
use crate::report::provenance;
use view::View;

/// Where the pages speak of what no run has shown yet.
const NO_RESULT: &str = "No experiment gave a result yet, so there is no surface.";

/// The page, from top to bottom. The journal is the one that the campaign follows from.
pub(super) fn page(campaign: &Campaign, journal: &Journal) -> Result<String> {
    let view = View::of(campaign)?;
    let mut page = Page::new(&campaign.problem.title);
    summary::write(&mut page, campaign, view.as_ref())?;
    history::write(&mut page, campaign)?;
    page.section("surfaces", "Surfaces");
    match &view {
        Some(view) => {
            curves::write(&mut page, view)?;
            bounds::write(&mut page, view);
            maps::write(&mut page, view)?;
            effects::write(&mut page, view)?;
        }
        None => page.paragraph(NO_RESULT),
    }
    page.section("fit", "Fit");
    match &view {
        Some(view) => {
            fit::write(&mut page, view);
            misses::write(&mut page, view);
        }
        None => page.paragraph(NO_RESULT),
    }
    page.section("measured", "Best and most telling experiments");
    match &view {
        Some(view) => measured::write(&mut page, view)?,
        None => page.paragraph("No experiment gave a result yet."),
    }
    sheets::write(&mut page, campaign, view.as_ref())?;
    provenance::write(&mut page, &campaign.problem, journal, settings::rows(campaign)?);
    Ok(page.html())
}

/// Its pictures without the rest: batch by batch, along each parameter, and measured against expected.
pub(super) fn pictures(campaign: &Campaign) -> Result<String> {
    let mut page = Page::new("Pictures");
    match View::of(campaign)? {
        Some(view) => {
            history::write_charts(&mut page, campaign)?;
            curves::write(&mut page, &view)?;
            fit::write(&mut page, &view);
        }
        None => page.paragraph(NO_RESULT),
    }
    Ok(page.html())
}
