//! `infuse confirm`: a few runs that measure what was gained.

use std::path::Path;
use std::time::Duration;

use anyhow::Result;

use super::ask::waiting;
use super::output::Output;
use crate::folder;
use crate::sheet::check_ending;

pub(crate) fn confirm(folder: &Path, wait: Duration, runs: usize, sheet: Option<&Path>) -> Result<Output> {
    sheet.map_or(Ok(()), check_ending)?;
    let (mut campaign, mut writer) = folder::open(folder, wait)?;
    let notices = campaign.take_notices();
    campaign.confirm(&mut writer, runs)?;
    waiting((&mut *campaign, &mut writer), (sheet, true), 0, notices)
}
