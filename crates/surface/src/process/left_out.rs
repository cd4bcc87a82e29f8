//! What the measurements of a place are foretold as by those of all other places.

use statrs::distribution::{Continuous, Normal, StudentsT};

use crate::process::averaged::AveragedProcess;
use crate::process::sites::Sites;

/// The logarithm of the density of the mean at each place as the mean of all others foretells it, were they all of one value and of noise, of this
/// variance or of one that the others tell; their sum. None where too few tell it.
fn of_noise_alone(sites: &Sites, noise: Option<f64>) -> Option<f64> {
    let (means, weights) = (sites.means(), sites.weights());
    let (n, total) = (means.len(), weights.iter().sum::<f64>());
    let freedom = (n + sites.n_repeats()).saturating_sub(2) as f64;
    let sum: f64 = weights.iter().zip(means).map(|(weight, mean)| weight * mean).sum();
    let of_place = |place: usize| {
        let others = total - weights[place];
        let expected = (sum - weights[place] * means[place]) / others;
        let of_mean = 1.0 / weights[place] + 1.0 / others;
        let squared = |other: usize| (means[other] - expected).powi(2);
        let variance = match noise {
            Some(noise) => noise,
            None => {
                let about = (0..n).filter(|other| *other != place).map(|other| weights[other] * squared(other));
                (about.sum::<f64>() + sites.scatter()) / freedom
            }
        };
        let deviation = (variance * of_mean).sqrt();
        // Too few places and no scatter leave no deviation, and no density.
        match noise {
            Some(_) => Normal::new(expected, deviation).ok().map(|density| density.ln_pdf(means[place])),
            None => StudentsT::new(expected, deviation, freedom).ok().map(|density| density.ln_pdf(means[place])),
        }
    };
    (0..n).map(of_place).sum()
}

impl AveragedProcess {
    /// By how much better the process foretells what was measured at each place from what was measured at all others than one value with noise
    /// does, of this standard deviation or of one that these others tell: the sum over the places of the difference of the logarithms of the
    /// densities. None where there are too few places to tell, and where all that was measured is equal.
    ///
    /// Above 3 or so the measurements tell of the factors; below, they may be noise, and what the process makes of other places is its prior.
    /// The density is the conditional predictive ordinate (Gelfand, Dey and Chang 1992), the harmonic mean over the particles. Errors that the
    /// measurements of an assembly share are known to the process alone.
    ///
    /// ```
    /// use surface::Data;
    /// use surface::process::{AveragedProcess, SamplerSettings, Sites};
    ///
    /// let x: Vec<f64> = (0..8).map(|i| f64::from(i) / 3.5 - 1.0).collect();
    /// let gain = |y: Vec<f64>| -> Result<Option<f64>, surface::Error> {
    ///     let sites = Sites::new(&Data::new(1, x.clone(), y)?, None)?;
    ///     Ok(AveragedProcess::new(sites, &SamplerSettings::default())?.gain_over_noise(None))
    /// };
    /// assert!(gain(x.iter().map(|x| x * x).collect())?.is_some_and(|gain| gain > 3.0));
    /// assert!(gain(vec![0.3, -0.2, 0.1, -0.4, 0.2, 0.4, -0.3, 0.0])?.is_some_and(|gain| gain < 3.0));
    /// # Ok::<(), surface::Error>(())
    /// ```
    #[must_use]
    pub fn gain_over_noise(&self, noise: Option<f64>) -> Option<f64> {
        let scale = self.sites().units().scale;
        let alone = of_noise_alone(self.sites(), noise.map(|noise| (noise / scale).powi(2)))?;
        let of_each: Vec<Vec<f64>> = self.particles().iter().map(|particle| particle.log_left_out()).collect();
        let of_place = |place: usize| {
            let least = of_each.iter().map(|each| each[place]).fold(f64::INFINITY, f64::min);
            let inverse: f64 = of_each.iter().map(|each| (least - each[place]).exp()).sum();
            least - (inverse / of_each.len() as f64).ln()
        };
        let foretold: f64 = (0..self.sites().means().len()).map(of_place).sum();
        Some(foretold - alone).filter(|gain| !gain.is_nan())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Data;
    use crate::process::sampler::SamplerSettings;
    use proptest::prelude::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    /// Places at random, with so much of a bowl and noise of .1.
    fn gain(n: usize, height: f64, seed: u64, noise: Option<f64>, unit: f64) -> f64 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let coordinates: Vec<f64> = (0..2 * n).map(|_| rng.random_range(-1.0..1.0)).collect();
        let values = coordinates.chunks(2).map(|x| {
            let normal: f64 = StandardNormal.sample(&mut rng);
            5.0 + unit * (height * (x[0] * x[0] + 0.5 * x[1]) + 0.1 * normal)
        });
        let values = values.collect();
        let sites = Sites::new(&Data::new(2, coordinates, values).unwrap(), None).unwrap();
        let settings = SamplerSettings { noise, ..SamplerSettings::default() };
        AveragedProcess::new(sites, &settings).unwrap().gain_over_noise(noise).unwrap()
    }

