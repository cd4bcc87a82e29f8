//! The correction laws of the dissertation's loop, their bounds and what follows from them.

mod assumption;
mod bound;
mod certificate;
mod files;
mod golden;
mod laws;
mod mutants;
mod norm;
mod proposition;

use infuse::correction::{Field, Gain, Law, ModelStage, Rule};
use proptest::prelude::*;

const LAWS: [Law; 3] = [Law::ProofRecursion, Law::CurrentSimulation, Law::AsPrinted36];
const STAGES: [ModelStage; 2] = [ModelStage::Onset, ModelStage::Corrected];

fn rule(law: Law, k: f64) -> Rule {
    Rule::new(law, Gain::constant(k).unwrap())
}

fn any_gain() -> impl Strategy<Value = Gain> {
    prop_oneof![
        4 => (0.01..1.0).prop_map(|k| Gain::constant(k).unwrap()),
        1 => Just(Gain::constant(1.0).unwrap()),
        2 => (1.0..1.95).prop_map(|k| Gain::constant(k).unwrap()),
        1 => Just(Gain::harmonic()),
    ]
}

fn converging_law() -> impl Strategy<Value = Law> {
    prop::sample::select(&LAWS[..2])
}

fn any_stage() -> impl Strategy<Value = ModelStage> {
    prop::sample::select(&STAGES[..])
}

/// The model of a stage after n rounds, from n rows of experiments and n + 1 rows of simulations, by
/// the recursion over cells.
fn by_recursion(rule: Rule, stage: ModelStage, experiment: &[Vec<f64>], simulation: &[Vec<f64>]) -> Vec<f64> {
    let mut field = Field::new(rule, simulation[0].len()).unwrap();
    for (experiment, simulation) in experiment.iter().zip(simulation) {
        field.update(experiment, simulation).unwrap();
    }
    match (stage, field.model()) {
        (ModelStage::Corrected, Some(model)) => model.to_vec(),
        (ModelStage::Corrected, None) | (ModelStage::Onset, _) => {
            field.onset_model(&simulation[experiment.len()]).unwrap()
        }
    }
}
