//! Where experiments fail.

use faer::linalg::triangular_solve::{solve_lower_triangular_in_place, solve_upper_triangular_in_place};
use faer::{Mat, Par, Side};
use statrs::distribution::{Continuous, ContinuousCDF, Normal};

use crate::Error;
use crate::process::covariance::{Covariance, Hyperparameters, Residual, SimulationUse, Structure};
use crate::process::places::Places;

/// The probability that an experiment gives a response: a probit of a Gaussian process, by Laplace's approximation
/// (Rasmussen and Williams 2006, Algorithms 3.1, 3.2 and 5.1), averaged over a length per factor by the evidence: so a choice with
/// which nothing ever works is told from one place where something failed.
#[derive(Debug, Clone)]
pub struct Feasibility {
    places: Places,
    /// With their shares, which sum to 1.
    members: Vec<(f64, Member)>,
}

/// One length per factor, and what follows from the outcomes.
#[derive(Debug, Clone)]
struct Member {
    hyper: Hyperparameters,
    /// ∇ log p(labels | f) at the mode.
    gradient: Mat<f64>,
    /// √W on the diagonal.
    roots: Vec<f64>,
    /// Lower factor of I + √W K √W.
    factor: Mat<f64>,
    /// Logarithm of the evidence.
    evidence: f64,
}

/// Over which outcomes go together, in coded units: a quarter of the range of a factor, or so far that the factor hardly matters.
const LENGTHS: [f64; 4] = [0.6, 2.0, 6.0, 20.0];
/// Of the latent process. With a larger one Laplace's approximation is less sure of what never worked, not more.
const VARIANCE: f64 = 4.0;
/// With more outcomes than these fewer lengths are tried.
const MANY: usize = 150;
/// What has a smaller share than this does not count.
const LEAST_SHARE: f64 = 0.01;
const STRUCTURE: Structure = Structure { simulation: SimulationUse::Ignored, residual: Residual::Smooth };
/// Standard deviations of the latent process by which a design is feasible before anything failed.
const OFFSET: f64 = 1.0;

impl Feasibility {
    /// From places where experiments were made, each with whether it gave a response. Nothing if none failed: then every design
    /// may do.
    ///
    /// # Errors
    ///
    /// [`Error::Length`] unless there is one outcome per place.
    pub fn of(places: Places, succeeded: &[bool]) -> Result<Option<Self>, Error> {
        if succeeded.len() != places.n_places() {
            return Err(Error::Length { name: "outcomes", expected: places.n_places(), found: succeeded.len() });
        }
        if succeeded.iter().all(|&succeeded| succeeded) {
            return Ok(None);
        }
        let labels: Vec<f64> = succeeded.iter().map(|succeeded| if *succeeded { 1.0 } else { -1.0 }).collect();
        let members = tried(&places, &labels)?;
        let most = members.iter().map(|member| member.evidence).fold(f64::NEG_INFINITY, f64::max);
        let shares = || members.iter().map(|member| (member.evidence - most).exp());
        let all: f64 = shares().sum();
        let of_each = shares().zip(&members).filter(|(share, _)| *share >= LEAST_SHARE * all);
        let kept: f64 = of_each.clone().map(|(share, _)| share).sum();
        let members = of_each.map(|(share, member)| (share / kept, member.clone())).collect();
        Ok(Some(Self { places, members }))
    }

    /// Probability of a response at each place.
    ///
    /// # Errors
    ///
    /// [`Error::FactorMismatch`] unless the places have as many factors as those that were tried.
    pub fn probabilities(&self, places: &Places) -> Result<Vec<f64>, Error> {
        places.check_factors(self.places.n_factors())?;
        let mut sum = vec![0.0; places.n_places()];
        for (share, member) in &self.members {
            let own = member.probabilities(&self.places, places)?;
            sum.iter_mut().zip(own).for_each(|(sum, probability)| *sum += share * probability);
        }
        Ok(sum)
    }
}

