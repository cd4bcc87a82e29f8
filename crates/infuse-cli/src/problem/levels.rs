//! How many levels an instrument's step makes.

use anyhow::{Context as _, Result, bail, ensure};
use design_space::Parameter;

use crate::number::plain;
use crate::problem::file::ParameterEntry;

/// A step must divide the width to this, relative.
const ROUNDING: f64 = 1e-9;

/// The parameter with the levels that its entry asks for.
pub(crate) fn parameter(entry: &ParameterEntry) -> Result<Parameter> {
    let parameter = match &entry.choices {
        Some(choices) => categorical(entry, choices)?,
        None => number(entry)?,
    };
    ensure!(
        !entry.name.contains(['{', '}', '[', ']', '"', '\n', ';', ',', '=']) && entry.name.trim() == entry.name,
        "parameter `{}`: expected a name without braces, brackets, quotes, commas, semicolons, equals signs or spaces at its ends",
        entry.name
    );
    let unit = parameter.unit();
    let is_plain = unit.trim() == unit && !unit.contains(['[', ']', '"', '\n', ';', ',']);
    ensure!(
        is_plain,
        "parameter `{}`: `unit` is {unit:?}, expected one without brackets, quotes, commas, semicolons or spaces at its ends",
        entry.name,
    );
    if let Some(few @ 0..=1) = entry.levels {
        bail!(
            "parameter `{}`: `levels` is {few}, expected at least 2; without `levels` any setting between the bounds is allowed, and \
             what is never changed is left out",
            entry.name
        );
    }
    let count = match (entry.levels, entry.step) {
        (Some(count), None) => count,
        (None, Some(step)) => count(&parameter, step)?,
        (None, None) => return Ok(parameter),
        (Some(_), Some(_)) => bail!("parameter `{}` has both `levels` and `step`, expected one of them", entry.name),
    };
    Ok(parameter.with_levels(count)?)
}

fn number(entry: &ParameterEntry) -> Result<Parameter> {
    let needed = |key: &str| {
        format!("parameter `{}` has no `{key}`, expected one; or `choices` = [...], if it is no number", entry.name)
    };
    let unit = entry.unit.as_ref().with_context(|| needed("unit"))?;
    let lower = entry.lower.with_context(|| needed("lower"))?;
    let upper = entry.upper.with_context(|| needed("upper"))?;
    Ok(Parameter::continuous(&entry.name, unit, lower, upper)?)
}

fn categorical(entry: &ParameterEntry, choices: &[String]) -> Result<Parameter> {
    let of_a_number = [
        ("unit", entry.unit.is_some()),
        ("lower", entry.lower.is_some()),
        ("upper", entry.upper.is_some()),
        ("levels", entry.levels.is_some()),
        ("step", entry.step.is_some()),
    ];
    if let Some((key, _)) = of_a_number.iter().find(|(_, is_set)| *is_set) {
        bail!("parameter `{}` has `{key}` beside `choices`, expected one of them: a choice is no number", entry.name);
    }
    ensure!(
        (2..=1000).contains(&choices.len()),
        "parameter `{}`: `choices` has {}, expected 2 to 1000",
        entry.name,
        choices.len()
    );
    for choice in choices {
        let is_plain = !choice.contains(['{', '}', '[', ']', '"', '\n', ';', ',', '=']);
        ensure!(
            is_plain && choice.parse::<f64>().is_err(),
            "parameter `{}`: the choice {choice:?} is not usable, expected a word that is no number, without braces, brackets, \
             quotes, commas, semicolons or equals signs",
            entry.name
        );
    }
    Ok(Parameter::categorical(&entry.name, choices.iter().cloned())?)
}

fn count(parameter: &Parameter, step: f64) -> Result<u32> {
    let (name, lower, width) = (parameter.name(), parameter.lower(), parameter.width());
    ensure!(
        step > 0.0 && step <= width,
        "parameter `{name}`: `step` is {}, expected a positive number up to {}, the width of its bounds",
        plain(step),
        plain(width)
    );
    let steps = width / step;
    ensure!(
        steps < 1e6,
        "parameter `{name}`: `step` = {} makes {steps:.0} levels, expected at most a million",
        plain(step)
    );
    let whole = steps.round();
    if (steps - whole).abs() > ROUNDING * steps {
        let (below, above) = (lower + steps.floor() * step, lower + steps.ceil() * step);
        bail!(
            "parameter `{name}`: from {} no whole number of steps of {} reaches {}, expected an upper bound of {} or {}",
            plain(lower),
            plain(step),
            plain(parameter.upper()),
            plain(below),
            plain(above),
        );
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between 1 and a million")]
    let count = whole as u32 + 1;
    Ok(count)
}

#[cfg(test)]
mod tests {

    use super::*;

    fn entry(lower: f64, upper: f64, levels: Option<u32>, step: Option<f64>) -> ParameterEntry {
        let (name, unit) = ("pitch".to_owned(), Some("deg".to_owned()));
        let (lower, upper) = (Some(lower), Some(upper));
        ParameterEntry { name, unit, lower, upper, levels, step, choices: None, change_cost: None, role: None }
    }

    #[test]
    fn steps_that_doubles_cannot_hold_still_divide_the_width() {
        // 8 to 9.8 by 0.1: 1.8/0.1 is not 18 in doubles.
        let parameter = parameter(&entry(8.0, 9.8, None, Some(0.1))).expect("19 levels");
        assert_eq!(parameter.levels(), design_space::Levels::Count(19));
        assert_eq!(plain(parameter.level(3).expect("a level")), "8.3");
    }

    #[test]
    fn steps_that_do_not_fit_are_told_which_bounds_would() {
        for (entry, words) in [
            (entry(0.0, 1.0, None, Some(0.3)), "upper bound of 0.9 or 1.2"),
            (entry(0.0, 1.0, None, Some(-0.1)), "`step` is -0.1"),
            (entry(0.0, 1.0, None, Some(f64::NAN)), "`step` is NaN"),
            (entry(0.0, 1.0, None, Some(1e-9)), "at most a million"),
            (entry(0.0, 1.0, Some(3), Some(0.5)), "both"),
            (entry(1.0, 0.0, Some(3), None), "pitch"),
            (entry(0.0, 1.0, Some(1), None), "`levels` is 1, expected at least 2"),
        ] {
            let error = parameter(&entry).expect_err(words).to_string();
            assert!(error.contains(words), "{error}");
        }
    }
}
