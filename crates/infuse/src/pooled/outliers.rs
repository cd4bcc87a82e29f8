//! Readings that the others do not expect, and those that a repeat gives the lie to.

use std::collections::BTreeSet;

use design_space::Cell;
use serde::{Deserialize, Serialize};

use crate::Error;
use crate::pooled::bands::NINE_IN_TEN;
use crate::pooled::block::Block;
use crate::pooled::designs::Designs;
use crate::pooled::drift::Drift;
use crate::pooled::knowledge::Knowledge;
use crate::pooled::measurements::{Measurements, Reading};
use crate::pooled::settings::Settings;
use crate::pooled::simulated::{Simulated, Source};

/// A reading that the others do not expect.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Outlier {
    /// Position among the readings.
    pub reading: usize,
    /// Distance from what the other readings say, in standard deviations; positive if it is above.
    pub deviations: f64,
    /// Whether it is left out of the surface: other runs of its settings gave something else, which the others do expect.
    pub set_aside: bool,
}

/// A reading, run once, on which the recommended design stands though the others do not expect it: a slip, it may be, or a well that
/// nobody knew of.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Doubted {
    /// Position among the readings.
    pub reading: usize,
    /// The response that the others expect at the recommended design.
    pub mean_without: f64,
}

/// The readings that make the surface, and those that do not.
#[derive(Debug, Default)]
pub(crate) struct Readings {
    pub(crate) kept: Vec<Reading>,
    /// Readings of each constrained response.
    pub(crate) constrained: Vec<Vec<Reading>>,
    pub(crate) set_aside: Vec<Outlier>,
    /// Readings with lower numbers were made outside of the campaign.
    pub(crate) n_earlier: usize,
    /// Designs of the campaign all of whose experiments failed.
    pub(crate) n_failed: usize,
    /// The block of each reading, by its number.
    pub(crate) blocks: Vec<Block>,
    /// The same of the readings of each constrained response.
    pub(crate) constrained_blocks: Vec<Vec<Block>>,
    /// What they say of a drift, by what was learnt without an error that runs of a block share.
    pub(crate) drift: Option<Drift>,
    /// The same of each constrained response.
    pub(crate) constrained_drifts: Vec<Option<Drift>>,
}

impl Readings {
    /// Whether those of the response share an error.
    pub(crate) fn are_shared(&self) -> bool {
        Reading::are_shared(&self.kept)
    }

    fn with_drifts(self, knowledge: &mut Knowledge<'_, '_>, settings: &Settings) -> Result<Self, Error> {
        let Self { kept, constrained, blocks, constrained_blocks, .. } = &self;
        let cells: Vec<Cell> = kept.iter().map(|reading| reading.cell).collect();
        let (places, surprises) = (knowledge.places(&cells)?, surprises(knowledge, kept));
        let (particles, sampler) = (knowledge.process.particles(), settings.sampler());
        let mut drift = Drift::of(kept, blocks, &places, particles, &sampler)?;
        // One that is far off would make noise of what blocks share.
        let usual: Vec<usize> = (0..kept.len()).filter(|&at| surprises[at].abs() <= FAR_OFF).collect();
        if usual.len() < kept.len() {
            let of_them: Vec<Reading> = usual.iter().map(|&at| kept[at].clone()).collect();
            let of_usual = Drift::of(&of_them, blocks, &places.select(&usual), particles, &sampler)?;
            let gain = |drift: &Option<Drift>| drift.as_ref().map_or(f64::NEG_INFINITY, |drift| drift.gain);
            drift = if gain(&of_usual) > gain(&drift) { of_usual } else { drift };
        }
        let constrained_drifts = knowledge.constrained_drifts(constrained, constrained_blocks, settings)?;
        Ok(Self { drift, constrained_drifts, ..self })
    }
}

