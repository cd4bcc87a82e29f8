//! Units that may stand in a file in place of those of the code: the one table of them.
//!
//! `scaling` reads any unit, but a rig needs a few and should not wait for its compilation; a test holds each row against it.

/// A unit of a file, the unit of the code that it stands for, and how a number gets from one to the other.
struct Unit {
    name: &'static str,
    of_code: &'static str,
    /// First the number is multiplied by this ...
    times: f64,
    /// ... and then divided by that: `45.18 / 100` has the bits of 0.4518, `45.18 * 0.01` has not.
    per: f64,
}

const fn times(name: &'static str, of_code: &'static str, times: f64) -> Unit {
    Unit { name, of_code, times, per: 1.0 }
}

const fn per(name: &'static str, of_code: &'static str, per: f64) -> Unit {
    Unit { name, of_code, times: 1.0, per }
}

const UNITS: &[Unit] = &[
    per("% chord", "chord", 100.0),
    times("deg", "rad", core::f64::consts::PI / 180.0),
    times("mm", "m", 1e-3),
    times("cm", "m", 1e-2),
    times("cm/s", "m/s", 1e-2),
    times("mm/s", "m/s", 1e-3),
    times("cm^2", "m^2", 1e-4),
    times("cm^3", "m^3", 1e-6),
    times("g", "kg", 1e-3),
    times("g/m", "kg/m", 1e-3),
    times("ms", "s", 1e-3),
    times("min", "s", 60.0),
    per("%", "1", 100.0),
    times("1/deg", "1/rad", 180.0 / core::f64::consts::PI),
];

/// `value` in `unit`, converted to `of_code`; `None` where `unit` does not stand for it.
pub(crate) fn converted(value: f64, unit: &str, of_code: &str) -> Option<f64> {
    if unit == of_code {
        return Some(value);
    }
    let row = UNITS.iter().find(|row| row.name == unit && row.of_code == of_code)?;
    Some(value * row.times / row.per)
}

/// The units in which a number of the unit `of_code` may be given, for a message.
pub(crate) fn understood(of_code: &str) -> String {
    let others = UNITS.iter().filter(|row| row.of_code == of_code).map(|row| row.name);
    std::iter::once(of_code).chain(others).map(|unit| format!("`{unit}`")).collect::<Vec<_>>().join(" or ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_unit_and_factor_is_that_of_the_registry_of_units() {
        let mut registry = scaling::Units::si();
        registry.base("chord").expect("a new base");
        registry.define("% chord", "0.01*chord").expect("a new unit");
        for row in UNITS {
            let [file, code] = [row.name, row.of_code].map(|unit| registry.parse(unit).expect(unit));
            assert_eq!(file.dimension, code.dimension, "{} and {}", row.name, row.of_code);
            let (exact, found) = ((&file.factor / &code.factor).to_f64(), row.times / row.per);
            assert!((found - exact).abs() <= f64::EPSILON * exact, "{}: {found} and {exact}", row.name);
            assert_eq!(converted(1.0, row.name, row.of_code), Some(found), "{}", row.name);
        }
        assert_eq!(converted(1.0, "mm", "kg"), None, "a length is no mass");
    }

    #[test]
    fn per_cent_have_the_bits_of_the_decimal_that_is_meant() {
        assert_eq!(converted(45.18, "% chord", "chord"), Some(0.4518), "per cent of chord");
        assert_eq!(converted(0.18, "kg", "kg"), Some(0.18), "the unit of the code itself");
    }
}
