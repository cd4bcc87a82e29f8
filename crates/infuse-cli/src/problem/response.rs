//! What is measured, and how it becomes the cost that a loop minimizes.

use super::file::{Goal, PROBLEM, Scale};
use crate::number::{plain, resolved, rounded, short, with_unit};

/// What is measured.
#[derive(Debug, Clone)]
pub(crate) struct Response {
    pub(crate) name: String,
    pub(crate) unit: String,
    pub(crate) goal: Goal,
    pub(crate) scale: Scale,
    pub(crate) lower: Option<f64>,
    pub(crate) upper: Option<f64>,
}

/// The largest value on a logarithmic scale, as on every other, and the smallest.
const LARGEST: f64 = 1e100;
const SMALLEST: f64 = 1e-100;
/// The natural logarithm of about the largest number there is.
const LARGEST_LOGARITHM: f64 = 690.0;

impl Response {
    /// From what is measured to what is minimized: itself or its natural logarithm, with the sign of the goal.
    pub(crate) fn cost(&self, response: f64) -> f64 {
        let scaled = self.scaled(response);
        match self.goal {
            Goal::Minimize => scaled,
            Goal::Maximize => -scaled,
        }
    }

    /// From what is minimized back to what is measured; of a logarithm to all digits that are written.
    pub(crate) fn of_cost(&self, cost: f64) -> f64 {
        let scaled = match self.goal {
            Goal::Minimize => cost,
            Goal::Maximize => -cost,
        };
        match self.scale {
            Scale::Linear => scaled,
            Scale::Log => rounded(exp(scaled)),
        }
    }

    /// As the scale has it: differences of these are what counts.
    pub(crate) fn scaled(&self, response: f64) -> f64 {
        match self.scale {
            Scale::Linear => response,
            Scale::Log => response.ln(),
        }
    }

    /// A difference of costs as people have it: in the unit of the response, or as a factor.
    pub(crate) fn of_difference(&self, difference: f64) -> f64 {
        match self.scale {
            Scale::Linear => difference,
            Scale::Log => exp(difference),
        }
    }

    /// From standard deviations above what is expected of a cost to those above what is expected of the response.
    pub(crate) fn of_deviations(&self, deviations: f64) -> f64 {
        match self.goal {
            Goal::Minimize => deviations,
            Goal::Maximize => -deviations,
        }
    }

    /// From a difference, or a factor, to a difference of costs.
    pub(crate) fn difference(&self, given: f64) -> f64 {
        self.scaled(given)
    }

    /// The unit of differences; a factor has none.
    pub(crate) fn unit_of_differences(&self) -> &str {
        match self.scale {
            Scale::Linear => &self.unit,
            Scale::Log => "1",
        }
    }

    /// No difference at all.
    pub(crate) fn no_difference(&self) -> f64 {
        self.of_difference(0.0)
    }

    /// By how much one value is more than another, or how many times as large.
    pub(crate) fn less(&self, value: f64, other: f64) -> f64 {
        match self.scale {
            Scale::Linear => value - other,
            Scale::Log => value / other,
        }
    }

    /// "measured less expected", or by what the one is divided.
    pub(crate) fn less_in_words(&self, other: &str) -> String {
        match self.scale {
            Scale::Linear => format!("measured less {other}"),
            Scale::Log => format!("measured, divided by {other}"),
        }
    }

    /// The value that differs from another by as much as `value` does from `from`.
    pub(crate) fn moved(&self, to: f64, value: f64, from: f64) -> f64 {
        match self.scale {
            Scale::Linear => to + value - from,
            Scale::Log => to * (value / from),
        }
    }

    /// Both ends of a band about a value, the lower one first; its half width is a difference of costs.
    pub(crate) fn band(&self, value: f64, half: f64) -> (f64, f64) {
        match self.scale {
            Scale::Linear => (value - half, value + half),
            Scale::Log => (value * exp(-half), value * exp(half)),
        }
    }

