//! `cargo xtask speed --flights`: what everything that is off by default costs a flight, all in turn in one run.

use std::path::Path;
use std::time::Instant;

use anyhow::{Context as _, Result};
use page::{Column, Table, quantile};
use water_channel::{
    Flight, FlightError, FlightRequest, FlightSettings, MovingWater, ProfileFile, RigFile, Sensing, SensingFile,
    Shedding, TestProfile, fly_all, fly_seeded,
};

use super::generated;
use super::tasks::{FLIGHTS, TURBULENCE, over_the_box};
use crate::kept;
use crate::reproduction::progress;
use crate::words::{number, verdict};

const PAGE: &str = "docs/results-flights.md";
/// Each variant so often, in turn.
const ROUNDS: usize = 11;
/// Steps per sample: as the studies fly, and as a flight is flown unless somebody says otherwise.
const STEPS: [usize; 2] = [1, 2];
/// What differs between the sides, in m: its center of mass, its horizontal stabilizer, its port line.
const SIDES_M: [f64; 3] = [2e-4, 0.04, 5e-4];

/// What is on.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Variant {
    words: &'static str,
    turbulence: bool,
    shedding: bool,
    asymmetry: bool,
    seed_each: bool,
    cameras: bool,
    /// How many times as long as a flight with all off it may take.
    limit: Option<f64>,
}

const OFF: Variant = Variant {
    words: "all off",
    turbulence: false,
    shedding: false,
    asymmetry: false,
    seed_each: false,
    cameras: false,
    limit: None,
};
const ALL_THREE: Variant = Variant {
    words: "turbulence, shedding and asymmetry, one water for all flights",
    turbulence: true,
    shedding: true,
    asymmetry: true,
    limit: Some(1.3),
    ..OFF
};
const VARIANTS: [Variant; 8] = [
    OFF,
    Variant { words: "turbulence in three directions", turbulence: true, ..OFF },
    Variant { words: "vortex shedding", shedding: true, ..OFF },
    Variant { words: "asymmetry", asymmetry: true, ..OFF },
    ALL_THREE,
    Variant { words: "turbulence, shedding and asymmetry, a water for each flight", seed_each: true, ..ALL_THREE },
    Variant { words: "three cameras", cameras: true, ..OFF },
    Variant {
        words: "turbulence, shedding, asymmetry and three cameras",
        cameras: true,
        limit: Some(4.0),
        ..ALL_THREE
    },
];

/// Seconds of the variants, round by round, at so many steps a sample.
struct Timed {
    steps_per_sample: usize,
    rounds: Vec<[f64; VARIANTS.len()]>,
}

/// Measured once, and by no run of this program.
const BEFORE_ANY: &str = "With all of it off a flight is no slower than before there was any of it: 0.94 times as long at one step a sample, and 0.96 at two, as \
    at revision `b3d192f`. This was measured once, on 2026-11-24 (kept with revision `43f6d30`), in lanes on one thread, six runs of each in turn, and not by the \
    run of this page; later revisions were not compared.";

