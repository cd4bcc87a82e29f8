//! Systems, groups, set-ups and results in files.

use ::serde::{Serialize, de::DeserializeOwned};
use scaling::{Dimension, Factor, Group, Groups, Rule, ScalingLaw, SetUp, Similarity, System, Unit, Units};

use crate::{TABLE_1, system};

#[track_caller]
fn returns<T: Serialize + DeserializeOwned + PartialEq + std::fmt::Debug>(value: &T) -> String {
    let text = serde_json::to_string(value).unwrap();
    assert_eq!(serde_json::from_str::<T>(&text).unwrap(), *value, "{text}");
    text
}

#[test]
fn everything_worth_keeping_returns_from_json() {
    let system = system(&TABLE_1);
    returns::<System>(&system);
    let groups = system.groups(&["L_t", "M_a", "V"]).unwrap();
    returns::<Groups>(&groups);
    let set_up = |name: &str| TABLE_1.iter().fold(SetUp::new(name), |s, (v, _)| s.with(*v, 0.1));
    returns::<SetUp>(&set_up("one").printed(&Units::si(), "V", "26", "cm/s").unwrap());
    returns::<Similarity>(&Similarity::check(&groups, &[set_up("one"), set_up("two")], 0.01).unwrap());
    returns::<Unit>(&Units::si().parse("deg/cm").unwrap());
    let law = system.law(&[("L_t", "3"), ("rho", "1"), ("g", "1")]).unwrap();
    returns::<Rule>(&law.rule("V").unwrap());
    let text = serde_json::to_string(&law).unwrap();
    let again: ScalingLaw = serde_json::from_str(&text).unwrap();
    assert_eq!(again.system(), law.system(), "{text}");
    assert!(again.given().eq(law.given()), "{text}");
    assert!(again.rules().eq(law.rules()), "{text}");
}

#[test]
fn a_law_is_checked_when_it_is_read() {
    let law = system(&TABLE_1).law(&[("L_t", "3"), ("rho", "1"), ("g", "1")]).unwrap();
    let text = serde_json::to_string(&law).unwrap();
    let refused = |from: &str, to: &str| {
        assert!(text.contains(from), "{from} in {text}");
        serde_json::from_str::<ScalingLaw>(&text.replacen(from, to, 1)).unwrap_err().to_string()
    };
    assert!(refused(r#",["g","1"]"#, "").contains("do not determine"), "a ratio is missing");
    assert!(refused(r#"["g","1"]"#, r#"["g","1"],["V","1"]"#).contains("contradict each other"), "one too many");
    assert!(refused(r#"["g","1"]"#, r#"["g","0"]"#).contains("must be positive"), "no ratio");
}

/// A row with too few values would be read beyond its end.
#[test]
fn a_comparison_is_checked_when_it_is_read() {
    let groups = system(&TABLE_1).groups(&["L_t", "M_a", "V"]).unwrap();
    let set_up = |name: &str| TABLE_1.iter().fold(SetUp::new(name), |s, (v, _)| s.with(*v, 0.1));
    let text =
        serde_json::to_string(&Similarity::check(&groups, &[set_up("one"), set_up("two")], 0.01).unwrap()).unwrap();
    let refused = |from: &str, to: &str| {
        assert!(text.contains(from), "{from} in {text}");
        serde_json::from_str::<Similarity>(&text.replacen(from, to, 1)).unwrap_err().to_string()
    };
    let row = r#""values":["#;
    let first = &groups.iter().next().unwrap().to_string();
    assert_eq!(
        refused(row, r#""values":[0.5,"#).split(" at line").next(),
        Some(&*format!("{first} has 3 values, expected 2, one per set-up"))
    );
    assert!(refused(r#""name":"two""#, r#""name":"one""#).contains("`one` is given twice as a set-up"), "{text}");
    assert!(refused(r#""tolerance":0.01"#, r#""tolerance":-1.0"#).contains("the tolerance is -1.0"), "{text}");
    assert!(refused(r#""unit":null"#, r#""unit":null,"unitt":null"#).contains("unknown field `unitt`"), "{text}");
}

#[test]
fn files_are_readable() {
    assert_eq!(returns(&"M*L/T^2".parse::<Dimension>().unwrap()), "\"M*L/T^2\"");
    assert_eq!(returns(&"100^(1/3)".parse::<Factor>().unwrap()), "\"10^(2/3)\"");
    let group = system(&TABLE_1).group("L_t^3*rho/M_a").unwrap();
    assert_eq!(returns(&group), r#"[["L_t","3"],["M_a","-1"],["rho","1"]]"#);
}

#[test]
fn broken_files_are_refused() {
    let refused = |text: &str| serde_json::from_str::<System>(text).unwrap_err().to_string();
    assert!(refused("[]").contains("there are no variables"));
    let twice = r#"[{"name":"a","dimension":"L"},{"name":"a","dimension":"T"}]"#;
    assert!(refused(twice).contains("`a` is given twice as a variable"));
    assert!(refused(r#"[{"name":"a","dimension":"L^^"}]"#).contains("character 3"));
    assert!(serde_json::from_str::<Factor>("\"-1\"").is_err());
    assert!(serde_json::from_str::<Group>(r#"[["a","x"]]"#).is_err());
    assert!(serde_json::from_str::<Group>(r#"[["a","1/0"]]"#).is_err());
}

#[test]
fn groups_are_checked_when_they_are_read() {
    let refused = |text: &str| serde_json::from_str::<Group>(text).unwrap_err().to_string();
    assert_eq!(refused(r#"[["a","1"],["a","0"]]"#), "`a` is given twice as a factor of the group");
    assert_eq!(
        refused(r#"[["a","1"],["b","0/7"]]"#),
        "the exponent of `b` is 0/7, expected a whole number or a fraction, other than 0"
    );
    assert_eq!(refused(r#"[["a b","1"]]"#).split(':').next(), Some("`a b` cannot be a name"));
    assert_eq!(serde_json::from_str::<Group>("[]").unwrap().to_string(), "1", "what it is to the power 0");
}

/// A file of groups with something else in place of a part of it.
#[test]
fn lists_of_groups_are_those_of_their_system() {
    let groups = system(&TABLE_1).groups(&["L_t", "M_a", "V"]).unwrap();
    for groups in [groups.clone(), groups.clone().oriented(scaling::Orientation::Below)] {
        returns::<Groups>(&groups);
    }
    let text = serde_json::to_string(&groups).unwrap();
    let refused = |from: &str, to: &str| {
        assert!(text.contains(from), "{from} in {text}");
        serde_json::from_str::<Groups>(&text.replacen(from, to, 1)).unwrap_err().to_string()
    };
    let repeating = r#""repeating":["L_t","M_a","V"]"#;
    assert!(refused(repeating, r#""repeating":["L_t","M_a","W"]"#).contains("there is no variable `W`"));
    assert!(refused(repeating, r#""repeating":["L_t","M_a"]"#).contains("do not span the dimension"));
    let density = r#"[["L_t","3"],["M_a","-1"],["rho","1"]]"#;
    let other = refused(density, r#"[["L_t","2"],["M_a","-1"],["rho","1"]]"#);
    assert!(other.contains("L_t^2*rho/M_a, ") && other.contains(", L_t^3*rho/M_a, "), "{other}");
    assert!(other.ends_with("as L_t, M_a and V give them"), "{other}");
    assert!(refused(&format!(",{density}"), "").starts_with("the groups are "), "one is missing");
}