/// Beyond so many standard deviations a reading is an outlier.
const STRIKING: f64 = 4.0;
/// One reading that is far off can make all seem noisy. Suspects are compared with a surface through the others alone, and are
/// outliers beyond so many standard deviations of that.
pub(super) const STRIKING_TO_OTHERS: f64 = 8.0;
/// Suspects are, among so many readings, the one that fits worst, from so many standard deviations on, and the most extreme one,
/// from so many times the usual distance to the median on; and those that differ from others of their settings by so many
/// standard deviations of the noise, at most so many.
const FEW: std::ops::RangeInclusive<usize> = 8..=60;
const WORST: f64 = 1.5;
const EXTREME: f64 = 5.0;
const DISAGREEING: f64 = 3.0;
const MOST_SUSPECT: usize = 2;
/// A repeat is looked into if it differs from its mates by as much as readings usually differ from their median, or, where there are more
/// repeated settings than so many, by so many times the usual difference of repeats, if that is less.
const UNUSUAL: f64 = 6.0;
const ENOUGH_REPEATED: usize = 3;
/// Whether a rig drifts is asked once more without readings that are so many standard deviations from what all others say.
const FAR_OFF: f64 = 3.0;
/// At most so many settings are looked into.
const MOST_LOOKED_INTO: usize = 8;
/// Fewer readings of other settings do not tell what to expect, where their noise is not given.
const WITNESSES: usize = 8;
/// The surface through other settings expects a reading that lies within so many of its standard deviations.
const EXPECTED: f64 = 4.0;

/// How far each reading is from what the others say, in standard deviations; those of equal settings share theirs.
pub(crate) fn surprises(knowledge: &Knowledge<'_, '_>, readings: &[Reading]) -> Vec<f64> {
    let places = knowledge.process.sites().places();
    let of_sites = knowledge.process.standardized_leave_one_out();
    let points: Vec<Vec<f64>> = (0..places.n_places()).map(|site| places.point(site)).collect();
    let of_reading =
        |reading: &Reading| points.iter().position(|point| *point == reading.coded).map(|site| of_sites[site]);
    readings.iter().map(|reading| of_reading(reading).unwrap_or(0.0)).collect()
}

/// Readings that the others do not expect; where all readings of a setting are unexpected, each of them.
pub(crate) fn outliers(
    knowledge: &mut Knowledge<'_, '_>,
    readings: &[Reading],
    settings: &Settings,
) -> Result<Vec<Outlier>, Error> {
    let named = |at: usize, deviations: f64| Outlier { reading: readings[at].number, deviations, set_aside: false };
    let surprises = surprises(knowledge, readings);
    let striking = surprises.iter().enumerate().filter(|(_, deviations)| deviations.abs() > STRIKING);
    let outliers: Vec<Outlier> = striking.map(|(at, &deviations)| named(at, deviations)).collect();
    if !outliers.is_empty() {
        return Ok(outliers);
    }
    let mut worst: Option<Outlier> = None;
    for at in suspects(&surprises, readings, knowledge.process.noise()) {
        let one = &readings[at];
        let mut deviations = knowledge.seen_from(readings, |other| other.number == one.number, one, settings)?.of(one);
        let is_mate = |other: &Reading| other.coded == one.coded;
        let has_mates = readings.iter().filter(|other| is_mate(other)).count() > 1;
        if has_mates && !readings.iter().all(is_mate) && deviations.abs() > STRIKING_TO_OTHERS {
            // A mate that is far off itself is no witness.
            let by_other_settings = knowledge.seen_from(readings, is_mate, one, settings)?.of(one);
            if by_other_settings.abs() < deviations.abs() {
                deviations = by_other_settings;
            }
        }
        if deviations.abs() > worst.map_or(STRIKING_TO_OTHERS, |worst| worst.deviations.abs()) {
            worst = Some(named(at, deviations));
        }
    }
    Ok(worst.into_iter().collect())
}

/// Whether a design that is far better than the others expect was run more than once.
pub(crate) fn is_seen_again(readings: &[Reading], unexpected: &[Outlier]) -> bool {
    let low = unexpected.iter().filter(|outlier| outlier.deviations < 0.0);
    let mut cells = low.filter_map(|low| readings.iter().find(|one| one.number == low.reading)).map(|one| one.cell);
    cells.any(|cell| readings.iter().filter(|other| other.cell == cell).count() > 1)
}

