//! Plants whose starboard and port sides differ: an independent derivation, the mirror, the symmetric limit, signs, trims.

use bat_dynamics::{
    Asymmetry, Disturbance, Error, Fidelity, Flow, NoTrim, OPTIONAL_FIELDS, Parameters, Plant, TetherLayout,
    TrimHeight, TrimRequest, accelerations, aerodynamic_wrench, christoffel_matrix, driven_of_lines, evaluate,
    evaluate_with, generalized_forces, gravity_vector, kinetic_energy, lines_of_driven, mass_matrix, potential_energy,
    rotation, sight, translation, trim, trim_with_lines,
};
use nalgebra::{Vector3, Vector6};
use serde_json::Value;

use crate::oracle;
use crate::plants::{Sample, everything, rig};
use crate::symmetry::{assert_mirrored, mirrored};

/// Of the largest entry of each vector or matrix.
const TOLERANCE: f64 = 1e-12;

fn golden(name: &str) -> Vec<Value> {
    let path = format!("{}/../../fixtures/bat-dynamics/{name}", env!("CARGO_MANIFEST_DIR"));
    let file: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    file["cases"].as_array().unwrap().clone()
}

fn numbers(value: &Value) -> Vec<f64> {
    let entries = value.as_array().unwrap().iter();
    entries.flat_map(|v| if v.is_array() { numbers(v) } else { vec![v.as_f64().unwrap()] }).collect()
}

fn array<const N: usize>(value: &Value) -> [f64; N] {
    numbers(value).try_into().unwrap()
}

fn plant_of(case: &Value) -> Plant {
    let number = |name: &str| case[name].as_f64();
    let mut p = rig();
    p.body.center_of_mass_x = number("center_of_mass_x_pct_chord").unwrap() / 100.0;
    p.body.inertia_xz_kg_m2 = number("inertia_xz").unwrap();
    if let Some(factor) = number("area_factor_horizontal") {
        p.horizontal_stabilizer.area_factor = factor;
        p.vertical_stabilizer.area_factor = number("area_factor_vertical").unwrap();
        p.horizontal_stabilizer.incidence_rad = number("incidence_deg").unwrap().to_radians();
    }
    for field in OPTIONAL_FIELDS {
        (field.set)(&mut p, number(field.name).unwrap());
    }
    p.layout = match case["layout"].as_str() {
        Some("two-forward-one-aft") => TetherLayout::TwoForwardOneAft,
        _ => TetherLayout::OneForwardTwoAft,
    };
    let fidelity = match case["fidelity"].as_str().unwrap() {
        "numerical" => Fidelity::NUMERICAL,
        "stalled" => Fidelity::STALLED,
        "added_mass" => Fidelity::ADDED_MASS,
        _ => Fidelity::STALLED_WITH_ADDED_MASS,
    };
    Plant::new(&p, fidelity).unwrap()
}

#[track_caller]
fn check(case: &Value, name: &str, found: &[f64], tolerance: f64) {
    let expected = numbers(&case[name]);
    assert_eq!(found.len(), expected.len(), "{name}: length");
    let scale = expected.iter().fold(1e-12_f64, |a, b| a.max(b.abs()));
    for (k, (f, e)) in found.iter().zip(&expected).enumerate() {
        assert!(
            (f - e).abs() <= tolerance * scale,
            "{name} of {}, entry {k}: {f}, independent derivation {e}",
            case["name"]
        );
    }
}

