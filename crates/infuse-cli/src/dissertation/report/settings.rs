//! The settings of the loop, as rows of the table on where all of it comes from.

use serde::Serialize;

use crate::dissertation::campaign::Campaign;
use crate::number::plain;
use crate::report::provenance::Row;

pub(super) fn rows(campaign: &Campaign) -> Vec<Row> {
    let (problem, settings) = (&campaign.problem, campaign.now.settings());
    let names: Vec<&str> = problem.names().collect();
    let repeats = match settings.replicates {
        0 => String::new(),
        n => format!(", {n} of them repeats"),
    };
    vec![
        ("terms of the surfaces", settings.model.term_names(&names).join(", ")),
        ("experiments per batch", format!("{}{repeats}", settings.n_experiments)),
        ("simulations per batch", settings.n_simulations.to_string()),
        ("batches at most", settings.max_batches.to_string()),
        ("confidence of the test", plain(settings.confidence)),
        ("gain of the correction", as_written(&settings.correction.gain)),
        (
            "weight of an experiment, of a simulation",
            format!("{}, {}", plain(settings.experiment_weight), plain(settings.simulation_weight)),
        ),
        (
            "surfaces of experiments, of simulations, combined",
            [settings.surfaces.experiment, settings.surfaces.simulation, settings.surfaces.combined]
                .map(|kind| as_written(&kind))
                .join(", "),
        ),
        ("without a spread S", as_written(&settings.fallback)),
        ("seed", settings.seed.to_string()),
    ]
}

/// As it stands in files.
fn as_written(setting: &impl Serialize) -> String {
    let written = serde_json::to_value(setting).unwrap_or_default();
    written.as_str().map_or_else(|| written.to_string(), |word| word.replace('_', " "))
}