/// The lowest of the readings that the others do not expect, if its settings were run but once and more would be expected of the
/// recommended cell, of which this mean is, without it, beyond what a reading there may differ by.
pub(crate) fn doubted(
    knowledge: &mut Knowledge<'_, '_>,
    readings: &[Reading],
    unexpected: &[Outlier],
    (cell, mean): (Cell, f64),
    settings: &Settings,
) -> Result<Option<Doubted>, Error> {
    let is_low = |one: &&Reading| {
        let mut of_it = unexpected.iter().filter(|outlier| outlier.reading == one.number);
        of_it.any(|outlier| outlier.deviations < 0.0)
            && readings.iter().filter(|other| other.cell == one.cell).count() == 1
    };
    let lowest = readings.iter().filter(is_low).min_by(|a, b| a.response.total_cmp(&b.response));
    let Some(lowest) = lowest.filter(|_| readings.len() > 1) else { return Ok(None) };
    let there = Reading { coded: knowledge.designs.coded_of(cell)?, cell, ..lowest.clone() };
    let others = knowledge.seen_from(readings, |other| other.number == lowest.number, &there, settings)?;
    let is_carried = others.mean - mean > NINE_IN_TEN * others.deviation;
    Ok(is_carried.then_some(Doubted { reading: lowest.number, mean_without: others.mean }))
}

/// What follows from readings, but for those that are set aside. Where nothing was said of blocks and they are sure of a drift, it is learnt
/// anew, with the error that runs of a block share.
pub(crate) fn learnt<'a, 's>(
    mut measurements: Measurements,
    designs: &'a Designs,
    settings: &Settings,
    simulated: &'a mut Simulated,
    source: Source<'s>,
) -> Result<(Knowledge<'a, 's>, Readings), Error> {
    let has_plants = settings.plants.is_some();
    let are_told = settings.blocks == Some(true) && !has_plants;
    if are_told {
        measurements.share(true, |_| true);
    }
    let knowledge = Knowledge::of(&measurements, designs, settings, simulated, source)?;
    let (mut knowledge, readings) = without_slips(knowledge, measurements.clone(), settings)?;
    if has_plants || are_told {
        return Ok((knowledge, readings));
    }
    let readings = readings.with_drifts(&mut knowledge, settings)?;
    let is_sure = |drift: &Option<Drift>| drift.as_ref().is_some_and(Drift::is_sure);
    let of_each: Vec<bool> = readings.constrained_drifts.iter().map(is_sure).collect();
    let of_response = is_sure(&readings.drift);
    if settings.blocks.is_some() || !(of_response || of_each.contains(&true)) {
        return Ok((knowledge, readings));
    }
    let Readings { drift, constrained_drifts, .. } = readings;
    measurements.share(of_response, |index| of_each.get(index).is_some_and(|of_it| *of_it));
    let knowledge = knowledge.through(&measurements, settings)?;
    let (knowledge, readings) = without_slips(knowledge, measurements, settings)?;
    Ok((knowledge, Readings { drift, constrained_drifts, ..readings }))
}

/// The same without what repeats give the lie to.
fn without_slips<'a, 's>(
    mut knowledge: Knowledge<'a, 's>,
    mut measurements: Measurements,
    settings: &Settings,
) -> Result<(Knowledge<'a, 's>, Readings), Error> {
    let set_aside = set_aside(&mut knowledge, &mut measurements.readings, settings)?;
    if !set_aside.is_empty() {
        knowledge = knowledge.through(&measurements, settings)?;
    }
    let Measurements { readings: kept, constrained, n_earlier, n_failed, blocks, constrained_blocks, .. } =
        measurements;
    let readings = Readings {
        kept,
        constrained,
        set_aside,
        n_earlier,
        n_failed,
        blocks,
        constrained_blocks,
        ..Readings::default()
    };
    Ok((knowledge, readings))
}

/// Takes out of `readings` those that repeats give the lie to, and says which they were. Of two runs of the same settings that differ by
/// far more than the noise, one is left out if the surface through all other settings expects the other one and not it, and these are
/// enough to tell. Nothing is left out that was run but once: it may be the well that nobody knew of.
pub(crate) fn set_aside(
    knowledge: &mut Knowledge<'_, '_>,
    readings: &mut Vec<Reading>,
    settings: &Settings,
) -> Result<Vec<Outlier>, Error> {
    let mut set_aside = Vec::new();
    // What was hidden by one may be seen without it.
    loop {
        let suspects = quarrels(readings);
        let n_before = set_aside.len();
        for &suspect in &suspects {
            set_aside.extend(given_the_lie(knowledge, readings, (suspect, &suspects), settings)?);
        }
        if set_aside.len() == n_before {
            break;
        }
    }
    set_aside.sort_by_key(|outlier| outlier.reading);
    Ok(set_aside)
}

