//! Files: what is read, and that each mistake is named with its file, its key, what was found and what is allowed.

use bat_dynamics::Fidelity;
use water_channel::{CostFile, FileError, FlightRequest, ProfileFile, Provenance, RigFile};

use crate::rigs::{assert_close, cost, first_row, fixture, flown, text};

/// The text with the first `from` replaced by `to`.
#[track_caller]
fn edited(name: &str, from: &str, to: &str) -> String {
    let text = text(name);
    assert!(text.contains(from), "`{from}` is not in {name}");
    text.replacen(from, to, 1)
}

/// The text without one key.
fn without(name: &str, keys: &[&str]) -> String {
    let mut table: toml::Table = text(name).parse().unwrap();
    let (last, sections) = keys.split_last().unwrap();
    let section = sections.iter().fold(&mut table, |table, key| table[*key].as_table_mut().unwrap());
    assert!(section.remove(*last).is_some(), "`{last}` is not in {name}");
    table.to_string()
}

#[track_caller]
fn check<T: std::fmt::Debug>(result: Result<T, FileError>, message: &str) {
    match result {
        Ok(read) => panic!("read without an error: {read:?}"),
        Err(error) => assert_eq!(error.to_string(), message, "{error:?}"),
    }
}

#[track_caller]
fn rig(from: &str, to: &str, message: &str) {
    check(RigFile::parse(&edited("bat/rig.toml", from, to)), message);
}

#[track_caller]
fn profile(from: &str, to: &str, message: &str) {
    check(ProfileFile::parse(&edited("bat/test-profile.toml", from, to)), message);
}

#[track_caller]
fn weights(from: &str, to: &str, message: &str) {
    check(CostFile::parse(&edited("bat/cost-chapter4.toml", from, to)), message);
}

const MASS: &str = r#"mass = { value = 0.18, unit = "kg", provenance = "given", source = "Table 2, model 2" }"#;
const FORM: &str = "a table { value, unit, provenance, source }";

#[test]
fn every_fixture_reads_with_its_provenance() {
    let rig = RigFile::read(fixture("bat/rig.toml")).unwrap();
    assert_eq!(rig.title, "Buoyant Air Turbine, 1/100, water channel");
    assert_eq!(rig.records.len(), bat_dynamics::FIELDS.len() + 13, "a record per number");
    let mass = rig.records.iter().find(|record| record.key == "plant.body.mass").unwrap();
    assert_eq!((mass.unit.as_str(), mass.provenance), ("kg", Provenance::Given));
    assert_eq!(mass.source, "Table 2, model 2");
    assert_close(rig.rig.plant.body.joint_x, 0.4642848, 1e-15, "a position in per cent of chord");
    assert_close(rig.rig.set_points.pitch_rad, 17.3_f64.to_radians(), 1e-15, "an angle in degrees");

    let profile = ProfileFile::read(fixture("bat/test-profile.toml")).unwrap();
    assert_close(profile.profile.duration_s(), 300.0, 0.0, "duration");
    assert_eq!(profile.profile.flow().knots().len(), 3, "speeds");
    assert_eq!(profile.profile.windows().len(), 6, "windows");
    assert!(profile.records.iter().all(|record| record.provenance == Provenance::Given), "{:?}", profile.records);

    let cost = CostFile::read(fixture("bat/cost-chapter4.toml")).unwrap();
    assert_eq!(cost.records.len(), 7, "weights");
    assert!(cost.records.iter().all(|record| record.provenance == Provenance::Calibrated), "{:?}", cost.records);
}

