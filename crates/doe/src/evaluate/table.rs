//! An evaluation as text.

use std::fmt;

use super::{Correlations, Evaluation, Precision};
use crate::wording::counted;

impl fmt::Display for Evaluation {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.warn(formatter)?;
        let runs = counted(self.n_runs as u64, "run", "runs");
        let terms = counted(self.terms.len() as u64, "term", "terms");
        writeln!(formatter, "{runs}, {terms} of {}, predictions over the {}", self.factors.join(", "), self.over)?;
        let freedom = self.degrees_of_freedom;
        writeln!(
            formatter,
            "degrees of freedom: {} model, {} lack of fit, {} pure error",
            freedom.model, freedom.lack_of_fit, freedom.pure_error
        )?;
        for group in self.replicates.iter().take(MOST_SHOWN) {
            writeln!(formatter, "replicates: runs {}", numbers(group))?;
        }
        if let Some(more @ 1..) = self.replicates.len().checked_sub(MOST_SHOWN) {
            writeln!(formatter, "replicates: at {} besides", counted(more as u64, "point", "points"))?;
        }
        if let Some(precision) = &self.precision {
            precision.write(formatter)?;
        } else {
            writeln!(formatter, "\nthe runs do not determine the model:")?;
            for alias in &self.aliases {
                writeln!(formatter, "  {alias}")?;
            }
        }
        self.correlations.write(formatter)
    }
}

impl Evaluation {
    /// What is likely to be a mistake comes first.
    fn warn(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let elsewhere: Vec<usize> = self.outside.iter().copied().filter(|run| !self.forbidden.contains(run)).collect();
        for (runs, verbs, what) in [
            (&self.forbidden, ["lies", "lie"], "in a forbidden box"),
            (&elsewhere, ["is", "are"], "not in the space: outside the bounds, or off the levels or the list"),
        ] {
            if let Some(verb) = verbs.get(runs.len().min(2).wrapping_sub(1)) {
                let noun = if runs.len() == 1 { "run" } else { "runs" };
                writeln!(formatter, "WARNING: {noun} {} {verb} {what}", numbers(runs))?;
            }
        }
        Ok(())
    }
}

impl Precision {
    fn write(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(formatter, "\nefficiencies")?;
        for efficiency in &self.efficiencies {
            writeln!(formatter, "  {efficiency}")?;
        }
        let predictions = &self.predictions;
        writeln!(formatter, "\nprediction variance, for unit variance of a run (coded points)")?;
        writeln!(formatter, "  largest  {} at {}", places(predictions.maximum), point(&predictions.maximum_at))?;
        writeln!(formatter, "  mean     {}", places(predictions.mean))?;
        writeln!(formatter, "  smallest {} at {}", places(predictions.minimum), point(&predictions.minimum_at))?;
        let curve = &self.fraction_of_space;
        writeln!(formatter, "\nfraction of the space with at most this variance ({})", curve.sampling)?;
        for fraction in [0.1, 0.25, 0.5, 0.75, 0.9, 0.95, 1.0] {
            let variance = curve.variance_at(fraction).unwrap_or(f64::NAN);
            writeln!(formatter, "  {:3.0} % {}", 100.0 * fraction, places(variance))?;
        }
        let width = self.coefficients.iter().map(|row| row.term.chars().count()).max().unwrap_or(0).max(4);
        writeln!(formatter, "\n{:<width$}  standard error  variance inflation", "term")?;
        for row in &self.coefficients {
            let inflation = row.variance_inflation.map_or_else(|| "-".to_owned(), |value| format!("{value:.4}"));
            writeln!(formatter, "{:<width$}  {:>14}  {inflation:>18}", row.term, places(row.standard_error))?;
        }
        if self.leverages.len() > MOST_LEVERAGES {
            return self.write_extremes_of_leverage(formatter);
        }
        writeln!(formatter, "\nleverage")?;
        for (run, leverage) in self.leverages.iter().enumerate() {
            writeln!(formatter, "  run {:3}  {leverage:.4}", run + 1)?;
        }
        Ok(())
    }

    /// Instead of hundreds of lines.
    fn write_extremes_of_leverage(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let runs = || self.leverages.iter().copied().zip(1_usize..);
        let of = |extreme: Option<(f64, usize)>| extreme.unwrap_or((f64::NAN, 0));
        let (least, at_least) = of(runs().reduce(|a, b| if b.0 < a.0 { b } else { a }));
        let (most, at_most) = of(runs().reduce(|a, b| if b.0 > a.0 { b } else { a }));
        let mean = self.leverages.iter().sum::<f64>() / self.leverages.len() as f64;
        writeln!(
            formatter,
            "\nleverage: {least:.3e} (run {at_least}) to {most:.3e} (run {at_most}), {mean:.3e} in the mean"
        )
    }
}

impl Correlations {
    fn write(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.largest() {
            Some((first, second, value)) => writeln!(
                formatter,
                "\nlargest correlation of terms: {value:.4}, {} with {}",
                self.terms[first], self.terms[second]
            ),
            None => Ok(()),
        }
    }
}

/// Leverages that are told one by one.
const MOST_LEVERAGES: usize = 200;
/// Points with several runs, and runs of a kind, that are told one by one.
const MOST_SHOWN: usize = 50;

/// Four places, or four digits where these would show little.
fn places(value: f64) -> String {
    if value > 0.0 && value < 1e-3 { format!("{value:8.3e}") } else { format!("{value:8.4}") }
}

/// Runs as people count them, from one.
fn numbers(runs: &[usize]) -> String {
    let shown: Vec<String> = runs.iter().take(MOST_SHOWN).map(|run| (run + 1).to_string()).collect();
    let more = match runs.len().checked_sub(MOST_SHOWN) {
        Some(more @ 1..) => format!(" and {more} more"),
        _ => String::new(),
    };
    format!("{}{more}", shown.join(", "))
}

fn point(coordinates: &[f64]) -> String {
    // Adding zero turns −0 into 0.
    let texts: Vec<String> =
        coordinates.iter().map(|x| format!("{:.3}", (x * 1000.0).round() / 1000.0 + 0.0)).collect();
    format!("({})", texts.join(", "))
}
