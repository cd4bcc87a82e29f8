//! `infuse new`: a campaign that works, to be edited.

use std::path::Path;

use anyhow::{Context as _, Result, bail};
use page::Finding;
use serde_json::json;

use super::output::Output;
use crate::disk::replace;
use crate::journal::JOURNAL;
use crate::problem::PROBLEM;

const TEMPLATE: &str = include_str!("new/campaign.toml");
const SIMULATION: &str = include_str!("new/simulation.csv");

/// The table of simulations that the template begins with.
const TABLE: &str = "simulation.csv";

pub(crate) fn new(folder: &Path) -> Result<Output> {
    for name in [PROBLEM, JOURNAL, TABLE] {
        let path = folder.join(name);
        if path.exists() {
            bail!("{} is there already, and was left alone; choose another folder", path.display());
        }
    }
    std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    replace(&folder.join(TABLE), SIMULATION.as_bytes())?;
    replace(&folder.join(PROBLEM), TEMPLATE.as_bytes())?;
    let place = folder.join(PROBLEM);
    let findings = [
        Finding::new(format!(
            "Made {}: a campaign that works as it is, with a table in place of a simulator.",
            place.display()
        )),
        Finding::new(format!(
            "Edit it until it describes your rig; each line says what it is for. Then, in {}: infuse ask",
            folder.display()
        )),
    ];
    Ok(Output::new(&findings, json!({ "campaign": place }), Vec::new()))
}
