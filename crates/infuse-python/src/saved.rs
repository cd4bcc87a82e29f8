//! What files of campaigns have in common.

use pyo3::prelude::*;
use serde_json::Value;

use crate::error::{Error, refusal};

/// The JSON of a saved campaign, if it is of this kind and format.
pub(crate) fn saved_as(kind: &str, format: u32, text: &str) -> PyResult<Value> {
    let saved: Value = serde_json::from_str(text).map_err(refusal)?;
    if saved["kind"] == kind && saved["format"] == format {
        return Ok(saved);
    }
    let (found, of) = (&saved["kind"], &saved["format"]);
    Err(Error::new_err(format!("a campaign of kind {found} and format {of}, expected \"{kind}\" and {format}")))
}
