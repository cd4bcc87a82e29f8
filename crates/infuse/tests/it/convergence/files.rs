//! What of it stands in files.

use infuse::{
    convergence::{Norm, NormOrder, NormScaling},
    correction::{Gain, Law, ModelStage, Rule},
};
use serde::Serialize;
use serde::de::DeserializeOwned;

#[track_caller]
fn check<T: Serialize + DeserializeOwned + PartialEq + std::fmt::Debug>(value: T, text: &str) {
    assert_eq!(serde_json::to_string(&value).unwrap(), text);
    assert_eq!(serde_json::from_str::<T>(text).unwrap(), value);
}

#[test]
fn rules_and_norms_are_written_in_words_and_read_again() {
    check(Gain::harmonic(), r#""harmonic""#);
    check(ModelStage::Onset, r#""onset""#);
    let gain = Gain::constant(0.4).unwrap();
    for (law, name) in [
        (Law::ProofRecursion, "proof_recursion"),
        (Law::CurrentSimulation, "current_simulation"),
        (Law::AsPrinted36, "as_printed_36"),
    ] {
        check(Rule::new(law, gain), &format!(r#"{{"law":"{name}","gain":{{"constant":0.4}}}}"#));
    }
    check(Norm::SUP, r#"{"order":"infinity","scaling":"integral"}"#);
    let mean = Norm { order: NormOrder::finite(2.0).unwrap(), scaling: NormScaling::Mean };
    check(mean, r#"{"order":{"finite":2.0},"scaling":"mean"}"#);
}

#[test]
fn the_law_of_the_proof_is_the_default_and_the_gain_has_none() {
    let rule: Rule = serde_json::from_str(r#"{"gain":"harmonic"}"#).unwrap();
    assert_eq!(rule.law, Law::ProofRecursion);
    assert!(serde_json::from_str::<Rule>(r#"{"law":"proof_recursion"}"#).is_err(), "a gain is chosen");
}

#[test]
fn files_cannot_hold_what_constructors_refuse() {
    let gain = serde_json::from_str::<Gain>(r#"{"constant":2.5}"#).unwrap_err().to_string();
    assert!(gain.starts_with("setting `gain` is 2.5, expected 0 < k < 2"), "{gain}");
    let order = serde_json::from_str::<NormOrder>(r#"{"finite":0.5}"#).unwrap_err().to_string();
    assert!(order.starts_with("setting `order` is 0.5, expected a finite q of at least 1"), "{order}");
    assert!(serde_json::from_str::<Rule>(r#"{"gain":"harmonic","trust":1.0}"#).is_err(), "an unknown key");
}
