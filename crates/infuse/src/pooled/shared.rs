//! What runs of one plant share: an error of how it was put together, or the plant's own part of the response. Only plants that were put
//! together again tell one from the other.

use std::collections::BTreeMap;

use statrs::distribution::{ChiSquared, ContinuousCDF as _, Normal};

use crate::Error;
use crate::pooled::designs::Designs;
use crate::pooled::knowledge::Knowledge;
use crate::pooled::measurements::Reading;
use crate::pooled::plants::{Plant, Plants};

/// The variance by which plants put together again differ is taken for one that is exceeded as often as not.
const MEDIAN: f64 = 0.5;

/// Variances of what runs of one plant share.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Shared {
    /// An error, as far as plants that were put together again allow.
    pub(crate) error: f64,
    /// What may be the plant's own.
    pub(crate) own: f64,
    /// Assemblies beyond the first of their plant.
    pub(crate) n_again: usize,
}

impl Shared {
    /// Of what the surface takes for shared, the part that assemblies of the same plant do not differ by is the plant's own.
    pub(crate) fn of(knowledge: &mut Knowledge<'_, '_>, readings: &[Reading], plants: &Plants) -> Result<Self, Error> {
        let cells: Vec<_> = readings.iter().map(|reading| reading.cell).collect();
        let places = knowledge.places(&cells)?;
        let expected = knowledge.marginals(&places)?.means;
        let beyond = readings.iter().zip(expected).map(|(reading, expected)| (reading, reading.response - expected));
        let (squares, n_again) = scatter(beyond, knowledge.designs, plants);
        let variance = knowledge.process.assembly_deviation().powi(2);
        Ok(Self::told_apart(variance, squares, n_again))
    }

    fn told_apart(variance: f64, squares: f64, n_again: usize) -> Self {
        // With none put together again nothing speaks for an error.
        let seen = ChiSquared::new(n_again as f64).map_or(0.0, |chi| squares / chi.inverse_cdf(MEDIAN));
        let error = variance.min(seen);
        Self { error, own: variance - error, n_again }
    }

    /// Variance of an error that is to be reckoned with where a reading is compared with the surface.
    pub(crate) fn error_of_a_reading(&self) -> f64 {
        if self.n_again > 0 { self.error } else { self.own }
    }

    /// With this probability none of so many plants is better by its own by more than this.
    pub(crate) fn best_of(&self, n_plants: f64, probability: f64) -> f64 {
        let of_one = probability.powf(1.0 / n_plants.max(1.0));
        Normal::standard().inverse_cdf(of_one).max(0.0) * self.own.sqrt()
    }
}

/// Sum of squares of assemblies about the mean of their plant, of the mean that each is beyond what is expected, and their number less
/// that of their plants.
fn scatter<'a>(beyond: impl Iterator<Item = (&'a Reading, f64)>, designs: &Designs, plants: &Plants) -> (f64, usize) {
    let mut of_plants: BTreeMap<Plant, BTreeMap<usize, Vec<f64>>> = BTreeMap::new();
    for (reading, beyond) in beyond {
        let Some(assembly) = reading.assembly else { continue };
        of_plants.entry(plants.of(designs, reading.cell)).or_default().entry(assembly).or_default().push(beyond);
    }
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let (mut squares, mut n_again) = (0.0, 0);
    for assemblies in of_plants.values() {
        let means: Vec<f64> = assemblies.values().map(|values| mean(values)).collect();
        let center = mean(&means);
        squares += means.iter().map(|one| (one - center).powi(2)).sum::<f64>();
        n_again += means.len() - 1;
    }
    (squares, n_again)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pooled::scene::Scene;

    /// Plants 0, 1 and 2 along the first axis; 0 was put together three times, 1 twice.
    #[test]
    fn scatter_is_that_of_assemblies_about_their_plant() {
        let mut scene = Scene::new(&[3, 5]);
        let runs = [
            (0, 0, 1.0, 1),
            (0, 4, 3.0, 1),
            (0, 0, 5.0, 2),
            (0, 1, 2.0, 3),
            (1, 0, 7.0, 4),
            (1, 3, 8.0, 5),
            (2, 2, 9.0, 6),
        ];
        for (number, (plant, setting, response, assembly)) in runs.into_iter().enumerate() {
            scene.read(&[plant, setting], response);
            scene.readings[number].assembly = Some(assembly);
        }
        let beyond = scene.readings.iter().map(|reading| (reading, reading.response));
        let (squares, n_again) = scatter(beyond, &scene.designs, &Plants::at_most(2, vec![0]));
        // Means 2, 5 and 2 about 3; 7 and 8 about 7.5.
        assert!((squares - 6.5).abs() < 1e-12 && n_again == 3, "{squares} {n_again}");
    }

    /// Of a shared variance of 4, chi-squared with two degrees of freedom: its median is 2 ln 2 = 1.3863.
    #[test]
    fn what_plants_put_together_again_do_not_show_is_their_own() {
        let of = |squares: f64, n_again: usize| Shared::told_apart(4.0, squares, n_again);
        assert_eq!((of(0.0, 0).error, of(0.0, 0).own, of(0.0, 0).error_of_a_reading()), (0.0, 4.0, 4.0));
        let some = of(1.3863, 2);
        assert!((some.error - 1.0).abs() < 1e-3 && (some.own - 3.0).abs() < 1e-3, "{some:?}");
        assert!((some.error_of_a_reading() - some.error).abs() <= 0.0);
        assert_eq!((of(9.0, 2).error, of(9.0, 2).own), (4.0, 0.0), "they differ by as much");
        // 0.9 to the seventh root is 0.98506, which lies 2.17171 above the mean.
        assert!(of(0.0, 0).best_of(1.0, 0.5).abs() < 1e-12);
        let best = of(0.0, 0).best_of(7.0, 0.9);
        assert!((best - 2.0 * 2.17171).abs() < 1e-3, "{best}");
        assert!(of(9.0, 2).best_of(1e9, 0.9) <= 0.0);
    }
}