    /// Of 60 samples of noise at most three are taken for more, and none of a bowl that is ten times as high for noise.
    #[test]
    fn noise_is_told_from_a_bowl() {
        for noise in [None, Some(0.1)] {
            let taken = (0..60).filter(|seed| gain(14, 0.0, *seed, noise, 1.0) > 3.0).count();
            assert!(taken <= 3, "{taken} of 60, {noise:?}");
            let missed = (0..20).filter(|seed| gain(14, 1.0, *seed, noise, 1.0) < 3.0).count();
            assert_eq!(missed, 0, "of 20, {noise:?}");
        }
    }

    /// With three values, of a weight of their own or two at a place, the densities of statrs.
    #[test]
    fn noise_alone_foretells_as_student_and_gauss_do() {
        let data = Data::new(1, vec![0.0, 0.5, 1.0, 1.0], vec![1.0, 2.5, 3.0, 4.0]).unwrap();
        let sites = Sites::new(&data, None).unwrap();
        let scale = sites.units().scale;
        let (means, weights, scatter) = ([1.0, 2.5, 3.5], [1.0, 1.0, 2.0], 0.5);
        let (mut gauss, mut student) = (0.0, 0.0);
        for place in 0..3 {
            let others: Vec<usize> = (0..3).filter(|other| *other != place).collect();
            let total: f64 = others.iter().map(|&other| weights[other]).sum();
            let expected = others.iter().map(|&other| weights[other] * means[other]).sum::<f64>() / total;
            let about: f64 = others.iter().map(|&other| weights[other] * (means[other] - expected).powi(2)).sum();
            let of_mean = 1.0 / weights[place] + 1.0 / total;
            gauss += Normal::new(expected, (0.04_f64 * of_mean).sqrt()).unwrap().ln_pdf(means[place]);
            let variance = (about + scatter) / 2.0 * of_mean;
            student += StudentsT::new(expected, variance.sqrt(), 2.0).unwrap().ln_pdf(means[place]);
        }
        // Densities of what is scaled are larger.
        let of_scale = 3.0 * scale.ln();
        let found = of_noise_alone(&sites, Some(0.04 / scale.powi(2))).unwrap();
        assert!((found - gauss - of_scale).abs() < 1e-9, "{found} {gauss}");
        let found = of_noise_alone(&sites, None).unwrap();
        assert!((found - student - of_scale).abs() < 1e-9, "{found} {student}");
    }

    #[test]
    fn too_few_and_equal_measurements_tell_nothing() {
        let of = |values: Vec<f64>| {
            let x = (0..values.len()).map(|i| i as f64).collect();
            let sites = Sites::new(&Data::new(1, x, values).unwrap(), None).unwrap();
            AveragedProcess::new(sites, &SamplerSettings::default()).unwrap().gain_over_noise(None)
        };
        assert_eq!(of(vec![1.0]), None, "one");
        assert_eq!(of(vec![1.0, 2.0]), None, "two");
        assert_eq!(of(vec![1.0; 5]), None, "equal");
        assert!(of(vec![1.0, 2.0, 4.0]).is_some());
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(8))]

        #[test]
        fn another_unit_changes_nothing(seed in 0_u64..1000, height in 0.0..1.0) {
            let (plain, in_milli) = (gain(10, height, seed, None, 1.0), gain(10, height, seed, None, 1000.0));
            prop_assert!((plain - in_milli).abs() < 1e-5 * plain.abs().max(1.0), "{plain} {in_milli}");
        }
    }
}
