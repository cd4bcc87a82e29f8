//! The flights of Figure 14: every design of a lattice in every configuration, with the modes of the body at each speed.

use bat_dynamics::{Fidelity, Flow};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use water_channel::{FlightError, FlightRequest, fly_all, open_loop_cost, open_loop_modes};

use super::file::{Configuration, Setup};
use crate::bat::{MODEL, STAND_IN};

/// What a design does in the open-loop test.
#[derive(Clone, Debug)]
pub(crate) struct Design {
    /// Center of mass in per cent of chord, trim pitch in degrees.
    pub(crate) at: [f64; 2],
    /// The two terms of (20), in s; or why there is no cost.
    pub(crate) outcome: Result<[f64; 2], Failure>,
    /// The fastest growth among the modes at the speeds of the test, in 1/s; or why there is no equilibrium.
    pub(crate) growth_per_s: Result<f64, String>,
}

/// Why a flight has no cost.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) enum Failure {
    /// The line that went slack.
    Slack(String),
    Other(String),
}

impl Design {
    pub(crate) fn cost(&self) -> Option<f64> {
        self.outcome.as_ref().ok().map(|terms| terms.iter().sum())
    }

    /// Whether every small disturbance dies out at every speed.
    pub(crate) fn is_stable(&self) -> bool {
        self.growth_per_s.as_ref().is_ok_and(|growth| *growth < 0.0)
    }

    /// Whether some small disturbance grows at some speed.
    pub(crate) fn is_unstable(&self) -> bool {
        self.growth_per_s.as_ref().is_ok_and(|growth| *growth >= 0.0)
    }
}

/// Every panel in the stand-in for the water channel, and in the numerical model.
pub(super) type Panels<'a> = [Vec<PanelFlights<'a>>; 2];
/// In this order.
pub(super) const FIDELITIES: [Fidelity; 2] = [STAND_IN, MODEL];

/// Every panel, flown.
pub(super) fn fly_panels(setup: &Setup, done: impl Fn(usize) + Sync) -> Panels<'_> {
    FIDELITIES.map(|fidelity| {
        let configurations = setup.configurations.iter();
        configurations.map(|configuration| PanelFlights::fly(setup, configuration, fidelity, &done)).collect()
    })
}

/// One configuration in one physics.
#[derive(Clone, Debug)]
pub(crate) struct PanelFlights<'a> {
    pub(crate) configuration: &'a Configuration,
    /// Row by row of constant trim pitch.
    pub(crate) rows: Vec<Vec<Design>>,
}

/// Every design of a panel, row by row of constant trim pitch.
pub(super) fn lattice(setup: &Setup) -> Vec<[f64; 2]> {
    let x = setup.center_of_mass.places();
    setup.trim_pitch.places().iter().flat_map(|y| x.iter().map(|x| [*x, *y])).collect()
}

/// What these designs do.
pub(super) fn fly(
    setup: &Setup,
    configuration: &Configuration,
    designs: &[[f64; 2]],
    fidelity: Fidelity,
    done: impl Fn(usize) + Sync,
) -> Vec<Design> {
    let requests: Vec<FlightRequest> = designs.iter().map(|at| setup.request(configuration, *at, fidelity)).collect();
    let flights = fly_all(&requests, &setup.profile, &setup.settings, done);
    let flows: Vec<Flow> = setup.profile.flow().knots().iter().map(|knot| knot.flow).collect();
    let growth: Vec<Result<f64, String>> = requests
        .par_iter()
        .map(|request| {
            let speeds = open_loop_modes(request, &flows).map_err(|error| error.to_string())?;
            let fastest = speeds.iter().map(water_channel::OpenLoop::growth_rate_per_s);
            fastest.reduce(f64::max).ok_or_else(|| "the test has no flow".to_owned())
        })
        .collect();
    let designs = designs.iter().zip(flights).zip(growth).map(|((at, flight), growth_per_s)| Design {
        at: *at,
        outcome: match flight {
            Ok(flight) => Ok(open_loop_cost(&flight.integrals, setup.weights.heading, setup.weights.lateral)),
            Err(FlightError::Slack { line, .. }) => Err(Failure::Slack(line.to_owned())),
            Err(other) => Err(Failure::Other(other.to_string())),
        },
        growth_per_s,
    });
    designs.collect()
}

/// The lowest cost of those that are stable; not finite where none is.
fn lowest<'a>(designs: impl Iterator<Item = &'a Design>) -> f64 {
    designs.filter(|design| design.is_stable()).filter_map(Design::cost).reduce(f64::min).unwrap_or(f64::NAN)
}

impl<'a> PanelFlights<'a> {
    pub(crate) fn fly(
        setup: &Setup,
        configuration: &'a Configuration,
        fidelity: Fidelity,
        done: impl Fn(usize) + Sync,
    ) -> Self {
        Self::of(setup, configuration, fly(setup, configuration, &lattice(setup), fidelity, done))
    }

    /// Of the designs of the [`lattice`], in its order.
    pub(super) fn of(setup: &Setup, configuration: &'a Configuration, designs: Vec<Design>) -> Self {
        let n = setup.center_of_mass.places().len();
        let mut designs = designs.into_iter();
        let rows = setup.trim_pitch.places().iter().map(|_| designs.by_ref().take(n).collect()).collect();
        Self { configuration, rows }
    }

    pub(crate) fn designs(&self) -> impl Iterator<Item = &Design> {
        self.rows.iter().flatten()
    }