/// The shortest lengths first, and from there one factor after the other: whatever was tried counts by its evidence.
fn tried(places: &Places, labels: &[f64]) -> Result<Vec<Member>, Error> {
    let n_factors = places.n_factors();
    let (lengths, n_sweeps) = if labels.len() > MANY { (&LENGTHS[..2], 1) } else { (&LENGTHS[..], 2) };
    let mut members = Vec::new();
    let mut best = Member::of(places, labels, vec![LENGTHS[0]; n_factors])?;
    for factor in (0..n_sweeps).flat_map(|_| 0..n_factors) {
        let own = best.hyper.lengths.clone();
        for &length in lengths {
            let mut lengths = own.clone();
            lengths[factor] = length;
            let known = |member: &Member| member.hyper.lengths == lengths;
            if known(&best) || members.iter().any(known) {
                continue;
            }
            let mut member = Member::of(places, labels, lengths)?;
            if member.evidence > best.evidence {
                std::mem::swap(&mut member, &mut best);
            }
            members.push(member);
        }
    }
    members.push(best);
    Ok(members)
}

impl Member {
    fn of(places: &Places, labels: &[f64], lengths: Vec<f64>) -> Result<Self, Error> {
        let hyper = Hyperparameters {
            trend: 0.0,
            simulation: 0.0,
            residual: VARIANCE,
            lengths,
            noise: 0.0,
            assembly: 0.0,
            additive: None,
        };
        let covariance = Covariance::of(STRUCTURE, &hyper)?.without_constant().between(places, places)?;
        let n = labels.len();
        let normal = Normal::standard();
        let mut latent = Mat::<f64>::zeros(n, 1);
        let (mut gradient, mut roots, mut factor) = (Mat::zeros(n, 1), vec![0.0; n], Mat::identity(n, n));
        // K⁻¹ f, so that f' K⁻¹ f needs no inverse.
        let mut solution = Mat::<f64>::zeros(n, 1);
        // Newton's steps for a concave objective; it settles in a handful.
        for _ in 0..30 {
            for i in 0..n {
                let at = labels[i] * (latent[(i, 0)] + OFFSET);
                // The inverse Mills ratio, by its asymptote where the tail underflows.
                let ratio = if at > FAR { normal.pdf(at) / normal.cdf(at) } else { -at };
                gradient[(i, 0)] = labels[i] * ratio;
                roots[i] = (ratio * (ratio + at)).max(1e-12).sqrt();
            }
            let mut matrix = Mat::from_fn(n, n, |i, j| roots[i] * covariance[(i, j)] * roots[j]);
            (0..n).for_each(|i| matrix[(i, i)] += 1.0);
            let Ok(llt) = matrix.llt(Side::Lower) else {
                break;
            };
            factor = llt.L().to_owned();
            let b = Mat::from_fn(n, 1, |i, _| roots[i] * roots[i] * latent[(i, 0)] + gradient[(i, 0)]);
            let product = &covariance * &b;
            let mut solved = Mat::from_fn(n, 1, |i, _| roots[i] * product[(i, 0)]);
            solve_lower_triangular_in_place(factor.as_ref(), solved.as_mut(), Par::Seq);
            solve_upper_triangular_in_place(factor.transpose(), solved.as_mut(), Par::Seq);
            solution = Mat::from_fn(n, 1, |i, _| b[(i, 0)] - roots[i] * solved[(i, 0)]);
            let next = &covariance * &solution;
            let change = (&next - &latent).norm_max();
            latent = next;
            if change < 1e-9 {
                break;
            }
        }
        let likelihood = |i: usize| {
            let at = labels[i] * (latent[(i, 0)] + OFFSET);
            // By the same asymptote: ln φ(x) − ln(−x).
            if at > FAR { normal.cdf(at).ln() } else { normal.ln_pdf(at) - (-at).ln() }
        };
        let of_each = (0..n).map(|i| likelihood(i) - 0.5 * solution[(i, 0)] * latent[(i, 0)] - factor[(i, i)].ln());
        let evidence = of_each.sum();
        Ok(Self { hyper, gradient, roots, factor, evidence })
    }

    fn probabilities(&self, tested: &Places, places: &Places) -> Result<Vec<f64>, Error> {
        let covariance = Covariance::of(STRUCTURE, &self.hyper)?.without_constant();
        let cross = covariance.between(places, tested)?;
        let means = &cross * &self.gradient;
        let mut whitened = Mat::from_fn(self.roots.len(), places.n_places(), |i, j| self.roots[i] * cross[(j, i)]);
        solve_lower_triangular_in_place(self.factor.as_ref(), whitened.as_mut(), Par::Seq);
        let prior = covariance.variances(places)?;
        let normal = Normal::standard();
        let probability = |place: usize| {
            let variance = (prior[place] - whitened.col(place).squared_norm_l2()).max(0.0);
            normal.cdf((means[(place, 0)] + OFFSET) / (1.0 + variance).sqrt())
        };
        Ok((0..places.n_places()).map(probability).collect())
    }
}

