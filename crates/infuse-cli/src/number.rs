//! Numbers as people write and read them.

use std::borrow::Cow;
use std::fmt;

/// A setting that takes more characters is no round number.
const LONGEST_SETTING: usize = 9;

/// From here on computed values are written with a power of ten: nobody counts more zeros.
const LONGEST_COUNTED: f64 = 1e7;
/// Unless more digits than these count.
const MOST_DIGITS: f64 = 6.0;

/// A setting or a measured value: twelve digits, so 8.3 and not 8.3000000000000007.
pub(crate) fn plain(value: f64) -> String {
    let rounded: f64 = format!("{value:.11e}").parse().unwrap_or(value);
    // No minus sign before zero.
    let rounded = rounded + 0.0;
    if rounded != 0.0 && !(1e-5..1e15).contains(&rounded.abs()) { format!("{rounded:e}") } else { rounded.to_string() }
}

/// The number that [`plain`] writes.
pub(crate) fn rounded(value: f64) -> f64 {
    plain(value).parse().unwrap_or(value)
}

/// Whether two settings are one to whoever reads them, to all digits that are written.
pub(crate) fn are_written_alike(a: f64, b: f64) -> bool {
    rounded(a).total_cmp(&rounded(b)).is_eq()
}

/// A computed value: four digits.
pub(crate) fn short(value: f64) -> String {
    if !value.is_finite() {
        return value.to_string();
    }
    let rounded: f64 = format!("{value:.3e}").parse().unwrap_or(value);
    if rounded.abs() >= LONGEST_COUNTED { format!("{rounded:e}") } else { plain(rounded) }
}

/// A computed value that is known to about `resolution`: four digits, or as many as show that.
pub(crate) fn resolved(value: f64, resolution: f64) -> String {
    let exponent = resolution.log10().floor();
    let can_be_shown = (1e-5..1e15).contains(&value.abs()) && (-12.0..15.0).contains(&exponent);
    if !can_be_shown || value.abs() < 10_f64.powf(exponent + 3.0) {
        return short(value);
    }
    let digits = value.abs().log10().floor() - exponent;
    if value.abs() >= LONGEST_COUNTED && digits <= MOST_DIGITS {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 3 to 6")]
        let rounded: f64 = format!("{value:.*e}", digits as usize).parse().unwrap_or(value);
        return format!("{rounded:e}");
    }
    if exponent >= 0.0 {
        let unit = 10_f64.powf(exponent);
        return format!("{:.0}", (value / unit).round() * unit);
    }
    let text = format!("{value:.*}", -exponent as usize);
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// A setting for people to read: as many decimals as tell levels that are this far apart well from each other, if it has
/// more than a person would type.
pub(crate) fn setting(value: f64, step: f64) -> String {
    let exact = plain(value);
    if exact.len() <= LONGEST_SETTING || !(step > 0.0 && step.is_finite()) {
        return exact;
    }
    let unit = 10_f64.powf(step.log10().floor() - 2.0);
    plain((value / unit).round() * unit)
}

/// With the unit, if there is one; 1 is none.
pub(crate) fn with_unit(number: &str, unit: &str) -> String {
    if unit.is_empty() || unit == "1" { number.to_owned() } else { format!("{number} {unit}") }
}

/// A share or a probability: one decimal where it counts, and of a small one the first digit that does. What is not quite all is
/// not said to be.
pub(crate) fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    if (99.95..100.0).contains(&percent) {
        return "more than 99.9 %".to_owned();
    }
    if percent == 0.0 || percent >= 0.1 {
        let rounded: f64 = format!("{percent:.1}").parse().unwrap_or(percent);
        return format!("{} %", plain(rounded));
    }
    if percent > 0.0 && percent < 1e-3 {
        return "less than 0.001 %".to_owned();
    }
    let rounded: f64 = format!("{percent:.0e}").parse().unwrap_or(percent);
    format!("{} %", plain(rounded))
}

/// The largest magnitude of a value: the surfaces take no more.
const LARGEST: f64 = surface::Data::LARGEST;

/// What was expected instead of what is no number.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum NoNumber {
    /// NaN is how programs write that there is none.
    NotFinite,
    Other(Cow<'static, str>),
}

impl NoNumber {
    /// What was expected instead of it as a result.
    pub(crate) fn of_result(&self) -> String {
        match self {
            Self::NotFinite => format!("{self}; a run without a result is reported as failed, with its reason"),
            Self::Other(_) => self.to_string(),
        }
    }
}

impl fmt::Display for NoNumber {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::NotFinite => "a finite number",
            Self::Other(expected) => expected,
        })
    }
}

impl From<&'static str> for NoNumber {
    fn from(expected: &'static str) -> Self {
        Self::Other(Cow::Borrowed(expected))
    }
}

impl From<String> for NoNumber {
    fn from(expected: String) -> Self {
        Self::Other(Cow::Owned(expected))
    }
}

/// What is wrong with a number, if anything is.
pub(crate) fn fault(value: f64) -> Option<NoNumber> {
    if !value.is_finite() {
        Some(NoNumber::NotFinite)
    } else if value.abs() > LARGEST {
        Some("a number of at most 1e100 in magnitude".into())
    } else {
        None
    }
}

/// A finite number as written in a cell of a table, or what is wrong with it.
pub(crate) fn parse(text: &str) -> Result<f64, NoNumber> {
    match text.parse::<f64>() {
        Ok(value) => fault(value).map_or(Ok(value), Err),
        Err(_) if is_decimal_comma(text) => Err("a number with a decimal point, not a comma".into()),
        Err(_) if text.starts_with(['<', '>']) => {
            Err("a number like 12.5: where a sensor ends, that end, with `lower` or `upper` of the response set to it"
                .into())
        }
        Err(_) => Err("a number like 12.5, without its unit".into()),
    }
}

