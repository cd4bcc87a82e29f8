//! `infuse what-if`: what is expected of a design, or of all.

use std::path::Path;

use anyhow::{Result, ensure};

use super::output::Output;
use super::settings;
use crate::folder;

pub(crate) fn what_if(folder: &Path, asked: Option<&str>, grid: Option<&Path>) -> Result<Output> {
    let mut campaign = folder::read(folder)?;
    let notices = campaign.take_notices();
    let (findings, json) = match (asked, grid) {
        (_, Some(path)) => {
            ensure!(!path.exists(), "{} is there already, and was left alone; choose another file", path.display());
            campaign.what_if_over_the_grid(path)?
        }
        (Some(text), None) => campaign.what_if(&settings::all(text, &campaign.problem().region)?)?,
        (None, None) => anyhow::bail!("expected the settings of a design, or --grid FILE"),
    };
    Ok(Output::new(&findings, json, notices))
}
