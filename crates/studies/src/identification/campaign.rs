//! One campaign: what it did iteration by iteration, and what it identified in the end.

use anyhow::{Context as _, Result};
use infuse::gradient::{IdentifyingLoop, Mechanism};
use infuse::identification::{Identification, RangeEnd};
use water_channel::BoundedNoise;

use super::file::Study;
use super::plant::{Doubted, readings};
use super::store::{Found, Kept, KeptTurn, KeptUnknown};
use super::which::Which;

/// Runs a campaign from its start to its end.
pub(super) fn run_campaign(study: &Study, which: Which) -> Result<Kept> {
    let entry = &study.loops[which.index];
    let share = study.setup.file.noise.share;
    let noise = which.seed.map(|seed| BoundedNoise::new(share, seed)).transpose()?;
    let mut campaign = IdentifyingLoop::new(
        study.setup.problem.clone(),
        study.loop_settings(),
        entry.mechanism,
        study.unknowns.clone(),
        Study::responses(),
        study.fit,
    )?;
    let mut experiments = |trials: &[_]| readings(study, entry.weights, noise.as_ref(), trials);
    let mut model = Doubted(study);
    campaign.run(&mut model, &mut experiments).with_context(|| entry.label.clone())?;
    // The last experiments are fitted, too.
    let identifies = entry.mechanism != Mechanism::ResponseCorrection;
    let found = if identifies { Some(campaign.identified(&mut model)?) } else { None };
    let turns = campaign.turns().iter().map(|turn| KeptTurn {
        design: turn.report.numerical.point.clone(),
        model_cost: turn.report.numerical.model_cost,
        corrected_cost: turn.report.numerical.corrected_cost,
        measured_cost: turn.report.experiment_cost,
        unknowns: turn.unknowns.clone(),
        carried_slope: turn.carried.slope().to_vec(),
        carried_offset: turn.carried.offset(),
    });
    Ok(Kept { which, turns: turns.collect(), found: found.as_ref().map(kept) })
}

fn kept(found: &Identification) -> Found {
    let unknown = |estimate: &infuse::identification::Estimate| KeptUnknown {
        value: estimate.value,
        standard_error: estimate.standard_error,
        bound: estimate.bound.map(|bound| if bound == RangeEnd::Lower { "lower" } else { "upper" }.to_owned()),
    };
    Found {
        unknowns: found.estimates.iter().map(unknown).collect(),
        misfit: found.sigma,
        singular_values: found.singular_values.clone(),
        warnings: found.warnings(),
    }
}
