//! The property of the proposition is strict: laws with a slip in them fail it.

use infuse::{
    convergence::Bound,
    correction::{Gain, Law, ModelStage, Rule},
};
use proptest::strategy::ValueTree;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};

use super::proposition::{Verdict, cases, law_of_the_crate, verdict};
use super::{Strategy, any_gain};

/// What a law sees in batch n: surfaces from 1 at index n − 1.
struct Seen<'a> {
    gain: Gain,
    n: usize,
    last_correction: f64,
    sum_of_corrections: f64,
    last_model: Option<f64>,
    experiment: &'a [f64],
    simulation: &'a [f64],
}

impl Seen<'_> {
    fn k(&self, n: usize) -> f64 {
        self.gain.as_constant().unwrap_or(1.0 / n as f64)
    }

    fn exp(&self) -> f64 {
        self.experiment[self.n - 1]
    }

    fn sim(&self) -> f64 {
        self.simulation[self.n - 1]
    }

    /// Jnum,n−1 with Jnum,0 = Jsim,1.
    fn model(&self) -> f64 {
        self.last_model.unwrap_or(self.sim())
    }
}

type Mutant = fn(&Seen<'_>) -> f64;

/// The corrected model after all rounds.
fn run(law: Mutant, gain: Gain, experiment: &[f64], simulation: &[f64]) -> f64 {
    let (mut last_correction, mut sum_of_corrections, mut last_model) = (0.0, 0.0, None);
    for n in 1..=experiment.len() {
        let seen = Seen { gain, n, last_correction, sum_of_corrections, last_model, experiment, simulation };
        last_correction = law(&seen);
        sum_of_corrections += last_correction;
        last_model = Some(seen.sim() + last_correction);
    }
    last_model.unwrap_or(simulation[0])
}

/// How often a law holds, leaves the bound of `law` and falls short of it, in 400 cases.
fn count(law: Law, model: impl Fn(Gain, &[f64], &[f64]) -> f64) -> [usize; 3] {
    let config = Config { failure_persistence: None, ..Config::default() };
    let mut runner = TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha));
    let mut counts = [0; 3];
    for _ in 0..400 {
        let (case, gain) = (cases(2..9), any_gain()).new_tree(&mut runner).unwrap().current();
        let bound = Bound::new(Rule::new(law, gain), ModelStage::Corrected);
        let verdict =
            verdict(&bound, &|experiment: &[f64], simulation: &[f64]| model(gain, experiment, simulation), &case);
        let all = [Verdict::Holds, Verdict::LeavesTheBound, Verdict::FallsShortOfIt];
        counts[all.iter().position(|one| *one == verdict).unwrap()] += 1;
    }
    counts
}

#[track_caller]
fn check_fails(name: &str, law: Law, mutant: Mutant) {
    let [holds, leaves, falls_short] =
        count(law, |gain, experiment, simulation| run(mutant, gain, experiment, simulation));
    assert!(leaves + falls_short > 200, "{name}: {holds} hold, {leaves} leave, {falls_short} fall short");
}

const PROOF: Mutant = |s| s.last_correction + s.k(s.n) * (s.exp() - s.model());
const CURRENT: Mutant = |s| s.last_correction + s.k(s.n) * (s.exp() - s.sim() - s.last_correction);
const PRINTED: Mutant = |s| s.k(s.n) * (s.exp() - s.sim()) + s.sum_of_corrections;

#[test]
fn laws_without_a_slip_hold_in_every_case() {
    for (law, definition) in
        [(Law::ProofRecursion, PROOF), (Law::CurrentSimulation, CURRENT), (Law::AsPrinted36, PRINTED)]
    {
        let defined = count(law, |gain, experiment, simulation| run(definition, gain, experiment, simulation));
        assert_eq!(defined, [400, 0, 0], "{law:?} as defined");
        let built = count(law, |gain, experiment, simulation| {
            law_of_the_crate(Rule::new(law, gain), ModelStage::Corrected)(experiment, simulation)
        });
        assert_eq!(built, [400, 0, 0], "{law:?} as built");
    }
}

#[test]
fn proof_recursion_with_a_slip_fails() {
    let law = Law::ProofRecursion;
    let check = |name: &str, mutant: Mutant| check_fails(name, law, mutant);
    check("sign of the difference", |s| s.last_correction - s.k(s.n) * (s.exp() - s.model()));
    check("last correction forgotten", |s| s.k(s.n) * (s.exp() - s.model()));
    check("1 - k missing: a sum of increments", |s| {
        s.last_correction + s.k(s.n) * (s.exp() - s.simulation[s.n.max(2) - 2])
    });
    check("1 - k twice", |s| (1.0 - s.k(s.n)) * s.last_correction + s.k(s.n) * (s.exp() - s.model()));
    check("experiment of the batch before", |s| {
        s.last_correction + s.k(s.n) * (s.experiment[s.n.max(2) - 2] - s.model())
    });
    check("simulation of this batch", CURRENT);
    check("simulation of two batches ago", |s| {
        let old = s.simulation[s.n.max(3) - 3] + if s.n == 1 { 0.0 } else { s.last_correction };
        s.last_correction + s.k(s.n) * (s.exp() - old)
    });
    check("Jnum,0 = 0", |s| s.last_correction + s.k(s.n) * (s.exp() - s.last_model.unwrap_or(0.0)));
    check("Jnum,0 = Jexp,1", |s| s.last_correction + s.k(s.n) * (s.exp() - s.last_model.unwrap_or(s.exp())));
    check("first correction with full gain", |s| {
        s.last_correction + if s.n == 1 { 1.0 } else { s.k(s.n) } * (s.exp() - s.model())
    });
    check("(36) as printed", PRINTED);
}

#[test]
fn current_simulation_with_a_slip_fails() {
    let law = Law::CurrentSimulation;
    let check = |name: &str, mutant: Mutant| check_fails(name, law, mutant);
    check("sign of the difference", |s| s.last_correction - s.k(s.n) * (s.exp() - s.sim() - s.last_correction));
    check("sign of the last correction", |s| s.last_correction + s.k(s.n) * (s.exp() - s.sim() + s.last_correction));
    check("1 - k missing: a sum of increments", |s| s.last_correction + s.k(s.n) * (s.exp() - s.sim()));
    check("last correction forgotten", |s| s.k(s.n) * (s.exp() - s.sim()));
    check("experiment of the batch before", |s| {
        s.last_correction + s.k(s.n) * (s.experiment[s.n.max(2) - 2] - s.sim() - s.last_correction)
    });
    check("simulation of the batch before", PROOF);
    check("(36) as printed", PRINTED);
}