/// Takes one of the runs of the settings of a suspect out of `readings`, if it is wrong.
fn given_the_lie(
    knowledge: &mut Knowledge<'_, '_>,
    readings: &mut Vec<Reading>,
    (suspect, suspects): (usize, &[usize]),
    settings: &Settings,
) -> Result<Option<Outlier>, Error> {
    let Some(at) = readings.iter().position(|reading| reading.number == suspect) else { return Ok(None) };
    let coded = readings[at].coded.clone();
    let is_mate = |other: &Reading| other.coded == coded;
    let n_others = readings.iter().filter(|other| !is_mate(other)).count();
    if n_others == 0 || (n_others < WITNESSES && settings.noise.is_none()) {
        return Ok(None);
    }
    // Another slip would make all seem noisy: what is extreme, and runs of settings that quarrel themselves.
    let (far, usual) = (distances_to_median(readings), usual_distance(readings));
    let extreme = readings.iter().zip(&far).filter(|(_, far)| far.abs() > EXTREME * usual).map(|(one, _)| one.number);
    let extreme: BTreeSet<usize> = extreme.collect();
    let quarrelling = readings.iter().filter(|one| suspects.contains(&one.number)).map(|one| one.coded.clone());
    let quarrelling: Vec<Vec<f64>> = quarrelling.collect();
    let is_doubtful = |other: &Reading| extreme.contains(&other.number) || quarrelling.contains(&other.coded);
    let n_plain = readings.iter().filter(|&other| !is_mate(other) && !is_doubtful(other)).count();
    let is_no_witness = |other: &Reading| is_mate(other) || (n_plain >= WITNESSES && is_doubtful(other));
    let view = knowledge.seen_from(readings, is_no_witness, &readings[at], settings)?;
    let mut mates: Vec<usize> = (0..readings.len()).filter(|&mate| is_mate(&readings[mate])).collect();
    mates.sort_by(|&a, &b| view.of(&readings[a]).abs().total_cmp(&view.of(&readings[b]).abs()));
    let (Some(&nearest), Some(&farthest)) = (mates.first(), mates.last()) else { return Ok(None) };
    let apart = (readings[farthest].response - readings[nearest].response).abs();
    let deviations = view.of(&readings[farthest]);
    let is_wrong = deviations.abs() > STRIKING_TO_OTHERS
        && view.of(&readings[nearest]).abs() < EXPECTED
        && apart > STRIKING_TO_OTHERS * view.noise;
    Ok(is_wrong.then(|| Outlier { reading: readings.remove(farthest).number, deviations, set_aside: true }))
}

/// A reading of each setting whose runs differ unusually much, those first that differ most.
fn quarrels(readings: &[Reading]) -> Vec<usize> {
    let from_mates = disagreements(readings);
    let mut of_settings: Vec<usize> = Vec::new();
    for at in (0..readings.len()).filter(|&at| from_mates[at] != 0.0) {
        match of_settings.iter_mut().find(|other| readings[**other].coded == readings[at].coded) {
            Some(most) if from_mates[at].abs() > from_mates[*most].abs() => *most = at,
            Some(_) => {}
            None => of_settings.push(at),
        }
    }
    of_settings.sort_by(|&a, &b| from_mates[b].abs().total_cmp(&from_mates[a].abs()).then(a.cmp(&b)));
    // Where half of the repeats are slips, what is usual of repeats is a slip; never more than readings usually differ from their median.
    let usual = usual_distance(readings);
    let usual = match of_settings.len() > ENOUGH_REPEATED {
        true => usual.min(UNUSUAL * median(of_settings.iter().map(|&at| from_mates[at].abs()).collect())),
        false => usual,
    };
    let unusual = of_settings.into_iter().filter(|&at| from_mates[at].abs() > usual);
    unusual.take(MOST_LOOKED_INTO).map(|at| readings[at].number).collect()
}

/// Readings that may have made all seem noisy: among few the one that fits worst and the most extreme one, and those that agree
/// least with others of their settings.
fn suspects(surprises: &[f64], readings: &[Reading], noise: f64) -> BTreeSet<usize> {
    let mut suspects = BTreeSet::new();
    if FEW.contains(&readings.len()) {
        suspects.extend(largest(surprises).filter(|&worst| surprises[worst].abs() >= WORST));
        let distances = distances_to_median(readings);
        let usual = usual_distance(readings);
        suspects.extend(largest(&distances).filter(|&farthest| distances[farthest].abs() > EXTREME * usual));
    }
    let disagreements = disagreements(readings);
    if let Some(first) = largest(&disagreements).filter(|&first| disagreements[first].abs() > DISAGREEING * noise) {
        let as_far = |index: &usize| disagreements[*index].abs() >= 0.999 * disagreements[first].abs();
        suspects.extend((0..readings.len()).filter(as_far).take(MOST_SUSPECT));
    }
    suspects
}