#[test]
fn unknown_key_is_an_error_at_every_level() {
    rig(
        "title =",
        "titel = \"x\"\ntitle =",
        "unknown key `titel` (is it `title`?); known here: controller, masses, plant, sensing, title",
    );
    rig(
        "[plant.winch]",
        "[plant.motor]\n[plant.winch]",
        "unknown key `plant.motor`; known here: added_mass, asymmetry, body, fluid, horizontal_stabilizer, hull, stall, tether, \
         vertical_stabilizer, winch",
    );
    rig(
        "[plant.fluid]",
        "[plant.fluid]\nviscosity = 1",
        "unknown key `plant.fluid.viscosity`; known here: density, gravity",
    );
    rig(
        MASS,
        &MASS.replace("source", "note = \"\", source"),
        "unknown key `plant.body.mass.note`; known here: provenance, source, unit, value",
    );
    rig(
        "[controller.pitch]",
        "[controller.pitch]\nintegral = 0",
        "unknown key `controller.pitch.integral`; known here: derivative, proportional, time_constant",
    );
    rig(
        "[controller.pitch]",
        "[controller.yaw]\n[controller.pitch]",
        "unknown key `controller.yaw`; known here: altitude, altitude_set_point, pitch, pitch_set_point, roll, \
         roll_set_point, sample_time",
    );
    profile(
        "[[flow]]",
        "[[flow]]\nturbulence = 0.1",
        "unknown key `flow[0].turbulence`; known here: direction, from, \
         speed, transition",
    );
    profile(
        "port =",
        "prot = 1\nport =",
        "unknown key `window[0].prot` (is it `port`?); known here: center, from, port, starboard, to",
    );
    profile(
        "duration =",
        "begin = 0\nduration =",
        "unknown key `begin`; known here: control, duration, flow, start, title, turbine, water, window",
    );
    weights(
        "k7_ballast =",
        "k8 = 0\nk7_ballast =",
        "unknown key `k8`; known here: k1_heading, k2_pitch, k3_roll, k4_altitude, k5_reel_speed, k6_zenith, \
         k7_ballast, k8_net_energy, title",
    );
}

#[test]
fn slip_in_a_key_is_pointed_at() {
    let pointed_at = |result: Result<(), FileError>, key: &str, meant: &str| {
        let message = result.unwrap_err().to_string();
        assert!(message.starts_with(&format!("unknown key `{key}` (is it `{meant}`?); known here: ")), "{message}");
    };
    let rig = RigFile::parse(&edited("bat/rig.toml", "mass =", "mas ="));
    pointed_at(rig.map(drop), "plant.body.mas", "mass");
    let rig = RigFile::parse(&edited("bat/rig.toml", "[plant.stall]", "[plant.stal]"));
    pointed_at(rig.map(drop), "plant.stal", "stall");
    let weights = CostFile::parse(&edited("bat/cost-chapter4.toml", "k3_roll", "k3_rol"));
    pointed_at(weights.map(drop), "k3_rol", "k3_roll");
    let profile = ProfileFile::parse(&edited("bat/test-profile.toml", "speed =", "sped ="));
    pointed_at(profile.map(drop), "flow[0].sped", "speed");
}

#[test]
fn missing_key_is_named_with_what_should_stand_there() {
    rig(MASS, "", &format!("missing key `plant.body.mass`: {FORM}"));
    rig(MASS, &MASS.replace("value = 0.18, ", ""), "missing key `plant.body.mass.value`: a number");
    rig(MASS, &MASS.replace("unit = \"kg\", ", ""), "missing key `plant.body.mass.unit`: a text");
    rig(
        MASS,
        &MASS.replace("provenance = \"given\", ", ""),
        "missing key `plant.body.mass.provenance`: given, derived, estimated or calibrated",
    );
    rig(MASS, &MASS.replace(", source = \"Table 2, model 2\"", ""), "missing key `plant.body.mass.source`: a text");
    rig(
        "layout = \"one-forward-two-aft\"",
        "",
        "missing key `plant.tether.layout`: one-forward-two-aft or two-forward-one-aft",
    );
    check(RigFile::parse(&without("bat/rig.toml", &["plant", "stall"])), "missing key `plant.stall`: a table");
    check(RigFile::parse(&without("bat/rig.toml", &["controller", "roll"])), "missing key `controller.roll`: a table");
    let missing = |key| format!("missing key `{key}`: {FORM}");
    check(ProfileFile::parse(&without("bat/test-profile.toml", &["duration"])), &missing("duration"));
    check(CostFile::parse(&without("bat/cost-chapter4.toml", &["k3_roll"])), &missing("k3_roll"));
    profile("from =", "# from =", &missing("flow[0].from"));
    check(
        ProfileFile::parse(
            "title = \"no flow\"\nduration = { value = 1, unit = \"s\", provenance = \"given\", source = \"\" }",
        ),
        "missing key `flow`: at least one table [[flow]] with `from`, `speed` and `direction`",
    );
}

