//! Structures and hyperparameters drawn from what the measurements leave possible.

use std::f64::consts::TAU;

use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;

use crate::process::covariance::{Additive, Hyperparameters, Structure};
use crate::process::gaussian_process::Problem;
use crate::process::sites::Sites;

/// A normal prior of a logarithm: what it is centered on, and its standard deviation.
#[derive(Debug, Clone, Copy, PartialEq)]
struct LogNormal {
    center: f64,
    spread: f64,
}

impl LogNormal {
    fn at(self, normal: f64) -> f64 {
        self.center * (self.spread * normal).exp()
    }
}

const RESIDUAL: LogNormal = LogNormal { center: 0.1, spread: 2.0 };
const NOISE: LogNormal = LogNormal { center: 0.01, spread: 1.5 };
/// Of the error that an assembly shares, where assemblies are told apart.
const ASSEMBLY: LogNormal = LogNormal { center: 0.01, spread: 1.5 };
const TREND: LogNormal = LogNormal { center: 0.5, spread: 1.5 };
const SIMULATION: LogNormal = LogNormal { center: 0.25, spread: 1.5 };
/// In coded units, of which an axis has two.
const LENGTH: LogNormal = LogNormal { center: 0.9, spread: 0.8 };

/// How the sampler works.
#[derive(Debug, Clone, PartialEq)]
pub struct SamplerSettings {
    /// The structures that are possible before anything was measured, all with the same probability.
    pub structures: Vec<Structure>,
    /// Standard deviation of a measurement of weight 1, in the unit of the response, if it is known.
    pub noise: Option<f64>,
    /// Whether measurements of an assembly share an error, where assemblies are told apart. Default true.
    pub shared_error: bool,
    /// Number of particles, at least 2. Default 32.
    pub particles: usize,
    /// Slice steps of each particle at each temperature. Default 1.
    pub sweeps: usize,
    /// Slice steps of each particle after the last. Default 4.
    pub last_sweeps: usize,
    /// Everything random follows from it.
    pub seed: u64,
}

impl Default for SamplerSettings {
    fn default() -> Self {
        let structures = Structure::ALL.to_vec();
        Self { structures, noise: None, shared_error: true, particles: 32, sweeps: 1, last_sweeps: 4, seed: 1 }
    }
}

/// A structure with its hyperparameters as independent standard normals.
#[derive(Debug, Clone, PartialEq)]
struct Particle {
    structure: Structure,
    normals: Vec<f64>,
    log_likelihood: f64,
}

/// What the measurements leave possible.
pub(crate) struct Sample {
    /// Of equal weight.
    pub(crate) particles: Vec<(Structure, Hyperparameters)>,
    /// Logarithm of the density of the measurements, averaged over the structures and hyperparameters as they were possible before; but for
    /// a constant that depends on the sites alone.
    pub(crate) log_evidence: f64,
}

/// A sample of the structures and hyperparameters given the measurements.
///
/// Annealed importance resampling: from the prior, the likelihood is raised to powers that grow from 0 to 1, each as far as
/// half of the particles keep their weight; at each power the particles are resampled, and moved by elliptical slice
/// sampling (Del Moral et al. 2006; Murray et al. 2010). The product of
/// the mean weights on the way is the evidence. The same for any number of threads.
pub(crate) fn sample(sites: &Sites, settings: &SamplerSettings) -> Sample {
    let problem = Problem::of(sites);
    let decode = Decoder {
        n_factors: sites.places().n_factors(),
        noise: settings.noise,
        has_assemblies: settings.shared_error && sites.assemblies().is_some(),
        additive: sites.additive(),
        scale: sites.units().scale,
    };
    let likelihood = |structure, normals: &[f64]| problem.log_likelihood(structure, &decode.hyperparameters(normals));
    let n = settings.particles.max(2);
    let mut streams = Streams { seed: settings.seed, next: 0 };
    let mut particles: Vec<Particle> = (0..n)
        .map(|index| (index, streams.next()))
        .collect::<Vec<_>>()
        .into_par_iter()
        .map(|(index, mut rng)| {
            let structure = settings.structures[index % settings.structures.len()];
            let normals: Vec<f64> = (0..decode.n_normals()).map(|_| StandardNormal.sample(&mut rng)).collect();
            let log_likelihood = likelihood(structure, &normals);
            Particle { structure, normals, log_likelihood }
        })
        .collect();
    let (mut power, mut log_evidence) = (0.0, 0.0);
    while power < 1.0 {
        let next = next_power(&particles, power);
        log_evidence += log_mean_weight(&particles, next - power);
        particles = resampled(&particles, next - power, streams.next().random());
        power = next;
        let sweeps = if power < 1.0 { settings.sweeps } else { settings.last_sweeps };
        let tasks: Vec<_> = particles.into_iter().map(|particle| (particle, streams.next())).collect();
        let moved = tasks.into_par_iter().map(|(mut particle, mut rng)| {
            for _ in 0..sweeps {
                particle.slice(power, &likelihood, &mut rng);
            }
            particle
        });
        particles = moved.collect();
    }
    let decoded = |particle: Particle| (particle.structure, decode.hyperparameters(&particle.normals));
    Sample { particles: particles.into_iter().map(decoded).collect(), log_evidence }
}

