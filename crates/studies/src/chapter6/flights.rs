//! How the optima of the first and of the last iteration fly in the truth.

use anyhow::{Context as _, Result};
use infuse::global;
use water_channel::LogRow;

use super::campaigns::Ended;
use super::file::{Case, Setup};
use crate::blind::Blind;
use crate::logged::Logged;

/// The optimum of the first and of the last iteration, flown in the truth.
#[derive(Clone, Debug)]
pub(crate) struct BeforeAfter {
    pub(crate) space: usize,
    pub(crate) truth: usize,
    pub(crate) designs: [Flown; 2],
    /// Designs that nobody chose.
    pub(crate) blind: Blind<Flown>,
}

/// How a design flies.
#[derive(Clone, Debug)]
pub(crate) struct Flown {
    pub(crate) point: Vec<f64>,
    pub(crate) cost: f64,
    pub(crate) heading_deg2: f64,
    pub(crate) zenith_deg: f64,
    pub(crate) footprint_m2: f64,
}

/// The optima of a campaign for each of these spaces and truths.
pub(crate) fn all(setup: &Setup, shown: &[&Ended]) -> Result<Vec<BeforeAfter>> {
    shown.iter().map(|ended| before_after(setup, ended)).collect()
}

fn before_after(setup: &Setup, ended: &Ended) -> Result<BeforeAfter> {
    let Case { space, truth, .. } = ended.case;
    let read = |point: &[f64], logged: Logged| Flown {
        cost: logged.cost.total,
        heading_deg2: logged.mean(|row| row.heading_rad.to_degrees().powi(2)),
        zenith_deg: logged.mean(|row| row.zenith_rad().to_degrees()),
        footprint_m2: logged.mean(LogRow::footprint_m2),
        point: point.to_vec(),
    };
    let fly = |points: &[Vec<f64>]| setup.spaces[space].bat.read_logged(points, setup.truth(truth).fidelity(), read);
    let optimum = |report: Option<&global::Report>| -> Result<Vec<f64>> {
        Ok(report.context("no iteration was made")?.screening.optimum.clone())
    };
    let reports = ended.campaign.reports();
    let optima = [optimum(reports.first())?, optimum(reports.last())?];
    let mut flown = fly(&optima).into_iter();
    let mut next = || -> Result<Flown> { flown.next().context("as many flights as designs")? };
    let designs = [next()?, next()?];
    Ok(BeforeAfter { space, truth, designs, blind: Blind::read(setup.spaces[space].space.region(), fly) })
}
