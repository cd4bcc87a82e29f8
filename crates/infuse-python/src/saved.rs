//! What files of campaigns have in common.

use pyo3::prelude::*;
use serde_json::Value;

use serde::de::DeserializeOwned;

use crate::error::{Error, misfit};

/// The JSON of a saved campaign, if it is of this kind and format.
pub(crate) fn saved_as(kind: &str, format: u32, text: &str) -> PyResult<Value> {
    let saved: Value = serde_json::from_str(text).map_err(|error| {
        let (line, column) = (error.line(), error.column());
        let what = if error.is_eof() { "it ends too early" } else { "it is damaged" };
        Error::new_err(format!("{what}, in line {line} at character {column}, expected a campaign as `save` writes it"))
    })?;
    if saved["kind"] == kind && saved["format"] == format {
        return Ok(saved);
    }
    let (found, of) = (&saved["kind"], &saved["format"]);
    if found.is_null() || of.is_null() {
        return Err(Error::new_err("it names no kind or no format, expected a campaign as `save` writes it"));
    }
    Err(Error::new_err(format!("a campaign of kind {found} and format {of}, expected \"{kind}\" and {format}")))
}

/// What a saved campaign holds.
pub(crate) fn unpacked<T: DeserializeOwned>(saved: Value) -> PyResult<T> {
    serde_json::from_value(saved).map_err(|error| {
        Error::new_err(format!("a saved campaign that was changed by hand or is damaged: {}", misfit(&error)))
    })
}
