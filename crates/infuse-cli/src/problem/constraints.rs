//! Constraints: responses within bounds, and settings that go together.

use anyhow::{Context as _, Result, ensure};
use design_space::Region;
use infuse::pooled::{Constraint, LinearConstraint};

use super::file::{ConstraintEntry, LinearEntry};
use super::reserved::is_reserved;
use crate::number::{percent, plain, with_unit};

/// A response that has to stay within bounds.
#[derive(Debug, Clone)]
pub(crate) struct Held {
    pub(crate) unit: String,
    pub(crate) constraint: Constraint,
}

impl Held {
    pub(crate) fn name(&self) -> &str {
        &self.constraint.name
    }

    /// "at most 12 mm", "2 mm to 12 mm".
    pub(crate) fn bounds(&self) -> String {
        let shown = |bound: f64| with_unit(&plain(bound), &self.unit);
        match (self.constraint.lower, self.constraint.upper) {
            (Some(lower), Some(upper)) => format!("{} to {}", plain(lower), shown(upper)),
            (Some(lower), None) => format!("at least {}", shown(lower)),
            (_, Some(upper)) => format!("at most {}", shown(upper)),
            (None, None) => "anything".to_owned(),
        }
    }

    /// "travel at most 12 mm with 90 % probability".
    pub(crate) fn in_words(&self) -> String {
        format!("{} {} with {} probability", self.name(), self.bounds(), percent(self.constraint.probability))
    }

    fn of(entry: ConstraintEntry, region: &Region, response: &str) -> Result<Self> {
        let ConstraintEntry { name, unit, lower, upper, probability, noise } = entry;
        let is_plain =
            |text: &str| text.trim() == text && !text.contains(['[', ']', ',', ';', '"', '\n', '=', '{', '}']);
        ensure!(
            !name.is_empty() && is_plain(&name),
            "`name` is {name:?}, expected words without brackets, quotes, commas, semicolons or equals signs"
        );
        ensure!(is_plain(&unit), "`unit` is {unit:?}, expected one without brackets, quotes, commas or semicolons");
        let is_taken = region.index_of(&name).is_some() || name == response;
        ensure!(!is_taken, "`{name}` is also the name of a parameter or of the response, expected another");
        ensure!(
            !is_reserved(&name) && name != "value",
            "`{name}` is a heading of sheets or a word of programs, expected another name"
        );
        ensure!(
            lower.is_some() || upper.is_some(),
            "`{name}` has neither `lower` nor `upper`, expected one of them or both"
        );
        let mut constraint = Constraint::new(name);
        (constraint.lower, constraint.upper, constraint.noise) = (lower, upper, noise);
        constraint.probability = probability.unwrap_or(constraint.probability);
        constraint.validate()?;
        Ok(Self { unit, constraint })
    }
}

/// Every constraint on a response.
pub(super) fn held(entries: Vec<ConstraintEntry>, region: &Region, response: &str) -> Result<Vec<Held>> {
    let mut all: Vec<Held> = Vec::with_capacity(entries.len());
    for entry in entries {
        let held = Held::of(entry, region, response).context("[[constraint]]")?;
        let comes_twice = all.iter().any(|other| other.name() == held.name());
        ensure!(!comes_twice, "[[constraint]]: `{}` comes twice; one constraint may have both bounds", held.name());
        all.push(held);
    }
    Ok(all)
}

/// "x + 2 y at most 5".
pub(crate) fn linear_in_words(region: &Region, linear: &LinearConstraint) -> String {
    let used = || region.parameters().iter().zip(&linear.coefficients).filter(|(_, factor)| **factor != 0.0);
    // A lower bound is kept as an upper one, with all signs turned.
    let is_turned = used().next().is_some_and(|(_, factor)| *factor < 0.0);
    let sign = if is_turned { -1.0 } else { 1.0 };
    let mut text = String::new();
    for (place, (parameter, factor)) in used().enumerate() {
        let factor = sign * factor;
        text.push_str(match (place, factor < 0.0) {
            (0, _) => "",
            (_, true) => " - ",
            (_, false) => " + ",
        });
        let size = factor.abs();
        if (size - 1.0).abs() > f64::EPSILON {
            text.push_str(&format!("{} ", plain(size)));
        }
        text.push_str(parameter.name());
    }
    let word = if is_turned { "at least" } else { "at most" };
    format!("{text} {word} {}", plain(sign * linear.upper))
}

/// Every constraint on the settings; one with two bounds makes two.
pub(super) fn linear(entries: Vec<LinearEntry>, region: &Region) -> Result<Vec<LinearConstraint>> {
    let mut all = Vec::new();
    for LinearEntry { sum, lower, upper } in entries {
        let named: Vec<String> = region.parameters().iter().map(|p| format!("`{}`", p.name())).collect();
        if let Some(unknown) = sum.keys().find(|name| region.index_of(name).is_none()) {
            anyhow::bail!(
                "[[linear_constraint]]: `sum` has `{unknown}`, which is no parameter; expected some of {}",
                named.join(", ")
            );
        }
        for parameter in region.parameters().iter().filter(|parameter| sum.contains_key(parameter.name())) {
            parameter.check_number().context("[[linear_constraint]]: `sum`")?;
        }
        ensure!(
            !sum.is_empty(),
            "[[linear_constraint]]: `sum` is empty, expected some of {} with their factors",
            named.join(", ")
        );
        if let Some((name, factor)) = sum.iter().find(|(_, factor)| !factor.is_finite()) {
            anyhow::bail!("[[linear_constraint]]: `sum` has {factor:?} for `{name}`, expected a finite factor");
        }
        ensure!(
            sum.values().any(|factor| *factor != 0.0),
            "[[linear_constraint]]: every factor of `sum` is 0, expected one at least that is not"
        );
        for (key, bound) in [("lower", lower), ("upper", upper)] {
            if let Some(bound) = bound.filter(|bound| !bound.is_finite()) {
                anyhow::bail!("[[linear_constraint]]: `{key}` is {bound:?}, expected a finite number");
            }
        }
        ensure!(
            lower.is_some() || upper.is_some(),
            "[[linear_constraint]] has neither `lower` nor `upper`, expected one of them or both"
        );
        if let Some((lower, upper)) = lower.zip(upper) {
            ensure!(
                lower <= upper,
                "[[linear_constraint]]: `lower` is {}, expected at most `upper`, which is {}",
                plain(lower),
                plain(upper)
            );
        }
        let of = |parameter: &design_space::Parameter| sum.get(parameter.name()).copied().unwrap_or(0.0);
        let coefficients: Vec<f64> = region.parameters().iter().map(of).collect();
        all.extend(lower.map(|lower| LinearConstraint::at_least(&coefficients, lower)));
        all.extend(upper.map(|upper| LinearConstraint::at_most(coefficients.clone(), upper)));
    }
    Ok(all)
}
