//! The exception: with the words of the Rust errors.

use std::fmt::Display;

use pyo3::{PyErr, PyResult};
use serde::de::DeserializeOwned;
use serde_json::Value;

pyo3::create_exception!(
    infuse,
    Error,
    pyo3::exceptions::PyValueError,
    "What was asked for is wrong; the message names the field, the value and what is allowed."
);

/// An error of a Rust library as the exception, in the same words.
pub(crate) fn refusal(error: impl Display) -> PyErr {
    Error::new_err(error.to_string())
}

/// What was expected and found, as Python calls it.
const WORDS: [(&str, &str); 20] = [
    ("invalid type: ", "it is "),
    ("invalid value: ", "it is "),
    ("floating point ", ""),
    ("integer ", ""),
    ("boolean `true`", "`True`"),
    ("boolean `false`", "`False`"),
    ("it is string ", "it is "),
    ("it is null", "it is None"),
    ("it is sequence", "it is a list"),
    ("it is map", "it is a dictionary"),
    ("expected a boolean", "expected True or False"),
    ("expected a sequence", "expected a list"),
    ("expected a map", "expected a dictionary"),
    ("expected usize", "expected a whole number from 0 on"),
    ("expected u64", "expected a whole number from 0 on"),
    ("expected u32", "expected a whole number from 0 on"),
    ("expected u8", "expected a whole number from 0 to 255"),
    ("expected f64", "expected a number"),
    ("expected string or map", "expected a name or a dictionary"),
    ("expected a table, like { combined = ", "expected a dictionary, like { \"combined\": "),
];

/// What does not fit, without words of Rust and JSON.
pub(crate) fn misfit(error: &serde_json::Error) -> String {
    let mut text = error.to_string();
    if let Some(at) = text.find(" at line ") {
        text.truncate(at);
    }
    for (theirs, ours) in WORDS {
        text = text.replace(theirs, ours);
    }
    // "expected struct Rule", "expected internally tagged enum Rule": what is inside is not said.
    for kind in ["expected struct ", "enum "] {
        if let Some((before, _)) = text.split_once(kind) {
            text = format!("{}expected a name or a dictionary", before.trim_end_matches("expected internally tagged "));
        }
    }
    if text.starts_with("data did not match any variant") {
        "it is not one of what is allowed".clone_into(&mut text);
    }
    text
}

/// Settings from a dictionary, of which the entries in `needed` are right; the first one that is not is named.
pub(crate) fn settings_of<T: DeserializeOwned>(settings: Value, needed: &[&str]) -> PyResult<T> {
    let entries = settings.as_object().cloned().unwrap_or_default();
    let error = match serde_json::from_value(settings) {
        Ok(found) => return Ok(found),
        Err(error) => error,
    };
    let is_needed = |name: &str| needed.contains(&name);
    for (name, value) in entries.iter().filter(|(name, _)| !is_needed(name)) {
        let mut few: serde_json::Map<String, Value> = entries
            .iter()
            .filter(|(name, _)| is_needed(name))
            .map(|(name, value)| (name.clone(), value.clone()))
            .collect();
        few.insert(name.clone(), value.clone());
        if let Err(error) = serde_json::from_value::<T>(Value::Object(few)) {
            let text = misfit(&error);
            let is_named = text.starts_with("unknown field");
            return Err(Error::new_err(if is_named { text } else { format!("setting `{name}`: {text}") }));
        }
    }
    Err(Error::new_err(format!("settings: {}", misfit(&error))))
}