/// Of each reading, the distance to the mean of the others of its settings; 0 where there is none.
fn disagreements(readings: &[Reading]) -> Vec<f64> {
    let from_mates = |(index, one): (usize, &Reading)| {
        let mates = readings.iter().enumerate().filter(|(other, mate)| *other != index && mate.coded == one.coded);
        let (sum, n) = mates.fold((0.0, 0.0), |(sum, n), (_, mate)| (sum + mate.response, n + 1.0));
        if n > 0.0 { one.response - sum / n } else { 0.0 }
    };
    readings.iter().enumerate().map(from_mates).collect()
}

fn distances_to_median(readings: &[Reading]) -> Vec<f64> {
    let responses: Vec<f64> = readings.iter().map(|reading| reading.response).collect();
    let center = median(responses.clone());
    responses.iter().map(|response| response - center).collect()
}

fn usual_distance(readings: &[Reading]) -> f64 {
    median(distances_to_median(readings).iter().map(|distance| distance.abs()).collect())
}

/// Where the largest magnitude is; the first of several.
fn largest(values: &[f64]) -> Option<usize> {
    let order = |&a: &usize, &b: &usize| values[a].abs().total_cmp(&values[b].abs()).then(b.cmp(&a));
    (0..values.len()).max_by(order)
}

