//! How far a simulation is displaced, in words.

use design_space::Parameter;
use infuse::pooled::reported::NINE_IN_TEN;

use crate::number::{short, with_unit};

/// "a higher by 1 mm (give or take 0.5 mm), b lower by 2 mm (give or take 0.6 mm)", of those along which it is displaced at all; by how much
/// give or take, journals of before do not have.
pub(crate) fn displaced_by(parameters: &[Parameter], by: &[f64], deviations: Option<&[f64]>) -> String {
    let along = parameters.iter().zip(by).enumerate().filter(|(_, (_, by))| by.abs() > 0.0);
    let along = along.map(|(axis, (parameter, &by))| {
        let way = if by > 0.0 { "higher" } else { "lower" };
        let way = format!("{} {way} by {}", parameter.name(), with_unit(&short(by.abs()), parameter.unit()));
        match deviations.and_then(|all| all.get(axis)) {
            Some(&deviation) => format!("{way} {}", give_or_take(parameter, deviation)),
            None => way,
        }
    });
    along.collect::<Vec<_>>().join(", ")
}

/// "(give or take 0.5 mm)", nine times of ten.
pub(crate) fn give_or_take(parameter: &Parameter, deviation: f64) -> String {
    format!("(give or take {})", with_unit(&short(two_digits(NINE_IN_TEN * deviation)), parameter.unit()))
}

/// As much of a band as anyone needs.
fn two_digits(value: f64) -> f64 {
    format!("{value:.1e}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_displaced_is_named_with_its_band_where_that_is_known() {
        let number = |name: &str| Parameter::continuous(name, "mm", 0.0, 10.0).unwrap();
        let parameters = [number("a"), number("b"), number("c")];
        let by = [1.0, 0.0, -0.25];
        assert_eq!(displaced_by(&parameters, &by, None), "a higher by 1 mm, c lower by 0.25 mm");
        // 1.645 standard deviations of .1 and of .03, to two digits.
        assert_eq!(
            displaced_by(&parameters, &by, Some(&[0.1, 0.2, 0.03])),
            "a higher by 1 mm (give or take 0.16 mm), c lower by 0.25 mm (give or take 0.049 mm)"
        );
        assert_eq!(displaced_by(&parameters, &[0.0; 3], None), "");
    }
}
