//! How wide bands are, and how many digits are worth showing.

use infuse::pooled::Assessment;

pub(super) use infuse::pooled::reported::NINE_IN_TEN;

/// From this probability that it is better ignored a simulation is hardly used.
pub(super) const IGNORED: f64 = 0.9;

/// How well responses are known: what is smaller need not be shown.
pub(super) fn resolution(found: &Assessment) -> f64 {
    [found.noise, found.recommended.deviation, found.certificate.bound]
        .into_iter()
        .filter(|size| *size > 0.0)
        .fold(f64::NAN, f64::min)
}
