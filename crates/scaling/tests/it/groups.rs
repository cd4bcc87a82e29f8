//! The groups of a system.

use scaling::{BigRational, Dimension, Group, Orientation, SetUp, System, Variable};

use crate::{CONTROLLER, TABLE_1, ratio, system};

/// Each computed group is a listed one or its inverse, and both sets span the same space.
#[track_caller]
fn check_listed(system: &System, repeating: &[&str], listed: &[&str]) {
    let groups = system.groups(repeating).unwrap();
    let listed: Vec<Group> = listed.iter().map(|text| system.group(text).unwrap()).collect();
    assert_eq!(groups.len(), listed.len());
    assert!(groups.span_same_space(&listed));
    for group in &groups {
        assert!(listed.contains(group) || listed.contains(&group.inverse()), "{group} is not listed");
    }
}

#[test]
fn eleven_groups_of_equation_15_come_out_of_table_1() {
    let listed = [
        "L_c/L_t",
        "L_t/d_t",
        "L_t^3*rho/M_a",
        "lambda*L_t/M_a",
        "g*L_t/V^2",
        "L_t*Theta_dot/V",
        "L_t^2*Theta_ddot/V^2",
        "L_t*Phi_dot/V",
        "L_t^2*Phi_ddot/V^2",
        "L_t*Psi_dot/V",
        "L_t^2*Psi_ddot/V^2",
    ];
    check_listed(&system(&TABLE_1), &["L_t", "M_a", "V"], &listed);
}

/// Table 1 with its times in units of t_bar = a t, and the stretching a, a pure number.
fn table_1_in_scaled_time() -> System {
    let scaled = |(name, unit): (&'static str, &'static str)| match name {
        "V" => ("V_bar", unit),
        "g" => ("g_bar", unit),
        _ => (name, unit),
    };
    let variables: Vec<_> = TABLE_1.into_iter().map(scaled).chain([("a", "1")]).collect();
    system(&variables)
}

#[test]
fn twelve_groups_of_equation_17_come_out_of_table_1_in_scaled_time() {
    let listed = [
        "L_c/L_t",
        "L_t/d_t",
        "L_t^3*rho/M_a",
        "lambda*L_t/M_a",
        "g_bar*L_t/V_bar^2",
        "L_t*Theta_dot/V_bar",
        "L_t^2*Theta_ddot/V_bar^2",
        "L_t*Phi_dot/V_bar",
        "L_t^2*Phi_ddot/V_bar^2",
        "L_t*Psi_dot/V_bar",
        "L_t^2*Psi_ddot/V_bar^2",
        "a",
    ];
    check_listed(&table_1_in_scaled_time(), &["L_t", "M_a", "V_bar"], &listed);
}

#[test]
fn groups_of_equation_17_match_at_every_scale_except_the_stretching_of_time() {
    // In scaled time nothing gets slower: speed and gravity go as the length, as the text after (18) says.
    let scaled = table_1_in_scaled_time().law(&[("L_t", "100"), ("rho", "1"), ("T", "1")]).unwrap();
    for (name, factor) in [("V_bar", "100"), ("g_bar", "100"), ("Theta_dot", "1"), ("Psi_ddot", "1"), ("a", "1")] {
        assert_eq!(scaled.rule(name).unwrap().factor.to_string(), factor, "{name}");
    }
    // In absolute time gravity stays, so that times go as the square root of the length, and a as its inverse, (18).
    let absolute = system(&TABLE_1).law(&[("L_t", "100"), ("rho", "1"), ("g", "1")]).unwrap();
    let time = absolute.factor(&"T".parse().unwrap()).unwrap();
    assert_eq!((time.to_string(), time.inverse().to_string()), ("10".to_owned(), "1/10".to_owned()));
    // V_bar = V/a and g_bar = g/a² say the same.
    let stretching = time.inverse();
    let speed = &absolute.rule("V").unwrap().factor * &stretching.inverse();
    assert_eq!(speed, scaled.rule("V_bar").unwrap().factor);
    assert_eq!(stretching.pow(&ratio("-2")), scaled.rule("g_bar").unwrap().factor);
}

/// (19) as repaired: `V/k_p^phi` in place of what is missing, `t_bar/tau_z` in place of `V/tau_z`, with t_bar = L_t/V.
const LISTED_19: [&str; 8] = [
    "L_t/k_d^theta",
    "L_t/k_d^phi",
    "L_t*k_p^z/V",
    "V/k_p^theta",
    "V/k_p^phi",
    "L_t/(V*tau_z)",
    "L_t/(V*tau_theta)",
    "L_t/(V*tau_phi)",
];

