//! What entries of every chapter are held to.

use anyhow::{Result, ensure};

/// That a share is one of noise.
pub(crate) fn check_share(name: &str, share: f64) -> Result<()> {
    ensure!((0.0..1.0).contains(&share), "{name} = {share}: it must be 0 or more and less than 1");
    Ok(())
}

/// That a number of seeds is allowed.
pub(crate) fn check_seeds(name: &str, seeds: u64) -> Result<()> {
    ensure!((1..=1000).contains(&seeds), "{name} = {seeds}: from 1 to 1000 are allowed");
    Ok(())
}

/// That a number can be a length, a step or a scale.
pub(crate) fn check_positive(name: &str, value: f64) -> Result<()> {
    ensure!(value.is_finite() && value > 0.0, "{name} = {value}: it must be finite and more than zero");
    Ok(())
}

/// That every list has an entry.
pub(crate) fn check_not_empty<'a>(lists: impl IntoIterator<Item = (&'a str, usize)>) -> Result<()> {
    for (name, count) in lists {
        ensure!(count > 0, "{name}: at least one is needed");
    }
    Ok(())
}

/// That no label is there twice.
pub(crate) fn check_labels(name: &str, labels: impl IntoIterator<Item = String>) -> Result<()> {
    let labels: Vec<String> = labels.into_iter().collect();
    let twice = labels.iter().enumerate().find(|(at, label)| labels[..*at].contains(label));
    ensure!(twice.is_none(), "{name}: {} is there twice", twice.map_or("", |(_, label)| label));
    Ok(())
}
