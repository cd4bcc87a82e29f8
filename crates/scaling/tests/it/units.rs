//! Unit strings and dimensions.

use std::collections::BTreeMap;

use ::serde::Deserialize;
use scaling::{Dimension, Error, Units};

/// Units by pint.
const FIXTURE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/scaling/units.json");

#[derive(Deserialize)]
struct Fixture {
    cases: Vec<Case>,
}

#[derive(Deserialize)]
struct Case {
    unit: String,
    factor: f64,
    dimension: BTreeMap<String, i64>,
}

#[test]
fn units_and_prefixes_are_those_of_pint() {
    let fixture: Fixture = serde_json::from_str(&std::fs::read_to_string(FIXTURE).unwrap()).unwrap();
    assert!(fixture.cases.len() > 100);
    for Case { unit, factor, dimension } in fixture.cases {
        let ours = Units::si().parse(&unit).unwrap();
        let ratio = ours.factor.to_f64() / factor;
        assert!((ratio - 1.0).abs() <= 1e-15, "{unit}: {} against {factor}", ours.factor);
        let expected = dimension.iter().fold(Dimension::one(), |product, (base, power)| {
            &product * &Dimension::base(base).unwrap().pow(&crate::ratio(&power.to_string()))
        });
        assert_eq!(ours.dimension, expected, "{unit}");
    }
}

/// Factor and dimension as text.
#[track_caller]
fn check(text: &str, factor: &str, dimension: &str) {
    let unit = Units::si().parse(text).unwrap();
    assert_eq!((unit.factor.to_string().as_str(), unit.dimension.to_string().as_str()), (factor, dimension), "{text}");
}

#[track_caller]
fn refused(text: &str, expected: &str) {
    assert_eq!(Units::si().parse(text).unwrap_err().to_string(), expected);
}

#[test]
fn unit_strings_are_read_as_people_write_them() {
    check("kg*m^-3", "1", "M/L^3");
    check("kg/m^3", "1", "M/L^3");
    check("m/s^2", "1", "L/T^2");
    check("N", "1", "M*L/T^2");
    check("Pa", "1", "M/(L*T^2)");
    check("rad", "1", "1");
    check("deg", "pi/180", "1");
    check("%", "1/100", "1");
    check("1", "1", "1");
    check("1/s", "1", "1/T");
    check("m/(s*rad)", "1", "L/T");
    check("cm^2", "1/10000", "L^2");
    check("g/m", "1/1000", "M/L");
    check("s^2/m^2", "1", "T^2/L^2");
    check("m^(1/2)", "1", "L^(1/2)");
    check("m^0.5", "1", "L^(1/2)");
    check("cm^0.5", "1/10", "L^(1/2)");
    check("mm^(1/3)", "1/10", "L^(1/3)");
    check("kg m/s^2", "1", "M*L/T^2");
    check("N·m", "1", "M*L^2/T^2");
    check("m²", "1", "L^2");
    check("s⁻¹", "1", "1/T");
    check("m**2", "1", "L^2");
    check("m ^ -2", "1", "1/L^2");
    check("m^(-3/2)", "1", "1/L^(3/2)");
    check("1/(m s)", "1", "1/(L*T)");
    check("(m/s)^2", "1", "L^2/T^2");
    check(" m ", "1", "L");
    check("m/s/s", "1", "L/T^2");
    check("10^3 kg", "1000", "M");
    check("1e-3*m", "1/1000", "L");
    check("1/rad^2", "1", "1");
}

#[test]
fn prefixes_scale_and_whole_symbols_go_first() {
    check("km", "1000", "L");
    check("µm", "1/1000000", "L");
    check("um", "1/1000000", "L");
    check("dam", "10", "L");
    check("mN", "1/1000", "M*L/T^2");
    check("hPa", "100", "M/(L*T^2)");
    check("min", "60", "T");
    check("cd", "1", "J");
    check("ft", "381/1250", "L");
    check("mrad", "1/1000", "1");
    check("kW*h", "3600000", "M*L^2/T^2");
    check("mg", "1/1000000", "M");
    check("L/min", "1/60000", "L^3/T");
    check("°", "pi/180", "1");
    check("lbf", "8896443230521/2000000000000", "M*L/T^2");
    check("eV", "801088317/5000000000000000000000000000", "M*L^2/T^2");
}

