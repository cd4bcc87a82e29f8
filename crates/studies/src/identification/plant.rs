//! The numerical model with unknown numbers, and the stand-in as it is read.

use infuse::gradient::{Reading, Trial, UncertainModel};
use infuse::identification::Answer;
use water_channel::{BoundedNoise, FlightRequest, N_TERMS};

use super::file::{Study, Weights};
use super::flights::{Flown, Pair};
use crate::bat::{MODEL, STAND_IN};
use crate::calibration::Candidate;
use crate::costs::Cost;

/// The numerical model of a plant of which some numbers are unknown.
pub(super) struct Doubted<'a>(pub(super) &'a Study);

impl Doubted<'_> {
    fn request(&self, (unknowns, design): Pair<'_>) -> Result<FlightRequest, String> {
        let bat = &self.0.setup.bat;
        if unknowns.is_empty() {
            return Ok(bat.request(design, STAND_IN));
        }
        let mut request = bat.request(design, MODEL);
        let (_, weights) = bat.rig_and_weights();
        let mut candidate = Candidate { rig: request.rig, weights: [*weights; 2] };
        for (free, value) in self.0.free.iter().zip(unknowns) {
            free.set(&mut candidate, *value).map_err(|error| error.to_string())?;
        }
        request.rig = candidate.rig;
        Ok(request)
    }

    /// The cost, term by term, of every pair of unknowns and a design, flown side by side unless they are known.
    pub(super) fn fly(&self, pairs: &[Pair<'_>]) -> Vec<Flown> {
        self.0.flights.of(pairs, |pairs| self.fly_anew(pairs))
    }

    /// The same, all flown and none remembered.
    pub(super) fn fly_anew(&self, pairs: &[Pair<'_>]) -> Vec<Flown> {
        let requests: Vec<Result<FlightRequest, String>> = pairs.iter().map(|pair| self.request(*pair)).collect();
        let ready: Vec<FlightRequest> = requests.iter().flatten().cloned().collect();
        let mut flown = self.0.setup.bat.breakdowns(&ready).into_iter();
        let mut next = || flown.next().unwrap_or_else(|| Err("no flight".to_owned()));
        requests.into_iter().map(|request| request.and_then(|_| next())).collect()
    }

    /// The stand-in at designs, without noise.
    pub(super) fn stand_in(&self, designs: &[Vec<f64>]) -> Vec<Flown> {
        let pairs: Vec<Pair<'_>> = designs.iter().map(|design| (&[][..], &design[..])).collect();
        self.fly(&pairs)
    }
}

impl UncertainModel for Doubted<'_> {
    fn cost(&mut self, unknowns: &[f64], design: &[f64]) -> Cost {
        let flown = self.fly(&[(unknowns, design)]).pop();
        flown.unwrap_or_else(|| Err("no flight".to_owned())).map(|cost| cost.total)
    }

    fn responses(&mut self, unknowns: &[Vec<f64>], designs: &[Vec<f64>]) -> Vec<Vec<Answer>> {
        let pairs: Vec<(&[f64], &[f64])> =
            unknowns.iter().flat_map(|theta| designs.iter().map(move |design| (&theta[..], &design[..]))).collect();
        let terms = |flown: Flown| flown.map(|cost| cost.terms[..N_TERMS].to_vec());
        let mut answers = self.fly(&pairs).into_iter().map(terms);
        unknowns.iter().map(|_| answers.by_ref().take(designs.len()).collect()).collect()
    }
}

/// Numbers of draws for terms begin here, above those of trials.
const TERMS_FROM: u64 = 1000;

/// The stand-in at a batch of designs, flown side by side and read with noise; without a seed there is none.
pub(super) fn readings(
    study: &Study,
    weights: Weights,
    noise: Option<&BoundedNoise>,
    trials: &[Trial],
) -> Vec<Result<Reading, String>> {
    let designs: Vec<Vec<f64>> = trials.iter().map(|trial| trial.point.clone()).collect();
    let flown = Doubted(study).stand_in(&designs);
    let both = trials.iter().zip(flown);
    both.map(|(trial, flown)| {
        let flown = flown?;
        let read = |value, number| noise.map_or(value, |noise| noise.measured(value, number));
        let number = trial.id.number();
        let term = |k: usize| read(flown.terms[k], TERMS_FROM + number * N_TERMS as u64 + k as u64);
        let responses: Vec<f64> = (0..N_TERMS).map(term).collect();
        let cost = read(flown.total, number);
        // Of noise that is uniform within a share.
        let deviation = study.setup.file.noise.share / 3.0_f64.sqrt();
        let standard_deviations = responses.iter().map(|response| {
            deviation
                * match weights {
                    Weights::Cost => cost,
                    Weights::Reading => response.abs(),
                }
        });
        Ok(Reading { cost, standard_deviations: standard_deviations.collect(), responses })
    })
    .collect()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn with_the_unknowns_of_the_rig_file_the_model_is_that_of_all_chapters() {
        let study = Study::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")).expect("a study");
        let design = [48.0, 12.0];
        let flown = Doubted(&study).fly_anew(&[(study.unknowns.start(), &design), (&[], &design)]);
        let costs = flown.into_iter().map(|flown| flown.map(|cost| cost.total));
        let bat = &study.setup.bat;
        assert_eq!(costs.collect::<Vec<_>>(), [MODEL, STAND_IN].map(|fidelity| bat.cost(&design, fidelity)));
    }
}
