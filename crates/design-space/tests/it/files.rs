//! Regions in files: what is accepted and what is refused while reading.

use design_space::{Levels, Region};

const GOOD: &str = r#"{"parameters":[{"name":"pitch","unit":"deg","lower":10.0,"upper":22.0,"levels":25}]}"#;

#[test]
fn reads_and_writes_the_same_text() {
    let region: Region = serde_json::from_str(GOOD).unwrap();
    assert_eq!(region.parameters()[0].levels(), Levels::Count(25));
    assert_eq!(serde_json::to_string(&region).unwrap(), GOOD);
}

#[test]
fn missing_levels_mean_continuous_and_so_does_the_word() {
    for levels in ["", r#","levels":"continuous""#] {
        let region: Region = serde_json::from_str(&GOOD.replace(r#","levels":25"#, levels)).unwrap();
        assert_eq!(region.parameters()[0].levels(), Levels::Continuous);
    }
}

#[track_caller]
fn check_refused(from: &str, to: &str, message: &str) {
    assert!(GOOD.contains(from), "the text has {from}");
    let error = serde_json::from_str::<Region>(&GOOD.replace(from, to)).unwrap_err();
    assert!(error.to_string().contains(message), "{error}");
}

#[test]
fn refuses_what_a_constructor_refuses() {
    check_refused("10.0", "30.0", "the lower bound 30.0 is above the upper bound 22.0");
    check_refused("10.0", "22.0", "both bounds are 22.0");
    check_refused("10.0", "null", "invalid type: null");
    check_refused("10.0", "1e300", "the lower bound is 1e300");
    check_refused("\"pitch\"", "\"\"", "empty name");
    check_refused("25", "1", "number of levels 1");
    check_refused("25", "-3", "expected the word \"continuous\" or a whole number of levels");
    check_refused("25", "2.5", "expected the word \"continuous\" or a whole number of levels");
    check_refused("25", "5000000000", "expected the word \"continuous\" or a whole number of levels");
    check_refused("25", "\"many\"", "expected the word \"continuous\" or a whole number of levels");
    check_refused("[{", "[],\"other\":[{", "unknown field `other`");
    check_refused("\"unit\"", "\"units\"", "unknown field `units`");
    check_refused("\"unit\":\"deg\",", "", "missing field `unit`");
    check_refused("}]", "},{\"name\":\"pitch\",\"unit\":\"\",\"lower\":0,\"upper\":1}]", "parameters number 1 and 2");
    let start = GOOD.find('{').unwrap();
    check_refused(&GOOD[start..], "{\"parameters\":[]}", "at least one");
}

#[test]
fn refuses_the_nan_that_toml_can_write() {
    let text = "[[parameters]]\nname = \"p\"\nunit = \"m\"\nlower = nan\nupper = 1.0\n";
    let error = toml::from_str::<Region>(text).unwrap_err();
    assert!(error.to_string().contains("the lower bound is NaN"), "{error}");
    let text = text.replace("nan", "-inf");
    let error = toml::from_str::<Region>(&text).unwrap_err();
    assert!(error.to_string().contains("the lower bound is -inf"), "{error}");
}
