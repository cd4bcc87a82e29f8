//! Parameter files.

use scaling::{Conversion, DocumentOptions, Error, ScalingLaw, System, Units};

use crate::system;

/// The rig of the workspace, a file that this crate does not know.
const RIG: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/bat/rig.toml");

fn units() -> Units {
    let mut units = Units::si();
    units.define("% chord", "0.01").unwrap().define("u_max", "1").unwrap();
    units
}

fn full_scale() -> ScalingLaw {
    let system = system(&[("L", "m"), ("rho", "kg/m^3"), ("g", "m/s^2")]);
    system.law(&[("L", "100"), ("rho", "1.225/1000"), ("g", "1")]).unwrap()
}

fn convert(law: &ScalingLaw, text: &str) -> Result<Conversion, Error> {
    law.convert_document(&units(), text, &DocumentOptions::default())
}

#[test]
fn rig_returns_bit_for_bit_and_letter_for_letter() {
    let text = std::fs::read_to_string(RIG).unwrap();
    let there = convert(&full_scale(), &text).unwrap();
    let back = convert(&full_scale().inverse(), &there.text).unwrap();
    assert!(there.converted.len() > 60, "{} quantities", there.converted.len());
    assert_eq!(there.converted.len(), back.converted.len());
    for (there, back) in there.converted.iter().zip(&back.converted) {
        assert_eq!(there.path, back.path);
        assert_eq!(there.old.to_bits(), back.new.to_bits(), "{}", there.path);
        assert_eq!(there.new.to_bits(), back.old.to_bits(), "{}", there.path);
    }
    assert_eq!(back.text, text);
    assert_ne!(there.text, text);
}

#[test]
fn full_scale_rig_has_the_numbers_of_the_laws() {
    let text = std::fs::read_to_string(RIG).unwrap();
    let there = convert(&full_scale(), &text).unwrap();
    // Read by hand from the file, and converted by the laws: length 100, speed 10, time 10, mass 1225.
    for (path, unit, factor, old, new) in [
        ("plant.fluid.density", "kg/m^3", "49/40000", 1000.0_f64, 1.225_f64),
        ("plant.fluid.gravity", "m/s^2", "1", 9.81, 9.81),
        ("plant.body.chord", "m", "100", 0.075, 7.5),
        ("plant.body.mass", "kg", "1225", 0.18, 220.5),
        ("plant.body.inertia_xx", "kg*m^2", "12250000", 3.598505e-4, 4408.168625),
        ("plant.body.joint_x", "% chord", "1", 46.42848, 46.42848),
        ("plant.hull.lift_slope", "1/rad", "1", 2.472415, 2.472415),
        ("plant.tether.linear_density", "kg/m", "49/4", 0.001, 0.01225),
        ("plant.winch.speed_limit", "m/s", "10", 0.01030184, 0.1030184),
        ("controller.altitude.proportional", "1/s", "1/10", 0.2130322, 0.02130322),
        ("controller.pitch.proportional", "m/(s*rad)", "10", 0.03561544, 0.3561544),
        ("controller.pitch.derivative", "m/rad", "100", 0.01690292, 1.690292),
        ("controller.pitch_set_point", "deg", "1", 17.3, 17.3),
    ] {
        let found = there.converted.iter().find(|c| c.path == path).unwrap();
        assert_eq!((found.unit.as_str(), found.factor.to_string().as_str()), (unit, factor), "{path}");
        assert_eq!((found.old.to_bits(), found.new.to_bits()), (old.to_bits(), new.to_bits()), "{path}");
    }
}

#[test]
fn layout_comments_and_units_stay() {
    let text = r#"# On top.
title = "a rig"  # stays

[plant]   # a table
chord = { value = 7.5, unit = "cm", source = "ruler" } # behind
count = 3
mass   =   {value=1.8e-1,unit="kg"}
list = [ { value = 0.25, unit = "m" }, # in a list
         { value = 4, unit = "m/s^2" } ]
span = { value = [1.0, 2.5], unit = "mm" }
[plant.tether]
value = 0.61
unit = "m"
[[gain]]
kp = { value = 0.2, unit = "1/s" }
"#;
    let expected = r#"# On top.
title = "a rig"  # stays

[plant]   # a table
chord = { value = 750.0, unit = "cm", source = "ruler" } # behind
count = 3
mass   =   {value=2.205e2,unit="kg"}
list = [ { value = 25.0, unit = "m" }, # in a list
         { value = 4, unit = "m/s^2" } ]
span = { value = [100.0, 250.0], unit = "mm" }
[plant.tether]
value = 61.0
unit = "m"
[[gain]]
kp = { value = 0.02, unit = "1/s" }
"#;
    let there = convert(&full_scale(), text).unwrap();
    assert_eq!(there.text, expected);
    let paths: Vec<_> = there.converted.iter().map(|c| format!("{}.{}", c.path, c.key)).collect();
    assert_eq!(
        paths,
        [
            "plant.chord.value",
            "plant.mass.value",
            "plant.list[0].value",
            "plant.list[1].value",
            "plant.span.value[0]",
            "plant.span.value[1]",
            "plant.tether.value",
            "gain[0].kp.value",
        ]
    );
    assert_eq!(convert(&full_scale().inverse(), &there.text).unwrap().text, text);
}

