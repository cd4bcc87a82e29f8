//! The campaigns of the pooled loop that are kept with the sources: what the page in `docs/` was written from.
//!
//! A check takes them over and runs some of them anew; who keeps writes them; every other run makes them all.

use std::path::Path;

use anyhow::{Context as _, Result, ensure};
use design_space::{Cell, Model};
use infuse::global;

use super::file::Case;
use super::pooled::{Pooled, PooledCampaign};
use crate::bat::{MODEL, STAND_IN};
use crate::costs::Cost;
use crate::costs::key::Key;
use crate::gridded::{CellCosts, Space, StandInRig};
use crate::kept::{KeptFile, SAMPLE_OF_LONG};
use crate::memory::Memory;

const REMEDY: &str = "take it back from version control, or make it anew by `cargo xtask reproduce-all --keep`";

/// The pooled loop on a case: its campaigns taken over where a check finds them, otherwise run; `finished` is called after each batch
/// that is run.
pub(super) fn pooled(
    memory: &Memory,
    case: &Case,
    rig: &StandInRig<'_>,
    budget: &global::Settings,
    seeds: &[u64],
    finished: impl Fn() + Sync,
) -> Result<Pooled> {
    let run = |seeds: &[u64]| Pooled::of(rig, budget, seeds, &finished);
    let place = |folder: &Path| Ok::<_, anyhow::Error>(file(folder, &key(case, rig, budget)?));
    if let Some(folder) = memory.kept_campaigns()
        && let Some(campaigns) = taken_over(&place(&folder)?, seeds, run)?
    {
        return Ok(Pooled { campaigns, ..run(&[])? });
    }
    let pooled = run(seeds)?;
    if let Some(folder) = memory.campaigns_to_keep() {
        place(&folder)?.write(&lines(seeds, &pooled.campaigns)?)?;
    }
    Ok(pooled)
}

fn file(folder: &Path, key: &str) -> KeptFile {
    KeptFile { path: folder.join(format!("{key}.tsv")), key: key.to_owned(), remedy: REMEDY }
}

/// A name for all that decides the campaigns but their seeds, which stand beside them: what flights follow from, noise and budget, and the
/// pooled loop of this program by what it makes of a bowl.
fn key(case: &Case, rig: &StandInRig<'_>, budget: &global::Settings) -> Result<String> {
    let region = case.space.region();
    let settings = PooledCampaign::settings(budget, 0);
    let key = Key::default()
        .with(case.bat.key(region, MODEL))
        .with(case.bat.key(region, STAND_IN))
        .with(serde_json::to_string(region)?)
        .with(rig.noise.to_le_bytes())
        .with(rig.model.range().to_le_bytes())
        .with(rig.truth.range().to_le_bytes())
        .with(serde_json::to_string(&settings)?)
        .with(fingerprint(&case.space)?);
    Ok(key.name())
}

/// What the pooled loop of this program makes of a bowl over the space of a case, with a simulation whose bottom lies elsewhere.
fn fingerprint(space: &Space) -> Result<String> {
    let [model, truth] = [0.25, 0.75].map(|lowest| Bowl { space, lowest });
    let rig = StandInRig { space, model: &model, truth: &truth, noise: 0.001, seed: 3 };
    let mut budget = global::Settings::new(Model::additive_quadratic(space.region().n_parameters())?, 6, 10);
    budget.max_batches = 2;
    lines(&[1], &Pooled::of(&rig, &budget, &[1], || ())?.campaigns)
}

/// A bowl over a space, with its bottom at this share of each range.
#[derive(Debug)]
struct Bowl<'a> {
    space: &'a Space,
    lowest: f64,
}

impl CellCosts for Bowl<'_> {
    fn cost(&self, cell: Cell) -> Cost {
        let coded = self.space.coded(cell).map_err(|error| error.to_string())?;
        // Steeper along each parameter than along the one before.
        let terms = coded.iter().zip(1_u32..).map(|(x, k)| f64::from(k) * (0.5 * (x + 1.0) - self.lowest).powi(2));
        Ok(1.0 + terms.sum::<f64>())
    }

    fn range(&self) -> f64 {
        10.0
    }
}

