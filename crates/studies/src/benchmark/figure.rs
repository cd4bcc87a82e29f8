//! Regret against batches of experiments.

use page::{Axis, LineFigure, Panel, Series, line_figure};

/// Numbers of parameters of the families that are drawn, a panel for each.
pub(super) const PICTURED: [usize; 2] = [2, 4];

/// A method in words, and its regret after each batch, in percent of the range.
pub(super) type Curve<'a> = (&'a str, Vec<f64>);

/// Panels of curves, each with what is said of its regret; the first curve of a panel is drawn through, the others are dashed.
pub(super) struct Regrets<'a> {
    pub(super) title: &'a str,
    pub(super) panels: Vec<(String, Vec<Curve<'a>>)>,
    /// Whether all panels have one scale.
    pub(super) is_one_scale: bool,
}

impl Regrets<'_> {
    pub(super) fn picture(&self) -> String {
        let n_batches =
            self.panels.iter().flat_map(|(_, curves)| curves).map(|(_, curve)| curve.len()).max().unwrap_or(1);
        let batches: Vec<f64> = (1..=n_batches).map(|batch| batch as f64).collect();
        let x_axis = || Axis::new("batches of experiments", "1").counting_to(n_batches);
        // With room for the dots.
        let heights = |curves: &[Curve<'_>]| -> Vec<f64> {
            curves.iter().flat_map(|(_, curve)| curve).flat_map(|value| [0.85 * value, 1.18 * value]).collect()
        };
        let of_all: Vec<f64> = self.panels.iter().flat_map(|(_, curves)| heights(curves)).collect();
        let panel = |(words, curves): &(String, Vec<Curve<'_>>)| {
            let heights = if self.is_one_scale { of_all.clone() } else { heights(curves) };
            let series = curves.iter().enumerate().map(|(place, (words, curve))| {
                let line = Series::line(words, &batches, curve);
                if place == 0 { line } else { line.dashed() }
            });
            Panel {
                x_axis: Some(x_axis()),
                y_axis: Axis::new(words, "% of range").in_ratios(heights),
                series: series.collect(),
            }
        };
        line_figure(&LineFigure {
            title: self.title.to_owned(),
            x_axis: x_axis(),
            panels: self.panels.iter().map(panel).collect(),
            shaded: None,
        })
    }
}
