//! Known names that look like a mistyped one.

use strsim::damerau_levenshtein;

/// At most three names that differ by case only, or by one slip (two in long names), the nearest first.
pub(crate) fn near_misses(name: &str, known: impl Iterator<Item = String>) -> Vec<String> {
    let allowed = if name.chars().count() > 5 { 2 } else { 1 };
    let lower = name.to_lowercase();
    let mut near: Vec<_> = known
        .filter_map(|candidate| {
            let distance = if candidate.to_lowercase() == lower { 0 } else { damerau_levenshtein(name, &candidate) };
            // One slip in a single letter is another letter.
            let meaningful = distance == 0 || (distance <= allowed && name.chars().count() > 1);
            meaningful.then_some((distance, candidate.chars().count(), candidate))
        })
        .collect();
    near.sort();
    near.dedup();
    // Where the case alone is wrong, nothing else was meant.
    if near.first().is_some_and(|(distance, ..)| *distance == 0) {
        near.retain(|(distance, ..)| *distance == 0);
    }
    near.into_iter().take(3).map(|(_, _, candidate)| candidate).collect()
}