fn is_decimal_comma(text: &str) -> bool {
    text.matches(',').count() == 1 && text.replace(',', ".").parse::<f64>().is_ok()
}

/// "1 run", "2 runs".
pub(crate) fn count(n: usize, noun: &str) -> String {
    if n == 1 { format!("1 {noun}") } else { format!("{} {}", grouped(n as u64), plural(noun)) }
}

fn plural(noun: &str) -> String {
    let ending = if noun.ends_with("ch") { "es" } else { "s" };
    format!("{noun}{ending}")
}

/// Digits in groups of three from ten thousand on.
pub(crate) fn grouped(n: u64) -> String {
    let digits = n.to_string();
    if digits.len() < 5 {
        return digits;
    }
    let mut grouped = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            grouped.push(',');
        }
        grouped.push(digit);
    }
    grouped
}

/// A time, in the unit that suits it.
pub(crate) fn seconds(took: std::time::Duration) -> String {
    let seconds = took.as_secs_f64();
    match seconds {
        _ if seconds < 90.0 => format!("{} s", short((100.0 * seconds).ceil() / 100.0)),
        _ if seconds < 5400.0 => format!("{} min", short((seconds / 6.0).round() / 10.0)),
        _ => format!("{} h", short((seconds / 360.0).round() / 10.0)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_are_written_without_the_noise_of_doubles() {
        assert_eq!(plain(0.1 + 0.2), "0.3");
        assert_eq!(plain(-0.0), "0");
        assert_eq!(plain(21_000.0), "21000");
        assert_eq!(plain(1.25e-9), "1.25e-9");
        assert_eq!(short(1.234_567), "1.235");
        assert_eq!(short(21_344.0), "21340");
        assert_eq!((with_unit("88.75", "1"), with_unit("3", "mm")), ("88.75".to_owned(), "3 mm".to_owned()));
    }

    #[test]
    fn values_show_what_is_known_of_them() {
        assert_eq!(resolved(12_345.678, 0.2), "12345.7");
        assert_eq!(resolved(12_345.678, 30.0), "12350", "four digits at least");
        assert_eq!(resolved(5_000.0, 0.01), "5000");
        assert_eq!(resolved(2.206_4, 0.05), "2.206");
        assert_eq!(resolved(1_000_000_000_003.25, 0.01), "1000000000003.25");
        assert_eq!(resolved(1_234_567_890_123.0, 2e9), "1.235e12");
        assert_eq!(resolved(1_234_567_890_123.0, 2e7), "1.23457e12");
        assert_eq!((short(2.5e12), short(-1e7), short(9.994e6)), ("2.5e12".into(), "-1e7".into(), "9994000".into()));
        assert_eq!(resolved(-71.234_56, 0.001), "-71.235");
        assert_eq!(resolved(3.0, 0.0), "3");
        assert_eq!(resolved(21_344.0, f64::NAN), "21340");
    }

    #[test]
    fn settings_between_round_numbers_are_shortened_for_reading() {
        assert_eq!(setting(2.956_521_739_13, 3.0 / 23.0), "2.957");
        assert_eq!(setting(0.434_782_608_696, 0.6 / 23.0), "0.4348");
        assert_eq!(setting(39.130_434_782_6, 50.0 / 23.0), "39.13");
        assert_eq!(setting(20.123, 2.0), "20.123");
        assert_eq!(setting(1_234_567_890.5, 1000.0), "1234567890");
    }

    #[test]
    fn cells_that_are_no_numbers_are_told_what_is() {
        assert_eq!(parse("1.5"), Ok(1.5));
        assert_eq!(parse("-2e3"), Ok(-2000.0));
        for (text, word) in [("1,5", "comma"), ("NaN", "finite"), ("inf", "finite"), ("1.5 m", "unit"), ("x", "number")]
        {
            assert!(parse(text).expect_err("no number").to_string().contains(word), "{text}");
        }
        assert!(parse("<1e-9").expect_err("no number").to_string().contains("where a sensor ends"));
        assert!(!parse("1,5,2").expect_err("no number").to_string().contains("comma"), "not a decimal comma");
        assert_eq!((parse("NaN"), parse("-inf")), (Err(NoNumber::NotFinite), Err(NoNumber::NotFinite)));
        assert!(NoNumber::NotFinite.of_result().contains("failed"), "{}", NoNumber::NotFinite.of_result());
    }

    #[test]
    fn small_shares_are_not_nothing() {
        assert_eq!(percent(0.153_27), "15.3 %");
        assert_eq!(percent(36.0 / 331_776.0), "0.01 %");
        assert_eq!(percent(0.0), "0 %");
    }

    #[test]
    fn a_probability_has_no_decimal_that_says_nothing() {
        assert_eq!((percent(0.9), percent(0.95), percent(0.975)), ("90 %".into(), "95 %".into(), "97.5 %".into()));
        assert_eq!((percent(1.0), percent(0.999)), ("100 %".into(), "99.9 %".into()));
        assert_eq!(percent(0.999_9), "more than 99.9 %", "not quite all");
    }

    #[test]
    fn counts_agree_with_their_nouns() {
        assert_eq!(count(1, "run"), "1 run");
        assert_eq!(count(12_345, "run"), "12,345 runs");
        assert_eq!(count(2, "batch"), "2 batches");
        assert_eq!(count(3, "more batch"), "3 more batches");
        assert_eq!(grouped(331_776), "331,776");
        assert_eq!(grouped(1234), "1234");
    }
}
