//! `infuse import`: experiments from before the campaign.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::Duration;

use anyhow::{Result, bail, ensure};
use design_space::{Parameter, Region};
use page::Finding;
use serde_json::json;

use super::output::Output;
use super::taken_over::{TakenOver, of_campaign};
use crate::campaign::Imported;
use crate::findings::{Twice, as_from_elsewhere, imported, withdrawn};
use crate::folder;
use crate::journal::{Event, now};
use crate::number::{count, plain, with_unit};
use crate::sheet;
use crate::shell::as_one_word;

pub(crate) fn import(folder: &Path, wait: Duration, file: &Path, source: Option<&str>) -> Result<Output> {
    let is_empty = source.is_some_and(|source| source.trim().is_empty());
    ensure!(!is_empty, "--source is empty, expected where these experiments come from");
    let (mut campaign, mut writer) = folder::open(folder, wait)?;
    let notices = campaign.take_notices();
    let TakenOver { found, n_left_out } = match (file.is_dir(), source) {
        (true, None) => bail!(
            "{} is a folder: --source is missing, expected a name for the campaign that its experiments come from",
            file.display()
        ),
        (true, Some(_)) => of_campaign(file, folder, campaign.problem())?,
        (false, _) => TakenOver { found: sheet::imported(file, campaign.problem(), source)?, n_left_out: 0 },
    };
    let found: Vec<Imported> =
        found.into_iter().map(|one| Imported { source: source_of(&one, source), ..one }).collect();
    let mut all = campaign.imported();
    let n_in_use = all.len();
    let is_known = |one: &&Imported| all.iter().any(|earlier| earlier.source == one.source && earlier.is_alike(one));
    if let Some(known) = found.iter().find(is_known) {
        bail!(
            "{}: {} with {} is in the journal already, from the same source; nothing was taken",
            file.display(),
            campaign.problem().describe(&known.point),
            known.result.value().map_or_else(|| "no value".to_owned(), plain)
        );
    }
    let copied = copied_rows(&found);
    let beyond = beyond_the_region(&found, &campaign.problem().region);
    all.extend(found.iter().cloned());
    let elsewhere = Twice::among(&all, n_in_use);
    let (rows, at, from) = (found.len(), now(), file.display().to_string());
    let events = found.into_iter().enumerate().map(|(index, one)| {
        let Imported { point, result, constrained, source, note } = one;
        let units = campaign.problem().units_of(&constrained);
        Event::Imported {
            row: index + 1,
            rows,
            point,
            result,
            constrained,
            units,
            source,
            note,
            from: from.clone(),
            at: at.clone(),
        }
    });
    let events: Vec<Event> = events.collect();
    campaign.record(&mut writer, events)?;
    let also = as_from_elsewhere(&elsewhere);
    let findings = std::iter::once(imported(rows, &campaign.use_of_imports(rows)));
    let findings: Vec<Finding> = findings.chain(left_out(n_left_out)).chain(beyond).chain(also).chain(copied).collect();
    let json = json!({ "imported": rows, "as_from_elsewhere": elsewhere.iter().map(|twice| twice.n).sum::<usize>(), "left_out": n_left_out });
    Ok(Output::new(&findings, json, notices))
}

/// That experiments of another campaign were not taken over.
fn left_out(n: usize) -> Option<Finding> {
    let sentence = format!(
        "{} left out: farther outside of the bounds than half their width, or of choices that there are not here.",
        if n == 1 { "1 experiment was".to_owned() } else { format!("{n} experiments were") }
    );
    (n > 0).then(|| Finding::new(sentence).with("experiments left out", n as f64, "1"))
}

/// That settings lie somewhat outside of the bounds; those that lie far outside are refused with the table.
fn beyond_the_region(found: &[Imported], region: &Region) -> Option<Finding> {
    let is_beyond = |(parameter, value): &(&Parameter, &f64)| {
        parameter.choices().is_none() && !(parameter.lower()..=parameter.upper()).contains(*value)
    };
    let beyond = |one: &&Imported| region.parameters().iter().zip(&one.point).any(|pair| is_beyond(&pair));
    let first = found.iter().find(beyond)?;
    let n = found.iter().filter(beyond).count();
    let (parameter, value) = region.parameters().iter().zip(&first.point).find(is_beyond)?;
    let (name, unit) = (parameter.name(), parameter.unit());
    let sentence = format!(
        "{} outside of the bounds of the parameters; the first: {name} {}, and it is set from {} to {}. {} all the same. {}",
        if n == 1 { "1 row lies".to_owned() } else { format!("{n} rows lie") },
        with_unit(&plain(*value), unit),
        plain(parameter.lower()),
        with_unit(&plain(parameter.upper()), unit),
        if n == 1 { "It counts" } else { "They count" },
        if_a_slip(&first.source)
    );
    Some(Finding::new(sentence).with("rows outside of the bounds", n as f64, "1"))
}

/// That rows of one source say the same, to the last digit, which a slip of the hand does more often than a rig.
fn copied_rows(found: &[Imported]) -> Option<Finding> {
    let mut seen: BTreeMap<(&str, Vec<u64>), Vec<&Imported>> = BTreeMap::new();
    let mut copies = Vec::new();
    for one in found {
        let Some(value) = one.result.value() else { continue };
        let numbers = one.point.iter().chain([&value]).map(|number| number.to_bits()).collect();
        let before = seen.entry((&*one.source, numbers)).or_default();
        if before.iter().any(|other| other.is_alike(one)) {
            copies.push(one);
        }
        before.push(one);
    }
    let (first, n) = (copies.first()?, copies.len());
    let (have, count_as) = match n {
        1 => ("has settings and result of another row", "counts as a run of its own"),
        _ => ("have settings and results of other rows", "count as runs of their own"),
    };
    let sentence =
        format!("{} {have} from the same source, and {count_as}. {}", count(n, "row"), if_a_slip(&first.source));
    Some(Finding::new(sentence).with("rows as others", n as f64, "1"))
}

fn if_a_slip(source: &str) -> String {
    format!("If that is a slip: `infuse import --withdraw {}`, put it right, and import it again.", as_one_word(source))
}

/// Stops using what was imported from a source.
pub(crate) fn withdraw(folder: &Path, wait: Duration, source: &str) -> Result<Output> {
    let (mut campaign, mut writer) = folder::open(folder, wait)?;
    let notices = campaign.take_notices();
    let sources: std::collections::BTreeSet<String> =
        campaign.imported().into_iter().map(|imported| imported.source).collect();
    let names: Vec<String> = sources.iter().map(|source| format!("`{source}`")).collect();
    ensure!(
        sources.contains(source),
        "nothing that is in use was imported from `{source}`, expected {}",
        match names.as_slice() {
            [] => "a source of imported experiments, of which there are none".to_owned(),
            all => format!("one of {}", all.join(", ")),
        }
    );
    let before = campaign.imported().len();
    campaign.record(&mut writer, vec![Event::Withdrawn { source: source.to_owned(), at: now() }])?;
    let n = before - campaign.imported().len();
    Ok(Output::new(&[withdrawn(n)], json!({ "withdrawn": n }), notices))
}

/// The name of all rows, and then that of the row itself: one of them is there.
fn source_of(one: &Imported, source: Option<&str>) -> String {
    match source {
        Some(source) if one.source.is_empty() => source.to_owned(),
        Some(source) => format!("{source}: {}", one.source),
        None => one.source.clone(),
    }
}