#[test]
fn every_term_matches_the_sympy_derivation() {
    let cases = golden("asymmetric.json");
    assert!(cases.len() >= 24, "the golden file holds {} cases", cases.len());
    for case in &cases {
        let plant = plant_of(case);
        let number = |name: &str| case[name].as_f64().unwrap();
        let flow = Flow { speed_m_s: number("flow_speed"), direction_rad: number("flow_direction") };
        let (q, rate): ([f64; 6], [f64; 6]) = (array(&case["q"]), array(&case["qdot"]));
        check(case, "X", &translation(&plant, &q, &rate), TOLERANCE);
        check(case, "Omega", &rotation(&plant, &q, &rate), TOLERANCE);
        check(case, "D", mass_matrix(&plant, &q).as_slice(), TOLERANCE);
        let coriolis = christoffel_matrix(&plant, &q, &rate) * Vector6::from(rate);
        check(case, "C_qdot", coriolis.as_slice(), TOLERANCE);
        check(case, "g", gravity_vector(&plant, &q).as_slice(), TOLERANCE);
        check(case, "tau", generalized_forces(&plant, &q, &rate, &flow).as_slice(), TOLERANCE);
        let at = accelerations(&plant, &q, &rate, array(&case["qddot_driven"]), &flow).unwrap();
        check(case, "qddot_free", &at.free_rad_s2, TOLERANCE);
        check(case, "f", &at.supplied, TOLERANCE);
        check(case, "tensions", &at.tensions.named().map(|line| line.1), TOLERANCE);
        check(case, "lines", &lines_of_driven(&plant, [q[3], q[4], q[5]]), TOLERANCE);
        check(case, "q", &[&q[..3], &driven_of_lines(&plant, array(&case["lines"]))].concat(), TOLERANCE);
        assert!((potential_energy(&plant, &q) - number("potential")).abs() < 1e-13, "potential energy");
        if number("kinetic_order_0") == 0.0 {
            assert!((kinetic_energy(&plant, &q, &rate) - number("kinetic")).abs() < 1e-13, "kinetic energy");
        }
    }
}

#[test]
fn trims_match_a_root_search_on_newton_and_euler() {
    for case in &golden("asymmetric_trims.json") {
        let plant = plant_of(case);
        let number = |name: &str| case[name].as_f64().unwrap();
        let request = TrimRequest {
            flow: Flow { speed_m_s: number("flow_speed"), direction_rad: number("flow_direction") },
            pitch_rad: number("pitch_deg").to_radians(),
            height: TrimHeight::Altitude(number("altitude")),
        };
        let found = trim(&plant, &request).unwrap();
        check(case, "q", &found.coordinates, 1e-10);
        check(case, "lines", &found.state[6..9], 1e-10);
        check(case, "tensions", &found.tensions.named().map(|line| line.1), 1e-10);
        assert!((found.state[7] - found.state[8]).abs() < 1e-12, "winches at the same length: {:?}", found.state);
        let seen = sight(&plant, &found.state, &request.flow);
        let attitude = [seen.roll_rad, seen.pitch_rad, seen.heading_rad + request.flow.direction_rad];
        check(case, "attitude", &attitude, 1e-10);
        for (k, rate) in evaluate(&plant, &found.state, [0.0; 3], &request.flow).derivative.into_iter().enumerate() {
            assert!(rate.abs() < 1e-9, "rate {k} at trim: {rate}");
        }
        // The same lines, held.
        let lines = array(&case["lines"]);
        let held = trim_with_lines(&plant, lines, &request.flow).unwrap();
        for k in 0..12 {
            assert!((held.state[k] - found.state[k]).abs() < 1e-8, "state {k} with held lines");
        }
    }
}

/// A plant with everything that sets starboard apart from port.
fn lopsided(sample: &mut Sample) -> Parameters {
    let mut p = everything();
    p.asymmetry = Asymmetry {
        center_of_mass_y_m: sample.within(-0.01, 0.01),
        inertia_xy_kg_m2: sample.within(-3e-5, 3e-5),
        inertia_yz_kg_m2: sample.within(-3e-5, 3e-5),
        offset_lateral_m: sample.within(0.0, 0.08),
        incidence_difference_rad: sample.within(-0.1, 0.1),
        lift_slope_difference_per_rad: sample.within(-1.0, 1.0),
        line_center_m: sample.within(-0.02, 0.02),
        line_starboard_m: sample.within(-0.02, 0.02),
        line_port_m: sample.within(-0.02, 0.02),
    };
    p
}

fn mirror(mut p: Parameters) -> Parameters {
    let a = &mut p.asymmetry;
    for odd in [
        &mut a.center_of_mass_y_m,
        &mut a.inertia_xy_kg_m2,
        &mut a.inertia_yz_kg_m2,
        &mut a.incidence_difference_rad,
        &mut a.lift_slope_difference_per_rad,
    ] {
        *odd = -*odd;
    }
    core::mem::swap(&mut a.line_starboard_m, &mut a.line_port_m);
    p
}

