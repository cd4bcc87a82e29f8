//! Systems, groups, set-ups and results in files.

use ::serde::{Serialize, de::DeserializeOwned};
use scaling::{Dimension, Factor, Groups, Rule, SetUp, Similarity, System, Unit, Units};

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
    assert!(serde_json::from_str::<scaling::Group>(r#"[["a","x"]]"#).is_err());
    assert!(serde_json::from_str::<scaling::Group>(r#"[["a","1/0"]]"#).is_err());
}