#[test]
fn wrong_unit_is_named_with_the_units_that_are_understood() {
    let with = |unit: &str| MASS.replace("\"kg\"", &format!("\"{unit}\""));
    rig(MASS, &with("lb"), "`plant.body.mass` is in the unit `lb`: it must be in `kg` or `g`");
    rig(MASS, &with("m"), "`plant.body.mass` is in the unit `m`: it must be in `kg` or `g`");
    rig(MASS, &with(""), "`plant.body.mass` is in the unit ``: it must be in `kg` or `g`");
    rig(
        "value = 46.42848, unit = \"% chord\"",
        "value = 46.42848, unit = \"%\"",
        "`plant.body.joint_x` is in the unit `%`: it must be in `chord` or `% chord`",
    );
    profile(
        "unit = \"deg\"",
        "unit = \"degree\"",
        "`flow[0].direction` is in the unit `degree`: it must be in `rad` or `deg`",
    );
    profile("unit = \"u_max\"", "unit = \"m/s\"", "`window[0].port` is in the unit `m/s`: it must be in `u_max`");
}

#[test]
fn wrong_type_is_named() {
    rig(MASS, "mass = 0.18", &format!("`plant.body.mass` is 0.18: it must be {FORM}"));
    rig(MASS, &MASS.replace("0.18", "\"0.18\""), "`plant.body.mass.value` is \"0.18\": it must be a number");
    rig(MASS, &MASS.replace("\"kg\"", "1"), "`plant.body.mass.unit` is 1: it must be a text");
    rig("title = \"Buoyant Air Turbine, 1/100, water channel\"", "title = 1", "`title` is 1: it must be a text");
    rig(
        "layout = \"one-forward-two-aft\"",
        "layout = \"sideways\"",
        "`plant.tether.layout` is \"sideways\": it must be one-forward-two-aft or two-forward-one-aft",
    );
    rig(
        MASS,
        &MASS.replace("\"given\"", "\"guessed\""),
        "`plant.body.mass.provenance` is \"guessed\": it must be given, derived, estimated or calibrated",
    );
    profile(
        "[[flow]]",
        "[[flow]]\ntransition = \"spline\"",
        "`flow[0].transition` is \"spline\": it must be step or linear",
    );
    check(
        ProfileFile::parse(
            "title = \"t\"\nflow = 1\nduration = { value = 1, unit = \"s\", provenance = \"given\", source = \"\" }",
        ),
        "`flow` is 1: it must be an array of tables",
    );
}