    /// The lowest cost of the stable designs with the center of mass at this place along its axis; not finite where none is stable.
    pub(crate) fn lowest_at(&self, place: usize) -> f64 {
        lowest(self.rows.iter().filter_map(|row| row.get(place)))
    }

    /// The same of these designs alone, flown here.
    pub(crate) fn fly_lowest_at(setup: &Setup, configuration: &Configuration, fidelity: Fidelity, place: usize) -> f64 {
        let at = setup.center_of_mass.places().get(place).copied();
        let column: Vec<[f64; 2]> =
            at.map_or_else(Vec::new, |x| setup.trim_pitch.places().iter().map(|y| [x, *y]).collect());
        lowest(fly(setup, configuration, &column, fidelity, |_| {}).iter())
    }

    /// The stable designs that `counts`, with their costs.
    fn stable(&self, counts: impl Fn(&Design) -> bool) -> impl Iterator<Item = (&Design, f64)> {
        let stable = self.designs().filter(move |design| design.is_stable() && counts(design));
        stable.filter_map(|design| Some((design, design.cost()?)))
    }

    /// The one of the lowest cost among them.
    pub(crate) fn best(&self, counts: impl Fn(&Design) -> bool) -> Option<(&Design, f64)> {
        self.stable(counts).min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// The one of the highest cost among them.
    pub(crate) fn worst(&self, counts: impl Fn(&Design) -> bool) -> Option<(&Design, f64)> {
        self.stable(counts).max_by(|a, b| a.1.total_cmp(&b.1))
    }

    pub(crate) fn unstable(&self) -> impl Iterator<Item = &Design> {
        self.designs().filter(|design| design.is_unstable())
    }

    pub(crate) fn slack(&self) -> usize {
        self.designs().filter(|design| matches!(design.outcome, Err(Failure::Slack(_)))).count()
    }

    /// Designs without an equilibrium at some speed.
    pub(crate) fn without_equilibrium(&self) -> usize {
        self.designs().filter(|design| design.growth_per_s.is_err()).count()
    }

    pub(crate) fn other_failures(&self) -> usize {
        self.designs().filter(|design| matches!(design.outcome, Err(Failure::Other(_)))).count()
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn setup() -> Setup {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let mut setup = Setup::read(&root.join("fixtures/bat/chapter3.toml")).expect("the study file");
        setup.center_of_mass.coarsen(5);
        setup.trim_pitch.coarsen(3);
        setup
    }

    fn panels(setup: &Setup, fidelity: Fidelity) -> Vec<PanelFlights<'_>> {
        setup.configurations.iter().map(|one| PanelFlights::fly(setup, one, fidelity, |_| {})).collect()
    }

    /// The lines' layout moves neither the equilibrium nor the modes: only what a reeled line does to the pitch.
    #[test]
    fn layout_changes_costs_and_no_mode() {
        let setup = setup();
        let panels = panels(&setup, STAND_IN);
        let mut costs_differ = false;
        for (one, two) in panels[0].designs().zip(panels[3].designs()) {
            let (Ok(a), Ok(b)) = (&one.growth_per_s, &two.growth_per_s) else { continue };
            assert!((a - b).abs() < 1e-9, "growth at {:?}: {a} and {b}", one.at);
            costs_differ |= one.cost().zip(two.cost()).is_some_and(|(a, b)| (a / b - 1.0).abs() > 0.1);
        }
        assert!(costs_differ, "the perturbation acts differently");
    }

    /// Behind the joint weight and buoyancy turn the body into the flow; far enough ahead of it they turn it away.
    #[test]
    fn center_of_mass_ahead_of_the_joint_makes_the_stand_in_unstable() {
        let setup = setup();
        for panel in panels(&setup, STAND_IN) {
            let x = setup.center_of_mass.places();
            let at = |x: f64| panel.designs().filter(move |design| (design.at[0] - x).abs() < 1e-9);
            assert!(at(x[0]).all(Design::is_unstable), "{}: all unstable at {}", panel.configuration.label, x[0]);
            assert!(at(x[4]).all(Design::is_stable), "{}: all stable at {}", panel.configuration.label, x[4]);
            let (best, cost) = panel.best(|_| true).expect("some design flies");
            let (_, worst) = panel.worst(|_| true).expect("some design flies");
            let lowest =
                panel.designs().filter(|d| d.is_stable()).filter_map(Design::cost).fold(f64::INFINITY, f64::min);
            assert_eq!(cost.to_bits(), lowest.to_bits(), "the best is the lowest");
            for place in 0..x.len() {
                let alone = PanelFlights::fly_lowest_at(&setup, panel.configuration, STAND_IN, place);
                assert_eq!(alone.to_bits(), panel.lowest_at(place).to_bits(), "a column flown alone");
            }
            assert!(best.is_stable() && worst > cost, "{best:?}");
        }
    }

    /// A fin with its leading edge up lifts the stern: the same design rests at a smaller zenith angle.
    #[test]
    fn incidence_is_positive_leading_edge_up() {
        let setup = setup();
        let zenith = |configuration: &Configuration| {
            let request = setup.request(configuration, [48.0, 8.0], MODEL);
            let flow = [Flow::straight(0.245)];
            open_loop_modes(&request, &flow).expect("an equilibrium")[0].trim.coordinates[0]
        };
        let [level, down, up] = [0, 1, 2].map(|k| zenith(&setup.configurations[k]));
        assert!(up < level && level < down, "zenith angles {up}, {level}, {down}: lift pulls the tether upright");
    }
}
