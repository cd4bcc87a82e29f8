//! Ballast and fins of a rig that move along with its design.

use bat_dynamics::{Ballast, Fidelity, Fin, MassModel, Parameters};
use water_channel::{FlightRequest, Masses, Rig, RigFile};

use crate::rigs::{assert_close, cost, flown, short_test, text};

const BALLAST: &str = r#"
[masses.ballast]
mass = { value = 40.0, unit = "g", provenance = "estimated", source = "a test" }
x = { value = 30.0, unit = "% chord", provenance = "estimated", source = "a test" }
height = { value = 2.0, unit = "cm", provenance = "estimated", source = "a test" }
"#;

const FIN: &str = r#"
[masses.vertical_stabilizer]
mass = { value = 3.0, unit = "g", provenance = "estimated", source = "a test" }
volume = { value = 2.5e-6, unit = "m^3", provenance = "estimated", source = "a test" }
offset_x = { value = 12.0, unit = "% chord", provenance = "estimated", source = "a test" }
offset_height = { value = 2.5, unit = "cm", provenance = "estimated", source = "a test" }
inertia_xx = { value = 2.0e-7, unit = "kg*m^2", provenance = "estimated", source = "a test" }
inertia_yy = { value = 3.0e-7, unit = "kg*m^2", provenance = "estimated", source = "a test" }
inertia_zz = { value = 1.0e-7, unit = "kg*m^2", provenance = "estimated", source = "a test" }
"#;

fn with(more: &str) -> Result<RigFile, String> {
    RigFile::parse(&(text("bat/rig.toml") + more)).map_err(|error| error.to_string())
}

fn at(rig: &Rig, center_of_mass_x: f64, vertical_area_factor: f64) -> Parameters {
    let mut rig = rig.clone();
    rig.plant.body.center_of_mass_x = center_of_mass_x;
    rig.plant.vertical_stabilizer.area_factor = vertical_area_factor;
    rig.parameters().unwrap()
}

#[test]
fn section_is_read_in_its_units_and_may_be_left_out_by_body() {
    let plain = with("").unwrap();
    assert_eq!(plain.rig.masses, None, "no section");
    assert_eq!(plain.rig.parameters().unwrap(), plain.rig.plant, "nothing moves by itself");
    let rig = with(&(BALLAST.to_owned() + FIN)).unwrap();
    let ballast = Some(Ballast { mass_kg: 0.04, x: 0.3, y_m: 0.0, height_m: 0.02 });
    let vertical = Some(Fin {
        mass_kg: 0.003,
        volume_m3: 2.5e-6,
        offset_x: 0.12,
        offset_height_m: 0.025,
        offset_lateral_m: 0.0,
        inertia_kg_m2: [2e-7, 3e-7, 1e-7],
        inertia_xz_kg_m2: 0.0,
    });
    let model = MassModel { ballast, horizontal: None, vertical };
    let center_of_mass_x = plain.rig.plant.body.center_of_mass_x;
    assert_eq!(rig.rig.masses, Some(Masses { model, center_of_mass_x }), "both bodies");
    assert_eq!(rig.rig.plant, plain.rig.plant, "what stands in the file");
    assert_eq!(rig.records.len(), plain.records.len() + 10, "a record per number");
    assert_eq!(with("\n[masses]\n").unwrap().rig.parameters().unwrap(), plain.rig.plant, "an empty section");
}

#[test]
fn shifted_ballast_moves_the_inertia_by_parallel_axes() {
    let rig = with(BALLAST).unwrap().rig;
    let Parameters { body: old, .. } = rig.plant;
    let new = at(&rig, old.center_of_mass_x + 0.03, 1.0).body;
    // By hand: 40 g of 180 g go aft until the center of mass has gone 3 % of 75 mm.
    let (moved, all, shift) = (0.04, old.mass_kg, 0.03 * old.chord_m);
    let travel = all / moved * shift;
    // Forward of the old center of mass, below it.
    let ahead = (old.center_of_mass_x - 0.3) * old.chord_m;
    let below = old.center_of_mass_height_m - 0.02;
    let change = moved * ((ahead - travel).powi(2) - ahead.powi(2)) - all * shift.powi(2);
    assert_close(new.inertia_yy_kg_m2 - old.inertia_yy_kg_m2, change, 1e-15, "pitch");
    assert_close(new.inertia_zz_kg_m2 - old.inertia_zz_kg_m2, change, 1e-15, "yaw");
    assert_close(new.inertia_xx_kg_m2, old.inertia_xx_kg_m2, 1e-15, "roll");
    // With x forward and z down, the ballast's product x z falls by its travel times its depth.
    let product = (new.inertia_xz_kg_m2 - old.inertia_xz_kg_m2).abs();
    assert_close(product, moved * travel * below, 1e-15, "product");
    assert_eq!((new.mass_kg, new.volume_m3), (old.mass_kg, old.volume_m3), "nothing is added");
    assert_close(new.center_of_mass_height_m, old.center_of_mass_height_m, 1e-15, "height");
}