/// The upper one of the two in the middle.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn readings(pairs: &[(f64, f64)]) -> Vec<Reading> {
        let reading = |(number, &(x, response)): (usize, &(f64, f64))| Reading {
            coded: vec![x],
            cell: design_space::Cell::new(0),
            response,
            number,
            assembly: None,
        };
        pairs.iter().enumerate().map(reading).collect()
    }

    #[test]
    fn disagreement_is_the_distance_to_the_mean_of_the_other_runs() {
        let some = readings(&[(0.1, 1.0), (0.2, 5.0), (0.1, 4.0), (0.1, 2.0)]);
        assert_eq!(disagreements(&some), [1.0 - 3.0, 0.0, 4.0 - 1.5, 2.0 - 2.5]);
    }

    #[test]
    fn distances_are_to_the_median() {
        let some = readings(&[(0.1, 1.0), (0.2, 5.0), (0.3, 4.0)]);
        assert_eq!(distances_to_median(&some), [-3.0, 1.0, 0.0]);
        assert_eq!(usual_distance(&some).to_bits(), 1.0_f64.to_bits());
    }

    /// Two of twelve readings are of one setting and differ by five standard deviations of the noise.
    #[test]
    fn runs_that_differ_by_more_than_the_noise_are_suspects_both() {
        let mut pairs: Vec<(f64, f64)> = (0..10).map(|i| (f64::from(i), f64::from(i))).collect();
        pairs.extend([(20.0, 4.0), (20.0, 4.5)]);
        let some = readings(&pairs);
        assert_eq!(suspects(&[0.0; 12], &some, 0.1), BTreeSet::from([10, 11]));
        assert_eq!(suspects(&[0.0; 12], &some, 0.2), BTreeSet::new(), "two and a half are no more than noise");
        let mut surprises = [0.5; 12];
        surprises[3] = -1.6;
        assert_eq!(suspects(&surprises, &some, 0.2), BTreeSet::from([3]), "the one that fits worst");
        pairs[0].1 = 40.0;
        assert_eq!(suspects(&[0.0; 12], &readings(&pairs), 0.2), BTreeSet::from([0]), "the most extreme one");
    }

    /// Of each setting the run that differs most from the others stands for it, and those come first that differ most.
    #[test]
    fn quarrels_are_told_from_the_largest_on() {
        let some = readings(&[
            (0.0, 0.0),
            (0.1, 1.0),
            (0.2, 2.0),
            (0.1, 90.0),
            (0.2, 2.0),
            (0.2, 60.0),
            (0.3, 1.5),
            (0.3, 1.6),
        ]);
        assert_eq!(quarrels(&some), [1, 5]);
    }

    /// A smooth curve, and at its middle one run more, three above it.
    #[test]
    fn of_two_runs_that_differ_the_one_that_the_others_do_not_expect_is_set_aside() {
        let mut scene = crate::pooled::scene::Scene::new(&[21]);
        scene.settings.noise = Some(0.02);
        let curve = |x: u64| (0.1 * x as f64 - 1.0).powi(2);
        for x in [0, 3, 6, 10, 14, 17, 20] {
            scene.read(&[x], curve(x) + 0.01 * (x as f64).sin());
        }
        let (kept, mut readings) = (scene.readings.clone(), Vec::new());
        for (above, expected) in [(3.0, vec![7]), (0.05, vec![])] {
            scene.readings = kept.clone();
            scene.read(&[10], curve(10) + above);
            readings.clone_from(&scene.readings);
            let settings = scene.settings.clone();
            let aside = set_aside(&mut scene.knowledge(None), &mut readings, &settings).unwrap();
            assert_eq!(aside.iter().map(|outlier| outlier.reading).collect::<Vec<_>>(), expected, "{above} above");
            assert!(aside.iter().all(|outlier| outlier.set_aside && outlier.deviations > STRIKING_TO_OTHERS));
            assert_eq!(readings.len(), 8 - expected.len());
            assert_eq!(readings[..7], kept, "the others stay");
            // Six others, of which nobody said how much they scatter, are no witnesses; eight are.
            let aside_unless_given = |scene: &mut crate::pooled::scene::Scene| {
                let (settings, mut readings) =
                    (Settings { noise: None, ..scene.settings.clone() }, scene.readings.clone());
                set_aside(&mut scene.knowledge(None), &mut readings, &settings).unwrap().len()
            };
            assert_eq!(aside_unless_given(&mut scene), 0);
            for x in [8, 12] {
                scene.read(&[x], curve(x) + 0.01 * (x as f64).sin());
            }
            assert_eq!(aside_unless_given(&mut scene), expected.len());
        }
    }

    /// Two runs of a smooth curve were slips, at different settings; only one was run again. The other does not hide it.
    #[test]
    fn a_slip_is_set_aside_though_there_is_another() {
        let mut scene = crate::pooled::scene::Scene::new(&[21]);
        let curve = |x: u64| (0.1 * x as f64 - 1.0).powi(2);
        for x in [0, 2, 4, 6, 8, 12, 14, 16, 18, 20] {
            scene.read(&[x], curve(x) + 0.01 * (x as f64).sin());
        }
        scene.read(&[5], 40.0);
        scene.read(&[10], 40.0);
        scene.read(&[10], curve(10));
        let (settings, mut readings) = (scene.settings.clone(), scene.readings.clone());
        let aside = set_aside(&mut scene.knowledge(None), &mut readings, &settings).unwrap();
        assert_eq!(aside.iter().map(|outlier| outlier.reading).collect::<Vec<_>>(), [11]);
    }

    /// Four settings were run twice, and at two of them one of the runs was a slip: what repeats usually differ by is a slip then. Neither
    /// hides the other, whether or not the noise is given, and with the third pair of slips all three are told.
    #[test]
    fn slips_at_half_of_the_repeated_settings_are_set_aside() {
        for (n_slips, noise) in [(2, None), (2, Some(0.02)), (3, None), (3, Some(0.02))] {
            let mut scene = crate::pooled::scene::Scene::new(&[21]);
            scene.settings.noise = noise;
            let curve = |x: u64| (0.1 * x as f64 - 1.0).powi(2) + 0.01 * (x as f64).sin();
            for x in [0, 1, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20] {
                scene.read(&[x], curve(x));
            }
            for (number, x) in [5, 10, 15, 18].into_iter().enumerate() {
                let slip = if number < n_slips { [3.0, -3.0, 9.0][number] } else { 0.01 };
                scene.read(&[x], curve(x) + slip);
                scene.read(&[x], curve(x) + 0.01);
            }
            let (settings, mut readings) = (scene.settings.clone(), scene.readings.clone());
            let aside = set_aside(&mut scene.knowledge(None), &mut readings, &settings).unwrap();
            let found: Vec<usize> = aside.iter().map(|outlier| outlier.reading).collect();
            assert_eq!(found, [12, 14, 16][..n_slips], "{n_slips} slips, noise {noise:?}");
        }
    }
}
