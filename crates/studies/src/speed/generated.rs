//! Flights beside the same flights by C code that CasADi writes, all in turn in one run.

use std::path::Path;
use std::time::Instant;

use anyhow::{Context as _, Result, ensure};
use page::{Column, Table, quantile};
use rayon::ThreadPool;
use water_channel::{
    CostFile, CostWeights, Flight, FlightError, FlightRequest, FlightSettings, TestProfile, fly, fly_all,
};

use super::tasks::FLIGHTS;
use super::theirs::Theirs;
use crate::words::{number, verdict};

const PROGRAM: &str = "fixtures/peers/flights.py";
const NEEDED: &str = "CasADi, numpy and scipy, and a compiler for C that is called cc";
/// Each way so often, in turn.
const ROUNDS: usize = 11;
/// The costs of all flights sum to the same, relative.
const SAME: f64 = 1e-9;

/// A way to fly.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Way {
    Lanes,
    Alone,
    Generated,
}

const WAYS: [(Way, &str); 3] =
    [(Way::Lanes, "ours, four in lanes"), (Way::Alone, "ours, one alone"), (Way::Generated, "CasADi's C code")];
/// How many times as long as ours in lanes CasADi's code shall take.
const GOAL: f64 = 11.0;

/// Seconds of the ways, round by round.
#[derive(Default)]
pub(super) struct Timed {
    rounds: Vec<[f64; WAYS.len()]>,
    versions: String,
}

/// What is flown.
pub(super) struct Flights<'a> {
    pub(super) profile: &'a TestProfile,
    pub(super) requests: &'a [FlightRequest],
    pub(super) pool: &'a ThreadPool,
}

impl Flights<'_> {
    /// All ways in turn; the costs must be the same.
    pub(super) fn timed(&self, root: &Path) -> Result<Timed> {
        let weights = CostFile::read(root.join("fixtures/bat/cost-chapter4.toml"))?.weights;
        let mut theirs = Theirs::start(root, PROGRAM, NEEDED)?;
        let mut rounds = Vec::with_capacity(ROUNDS);
        for round in 0..=ROUNDS {
            let mut seconds = [0.0; WAYS.len()];
            let mut sums = [0.0; WAYS.len()];
            for (place, (way, words)) in WAYS.iter().enumerate() {
                let flown = match way {
                    Way::Lanes => self.pool.install(|| self.ours(&weights, true)),
                    Way::Alone => self.pool.install(|| self.ours(&weights, false)),
                    Way::Generated => theirs.run("fly"),
                };
                (seconds[place], sums[place]) = flown.context(*words)?;
                let is_same = (sums[place] - sums[0]).abs() <= SAME * sums[0].abs();
                ensure!(is_same, "{words}: the costs sum to {}, those of our flights to {}", sums[place], sums[0]);
            }
            // The first is for the caches.
            if round > 0 {
                rounds.push(seconds);
            }
        }
        Ok(Timed { rounds, versions: theirs.versions().to_owned() })
    }

    /// Seconds for all flights, and the sum of their costs.
    fn ours(&self, weights: &CostWeights, in_lanes: bool) -> Result<(f64, f64)> {
        let settings = FlightSettings::with_steps(1);
        let start = Instant::now();
        let flown: Vec<Result<Flight, FlightError>> = if in_lanes {
            fly_all(self.requests, self.profile, &settings, |_| {})
        } else {
            self.requests.iter().map(|request| fly(request, self.profile, &settings)).collect()
        };
        let seconds = start.elapsed().as_secs_f64();
        let mut sum = 0.0;
        for (request, flight) in self.requests.iter().zip(flown) {
            let body = &request.rig.plant.body;
            let ballast_pct_chord = 100.0 * (body.center_of_mass_x - body.center_of_buoyancy_x);
            sum += weights.cost(&flight?.integrals, ballast_pct_chord).total;
        }
        Ok((seconds, sum))
    }
}

impl Timed {
    /// How many times as long as ours in lanes: lowest, median and highest over the rounds.
    fn ratios(&self, way: usize) -> [f64; 3] {
        let ratios: Vec<f64> = self.rounds.iter().map(|round| round[way] / round[0]).collect();
        [0.0, 0.5, 1.0].map(|share| quantile(&ratios, share).unwrap_or(f64::NAN))
    }

    fn median_ms(&self, way: usize) -> f64 {
        let times: Vec<f64> = self.rounds.iter().map(|round| 1e3 * round[way] / FLIGHTS as f64).collect();
        quantile(&times, 0.5).unwrap_or(f64::NAN)
    }

    /// What was found, in a sentence.
    pub(super) fn sentence(&self) -> String {
        let ratio = self.ratios(2)[1];
        format!(
            "- C code that CasADi writes of an independent model of the same plant takes {} times as long as ours in lanes ({}; the goal is at least {} times, \
             which would be {} ms a flight of ours), and {} times as long as ours alone.\n",
            number(ratio, 1),
            verdict(ratio >= GOAL),
            number(GOAL, 0),
            number(self.median_ms(2) / GOAL, 2),
            number(self.median_ms(2) / self.median_ms(1), 1),
        )
    }

    pub(super) fn section(&self) -> String {
        let mut table = Table::new(vec![
            Column::words("flown by"),
            Column::number("a flight", "ms"),
            Column::number("times as long as ours in lanes", ""),
        ]);
        for (place, (_, words)) in WAYS.iter().enumerate() {
            let [low, median, high] = self.ratios(place).map(|ratio| number(ratio, 2));
            table.push(vec![
                (*words).to_owned(),
                number(self.median_ms(place), 2),
                format!("{median} ({low} to {high})"),
            ]);
        }
        format!(
            "\n## Beside generated code\n\n{}\nThe same {FLIGHTS} flights with all off and one step a sample, on one thread; medians of {} rounds, \
             all ways in turn in each. The generated code is the right-hand side of `fixtures/generate/plant.py` with the quadratures of the cost; \
             `{PROGRAM}` flies it from C. The costs of all ways sum to the same within {SAME:e}, in each round. {}.\n",
            table.markdown(),
            self.rounds.len(),
            self.versions
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratios_are_those_of_each_round_to_our_lanes() {
        let timed = |theirs: f64| Timed {
            rounds: vec![[0.05, 0.2, theirs], [0.1, 0.4, 2.0 * theirs], [0.05, 0.1, 1.5 * theirs]],
            versions: "CasADi 0".to_owned(),
        };
        let text = timed(0.6).sentence();
        assert!(
            text.contains("takes 12.0 times as long as ours in lanes (met;")
                && text.contains("4.5 times as long as ours alone"),
            "{text}"
        );
        assert!(timed(0.5).sentence().contains("10.0 times as long as ours in lanes (missed;"));
        let section = timed(0.5).section();
        assert!(section.contains("| ours, one alone | 12.50 | 4.00 (2.00 to 4.00) |"), "{section}");
        assert!(section.contains("| CasADi's C code | 46.88 | 10.00 (10.00 to 15.00) |"), "{section}");
    }
}
