//! How wide bands are, and how many digits are worth showing.

use infuse::pooled::Assessment;

/// Standard deviations on either side of an expectation, within which the response lies with 90 % probability.
pub(super) const NINE_IN_TEN: f64 = 1.645;

/// How well responses are known: what is smaller need not be shown.
pub(super) fn resolution(found: &Assessment) -> f64 {
    [found.noise, found.recommended.deviation, found.certificate.bound]
        .into_iter()
        .filter(|size| *size > 0.0)
        .fold(f64::NAN, f64::min)
}
