//! Names of settings.

use serde_json::Value;

/// What a setting of a loop is called in the file.
pub(crate) fn key_of(name: &str) -> &str {
    match name {
        "n_experiments" => "experiments",
        "n_simulations" => "simulations",
        "max_batches" => "batches",
        "first_screening" => "drop_from",
        "fallback" => "without_spread",
        name => name,
    }
}

/// Settings of a loop under the names of the file.
pub(crate) fn by_key(settings: &Value) -> Value {
    let Value::Object(settings) = settings else { return settings.clone() };
    settings.iter().map(|(name, value)| (key_of(name).to_owned(), value.clone())).collect()
}
