//! Scaling laws that follow from the system.

use scaling::{Dimension, Error, Factor, ScalingLaw};

use crate::{CONTROLLER, TABLE_1, ratio, system};

/// Plant and controller together, scaled by length, density and gravity: from the rig to the turbine in air.
fn full_scale() -> ScalingLaw {
    let mut variables = TABLE_1.to_vec();
    variables.extend(CONTROLLER.iter().filter(|(name, _)| !matches!(*name, "L_t" | "V")));
    variables.push(("k_d^z", "1"));
    system(&variables).law(&[("L_t", "100"), ("rho", "1.225/1000"), ("g", "1")]).unwrap()
}

#[track_caller]
fn check(law: &ScalingLaw, variable: &str, rule: &str, factor: &str) {
    let found = law.rule(variable).unwrap();
    assert_eq!((found.to_string().as_str(), found.factor.to_string().as_str()), (rule, factor));
}

#[test]
fn laws_after_equation_19_come_out_of_the_dimensions() {
    let law = full_scale();
    check(&law, "V", "V ~ L_t^(1/2)*g^(1/2)", "10");
    check(&law, "k_p^z", "k_p^z ~ L_t^(-1/2)*g^(1/2)", "1/10");
    check(&law, "k_p^theta", "k_p^theta ~ L_t^(1/2)*g^(1/2)", "10");
    check(&law, "k_p^phi", "k_p^phi ~ L_t^(1/2)*g^(1/2)", "10");
    check(&law, "k_d^theta", "k_d^theta ~ L_t", "100");
    check(&law, "k_d^phi", "k_d^phi ~ L_t", "100");
    check(&law, "tau_z", "tau_z ~ L_t^(1/2)*g^(-1/2)", "10");
    check(&law, "M_a", "M_a ~ L_t^3*rho", "1225");
    check(&law, "lambda", "lambda ~ L_t^2*rho", "49/4");
    check(&law, "L_t", "L_t ~ L_t", "100");
    check(&law, "Theta_ddot", "Theta_ddot ~ L_t^-1*g", "1/100");
    check(&law, "k_d^z", "k_d^z ~ 1", "1");
    assert_eq!(law.rule("M_a").unwrap().factor.apply(0.18).to_bits(), 220.5f64.to_bits());
}

#[test]
fn any_dimension_has_its_ratio() {
    let law = full_scale();
    let factor = |text: &str| law.factor(&text.parse().unwrap()).unwrap().to_string();
    assert_eq!(factor("T"), "10");
    assert_eq!(factor("M*L/T^2"), "1225");
    assert_eq!(factor("M*L^2"), "12250000");
    assert_eq!(factor("M/(L*T^2)"), "49/400");
    assert_eq!(factor("L^(1/2)"), "10");
    assert_eq!(factor("1"), "1");
    let error = law.factor(&"M*I".parse().unwrap()).unwrap_err();
    assert_eq!(
        error.to_string(),
        "the given ratios (L_t, rho and g) do not determine M*I: I stays free, \
         so add a variable of such a dimension to the system, and its ratio"
    );
}

#[test]
fn plain_dimensions_are_ratios_too() {
    let law = system(&TABLE_1).law(&[("L", "100"), ("M", "1225"), ("T", "10")]).unwrap();
    check(&law, "V", "V ~ L*T^-1", "10");
    check(&law, "rho", "rho ~ L^-3*M", "49/40000");
    let mixed = system(&TABLE_1).law(&[("L", "100"), ("L/T^2", "1"), ("rho", "1.225/1000")]).unwrap();
    assert_eq!(mixed.rule("M_a").unwrap().factor, law.rule("M_a").unwrap().factor);
}

#[test]
fn irrational_ratios_stay_exact() {
    let law = system(&TABLE_1).law(&[("L_t", "3"), ("rho", "1"), ("g", "1")]).unwrap();
    let speed = law.rule("V").unwrap().factor;
    assert_eq!(speed.to_string(), "3^(1/2)");
    assert_eq!(speed.pow(&ratio("2")), "3".parse::<Factor>().unwrap());
    assert_eq!(law.inverse().rule("V").unwrap().factor, speed.inverse());
    assert_eq!(law.inverse().rule("M_a").unwrap().factor.to_string(), "1/27");
}

