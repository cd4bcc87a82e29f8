//! The flights of Figure 14: every design of a lattice in every configuration, with the modes of the body at each speed.

use bat_dynamics::{Fidelity, Flow};
use rayon::prelude::*;
use water_channel::{FlightError, FlightRequest, fly_all, open_loop_cost, open_loop_modes};

use super::file::{Configuration, Setup};

/// What a design does in the open-loop test.
#[derive(Clone, Debug)]
pub(crate) struct Design {
    /// Center of mass in per cent of chord, trim pitch in degrees.
    pub(crate) at: [f64; 2],
    /// The two terms of (20), in s; or why there is no cost.
    pub(crate) outcome: Result<[f64; 2], Failure>,
    /// The fastest growth among the modes at the speeds of the test, in 1/s; not a number where there is no equilibrium.
    pub(crate) growth_per_s: f64,
}

/// Why a flight has no cost.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Failure {
    Slack(&'static str),
    Other(String),
}

impl Design {
    pub(crate) fn cost(&self) -> Option<f64> {
        self.outcome.as_ref().ok().map(|terms| terms.iter().sum())
    }

    /// Whether every small disturbance dies out at every speed.
    pub(crate) fn is_stable(&self) -> bool {
        self.growth_per_s < 0.0
    }
}

/// One configuration in one physics.
#[derive(Clone, Debug)]
pub(crate) struct PanelFlights<'a> {
    pub(crate) configuration: &'a Configuration,
    /// Row by row of constant trim pitch.
    pub(crate) rows: Vec<Vec<Design>>,
}

impl<'a> PanelFlights<'a> {
    pub(crate) fn fly(
        setup: &Setup,
        configuration: &'a Configuration,
        fidelity: Fidelity,
        landed: impl Fn(usize) + Sync,
    ) -> Self {
        let x = setup.center_of_mass.places();
        let designs: Vec<[f64; 2]> =
            setup.trim_pitch.places().iter().flat_map(|y| x.iter().map(|x| [*x, *y])).collect();
        let requests: Vec<FlightRequest> =
            designs.iter().map(|at| setup.request(configuration, *at, fidelity)).collect();
        let flights = fly_all(&requests, &setup.profile, &setup.settings, landed);
        let flows: Vec<Flow> = setup.profile.flow().knots().iter().map(|knot| knot.flow).collect();
        let growth: Vec<f64> = requests
            .par_iter()
            .map(|request| {
                let speeds = open_loop_modes(request, &flows).unwrap_or_default();
                let fastest = speeds.iter().map(water_channel::OpenLoop::growth_rate_per_s);
                fastest.reduce(f64::max).unwrap_or(f64::NAN)
            })
            .collect();
        let mut designs = designs.iter().zip(flights).zip(growth).map(|((at, flight), growth_per_s)| Design {
            at: *at,
            outcome: match flight {
                Ok(flight) => Ok(open_loop_cost(&flight.integrals, setup.weights.heading, setup.weights.lateral)),
                Err(FlightError::Slack { line, .. }) => Err(Failure::Slack(line)),
                Err(other) => Err(Failure::Other(other.to_string())),
            },
            growth_per_s,
        });
        let rows = setup.trim_pitch.places().iter().map(|_| designs.by_ref().take(x.len()).collect()).collect();
        Self { configuration, rows }
    }

    pub(crate) fn designs(&self) -> impl Iterator<Item = &Design> {
        self.rows.iter().flatten()
    }

    /// The stable design of the lowest cost among those that `counts`.
    pub(crate) fn best(&self, counts: impl Fn(&Design) -> bool) -> Option<(&Design, f64)> {
        self.designs()
            .filter(|design| design.is_stable() && counts(design))
            .filter_map(|design| Some((design, design.cost()?)))
            .min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// The stable design of the highest cost among those that `counts`.
    pub(crate) fn worst(&self, counts: impl Fn(&Design) -> bool) -> Option<(&Design, f64)> {
        self.designs()
            .filter(|design| design.is_stable() && counts(design))
            .filter_map(|design| Some((design, design.cost()?)))
            .max_by(|a, b| a.1.total_cmp(&b.1))
    }

    pub(crate) fn unstable(&self) -> impl Iterator<Item = &Design> {
        self.designs().filter(|design| !design.is_stable())
    }

    pub(crate) fn slack(&self) -> usize {
        self.designs().filter(|design| matches!(design.outcome, Err(Failure::Slack(_)))).count()
    }

    pub(crate) fn other_failures(&self) -> usize {
        self.designs().filter(|design| matches!(design.outcome, Err(Failure::Other(_)))).count()
    }
}
