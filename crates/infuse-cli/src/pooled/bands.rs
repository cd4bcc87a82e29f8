//! How wide bands are, and how many digits are worth showing.

use infuse::pooled::Assessment;

pub(super) use infuse::pooled::reported::NINE_IN_TEN;

/// How well responses are known: what is smaller need not be shown.
pub(super) fn resolution(found: &Assessment) -> f64 {
    [found.noise, found.recommended.deviation, found.certificate.bound]
        .into_iter()
        .filter(|size| *size > 0.0)
        .fold(f64::NAN, f64::min)
}