    /// What stands above a column of half widths.
    pub(crate) fn band_heading(&self) -> &'static str {
        match self.scale {
            Scale::Linear => "± (90 %)",
            Scale::Log => "times or divided by (90 %)",
        }
    }

    /// A computed cost as people read it, known to about `resolution`, a difference of costs; without its unit.
    pub(crate) fn number_to(&self, cost: f64, resolution: f64) -> String {
        let value = self.of_cost(cost);
        match self.scale {
            Scale::Linear => resolved(value, resolution),
            Scale::Log => resolved(value, value * resolution.exp_m1()),
        }
    }

    /// A computed cost as people read it, with its unit.
    pub(crate) fn value(&self, cost: f64) -> String {
        with_unit(&short(self.of_cost(cost)), &self.unit)
    }

    /// The same, known to about `resolution`.
    pub(crate) fn value_to(&self, cost: f64, resolution: f64) -> String {
        with_unit(&self.number_to(cost, resolution), &self.unit)
    }

    /// What can be gained, in words if it is nothing.
    pub(crate) fn gain(&self, mean: f64) -> String {
        if mean > 0.0 { self.amount(mean) } else { "practically nothing".to_owned() }
    }

    /// A difference of costs as people read it: "0.3 mm", or "a factor of 1.2".
    pub(crate) fn amount(&self, difference: f64) -> String {
        match self.scale {
            Scale::Linear => with_unit(&short(difference), &self.unit),
            Scale::Log => format!("a factor of {}", self.factor(difference)),
        }
    }

    /// The same of one that was said before: "the 0.3 mm", or "the factor of 1.2".
    pub(crate) fn the_amount(&self, difference: f64) -> String {
        match self.scale {
            Scale::Linear => format!("the {}", self.amount(difference)),
            Scale::Log => format!("the factor of {}", self.factor(difference)),
        }
    }

    /// A difference, or a factor, as it stands in the file.
    pub(crate) fn given(&self, given: f64) -> String {
        match self.scale {
            Scale::Linear => with_unit(&plain(given), &self.unit),
            Scale::Log => format!("a factor of {}", plain(given)),
        }
    }

    /// With as many digits as tell it from 1.
    fn factor(&self, difference: f64) -> String {
        resolved(self.of_difference(difference), difference.abs().exp_m1() / 10.0)
    }

    /// What a narrow region is called where the response is far better than around it.
    pub(crate) fn well(&self) -> &'static str {
        match self.goal {
            Goal::Minimize => "well",
            Goal::Maximize => "peak",
        }
    }

    /// The heading of its column in a sheet.
    pub(crate) fn heading(&self) -> String {
        heading(&self.name, &self.unit)
    }

    /// What is allowed, unless this is.
    pub(crate) fn fault(&self, value: f64) -> Option<String> {
        if let Some(expected) = self.without_logarithm(value) {
            return Some(expected);
        }
        let at_least = self.lower.filter(|&lower| value < lower).map(|lower| ("at least", lower));
        let at_most = self.upper.filter(|&upper| value > upper).map(|upper| ("at most", upper));
        let (word, bound) = at_least.or(at_most)?;
        Some(format!("{word} {}, the bound of the response in {PROBLEM}", with_unit(&plain(bound), &self.unit)))
    }

    /// What is allowed by the scale, unless this is.
    pub(crate) fn without_logarithm(&self, value: f64) -> Option<String> {
        match value {
            _ if self.scale.is_linear() => None,
            value if value <= 0.0 => Some("above 0 on a log scale".to_owned()),
            value if !(SMALLEST..=LARGEST).contains(&value) => Some("1e-100 to 1e100 on a log scale".to_owned()),
            _ => None,
        }
    }

    /// The least cost that there can be.
    pub(crate) fn least(&self) -> Option<f64> {
        let best = match self.goal {
            Goal::Minimize => self.lower,
            Goal::Maximize => self.upper,
        };
        best.filter(|&best| self.without_logarithm(best).is_none()).map(|best| self.cost(best))
    }

    /// "lower" or "higher", whichever is better.
    pub(crate) fn better(&self) -> &'static str {
        match self.goal {
            Goal::Minimize => "lower",
            Goal::Maximize => "higher",
        }
    }

    /// "down" or "up", whichever is better.
    pub(crate) fn better_way(&self) -> &'static str {
        match self.goal {
            Goal::Minimize => "down",
            Goal::Maximize => "up",
        }
    }

    /// "above" or "below", where what is worse lies.
    pub(crate) fn worse_side(&self) -> &'static str {
        self.side(1.0)
    }

    /// On which side of another a response is whose cost is so much more.
    pub(crate) fn side(&self, more: f64) -> &'static str {
        match (self.goal, more < 0.0) {
            (Goal::Minimize, false) | (Goal::Maximize, true) => "above",
            (Goal::Minimize, true) | (Goal::Maximize, false) => "below",
        }
    }
}