#[test]
fn mirrored_plants_in_mirrored_states_have_mirrored_rates_bit_for_bit() {
    let mut sample = Sample(61);
    for _ in 0..500 {
        let p = lopsided(&mut sample);
        let of = |p: &Parameters| Plant::new(p, Fidelity::STALLED_WITH_ADDED_MASS).unwrap();
        let (state, [a, b, c]) = (sample.state(), sample.array(-0.02, 0.02));
        let (speed_m_s, direction_rad) = (sample.within(0.1, 0.4), sample.within(-1.0, 1.0));
        let right = evaluate(&of(&p), &state, [a, b, c], &Flow { speed_m_s, direction_rad });
        let flow = Flow { speed_m_s, direction_rad: -direction_rad };
        let left = evaluate(&of(&mirror(p)), &mirrored(&state), [a, c, b], &flow);
        assert_mirrored(&left, &right, &state);
    }
}

#[test]
fn symmetric_plants_take_the_same_bits_through_either_door_and_the_limit_is_theirs() {
    let mut sample = Sample(62);
    for _ in 0..200 {
        let symmetric = Plant::new(&everything(), Fidelity::STALLED_WITH_ADDED_MASS).unwrap();
        assert!(!symmetric.is_lopsided(), "a plant without asymmetry");
        let (state, command) = (sample.state(), sample.array(-0.02, 0.02));
        let flow = Flow { speed_m_s: sample.within(0.1, 0.4), direction_rad: sample.within(-1.0, 1.0) };
        let one = evaluate(&symmetric, &state, command, &flow);
        let other = evaluate_with::<f64, false, false>(&symmetric, &state, command, &flow, &Disturbance::none());
        assert_eq!(one.derivative.map(f64::to_bits), other.derivative.map(f64::to_bits), "at {state:?}");
        // The general code with an asymmetry that is next to none: two halves at one place are one surface.
        let mut p = everything();
        p.asymmetry.center_of_mass_y_m = 1e-300;
        let near = Plant::new(&p, Fidelity::STALLED_WITH_ADDED_MASS).unwrap();
        assert!(near.is_lopsided(), "an asymmetry");
        let near = evaluate(&near, &state, command, &flow);
        for (k, (a, b)) in one.derivative.iter().zip(near.derivative).enumerate() {
            assert!((a - b).abs() <= 1e-12 * a.abs().max(10.0), "rate {k}: {a} and {b}");
        }
    }
}

#[test]
fn energy_is_that_of_a_heap_of_point_masses_beside_the_plane_of_symmetry() {
    let mut sample = Sample(63);
    for _ in 0..20 {
        // Points around a center of mass to starboard, their tensor by sums.
        let points: Vec<(f64, Vector3<f64>)> =
            (0..9).map(|_| (sample.within(0.01, 0.03), Vector3::from(sample.array::<3>(-0.04, 0.04)))).collect();
        let mass: f64 = points.iter().map(|(m, _)| m).sum();
        let center = points.iter().map(|(m, r)| r * *m).sum::<Vector3<f64>>() / mass;
        let second =
            |i: usize, k: usize| points.iter().map(|(m, r)| m * (r - center)[i] * (r - center)[k]).sum::<f64>();
        let mut p = everything();
        p.body.mass_kg = mass;
        p.body.center_of_mass_x = p.body.joint_x - center.x / p.body.chord_m;
        p.body.center_of_mass_height_m = -center.z;
        p.asymmetry.center_of_mass_y_m = center.y;
        p.body.inertia_xx_kg_m2 = second(1, 1) + second(2, 2);
        p.body.inertia_yy_kg_m2 = second(0, 0) + second(2, 2);
        p.body.inertia_zz_kg_m2 = second(0, 0) + second(1, 1);
        p.body.inertia_xz_kg_m2 = second(0, 2);
        p.asymmetry.inertia_xy_kg_m2 = second(0, 1);
        p.asymmetry.inertia_yz_kg_m2 = second(1, 2);
        p.tether.linear_density_kg_m = 0.0;
        let plant = Plant::new(&p, Fidelity::NUMERICAL).unwrap();
        let (q, rate) = (sample.coordinates(), sample.rates());
        let expected: f64 = points.iter().map(|(m, r)| 0.5 * m * oracle::velocity(&q, &rate, *r).norm_squared()).sum();
        let found = kinetic_energy(&plant, &q, &rate);
        assert!((found - expected).abs() < 1e-12 * expected, "{found} J against {expected} J");
    }
}

