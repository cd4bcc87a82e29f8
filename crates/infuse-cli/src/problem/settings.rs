//! The settings of each method, from the file and what follows from it.

use anyhow::{Context as _, Result, anyhow, bail, ensure};
use design_space::{Levels, Model, Region, Term};
use infuse::{
    Error,
    correction::{Gain, Law, Rule},
    global, pooled,
};

use super::file::{LoopEntry, ModelEntry, SimulationsEntry};
use super::keys::key_of;
use super::{Costs, Problem, Response, Scale, Simulator};

impl Problem {
    /// The settings of the dissertation's loop.
    pub(crate) fn dissertation_settings(&self, careful: bool) -> Result<global::Settings> {
        let of_the_pooled_loop = [
            ("constraint", !self.constraints.is_empty()),
            ("linear_constraint", !self.linear_constraints.is_empty()),
            ("can_be_built", self.can_be_built.is_some()),
            ("change_cost", self.costs.is_some()),
            ("experiment_cost", self.rule.experiment_cost.is_some()),
            ("cost_unit", self.rule.cost_unit.is_some()),
            ("blocks", self.rule.blocks.is_some()),
            ("by", self.stop_by.is_some()),
            ("smooth", self.smooth.is_some()),
            ("scale", !self.response.scale.is_linear()),
        ];
        ensure!(
            self.simulator.is_there(),
            "no [simulator], which `method` = \"dissertation\" corrects by experiments; expected one, or `method` = \"pooled\""
        );
        if let Some((key, _)) = of_the_pooled_loop.iter().find(|(_, is_set)| *is_set) {
            bail!("`{key}` belongs to `method` = \"pooled\", expected none with `method` = \"dissertation\"");
        }
        if let Some(choice) = self.region.parameters().iter().find(|parameter| parameter.choices().is_some()) {
            bail!(
                "parameter `{}` has `choices`, which `method` = \"dissertation\" cannot use, expected numbers",
                choice.name()
            );
        }
        let mut settings = dissertation(&self.rule, &self.region, self.seed).context("[loop]")?;
        settings.careful = careful;
        Ok(settings)
    }

    /// The settings of the pooled loop, and the keys of the file that mean nothing to it.
    pub(crate) fn pooled_settings(&self) -> Result<(pooled::Settings, Vec<&'static str>)> {
        let settings = pooled_loop(self).map_err(by_its_name_in_the_file).context("[loop]")?;
        Ok((settings, of_the_other_method(&self.rule)))
    }
}

/// Simulations per batch, if not said: that many per parameter.
const SIMULATIONS_PER_PARAMETER: usize = 15;

fn pooled_loop(problem: &Problem) -> Result<pooled::Settings, Error> {
    let (entry, k) = (&problem.rule, problem.region.n_parameters());
    let mut settings = pooled::Settings::new(entry.experiments.unwrap_or(4 + 2 * k));
    settings.simulations = match (&problem.simulator, &entry.simulations) {
        // To look up costs nothing.
        (Simulator::Nothing | Simulator::Table(_), _) => None,
        (Simulator::Program { .. }, Some(SimulationsEntry::Count(count))) => Some(*count),
        (Simulator::Program { .. }, None) => Some(SIMULATIONS_PER_PARAMETER * k),
        (Simulator::Program { .. }, Some(SimulationsEntry::Named(_))) => None,
    };
    settings.max_batches = entry.batches.unwrap_or(settings.max_batches);
    settings.confidence = entry.confidence.unwrap_or(settings.confidence);
    settings.noise = entry.noise.map(|noise| noise_of_costs(&problem.response, noise)).transpose()?;
    settings.blocks = entry.blocks;
    settings.displaced = entry.displaced.unwrap_or(settings.displaced);
    settings.worth = problem.worth.map(|worth| problem.response.difference(worth));
    settings.stop_by = problem.stop_by.unwrap_or_default();
    settings.smooth = problem.smooth.unwrap_or(false);
    settings.least = problem.response.least();
    settings.constraints = problem.constraints.iter().map(|held| held.constraint.clone()).collect();
    settings.plants = problem.costs.as_ref().map(Costs::plants);
    settings.linear_constraints.clone_from(&problem.linear_constraints);
    settings.seed = problem.seed;
    settings.validate(&problem.region)?;
    Ok(settings)
}

/// The noise of the cost: of a logarithm the file has a factor.
fn noise_of_costs(response: &Response, given: f64) -> Result<f64, Error> {
    let is_no_factor = response.scale == Scale::Log && (given.is_nan() || given <= 1.0);
    match is_no_factor {
        true => Err(Error::Setting {
            name: "noise",
            value: given,
            expected: "a factor above 1, as 1.05 for 5 %, where `scale` of [response] is \"log\"",
        }),
        false => Ok(response.difference(given)),
    }
}

