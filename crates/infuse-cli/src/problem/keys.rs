//! Names of settings.

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
