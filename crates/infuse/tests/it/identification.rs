//! Identification of unknowns: against scipy, closed forms, frequencies, and itself.

mod errors;
mod golden;
mod invariants;
mod linear;

use design_space::{Parameter, Region};
use infuse::identification::{Answer, Measurements, Unknowns};

/// Unknowns named a, b, c, ... without unit, with these bounds and starts.
pub(crate) fn unknowns(entries: &[(f64, f64, f64)]) -> Unknowns {
    let name = |index: usize| char::from(b'a' + index as u8).to_string();
    let parameter = |(index, &(lower, upper, _)): (usize, &(f64, f64, f64))| {
        Parameter::continuous(name(index), "", lower, upper).unwrap()
    };
    let region = Region::new(entries.iter().enumerate().map(parameter).collect()).unwrap();
    Unknowns::new(region, entries.iter().map(|entry| entry.2).collect()).unwrap()
}

/// One response at designs of one setting, all with the same deviation.
pub(crate) fn readings(pairs: &[(f64, f64)], deviation: f64) -> Measurements {
    let mut measurements = Measurements::new(vec!["y".into()]).unwrap();
    for (x, y) in pairs {
        measurements.push(&[*x], &[*y], &[deviation]).unwrap();
    }
    measurements
}

/// For every vector of unknowns at every design.
type Answers = Vec<Vec<Answer>>;

/// A model of one design, for all unknowns and designs.
pub(crate) fn each(model: impl Fn(&[f64], &[f64]) -> Answer) -> impl FnMut(&[Vec<f64>], &[Vec<f64>]) -> Answers {
    move |unknowns, designs| {
        unknowns.iter().map(|theta| designs.iter().map(|design| model(theta, design)).collect()).collect()
    }
}