/// Keys of the dissertation's loop that are set.
fn of_the_other_method(entry: &LoopEntry) -> Vec<&'static str> {
    let keys = [
        ("model", entry.model.is_some()),
        ("replicates", entry.replicates.is_some()),
        ("drop_from", entry.drop_from.is_some()),
        ("gain", entry.gain.is_some()),
        ("experiment_weight", entry.experiment_weight.is_some()),
        ("simulation_weight", entry.simulation_weight.is_some()),
        ("surfaces", entry.surfaces.is_some()),
        ("without_spread", entry.without_spread.is_some()),
    ];
    keys.into_iter().filter(|(_, is_set)| *is_set).map(|(key, _)| key).collect()
}

fn dissertation(entry: &LoopEntry, region: &Region, seed: u64) -> Result<global::Settings> {
    ensure!(entry.noise.is_none(), "`noise` belongs to `method` = \"pooled\", expected repeats (`replicates`) instead");
    ensure!(entry.displaced.is_none(), "`displaced` belongs to `method` = \"pooled\", expected no such key");
    if let Some(parameter) = region.parameters().iter().find(|parameter| parameter.levels() == Levels::Continuous) {
        bail!(
            "parameter `{}` needs `levels` = how many, or `step` = how finely it can be set, with `method` = \"dissertation\"",
            parameter.name()
        );
    }
    let model = model(entry.model.as_ref(), region)?;
    let n_terms = model.n_terms();
    let replicates = entry.replicates.unwrap_or(0);
    let experiments =
        entry.experiments.unwrap_or_else(|| (n_terms + n_terms.div_ceil(5)).max(n_terms + 2).max(4) + replicates);
    let simulations = match &entry.simulations {
        None => 2 * experiments,
        Some(SimulationsEntry::Count(count)) => *count,
        Some(SimulationsEntry::Named(_)) => {
            bail!("`simulations` is \"all\", expected a number per batch with `method` = \"dissertation\"")
        }
    };
    let mut settings = global::Settings::new(model, experiments, simulations);
    settings.replicates = replicates;
    settings.seed = seed;
    settings.max_batches = entry.batches.unwrap_or(settings.max_batches);
    settings.confidence = entry.confidence.unwrap_or(settings.confidence);
    // The surface of the first batch still rests on simulations that nothing has corrected.
    settings.first_screening = entry.drop_from.unwrap_or(2);
    settings.experiment_weight = entry.experiment_weight.unwrap_or(settings.experiment_weight);
    settings.simulation_weight = entry.simulation_weight.unwrap_or(settings.simulation_weight);
    settings.surfaces = entry.surfaces.unwrap_or_default();
    settings.fallback = entry.without_spread.unwrap_or_default();
    // The harmonic gain forgets the gap at once and averages the noise of all batches.
    let gain = entry.gain.unwrap_or_else(Gain::harmonic);
    settings.correction = Rule::new(Law::ProofRecursion, gain);
    settings.validate(region).map_err(by_its_name_in_the_file)?;
    Ok(settings)
}

/// The fault of a setting under the name that this has in the file.
fn by_its_name_in_the_file(error: Error) -> Error {
    match error {
        Error::Setting { name, value, expected } => Error::Setting { name: key_of(name), value, expected },
        Error::SettingCount { name, value, expected } => Error::SettingCount { name: key_of(name), value, expected },
        other => other,
    }
}

fn model(entry: Option<&ModelEntry>, region: &Region) -> Result<Model> {
    let k = region.n_parameters();
    Ok(match entry {
        None => Model::quadratic(k)?,
        Some(ModelEntry::Named(name)) => {
            Model::named(name, k).map_err(|error| anyhow!("`model` is {name:?}: {error}, or a list of terms"))?
        }
        Some(ModelEntry::Listed(terms)) => {
            let mut exponents = Vec::new();
            for (number, term) in terms.iter().enumerate() {
                if let Some(name) = term.keys().find(|name| region.index_of(name).is_none()) {
                    bail!("`model`, term {}: no parameter is called `{name}`", number + 1);
                }
                let exponent = |parameter: &design_space::Parameter| term.get(parameter.name()).copied().unwrap_or(0);
                exponents.push(Term::new(region.parameters().iter().map(exponent).collect::<Vec<u8>>()));
            }
            Model::new(k, exponents)?
        }
    })
}