/// Measures all, and writes the page.
pub(crate) fn run(root: &Path) -> Result<()> {
    let folder = root.join("fixtures/bat");
    let bench = Bench {
        profile: ProfileFile::read(folder.join("test-profile.toml"))?.profile,
        requests: over_the_box(&RigFile::read(folder.join("rig.toml"))?.rig),
        sensing: SensingFile::read(folder.join("sensing.toml"))?.sensing,
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let bar = progress("rounds of flights", STEPS.len() * (ROUNDS + 1));
    let timed = |steps_per_sample| -> Result<Timed> {
        let mut rounds = Vec::with_capacity(ROUNDS);
        for round in 0..=ROUNDS {
            let times = pool.install(|| bench.round(steps_per_sample))?;
            bar.inc(1);
            // The first is for the caches.
            if round > 0 {
                rounds.push(times);
            }
        }
        Ok(Timed { steps_per_sample, rounds })
    };
    let all = STEPS.into_iter().map(timed).collect::<Result<Vec<_>>>()?;
    bar.finish();
    let flights = generated::Flights { profile: &bench.profile, requests: &bench.requests, pool: &pool };
    let beside = flights.timed(root)?;
    kept::write(root, &[(PAGE, markdown(&all, &beside))])
}

struct Bench {
    profile: TestProfile,
    requests: Vec<FlightRequest>,
    sensing: Sensing,
}

impl Bench {
    /// Every variant once.
    fn round(&self, steps_per_sample: usize) -> Result<[f64; VARIANTS.len()]> {
        let mut seconds = [0.0; VARIANTS.len()];
        for (variant, seconds) in VARIANTS.iter().zip(&mut seconds) {
            *seconds = self.seconds(variant, steps_per_sample).context(variant.words)?;
        }
        Ok(seconds)
    }

    /// The table of the water is made within the time.
    fn seconds(&self, variant: &Variant, steps_per_sample: usize) -> Result<f64> {
        let shedding = Shedding { strouhal: 0.2, width_m: 0.092, lift_coefficient: 0.05, plane_rad: 0.5 };
        let water = MovingWater {
            turbulence: variant.turbulence.then_some(TURBULENCE),
            shedding: variant.shedding.then_some(shedding),
            seed: 1,
        };
        let profile = self.profile.clone().with_water(water)?;
        let mut requests = self.requests.clone();
        for request in &mut requests {
            if variant.asymmetry {
                let sides = &mut request.rig.plant.asymmetry;
                [sides.center_of_mass_y_m, sides.offset_lateral_m, sides.line_port_m] = SIDES_M;
            }
            request.rig.sensing = variant.cameras.then(|| self.sensing.clone());
        }
        let seeds: Vec<u64> = (0..requests.len() as u64).collect();
        let settings = FlightSettings::with_steps(steps_per_sample);
        let start = Instant::now();
        let flown = match variant.seed_each {
            true => fly_seeded(&requests, &seeds, &profile, &settings, |_| {}),
            false => fly_all(&requests, &profile, &settings, |_| {}),
        };
        let seconds = start.elapsed().as_secs_f64();
        // A flight that ends early would make a variant look cheap.
        flown.into_iter().collect::<Result<Vec<Flight>, FlightError>>()?;
        Ok(seconds)
    }
}

impl Timed {
    /// Median time of a flight in ms.
    fn median_ms(&self, variant: usize) -> f64 {
        let times: Vec<f64> = self.rounds.iter().map(|round| 1e3 * round[variant] / FLIGHTS as f64).collect();
        quantile(&times, 0.5).unwrap_or(f64::NAN)
    }

    /// How many times as long as with all off: lowest, median and highest over the rounds.
    fn ratios(&self, variant: usize) -> [f64; 3] {
        let ratios: Vec<f64> = self.rounds.iter().map(|round| round[variant] / round[0]).collect();
        [0.0, 0.5, 1.0].map(|share| quantile(&ratios, share).unwrap_or(f64::NAN))
    }
}

fn steps_words(steps_per_sample: usize) -> &'static str {
    if steps_per_sample == 1 { "one step" } else { "two steps" }
}

