//! Where a design predicts badly, and why: pictures of an evaluation, with their captions.

use super::evaluation::{Correlations, Evaluation, Fractions, Parameter, Precision, Slice};
use page::{
    Axis, CellFigure, CellPanel, Landscape, LineFigure, Panel, Points, Series, cell_figure, landscape_figure,
    line_figure,
};

fn axis(parameter: &Parameter) -> Axis {
    Axis::new(&parameter.name, parameter.unit())
}

pub(super) fn plane(evaluation: &Evaluation, slice: &Slice) -> String {
    let [a, b] = slice.factors;
    let (first, second) = (&evaluation.parameters[a], &evaluation.parameters[b]);
    let mut point = slice.through.clone();
    let rows = slice.levels.iter().zip(slice.variances.chunks(slice.levels.len()));
    let z = rows.map(|(y, row)| {
        let values = slice.levels.iter().zip(row).map(|(x, variance)| {
            (point[a], point[b]) = (*x, *y);
            if evaluation.forbids(&point) { f64::NAN } else { *variance }
        });
        values.collect()
    });
    let z: Vec<Vec<f64>> = z.collect();
    // The whole range: where a design predicts worst is what the picture is for.
    let finite = || z.iter().flatten().copied().filter(|value| value.is_finite());
    let (lowest, highest) = (finite().fold(f64::INFINITY, f64::min), finite().fold(0.0, f64::max));
    let z_axis = Axis::new("prediction variance / variance of a run", "1");
    let z_axis = if lowest < highest { z_axis.with_range(lowest, highest) } else { z_axis };
    let repeated: Vec<usize> = evaluation.replicates.iter().flatten().copied().collect();
    let points = |label: &str, wants_repeated: bool, fill: &'static str, radius_px: f64| {
        let chosen = evaluation.runs.iter().enumerate().filter(|(run, _)| repeated.contains(run) == wants_repeated);
        let points = chosen.map(|(_, run)| (first.natural(run[a]), second.natural(run[b]))).collect();
        Points { label: label.to_owned(), points, fill, radius_px }
    };
    let mut points = vec![points("run", false, "#ffffff", 5.0), points("runs at one point", true, "#e69f00", 7.0)];
    points.retain(|points| !points.points.is_empty());
    landscape_figure(&Landscape {
        title: "Prediction variance".to_owned(),
        x_axis: axis(first),
        y_axis: axis(second),
        z_axis,
        x: slice.levels.iter().map(|x| first.natural(*x)).collect(),
        y: slice.levels.iter().map(|y| second.natural(*y)).collect(),
        z,
        missing_label: "forbidden".to_owned(),
        points,
        verticals: Vec::new(),
        verticals_label: String::new(),
        paths: Vec::new(),
        minimum: None,
        minimum_label: String::new(),
    })
}

pub(super) fn plane_caption(evaluation: &Evaluation, slice: &Slice) -> String {
    let held: Vec<String> = (0..evaluation.parameters.len())
        .filter(|factor| !slice.factors.contains(factor))
        .map(|factor| {
            let parameter = &evaluation.parameters[factor];
            format!("{} at {} {}", parameter.name, parameter.text(slice.through[factor]), parameter.unit)
        })
        .collect();
    let caption = "How well the design predicts where";
    match held.as_slice() {
        [] => format!("{caption}, and its runs."),
        held => format!("{caption}, on the plane with {}, and all runs seen from above.", held.join(", ")),
    }
}

pub(super) fn fractions(precision: &Precision) -> String {
    let Fractions { fractions, variances } = &precision.fraction_of_space;
    let shares: Vec<f64> = fractions.iter().map(|fraction| 100.0 * fraction).collect();
    let series = vec![
        Series::line("variance not exceeded", &shares, variances),
        Series::line("mean", &[0.0, 100.0], &[precision.predictions.mean; 2]).dashed(),
    ];
    line_figure(&LineFigure {
        title: "How much of the space is predicted how well".to_owned(),
        x_axis: Axis::new("share of the space", "%"),
        panels: vec![Panel { x_axis: None, y_axis: Axis::new("prediction variance", "1"), series }],
        shaded: None,
    })
}

pub(super) fn leverages(precision: &Precision) -> String {
    let inflations: Vec<f64> = precision.coefficients.iter().filter_map(|row| row.variance_inflation).collect();
    let panel = |axis: &str, quantity: &str, values: &[f64]| {
        let numbers: Vec<f64> = (1..=values.len()).map(|number| number as f64).collect();
        Panel {
            x_axis: Some(Axis::new(axis, "1").counting_to(values.len())),
            y_axis: Axis::new(quantity, "1"),
            series: vec![Series::line(quantity, &numbers, values)],
        }
    };
    let mut panels = vec![panel("run", "leverage", &precision.leverages)];
    if !inflations.is_empty() {
        panels.push(panel("term", "variance inflation", &inflations));
    }
    let title = "Leverage of the runs, inflation of the terms".to_owned();
    line_figure(&LineFigure { title, x_axis: Axis::new("", "1"), panels, shaded: None })
}

pub(super) fn correlations(correlations: &Correlations) -> String {
    let n = correlations.terms.len();
    let numbers: Vec<f64> = (1..=n).map(|number| number as f64).collect();
    let values: Vec<f64> = correlations.values.iter().map(|value| value.map_or(f64::NAN, f64::abs)).collect();
    let axis = || Axis::new("term", "1").counting_to(n);
    cell_figure(&CellFigure {
        title: "Correlation of the terms over the runs".to_owned(),
        x_axis: axis(),
        y_axis: axis(),
        z_axis: Axis::new("magnitude of the correlation", "1").with_range(0.0, 1.0),
        panels: vec![CellPanel {
            title: String::new(),
            x: numbers.clone(),
            y: numbers,
            z: values.chunks(n).map(<[f64]>::to_vec).collect(),
            points: Vec::new(),
            minimum: None,
        }],
        missing_label: "a term does not vary over the runs".to_owned(),
        minimum_label: String::new(),
    })
}

pub(super) fn correlations_caption(correlations: &Correlations) -> String {
    let numbered = correlations.terms.iter().enumerate().map(|(index, term)| format!("{} {term}", index + 1));
    let numbered: Vec<String> = numbered.collect();
    let n = correlations.terms.len();
    let pairs = (0..n).flat_map(|i| (i + 1..n).map(move |j| (i, j)));
    let valued = pairs.filter_map(|(i, j)| correlations.values[i * n + j].map(|value| (i, j, value)));
    let largest = valued.reduce(|a, b| if b.2.abs() > a.2.abs() { b } else { a });
    let largest = largest.map_or_else(String::new, |(i, j, value)| {
        format!(" The largest is {value:.4}, of {} and {}.", correlations.terms[i], correlations.terms[j])
    });
    format!("Terms that the runs tell apart badly are correlated.{largest} The terms: {}.", numbered.join("; "))
}
