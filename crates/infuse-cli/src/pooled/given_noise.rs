//! Whether repeats contradict the noise that the file gives: of the response, and of each constraint.

use infuse::global::PureError;
use infuse::pooled::Assessment;
use page::Finding;
use statrs::distribution::{ChiSquared, ContinuousCDF as _};

use super::campaign::Campaign;
use crate::number::{count, short, with_unit};

/// Repeats whose scatter is less likely than this speak against the noise that was given.
const UNLIKELY: f64 = 1e-3;

/// What repeats say against the noise that was given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Contradiction {
    given: f64,
    error: PureError,
    /// Settings that were run more than once.
    n_designs: usize,
}

impl Contradiction {
    fn of(given: Option<f64>, runs: &[(Vec<f64>, f64)]) -> Option<Self> {
        let (given, error) = (given?, PureError::of_readings(runs.iter().cloned())?);
        is_contradicted(given, error).then(|| Self { given, error, n_designs: n_repeated(runs) })
    }

    /// What repeats scatter by.
    pub(super) fn measured(&self) -> f64 {
        self.error.standard_deviation()
    }

    fn is_too_small(&self) -> bool {
        self.measured() > self.given
    }

    /// `shown` says a standard deviation in words.
    fn in_words(&self, what: &str, shown: impl Fn(f64) -> String) -> Finding {
        let by_chance = match self.given > 0.0 {
            true => ", which by chance would happen less than one time in a thousand",
            false => "",
        };
        let so = match self.is_too_small() {
            true => "What is said of the recommended design and of how much better others may be is too sure",
            false => "Bands and bounds are wider than they need be",
        };
        let sentence = format!(
            "Careful: {what} is {}, but {} of {} {} by {} (standard deviation){by_chance}. {so}: take `noise` out, and it is learnt, or \
             give what was measured.",
            shown(self.given),
            count(self.error.degrees_of_freedom, "repeat"),
            count(self.n_designs, "design"),
            if self.error.degrees_of_freedom == 1 { "scatters" } else { "scatter" },
            shown(self.measured())
        );
        Finding::new(sentence)
    }
}

/// The sum of squares of repeats is χ² of their number times the square of the noise.
fn is_contradicted(given: f64, error: PureError) -> bool {
    let n = error.degrees_of_freedom as f64;
    let sum_of_squares = n * error.variance;
    if given <= 0.0 {
        return sum_of_squares > 0.0;
    }
    let below = ChiSquared::new(n).map(|chi_squared| chi_squared.cdf(sum_of_squares / (given * given)));
    below.is_ok_and(|below| !(UNLIKELY..=1.0 - UNLIKELY).contains(&below))
}

/// Settings that come more than once, to the last bit but for the sign of zero.
fn n_repeated(runs: &[(Vec<f64>, f64)]) -> usize {
    let mut settings: Vec<Vec<u64>> =
        runs.iter().map(|(at, _)| at.iter().map(|x| (x + 0.0).to_bits()).collect()).collect();
    settings.sort_unstable();
    settings.chunk_by(|a, b| a == b).filter(|same| same.len() > 1).count()
}

/// What repeats say against the noise of the response. A run that is set aside is a slip, and says nothing of it.
pub(super) fn contradiction(campaign: &Campaign, found: &Assessment) -> Option<Contradiction> {
    let is_set_aside = |at: usize| found.outliers.iter().any(|outlier| outlier.set_aside && outlier.reading == at);
    let counted = campaign.runs_to_compare(found).into_iter().enumerate().filter(|(at, _)| !is_set_aside(*at));
    let runs: Vec<_> = counted.map(|(_, run)| run).collect();
    Contradiction::of(campaign.settings.noise, &runs)
}

/// Noise that was given too small: what is said is too sure.
pub(super) fn too_small(campaign: &Campaign, found: &Assessment) -> Vec<Finding> {
    said(campaign, found, Contradiction::is_too_small)
}

/// Noise that was given too large.
pub(super) fn too_large(campaign: &Campaign, found: &Assessment) -> Vec<Finding> {
    said(campaign, found, |contradiction| !contradiction.is_too_small())
}

fn said(campaign: &Campaign, found: &Assessment, is_meant: impl Fn(&Contradiction) -> bool) -> Vec<Finding> {
    let response = &campaign.problem.response;
    let of_response = contradiction(campaign, found).filter(&is_meant).map(|contradiction| {
        let [given, measured] =
            [contradiction.given, contradiction.measured()].map(|noise| response.of_difference(noise));
        let finding = contradiction.in_words("`noise` in [loop]", |noise| response.amount(noise));
        with_both(finding, given, measured, response.unit_of_differences())
    });
    let of_constraints = campaign.problem.constraints.iter().filter_map(|held| {
        let runs = campaign.runs_of(held.name());
        let contradiction = Contradiction::of(held.constraint.noise, &runs).filter(&is_meant)?;
        let what = format!("`noise` in [[constraint]] `{}`", held.name());
        let finding = contradiction.in_words(&what, |noise| with_unit(&short(noise), &held.unit));
        Some(with_both(finding, contradiction.given, contradiction.measured(), &held.unit))
    });
    of_response.into_iter().chain(of_constraints).collect()
}

fn with_both(finding: Finding, given: f64, measured: f64, unit: &str) -> Finding {
    finding.with("noise given", given, unit).with("noise of repeats", measured, unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs of one design about zero, whose squares sum to this.
    fn error(n_runs: usize, sum_of_squares: f64) -> PureError {
        let half = (sum_of_squares / 2.0).sqrt();
        let mut runs = vec![(vec![0.0], half), (vec![0.0], -half)];
        runs.resize(n_runs, (vec![-0.0], 0.0));
        PureError::of_readings(runs).expect("repeats")
    }

    /// scipy: chi2.isf(1e-3, 1) = 10.828, chi2.isf(1e-3, 9) = 27.877, chi2.ppf(1e-3, 9) = 1.152.
    #[test]
    fn noise_is_contradicted_where_chance_would_do_it_one_time_in_a_thousand() {
        for (n_runs, sum_of_squares, is_far) in [
            (2, 10.8, false),
            (2, 10.9, true),
            (10, 27.8, false),
            (10, 27.9, true),
            (10, 1.16, false),
            (10, 1.14, true),
        ] {
            assert_eq!(is_contradicted(3.0, error(n_runs, 9.0 * sum_of_squares)), is_far, "{n_runs}, {sum_of_squares}");
        }
        assert!(is_contradicted(0.0, error(2, 1e-9)) && !is_contradicted(0.0, error(5, 0.0)));
    }

    #[test]
    fn designs_that_were_run_twice_are_counted_once() {
        let runs = [0.0, 1.0, -0.0, 2.0, 1.0, 0.0, 3.0].map(|at| (vec![at, 5.0], at));
        assert_eq!((n_repeated(&runs), n_repeated(&runs[3..5])), (2, 0));
    }
}