#[test]
fn callers_rewrite_other_keys_of_the_same_table() {
    let text = "a = { value = 1.0, unit = \"m\", provenance = \"given\", source = \"Table 2\" } # a\n\
                b = { value = 1.0, unit = \"1\", provenance = \"given\", source = \"Table 3\" }\n";
    let rewrite = |converted: &scaling::Converted| {
        if converted.factor.is_one() {
            return vec![];
        }
        let source = converted.others.iter().find(|(key, _)| key == "source").map_or("", |(_, text)| text);
        vec![
            ("provenance".to_owned(), "derived".to_owned()),
            (
                "source".to_owned(),
                format!("scaled from {} {} by {}; {source}", converted.old, converted.unit, converted.factor),
            ),
        ]
    };
    let options = DocumentOptions { rewrite: Some(Box::new(rewrite)), ..DocumentOptions::default() };
    let there = full_scale().convert_document(&units(), text, &options).unwrap();
    assert_eq!(
        there.text,
        "a = { value = 100.0, unit = \"m\", provenance = \"derived\", source = \"scaled from 1 m by 100; Table 2\" } # a\n\
         b = { value = 1.0, unit = \"1\", provenance = \"given\", source = \"Table 3\" }\n"
    );
}

#[test]
fn other_value_keys_are_converted_on_request() {
    let text = "[[parameter]]\nname = \"chord\"\nunit = \"m\"\nlower = 0.05\nupper = 0.1\n";
    let plain = convert(&full_scale(), text).unwrap();
    assert_eq!((plain.text.as_str(), plain.without_value), (text, vec!["parameter[0]".to_owned()]));
    let options =
        DocumentOptions { value_keys: vec!["lower".to_owned(), "upper".to_owned()], ..DocumentOptions::default() };
    let there = full_scale().convert_document(&units(), text, &options).unwrap();
    assert_eq!(there.text, text.replace("0.05", "5.0").replace("0.1", "10.0"));
}

#[test]
fn faults_name_the_path_of_the_key() {
    let refused = |text: &str| convert(&full_scale(), text).unwrap_err().to_string();
    assert_eq!(
        refused("[plant.body]\nchord = { value = 1.0, unit = \"metr\" }"),
        "plant.body.chord: \"metr\", character 1: unknown unit `metr`; did you mean `m`?"
    );
    assert_eq!(
        refused("[[a]]\n[[a]]\nb = [{ value = 1.0, unit = \"A\" }]"),
        "a[1].b[0]: the given ratios (L, rho and g) do not determine I: I stays free, \
         so add a variable of such a dimension to the system, and its ratio"
    );
    assert_eq!(
        refused("a = { value = \"1\", unit = \"m\" }"),
        "a: the value is string, expected a finite number or a list of them"
    );
    assert_eq!(
        refused("a = { value = nan, unit = \"m\" }"),
        "a: the value is nan, expected a finite number or a list of them"
    );
    assert_eq!(refused("a = { value = 1e307, unit = \"m\" }"), "a: 1e307 times 100 is beyond the range of f64");
    assert!(refused("a = ").starts_with("not a TOML document: TOML parse error at line 1"));
}

#[test]
fn line_ends_stay() {
    for text in
        ["", "\n", "a = 1", "a = 1\r\nb = 2\r\n", "# only a comment", "a = { value = 1.0, unit = \"1\" }\r\n\r\n# end"]
    {
        assert_eq!(convert(&full_scale(), text).unwrap().text, text, "{text:?}");
    }
}

#[test]
fn nothing_else_is_needed_of_a_system() {
    // No density: masses are undetermined, and a file without masses does not mind.
    let system: System = system(&[("L", "m"), ("g", "m/s^2")]);
    let law = system.law(&[("L", "100"), ("g", "1")]).unwrap();
    assert_eq!(
        convert(&law, "v = { value = 1.0, unit = \"m/s\" }").unwrap().text,
        "v = { value = 10.0, unit = \"m/s\" }"
    );
    assert!(
        convert(&law, "m = { value = 1.0, unit = \"kg\" }").unwrap_err().to_string().starts_with("m: the given ratios")
    );
}

/// A TOML integer has no point, and has to be exact.
#[test]
fn a_whole_number_stays_whole_as_long_as_it_is_exact() {
    let converted =
        |value: &str| convert(&full_scale(), &format!("a = {{ value = {value}, unit = \"m\" }}\n")).unwrap().text;
    assert_eq!(converted("3"), "a = { value = 300, unit = \"m\" }\n");
    assert_eq!(converted("1000000000000000"), "a = { value = 100000000000000000.0, unit = \"m\" }\n");
}

#[test]
fn a_conversion_returns_from_json() {
    let there = convert(&full_scale(), "# a length\nchord = { value = 0.075, unit = \"m\" }\nfin = { unit = \"m\" }\n")
        .unwrap();
    assert_eq!((there.converted.len(), there.without_value.len()), (1, 1), "{there:?}");
    let text = serde_json::to_string(&there).unwrap();
    assert_eq!(serde_json::from_str::<Conversion>(&text).unwrap(), there, "{text}");
}