/// A random stream for each task, in the order in which they are taken.
struct Streams {
    seed: u64,
    next: u64,
}

impl Streams {
    fn next(&mut self) -> ChaCha8Rng {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream(self.next);
        self.next += 1;
        rng
    }
}

/// From standard normals to hyperparameters.
#[derive(Debug, Clone, Copy)]
struct Decoder<'a> {
    n_factors: usize,
    noise: Option<f64>,
    has_assemblies: bool,
    /// Axes of the additive part.
    additive: &'a [usize],
    scale: f64,
}

impl Decoder<'_> {
    fn n_normals(self) -> usize {
        let of_additive = if self.additive.is_empty() { 0 } else { self.additive.len() + 1 };
        self.n_factors + 4 + usize::from(self.has_assemblies) + of_additive
    }

    fn hyperparameters(self, normals: &[f64]) -> Hyperparameters {
        let (normals, others) = normals.split_at(self.n_factors + 4);
        let (of_assembly, of_additive) = others.split_at(usize::from(self.has_assemblies));
        let prior = Hyperparameters::of_prior(normals);
        let noise = self.noise.map_or(prior.noise, |noise| (noise / self.scale).powi(2));
        let assembly = of_assembly.first().map_or(0.0, |&normal| ASSEMBLY.at(normal));
        let additive = of_additive.split_first().map(|(&variance, lengths)| Additive {
            axes: self.additive.to_vec(),
            variance: RESIDUAL.at(variance),
            lengths: lengths.iter().map(|&normal| LENGTH.at(normal)).collect(),
        });
        Hyperparameters { noise, assembly, additive, ..prior }
    }
}

impl Hyperparameters {
    /// The prior, as a function of independent standard normals: one for each length, then for the variances of trend,
    /// simulation, residual and noise. Each is the exponential of a normal; with center and standard deviation of the logarithm
    /// 0.9 and 0.8 (lengths, coded), 0.5 and 1.5 (trend), 0.25 and 1.5 (simulation), 0.1 and 2 (residual), 0.01 and 1.5 (noise).
    ///
    /// # Panics
    ///
    /// For fewer than five normals.
    #[must_use]
    pub fn of_prior(normals: &[f64]) -> Self {
        let (lengths, others) = normals.split_at(normals.len() - 4);
        Self {
            trend: TREND.at(others[0]),
            simulation: SIMULATION.at(others[1]),
            residual: RESIDUAL.at(others[2]),
            lengths: lengths.iter().map(|&normal| LENGTH.at(normal)).collect(),
            noise: NOISE.at(others[3]),
            assembly: 0.0,
            additive: None,
        }
    }
}

impl Particle {
    /// One step of elliptical slice sampling with the likelihood raised to `power`.
    fn slice(&mut self, power: f64, likelihood: &impl Fn(Structure, &[f64]) -> f64, rng: &mut impl Rng) {
        let other: Vec<f64> = self.normals.iter().map(|_| StandardNormal.sample(rng)).collect();
        let level = power * self.log_likelihood + rng.random::<f64>().max(f64::MIN_POSITIVE).ln();
        let mut angle = TAU * rng.random::<f64>();
        let mut bracket = [angle - TAU, angle];
        // The bracket shrinks to the present state, which lies on the slice; a hundred halvings are beyond rounding.
        for _ in 0..100 {
            let (sine, cosine) = angle.sin_cos();
            let proposed: Vec<f64> = self.normals.iter().zip(&other).map(|(a, b)| a * cosine + b * sine).collect();
            let log_likelihood = likelihood(self.structure, &proposed);
            if power * log_likelihood > level {
                (self.normals, self.log_likelihood) = (proposed, log_likelihood);
                return;
            }
            bracket[usize::from(angle >= 0.0)] = angle;
            angle = bracket[0] + (bracket[1] - bracket[0]) * rng.random::<f64>();
        }
    }
}

