//! A batch designed, simulated and opened.

use anyhow::{Result, bail};
use infuse::Error;

use super::campaign::{Campaign, Stage};
use crate::campaign::{HandedOut, busy, failed_in_words, simulate_missing};
use crate::journal::{Event, Writer, now};
use crate::simulator::identity;

/// Plans that fail because their simulations do, one after the other, before a person is asked.
const ATTEMPTS: usize = 5;

/// Brings the campaign to the point where experiments are waited for, or to its end.
pub(super) fn hand_out(campaign: &mut Campaign, writer: &mut Writer, anyway: bool) -> Result<HandedOut> {
    let mut done = HandedOut::default();
    for _ in 0..ATTEMPTS {
        match campaign.its_stage()? {
            Stage::Ready => {}
            Stage::NotWorth { .. } if anyway => {}
            _ => return Ok(done),
        }
        let searching = busy(format!("designing batch {}", campaign.batch()));
        let planning = campaign.planning()?;
        searching.finish_and_clear();
        campaign.write_down(writer, planning.into_iter().collect())?;
        let missing = campaign.missing_simulations(&identity(&campaign.problem.simulator))?;
        let (folder, problem) = (campaign.folder.clone(), campaign.problem.clone());
        let grid = campaign.now.grid().clone();
        let submitted = campaign.submitted.clone();
        let simulated = simulate_missing(&folder, &problem, &grid, &missing, &submitted, |event| {
            campaign.record_simulation(writer, event)
        })?;
        done.n_simulated += simulated.n_done;
        done.notices.extend(failed_in_words(&problem, simulated.n_done, &simulated.failed));
        let batch = campaign.batch();
        campaign.failed_opening = None;
        campaign.write_down(writer, vec![Event::Opened { batch, at: now() }])?;
        match campaign.failed_opening.take() {
            None => return Ok(done),
            Some(Error::EverySimulationFailed { n_simulations, first_point, first_reason }) => {
                bail!(
                    "all {n_simulations} simulations failed, the first at {}: {first_reason}\nRepair the simulator and ask again: \
                     nothing is lost",
                    campaign.problem.describe(&first_point)
                );
            }
            Some(error) => done.notices.push(format!("{error}; other points are simulated instead")),
        }
    }
    bail!(
        "{ATTEMPTS} designs in a row could not be simulated; repair the simulator or narrow the bounds, and ask again"
    )
}
