//! How many batches a gain needs, what is left in the end, and what that certifies: Section 6.1.

use infuse::{
    Error,
    convergence::{Bound, ErrorLevels, Norm, RegretCertificate},
    correction::{Field, Gain, Law, ModelStage, Rule},
};

/// Bounds on the errors of the fitted surfaces, in the unit of the cost.
const SIMULATION_ERROR: f64 = 0.05;
const EXPERIMENT_ERROR: f64 = 0.10;

#[expect(clippy::print_stdout, reason = "an example shows what it computes")]
fn main() -> Result<(), Error> {
    // Surfaces of the first batch at five designs: their distance bounds the unknown gap.
    let experiment = [6.9, 6.1, 5.8, 6.0, 6.7];
    let simulation = [4.9, 4.4, 4.4, 4.9, 5.9];
    let difference: Vec<f64> = experiment.iter().zip(&simulation).map(|(exp, sim)| exp - sim).collect();
    let gap = Norm::SUP.over(&difference, &[1.0; 5])? + SIMULATION_ERROR + EXPERIMENT_ERROR;
    let levels = ErrorLevels::new(gap, SIMULATION_ERROR, EXPERIMENT_ERROR)?;

    println!("gap at most {gap:.2}; limit of the error, and batches to within 0.05 of it");
    let laws = [("proof", Law::ProofRecursion), ("current", Law::CurrentSimulation)];
    let gains = [0.1, 0.3, 0.5, 0.8, 1.0].map(|k| (k.to_string(), Gain::constant(k)));
    for (name, gain) in gains.into_iter().chain([("1/n".to_owned(), Ok(Gain::harmonic()))]) {
        let mut line = format!("gain {name:<4}");
        for (law_name, law) in laws {
            let bound = Bound::new(Rule::new(law, gain.clone()?), ModelStage::Corrected);
            let batches = bound.batches_to(&levels, 0.05)?.map_or("never".to_owned(), |n| format!("{n:>2}"));
            let limit = bound.limit().map_or(f64::INFINITY, |limit| limit.error(&levels));
            line += &format!("   {law_name}: {limit:.2} in {batches}");
        }
        println!("{line}");
    }

    // Four rounds in which the surfaces happen to stay the same.
    let rule = Rule::new(Law::CurrentSimulation, Gain::constant(0.8)?);
    let mut field = Field::new(rule, 5)?;
    for _ in 0..4 {
        field.update(&experiment, &simulation)?;
        let eps = Bound::new(rule, ModelStage::Corrected).after(field.n_batches()).error(&levels);
        let certificate = RegretCertificate::of_cell(2, field.model().unwrap_or_default(), eps)?;
        println!(
            "round {}: model within {eps:.3}, design 2 within {:.3} of the best",
            field.n_batches(),
            certificate.regret
        );
    }
    Ok(())
}