/// Level, head to the flow, at rest: what the asymmetry alone does.
fn level(p: &Parameters, speed_m_s: f64) -> (Plant, [f64; 6], Flow) {
    let plant = Plant::new(p, Fidelity::NUMERICAL).unwrap();
    (plant, [0.3, 0.0, 0.0, 0.6, -0.3, 0.0], Flow::straight(speed_m_s))
}

/// Moment in roll at rest: the force that the lines must supply against it, reversed.
fn rolling_moment(p: &Parameters) -> f64 {
    let (plant, q, flow) = level(p, 0.245);
    (generalized_forces(&plant, &q, &[0.0; 6], &flow) - gravity_vector(&plant, &q))[5]
}

#[test]
fn mass_to_starboard_rolls_to_starboard_by_its_weight() {
    let mut p = rig();
    assert!(rolling_moment(&p).abs() < 1e-15, "symmetric: {}", rolling_moment(&p));
    p.asymmetry.center_of_mass_y_m = 2e-3;
    let expected = 0.18 * 9.81 * 2e-3;
    assert!((rolling_moment(&p) - expected).abs() < 1e-12 * expected, "{} N m", rolling_moment(&p));
}

#[test]
fn more_incidence_or_slope_to_starboard_lifts_starboard() {
    let mut p = rig();
    p.horizontal_stabilizer.incidence_rad = 0.1;
    p.horizontal_stabilizer.drag_due_to_lift = 0.0;
    p.asymmetry.offset_lateral_m = 0.05;
    let fin = p.horizontal_stabilizer;
    let pressure = 0.5 * 1000.0 * 0.245 * 0.245;
    let mut twisted = p;
    twisted.asymmetry.incidence_difference_rad = 0.02;
    // Each half differs from the mean by half the difference, with half the area, at the same arm.
    let lift = pressure * 0.5 * fin.area_m2 * fin.lift_slope_per_rad * 0.02;
    let found = rolling_moment(&twisted);
    assert!((found + lift * 0.05).abs() < 1e-9 * lift, "roll moment {found} N m for {lift} N at 0.05 m");
    let mut steeper = p;
    steeper.asymmetry.lift_slope_difference_per_rad = 0.3;
    let lift = pressure * 0.5 * fin.area_m2 * 0.3 * 0.1;
    let found = rolling_moment(&steeper);
    assert!((found + lift * 0.05).abs() < 1e-9 * lift, "roll moment {found} N m for {lift} N at 0.05 m");
}

#[test]
fn halves_apart_damp_roll_and_keep_the_total_force() {
    let mut p = rig();
    let one = Plant::new(&p, Fidelity::NUMERICAL).unwrap();
    p.asymmetry.offset_lateral_m = 0.05;
    let two = Plant::new(&p, Fidelity::NUMERICAL).unwrap();
    let relative = [0.245, 0.0, 0.03];
    let [(f_one, m_one), (f_two, m_two)] = [&one, &two].map(|plant| aerodynamic_wrench(plant, relative, [0.0; 3]));
    for k in 0..3 {
        assert!(
            (f_one[k] - f_two[k]).abs() < 1e-15 && (m_one[k] - m_two[k]).abs() < 1e-15,
            "axis {k} without rotation"
        );
    }
    let damping = |plant: &Plant| aerodynamic_wrench(plant, relative, [0.5, 0.0, 0.0]).1[0];
    assert!(damping(&two) < damping(&one) - 1e-5, "a roll rate meets more: {} and {}", damping(&two), damping(&one));
}

#[test]
fn longer_port_line_lowers_starboard_at_equal_winches() {
    let mut p = rig();
    p.asymmetry.line_port_m = 0.004;
    let plant = Plant::new(&p, Fidelity::STALLED_WITH_ADDED_MASS).unwrap();
    let [length, _, roll] = driven_of_lines(&plant, [0.6; 3]);
    assert!((length - 0.6 - 0.004 / 3.0).abs() < 1e-15, "mean length {length}");
    assert!((roll - (0.004_f64 / p.tether.separation_lateral_m).atan()).abs() < 1e-15, "roll {roll}");
    let flow = Flow::straight(0.245);
    let request = TrimRequest { flow, pitch_rad: 0.2, height: TrimHeight::Altitude(0.61) };
    let seen = sight(&plant, &trim(&plant, &request).unwrap().state, &flow);
    assert!(seen.roll_rad > 0.02 && (seen.pitch_rad - 0.2).abs() < 1e-10, "{seen:?}");
}

