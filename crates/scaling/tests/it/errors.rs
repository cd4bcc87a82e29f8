//! What a person in the laboratory reads when something is wrong.

use scaling::{Error, SetUp, Similarity, System, Units, Variable};

use crate::{TABLE_1, system};

#[track_caller]
fn check<T: std::fmt::Debug>(result: Result<T, Error>, expected: &str) {
    assert_eq!(result.unwrap_err().to_string(), expected);
}

#[test]
fn dependent_repeating_variables_are_named_with_their_relation() {
    check(
        system(&TABLE_1).groups(&["L_t", "g", "V"]),
        "the repeating variables are not independent: V depends on L_t and g: V^2/(L_t*g) is dimensionless",
    );
    check(
        system(&TABLE_1).groups(&["L_t", "M_a", "V", "rho"]),
        "the repeating variables are not independent: rho depends on L_t and M_a: L_t^3*rho/M_a is dimensionless",
    );
    check(
        system(&TABLE_1).groups(&["L_t", "L_c"]),
        "the repeating variables are not independent: L_c depends on L_t: L_c/L_t is dimensionless",
    );
}

#[test]
fn insufficient_repeating_variables_name_what_would_help() {
    check(
        system(&TABLE_1).groups(&["L_t", "V"]),
        "the repeating variables L_t and V do not span the dimension of M_a (M): add one of M_a, rho, lambda",
    );
    check(
        system(&[("l", "m"), ("m", "kg")]).groups(&["l"]),
        "the repeating variables l do not span the dimension of m (M): \
         add m (no other variable of the system helps) or leave it out",
    );
}

#[test]
fn bad_repeating_variables_are_named() {
    let system = system(&[("L_t", "m"), ("V", "m/s"), ("T", "s"), ("alpha", "rad")]);
    check(system.groups(&["L_t", "v"]), "there is no variable `v`; did you mean `V`?");
    check(system.groups(&["L_t", "Lt"]), "there is no variable `Lt`; did you mean `L_t`?");
    check(system.groups(&["L_t", "L_t"]), "`L_t` is given twice as a repeating variable");
    check(
        system.groups(&["L_t", "alpha"]),
        "`alpha` is dimensionless and cannot be a repeating variable: it is a group of its own",
    );
}

#[test]
fn bad_systems_are_refused() {
    let units = Units::si();
    check(System::new(vec![]), "there are no variables");
    check(System::parse(&units, &[("a", "m"), ("a", "s")]), "`a` is given twice as a variable");
    check(System::parse(&units, &[("a", "m"), ("b", "x")]), "b: \"x\", character 1: unknown unit `x`");
    for name in ["", "2a", "a b", "a*b", "a/b", "a^2", "a^", "(a)", "a^b^3"] {
        let variable = Variable { name: name.into(), dimension: scaling::Dimension::one() };
        assert!(matches!(System::new(vec![variable]), Err(Error::BadName { .. })), "{name}");
    }
}

#[test]
fn bad_groups_are_refused() {
    let system = system(&TABLE_1);
    check(system.group("L_t^3*roh/M_a"), "\"L_t^3*roh/M_a\", character 7: unknown variable `roh`; did you mean `rho`?");
    check(
        system.group("2*L_t/L_c"),
        "\"2*L_t/L_c\" contains the number 2, but only 1 and symbols with exponents are allowed here",
    );
    check(system.group("L_t/(L_c"), "\"L_t/(L_c\", character 9: found the end, expected `)`");
}

#[test]
fn bad_comparisons_are_refused() {
    let units = Units::si();
    let system = system(&[("a", "m"), ("b", "m")]);
    let groups = system.groups(&["a"]).unwrap();
    let one = SetUp::new("one").with("a", 1.0).with("b", 1.0);
    let two = SetUp::new("two").with("a", 1.0).with("b", 1.0);
    check(
        Similarity::check(&groups, std::slice::from_ref(&one), 0.1),
        "1 set-up(s) given, but similarity needs at least 2",
    );
    check(Similarity::check(&groups, &[one.clone(), one.clone()], 0.1), "`one` is given twice as a set-up");
    check(
        Similarity::check(&groups, &[one.clone(), two.clone()], -1.0),
        "the tolerance is -1.0, but must be finite and at least 0",
    );
    check(Similarity::check(&groups, &[one.clone(), two.clone().with("c", 1.0)], 0.1), "there is no variable `c`");
    check(
        Similarity::check(&groups, &[one.clone(), two.with_unit(&units, "a", 1.0, "cm/s").unwrap()], 0.1),
        "set-up \"two\": a is given in cm/s (L/T), but has the dimension L",
    );
    check(
        one.clone().printed(&units, "a", "2,5", "cm"),
        "set-up \"one\", a: the value is \"2,5\", expected a finite number or a list of them",
    );
    check(
        one.printed(&units, "a", "inf", "cm"),
        "set-up \"one\", a: the value is \"inf\", expected a finite number or a list of them",
    );
}