#[test]
fn eight_groups_of_equation_19_come_out_of_the_controller() {
    check_listed(&system(&CONTROLLER), &["L_t", "V"], &LISTED_19);
}

#[test]
fn dimensionless_gain_is_a_group_of_its_own() {
    let mut variables = CONTROLLER.to_vec();
    variables.insert(3, ("k_d^z", "m/m"));
    let system = system(&variables);
    let listed: Vec<_> = LISTED_19.into_iter().chain(["k_d^z"]).collect();
    check_listed(&system, &["L_t", "V"], &listed);
    assert_eq!(system.n_groups(), 9);
    assert_eq!(system.propose_repeating(), ["L_t", "V"]);
}

#[test]
fn term_of_19_as_printed_is_not_dimensionless() {
    let error = system(&CONTROLLER).group("V/tau_z").unwrap_err();
    assert_eq!(error.to_string(), "V/tau_z is not dimensionless: it has the dimension L/T^2");
}

#[test]
fn groups_print_as_people_write_them() {
    let groups = system(&TABLE_1).groups(&["L_t", "M_a", "V"]).unwrap();
    let written: Vec<_> = groups.iter().map(Group::to_string).collect();
    assert_eq!(written[..5], ["L_c/L_t", "d_t/L_t", "L_t^3*rho/M_a", "L_t*g/V^2", "L_t*Theta_dot/V"]);
    let below: Vec<_> = groups.oriented(Orientation::Below).iter().map(Group::to_string).collect();
    assert_eq!(below[..5], ["L_t/L_c", "L_t/d_t", "M_a/(L_t^3*rho)", "V^2/(L_t*g)", "V/(L_t*Theta_dot)"]);
}

#[test]
fn exponents_are_coprime_integers() {
    // From a root: sqrt(l) has the dimension L^(1/2), and l itself must enter to an integer power.
    let system = system(&[("s", "m^(1/2)"), ("l", "m"), ("c", "m^(1/3)")]);
    let groups = system.groups(&["l"]).unwrap();
    let written: Vec<_> = groups.iter().map(Group::to_string).collect();
    assert_eq!(written, ["s^2/l", "c^3/l"]);
    assert_eq!(groups.iter().next().unwrap().exponent("s"), ratio("2"));
}

#[test]
fn group_of_names_with_carets_reads_back() {
    let system = system(&[("k_p^z", "1/s"), ("a", "1/s^2"), ("k", "1"), ("k_p", "1")]);
    let groups = system.groups(&["k_p^z"]).unwrap();
    let written: Vec<_> = groups.iter().map(Group::to_string).collect();
    assert_eq!(written, ["a/(k_p^z)^2", "k", "k_p"]);
    for group in &groups {
        assert_eq!(system.group(&group.to_string()).unwrap(), *group);
    }
}

#[test]
fn reynolds_and_drag_coefficient_come_out_of_a_cylinder() {
    let system = system(&[("D", "m"), ("rho", "kg/m^3"), ("U", "m/s"), ("mu", "Pa*s"), ("F", "N")]);
    let groups = system.groups(&["D", "rho", "U"]).unwrap();
    let reynolds = system.group("rho*U*D/mu").unwrap();
    let drag = system.group("F/(rho*U^2*D^2)").unwrap();
    assert!(groups.span_same_space(&[reynolds.clone(), drag.clone()]));
    assert!(groups.span_same_space(&[reynolds.inverse(), drag.pow(&ratio("1/2"))]));
    assert!(!groups.span_same_space(&[reynolds.clone(), reynolds.pow(&ratio("2"))]));
    assert!(!groups.span_same_space(&[reynolds]));
    assert!(!groups.span_same_space(&[]));
}

#[test]
fn every_repeating_set_of_the_pendulum_is_found() {
    let system = system(&[("l", "m"), ("g", "m/s^2"), ("m", "kg"), ("T", "s"), ("alpha", "rad")]);
    let sets: Vec<_> = system.repeating_sets().collect();
    assert_eq!(sets, [["l", "g", "m"], ["l", "m", "T"], ["g", "m", "T"]]);
    assert_eq!(system.in_no_group(), ["m"]);
    assert_eq!(system.rank(), 3);
}

#[test]
fn repeating_sets_are_lazy() {
    // 60 over 7 sets are 386 million: only the first ones are ever made.
    let bases = ["a", "b", "c", "d", "e", "f", "g"];
    let variable = |n: usize| {
        let dimension = bases.iter().enumerate().fold(Dimension::one(), |product, (i, base)| {
            let power = BigRational::from_integer(((n * (i + 3) + i * i) % 11 + 1).into());
            &product * &Dimension::base(base).unwrap().pow(&power)
        });
        Variable { name: format!("x{n}"), dimension }
    };
    let system = System::new((0..60).map(variable).collect()).unwrap();
    assert_eq!(system.rank(), system.repeating_sets().next().unwrap().len());
    assert_eq!(system.repeating_sets().take(1000).count(), 1000);
}

