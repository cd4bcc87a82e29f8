//! A setting as it is written and read: a number, or the name of a choice.

use design_space::{Levels, Parameter};
use serde_json::{Value, json};

use crate::number::{parse, plain, rounded, setting};
use crate::wording::place_in_any_case;

/// With all its digits, as sheets and programs get it.
pub(crate) fn written(parameter: &Parameter, value: f64) -> String {
    parameter.choice(value).map_or_else(|| plain(value), str::to_owned)
}

/// For people to read.
pub(crate) fn shown(parameter: &Parameter, value: f64) -> String {
    parameter.choice(value).map_or_else(|| setting(value, step(parameter)), str::to_owned)
}

/// For programs.
pub(crate) fn said(parameter: &Parameter, value: f64) -> Value {
    parameter.choice(value).map_or_else(|| json!(rounded(value)), |choice| json!(choice))
}

/// What [`written`] wrote, a choice in any case, or what is wrong with it.
pub(crate) fn parse_setting(parameter: &Parameter, text: &str) -> Result<f64, String> {
    match parameter.choices() {
        None => parse(text).map_err(|fault| fault.to_string()),
        Some(choices) => {
            let named: Vec<String> = choices.iter().map(|choice| format!("`{choice}`")).collect();
            let place = place_in_any_case(choices.iter().map(String::as_str), text);
            place.map(|place| place as f64).ok_or_else(|| format!("one of {}", named.join(", ")))
        }
    }
}

/// The distance between neighboring levels; 0 without levels.
pub(crate) fn step(parameter: &Parameter) -> f64 {
    match parameter.levels() {
        Levels::Count(count) => parameter.width() / f64::from(count.saturating_sub(1).max(1)),
        Levels::Continuous => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_choice_is_known_in_any_case_unless_two_differ_in_case_alone() {
        let of = |choices: &[&str]| Parameter::categorical("kind", choices.iter().map(ToString::to_string)).unwrap();
        assert_eq!(parse_setting(&of(&["foam", "Film"]), "FILM"), Ok(1.0));
        assert_eq!(parse_setting(&of(&["Film", "film"]), "film"), Ok(1.0));
        let error = parse_setting(&of(&["Film", "film"]), "FILM");
        assert_eq!(error, Err("one of `Film`, `film`".to_owned()));
    }
}
