//! The mean flow of a test from sample to sample: what all waters of the test share, whatever their seed.

use bat_dynamics::FlowHistory;

use crate::error::Error;
use crate::turbulence::Passage;

/// The mean flow over the samples of a test.
#[derive(Clone, Debug)]
pub(crate) struct Course {
    sample_time_s: f64,
    samples: usize,
    stretches: Vec<Stretch>,
}

/// Samples in a row in which the mean flow is the same; it seldom changes.
#[derive(Clone, Debug)]
pub(crate) struct Stretch {
    pub(crate) samples: usize,
    /// Just after each sample and just before the next.
    pub(crate) speeds_m_s: [f64; 2],
    /// From each sample to the next.
    pub(crate) passage: Passage,
}

impl Course {
    /// Of a test of `duration_s`, at samples `sample_time_s` apart, for gusts of the length `length_m`.
    ///
    /// # Errors
    /// [`Error::Argument`] for a sample time that gives no sample.
    pub(crate) fn new(flow: &FlowHistory, duration_s: f64, sample_time_s: f64, length_m: f64) -> Result<Self, Error> {
        let count = samples(duration_s, sample_time_s)?;
        // By how many lengths the mean flow moves on between two samples.
        let per_length = 0.5 * sample_time_s / length_m;
        let mut stretches: Vec<Stretch> = Vec::new();
        for speeds_m_s in speeds(flow, count, sample_time_s) {
            match stretches.last_mut() {
                Some(last) if last.speeds_m_s.map(f64::to_bits) == speeds_m_s.map(f64::to_bits) => last.samples += 1,
                _ => {
                    let passage = Passage::over(per_length * (speeds_m_s[0] + speeds_m_s[1]));
                    stretches.push(Stretch { samples: 1, speeds_m_s, passage });
                }
            }
        }
        Ok(Self { sample_time_s, samples: count, stretches })
    }

    pub(crate) fn sample_time_s(&self) -> f64 {
        self.sample_time_s
    }

    /// How many samples there are.
    pub(crate) fn samples(&self) -> usize {
        self.samples
    }

    pub(crate) fn stretches(&self) -> &[Stretch] {
        &self.stretches
    }
}

/// The most samples of a test: more would take days, or all memory where each has a row.
const MOST_SAMPLES: f64 = 1e8;

fn count(duration_s: f64, sample_time_s: f64) -> f64 {
    (duration_s / sample_time_s - 1e-6).ceil()
}

/// A test that does not have too many samples, and how many they are.
pub(crate) fn checked_count(duration_s: f64, sample_time_s: f64) -> Result<f64, Error> {
    let value = count(duration_s, sample_time_s);
    if value <= MOST_SAMPLES {
        return Ok(value);
    }
    let expected = "at most 1e8: a shorter test, or a longer sample time";
    Err(Error::Argument { name: "number of samples of the test", value, expected })
}

/// Samples that begin within a test.
pub(crate) fn samples(duration_s: f64, sample_time_s: f64) -> Result<usize, Error> {
    let count = count(duration_s, sample_time_s);
    if sample_time_s > 0.0 && (1.0..=MOST_SAMPLES).contains(&count) {
        return Ok(count as usize);
    }
    Err(Error::Argument {
        name: "sample time of the water in s",
        value: sample_time_s,
        expected: "more than zero, and from 1 to 1e8 samples in the test",
    })
}

/// Mean speeds just after each sample and just before the next; a knot between two samples counts from the next sample on.
fn speeds(flow: &FlowHistory, count: usize, sample_time_s: f64) -> impl Iterator<Item = [f64; 2]> {
    let (knots, mut piece) = (flow.knots(), 0);
    (0..count).map(move |k| {
        let from_s = k as f64 * sample_time_s;
        while knots.get(piece + 1).is_some_and(|knot| knot.from_s <= from_s + 1e-6 * sample_time_s) {
            piece += 1;
        }
        [from_s, from_s + sample_time_s].map(|time_s| flow.within(piece, time_s).speed_m_s)
    })
}