fn markdown(all: &[Timed], beside: &generated::Timed) -> String {
    let mut text = "# What is off by default, and what it costs\n\n".to_owned();
    for (place, variant) in VARIANTS.iter().enumerate() {
        let Some(limit) = variant.limit else { continue };
        let words = all.iter().map(|timed| {
            let [_, median, high] = timed.ratios(place);
            let word = verdict(median <= limit);
            let beyond = if median <= limit && high > limit {
                format!(", though single rounds go up to {}", number(high, 2))
            } else {
                String::new()
            };
            let steps = steps_words(timed.steps_per_sample);
            format!("{} times as long at {steps} a sample ({word}{beyond})", number(median, 2))
        });
        text += &format!(
            "- With {} a flight takes {}; the goal is at most {} times as long as with all off.\n",
            variant.words,
            words.collect::<Vec<_>>().join(", "),
            number(limit, 1)
        );
    }
    text += &beside.sentence();
    text += &format!(
        "- The studies fly one step a sample, campaigns of the ensemble with a water for each flight and without cameras.\n- {BEFORE_ANY}\n\n"
    );
    let mut table = Table::new(vec![
        Column::words("on"),
        Column::number("steps per sample", ""),
        Column::number("a flight", "ms"),
        Column::number("times as long as with all off", ""),
        Column::number("goal, at most", ""),
    ]);
    for timed in all {
        for (place, variant) in VARIANTS.iter().enumerate() {
            let [low, median, high] = timed.ratios(place).map(|ratio| number(ratio, 2));
            table.push(vec![
                variant.words.to_owned(),
                timed.steps_per_sample.to_string(),
                number(timed.median_ms(place), 2),
                format!("{median} ({low} to {high})"),
                variant.limit.map_or_else(String::new, |limit| number(limit, 1)),
            ]);
        }
    }
    text += &table.markdown();
    text += &format!(
        "\nMedians of {} rounds of one run, every variant in turn in each round, after one round for the caches; in brackets the lowest and the \
         highest ratio of a round. {FLIGHTS} flights of 300 s of the stand-in over the box of Chapter 4, four in lanes, on one thread; the making of \
         the water's table and the images are within the time.\n",
        all.first().map_or(0, |timed| timed.rounds.len())
    );
    text += &beside.section();
    text += "\nWritten by `cargo xtask speed --flights`; times are those of the machine, so that `cargo xtask ci` does not repeat them.\n";
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn goals_are_met_or_missed_by_the_median_of_the_ratios() {
        let round = |all_three: f64| {
            let mut seconds = [0.032; VARIANTS.len()];
            (seconds[4], seconds[5], seconds[7]) = (0.032 * all_three, 0.064, 0.16);
            seconds
        };
        let timed = Timed { steps_per_sample: 1, rounds: vec![round(1.2), round(1.25), round(1.9)] };
        let text = markdown(&[timed], &generated::Timed::default());
        let met = "one water for all flights a flight takes 1.25 times as long at one step a sample (met, though single rounds go up to 1.90); the goal \
                   is at most 1.3 times";
        assert!(text.contains(met), "{text}");
        assert!(
            text.contains("a water for each flight a flight takes 2.00 times as long at one step a sample (missed)"),
            "{text}"
        );
    }

    /// The page is not written anew for a sentence: its numbers are those of a run.
    #[test]
    fn the_kept_page_says_what_its_rows_say() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let page = std::fs::read_to_string(root.join(PAGE)).expect("the page");
        assert!(page.lines().any(|line| line == format!("- {BEFORE_ANY}")), "{page}");
        let highest = |row: &str| {
            let (_, rest) = row.split_once("(").expect("brackets");
            rest.split_once(" to ").and_then(|(_, high)| high.split_once(')')).expect("a range").0.to_owned()
        };
        for variant in VARIANTS.iter().filter(|variant| variant.limit.is_some()) {
            let bullet = format!("- With {} a flight takes ", variant.words);
            let bullet = page.lines().find(|line| line.starts_with(&bullet)).expect("a bullet");
            for row in page.lines().filter(|line| line.starts_with(&format!("| {} |", variant.words))) {
                let high = highest(row);
                let is_beyond = high.parse::<f64>().expect("a ratio") > variant.limit.unwrap_or(f64::NAN);
                assert_eq!(bullet.contains(&format!("single rounds go up to {high}")), is_beyond, "{bullet}\n{row}");
            }
        }
    }

    #[test]
    fn the_first_variant_has_all_off() {
        assert_eq!(VARIANTS[0], OFF);
        assert!(
            VARIANTS[1..]
                .iter()
                .all(|variant| variant.turbulence || variant.shedding || variant.asymmetry || variant.cameras)
        );
    }
}
