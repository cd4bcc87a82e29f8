//! The responses that have to stay within bounds, in words.

use infuse::pooled::Standing;
use infuse::pooled::reported::Constrained;
use page::Finding;
use serde_json::{Value, json};

use super::bands::NINE_IN_TEN;
use super::campaign::Campaign;
use crate::number::{percent, resolved, short, with_unit};
use crate::problem::Held;

/// What is known of each constrained response at a design.
pub(super) fn constrained_there(campaign: &Campaign, there: &Standing) -> Vec<Finding> {
    let pairs = campaign.problem.constraints.iter().zip(&there.constrained);
    pairs.map(|(held, there)| in_words(held, there)).collect()
}

fn in_words(held: &Held, there: &Constrained) -> Finding {
    let Some((mean, deviation)) = there.expected else {
        return Finding::new(format!("{}: not measured yet; {} is asked for.", held.name(), held.bounds()));
    };
    let half = NINE_IN_TEN * deviation;
    let measured = there.measured.map_or_else(String::new, |measured| {
        format!("; {} measured there", with_unit(&resolved(measured, half / 10.0), &held.unit))
    });
    let sentence = format!(
        "{} there: {} expected, give or take {} (90 %): {} with {} probability{measured}.",
        held.name(),
        with_unit(&resolved(mean, half), &held.unit),
        with_unit(&short(half), &held.unit),
        held.bounds(),
        chance(there.within)
    );
    Finding::new(sentence).with(held.name(), mean, &held.unit).with("give or take", half, &held.unit).with(
        "probability to keep to the bounds",
        there.within,
        "1",
    )
}

/// ", within the bounds with 3 % probability", where there are any.
pub(super) fn likely_to_keep(campaign: &Campaign, there: &Standing) -> String {
    if campaign.problem.constraints.is_empty() {
        return String::new();
    }
    format!(", within the bounds with {} probability", chance(within(there)))
}

/// In words. What is told by a surface is never quite sure, though rounding may make it so.
fn chance(probability: f64) -> String {
    percent(probability.min(1.0 - f64::EPSILON))
}

/// The probability that it keeps to all of its bounds.
fn within(there: &Standing) -> f64 {
    there.constrained.iter().map(|one| one.within).product()
}

/// The same, of a design that is likelier to break one.
pub(super) fn unlikely_to_keep(there: &Standing) -> Option<f64> {
    (!there.constrained.is_empty()).then(|| within(there)).filter(|&within| within < 0.5)
}

/// That the recommended design is not sure enough to keep to its bounds.
pub(super) fn not_sure(campaign: &Campaign, recommended: &Standing) -> Option<Finding> {
    if recommended.suffices || campaign.problem.constraints.is_empty() {
        return None;
    }
    let asked: Vec<String> = campaign.problem.constraints.iter().map(Held::in_words).collect();
    let sentence = format!(
        "Careful: no design is known to keep to what is asked for ({}). The recommended one is the likeliest to.",
        asked.join("; ")
    );
    Some(Finding::new(sentence))
}

/// For programs.
pub(super) fn as_json(campaign: &Campaign, there: &[Constrained]) -> Value {
    let pairs = campaign.problem.constraints.iter().zip(there);
    let one = |(held, there): (&Held, &Constrained)| {
        let (expected, deviation) = there.expected.unzip();
        let value = json!({
            "expected": expected, "deviation": deviation, "probability": there.within.min(1.0), "measured": there.measured,
            "lower": held.constraint.lower, "upper": held.constraint.upper,
        });
        (held.name().to_owned(), value)
    };
    Value::Object(pairs.map(one).collect())
}