/// A line for each seed.
fn lines(seeds: &[u64], campaigns: &[PooledCampaign]) -> Result<String> {
    let line = |(seed, campaign): (&u64, &PooledCampaign)| {
        let flies = campaign.steps.iter().all(|step| step.cost.is_finite());
        ensure!(flies, "pooled loop, seed {seed}: a design that was recommended does not fly, and cannot be kept");
        Ok(format!("{seed}\t{}\n", serde_json::to_string(campaign)?))
    };
    seeds.iter().zip(campaigns).map(line).collect()
}

/// The campaigns of a file, if this program runs the same: of every so many one is run anew, and has to come out the same bit for bit;
/// nothing if there is no file.
fn taken_over(
    file: &KeptFile,
    seeds: &[u64],
    run: impl Fn(&[u64]) -> Result<Pooled>,
) -> Result<Option<Vec<PooledCampaign>>> {
    let Some(rows) = file.rows()? else { return Ok(None) };
    let sample: Vec<u64> = seeds.iter().step_by(SAMPLE_OF_LONG).copied().collect();
    let anew = lines(&sample, &run(&sample)?.campaigns)?;
    for (kept, anew) in rows.lines().step_by(SAMPLE_OF_LONG).zip(anew.lines()) {
        file.ensure_same("a campaign of the pooled loop", &kept, &anew)?;
    }
    let read = |line: &str| -> Result<(u64, PooledCampaign)> {
        let (seed, campaign) = line.split_once('\t').context("a line without a seed")?;
        Ok((seed.parse()?, serde_json::from_str(campaign)?))
    };
    let read: Vec<(u64, PooledCampaign)> =
        rows.lines().map(read).collect::<Result<_>>().with_context(|| format!("{}; {REMEDY}", file.path.display()))?;
    let (kept, campaigns): (Vec<u64>, Vec<PooledCampaign>) = read.into_iter().unzip();
    ensure!(kept == seeds, "{}: seeds {kept:?}, needed are {seeds:?}; {REMEDY}", file.path.display());
    Ok(Some(campaigns))
}

#[cfg(test)]
mod tests {
    use super::*;
    use infuse::pooled::Certificate;

    use crate::chapter7::pooled::PooledStep;

    fn campaign(seed: u64) -> PooledCampaign {
        let certificate = Certificate { probability: 0.9, bound: 0.1 + 0.2, quantile: 1e-300 };
        PooledCampaign {
            steps: vec![PooledStep { cost: 2.0 + seed as f64 / 3.0, certificate }],
            n_experiments: 12,
            n_simulations: 24,
        }
    }

    fn pooled(seeds: &[u64]) -> Result<Pooled> {
        Ok(Pooled { campaigns: seeds.iter().map(|seed| campaign(*seed)).collect(), center_cost: 3.0 })
    }

    #[test]
    fn campaigns_are_taken_over_as_they_were_kept_and_changed_ones_are_noticed() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = file(folder.path(), "abc");
        let seeds: Vec<u64> = (1..=12).collect();
        assert!(taken_over(&file, &seeds, pooled).expect("no file").is_none());
        let rows = lines(&seeds, &pooled(&seeds).expect("campaigns").campaigns).expect("lines");
        file.write(&rows).expect("written");
        let taken = taken_over(&file, &seeds, pooled).expect("the same").expect("campaigns");
        assert_eq!(lines(&seeds, &taken).expect("lines"), rows);
        let refused = |rows: &str, seeds: &[u64]| {
            file.write(rows).expect("written");
            taken_over(&file, seeds, pooled).err().map(|error| format!("{error:#}"))
        };
        // The first and the eleventh are of the sample.
        for (from, to) in [("1\t{", "2\t{"), ("2.3333333333333335", "2.333333333333334"), ("\n11\t", "\n13\t")] {
            let error = refused(&rows.replacen(from, to, 1), &seeds).expect("it was changed");
            assert!(error.contains("abc.tsv") && error.contains("this program finds"), "{error}");
        }
        let error = refused(&rows, &seeds[..11]).expect("one too many");
        assert!(error.contains("needed are"), "{error}");
        let error = refused(&rows.replacen("\n2\t{", "\n2\t", 1), &seeds).expect("no JSON");
        assert!(error.contains("abc.tsv") && error.contains("--keep"), "{error}");
        assert_eq!(refused(&rows, &seeds), None);
    }

    #[test]
    fn a_campaign_that_recommends_what_does_not_fly_is_not_kept() {
        let mut campaigns = vec![campaign(1)];
        campaigns[0].steps[0].cost = f64::NAN;
        assert!(lines(&[1], &campaigns).is_err());
    }
}
