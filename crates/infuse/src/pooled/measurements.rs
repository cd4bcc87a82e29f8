//! What was measured, as the surfaces take it.

use std::collections::BTreeSet;

use design_space::Cell;
use surface::Data;
use surface::process::{Places, Sites};

use crate::Error;
use crate::pooled::block::Block;
use crate::pooled::designs::Designs;
use crate::pooled::plants::{Assemblies, Plants};
use crate::pooled::settings::Settings;
use crate::pure_error::PureError;

/// One experiment that gave a response.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Reading {
    pub(crate) coded: Vec<f64>,
    pub(crate) cell: Cell,
    pub(crate) response: f64,
    /// Position among all readings.
    pub(crate) number: usize,
    /// Which readings it shares an error with, if it does with some: those of its plant in its batch, or those of its block.
    pub(crate) assembly: Option<usize>,
}

impl Reading {
    /// The highest response less the lowest.
    pub(crate) fn range(readings: &[Self]) -> f64 {
        let responses = || readings.iter().map(|reading| reading.response);
        responses().fold(f64::NEG_INFINITY, f64::max) - responses().fold(f64::INFINITY, f64::min)
    }

    /// Those of a block, by the number of a reading, share an error from here on.
    fn share(readings: &mut [Self], blocks: &[Block]) {
        let mut assemblies = Assemblies::default();
        for reading in readings {
            reading.assembly = blocks.get(reading.number).map(|block| assemblies.of(block, Vec::new()));
        }
    }

    /// Whether they share an error with others.
    pub(crate) fn are_shared(readings: &[Self]) -> bool {
        readings.iter().any(|reading| reading.assembly.is_some())
    }

    /// Measurements with what the simulation says of the place of each, as a process takes them. Where there are plants, a part of the response may
    /// be the plant's own, whatever is typed.
    pub(crate) fn sites(
        readings: &[&Self],
        designs: &Designs,
        plants: Option<&Plants>,
        places: &Places,
    ) -> Result<Sites, Error> {
        let n_factors = designs.n_factors();
        let coordinates = readings.iter().flat_map(|reading| &reading.coded).copied().collect();
        let responses = readings.iter().map(|reading| reading.response).collect();
        let data = Data::new(n_factors, coordinates, responses)?;
        let assemblies: Option<Vec<usize>> = readings.iter().map(|reading| reading.assembly).collect();
        Ok(match assemblies.filter(|_| !readings.is_empty()) {
            Some(assemblies) => {
                let axes = plants.map_or(Vec::new(), |plants| plants.axes(designs));
                Sites::in_assemblies(&data, places.simulated(), &assemblies)?.with_additive(axes)?
            }
            None => Sites::new(&data, places.simulated())?,
        }
        .with_deviations(places.deviations())?
        .with_unknown(places.unknown())?)
    }
}

/// So many repeats that do not differ at all say that there is no noise,
const ENOUGH_EQUAL: usize = 3;
/// and one where responses are written so finely, of what they differ by, that two would not agree by chance.
const FINE: f64 = 1e-6;

/// The power of ten that stands for the last digit of a number.
fn last_digit(number: f64) -> i32 {
    let text = format!("{number:e}");
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let n_decimals = mantissa.split_once('.').map_or(0, |(_, decimals)| decimals.len());
    exponent.parse::<i32>().unwrap_or(0) - n_decimals as i32
}

/// All that was measured.
#[derive(Debug, Clone, Default)]
pub(crate) struct Measurements {
    pub(crate) readings: Vec<Reading>,
    /// Readings of each constrained response.
    pub(crate) constrained: Vec<Vec<Reading>>,
    /// Where experiments failed, and what nobody can build.
    pub(crate) failed: BTreeSet<Cell>,
    /// Of these what nobody can build any more, whatever was measured there.
    pub(crate) refused: BTreeSet<Cell>,
    /// So many of the readings, the first ones, were made outside of the campaign.
    pub(crate) n_earlier: usize,
    /// Designs of the campaign all of whose experiments failed.
    pub(crate) n_failed: usize,
    /// The block of each reading, by its number.
    pub(crate) blocks: Vec<Block>,
    /// The same of the readings of each constrained response.
    pub(crate) constrained_blocks: Vec<Vec<Block>>,
}

impl Measurements {
    /// Whether readings are the same whenever settings are: nothing is learnt from one more of the same settings. Readings where a sensor
    /// may have reached its end tell nothing of that.
    fn are_exact(&self, least: Option<f64>) -> bool {
        let ends = self.ends(least);
        let telling = self.readings.iter().filter(|reading| !ends.contains(&reading.response.to_bits()));
        let readings = telling.map(|reading| (reading.coded.clone(), reading.response));
        let finest = self.readings.iter().map(|reading| last_digit(reading.response)).min().unwrap_or(0);
        let is_fine = 10.0_f64.powi(finest) < FINE * Reading::range(&self.readings);
        let enough = if is_fine { 1 } else { ENOUGH_EQUAL };
        PureError::of_readings(readings)
            .is_some_and(|repeats| repeats.degrees_of_freedom >= enough && repeats.variance <= 0.0)
    }