#[test]
fn larger_fin_weighs_and_floats_more() {
    let rig = with(FIN).unwrap().rig;
    let (old, new) = (at(&rig, 0.461, 1.0).body, at(&rig, 0.461, 3.0).body);
    assert_close(new.mass_kg - old.mass_kg, 2.0 * 0.003, 1e-15, "mass");
    assert_close(new.volume_m3 - old.volume_m3, 2.0 * 2.5e-6, 1e-18, "volume");
    assert!(new.center_of_buoyancy_x > old.center_of_buoyancy_x, "the fin floats aft");
    assert_close(new.center_of_mass_x, 0.461, 0.0, "the design's center of mass is the body's");
    let mut grown = rig;
    (grown.plant.body.center_of_mass_x, grown.plant.vertical_stabilizer.area_factor) = (0.461, 3.0);
    let expected = 100.0 * (0.461 - new.center_of_buoyancy_x);
    assert_close(grown.ballast_pct_chord(), expected, 1e-12, "what (21) weighs");
}

#[test]
fn design_is_made_of_the_file_whatever_was_asked_before() {
    let rig = with(&(BALLAST.to_owned() + FIN)).unwrap().rig;
    let aft = at(&rig, 0.50, 2.0);
    let mut there_and_back = rig.clone();
    there_and_back.plant.body.center_of_mass_x = 0.44;
    assert_eq!(at(&there_and_back, 0.50, 2.0), aft, "no trace of the design before");
    // As it was read it is what the file says, but for rounding.
    let (same, plant) = (rig.parameters().unwrap().body, rig.plant.body);
    assert_close(same.inertia_yy_kg_m2, plant.inertia_yy_kg_m2, 1e-15, "inertia");
    assert_close(same.mass_kg, plant.mass_kg, 1e-15, "mass");
}

#[test]
fn flight_feels_what_moves() {
    let test = short_test(10.0);
    let cost_of = |more: &str, center_of_mass_x: f64| {
        let mut rig = with(more).unwrap().rig;
        rig.plant.body.center_of_mass_x = center_of_mass_x;
        cost(&flown(&FlightRequest { rig, fidelity: Fidelity::STALLED_WITH_ADDED_MASS }, &test, 1))
    };
    let at_home = with("").unwrap().rig.plant.body.center_of_mass_x;
    assert_close(cost_of(BALLAST, at_home), cost_of("", at_home), 1e-9, "ballast in its place");
    let (moved, set) = (cost_of(BALLAST, 0.50), cost_of("", 0.50));
    assert!((moved / set - 1.0).abs() > 1e-4, "{moved} and {set}");
}

#[test]
fn masses_that_cannot_be_are_named() {
    let error = |from: &str, to: &str| with(&(BALLAST.to_owned() + FIN).replacen(from, to, 1)).unwrap_err();
    let said = error("value = 40.0", "value = -40.0");
    assert!(said.starts_with("`masses.ballast.mass` is -40 g"), "{said}");
    let said = error("height =", "hieght =");
    assert!(said.starts_with("unknown key `masses.ballast.hieght`"), "{said}");
    let said = error("[masses.ballast]", "[masses.balast]");
    assert!(said.starts_with("unknown key `masses.balast`"), "{said}");
    // More than all of the body.
    let said = error("value = 40.0", "value = 400.0");
    assert!(said.contains("mass"), "{said}");
    let factor =
        text("bat/rig.toml").replacen("area_factor = { value = 1.0", "area_factor = { value = 2.0", 1) + BALLAST;
    let said = RigFile::parse(&factor).unwrap_err().to_string();
    assert!(said.starts_with("`plant.horizontal_stabilizer.area_factor` is 2: it must be 1"), "{said}");
    // A design without room for its ballast is refused where it is flown.
    let mut rig = with(BALLAST).unwrap().rig;
    rig.plant.body.center_of_mass_x = f64::NAN;
    assert!(rig.plant(Fidelity::NUMERICAL).is_err(), "no number");
}
