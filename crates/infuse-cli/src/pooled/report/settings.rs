//! The settings of the loop, as rows of the table on where all of it comes from.

use anyhow::Result;

use crate::number::{grouped, plain};
use crate::pooled::campaign::{Access, Campaign};
use crate::report::provenance::Row;

/// By their keys in the problem.
pub(super) fn rows(campaign: &Campaign) -> Result<Vec<Row>> {
    let settings = &campaign.settings;
    let simulations = match (campaign.access()?, settings.simulations) {
        (Access::Nothing, _) => "none".to_owned(),
        (Access::LookedUp, _) => "looked up where they are needed".to_owned(),
        (Access::All, _) => "all designs".to_owned(),
        (Access::Budget, Some(budget)) => format!("{budget} per batch"),
        (Access::Budget, None) => "the rows of the table, and a surface through some of them".to_owned(),
    };
    let noise = campaign.problem.rule.noise;
    let noise = noise.map_or_else(|| "learnt".to_owned(), |noise| campaign.problem.response.given(noise));
    let mut rows = vec![
        ("`method`", "pooled".to_owned()),
        ("`experiments`", format!("{} per batch", settings.n_experiments)),
        ("`simulations`", simulations),
        ("`batches`", format!("{} at most", settings.max_batches)),
        ("`confidence`", plain(settings.confidence)),
        ("`noise`", noise),
        ("`seed`", settings.seed.to_string()),
        ("designs", grouped(campaign.grid.n_cells())),
    ];
    let of_blocks = settings.blocks.map(|blocks| match blocks {
        true => "true: runs of a batch share an error",
        false => "false: runs of a batch share no error, whatever they say",
    });
    rows.extend(of_blocks.map(|words| ("`blocks`", words.to_owned())));
    if !settings.displaced {
        rows.push(("`displaced`", "false: the simulation is taken as it stands".to_owned()));
    }
    if let Some(costs) = &campaign.problem.costs {
        rows.push(("costs", costs.in_words(&campaign.problem.region)));
    }
    Ok(rows)
}