/// `name [unit]`, or the name alone.
pub(crate) fn heading(name: &str, unit: &str) -> String {
    if unit.is_empty() { name.to_owned() } else { format!("{name} [{unit}]") }
}

/// Of what would be no number, about the largest.
fn exp(logarithm: f64) -> f64 {
    logarithm.clamp(-LARGEST_LOGARITHM, LARGEST_LOGARITHM).exp()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn response(goal: Goal, scale: Scale) -> Response {
        Response { name: "leak".into(), unit: "Pa l/s".into(), goal, scale, lower: None, upper: None }
    }

    #[test]
    fn values_come_back_from_their_costs() {
        for goal in [Goal::Minimize, Goal::Maximize] {
            for scale in [Scale::Linear, Scale::Log] {
                let response = response(goal, scale);
                for value in [7.3e-9, 0.1, 1.0, 42.0, 3e12] {
                    let back = response.of_cost(response.cost(value));
                    assert!(back.total_cmp(&value).is_eq(), "{value} is {back}");
                }
                let is_lower_better = response.cost(1.0) < response.cost(2.0);
                assert_eq!(is_lower_better, goal == Goal::Minimize);
            }
        }
    }

    #[test]
    fn ten_times_as_much_is_as_far_everywhere() {
        let response = response(Goal::Maximize, Scale::Log);
        let far = |value: f64| response.cost(value) - response.cost(10.0 * value);
        assert!((far(1e-8) - far(1e3)).abs() < 1e-12 && (response.of_difference(far(2.0)) - 10.0).abs() < 1e-12);
        let (low, high) = response.band(20.0, response.difference(2.0));
        assert!((low - 10.0).abs() < 1e-12 && (high - 40.0).abs() < 1e-12, "{low} {high}");
        assert!((response.moved(6.0, 20.0, 10.0) - 12.0).abs() < 1e-12);
    }

    #[test]
    fn factors_have_the_digits_that_tell_them_from_one() {
        let log = response(Goal::Minimize, Scale::Log);
        let said = [0.0, 2e-5_f64, 0.05, 1.0, 6.0].map(|difference| log.amount(difference));
        assert_eq!(
            said,
            ["a factor of 1", "a factor of 1.00002", "a factor of 1.051", "a factor of 2.718", "a factor of 403.4"]
        );
        assert_eq!(response(Goal::Minimize, Scale::Linear).the_amount(0.05), "the 0.05 Pa l/s");
    }

    #[test]
    fn what_has_no_logarithm_is_not_allowed() {
        let mut log = response(Goal::Minimize, Scale::Log);
        assert!(log.fault(0.0).is_some_and(|expected| expected.starts_with("above 0")) && log.fault(1e-9).is_none());
        assert!(log.fault(1e-101).is_some() && log.fault(1e-100).is_none() && log.of_difference(1e9).is_finite());
        for extreme in [1e-100, 1e100] {
            assert!((log.of_cost(log.cost(extreme)) / extreme - 1.0).abs() < 1e-11, "{extreme}");
        }
        log.lower = Some(0.0);
        assert_eq!(log.least(), None, "there is no least logarithm");
        log.lower = Some(1.0);
        assert_eq!(log.least(), Some(0.0));
    }
}
