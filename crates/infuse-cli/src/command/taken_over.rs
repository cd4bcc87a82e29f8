//! Experiments of another campaign of the same rig, as one with other bounds or levels takes them over.

use std::path::Path;

use anyhow::{Context as _, Result, anyhow, bail, ensure};
use design_space::Parameter;

use crate::campaign::{Campaign, Imported};
use crate::folder;
use crate::journal::{Constrained, Measured};
use crate::number::plain;
use crate::problem::{PROBLEM, Problem};
use crate::sheet::setting_fault;

/// Its experiments, and how many of them are of settings that are of no use here.
#[derive(Debug)]
pub(super) struct TakenOver {
    pub(super) found: Vec<Imported>,
    pub(super) n_left_out: usize,
}

/// All that was told or imported there, with the parameters in the order of this problem.
pub(super) fn of_campaign(other: &Path, own: &Path, problem: &Problem) -> Result<TakenOver> {
    let is_own = other.canonicalize().ok().zip(own.canonicalize().ok()).is_some_and(|(other, own)| other == own);
    ensure!(!is_own, "{} is the folder of this campaign, expected that of another, or a table", other.display());
    let there = folder::read(other)?;
    let (found, n_left_out) = experiments(&*there, problem).with_context(|| other.display().to_string())?;
    ensure!(
        !found.is_empty(),
        "{}: no experiment there has a result of use here, expected at least one",
        other.display()
    );
    Ok(TakenOver { found, n_left_out })
}

/// Where an experiment comes from, and what was written beside it.
struct Of<'a> {
    source: &'a str,
    note: &'a str,
}

fn experiments(there: &dyn Campaign, problem: &Problem) -> Result<(Vec<Imported>, usize)> {
    let order = order(there.problem(), problem)?;
    let (theirs, ours) = (there.problem().region.parameters(), problem.region.parameters());
    let (mut found, mut n_left_out) = (Vec::new(), 0);
    let mut take = |settings: &[f64], result: &Measured, constrained: &Constrained, of: Of<'_>, name: String| {
        let settings = order.iter().zip(ours).map(|(&at, own)| as_here(&theirs[at], own, settings[at]));
        let Some(point) = settings.collect::<Option<Vec<f64>>>() else {
            n_left_out += 1;
            return Ok(());
        };
        if let Some((value, expected)) = result.value().and_then(|value| Some((value, problem.response.fault(value)?)))
        {
            bail!("{name} gave {}, expected {expected}", plain(value));
        }
        let constrained = problem.of_constraints(constrained.clone());
        let (source, note) = (of.source.to_owned(), of.note.to_owned());
        found.push(Imported { point, result: result.clone(), constrained, source, note });
        Ok(())
    };
    for one in there.imported() {
        let name = format!("what was imported from `{}`", one.source);
        take(&one.point, &one.result, &one.constrained, Of { source: &one.source, note: &one.note }, name)?;
    }
    let (experiments, none) = (there.experiments(), Constrained::new());
    for (&id, reading) in &experiments.readings {
        let runs =
            reading.first.iter().map(|first| (0, first)).chain(reading.again.iter().map(|(&run, again)| (run, again)));
        for (run, result) in runs {
            let constrained = reading.constrained.get(&run).unwrap_or(&none);
            let note = if run == 0 { reading.note.as_str() } else { "" };
            take(
                &experiments.settings_of(id),
                result,
                constrained,
                Of { source: "", note },
                format!("experiment {id}"),
            )?;
        }
    }
    Ok((found, n_left_out))
}

/// Where each of our parameters stands there. What is measured has to be the same, and all that was set.
fn order(theirs: &Problem, ours: &Problem) -> Result<Vec<usize>> {
    let same = |what: &str, there: &str, here: &str| {
        ensure!(there == here, "its {PROBLEM} has {what} {there:?} and this one {here:?}, expected the same");
        Ok(())
    };
    same("as the name of the response", &theirs.response.name, &ours.response.name)?;
    same("as the unit of the response", &theirs.response.unit, &ours.response.unit)?;
    for held in &ours.constraints {
        if let Some(there) = theirs.constraints.iter().find(|there| there.name() == held.name()) {
            same(&format!("as the unit of `{}`", held.name()), &there.unit, &held.unit)?;
        }
    }
    if let Some(unknown) = theirs.names().find(|name| ours.region.index_of(name).is_none()) {
        bail!("its parameter `{unknown}` is none of this campaign, expected the same parameters");
    }
    let place = |own: &Parameter| {
        let name = own.name();
        let at = theirs.region.index_of(name);
        let at = at.ok_or_else(|| anyhow!("it has no parameter `{name}`, expected the same parameters"))?;
        let there = &theirs.region.parameters()[at];
        ensure!(
            there.choices().is_some() == own.choices().is_some(),
            "`{name}` is a choice in one of the campaigns and a number in the other, expected the same"
        );
        same(&format!("as the unit of `{name}`"), there.unit(), own.unit())?;
        Ok(at)
    };
    ours.region.parameters().iter().map(place).collect()
}

/// A setting as it is here; none if it is no setting here.
fn as_here(there: &Parameter, here: &Parameter, value: f64) -> Option<f64> {
    let value = match there.choice(value) {
        Some(choice) => here.of_choice(choice)?,
        None => value,
    };
    setting_fault(here, value).is_none().then_some(value)
}
