//! Numbers as they stand in the cells of a table: with a unit, or with a comma for the decimal point.

use super::cells::Separator;
use crate::echo::echo;
use crate::number::{NoNumber, parse};

/// What a comma in a number of this table stands for.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Commas {
    /// Nothing that is known: it may stand for the decimal point, or between thousands.
    Refused,
    /// The decimal point.
    Decimal,
    /// The decimal point, but where three digits follow: then it may stand between thousands.
    DecimalIfNothingElse,
    /// Some numbers of the table have a decimal point, among them this one in this row.
    Mixed { row: usize, text: String },
}

impl Commas {
    /// From all cells that are to be numbers, each with its row.
    pub(super) fn of<'a>(separator: Separator, numbers: impl Iterator<Item = (usize, &'a str)>) -> Self {
        match separator {
            Separator::Comma | Separator::Workbook => return Self::Refused,
            Separator::Form => return Self::DecimalIfNothingElse,
            Separator::Other => {}
        }
        for (row, text) in numbers {
            if text.contains('.') && !text.contains(',') && split(text).is_some() {
                return Self::Mixed { row, text: text.to_owned() };
            }
        }
        Self::Decimal
    }

    /// The number in a cell of a column with this unit, or what was expected instead.
    pub(super) fn number(&self, text: &str, unit: &str) -> Result<f64, NoNumber> {
        let fault = match parse(text) {
            Ok(value) => return Ok(value),
            Err(expected) => expected,
        };
        if let Some((number, other)) = split(text).filter(|(_, other)| !other.is_empty()) {
            let fits = same_unit(other, unit);
            return match (fits, unit) {
                (true, _) => self.number(number, ""),
                (false, "") => {
                    Err(format!("a number; the column has no unit, and the cell has `{}`", echo(other)).into())
                }
                (false, unit) => {
                    Err(format!("a number in `{unit}`, the unit of the column, and not in `{}`", echo(other)).into())
                }
            };
        }
        if !text.contains(',') {
            // A unit that agrees may stand beside it.
            let is_number = text.parse::<f64>().is_ok();
            return Err(if is_number { fault } else { "a number like 12.5".into() });
        }
        match (text.matches(',').count(), text.contains('.'), self) {
            (1, false, Self::DecimalIfNothingElse) if !(is_digits(text) && is_grouped(text)) => {
                parse(&text.replace(',', "."))
            }
            (1, false, Self::Decimal) => parse(&text.replace(',', ".")),
            (1, false, Self::Mixed { row, text }) => {
                let allowed = "a number with a decimal point, not a comma";
                Err(format!("{allowed}, as row {row} has `{}`: one table has one of them", echo(text)).into())
            }
            (1, false, Self::Refused | Self::DecimalIfNothingElse) if is_digits(text) && is_grouped(text) => {
                let [decimal, whole] = [".", ""].map(|other| text.replace(',', other));
                Err(format!("a number with a decimal point, not a comma: it may be {decimal} or {whole}").into())
            }
            _ if is_digits(text) && is_any_grouped(text) => {
                Err("a number like 1234.5, with nothing between the thousands".into())
            }
            _ => Err(fault),
        }
    }
}

/// Number and unit of a cell, if it has both or only a number.
fn split(text: &str) -> Option<(&str, &str)> {
    if !text.starts_with(|c: char| c.is_ascii_digit() || "+-.,".contains(c)) {
        return None;
    }
    let is_number = |text: &str| text.replacen(',', ".", 1).parse::<f64>().is_ok();
    let ends = text.char_indices().map(|(at, _)| at).chain([text.len()]).take(MOST_DIGITS);
    let end = ends.filter(|&end| is_number(text[..end].trim_end())).last()?;
    let (number, unit) = (text[..end].trim_end(), text[end..].trim());
    // What goes on with digits and commas is no unit, nor is a slip such as 6.o4.
    let goes_on = unit.starts_with(|c: char| c.is_ascii_digit() || ".,;:+-".contains(c));
    let is_unit = !goes_on && (unit.is_empty() || !text[..end].ends_with('.'));
    // `12.5` alone has been tried.
    is_unit.then_some((number, unit)).filter(|(number, unit)| !unit.is_empty() || number.contains('.'))
}

