//! What is said of the flights before and after infusion.

use super::designs::standing;
use super::votes::Votes;
use super::words::median_words;
use crate::chapter7::file::Case;
use crate::chapter7::findings::Found;
use crate::chapter7::flights::Means;
use crate::claims::{Claim, Place};
use crate::rules::{Judged, MUCH};

/// What is said of the flights: the figure, words, a reading with its unit, and how much of it may be left.
type Said = (u8, &'static str, fn(&Means) -> f64, &'static str, f64);

const OF_TWO: [Said; 2] = [
    (24, "heading squared improves significantly", |m| m.heading2, "deg²", MUCH),
    (24, "pitch error squared improves significantly", |m| m.pitch2, "deg²", MUCH),
];

const OF_FOUR: [Said; 5] = [
    (26, "the heading is significantly improved", |m| m.heading2, "deg²", MUCH),
    (27, "the roll offset is greatly reduced", |m| m.roll_offset, "deg", MUCH),
    (27, "the zenith angle is slightly lower", |m| m.zenith, "deg", 1.0),
    (28, "altitude tracking improves", |m| m.altitude2, "cm²", 1.0),
    (28, "pitch tracking improves", |m| m.pitch2, "deg²", 1.0),
];

pub(super) fn flights(case: &Case, found: &Found) -> Vec<Claim> {
    let said: &[Said] = if case.space.variables.len() == 2 { &OF_TWO } else { &OF_FOUR };
    let (before, after) = (found.flights.before.means(), found.flights.after.means());
    let claim = |(figure, says, reading, unit, left): &Said| {
        let start = reading(&before);
        let votes = Votes::of(&after, &found.flights.after_seeds, |means| reading(means) < left * start);
        let better = found.flights.after_seeds.iter().filter(|means| reading(means) < start).count();
        let threshold = if *left < 1.0 {
            format!("Much is at least a half: {}; it is lower at all for {better} seeds", votes.words())
        } else {
            votes.sentence()
        };
        let by_chance = found.flights.blind.share(|(_, means)| reading(means) < left * start);
        Claim::new(
            Place::Figure(*figure),
            says,
            Judged::of(votes.count(), standing(case)).beside(by_chance),
            format!(
                "{threshold}. {start:.3} {unit} at the numerical optimum, {:.3} at the infused one without noise, {} in the median.",
                reading(&after),
                median_words(found.flights.after_seeds.iter().map(reading), 3)
            ),
        )
        .in_short(format!("{start:.3} → {:.3} {unit} without noise", reading(&after)))
        .shown_in(&[&format!("figure-{figure}")])
    };
    said.iter().map(claim).collect()
}