/// The factors of Appendix B.8 of NIST SP 811 (2008), which are rounded there to seven digits unless exact.
#[test]
fn engineering_units_have_the_published_factors() {
    let published = [
        ("rpm", "rad/s", 1.047198e-1, 7),
        ("rev/min", "rad/s", 1.047198e-1, 7),
        ("Wh", "J", 3.6e3, 16),
        ("kWh", "J", 3.6e6, 16),
        ("mAh", "C", 3.6, 16),
        ("mmHg", "Pa", 1.333224e2, 7),
        ("inHg", "Pa", 3.386389e3, 7),
        ("Torr", "Pa", 1.333224e2, 7),
        ("mbar", "Pa", 1.0e2, 16),
        ("atm", "Pa", 1.01325e5, 16),
        ("cP", "Pa*s", 1.0e-3, 16),
        ("cSt", "m^2/s", 1.0e-6, 16),
        ("kcal", "J", 4.184e3, 16),
    ];
    for (symbol, si, factor, digits) in published {
        let (unit, si) = (Units::si().parse(symbol).unwrap(), Units::si().parse(si).unwrap());
        assert_eq!((unit.dimension, si.factor.to_string().as_str()), (si.dimension, "1"), "{symbol}");
        // Half a unit of the last digit of a number that begins with a 1 is the most that rounding leaves.
        let (found, tolerance) = (unit.factor.to_f64(), 0.5 * 10.0_f64.powi(1 - digits));
        assert!((found / factor - 1.0).abs() <= tolerance, "{symbol}: {found} against {factor}");
    }
    // What is conventional is exact.
    check("mmHg", "26664477483/200000000", "M/(L*T^2)");
    check("Torr", "20265/152", "M/(L*T^2)");
    check("rpm", "pi/30", "1/T");
    assert_eq!(Units::si_with_angle().parse("rpm").unwrap().dimension.to_string(), "angle/T", "an angle that counts");
}

#[test]
fn every_base_of_the_si_is_there() {
    check("A*s", "1", "T*I");
    check("K", "1", "Theta");
    check("mol", "1", "N");
    check("lm", "1", "J");
    check("ohm", "1", "M*L^2/(T^3*I^2)");
}

#[test]
fn unknown_units_are_named_with_position_and_near_misses() {
    refused("kg*metr^-3", "\"kg*metr^-3\", character 4: unknown unit `metr`; did you mean `m`?");
    refused("m/sec", "\"m/sec\", character 3: unknown unit `sec`; did you mean `s`?");
    refused("m2/s", "\"m2/s\", character 1: unknown unit `m2`; did you mean `m^2`?");
    refused("kPA", "\"kPA\", character 1: unknown unit `kPA`; did you mean `kPa`?");
    refused("1/(% chord)", "\"1/(% chord)\", character 6: unknown unit `chord`");
    refused("rdd", "\"rdd\", character 1: unknown unit `rdd`; did you mean `rad`?");
}

#[test]
fn offsets_are_refused_with_a_reason() {
    let expected =
        "character 1: `degC` has an offset, so no factor converts it; give temperatures and their differences in K";
    refused("degC", &format!("\"degC\", {expected}"));
    assert!(matches!(Units::si().parse("W/(m^2*°C)"), Err(Error::AffineUnit { position: 8, .. })));
}

#[test]
fn slips_of_syntax_name_position_and_expectation() {
    refused(
        "",
        "\"\", character 1: found the end, expected a symbol or a number, and a dimensionless 1 is written `1`",
    );
    refused("m/", "\"m/\", character 3: found the end, expected a symbol, a number or `(`");
    refused("m//s", "\"m//s\", character 3: found `/`, expected a symbol, a number or `(`");
    refused("m/(s*rad", "\"m/(s*rad\", character 9: found the end, expected `)`");
    refused("m)", "\"m)\", character 2: found `)`, expected an operator (`*`, `/`, `^`) or the end");
    refused("m^", "\"m^\", character 3: found the end, expected a number, at most 400 digits long and below 1e400");
    refused("m^(1/0)", "\"m^(1/0)\", character 7: found `)`, expected a denominator other than 0");
    refused("µm^x", "\"µm^x\", character 4: found `x`, expected a number, at most 400 digits long and below 1e400");
    refused(
        "m^1/2",
        "\"m^1/2\", character 4: found `/`, expected parentheses around a fractional exponent, as in `m^(1/2)`",
    );
    refused(
        "m^2^3",
        "\"m^2^3\", character 4: found `^`, expected parentheses, because a power of a power reads in two ways",
    );
    refused(
        "m/s rad",
        "\"m/s rad\", character 5: found `r`, expected `*`, or parentheses around the denominator, \
         because it is unclear what the `/` divides",
    );
    refused("m#", "\"m#\", character 2: found `#`, expected an operator (`*`, `/`, `^`) or the end");
    refused("0*m", "0 is no ratio: it must be positive and finite");
}

