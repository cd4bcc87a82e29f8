//! Recommendations on a bound.

use page::Finding;

use crate::number::{plain, with_unit};
use crate::problem::Problem;

/// The bounds on which a design lies.
pub(crate) fn on_bounds(problem: &Problem, point: &[f64]) -> Vec<Finding> {
    let mut found = Vec::new();
    for (parameter, &setting) in problem.region.parameters().iter().zip(point) {
        let word = match setting {
            _ if parameter.choices().is_some() => continue,
            at if at <= parameter.lower() => "lower",
            at if at >= parameter.upper() => "upper",
            _ => continue,
        };
        let bound = with_unit(&plain(setting), parameter.unit());
        let name = parameter.name();
        let sentence = format!("{name} is on its {word} bound, {bound}: beyond it may be better ones.");
        found.push(Finding::new(sentence).with(name, setting, parameter.unit()));
    }
    found
}
