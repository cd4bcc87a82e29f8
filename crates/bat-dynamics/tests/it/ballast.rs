//! Ballast and fins that weigh something: sums over point masses by numpy, parallel axes, and what stays as it was.

use bat_dynamics::{Ballast, Fin, MassModel, Parameters, PlantDesign};
use serde_json::Value;

use crate::plants::rig;

fn array<const N: usize>(value: &Value) -> [f64; N] {
    let numbers: Vec<f64> = value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
    numbers.try_into().unwrap()
}

fn fin(of: &Value) -> Fin {
    let [x, y, height] = array(&of["offset"]);
    Fin {
        mass_kg: of["mass"].as_f64().unwrap(),
        volume_m3: of["volume"].as_f64().unwrap(),
        offset_x: x,
        offset_height_m: height,
        offset_lateral_m: y,
        inertia_kg_m2: array(&of["moments"]),
        inertia_xz_kg_m2: of["product_xz"].as_f64().unwrap(),
    }
}

fn base(case: &Value) -> Parameters {
    let body = &case["base"];
    let mut p = rig();
    p.body.mass_kg = body["mass"].as_f64().unwrap();
    p.body.volume_m3 = body["volume"].as_f64().unwrap();
    let [x, y, height] = array(&body["center"]);
    (p.body.center_of_mass_x, p.asymmetry.center_of_mass_y_m, p.body.center_of_mass_height_m) = (x, y, height);
    let [x, _, height] = array(&body["buoyancy"]);
    (p.body.center_of_buoyancy_x, p.body.center_of_buoyancy_height_m) = (x, height);
    let [xx, yy, zz] = array(&body["moments"]);
    (p.body.inertia_xx_kg_m2, p.body.inertia_yy_kg_m2, p.body.inertia_zz_kg_m2) = (xx, yy, zz);
    let [xy, yz, xz] = array(&body["products"]);
    (p.asymmetry.inertia_xy_kg_m2, p.asymmetry.inertia_yz_kg_m2, p.body.inertia_xz_kg_m2) = (xy, yz, xz);
    let [x, _, height] = array(&case["horizontal"]["root"]);
    (p.horizontal_stabilizer.root_x, p.horizontal_stabilizer.root_height_m) = (x, height);
    let [x, _, height] = array(&case["vertical"]["root"]);
    (p.vertical_stabilizer.root_x, p.vertical_stabilizer.root_height_m) = (x, height);
    p
}

#[test]
fn designs_are_the_sums_over_point_masses_of_numpy() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/bat-dynamics/ballast.json");
    let golden: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    for case in golden["cases"].as_array().unwrap() {
        let [mass_kg, x, y_m, height_m] = array(&case["ballast"]);
        let model = MassModel {
            ballast: Some(Ballast { mass_kg, x, y_m, height_m }),
            horizontal: Some(fin(&case["horizontal"])),
            vertical: Some(fin(&case["vertical"])),
        };
        let [horizontal, vertical] = array(&case["area_factors"]);
        let design = PlantDesign {
            center_of_mass_x: case["center_of_mass_x"].as_f64().unwrap(),
            horizontal_area_factor: horizontal,
            vertical_area_factor: vertical,
        };
        let p = model.parameters(&base(case), &design).unwrap();
        let expected = &case["design"];
        let [x, y, height] = array(&expected["center"]);
        let [cb_x, cb_y, cb_height] = array(&expected["buoyancy"]);
        let [xx, yy, zz] = array(&expected["moments"]);
        let [xy, yz, xz] = array(&expected["products"]);
        let (b, a) = (&p.body, &p.asymmetry);
        for (found, expected, scale) in [
            (b.mass_kg, expected["mass"].as_f64().unwrap(), 0.2),
            (b.volume_m3, expected["volume"].as_f64().unwrap(), 2e-4),
            (b.center_of_mass_x, x, 1.0),
            (a.center_of_mass_y_m, y, 0.1),
            (b.center_of_mass_height_m, height, 0.1),
            (b.center_of_buoyancy_x, cb_x, 1.0),
            (0.0, cb_y, 0.1),
            (b.center_of_buoyancy_height_m, cb_height, 0.1),
            (b.inertia_xx_kg_m2, xx, 1e-4),
            (b.inertia_yy_kg_m2, yy, 1e-4),
            (b.inertia_zz_kg_m2, zz, 1e-4),
            (b.inertia_xz_kg_m2, xz, 1e-4),
            (a.inertia_xy_kg_m2, xy, 1e-4),
            (a.inertia_yz_kg_m2, yz, 1e-4),
        ] {
            assert!((found - expected).abs() < 1e-12 * scale, "{}: {found} instead of {expected}", case["name"]);
        }
    }
}