#[test]
fn number_out_of_range_is_named_with_what_is_allowed() {
    rig(
        "pitch_set_point = { value = 17.3",
        "pitch_set_point = { value = 95",
        "`controller.pitch_set_point` is 95 deg: it must be finite and short of a quarter turn to either side",
    );
    let mass = |value: &str| MASS.replace("0.18", value);
    rig(MASS, &mass("-0.18"), "`plant.body.mass` is -0.18 kg: it must be finite and more than zero");
    rig(MASS, &mass("nan"), "`plant.body.mass` is NaN kg: it must be finite and more than zero");
    rig(MASS, &mass("inf"), "`plant.body.mass` is inf kg: it must be finite and more than zero");
    rig(MASS, &mass("0"), "`plant.body.mass` is 0 kg: it must be finite and more than zero");
    rig(
        "hull = { value = 0.2839866",
        "hull = { value = 1.6",
        "`plant.stall.hull` is 1.6 rad: it must be more than 0 and at most pi/2 rad",
    );
    rig(
        "inertia_xx = { value = 0.0003598505",
        "inertia_xx = { value = 9e-4",
        "body.inertia_xx = 0.0009 kg*m^2: it must be at most the sum of the other two moments of inertia",
    );
    rig(
        "sample_time = { value = 0.025",
        "sample_time = { value = 0.0",
        "`controller.sample_time` is 0 s: it must be finite and more than zero",
    );
    rig(
        "time_constant = { value = 0.1025573",
        "time_constant = { value = -0.1025573",
        "`controller.pitch.time_constant` is -0.1025573 s: it must be finite and more than zero",
    );
    profile("value = 0.205", "value = -0.205", "`flow[0].speed` is -0.205 m/s: it must be finite and zero or more");
    profile("value = -1.0", "value = -1.01", "`window[0].port` is -1.01 u_max: it must be within -1 and 1");
    weights(
        "value = 9.672002",
        "value = -9.672002",
        "`k2_pitch` is -9.672002 1/rad^2: it must be finite and zero or more",
    );
    weights("value = 9.672002", "value = nan", "`k2_pitch` is NaN 1/rad^2: it must be finite and zero or more");
}

#[test]
fn numbers_that_do_not_fit_together_are_named() {
    profile("to = { value = 21.0", "to = { value = 19.0", "`window[0].to` is 19 s: it must be not before `from`");
    profile("from = { value = 0.0", "from = { value = 5.0", "`flow[0].from` is 5 s: it must be 0 in the first entry");
    profile(
        "from = { value = 200.0",
        "from = { value = 100.0",
        "`flow[2].from` is 100 s: it must be later than in the entry before",
    );
    profile(
        "from = { value = 200.0",
        "from = { value = 301.0",
        "`flow[2].from` is 301 s: it must be within `duration`",
    );
    profile(
        "from = { value = 220.0",
        "from = { value = 320.0",
        "`window[4].from` is 320 s: it must be within `duration`",
    );
}

#[test]
fn error_names_the_file_that_could_not_be_read() {
    let missing = fixture("bat/no-such-rig.toml");
    let error = RigFile::read(&missing).unwrap_err();
    assert!(matches!(error, FileError::Read { .. }), "{error:?}");
    assert!(error.to_string().starts_with(&format!("{missing}: ")), "{error}");
    check(RigFile::parse("title = "), &RigFile::parse("title = ").unwrap_err().to_string());
    let error = RigFile::parse("title = ").unwrap_err();
    assert!(error.to_string().starts_with("not a TOML file: "), "{error}");
}

#[test]
fn error_in_a_file_names_the_file() {
    let path = fixture("bat/cost-chapter4.toml");
    check(
        ProfileFile::read(&path),
        &format!(
            "{path}: unknown key `k1_heading`; known here: control, duration, flow, start, title, turbine, water, window"
        ),
    );
}

#[test]
fn units_of_a_file_read_to_the_same_rig() {
    let original = RigFile::parse(&text("bat/rig.toml")).unwrap();
    let mut other = text("bat/rig.toml");
    for (from, to) in [
        ("value = 0.18, unit = \"kg\"", "value = 180, unit = \"g\""),
        ("value = 0.075, unit = \"m\"", "value = 7.5, unit = \"cm\""),
        ("value = 0.04078304, unit = \"m\"", "value = 40.78304, unit = \"mm\""),
        ("value = 46.42848, unit = \"% chord\"", "value = 0.4642848, unit = \"chord\""),
        ("value = 17.3, unit = \"deg\"", "value = 0.30194196059501904, unit = \"rad\""),
        ("value = 0.0002352291, unit = \"m^3\"", "value = 235.2291, unit = \"cm^3\""),
        ("value = 0.0075, unit = \"m^2\"", "value = 75.0, unit = \"cm^2\""),
        ("value = 0.001, unit = \"kg/m\"", "value = 1.0, unit = \"g/m\""),
        ("value = 0.01030184, unit = \"m/s\"", "value = 10.30184, unit = \"mm/s\""),
        ("value = 0.025, unit = \"s\"", "value = 25, unit = \"ms\""),
        ("value = 2.472415, unit = \"1/rad\"", "value = 0.0431517822256956, unit = \"1/deg\""),
    ] {
        assert!(other.contains(from), "`{from}` is not in the rig file");
        other = other.replacen(from, to, 1);
    }
    let other = RigFile::parse(&other).unwrap();
    for field in bat_dynamics::FIELDS {
        let (found, expected) = ((field.get)(&other.rig.plant), (field.get)(&original.rig.plant));
        // A factor may cost the last bit.
        assert_close(found, expected, 1e-15 * expected.abs(), field.name);
    }
    let (found, expected) = (other.rig, original.rig);
    assert_close(found.set_points.pitch_rad, expected.set_points.pitch_rad, 1e-15, "pitch set point");
    assert_close(found.sample_time_s, expected.sample_time_s, 1e-17, "sample time");
}