#[test]
fn free_quantities_are_named() {
    let error = system(&TABLE_1).law(&[("L_t", "100"), ("g", "1")]).unwrap_err();
    assert_eq!(
        error.to_string(),
        "the given ratios (L_t and g) do not determine M_a (M): \
         M stays free, so give the ratio of one of M_a, rho, lambda as well"
    );
    let nothing = system(&[("a", "m")]).law(&[]).unwrap_err();
    assert_eq!(
        nothing.to_string(),
        "the given ratios (none) do not determine a (L): L stays free, so give the ratio of a as well"
    );
}

#[test]
fn contradictory_ratios_name_the_group_and_both_values() {
    let error = |ratios: &[(&str, &str)]| system(&TABLE_1).law(ratios).unwrap_err().to_string();
    assert_eq!(
        error(&[("L_t", "100"), ("rho", "1"), ("g", "1"), ("V", "11")]),
        "the given ratios contradict each other: V^2/(L_t*g) is dimensionless and must keep its value, \
         but V changes by 11, where the other ratios require 10"
    );
    assert_eq!(
        error(&[("L_t", "10"), ("T", "3"), ("V", "3.3333"), ("rho", "1")]),
        "the given ratios contradict each other: V*T/L_t is dimensionless and must keep its value, \
         but V changes by 33333/10000 (3.3333), where the other ratios require 10/3 (3.3333)"
    );
}

#[test]
fn redundant_ratios_that_agree_are_fine() {
    let law = system(&TABLE_1)
        .law(&[("L_t", "2"), ("rho", "1"), ("g", "1"), ("V", "2^(1/2)"), ("L_c", "2"), ("M_a", "8")])
        .unwrap();
    assert_eq!(law.given().map(|(name, _)| name).collect::<Vec<_>>(), ["L_t", "rho", "g"]);
    check(&law, "Theta_dot", "Theta_dot ~ L_t^(-1/2)*g^(1/2)", "1/2^(1/2)");
}

#[test]
fn dimensionless_variables_keep_their_value() {
    let system = system(&[("a", "m"), ("alpha", "rad")]);
    assert!(system.law(&[("a", "2"), ("alpha", "1")]).is_ok());
    let error = system.law(&[("a", "2"), ("alpha", "2")]).unwrap_err().to_string();
    assert!(error.contains("alpha is dimensionless and must keep its value, but alpha changes by 2"), "{error}");
}

#[test]
fn bad_ratios_are_refused_by_name() {
    let error = |ratios: &[(&str, &str)]| system(&TABLE_1).law(ratios).unwrap_err().to_string();
    assert_eq!(error(&[("L_t", "0")]), "L_t: 0 is no ratio: it must be positive and finite");
    assert_eq!(
        error(&[("L_t", "1O0")]),
        "L_t: \"1O0\", character 2: found `O`, expected an operator (`*`, `/`, `^`) or the end"
    );
    assert_eq!(error(&[("L_tt", "1")]), "there is no variable `L_tt`; did you mean `L_t`?");
    assert_eq!(error(&[("L_t", "1"), ("L_t", "1")]), "`L_t` is given twice as a ratio");
    assert!(matches!(system(&TABLE_1).law(&[("I", "1")]), Err(Error::UnknownVariable { .. })));
    assert!(matches!(system(&TABLE_1).law(&[("1", "1")]), Err(Error::UnknownVariable { .. })));
}

#[test]
fn law_prints_one_rule_a_line() {
    let law = system(&[("L", "m"), ("g", "m/s^2"), ("V", "m/s")]).law(&[("L", "10"), ("g", "1")]).unwrap();
    assert_eq!(
        law.to_string(),
        "L ~ L                10\ng ~ g                1\nV ~ L^(1/2)*g^(1/2)  10^(1/2) (3.1623)\n"
    );
}

#[test]
fn variable_goes_before_a_dimension_of_the_same_name() {
    // T is a temperature here, not the time.
    let system = system(&[("T", "K"), ("tau", "s")]);
    let law = system.law(&[("T", "2"), ("tau", "3")]).unwrap();
    assert_eq!(law.factor(&"Theta".parse::<Dimension>().unwrap()).unwrap().to_string(), "2");
}