/// Beyond this the normal distribution is known by its asymptote.
const FAR: f64 = -30.0;

#[cfg(test)]
mod tests {
    use super::*;

    /// Of the latent process: Matérn-5/2 of variance 4 and length 0.6.
    fn kernel(a: [f64; 2], b: [f64; 2]) -> f64 {
        let r = 5.0_f64.sqrt() * (a[0] - b[0]).hypot(a[1] - b[1]) / 0.6;
        4.0 * (1.0 + r + r * r / 3.0) * (-r).exp()
    }

    /// Two experiments, of which the first failed: the mode by small steps along the gradient, the rest by a 2 by 2 inverse. The
    /// evidence by a sum over the plane, to the tenth that Laplace's approximation is good for.
    #[test]
    fn probabilities_after_a_failure_and_a_success_are_those_of_laplace() {
        let tested = [[0.3, -0.4], [-0.2, 0.5]];
        let labels = [-1.0, 1.0];
        let normal = Normal::standard();
        let k: Vec<[f64; 2]> = tested.iter().map(|&a| [kernel(a, tested[0]), kernel(a, tested[1])]).collect();
        let slope = |f: f64, label: f64| label * normal.pdf(f + 1.0) / normal.cdf(label * (f + 1.0));
        let mut mode = [0.0; 2];
        for _ in 0..2000 {
            let slopes = [slope(mode[0], labels[0]), slope(mode[1], labels[1])];
            for i in 0..2 {
                mode[i] += 0.05 * (k[i][0] * slopes[0] + k[i][1] * slopes[1] - mode[i]);
            }
        }
        let slopes = [slope(mode[0], labels[0]), slope(mode[1], labels[1])];
        // The curvature of the logarithm by a difference of its slope.
        let h = 1e-5;
        let curvature = |i: usize| (slope(mode[i] - h, labels[i]) - slope(mode[i] + h, labels[i])) / (2.0 * h);
        let (a, b, off) = (k[0][0] + 1.0 / curvature(0), k[1][1] + 1.0 / curvature(1), k[0][1]);
        let determinant = a * b - off * off;

        let places = [[0.3, -0.4], [-0.2, 0.5], [0.0, 0.0], [0.9, 0.9]];
        let tested_places = Places::new(2, &tested.concat()).expect("valid places");
        let member = Member::of(&tested_places, &labels, vec![LENGTHS[0]; 2]).expect("two factors");
        let elsewhere = Places::new(2, &places.concat()).expect("valid places");
        let found = member.probabilities(&tested_places, &elsewhere).expect("two factors");
        for (place, found) in places.into_iter().zip(found) {
            let [u, v] = [kernel(place, tested[0]), kernel(place, tested[1])];
            let mean = u * slopes[0] + v * slopes[1] + 1.0;
            let variance = kernel(place, place) - (b * u * u - 2.0 * off * u * v + a * v * v) / determinant;
            let expected = normal.cdf(mean / (1.0 + variance).sqrt());
            assert!((found - expected).abs() < 1e-7, "{found} for {expected} at {place:?}");
        }
        let [[a, off], [_, b]] = [k[0], k[1]];
        let determinant = a * b - off * off;
        let step = 0.05;
        let density = |x: f64, y: f64| {
            let square = (b * x * x - 2.0 * off * x * y + a * y * y) / determinant;
            let likelihood = normal.cdf(labels[0] * (x + 1.0)) * normal.cdf(labels[1] * (y + 1.0));
            likelihood * (-0.5 * square).exp() / (2.0 * std::f64::consts::PI * determinant.sqrt())
        };
        let axis = || (-300..=300).map(|i| f64::from(i) * step);
        let exact: f64 =
            axis().flat_map(|x| axis().map(move |y| (x, y))).map(|(x, y)| density(x, y) * step * step).sum();
        assert!((member.evidence - exact.ln()).abs() < 0.1, "{} for {}", member.evidence, exact.ln());
    }
}