#[test]
fn rig_that_is_read_flies_at_any_sample_time() {
    let test = crate::rigs::short_test(10.0);
    let reference = cost(&flown(&first_row(), &test, 2));
    for (sample_time, apart) in [("0.01", 0.1), ("0.05", 0.2)] {
        let text = edited("bat/rig.toml", "value = 0.025", &format!("value = {sample_time}"));
        let request = FlightRequest { rig: RigFile::parse(&text).unwrap().rig, fidelity: Fidelity::NUMERICAL };
        assert_close(request.rig.sample_time_s, sample_time.parse().unwrap(), 0.0, "sample time");
        // Another sampling is another flight, of about the same cost.
        assert_close(cost(&flown(&request, &test, 2)), reference, apart * reference, "cost");
    }
}

/// A rig file with a table of what sets starboard apart from port.
fn lopsided(keys: &str) -> Result<RigFile, FileError> {
    RigFile::parse(&(text("bat/rig.toml") + "\n[plant.asymmetry]\n" + keys))
}

#[test]
fn asymmetry_may_be_left_out_by_table_and_by_key_and_is_checked_where_it_stands() {
    use bat_dynamics::{Asymmetry, OPTIONAL_FIELDS};
    let none = RigFile::parse(&text("bat/rig.toml")).unwrap();
    assert_eq!(none.rig.plant.asymmetry, Asymmetry::default(), "a file without the table");
    assert_eq!(lopsided("").unwrap().rig, none.rig, "an empty table");
    let some = lopsided(
        r#"line_port = { value = 2.0, unit = "mm", provenance = "estimated", source = "a knot" }
        incidence_difference = { value = 3.0, unit = "deg", provenance = "estimated", source = "bent" }"#,
    )
    .unwrap();
    let expected = Asymmetry { line_port_m: 2e-3, incidence_difference_rad: 3f64.to_radians(), ..Asymmetry::default() };
    assert_eq!(some.rig.plant.asymmetry, expected, "two keys, the others zero");
    assert_eq!(some.records.len(), none.records.len() + 2, "a record per number");
    for field in OPTIONAL_FIELDS {
        let wrong = format!("{} = {{ value = 1.0, unit = \"K\", provenance = \"given\", source = \"-\" }}", field.name);
        let key = format!("`plant.asymmetry.{}` is in the unit `K`", field.name);
        let error = lopsided(&wrong).unwrap_err().to_string();
        assert!(error.starts_with(&key), "{error}");
    }
    let slip = r#"line_prot = { value = 2.0, unit = "mm", provenance = "estimated", source = "a knot" }"#;
    let error = lopsided(slip).unwrap_err().to_string();
    assert!(error.starts_with("unknown key `plant.asymmetry.line_prot` (is it `line_port`?)"), "{error}");
    let inside = r#"offset_lateral = { value = -0.01, unit = "m", provenance = "estimated", source = "-" }"#;
    let error = lopsided(inside).unwrap_err().to_string();
    assert_eq!(error, "`plant.asymmetry.offset_lateral` is -0.01 m: it must be finite and zero or more");
}