#[test]
fn without_masses_a_design_moves_the_center_of_mass_and_the_areas_alone() {
    let design = PlantDesign { center_of_mass_x: 0.49, horizontal_area_factor: 1.2, vertical_area_factor: 0.9 };
    let mut expected = rig();
    expected.body.center_of_mass_x = 0.49;
    expected.horizontal_stabilizer.area_factor = 1.2;
    expected.vertical_stabilizer.area_factor = 0.9;
    assert_eq!(MassModel::default().parameters(&rig(), &design).unwrap(), expected);
}

#[test]
fn ballast_moved_aft_adds_inertia_by_the_theorem_of_parallel_axes() {
    let p = rig();
    let model = MassModel {
        ballast: Some(Ballast {
            mass_kg: 0.03,
            x: p.body.center_of_mass_x,
            y_m: 0.0,
            height_m: p.body.center_of_mass_height_m,
        }),
        ..MassModel::default()
    };
    let aft = 0.02;
    let design = PlantDesign {
        center_of_mass_x: p.body.center_of_mass_x + aft,
        horizontal_area_factor: 1.0,
        vertical_area_factor: 1.0,
    };
    let moved = model.parameters(&p, &design).unwrap();
    // The rest, 0.15 kg, stays; the ballast is 0.18/0.03 times as far from where it was: reduced mass times distance squared.
    let (m, rest) = (0.03, p.body.mass_kg - 0.03);
    let distance = aft * p.body.chord_m * p.body.mass_kg / m;
    let more = m * rest / p.body.mass_kg * distance * distance;
    for (found, expected) in [
        (moved.body.inertia_yy_kg_m2, p.body.inertia_yy_kg_m2 + more),
        (moved.body.inertia_zz_kg_m2, p.body.inertia_zz_kg_m2 + more),
        (moved.body.inertia_xx_kg_m2, p.body.inertia_xx_kg_m2),
        (moved.body.mass_kg, p.body.mass_kg),
        (moved.body.center_of_mass_height_m, p.body.center_of_mass_height_m),
    ] {
        assert!((found - expected).abs() < 1e-15, "{found} instead of {expected}");
    }
    assert!(more > 1e-6, "a change that counts: {more} kg m²");
}

/// The planform of a fin of twice the area is longer by the root of two, and its mass twice as large.
#[test]
fn products_of_inertia_of_a_fin_grow_by_the_square_of_its_area() {
    let (p, own, factor) = (rig(), 1e-8, 1.7);
    let product = |inertia_xz_kg_m2: f64| {
        let fin = Fin {
            mass_kg: 1e-3,
            volume_m3: 0.0,
            offset_x: 0.02,
            offset_height_m: 0.01,
            offset_lateral_m: 0.0,
            inertia_kg_m2: [4e-8; 3],
            inertia_xz_kg_m2,
        };
        let model = MassModel { vertical: Some(fin), ..MassModel::default() };
        let design = PlantDesign {
            center_of_mass_x: p.body.center_of_mass_x,
            horizontal_area_factor: 1.0,
            vertical_area_factor: factor,
        };
        model.parameters(&p, &design).unwrap().body.inertia_xz_kg_m2
    };
    let (found, expected) = (product(own) - product(0.0), (factor * factor - 1.0) * own);
    assert!((found - expected).abs() < 1e-6 * own, "{found} instead of {expected}: the fin of the body is taken off");
}

#[test]
fn masses_that_make_no_plant_are_refused_by_name() {
    let design = PlantDesign { center_of_mass_x: 0.49, horizontal_area_factor: 1.2, vertical_area_factor: 0.9 };
    let of = |mass_kg: f64, x: f64| MassModel {
        ballast: Some(Ballast { mass_kg, x, y_m: 0.0, height_m: 0.04 }),
        ..MassModel::default()
    };
    for (model, words) in [
        (of(0.0, 0.5), "mass of the ballast in kg = 0"),
        (of(0.02, f64::NAN), "place of the ballast = NaN"),
        // More inertia than the body has lies in a ballast so far away.
        (of(0.1, 2.0), "body.inertia"),
    ] {
        let error = model.parameters(&rig(), &design).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
    let error = MassModel::default().parameters(&rig(), &PlantDesign { horizontal_area_factor: -1.0, ..design });
    assert!(error.unwrap_err().to_string().contains("horizontal_stabilizer.area_factor = -1"), "a negative area");
}