#[test]
fn system_of_numbers_has_every_variable_as_a_group() {
    let system = system(&[("a", "rad"), ("b", "1")]);
    let groups = system.groups(&[]).unwrap();
    assert_eq!(groups.iter().map(Group::to_string).collect::<Vec<_>>(), ["a", "b"]);
    assert_eq!(system.repeating_sets().collect::<Vec<_>>(), [Vec::<&str>::new()]);
}

#[test]
fn system_without_groups_is_fine() {
    let system = system(&[("a", "m"), ("b", "kg")]);
    assert!(system.groups(&["a", "b"]).unwrap().is_empty());
    assert_eq!(system.in_no_group(), ["a", "b"]);
}

#[test]
fn large_exponents_neither_panic_nor_wrap() {
    let powers = |n: i64, d: i64| format!("m^({n}/{d})*kg^({d}/{n})*s^({}/{})", n - 3, d + 2);
    let names: Vec<String> = (0..14).map(|i| format!("x{i}")).collect();
    let texts: Vec<String> = (0..14).map(|i| powers(997 - 31 * i, 991 - 17 * i)).collect();
    let variables: Vec<_> = names.iter().zip(&texts).map(|(n, t)| (n.as_str(), t.as_str())).collect();
    let system = system(&variables);
    let groups = system.groups(&system.propose_repeating()).unwrap();
    assert_eq!(groups.len(), 11);
    // Coprime integers that no machine integer holds.
    assert!(groups.iter().any(|group| group.factors().any(|(_, e)| e.numer().bits() > 64)));
    let set_up = names.iter().fold(SetUp::new("ones"), |set_up, name| set_up.with(name.clone(), 1.0));
    for group in &groups {
        assert_eq!(group.value(&set_up).map(f64::to_bits), Ok(1.0f64.to_bits()));
    }
}

#[test]
fn values_are_rounded_once() {
    let system = system(&[("a", "m"), ("b", "m")]);
    let group = system.group("a^3/b^3").unwrap();
    // In doubles 0.1^3/0.3^3 is off by units in the last place; 1/27 exactly rounded is the nearest.
    let value = group.value(&SetUp::new("s").with("a", 0.1).with("b", 0.3)).unwrap();
    assert_eq!(value.to_bits(), (1.0f64 / 27.0).to_bits());
    // The factors overflow, the group does not.
    let huge = group.value(&SetUp::new("s").with("a", 2e200).with("b", 1e200)).unwrap();
    assert_eq!(huge.to_bits(), 8.0f64.to_bits());
}

#[test]
fn signs_follow_the_exponents() {
    let system = system(&[("a", "m"), ("b", "m")]);
    let at = |text: &str, a: f64, b: f64| {
        system.group(text).unwrap().value(&SetUp::new("s").with("a", a).with("b", b)).map_err(|e| e.to_string())
    };
    assert_eq!(at("a/b", -2.0, 4.0), Ok(-0.5));
    assert_eq!(at("a/b", -2.0, -4.0), Ok(0.5));
    assert_eq!(at("a^2/b^2", -2.0, 4.0), Ok(0.25));
    assert_eq!(at("a^(1/3)/b^(1/3)", -8.0, 1.0), Ok(-2.0));
    assert_eq!(at("a/b", 0.0, 4.0), Ok(0.0));
    assert_eq!(at("a/b", 1.0, 0.0), Err("set-up \"s\": b is 0.0, but a/b divides by it".into()));
    let even = Err("set-up \"s\": a is -2.0, but a^(1/2)/b^(1/2) takes an even root of it".into());
    assert_eq!(at("a^(1/2)/b^(1/2)", -2.0, 4.0), even);
    assert_eq!(at("a/b", f64::NAN, 4.0), Err("set-up \"s\": a is NaN, but a/b needs a finite number".into()));
    let beyond = Err("set-up \"s\": the value of a^2/b^2 is beyond the range of f64".into());
    assert_eq!(at("a^2/b^2", 1e300, 1e-300), beyond);
    let missing = system.group("a/b").unwrap().value(&SetUp::new("s").with("a", 1.0)).unwrap_err();
    assert_eq!(missing.to_string(), "set-up \"s\" gives no value for b, which a/b needs");
}
