//! What noise does to the loop: readings of its campaigns, seed by seed.

use infuse::gradient;

use super::file::{Setup, Table3Row};
use super::loops::Seeded;
use super::rows::fall_pct;
use crate::bat::STAND_IN;
use page::Column;

/// What is followed over the noise seeds.
pub(crate) struct Followed {
    pub(crate) column: Column,
    /// The name of its picture.
    pub(crate) picture: &'static str,
    /// Of an iteration of a campaign.
    pub(crate) of: fn(&Setup, &gradient::Report) -> f64,
    pub(crate) published: fn(&Table3Row) -> f64,
}

/// Both parameters and both costs.
pub(crate) fn followed(setup: &Setup) -> [Followed; 4] {
    [
        Followed {
            column: setup.variable(0).column(),
            picture: "seeds-center-of-mass",
            of: |_, report| report.numerical.point[0],
            published: |row| row.center_of_mass,
        },
        Followed {
            column: setup.variable(1).column(),
            picture: "seeds-pitch",
            of: |_, report| report.numerical.point[1],
            published: |row| row.pitch_set_point,
        },
        Followed {
            column: Column::new("Corrected numerical cost", "s"),
            picture: "seeds-corrected-cost",
            of: |_, report| report.numerical.corrected_cost,
            published: |row| row.corrected_cost,
        },
        Followed {
            column: Column::new("True cost in the stand-in", "s"),
            picture: "seeds-experiment-cost",
            of: experiment_cost,
            published: |row| row.experiment_cost,
        },
    ]
}

/// What the design of an iteration costs in the stand-in, noise taken off.
fn experiment_cost(setup: &Setup, report: &gradient::Report) -> f64 {
    setup.bat.cost(&report.numerical.point, STAND_IN).unwrap_or(f64::NAN)
}

/// `values[iteration][seed]`.
pub(crate) fn over_seeds(setup: &Setup, seeded: &Seeded, followed: &Followed) -> Vec<Vec<f64>> {
    let longest = seeded.campaigns.iter().map(|(_, campaign)| campaign.reports.len()).max().unwrap_or(0);
    let of_iteration = |k: usize| {
        let reports = seeded.campaigns.iter().filter_map(|(_, campaign)| campaign.reports.get(k));
        reports.map(|report| (followed.of)(setup, report)).collect()
    };
    (0..longest).map(of_iteration).collect()
}

/// Falls of the experimental cost, noise taken off, from the first to the last iteration, seed by seed, in per cent.
pub(crate) fn falls_pct(setup: &Setup, seeded: &Seeded) -> Vec<f64> {
    let ends =
        seeded.campaigns.iter().filter_map(|(_, campaign)| campaign.reports.first().zip(campaign.reports.last()));
    ends.map(|(first, last)| fall_pct(experiment_cost(setup, first), experiment_cost(setup, last))).collect()
}