    /// Responses that may be where a sensor ends: the least that there can be, and the lowest and the highest of all where different
    /// settings have the same.
    fn ends(&self, least: Option<f64>) -> Vec<u64> {
        let of_all = |better: fn(f64, f64) -> f64| self.readings.iter().map(|reading| reading.response).reduce(better);
        let extremes = [of_all(f64::min), of_all(f64::max)].into_iter().flatten();
        let is_shared = |end: &f64| {
            let mut there = self.readings.iter().filter(|reading| reading.response.to_bits() == end.to_bits());
            let first = there.next();
            there.any(|reading| first.is_some_and(|first| first.coded != reading.coded))
        };
        extremes.filter(is_shared).chain(least).map(f64::to_bits).collect()
    }

    /// Readings of a block share an error: those of the response, and those of the constrained ones, that are meant.
    pub(crate) fn share(&mut self, is_response: bool, is_constrained: impl Fn(usize) -> bool) {
        if is_response {
            Reading::share(&mut self.readings, &self.blocks);
        }
        let of_each = self.constrained.iter_mut().zip(&self.constrained_blocks).enumerate();
        of_each.filter(|(index, _)| is_constrained(*index)).for_each(|(_, (readings, blocks))| {
            Reading::share(readings, blocks);
        });
    }

    /// The settings, without noise where nothing was said of it and repeats show none.
    pub(crate) fn settings(&self, settings: &Settings) -> Settings {
        let noise = settings.noise.or_else(|| self.are_exact(settings.least).then_some(0.0));
        Settings { noise, ..settings.clone() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Readings of one parameter, each its setting and its response.
    fn measured(pairs: &[(f64, f64)]) -> Measurements {
        let reading = |(number, &(x, response)): (usize, &(f64, f64))| Reading {
            coded: vec![x],
            cell: Cell::new(0),
            response,
            number,
            assembly: None,
        };
        Measurements { readings: pairs.iter().enumerate().map(reading).collect(), ..Measurements::default() }
    }

    #[test]
    fn three_repeats_that_are_equal_say_that_there_is_no_noise() {
        let equal = [(0.1, 1.0), (0.2, 2.0), (0.1, 1.0), (0.1, 1.0), (0.2, 2.0)];
        let noise = |pairs: &[(f64, f64)], noise: Option<f64>| {
            let mut settings = Settings::new(4);
            settings.noise = noise;
            measured(pairs).settings(&settings).noise
        };
        assert_eq!(noise(&equal, None), Some(0.0));
        assert_eq!(noise(&equal, Some(0.3)), Some(0.3), "what was said counts");
        assert_eq!(noise(&equal[..4], None), None, "two are chance");
        let other = [&equal[..], &[(0.2, 2.0 + 1e-9)]].concat();
        assert_eq!(noise(&other, None), None);
    }

    /// Where a sensor ends all readings are equal, whatever the noise.
    #[test]
    fn equal_readings_at_the_end_of_a_scale_say_nothing_of_the_noise() {
        let noise = |pairs: &[(f64, f64)], least: Option<f64>| {
            measured(pairs).settings(&Settings { least, ..Settings::new(4) }).noise
        };
        let at_the_least = [(0.1, 0.5), (0.1, 0.5), (0.2, 1.234_567_8)];
        assert_eq!((noise(&at_the_least, None), noise(&at_the_least, Some(0.5))), (Some(0.0), None));
        assert_eq!(noise(&at_the_least, Some(0.4)), Some(0.0), "above the least");
        let shared = [(0.1, 0.5), (0.1, 0.5), (0.3, 0.5), (0.2, 1.234_567_8)];
        assert_eq!(noise(&shared, None), None, "lowest at two settings");
        assert_eq!(noise(&shared.map(|(x, response)| (x, -response)), None), None, "highest at two settings");
        let between = [&shared[..], &[(0.4, 0.123_456_7)]].concat();
        assert_eq!(noise(&between, None), Some(0.0), "neither lowest nor highest");
    }

    /// Of 1000 units in the last digit two agree now and then; of ten million hardly ever.
    #[test]
    fn one_repeat_is_enough_where_responses_have_many_digits() {
        for (number, expected) in
            [(0.0, 0), (7.0, 0), (120.0, 1), (0.25, -2), (-1.2e-7, -8), (3.5e22, 21), (0.1 + 0.2, -17)]
        {
            assert_eq!(last_digit(number), expected, "{number}");
        }
        let noise = |[a, b, c]: [f64; 3]| measured(&[(0.1, a), (0.1, b), (0.2, c)]).settings(&Settings::new(4)).noise;
        assert_eq!(noise([1.0, 1.0, 2.0]), None);
        assert_eq!(noise([1.001, 1.001, 2.0]), None);
        assert_eq!(noise([1.000_000_1, 1.000_000_1, 2.0]), Some(0.0));
        assert_eq!(noise([1.000_000_1, 1.000_000_2, 2.0]), None, "they differ");
        assert_eq!(noise([100_000.1, 100_000.1, 300_000.0]), Some(0.0));
        assert_eq!(noise([4.0, 4.0, 4.0]), None, "nothing differs");
    }
}
