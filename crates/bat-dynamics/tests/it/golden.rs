//! An independent derivation (sympy, 40 digits) at random states: every term of (4), X, Omega and the tensions.

use bat_dynamics::{
    Fidelity, Flow, Plant, TetherLayout, accelerations, christoffel_matrix, generalized_forces, gravity_vector,
    kinetic_energy, mass_matrix, potential_energy, rotation, translation,
};
use nalgebra::Vector6;
use serde_json::Value;

use crate::plants::rig;

/// The golden values are exact to rounding; solving the free rows near Phi = 0 loses up to three digits.
const TOLERANCE: f64 = 1e-11;

fn numbers(value: &Value) -> Vec<f64> {
    value
        .as_array()
        .unwrap()
        .iter()
        .flat_map(|v| if v.is_array() { numbers(v) } else { vec![v.as_f64().unwrap()] })
        .collect()
}

fn array<const N: usize>(value: &Value) -> [f64; N] {
    numbers(value).try_into().unwrap()
}

#[track_caller]
fn check(case: &Value, name: &str, found: &[f64]) {
    let expected = numbers(&case[name]);
    assert_eq!(found.len(), expected.len(), "{name}: length");
    let scale = expected.iter().fold(1e-12_f64, |a, b| a.max(b.abs()));
    for (k, (f, e)) in found.iter().zip(&expected).enumerate() {
        assert!(
            (f - e).abs() <= TOLERANCE * scale,
            "{} of {}, entry {k}: found {f}, independent derivation {e}",
            name,
            case["name"]
        );
    }
}

#[test]
fn every_term_matches_the_sympy_derivation() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/bat-dynamics/lagrange.json");
    let golden: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let cases = golden["cases"].as_array().unwrap();
    assert!(cases.len() >= 40, "the golden file holds {} cases", cases.len());
    for case in cases {
        let number = |name: &str| case[name].as_f64().unwrap();
        let mut parameters = rig();
        parameters.body.center_of_mass_x = number("center_of_mass_x_pct_chord") / 100.0;
        parameters.horizontal_stabilizer.area_factor = number("area_factor_horizontal");
        parameters.vertical_stabilizer.area_factor = number("area_factor_vertical");
        parameters.horizontal_stabilizer.incidence_rad = number("incidence_deg").to_radians();
        parameters.layout = match case["layout"].as_str().unwrap() {
            "one-forward-two-aft" => TetherLayout::OneForwardTwoAft,
            _ => TetherLayout::TwoForwardOneAft,
        };
        let fidelity = match case["fidelity"].as_str().unwrap() {
            "numerical" => Fidelity::NUMERICAL,
            "stalled" => Fidelity::STALLED,
            "added_mass" => Fidelity::ADDED_MASS,
            _ => Fidelity::STALLED_WITH_ADDED_MASS,
        };
        let plant = Plant::new(&parameters, fidelity).unwrap();
        let flow = Flow { speed_m_s: number("flow_speed"), direction_rad: number("flow_direction") };
        let (q, rate): ([f64; 6], [f64; 6]) = (array(&case["q"]), array(&case["qdot"]));

        check(case, "X", &translation(&plant, &q, &rate));
        check(case, "Omega", &rotation(&plant, &q, &rate));
        check(case, "D", mass_matrix(&plant, &q).as_slice());
        check(case, "C_qdot", (christoffel_matrix(&plant, &q, &rate) * Vector6::from(rate)).as_slice());
        check(case, "g", gravity_vector(&plant, &q).as_slice());
        check(case, "tau", generalized_forces(&plant, &q, &rate, &flow).as_slice());
        let at = accelerations(&plant, &q, &rate, array(&case["qddot_driven"]), &flow).unwrap();
        check(case, "qddot_free", &at.free_rad_s2);
        check(case, "f", &at.supplied);
        check(case, "tensions", &at.tensions.named().map(|line| line.1));
        assert!((potential_energy(&plant, &q) - number("potential")).abs() < 1e-13, "potential energy");
        if number("kinetic_order_0") == 0.0 {
            assert!((kinetic_energy(&plant, &q, &rate) - number("kinetic")).abs() < 1e-13, "kinetic energy");
        }
    }
}
