//! Numbers as messages say them: with the right form of the noun, and without needless digits.

/// "1 run", "2 runs".
pub(crate) fn counted(count: u64, one: &str, many: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { many })
}

/// Σ coefficient · name, with names in backticks; "0" for nothing.
pub(crate) fn combination<'a>(parts: impl Iterator<Item = (&'a str, f64)>) -> String {
    let mut text = String::new();
    for (position, (name, coefficient)) in parts.enumerate() {
        text += match (position, coefficient < 0.0) {
            (0, false) => "",
            (0, true) => "-",
            (_, false) => " + ",
            (_, true) => " - ",
        };
        let size = plain(coefficient.abs());
        text += &match (name, size.as_str()) {
            ("1", _) => size,
            (_, "1") => format!("`{name}`"),
            _ => format!("{size} `{name}`"),
        };
    }
    if text.is_empty() { "0".to_owned() } else { text }
}

/// A positive number: whole or a simple fraction if it is one but for rounding, else in six digits.
fn plain(value: f64) -> String {
    const LARGEST_DENOMINATOR: u32 = 64;
    const ROUNDING: f64 = 1e-9;
    for denominator in 1..=LARGEST_DENOMINATOR {
        let numerator = (value * f64::from(denominator)).round();
        if (1.0..1e6).contains(&numerator)
            && (numerator / f64::from(denominator) - value).abs() <= ROUNDING * value.max(1.0)
        {
            return if denominator == 1 { format!("{numerator}") } else { format!("{numerator}/{denominator}") };
        }
    }
    let decimals = (5.0 - value.log10().floor()).clamp(0.0, 17.0) as usize;
    format!("{value:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coefficients_are_as_plain_as_they_can_be() {
        let text = |parts: &[(&'static str, f64)]| combination(parts.iter().copied());
        assert_eq!(text(&[]), "0");
        assert_eq!(text(&[("1", 1.0)]), "1");
        assert_eq!(text(&[("1", 1.0 / 3.0), ("x1", -1.0)]), "1/3 - `x1`");
        assert_eq!(text(&[("x1", -1.0 - 1e-12), ("x1 x2", 2.0), ("x2^2", -0.4)]), "-`x1` + 2 `x1 x2` - 2/5 `x2^2`");
        assert_eq!(text(&[("x1", std::f64::consts::PI), ("x2", 1.234e-5)]), "3.14159 `x1` + 0.0000123400 `x2`");
    }

    #[test]
    fn one_of_a_thing_is_singular() {
        assert_eq!(counted(1, "run", "runs"), "1 run");
        assert_eq!(counted(0, "run", "runs"), "0 runs");
    }
}
