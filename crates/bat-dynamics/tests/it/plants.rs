//! The plant of the tests: the numbers of the rig file, read from it.

use bat_dynamics::{Parameters, TetherLayout};

/// The parameters of `fixtures/bat/rig.toml`.
pub(crate) fn rig() -> Parameters {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/bat/rig.toml");
    let text = std::fs::read_to_string(path).unwrap();
    let table: toml::Table = text.parse().unwrap();
    Parameters::from_fields(TetherLayout::OneForwardTwoAft, |field| {
        let entry = &table["plant"][field.section][field.name];
        let value = entry["value"].as_float().unwrap();
        match (entry["unit"].as_str().unwrap(), field.unit) {
            ("% chord", "chord") => Ok::<f64, ()>(value / 100.0),
            ("deg", "rad") => Ok(value.to_radians()),
            (found, expected) => {
                assert_eq!(found, expected, "unit of {}.{}", field.section, field.name);
                Ok(value)
            }
        }
    })
    .unwrap()
}