#[test]
fn trim_without_a_branch_says_so() {
    let mut p = rig();
    // Ten times what the lines can hold upright.
    p.asymmetry.center_of_mass_y_m = 3.0;
    let plant = Plant::new(&p, Fidelity::NUMERICAL).unwrap();
    let request = TrimRequest { flow: Flow::straight(0.245), pitch_rad: 0.2, height: TrimHeight::Altitude(0.61) };
    let error = trim(&plant, &request).unwrap_err();
    assert!(matches!(error, Error::NoTrim(NoTrim::NoBalance { .. })), "{error:?}");
    assert!(error.to_string().contains("without its asymmetry"), "{error}");
}

#[test]
fn numbers_that_no_plant_has_are_refused_by_name() {
    for field in OPTIONAL_FIELDS {
        let mut p = rig();
        (field.set)(&mut p, f64::NAN);
        let error = Plant::new(&p, Fidelity::NUMERICAL).unwrap_err().to_string();
        assert!(error.starts_with(&format!("asymmetry.{} = NaN", field.name)), "{error}");
    }
    type Change = fn(&mut Asymmetry);
    let cases: [(Change, &str); 4] = [
        (|a| a.offset_lateral_m = -0.01, "offset_lateral"),
        (|a| a.incidence_difference_rad = 3.2, "incidence_difference"),
        (|a| a.inertia_xy_kg_m2 = 2e-4, "inertia_xy"),
        (|a| a.inertia_yz_kg_m2 = -2e-4, "inertia_yz"),
    ];
    for (change, name) in cases {
        let mut p = rig();
        change(&mut p.asymmetry);
        let error = Plant::new(&p, Fidelity::NUMERICAL).unwrap_err().to_string();
        assert!(error.starts_with(&format!("asymmetry.{name} = ")), "{error}");
    }
    // Each product possible by itself, together not.
    let mut p = rig();
    (p.body.inertia_xx_kg_m2, p.body.inertia_yy_kg_m2, p.body.inertia_zz_kg_m2) = (2.0, 2.0, 2.0);
    p.body.inertia_xz_kg_m2 = 0.8;
    (p.asymmetry.inertia_xy_kg_m2, p.asymmetry.inertia_yz_kg_m2) = (0.8, 0.8);
    Plant::new(&p, Fidelity::NUMERICAL).unwrap();
    p.asymmetry.inertia_yz_kg_m2 = -0.8;
    let error = Plant::new(&p, Fidelity::NUMERICAL).unwrap_err().to_string();
    assert!(error.contains("no mass has this inertia"), "{error}");
}

/// Masses in a plane have second moments of determinant zero: products that are a little larger belong to no mass.
#[test]
fn products_of_inertia_end_where_all_mass_lies_in_a_plane() {
    // Second moments about a plane with the normal n are 1 - n n': moments of inertia are sums of two of their diagonal.
    for n in [[2.0, -1.0, 3.0], [2.0, 1.0, 3.0], [1.0, 3.0, -2.0], [3.0, 2.0, 2.0]].map(nalgebra::Vector3::<f64>::from)
    {
        let second: nalgebra::Matrix3<f64> = nalgebra::Matrix3::identity() - n * n.transpose() / n.norm_squared();
        let with = |share: f64| {
            let mut p = rig();
            let diagonal = second.diagonal();
            p.body.inertia_xx_kg_m2 = diagonal[1] + diagonal[2];
            p.body.inertia_yy_kg_m2 = diagonal[0] + diagonal[2];
            p.body.inertia_zz_kg_m2 = diagonal[0] + diagonal[1];
            p.body.inertia_xz_kg_m2 = share * second[(0, 2)];
            p.asymmetry.inertia_xy_kg_m2 = share * second[(0, 1)];
            p.asymmetry.inertia_yz_kg_m2 = share * second[(1, 2)];
            Plant::new(&p, Fidelity::NUMERICAL)
        };
        assert!(with(0.999).is_ok(), "{n}");
        assert!(with(1.001).unwrap_err().to_string().contains("no mass has this inertia"), "{n}");
    }
}