/// A number takes no more characters.
const MOST_DIGITS: usize = 400;

/// Both signs for micro are one.
fn same_unit(a: &str, b: &str) -> bool {
    let plain = |unit: &str| unit.trim_start_matches('[').trim_end_matches(']').replace('\u{3bc}', "\u{b5}");
    plain(a) == plain(b)
}

fn is_digits(text: &str) -> bool {
    text.chars().all(|c| c.is_ascii_digit() || "+-.,".contains(c))
}

/// Three digits after a comma that has one to three before it: it may part thousands.
fn is_grouped(text: &str) -> bool {
    let digits = text.trim_start_matches(['+', '-']);
    digits
        .split_once(',')
        .is_some_and(|(before, after)| after.len() == 3 && (1..=3).contains(&before.len()) && !before.starts_with('0'))
}

fn is_any_grouped(text: &str) -> bool {
    text.matches([',', '.']).count() >= 2
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_unit_that_agrees_is_taken_and_another_is_named() {
        for (text, unit) in [("12.5 mm", "mm"), ("12.5mm", "mm"), ("12.5 [mm]", "mm"), ("12.5", "mm"), ("12.5", "")] {
            assert_eq!(Commas::Refused.number(text, unit), Ok(12.5), "{text}");
        }
        assert_eq!(Commas::Refused.number("3 \u{3bc}m", "\u{b5}m"), Ok(3.0));
        assert_eq!(Commas::Refused.number("2e3 N/mm", "N/mm"), Ok(2000.0));
        let error = Commas::Refused.number("12.5 cm", "mm").expect_err("another").to_string();
        assert!(error.contains("`mm`") && error.contains("`cm`"), "{error}");
        let error = Commas::Refused.number("12.5 N", "mN").expect_err("case counts").to_string();
        assert!(error.contains("`mN`") && error.contains("`N`"), "{error}");
        assert!(Commas::Refused.number("12.5 mm", "").expect_err("no unit").to_string().contains("has no unit"));
        assert!(Commas::Refused.number("nano", "m").is_err());
        assert_eq!(Commas::Refused.number("6.o4", "mm"), Err("a number like 12.5".into()), "a slip, and no unit");
        assert!(Commas::Refused.number("inf", "m").expect_err("no number").to_string().contains("finite"));
    }

    #[test]
    fn commas_are_decimal_where_they_can_be_nothing_else() {
        assert_eq!(Commas::Decimal.number("-1,5", ""), Ok(-1.5));
        assert_eq!(Commas::Decimal.number("1,234", ""), Ok(1.234));
        assert_eq!(Commas::Decimal.number("12,5 mm", "mm"), Ok(12.5));
        for (text, words) in [("1,234", "it may be 1.234 or 1234"), ("1,5", "decimal point, not a comma")] {
            let error = Commas::Refused.number(text, "").expect_err(words).to_string();
            assert!(error.contains(words), "{error}");
        }
        for text in ["1.234,5", "1,234.5", "1,234,567"] {
            let error = Commas::Decimal.number(text, "").expect_err("two kinds").to_string();
            assert!(error.contains("between the thousands"), "{error}");
        }
        let typed = Commas::of(Separator::Form, std::iter::empty());
        assert_eq!((typed.number("7,5", ""), typed.number("8,1250", "")), (Ok(7.5), Ok(8.125)));
        assert!(typed.number("1,234", "").expect_err("a thousand?").to_string().contains("it may be 1.234 or 1234"));
        let mixed = Commas::of(Separator::Other, [(2, "7,5"), (3, "8.5")].into_iter());
        assert_eq!(mixed.number("8.5", ""), Ok(8.5));
        assert!(mixed.number("7,5", "").expect_err("mixed").to_string().contains("row 3 has `8.5`"));
        assert_eq!(Commas::of(Separator::Other, [(2, "7,5"), (3, "8")].into_iter()), Commas::Decimal);
        assert_eq!(Commas::of(Separator::Comma, [(2, "7,5")].into_iter()), Commas::Refused);
    }
}
