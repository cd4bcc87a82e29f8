//! A plant with its controller and its weights, and what it costs at designs.

use bat_dynamics::Fidelity;
use water_channel::{CostWeights, FlightRequest, FlightSettings, Integrals, Rig, TestProfile, fly_all};

use crate::variable::Variable;

/// The studies that have weights of their own.
pub(super) const STUDIES: [&str; 2] = ["chapter4", "chapter7"];

#[derive(Debug, Clone)]
pub(crate) struct Candidate {
    pub(crate) rig: Rig,
    /// One for each of [`STUDIES`].
    pub(crate) weights: [CostWeights; 2],
}

/// A design in a fidelity: center of mass in per cent of chord, pitch set point in degrees, factors of the stabilizers' areas.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Spot {
    pub(super) fidelity: Fidelity,
    pub(super) design: [f64; 4],
}

impl Spot {
    /// A design of two parameters, with the stabilizers as they are.
    pub(super) fn new(fidelity: Fidelity, design: [f64; 2]) -> Self {
        Self { fidelity, design: [design[0], design[1], 1.0, 1.0] }
    }
}

/// What a flight leaves for any weights.
#[derive(Debug, Clone, Copy)]
pub(super) struct Flown {
    integrals: Integrals,
    ballast_pct_chord: f64,
}

impl Flown {
    pub(super) fn cost(&self, weights: &CostWeights) -> f64 {
        weights.cost(&self.integrals, self.ballast_pct_chord).total
    }
}

impl Candidate {
    fn request(&self, spot: &Spot) -> FlightRequest {
        let mut rig = self.rig.clone();
        for (variable, value) in Variable::ALL.into_iter().zip(spot.design) {
            variable.set(&mut rig, value);
        }
        FlightRequest { rig, fidelity: spot.fidelity }
    }
}

/// Flies every candidate at every spot; none where a flight fails.
pub(super) fn fly(
    candidates: &[Candidate],
    spots: &[Spot],
    profile: &TestProfile,
    settings: &FlightSettings,
) -> Vec<Vec<Option<Flown>>> {
    let requests: Vec<FlightRequest> =
        candidates.iter().flat_map(|candidate| spots.iter().map(|spot| candidate.request(spot))).collect();
    let flights = fly_all(&requests, profile, settings, |_| {});
    let flown = requests.iter().zip(flights).map(|(request, flight)| {
        flight
            .ok()
            .map(|flight| Flown { integrals: flight.integrals, ballast_pct_chord: request.rig.ballast_pct_chord() })
    });
    let flown: Vec<Option<Flown>> = flown.collect();
    flown.chunks(spots.len().max(1)).map(<[_]>::to_vec).collect()
}