#[test]
fn exponents_beyond_use_are_refused_and_never_wrap() {
    for text in ["m^1001", "m^99999999999999999999", "m^(1/1001)", "(m^1000)^2", "m^1e399"] {
        assert!(matches!(Units::si().parse(text), Err(Error::ExponentTooLarge { .. })), "{text}");
    }
    assert!(Units::si().parse("m^1e999999999999").is_err());
    assert!(Units::si().parse(&"(".repeat(100_000)).is_err());
    assert!(Units::si().parse("m^1000").is_ok());
}

#[test]
fn labels_with_spaces_are_read_whole() {
    let mut units = Units::si();
    units.define("% chord", "0.01").unwrap().define("u_max", "1").unwrap();
    for (text, factor) in
        [("% chord", "1/100"), ("1/(% chord)^2", "10000"), ("1/% chord", "100"), ("m*% chord", "1/100"), ("u_max", "1")]
    {
        assert_eq!(units.parse(text).unwrap().factor.to_string(), factor, "{text}");
    }
    assert_eq!(units.parse("% chord/s").unwrap().dimension.to_string(), "1/T");
    assert!(units.parse("% chords").is_err(), "a longer word is another word");
    assert_eq!(units.parse("%").unwrap().factor.to_string(), "1/100");
}

#[test]
fn users_add_units_and_bases() {
    let mut units = Units::si();
    units.base("USD").unwrap().base_as("bit", "information").unwrap().define("furlong", "660*ft").unwrap();
    let price = units.parse("USD/(kW*h)").unwrap();
    assert_eq!(price.dimension.to_string(), "T^2*USD/(M*L^2)");
    assert_eq!(units.parse("bit/s").unwrap().dimension.to_string(), "information/T");
    assert_eq!(units.parse("furlong").unwrap().factor.to_string(), "25146/125");
    let exists = units.define("mm", "1").unwrap_err().to_string();
    assert_eq!(exists, "the unit `mm` exists already: it means 1/1000 of dimension L");
    for symbol in ["", "2x", "a*b", " a", "a 2", "a/b"] {
        assert!(matches!(units.define(symbol, "1"), Err(Error::BadName { .. })), "{symbol:?}");
    }
}

/// `M` in place of a mass would leave `M/kg` without a dimension.
#[test]
fn a_base_brings_a_dimension_that_no_unit_has() {
    let mut units = Units::si();
    let refused = |found: Result<&mut Units, Error>| found.unwrap_err().to_string();
    let expected = "the dimension `M` of the base `M` is not new, `g` has it: give it another name with `base_as`";
    assert_eq!(refused(units.base("M")), expected);
    assert!(refused(units.base("Theta")).contains("`K` has it"));
    assert!(refused(units.base_as("smoot", "L")).contains("`m` has it"));
    units.base_as("M", "money").unwrap().base("USD").unwrap();
    assert_eq!(units.parse("M/kg").unwrap().dimension.to_string(), "money/M");
    assert!(refused(units.base_as("EUR", "USD")).contains("`USD` has it"));
    assert!(refused(units.base("USD")).starts_with("the unit `USD` exists already"));
    assert!(refused(Units::si_with_angle().base("angle")).contains("`rad` has it"));
}

#[test]
fn angle_can_be_a_base() {
    let units = Units::si_with_angle();
    let pitch_rate = units.parse("deg/s").unwrap();
    assert_eq!((pitch_rate.factor.to_string(), pitch_rate.dimension.to_string()), ("pi/180".into(), "angle/T".into()));
    assert_eq!(units.parse("sr").unwrap().dimension.to_string(), "angle^2");
}

#[test]
fn dimensions_take_any_base_symbol() {
    let dimension: Dimension = "L^2*angle/(USD^(1/2)*T)".parse().unwrap();
    assert_eq!(dimension.to_string(), "L^2*angle/(T*USD^(1/2))");
    assert_eq!(
        "2*L".parse::<Dimension>().unwrap_err().to_string(),
        "\"2*L\" contains the number 2, but only 1 and symbols with exponents are allowed here"
    );
    assert!(Dimension::base("a b").is_err());
    assert!("L^0".parse::<Dimension>().unwrap().is_one());
}

#[test]
fn quotients_of_references_are_those_of_values() {
    let dimension = |text: &str| Units::si().parse(text).unwrap().dimension;
    assert_eq!(&dimension("m^2") / &dimension("m"), dimension("m"));
    assert_eq!(&dimension("kg*m") / &dimension("s^2"), dimension("N"));
    assert_eq!(&dimension("m") / &dimension("m"), Dimension::one());
}