/// How far the likelihood can be raised before the effective number of particles falls below half of them.
fn next_power(particles: &[Particle], power: f64) -> f64 {
    let effective = |step: f64| {
        let weights = weights(particles, step);
        1.0 / weights.iter().map(|weight| weight * weight).sum::<f64>()
    };
    let wanted = 0.5 * particles.len() as f64;
    if effective(1.0 - power) >= wanted {
        return 1.0;
    }
    let [mut low, mut high] = [0.0, 1.0 - power];
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if effective(middle) >= wanted {
            low = middle;
        } else {
            high = middle;
        }
    }
    // Never stand still, should all but a few particles have no likelihood at all.
    (power + low.max(1e-3)).min(1.0)
}

fn largest_log_likelihood(particles: &[Particle]) -> f64 {
    particles.iter().map(|particle| particle.log_likelihood).fold(f64::NEG_INFINITY, f64::max)
}

/// Logarithm of the mean of the likelihoods to the power of `step`; −∞ where no particle has a likelihood.
fn log_mean_weight(particles: &[Particle], step: f64) -> f64 {
    let largest = largest_log_likelihood(particles);
    if largest == f64::NEG_INFINITY {
        return largest;
    }
    let relative = particles.iter().map(|particle| (step * (particle.log_likelihood - largest)).exp());
    step * largest + (relative.sum::<f64>() / particles.len() as f64).ln()
}

/// Weights of the particles, which sum to 1; equal ones where no particle has a likelihood.
fn weights(particles: &[Particle], step: f64) -> Vec<f64> {
    let largest = largest_log_likelihood(particles);
    if largest == f64::NEG_INFINITY {
        return vec![1.0 / particles.len() as f64; particles.len()];
    }
    let relative: Vec<f64> =
        particles.iter().map(|particle| (step * (particle.log_likelihood - largest)).exp()).collect();
    let total: f64 = relative.iter().sum();
    relative.iter().map(|weight| weight / total).collect()
}

/// As many particles, each as often as its weight asks, with one random offset for all.
fn resampled(particles: &[Particle], step: f64, offset: f64) -> Vec<Particle> {
    let weights = weights(particles, step);
    let n = particles.len();
    let mut chosen = Vec::with_capacity(n);
    let mut sum = 0.0;
    for (particle, weight) in particles.iter().zip(weights) {
        sum += weight * n as f64;
        while chosen.len() < n && chosen.len() as f64 + offset < sum {
            chosen.push(particle.clone());
        }
    }
    while let (true, Some(last)) = (chosen.len() < n, particles.last()) {
        chosen.push(last.clone());
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::process::covariance::{Residual, SimulationUse};

    fn particle(normal: f64, log_likelihood: f64) -> Particle {
        let structure = Structure { simulation: SimulationUse::Ignored, residual: Residual::None };
        Particle { structure, normals: vec![normal], log_likelihood }
    }

    /// Weights 4, 2, 1 and 1 of 8, so 2, 1 and twice a half of four: whole numbers always, halves for half of the offsets.
    #[test]
    fn particles_come_as_often_as_their_weights_ask() {
        let weighted = [4.0_f64, 2.0, 1.0, 1.0];
        let particles: Vec<Particle> =
            weighted.iter().enumerate().map(|(i, weight)| particle(i as f64, weight.ln())).collect();
        for (offset, expected) in
            [(0.1, [0.0, 0.0, 1.0, 2.0]), (0.45, [0.0, 0.0, 1.0, 2.0]), (0.7, [0.0, 0.0, 1.0, 3.0])]
        {
            let found: Vec<f64> =
                resampled(&particles, 1.0, offset).iter().map(|particle| particle.normals[0]).collect();
            assert_eq!(found, expected, "offset {offset}");
        }
    }

    /// Where the likelihood is a narrow normal about 0.8, the posterior is known, and every step finds the slice again.
    #[test]
    fn slice_steps_always_move_and_keep_the_posterior() {
        let deviation = 0.01_f64;
        let likelihood = |_: Structure, normals: &[f64]| -0.5 * ((normals[0] - 0.8) / deviation).powi(2);
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let mut state = particle(0.8, 0.0);
        let (mut sum, mut squares) = (0.0, 0.0);
        const STEPS: usize = 4000;
        for _ in 0..STEPS {
            let before = state.normals[0];
            state.slice(1.0, &likelihood, &mut rng);
            assert_ne!(state.normals[0].to_bits(), before.to_bits(), "it moves");
            sum += state.normals[0] / STEPS as f64;
            squares += (state.normals[0] - 0.8).powi(2) / STEPS as f64;
        }
        let variance = 1.0 / (1.0 + deviation.powi(-2));
        let mean = variance * 0.8 / (deviation * deviation);
        assert!((sum - mean).abs() < 0.1 * deviation, "mean {sum}, expected {mean}");
        assert!((squares / variance - 1.0).abs() < 0.15, "variance {squares}, expected {variance}");
    }
}
